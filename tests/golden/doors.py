"""The one file of the net that calls the package: after a change of public names, this file follows and no other.

What goes in and comes out here is plain: numbers, arrays, and names that ``renamed.py`` may map.
"""

from __future__ import annotations

import csv
import json
import re
import time
import warnings
from collections.abc import Callable, Iterator, Mapping
from contextlib import suppress
from dataclasses import fields, is_dataclass
from pathlib import Path
from typing import Any

import numpy as np

import springpot as sp
from springpot import theory
from springpot.evidence.comparison import compare, observe
from springpot.paper.errata import ERRATA
from springpot.studies.export import export
from springpot.studies.question import read_study
from springpot.studies.running import run_study
from springpot.studies.store import open_store

Named = Iterator[tuple[str, object]]

REFUSALS = (TypeError, ValueError, ArithmeticError)


def refusal(error: BaseException) -> str:
    """The nearest class of Python's own, whatever the package calls its errors."""
    return next(kind.__name__ for kind in type(error).__mro__ if kind.__module__ == "builtins")


# --- problems ---------------------------------------------------------------------------------------------------------

free = sp.free
mass, spring, polynomial_spring = sp.Mass, sp.Spring, sp.PolynomialSpring
springpot, series, maxwell, circuit = sp.Springpot, sp.FractionalMaxwell, sp.Maxwell, sp.PiezoelectricCircuit
dashpot, polynomial_dashpot, van_der_pol, friction = sp.Dashpot, sp.PolynomialDashpot, sp.VanDerPol, sp.Friction
power_restitution, force, constant, recorded = sp.PowerRestitution, sp.Force, sp.Constant, sp.RecordedExcitation
white_noise, coloured_noise, filtered_noise = sp.WhiteNoise, sp.ColoredNoise, sp.KanaiTajimiNoise
thermal_noise, parametric_noise = sp.ThermalNoise, sp.ParametricNoise
poisson_impulses, harmonic = sp.PoissonImpulses, sp.Harmonic


def wall(position: Any, restitution: Any = 1.0, free_side: str = "above") -> Any:
    """A rigid wall; the mass moves on the side that is named."""
    return sp.Barrier(position, restitution, free_side=free_side)  # type: ignore[arg-type]


def contact(
    position: float, stiffness: float, exponent: float = 1.5, dissipation: float = 0.0, free_side: str = "above"
) -> Any:
    return sp.Contact(position, stiffness, exponent, dissipation, free_side)  # type: ignore[arg-type]


def system(*parts: Any) -> Any:
    """One mass with these parts, in this order, with the names that they get by themselves."""
    return sp.System(*parts)


def is_spring(part: Any) -> bool:
    return isinstance(part, sp.Spring | sp.PolynomialSpring)


def oscillator(frequency: Any, order: Any, coefficient: Any, intensity: Any, wall: Any = None) -> Any:
    """The paper's problem; ``wall`` is one made above."""
    return sp.Oscillator(
        natural_frequency=frequency,
        springpot=sp.Springpot(order, coefficient),
        barrier=wall,
        excitation=sp.WhiteNoise(intensity),
    )


# --- numbers of a result ----------------------------------------------------------------------------------------------


def numbers_of(found: object) -> Named:
    """A result's numbers, however it is nested; sentences and times are no numbers."""
    if isinstance(found, Mapping):
        for name, part in found.items():
            for rest, value in numbers_of(part):
                yield f"/{name}{rest}", value
    elif is_dataclass(found):
        for field in fields(found):
            for rest, value in numbers_of(getattr(found, field.name)):
                yield f"/{field.name}{rest}", value
    elif isinstance(found, np.ndarray):
        if found.dtype.kind in "fiucb":
            yield "", found
    elif isinstance(found, bool | int | float | np.number):
        yield "", float(found)
    elif isinstance(found, tuple | list):
        for number, part in enumerate(found):
            for rest, value in numbers_of(part):
                yield f"/{number}{rest}", value


def _some(found: object, *names: str) -> Named:
    """The numbers of some attributes of a result."""
    for name in names:
        for rest, value in numbers_of(getattr(found, name)):
            yield f"{name}{rest}", value


def _of_a_dataset(found: Any) -> Named:
    for name in sorted([*found.data_vars, *found.coords]):
        values = np.asarray(found[name])
        if values.dtype.kind in "fiu":
            yield str(name), values if values.ndim else float(values)


# --- Monte Carlo ------------------------------------------------------------------------------------------------------

SETTINGS = ("paths", "duration", "step", "window", "initial_position", "initial_velocity", "record", "record_every")
DIAGNOSTICS = ("pairs", "path_steps", "reached", "collapses")


