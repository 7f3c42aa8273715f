"""What a tab asks a run for beside its moments: forces, cycles, first passages, profiles; as numbers and charts."""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy as np

from springpot.explorer.excitation import chart
from springpot.explorer.protocol import Observe
from springpot.explorer.sliders import raised, shown_in, titled, written
from springpot.machine.faults import with_error
from springpot.machine.progress import until_stopped
from springpot.problem.basquin import HOUR, Basquin
from springpot.problem.catalogue import LEVELS, results_on_request, unit_of_result
from springpot.problem.coordinates import Coordinates
from springpot.problem.system import System

if TYPE_CHECKING:
    from springpot.simulation.result.results import Run

HISTOGRAM_BINS = 60
POINTS = 161  # of a survival curve
_IN_BINS = ("mean_square_profile", "impact_rate_profile")
"""Endings of the profiles that are drawn."""


def offered(system: System) -> dict[str, Any]:
    """What a run can see: name, words, unit, and why not, if it cannot; and why the excitation ends.

    Of what can exceed a level, of displacements, of forces and accelerations,
    and of what belongs to impacts and has no value at other times.

    Examples
    --------
    >>> from springpot.problem.parts import Spring, WhiteNoise
    >>> offered(System(Spring(4.0), WhiteNoise(1.0)))["forces"][0]
    ('spring_force', 'spring force', 'm/s²', '')
    """
    from springpot.simulation.plan.motions import motion_of

    motion = motion_of(system)
    moving = [name for name, (kind, _) in motion.levels.items() if kind == "x"]
    whys = {name: one.reason and f"{name} cannot be seen: {one.reason}." for name, one in motion.outputs.items()}
    return {
        "ends": motion.ends,
        "levels": [(name, titled(name), written(LEVELS[kind]), "") for name, (kind, _) in motion.levels.items()]
        + [(name, titled(name), "m/s", "") for name in motion.speeds if motion.touched],
        "displacements": [(name, titled(name), "m", "") for name in moving],
        "forces": [(name, titled(name), _unit(system, name), why) for name, why in whys.items()],
        "of_impacts": [(name, titled(name), _unit(system, name), "") for name in motion.of_impacts],
    }


def _unit(system: System, name: str) -> str:
    """The unit of a displacement, force or acceleration; of a mean square that of its root."""
    return written(unit_of_result(system, f"{name}_mean")) or "m"


def observed(
    system: System, asked: Observe, run: Mapping[str, Any], progress: Callable[[float], None], stop: Callable[[], bool]
) -> dict[str, Any]:
    """Simulate with what was asked: numbers as words and texts, charts, and warnings.

    Parameters
    ----------
    system : System
    asked : Observe
    run : dict
        Paths, seed, start and threads.
    progress : callable
        Told the fraction done.
    stop : callable
        Tells whether to stop.

    Raises
    ------
    TypeError, ValueError, Stopped
        If a request is not possible, or it was stopped.

    Examples
    --------
    >>> from springpot.problem.parts import Dashpot, Spring, WhiteNoise
    >>> device = System(Spring(4.0), Dashpot(0.5), WhiteNoise(1.0))
    >>> found = observed(device, Observe(kind="observe", forces=["spring_force"]), {"paths": 64}, float, bool)
    >>> [name for name, _ in found["numbers"]], found["charts"][0]["x"]
    (['spring force, mean', 'spring force, rms'], ('spring force', 'm/s²'))
    """
    from springpot.simulation.monte_carlo import simulated

    wishes: dict[str, Any] = {"forces": [*asked.forces] or None, "distributions": bool(asked.forces) or None}
    wishes["profile"] = asked.bins or None
    if asked.levels:
        factor = shown_in(asked.length, unit_of_level(system, asked.levels_of))[0]
        wishes["first_passage"] = {asked.levels_of: [level / factor for level in asked.levels]}
    if asked.cycles_of:
        factor = shown_in(asked.length, unit_of_level(system, asked.cycles_of))[0]
        wishes["rainflow"] = {asked.cycles_of: Basquin(asked.exponent, asked.strength / factor, asked.cycles)}
    found = simulated(
        system,
        **{name: wish for name, wish in wishes.items() if wish is not None},
        **run,
        progress=until_stopped(progress, stop),
    )
    return {
        "numbers": [*_numbers(found, asked.length), *_passed(found, asked.length)],
        "charts": [
            *_histograms(found, asked),
            *_cycles(found, asked),
            *_survival(found, asked.length),
            *_return_periods(found, asked.length),
            *_profiles(found, asked.length),
        ],
        "said": [*map(str, found.warnings)],
    }


def unit_of_level(system: System, name: str) -> str:
    """The unit of what can exceed a level; none of what cannot, which is refused later.

    Examples
    --------
    >>> from springpot.problem.parts import Spring, WhiteNoise
    >>> [unit_of_level(System(Spring(4.0), WhiteNoise(1.0)), name) for name in ("x", "spring_force", "other")]
    ['m', 'm/s²', '']
    """
    known = offered(system)
    return next((unit for own, _, unit, _ in known["levels"] + known["forces"] if own == name), "")


def _numbers(run: Run, length: str) -> Iterator[tuple[str, str]]:
    for name in results_on_request(run.system):
        if name not in run:
            continue
        value, error, unit = run[name].value, run[name].error, written(run[name].unit)
        if name.endswith("_mean_square"):
            value = math.sqrt(value)
            name = name.removesuffix("_mean_square")
            error, unit, name = error / (2.0 * value) if value else error, _unit(run.system, name), f"{name}, rms"
        elif name.endswith("_mean"):
            name = f"{name.removesuffix('_mean')}, mean"
        factor, unit = shown_in(length, unit)
        yield titled(name), text_of(with_error(value * factor, error * factor, unit or "1"))


