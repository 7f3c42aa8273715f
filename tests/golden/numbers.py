"""Every kind of number the program gives, by name, through its public functions only (`doors.py`).

Names are paths such as ``runs/lossy/plain/x_mean``: kind, case, and the rest.  A number stands for itself, an array
for its shape and a digest of its bytes.
"""

from __future__ import annotations

import hashlib
import tempfile
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from tests.golden import doors
from tests.golden.systems import CHOSEN, FUNCTIONS, system

__all__ = ["FEW", "KINDS", "Case", "digested", "few", "papers"]

Named = Iterator[tuple[str, object]]
Case = tuple[str, Callable[[], Named]]
"""A name without a slash, and what gives the numbers; none of them knows of another."""


def _each(*ways: tuple[str, Callable[[], Named]]) -> Named:
    """The numbers of each way under its name, or that it is refused."""
    for name, numbers in ways:
        try:
            for rest, value in numbers():
                yield f"{name}/{rest}", value
        except doors.REFUSALS as error:
            yield f"{name}/refused", doors.refusal(error)


# --- the paper's oscillators ------------------------------------------------------------------------------------------


@dataclass(frozen=True)
class Paper:
    """The numbers of one of the paper's oscillators, apart from the program."""

    frequency: float = 1.0
    order: float = 0.5
    coefficient: float = 1.0
    intensity: float = 1.0
    wall: tuple[float, float, str] | None = (0.0, 1.0, "above")
    """Position, restitution, and the side on which the mass moves."""

    @property
    def problem(self) -> Any:
        wall = None if self.wall is None else doors.wall(*self.wall)
        return doors.oscillator(self.frequency, self.order, self.coefficient, self.intensity, wall)

    def device(self, mass: float, on: str) -> Any:
        """The same motion of a mass, shaken by a force or by the ground."""
        parts = [
            doors.mass(mass),
            doors.spring(mass * self.frequency**2),
            doors.springpot(self.order, mass * self.coefficient),
            *(() if self.wall is None else (doors.wall(*self.wall),)),
            doors.white_noise(self.intensity * (mass**2 if on == "mass" else 1.0), on),
        ]
        return doors.system(*parts)

    def in_its_units(self, given: dict[str, Any]) -> dict[str, Any]:
        """Settings for frequency 1, noise 1 and a wall at 0, for this one."""
        time = 1.0 / self.frequency
        size, wall, up = float(self.intensity * time**3) ** 0.5, 0.0, 1.0
        if self.wall is not None:
            wall, up = self.wall[0], {"above": 1.0, "below": -1.0}[self.wall[2]]
        scales = {"v": size / time, "speed": size / time, "amplitude": size, "energy": (size / time) ** 2}

        def scaled(name: str, value: Any) -> Any:
            match name:
                case "duration" | "step":
                    return value * time
                case "window":
                    return tuple(each * time for each in value)
                case "spectrum":
                    return [each / time for each in value]
                case "initial_position":
                    return wall + up * value * size
                case "initial_velocity" | "slowest_counted_impact":
                    return value * size / time
                case "first_passage":
                    levels = {kind: level * scales[kind] for kind, level in value.items() if kind in scales}
                    return {**levels, "x": wall + up * 0.8 * size}
            return value

        return {name: scaled(name, value) for name, value in given.items()}


