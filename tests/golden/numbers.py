"""Every kind of number the program gives, by name, through its public functions only.

Names are paths such as ``runs/lossy/values/x_mean``; a number stands for itself, an array for its shape and a digest of
its bytes.
"""

from __future__ import annotations

import hashlib
import tempfile
import time
import warnings
from collections.abc import Callable, Iterator, Mapping
from dataclasses import fields, is_dataclass
from pathlib import Path
from typing import Any

import numpy as np

import springpot as sp
from springpot import theory
from tests.golden.systems import random_systems

__all__ = ["FEW", "KINDS", "digested", "few", "oscillators"]

Named = Iterator[tuple[str, object]]


def oscillators(count: int, seed: int = 12) -> list[sp.Oscillator]:
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
        wall = sp.Barrier(place, restitution, side=("above", "below")[number // 7 % 2])
        found.append(
            sp.Oscillator(
                natural_frequency=frequency,
                springpot=sp.Springpot(order, coefficient),
                barrier=None if number % 9 == 5 else wall,
                excitation=sp.WhiteNoise(intensity),
            )
        )
    return found


ELASTIC = sp.Oscillator(springpot=sp.Springpot(0.5, 0.3))
LOSSY = sp.Oscillator(
    natural_frequency=2.0,
    springpot=sp.Springpot(0.6, 0.4),
    barrier=sp.Barrier(-0.1, 0.8),
    excitation=sp.WhiteNoise(0.5),
)
BELOW = sp.Oscillator(springpot=sp.Springpot(0.3, 0.7), barrier=sp.Barrier(0.4, 0.45, side="below"))
OPEN = sp.Oscillator(springpot=sp.Springpot(0.7, 0.5), barrier=None)
DASHPOT = sp.Oscillator(springpot=sp.Springpot(1.0, 0.2), barrier=sp.Barrier(-0.5, 0.7))
SPRING = sp.Oscillator(springpot=sp.Springpot(0.0, 0.2), barrier=sp.Barrier(0.0, 0.9))
PROBLEMS = {"elastic": ELASTIC, "lossy": LOSSY, "below": BELOW, "open": OPEN, "dashpot": DASHPOT, "spring": SPRING}

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
}
TOLERANCES: dict[str, tuple[sp.Oscillator, dict[str, Any]]] = {
    "elastic": (ELASTIC, {"rtol": 0.02}),
    "lossy": (LOSSY, {"rtol": 0.03, "quantities": ("amplitude_mean_square", "impact_rate", "x_mean")}),
    "below": (BELOW, {"rtol": 0.05, "quantities": ("amplitude_mean_square", "impact_speed_mean")}),
    "open": (OPEN, {"rtol": 0.02}),
    "dashpot": (DASHPOT, {"rtol": 0.03, "quantities": ("impact_rate",)}),
}


def _of_a_result(found: object) -> Named:
    """A frozen result's numbers, however it is nested; sentences and times are no numbers."""
    if isinstance(found, Mapping):
        for name, part in found.items():
            for rest, value in _of_a_result(part):
                yield f"/{name}{rest}", value
    elif is_dataclass(found):
        for field in fields(found):
            for rest, value in _of_a_result(getattr(found, field.name)):
                yield f"/{field.name}{rest}", value
    elif isinstance(found, np.ndarray):
        yield "", found
    elif isinstance(found, bool | int | float | np.number):
        yield "", float(found)
    elif isinstance(found, tuple | list):
        for number, part in enumerate(found):
            for rest, value in _of_a_result(part):
                yield f"/{number}{rest}", value


def _of_a_dataset(found: Any) -> Named:
    for name in sorted([*found.data_vars, *found.coords]):
        values = np.asarray(found[name])
        if values.dtype.kind in "fiu":
            yield str(name), values if values.ndim else float(values)


def runs() -> Named:
    for name, oscillator in PROBLEMS.items():
        for how, given in SETTINGS.items():
            if how == "riemann" and name in ("dashpot", "spring", "below"):
                continue
            with warnings.catch_warnings():
                warnings.simplefilter("ignore")
                found = sp.simulate(oscillator, **given).to_xarray()
            for rest, value in _of_a_dataset(found):
                yield f"{name}/{how}/{rest}", value


def runs_to_a_tolerance() -> Named:
    for name, (oscillator, given) in TOLERANCES.items():
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            found = sp.simulate(oscillator, **given, seed=2).to_xarray()
        for rest, value in _of_a_dataset(found):
            yield f"{name}/{rest}", value


def _simulated(problem: Any, how: str, given: dict[str, Any]) -> Named:
    """A run's numbers under its way, or that it is refused."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        try:
            found = sp.simulate(problem, **given).to_xarray()
        except (TypeError, ValueError, ArithmeticError) as refusal:
            yield f"{how}/refused", type(refusal).__name__
            return
    for rest, value in _of_a_dataset(found):
        yield f"{how}/{rest}", value


def _in_units_of(oscillator: sp.Oscillator, given: dict[str, Any]) -> dict[str, Any]:
    """Settings for frequency 1, noise 1 and a wall at 0, for another oscillator."""
    time = 1.0 / oscillator.natural_frequency
    size, wall, up = float(oscillator.excitation.intensity * time**3) ** 0.5, 0.0, 1.0
    if oscillator.barrier is not None:
        wall, up = oscillator.barrier.position, {"above": 1.0, "below": -1.0}[oscillator.barrier.side]
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
            case "initial_velocity":
                return value * size / time
            case "first_passage":
                levels = {kind: level * scales[kind] for kind, level in value.items() if kind in scales}
                return {**levels, "x": wall + up * 0.8 * size}
        return value

    return {name: scaled(name, value) for name, value in given.items()}


def random_runs(count: int = 200) -> Named:
    """Random oscillators, each in two of the ways of SETTINGS in its own units, every tenth to a tolerance."""
    ways = [*SETTINGS]
    for number, oscillator in enumerate(oscillators(count, seed=29)):
        for how in (ways[number % len(ways)], ways[(3 * number + 1) % len(ways)]):
            for rest, value in _simulated(oscillator, how, _in_units_of(oscillator, SETTINGS[how])):
                yield f"{number}/{rest}", value
        if number % 10 == 3:
            for rest, value in _simulated(oscillator, "rtol", {"rtol": 0.1, "seed": number}):
                yield f"{number}/{rest}", value


SYSTEM_SETTINGS: tuple[dict[str, Any], ...] = (
    {**SHORT, "start": "rest"},
    {"paths": 100, "step": 0.02, "duration": 10.0, "seed": 9},
    {**SHORT, "window": (5.0, 15.0), "initial_position": 0.1, "initial_velocity": -0.5},
    {**SHORT, "start": "rest", "record": 5, "record_every": 7, "spectrum": [2.0, 4.0]},
    {**SHORT, "start": "rest", "distributions": True},
    {**SHORT, "start": "rest", "observables": SETTINGS["observables"]["observables"]},
    {**SHORT, "start": "rest", "first_passage": {"x": 0.15, "v": -1.0, "energy": 1.0}},
    {**SHORT, "start": "rest", "memory_tolerance": 1e-9},
)


def systems(count: int = 100) -> Named:
    """Random systems with every pair of parts, each in one of the ways above; what is refused too."""
    for number, (names, system) in enumerate(random_systems(count)):
        where = f"{number}-{'-'.join(names)}"
        for rest, value in _simulated(system, "run", SYSTEM_SETTINGS[number % len(SYSTEM_SETTINGS)]):
            yield f"{where}/{rest}", value
        if number % 12 == 5:
            given = {"rtol": 0.1, "seed": number, "quantities": ("v_mean_square",)}
            for rest, value in _simulated(system, "rtol", given):
                yield f"{where}/{rest}", value


def methods_for_systems(count: int = 100) -> Named:
    for number, (_, system) in enumerate(random_systems(count)):
        answers, statements = theory.solve_all(system)
        for method in sorted(statements):
            yield f"{number}/{method}", "none"
        for method in sorted(answers):
            for rest, value in answers[method].to_dict().items():
                if isinstance(value, bool | int | float):
                    yield f"{number}/{method}/{rest}", float(value)
        yield f"{number}/recommended", sp.recommended(system, answers).method


def _densities(result: Any, oscillator: sp.Oscillator) -> Named:
    spread = max(float(result.x_mean_square), 1e-12) ** 0.5
    speed = max(float(result.v_mean_square), 1e-12) ** 0.5
    wall = oscillator.barrier.position if oscillator.barrier is not None else 0.0
    places = {
        "x_density": wall + np.linspace(-2.0, 2.0, 9) * spread,
        "v_density": np.linspace(-2.0, 2.0, 9) * speed,
        "amplitude_density": np.linspace(0.1, 4.0, 9) * spread,
        "impact_speed_density": np.linspace(0.1, 3.0, 9) * speed,
    }
    for name, where in places.items():
        if hasattr(result, name):
            try:
                yield name, np.asarray(getattr(result, name)(where))
            except (ValueError, ArithmeticError, TypeError) as refusal:
                yield name, type(refusal).__name__


def methods(count: int = 300, with_densities: int = 60) -> Named:
    for number, oscillator in enumerate(oscillators(count)):
        answers, statements = theory.solve_all(oscillator)
        for method in sorted([*answers, *statements]):
            if method in statements:
                yield f"{number}/{method}", "none"
                continue
            for rest, value in answers[method].to_dict().items():
                if isinstance(value, bool | int | float):
                    yield f"{number}/{method}/{rest}", float(value)
            if number < with_densities:
                for rest, value in _densities(answers[method], oscillator):
                    yield f"{number}/{method}/{rest}", value
        yield f"{number}/recommended", sp.recommended(oscillator, answers).method
        try:
            found = sp.atlas(oscillator)
        except (ValueError, theory.NotCoveredError):
            continue
        for rest, value in found.to_dict().items():
            if isinstance(value, bool | int | float):
                yield f"{number}/atlas/{rest}", float(value)


STUDY: dict[str, Any] = {
    "name": "golden",
    "seed": 7,
    "methods": ["averaging", "envelope", "memory_closure", "monte_carlo"],
    "quantities": ["amplitude_mean_square", "impact_rate"],
    "axes": {"order": [0.4, 1.0], "restitution": [1.0, 0.7]},
}
WAYS: dict[str, dict[str, Any]] = {
    "plain": {"paths": 128, "duration": 20.0, "step": 0.02},
    "rtol": {"rtol": 0.1},
}


STUDY_OF_SYSTEMS: dict[str, Any] = {
    "name": "golden systems",
    "seed": 7,
    "methods": ["envelope", "monte_carlo"],
    "quantities": ["x_mean_square", "impact_rate"],
    "system": {
        "parts": [
            {"kind": "mass", "value": 0.5},
            {"kind": "spring", "stiffness": 2.0},
            {"kind": "polynomial_spring", "coefficients": [0.0, 0.0, 0.1]},
            {"kind": "springpot", "order": 0.5, "coefficient": 0.2},
            {"kind": "barrier", "name": "stop", "position": -0.5, "restitution": 0.8},
            {"kind": "white_noise", "intensity": 0.3},
        ]
    },
    "axes": {"parts.spring.stiffness": [1.0, 2.0], "parts.stop.restitution": [1.0, 0.7]},
    "monte_carlo": {"paths": 128, "duration": 20.0, "step": 0.02},
}


def studies() -> Named:
    """Every stored chunk."""
    from springpot.studies.question import read_study
    from springpot.studies.running import run_study

    given = {how: {**STUDY, "monte_carlo": way} for how, way in WAYS.items()}
    for how, study in {**given, "systems": STUDY_OF_SYSTEMS}.items():
        with tempfile.TemporaryDirectory() as folder:
            store = Path(folder) / "golden.zarr"
            run_study(read_study(study), store)
            for file in sorted(store.rglob("*")):
                if file.is_file() and file.name != "zarr.json":
                    yield f"{how}/{file.relative_to(store)}", np.frombuffer(file.read_bytes(), np.uint8)


SHOWN = {
    "lossy": {"order": 0.6, "coefficient": 0.4, "restitution": 0.8, "position": -0.3},
    "open": {"order": 0.5, "wall": False},
    "elastic": {"order": 1.0, "coefficient": 0.5},
}


def page() -> Named:
    """What the page is sent: tables, curves and histograms when all is there."""
    from tests.explorer.conftest import running
    from tests.explorer.talk import tab

    with running() as server:
        for name, problem in SHOWN.items():
            last: dict[str, Any] = {}
            with tab(server) as one:
                one.say(kind="problem", generation=7, paths=640, seed=3, **problem)
                end = time.monotonic() + 60.0
                while not ({"theory", "2", "3"} <= last.keys() and last.get("estimates", {}).get("complete")):
                    assert time.monotonic() < end
                    kind, content = one.hear()
                    if kind == "estimates" and content["complete"]:  # the frames of all paths come after it
                        last.pop("2", None), last.pop("3", None)
                    last[kind] = content[1] if kind.isdigit() else content
            for kind in ("theory", "estimates", "2", "3"):
                for rest, value in _of_a_result(last.get(kind, {})):
                    if "seconds" not in rest and "generation" not in rest:
                        yield f"{name}/{kind}{rest}", value


def digested(value: object) -> str:
    """A number's hexadecimal form, or an array's shape and the digest of its bytes."""
    if isinstance(value, np.ndarray):
        return (
            f"{value.dtype}{list(value.shape)} {hashlib.sha256(np.ascontiguousarray(value).tobytes()).hexdigest()[:24]}"
        )
    return value.hex() if isinstance(value, float) else str(value)


KINDS: dict[str, Callable[[], Named]] = {
    "runs": runs,
    "random_runs": random_runs,
    "systems": systems,
    "rtol": runs_to_a_tolerance,
    "methods": methods,
    "methods_for_systems": methods_for_systems,
    "studies": studies,
    "page": page,
}


FEW = ("runs", "methods")


def few(kind: str) -> Iterator[tuple[str, tuple[float, float]]]:
    """A cheap part of what is kept, with the room that rounding takes: a thousandth of a standard error in a run."""
    if kind == "methods":
        for name, value in methods(12, 0):
            if isinstance(value, float) and np.isfinite(value):
                yield name, (value, 1e-6 * abs(value) + 1e-9)
        return
    for name in ("lossy", "below", "open"):
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            found = sp.simulate(PROBLEMS[name], paths=300, seed=3)
        for quantity, value in found.values.items():
            if np.isfinite(value):
                yield f"{name}/{quantity}", (value, 1e-3 * found[quantity].error + 1e-9)