def text_of(words: str) -> str:
    """A number as the page writes it.

    Examples
    --------
    >>> text_of("(8.79 +- 0.08)e-08 1/h")
    '(8.79 ± 0.08)·10⁻⁸ 1/h'
    """
    signs = {"-": "⁻", "+": ""}
    powers = re.sub(r"(?<=[\d)])e([+-])0*(\d+)", lambda e: f"·10{signs[e[1]]}{raised(int(e[2]))}", words)
    return powers.replace("+-", "±").replace("-", "−")


def _levels(run: Run) -> Iterator[Any]:
    for passages in run.first_passages.values():
        assert isinstance(passages, Sequence)  # a list of levels was asked for
        yield from passages


def _passed(run: Run, length: str) -> Iterator[tuple[str, str]]:
    """Of each level the share that passed, the rate and the return period; why they are not known once for all."""
    unknown = dict[str, None]()
    for own in _levels(run):
        factor, unit = shown_in(length, written(own.unit))
        title = f"{titled(own.quantity)} past {own.level * factor:.6g} {unit}"
        yield f"{title}, within {own.horizon:.4g} s", text_of(str(own.probability(own.horizon)))
        if math.isnan(own.rate.value):
            unknown[text_of(str(own.rate))] = None
        else:
            yield f"{title}, rate", text_of(str(replace(own.rate, unit="1/s")))
            yield f"{title}, return period", text_of(str(own.return_period))
    yield from (("rate of passages and return period", words) for words in unknown)


def _histograms(run: Run, asked: Observe) -> Iterator[dict[str, Any]]:
    for name in asked.forces:
        edges, density = run.distributions[name].density(HISTOGRAM_BINS)[:2]
        unit = _unit(run.system, name)
        yield chart(titled(name), (titled(name), unit), ("density", f"1/({unit})" if "/" in unit else f"1/{unit}"),
                    edges, bars=density)  # fmt: skip


def _cycles(run: Run, asked: Observe) -> Iterator[dict[str, Any]]:
    """How many cycles per hour are longer than each range."""
    if name := asked.cycles_of:
        from springpot.simulation.paths.statistics import NORMAL
        from springpot.simulation.watch.rainflow import longer_cycles  # Numba is slow to import

        rate = HOUR * run[f"{name}_cycle_rate"].value
        place, longer, error = longer_cycles(run.distributions[f"{name}_range"], rate)
        low, high = longer - NORMAL * error, longer + NORMAL * error
        line = {"name": "longer cycles", "values": longer, "low": np.where(low > 0.0, low, np.nan), "high": high}
        factor, unit = shown_in(asked.length, _unit(run.system, name))
        yield chart(f"{titled(name)}: ranges of its cycles", (titled(f"{name}_range"), unit),
                    ("longer cycles", "1/h"), factor * place, [line], logarithmic="y",
                    note="With 95 % intervals.")  # fmt: skip


def _survival(run: Run, length: str) -> Iterator[dict[str, Any]]:
    if levels := [*_levels(run)]:
        time, lines = np.linspace(0.0, levels[0].horizon, POINTS), []
        for own in levels:
            low, high = own.survival_interval(time)
            factor, unit = shown_in(length, written(own.unit))
            lines.append(
                {"name": f"{own.level * factor:.6g} {unit}", "values": own.survival(time)[0]}
                | {"low": low, "high": high}
            )
        yield chart(
            f"{titled(levels[0].quantity)}: share that has not passed the level", ("t", "s"), ("share", ""), time, lines
        )


def _return_periods(run: Run, length: str) -> Iterator[dict[str, Any]]:
    """Level against return period, of the levels whose rate is known."""
    periods = {own.level: own.return_period for own in _levels(run) if own.rate.value > 0.0}
    if len(periods) > 1:
        own, levels = next(_levels(run)), sorted(periods)
        line = {end: [getattr(periods[level], end) for level in levels] for end in ("value", "low", "high")}
        words = {"name": "return period", "values": line.pop("value")} | line
        factor, unit = shown_in(length, written(own.unit))
        yield chart(f"{titled(own.quantity)}: return period of the level", (titled(own.quantity), unit),
                    ("return period", "s"), np.multiply(levels, factor), [words], logarithmic="y",
                    note="With 95 % intervals.")  # fmt: skip


def _profiles(run: Run, length: str) -> Iterator[dict[str, Any]]:
    for name, own in run.profiles.items():
        if name.endswith(_IN_BINS) and np.isfinite(own.value).any():
            factor, unit = shown_in(length, written(own.unit))
            words, value = titled(name.removesuffix("_profile")), factor * own.value
            away = 2.0 * factor * own.standard_error
            quantity = "mean square" if words.endswith("mean square") else "impact rate"
            line = {"name": words, "values": value, "low": value - away, "high": value + away}
            yield chart(words, ("t", "s"), (quantity, unit), own.time, [line],
                        note="Two standard errors on either side.")  # fmt: skip


def followed(system: System) -> Iterator[dict[str, Any]]:
    """What the charts can show: the one mass, or each point of several and each two with a part between them.

    ``name`` is how the names of its results begin, ``row`` what it takes of the displacement of each point.
    """
    at = Coordinates.of_masses(system.points)
    for own, row in at.beginnings.items():
        yield {"name": own, "title": titled(own[:-1]), "row": row.tolist(), "pair": False}
    for pair in system.coordinates.linked:
        name, title = f"{'_'.join(pair)}_elongation_", " to ".join(map(titled, pair))
        yield {"name": name, "title": title, "row": at.row(pair).tolist(), "pair": True}