def _of_a_run(found: Any) -> Named:
    """All numbers of the dataset of a run, the settings that it was made with, and how many warnings it has."""
    yield from _of_a_dataset(found)
    settings, diagnostics = (json.loads(found.attrs[name]) for name in ("settings", "diagnostics"))
    for whole, names in ((settings, SETTINGS), (diagnostics, DIAGNOSTICS)):
        for name in names:
            for rest, value in numbers_of(whole.get(name)):
                yield f"settings/{name}{rest}", value
    yield "warnings", float(len(found.attrs["warnings"]))


def simulated(problem: Any, **given: Any) -> Named:
    yield from _of_a_run(run(problem, **given).to_xarray())


def values_and_errors(problem: Any, **given: Any) -> dict[str, tuple[float, float]]:
    return {name: (own.value, own.error) for name, own in run(problem, **given).estimates.items()}


def observed(problem: Any) -> Named:
    """The run for pictures."""
    yield from _of_a_run(observe(problem).to_xarray())


def run(problem: Any, **given: Any) -> Any:
    """A run to be saved and extended."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        return sp.simulate(problem, **given)


def loaded(found: Any, place: Path) -> Any:
    """A run through a file."""
    return sp.load_run(found.save(place, path_sums=True))


def extended(found: Any, **to: Any) -> Any:
    return sp.extend(found, **to)


def of_run(found: Any) -> Named:
    yield from _of_a_run(found.to_xarray())


def table_of_run(found: Any, place: Path) -> Named:
    """The columns of its table."""
    yield from _columns(found.save(place))


def _columns(table: Path) -> Named:
    with table.open(newline="", encoding="utf-8") as file:
        rows = list(csv.DictReader(row for row in file if not row.startswith("#")))
    for name in rows[0]:
        cells = [row[name] for row in rows]
        try:
            yield name, np.array([float(cell or "nan") for cell in cells])
        except ValueError:
            continue  # words


# --- theory -----------------------------------------------------------------------------------------------------------

SIZES = np.linspace(0.1, 4.0, 9)
BOTH = np.linspace(-2.0, 2.0, 9)
CURVES: dict[str, Callable[[float, float, float, float], tuple[Any, ...]]] = {
    # of the position of the wall, root mean squares of x and v, and their ratio, which is a time
    "x_density": lambda at, x, v, t: (at + BOTH * x,),
    "v_density": lambda at, x, v, t: (BOTH * v,),
    "joint_density": lambda at, x, v, t: (at + BOTH * x, BOTH * v),
    "amplitude_density": lambda at, x, v, t: (SIZES * x,),
    "energy_density": lambda at, x, v, t: (0.5 * (SIZES * v) ** 2,),
    "impact_speed_density": lambda at, x, v, t: (0.75 * SIZES * v,),
    "correlation": lambda at, x, v, t: (3.0 * SIZES * t,),
    "spectrum": lambda at, x, v, t: (SIZES / t,),
    "frequency_response": lambda at, x, v, t: (SIZES / t,),
    "mean_square": lambda at, x, v, t: (SIZES * t,),
    "amplitude_mean_square_at": lambda at, x, v, t: (SIZES * t,),
    "x_mean_at": lambda at, x, v, t: (SIZES * t,),
    "x_mean_square_at": lambda at, x, v, t: (SIZES * t,),
    "v_mean_square_at": lambda at, x, v, t: (SIZES * t,),
    "drift": lambda at, x, v, t: (SIZES * x,),
    "frequency": lambda at, x, v, t: (SIZES * x,),
    "damping": lambda at, x, v, t: (SIZES * x,),
}
"""Methods of the results of theory, and what they are asked."""
IN_TIME = ("x_density", "v_density", "amplitude_density", "impact_speed_density")


def answers(problem: Any) -> tuple[dict[str, Any], list[str]]:
    """The results of all methods by name, and the names of those without one."""
    found, statements = theory.solve_all(problem)
    return dict(found), sorted(statements)


def of_answer(found: Any) -> Named:
    words = found.to_dict()
    for rest, value in numbers_of({name: part for name, part in words.items() if name not in ("warnings",)}):
        yield rest.removeprefix("/"), value
    yield "warnings", float(len(words["warnings"]))


def curves_of(found: Any, place: float) -> Named:
    """All its curves, at places in units of the problem."""
    x, v = (max(float(square), 1e-12) ** 0.5 for square in (found.x_mean_square, found.v_mean_square))
    for name, ask in CURVES.items():
        own = getattr(type(found), name, None)
        if not callable(own):
            continue
        asked = {name: ask(place, x, v, x / v)}
        if name in IN_TIME:
            asked[f"{name}_in_time"] = (*asked[name], x / v)
        if name == "impact_speed_density" and isinstance(found, theory.HalfCycles):
            walls = [wall for wall, part in found.system.named() if isinstance(part, sp.Barrier | sp.Contact)]
            asked = {f"{name}/{number}": (*asked[name], wall) for number, wall in enumerate(walls)}
        for kind, arguments in asked.items():
            with suppress(*REFUSALS):  # not of this result, or not in time
                yield kind, np.asarray(getattr(found, name)(*arguments))


def trusted(problem: Any, found: Mapping[str, Any]) -> Named:
    """Which method is recommended, the best guess, and what the validity map says of each."""
    best = sp.recommended(problem, found)
    yield "recommended", str(best.method)
    yield "best_guess", str(best.guess)
    for method in found:
        try:
            own = sp.trust(problem, method)
        except ValueError:
            continue  # a method that is not on the map
        for rest, value in numbers_of(own.gaps):
            yield f"{method}/gaps{rest}", value
        yield f"{method}/unjudged", float(len(own.unjudged))
        for name in ("mapped", "judges", "largest", "worst"):
            yield f"{method}/{name}", float(getattr(own, name))


def in_words(problem: Any) -> Named:
    """The numbers in the explanation, in their order."""
    text = re.sub(r"[A-Za-z_]\w*", " ", sp.explain(problem))
    yield "numbers", np.array([float(number) for number in re.findall(r"(?<![\w.])\d+(?:\.\d+)?(?:e[+-]?\d+)?", text)])


def of_atlas(problem: Any) -> Named:
    try:
        found = sp.atlas(problem)
    except REFUSALS:
        return
    for name, value in found.to_dict().items():
        if isinstance(value, bool | int | float):
            yield name, float(value)


def compared(problem: Any, **given: Any) -> Named:
    found = compare(problem, **given)
    yield "recommended", found.recommended
    for name in found.moments:
        yield f"simulation/{name}", found.simulation[name].value
        yield f"simulation/{name}_se", found.simulation[name].error
    for method in found.answers:
        for rest, value in numbers_of(found.gaps(method)):
            yield f"{method}{rest}", value


def errata() -> Named:
    """The numbers of the slips in the print."""
    for erratum in ERRATA:
        for number, finding in enumerate(erratum.check()):
            for rest, value in numbers_of(finding):
                yield f"{erratum.number}/{number}{rest}", value


def through_a_file(problem: Any, place: Path) -> Any:
    """A system written as TOML and read again."""
    place.write_text(sp.to_toml(problem), encoding="utf-8")
    return sp.read_system(place)


# --- sensitivities, designs, fits -------------------------------------------------------------------------------------


def sensitivity(problem: Any, quantities: list[str], **given: Any) -> Named:
    found = sp.sensitivity(problem, quantities, **given)
    yield "method", found.method
    yield from _some(found, "numbers", "quantities", "values", "errors", "gains")
    yield "warnings", float(len(found.warnings))


def design(problem: Any, minimized: Any, limits: dict[str, tuple[float | None, float | None]], **given: Any) -> Named:
    found = sp.design(problem, minimized, limits, **given)
    yield "method", found.method
    yield from _some(found, "values", "quantities", "errors", "cost", "cost_error", "margin", "promises", "history")
    yield "warnings", float(len(found.warnings))


moduli, spectrum, record = sp.MeasuredModuli, sp.MeasuredSpectrum, sp.MeasuredRecord
frequency_response, impacts, statistics = sp.MeasuredFrequencyResponse, sp.MeasuredImpacts, sp.MeasuredStatistics


def fit(model: Any, data: Any = None, **given: Any) -> Named:
    found = sp.fit(model, data, **given)
    yield from _some(found, "values", "errors", "extras", "covariance", "correlations", "deviance", "bic", "aicc")
    for rest, value in numbers_of([(choice.numbers, choice.bic, choice.aicc) for choice in found.choices]):
        yield f"choices{rest}", value
    yield "residuals", np.asarray(found.residuals)
    yield "probabilities", np.array([*found.check().probabilities.values()])


# --- studies ----------------------------------------------------------------------------------------------------------

_STUDY: dict[str, Any] = {
    "name": "golden",
    "seed": 7,
    "methods": ["averaging", "envelope", "memory_closure", "monte_carlo"],
    "quantities": ["amplitude_mean_square", "impact_rate"],
    "axes": {"order": [0.4, 1.0], "restitution": [1.0, 0.7]},
}
_DEVICE = [
    {"kind": "mass", "value": 0.5},
    {"kind": "spring", "stiffness": 2.0},
    {"kind": "polynomial_spring", "coefficients": [0.0, 0.0, 0.1]},
    {"kind": "springpot", "order": 0.5, "coefficient": 0.2},
    {"kind": "barrier", "name": "stop", "position": -0.5, "restitution": 0.8, "free_side": "above"},
    {"kind": "white_noise", "intensity": 0.3},
]
_OF_SYSTEMS: dict[str, Any] = {
    "name": "golden systems",
    "seed": 7,
    "methods": ["envelope", "monte_carlo"],
    "quantities": ["x_mean_square", "impact_rate"],
    "system": {"parts": _DEVICE},
    "axes": {"parts.spring.stiffness": [1.0, 2.0], "parts.stop.restitution": [1.0, 0.7]},
    "monte_carlo": {"paths": 128, "duration": 20.0, "step": 0.02},
}
_UPPER = {"kind": "barrier", "name": "top", "position": 0.7, "restitution": 0.9, "free_side": "below"}
STUDIES: dict[str, dict[str, Any]] = {
    "plain": {**_STUDY, "monte_carlo": {"paths": 128, "duration": 20.0, "step": 0.02}},
    "rtol": {**_STUDY, "monte_carlo": {"rtol": 0.1}},
    "grunwald": {
        **_STUDY,
        "methods": ["exact", "monte_carlo"],
        "axes": {"order": [0.5, 1.0], "position": [-0.3, 0.2]},
        "monte_carlo": {"paths": 20, "duration": 5.0, "step": 0.005, "scheme": "grunwald", "start": "rest"},
    },
    "theory": {
        **_STUDY,
        "methods": ["averaging_printed", "averaging", "averaging_amplitude", "envelope", "memory_closure", "exact"],
        "fixed": {"free_side": "below", "natural_frequency": 2.0},
        "axes": {"order": [0.3, 1.0], "coefficient": [0.1, 1.0], "position": [0.4, -0.2], "restitution": [1.0, 0.8]},
    },
    "systems": _OF_SYSTEMS,
    "systems_rtol": {**_OF_SYSTEMS, "monte_carlo": {"rtol": 0.1}},
    "two_walls": {
        **_OF_SYSTEMS,
        "methods": ["averaging_amplitude", "linearization", "envelope", "half_cycles", "monte_carlo"],
        "system": {"parts": [*_DEVICE, _UPPER]},
        "axes": {"parts.polynomial_spring.coefficients.3": [0.0, 0.4], "parts.top.position": [0.7, 1.5]},
    },
    "devices": {
        **_OF_SYSTEMS,
        "methods": ["averaging", "memory_closure", "envelope", "monte_carlo"],
        "system": {"parts": [part for part in _DEVICE if part["kind"] != "polynomial_spring"]},
    },
}
"""Studies in the words of a study file."""


def study(given: dict[str, Any], folder: Path) -> Named:
    """A study run to its end: all numbers of its labelled data, and the columns of its table."""
    run_study(read_study(given), folder / "golden.zarr")
    tree = sp.open_study(folder / "golden.zarr")
    for room in ("theory", "simulation"):
        if room in tree:
            for name, value in _of_a_dataset(tree[room].to_dataset()):
                yield f"{room}/{name}", value
    for name, value in _columns(export(open_store(folder / "golden.zarr"), folder / "golden.csv")):
        yield f"table/{name}", value


# --- the page ---------------------------------------------------------------------------------------------------------

SHOWN: dict[str, dict[str, Any]] = {
    "lossy": {
        "numbers": {
            "springpot-order": 0.6, "springpot-coefficient": 0.4, "barrier-restitution": 0.8, "barrier-position": -0.3,
        }
    },
    "open": {"without": ["barrier"]},
    "elastic": {"numbers": {"springpot-order": 1.0, "springpot-coefficient": 0.5}},
}  # fmt: skip


def page(problem: dict[str, Any]) -> Named:
    """What the page is sent: tables, curves and histograms when all is there."""
    from tests.explorer.conftest import running
    from tests.explorer.talk import tab

    last: dict[str, Any] = {}
    with running() as server, tab(server) as one:
        one.say(kind="problem", generation=7, paths=640, seed=3, **problem)
        end = time.monotonic() + 120.0
        while not ({"theory", "2", "3"} <= last.keys() and last.get("estimates", {}).get("complete")):
            assert time.monotonic() < end
            kind, content = one.hear()
            if kind == "estimates" and content["complete"]:  # the frames of all paths come after it
                last.pop("2", None), last.pop("3", None)
            last[kind] = content[1] if kind.isdigit() else content
    for kind in ("theory", "estimates", "2", "3"):
        for rest, value in numbers_of(last.get(kind, {})):
            if "seconds" not in rest and "generation" not in rest:
                yield f"{kind}{rest}", value