def papers(count: int, seed: int = 12) -> list[Paper]:
    """Random ones: with and without a wall, above and below, gaps and preloads, orders 0 and 1 among them."""
    draw = np.random.default_rng(seed)
    found = []
    for number in range(count):
        order = [0.0, 1.0, *[float(draw.uniform(0.02, 0.99))] * 8][number % 10]
        frequency, intensity = (float(10.0 ** draw.uniform(-1.0, 1.0)) for _ in range(2))
        damping = float(10.0 ** draw.uniform(-2.0, 0.7))
        coefficient = damping * frequency ** (2.0 - order)
        spread = (intensity / (2.0 * damping * frequency**3)) ** 0.5 * 1.4
        place = [0.0, 0.0, float(draw.uniform(-2.0, 2.0)), float(draw.uniform(-0.5, 0.5))][number % 4] * spread
        restitution = [1.0, float(draw.uniform(0.3, 1.0)), float(draw.uniform(0.8, 1.0))][number % 3]
        wall = None if number % 9 == 5 else (place, restitution, ("above", "below")[number // 7 % 2])
        found.append(Paper(frequency, order, coefficient, intensity, wall))
    return found


PAPERS = {
    "elastic": Paper(order=0.5, coefficient=0.3),
    "lossy": Paper(2.0, 0.6, 0.4, 0.5, (-0.1, 0.8, "above")),
    "below": Paper(order=0.3, coefficient=0.7, wall=(0.4, 0.45, "below")),
    "open": Paper(order=0.7, coefficient=0.5, wall=None),
    "dashpot": Paper(order=1.0, coefficient=0.2, wall=(-0.5, 0.7, "above")),
    "spring": Paper(order=0.0, coefficient=0.2, wall=(0.0, 0.9, "above")),
}

SHORT: dict[str, Any] = {"paths": 300, "duration": 20.0, "step": 0.02, "seed": 5}
DISTANCE = {"level": 1.0, "reference": 0.1}
PASSAGE: dict[str, Any] = {"x": 0.3, "v": -1.0, "distance": DISTANCE, "speed": 1.5, "amplitude": 2.0, "energy": 1.0}
SETTINGS: dict[str, dict[str, Any]] = {
    "plain": {"paths": 200, "seed": 3},
    "rest": {**SHORT, "start": "rest"},
    "window": {**SHORT, "window": (5.0, 15.0), "initial_position": 0.3, "initial_velocity": -0.5},
    "double": {**SHORT, "memory_tolerance": 1e-9, "start": "rest"},
    "record": {**SHORT, "record": 70, "record_every": 7, "start": "rest"},
    "distributions": {**SHORT, "distributions": True, "start": "rest"},
    "spectrum": {**SHORT, "spectrum": [2.0, 4.0], "start": "rest"},
    "passage": {**SHORT, "first_passage": PASSAGE, "start": "rest"},
    "observables": {
        **SHORT,
        "start": "rest",
        "observables": {"work": lambda t, x, v: 0.1 * v * v + 0.0 * t * x},
        "impact_observables": {"lost": lambda speed: speed * speed},
    },
    "riemann": {**SHORT, "derivative": "riemann-liouville", "start": "rest", "initial_position": 1.0},
    "grunwald": {"paths": 20, "duration": 5.0, "step": 0.005, "scheme": "grunwald", "seed": 4, "start": "rest"},
    "counted": {**SHORT, "start": "rest", "slowest_counted_impact": 0.3},
    "together": {
        **SHORT,
        "start": "rest",
        "distributions": True,
        "spectrum": [2.0, 4.0],
        "first_passage": {"x": 0.3},
        "record": 3,
    },
}
TOLERANCES: dict[str, dict[str, Any]] = {
    "elastic": {"rtol": 0.02},
    "lossy": {"rtol": 0.03, "quantities": ("amplitude_mean_square", "impact_rate", "x_mean")},
    "below": {"rtol": 0.05, "quantities": ("amplitude_mean_square", "impact_speed_mean")},
    "open": {"rtol": 0.02},
    "dashpot": {"rtol": 0.03, "quantities": ("impact_rate",)},
}


def runs() -> Iterator[Case]:
    """Six oscillators, each in every way."""
    for name, paper in PAPERS.items():
        yield name, lambda paper=paper: _each(
            *((how, partial(doors.simulated, paper.problem, **given)) for how, given in SETTINGS.items()),
            ("observe", partial(doors.observed, paper.problem)),
        )  # fmt: skip


def runs_to_a_tolerance() -> Iterator[Case]:
    for name, given in TOLERANCES.items():
        yield name, partial(doors.simulated, PAPERS[name].problem, **given, seed=2)


def random_runs() -> Iterator[Case]:
    """Random oscillators, each in two of the ways in its own units, every tenth to a tolerance."""
    ways = [*SETTINGS]
    for number, paper in enumerate(papers(220, seed=29)):

        def numbers(number: int = number, paper: Paper = paper) -> Named:
            hows = dict.fromkeys((ways[number % len(ways)], ways[(3 * number + 1) % len(ways)]))
            asked = {how: paper.in_its_units(SETTINGS[how]) for how in hows}
            if number % 10 == 3:
                asked["rtol"] = {"rtol": 0.1, "seed": number}
            return _each(*((how, partial(doors.simulated, paper.problem, **given)) for how, given in asked.items()))

        yield str(number), numbers


def devices() -> Iterator[Case]:
    """Random oscillators written as a mass with parts, in two ways, and every sixth to a tolerance; and theory."""
    ways = ("plain", "rest", "window", "record", "distributions", "passage")
    for number, paper in enumerate(papers(30, seed=31)):

        def numbers(number: int = number, paper: Paper = paper) -> Named:
            device = paper.device((0.3, 2.0, 1.0)[number % 3], ("mass", "ground")[number % 2])
            asked = {how: paper.in_its_units(SETTINGS[how]) for how in ("plain", ways[number % len(ways)])}
            if number % 6 == 3:
                asked["rtol"] = {"rtol": 0.1, "seed": number}
            return _each(
                *((how, partial(doors.simulated, device, **given)) for how, given in asked.items()),
                ("theory", partial(_theory, device, 0.0)),
            )

        yield str(number), numbers


# --- systems of parts -------------------------------------------------------------------------------------------------

_PLAIN: tuple[dict[str, Any], ...] = (
    {**SHORT, "start": "rest"},
    {"paths": 100, "step": 0.02, "duration": 10.0, "seed": 9},
    {**SHORT, "window": (5.0, 15.0), "initial_position": 0.1, "initial_velocity": -0.5},
    {"paths": 100, "seed": 9},
)
_MORE: tuple[dict[str, Any], ...] = (
    {**SHORT, "start": "rest", "record": 5, "record_every": 7, "spectrum": [2.0, 4.0]},
    {**SHORT, "start": "rest", "distributions": True},
    {**SHORT, "start": "rest", "observables": SETTINGS["observables"]["observables"]},
    {**SHORT, "start": "rest", "first_passage": {"x": 0.15, "v": -1.0, "energy": 1.0}},
    {**SHORT, "start": "rest", "memory_tolerance": 1e-9},
    {**SHORT, "start": "rest", "slowest_counted_impact": 0.3},
)


def systems() -> Iterator[Case]:
    """Random systems with every pair of parts, in two ways that share a kernel, or in one; what is refused too."""
    for number in range(len(CHOSEN)):
        names, parts = system(number)

        def numbers(number: int = number, parts: list[Any] = parts) -> Named:
            one = number // 2
            asked = {"more": _MORE[one % len(_MORE)]}
            if number % 2:
                asked = {"run": _PLAIN[one % len(_PLAIN)], "other": _PLAIN[(one + 1) % len(_PLAIN)]}
            if number % 12 == 5:
                asked["rtol"] = {"rtol": 0.1, "seed": number, "quantities": ("v_mean_square",)}
            problem = doors.system(*parts)
            return _each(*((how, partial(doors.simulated, problem, **given)) for how, given in asked.items()))

        yield f"{number}-{'-'.join(names)}", numbers


# --- theory -----------------------------------------------------------------------------------------------------------


def _theory(problem: Any, place: float, curves: bool = True) -> Named:
    """What all methods answer, and how far each is trusted."""
    answers, silent = doors.answers(problem)
    for method in silent:
        yield f"{method}", "none"
    for method in sorted(answers):
        for rest, value in doors.of_answer(answers[method]):
            yield f"{method}/{rest}", value
        if curves:
            for rest, value in doors.curves_of(answers[method], place):
                yield f"{method}/curves/{rest}", value
    for rest, value in doors.trusted(problem, answers):
        yield f"trust/{rest}", value


def methods() -> Iterator[Case]:
    """All methods and the atlas for random oscillators; of the first sixty also curves and words."""
    for number, paper in enumerate(papers(300)):

        def numbers(number: int = number, paper: Paper = paper) -> Named:
            problem, place, many = paper.problem, 0.0 if paper.wall is None else paper.wall[0], number < 60
            yield from _theory(problem, place, many)
            ways = [("atlas", partial(doors.of_atlas, problem))]
            yield from _each(*ways, *([("words", partial(doors.in_words, problem))] if many else []))

        yield str(number), numbers


def methods_for_systems() -> Iterator[Case]:
    for number in range(len(CHOSEN)):
        _, parts = system(number)

        def numbers(parts: list[Any] = parts) -> Named:
            problem = doors.system(*parts)
            yield from _theory(problem, 0.0)
            yield from _each(("words", partial(doors.in_words, problem)))

        yield str(number), numbers


def _duffing(walls: int, colour: float, order: float, c: float, kappa: float, restitution: float, mass: float) -> Any:
    """A system that is on the validity map."""
    noise = doors.coloured_noise(0.5, colour) if colour else doors.white_noise(1.0)
    return doors.system(
        doors.mass(mass),
        doors.spring(1.3),
        doors.polynomial_spring((0.0, 0.0, kappa)),
        doors.springpot(order, c),
        *(doors.wall(-0.8, restitution), doors.wall(1.1, restitution, "below"))[:walls],
        noise,
    )


def validity() -> Iterator[Case]:
    """Methods for systems on the validity map, and comparisons with Monte Carlo."""
    draw = np.random.default_rng(41)
    for number in range(24):
        walls, colour = number % 3, (0.0, 0.0, 0.0, 0.7)[number % 4]
        order, c = float(draw.uniform(0.25, 1.0)), float(10.0 ** draw.uniform(-1.0, 0.0))
        kappa, restitution = float(draw.uniform(0.05, 1.0)), (1.0, 0.8)[number % 2]
        problem = _duffing(walls, colour, order, c, kappa, restitution, (1.0, 0.6)[number % 2])
        yield str(number), partial(_theory, problem, 0.0)


def comparisons() -> Iterator[Case]:
    given = {"rtol": 0.05, "seed": 3}
    for name in ("lossy", "open", "dashpot"):
        yield name, partial(doors.compared, PAPERS[name].problem, **given)
    yield "device", partial(doors.compared, PAPERS["lossy"].device(0.7, "ground"), **given)
    yield "one_wall", partial(doors.compared, _duffing(1, 0.0, 0.6, 0.4, 0.2, 0.9, 0.6), **given)
    yield "two_walls", partial(doors.compared, _duffing(2, 0.0, 1.0, 0.4, 0.2, 0.9, 1.0), **given)
    yield "errata", doors.errata


# --- files ------------------------------------------------------------------------------------------------------------


def _saved(problem: Any, moments: dict[str, Any], more: dict[str, Any]) -> Named:
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        short, whole = doors.run(problem, **moments), doors.run(problem, **more)
        there = doors.loaded(short, folder / "short.nc")
        yield from _each(
            ("netcdf", lambda: doors.of_run(doors.loaded(whole, folder / "whole.nc"))),
            ("json", lambda: doors.of_run(doors.loaded(whole, folder / "whole.json"))),
            ("table", lambda: doors.table_of_run(whole, folder / "whole.csv")),
            ("extended", lambda: doors.of_run(doors.extended(there, paths=520))),
            ("extended_to", lambda: doors.of_run(doors.extended(there, rtol=0.1))),
        )


def _read_back(problem: Any) -> Named:
    with tempfile.TemporaryDirectory() as folder:
        other = doors.through_a_file(problem, Path(folder) / "system.toml")
    yield "same", float(other == problem)
    yield from _each(("run", partial(doors.simulated, other, **_PLAIN[1])))


def files() -> Iterator[Case]:
    """Runs saved, loaded and extended; systems written and read."""
    moments = {"paths": 200, "seed": 3}
    more = {**SETTINGS["together"], "paths": 100, "duration": 10.0}
    for name, paper in PAPERS.items():
        yield name, partial(_saved, paper.problem, moments, more)
    for number in range(1, len(CHOSEN), 9):
        names, parts = system(number)
        if not {*FUNCTIONS} & {*names}:
            near = {**more, "first_passage": {"x": 0.15}}
            yield f"system_{number}", lambda parts=parts, near=near: _saved(doors.system(*parts), moments, near)
    for number in range(0, len(CHOSEN), 4):
        names, parts = system(number)
        if not {*FUNCTIONS} & {*names}:
            yield f"toml_{number}", lambda parts=parts: _each(("read", lambda: _read_back(doors.system(*parts))))


# --- sensitivities, designs, fits -------------------------------------------------------------------------------------

MATTER = ["x_mean_square", "impact_rate", "impact_speed_mean"]


def sensitivities() -> Iterator[Case]:
    few = {"method": "monte_carlo", "paths": 256, "duration": 40.0, "step": 0.04}
    for name in ("elastic", "lossy", "dashpot", "below"):
        problem = PAPERS[name].problem
        yield (
            name,
            lambda problem=problem: _each(
                ("usual", partial(doors.sensitivity, problem, MATTER)),
                ("envelope", partial(doors.sensitivity, problem, MATTER, method="envelope")),
                ("monte_carlo", partial(doors.sensitivity, problem, MATTER, **few)),
            ),
        )
    between = _duffing(2, 0.0, 0.6, 0.4, 0.2, 0.9, 0.6)
    yield (
        "two_walls",
        lambda: _each(
            ("theory", partial(doors.sensitivity, between, MATTER[:2], method="theory")),
            ("monte_carlo", partial(doors.sensitivity, between, MATTER[:2], **few)),
        ),
    )


def designs() -> Iterator[Case]:
    c = doors.free("c", 0.5, (0.05, 5.0))
    device = doors.system(doors.spring(4.0), doors.dashpot(c), doors.wall(-1.0), doors.white_noise(1.0))
    rate: dict[str, tuple[float | None, float | None]] = {"impact_rate": (None, 0.2)}
    rough = {"rtol": 0.1, "cost_rtol": 0.3, "probability": 0.9}
    yield "device", partial(doors.design, device, "c", rate, **rough)
    gap = doors.free("gap", -0.6, (-2.0, -0.1))
    hard = doors.system(
        doors.mass(0.5), doors.spring(2.0), doors.polynomial_spring((0.0, 0.0, 0.1)), doors.dashpot(0.3),
        doors.wall(gap, 0.8), doors.white_noise(0.3),
    )  # fmt: skip
    yield "hard", partial(doors.design, hard, "x_mean_square", rate, **rough)
    paper = doors.oscillator(2.0, 0.6, c, 0.5, doors.wall(-0.1, 0.8))
    yield "paper", partial(doors.design, paper, "c", {"x_mean_square": (None, 0.05)}, **rough)


def fits() -> Iterator[Case]:
    """One fit to each kind of data, of numbers at random."""
    draw = np.random.default_rng(43)
    hertz = np.geomspace(0.1, 100.0, 21)
    w = 2j * np.pi * hertz
    order, coefficient = doors.free("order", 0.5, (0.02, 0.98)), doors.free("C", 1.0, (0.01, 100.0))
    k, q = doors.free("k", 1.0, (0.01, 1000.0)), doors.free("q", 0.8, (0.05, 5.0))
    modulus = (3.0 + 2.0 * w**0.4) * (1.0 + 0.02 * draw.standard_normal(21))
    moduli = doors.moduli(hertz, modulus.real, modulus.imag)
    one = doors.system(doors.spring(k), doors.springpot(order, coefficient))
    other = doors.system(doors.spring(k), doors.dashpot(doors.free("c", 0.1, (0.001, 10.0))))
    yield "moduli", partial(doors.fit, one, moduli)
    yield "choices", partial(doors.fit, [one, other], moduli)

    hertz = np.linspace(0.2, 6.0, 41)
    w = 2j * np.pi * hertz
    clean = 1.0 / (200.0 + 5.0 * w**0.5 + w**2)
    noisy = clean * (1.0 + 0.05 * draw.standard_normal(41) + 0.05j * draw.standard_normal(41))
    yield "response", partial(doors.fit, one, doors.frequency_response(hertz, noisy, averages=50, coherence=[0.9] * 41))
    shaken = doors.system(doors.spring(k), doors.springpot(order, coefficient), doors.white_noise(q))
    density = 2.0 * np.abs(clean) ** 2 * draw.gamma(30.0, 1.0 / 30.0, 41)
    yield "spectrum", partial(doors.fit, shaken, doors.spectrum(hertz, density, 30.0))

    damped = doors.system(doors.spring(k), doors.dashpot(doors.free("c", 0.5, (0.01, 10.0))), doors.white_noise(q))
    path, kick = np.zeros(400), draw.standard_normal(400)
    for n in range(2, 400):
        path[n] = 1.85 * path[n - 1] - 0.92 * path[n - 2] + 0.01 * kick[n]
    yield "record", partial(doors.fit, damped, doors.record(0.1 * np.arange(400), path, noise=1e-3))

    before = draw.rayleigh(1.0, 60)
    after = before * 0.7 * before**-0.1 * (1.0 + 0.03 * draw.standard_normal(60))
    bounce = doors.free("r", 0.5, (0.1, 1.0))
    yield "impacts", partial(doors.fit, doors.wall(0.0, bounce), doors.impacts(before, after))

    struck = doors.oscillator(doors.free("w", 1.1, (0.3, 3.0)), 1.0, 0.4, q, doors.wall(-0.5))
    means = doors.statistics(x_mean_square=(1.0, 0.03), v_mean_square=(1.2, 0.03), impact_rate=(0.24, 0.01))
    yield "statistics", partial(doors.fit, struck, means, seed=2, paths=1024)


# --- studies, the page ------------------------------------------------------------------------------------------------


def _study(given: dict[str, Any]) -> Named:
    with tempfile.TemporaryDirectory() as folder:
        yield from doors.study(given, Path(folder))


def studies() -> Iterator[Case]:
    for name, given in doors.STUDIES.items():
        yield name, lambda given=given: _each(("study", partial(_study, given)))


def page() -> Iterator[Case]:
    for name, problem in doors.SHOWN.items():
        yield name, partial(doors.page, problem)


KINDS: dict[str, Callable[[], Iterator[Case]]] = {
    "runs": runs,
    "random_runs": random_runs,
    "devices": devices,
    "systems": systems,
    "rtol": runs_to_a_tolerance,
    "files": files,
    "methods": methods,
    "methods_for_systems": methods_for_systems,
    "validity": validity,
    "comparisons": comparisons,
    "sensitivities": sensitivities,
    "designs": designs,
    "fits": fits,
    "studies": studies,
    "page": page,
}


def digested(value: object) -> str:
    """A number's hexadecimal form, or an array's shape and the digest of its bytes."""
    if isinstance(value, np.ndarray):
        return (
            f"{value.dtype}{list(value.shape)} {hashlib.sha256(np.ascontiguousarray(value).tobytes()).hexdigest()[:24]}"
        )
    return value.hex() if isinstance(value, float) else str(value)


FEW = ("runs", "methods")


def few(kind: str) -> Iterator[tuple[str, tuple[float, float]]]:
    """A cheap part of what is kept, with the room that rounding takes: a thousandth of a standard error in a run."""
    if kind == "methods":
        for number, paper in enumerate(papers(12)):
            answers, _ = doors.answers(paper.problem)
            for method in sorted(answers):
                for rest, value in doors.of_answer(answers[method]):
                    if isinstance(value, float) and np.isfinite(value) and rest != "warnings":
                        yield f"{number}/{method}/{rest}", (value, 1e-6 * abs(value) + 1e-9)
            for rest, value in doors.of_atlas(paper.problem):
                if isinstance(value, float) and np.isfinite(value):
                    yield f"{number}/atlas/{rest}", (value, 1e-6 * abs(value) + 1e-9)
        return
    for name in ("lossy", "below", "open"):
        for quantity, (value, error) in doors.values_and_errors(PAPERS[name].problem, paths=300, seed=3).items():
            if np.isfinite(value):
                yield f"{name}/{quantity}", (value, 1e-3 * error + 1e-9)
