"""Stationary moments by runs scaled to the problem, so that every point of a wide grid is known equally well.

Times are counted in the problem's own: steps in its shortest time scale, transient and window in relaxation times of
the energy.  The start is adapted, and the energy balance is a control variate (see
:mod:`springpot.simulation.accuracy`).

Behind a lossy wall slow impacts crowd, and a step h misses those slower than about sqrt(h): the impact rate lacks a
share that goes like h^p with the p of `springpot.simulation.slow_impacts.slow_impact_order`.  Against the Fokker-Planck
equation at order 1 that one power describes the whole bias from steps of 0.1 down to 0.003, at r = 0.3, 0.4, 0.5 and
0.65, to the standard errors of 0.15 %: so two steps and the known power take it out; behind a preload they have to be
shorter.  What impacts hand over, rate times mean speed and rate times mean square speed, does not suffer, for slow
impacts hand over next to nothing.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

from springpot.arguments import finite_number
from springpot.oscillator import Oscillator
from springpot.simulation.adapted import adapt
from springpot.simulation.compose import Floats
from springpot.simulation.scales import scales_of
from springpot.simulation.settings import Settings, resolve
from springpot.simulation.simulation import Progress, Simulation, simulation_of
from springpot.simulation.slow_impacts import even_step, impacts_are_countable, slow_impact_order
from springpot.simulation.statistics import controlled, standard_error
from springpot.theory.result import MOMENTS

__all__ = ["Scaled", "stationary"]

ELASTIC_STEP = 0.05  # in units of the shortest time scale; leaves 0.1 %
LOSSY_STEPS = (0.1, 0.025, 8.0)  # two steps, and how many `even_step` the first may be behind a preload
LOSSIER_STEPS = (0.1, 0.0125, 2.0)  # where slow impacts crowd
CROWDED = 0.7  # power of the step below which they do
SHORTEST = 0.05  # share of these steps that is taken at least
TRANSIENT, WINDOW = 6.0, 20.0  # relaxation times
SHORTEST_RELAXATION, SHORTEST_WINDOW = 2.0, 30.0  # in units of 1 / Omega
FEWEST_PATHS = 2048
STREAMS = (4, 5)  # of normals: those of the pilots and of the error budget's levels are 0 to 3
PILOT_PATHS = 8192
_FLUXES = {"impact_speed_mean": "impulse", "impact_speed_mean_square": "loss"}


@dataclass(frozen=True)
class Scaled:
    """Stationary moments and their standard errors, by name.

    Attributes
    ----------
    values, errors : dict
        Keys of `springpot.theory.result.MOMENTS`; NaN where a number does not exist.
    """

    values: dict[str, float]
    errors: dict[str, float]


def stationary(
    oscillator: Oscillator,
    *,
    path_times: float = 1e6,
    seed: int = 1,
    threads: int | None = None,
    progress: Progress | None = None,
) -> Scaled:
    """Every stationary moment, from adapted runs whose step and length are scaled to the problem.

    Parameters
    ----------
    oscillator : Oscillator
        With a stationary state.
    path_times : float
        Length of the windows of all paths together, in relaxation times, from 1e3 to 1e9; the standard error of <A^2>
        is some 0.4 / sqrt(path_times) of it.
    seed, threads, progress
        As in `springpot.simulate`.

    Returns
    -------
    Scaled

    Raises
    ------
    TypeError, ValueError
        If an argument is wrong or there is no stationary state.

    Examples
    --------
    >>> from springpot import Springpot
    >>> found = stationary(Oscillator(springpot=Springpot(order=1.0, coefficient=1.0)), path_times=1e5)
    >>> abs(found.values["x_mean_square"] - 0.5) < 5.0 * found.errors["x_mean_square"] < 0.01
    True
    """
    path_times = finite_number(path_times, "path_times", low=1e3, high=1e9)
    steps = _steps(oscillator)
    settings = [_settings(oscillator, step, path_times, seed, threads) for step in steps]
    adapted = adapt(
        oscillator,
        _settings(oscillator, ELASTIC_STEP, path_times, seed, threads),
        paths=PILOT_PATHS,
        progress=progress,
    )
    whole = sum(each.paths * each.steps for each in settings)
    done, found = 0.0, []
    for each, stream in zip(settings, STREAMS, strict=False):
        share = each.paths * each.steps / whole
        part = None if progress is None else _part_of(progress, done, share)
        found.append(_run(simulation_of(oscillator, each, adapted), stream, part))
        done += share
    return _moments(found[0] if len(found) == 1 else _extrapolated(oscillator, *found))


def _part_of(progress: Progress, before: float, share: float) -> Progress:
    """Progress of one of several runs, told as that of all."""
    return lambda fraction: progress(before + share * fraction)


def _steps(oscillator: Oscillator) -> tuple[float, ...]:
    if not oscillator.restitution < 1.0:
        return (ELASTIC_STEP,)
    order = slow_impact_order(oscillator.restitution)
    first, last, even = LOSSY_STEPS if order > CROWDED else LOSSIER_STEPS
    longest = even * even_step(oscillator) * scales_of(oscillator).fastest_rate
    shorter = max(min(1.0, longest / first), SHORTEST)
    return first * shorter, last * shorter


@dataclass(frozen=True, eq=False)
class _Samples:
    """What each path contributes to each number, and standard errors that all paths share."""

    of: dict[str, Floats]
    shared: dict[str, float]


def _run(simulation: Simulation, stream: int, progress: Progress | None) -> _Samples:
    found = simulation.samples(simulation.advance(stream=stream, progress=progress).rows)
    balance = found["energy_residual"][1][:, None]
    for speed, flux in _FLUXES.items():  # rate times speed, to first order in the spread
        (rate, rates), (mean, means) = found["impact_rate"], found[speed]
        found[flux] = rate * mean, rates * mean + rate * (means - mean)
    shared = simulation.errors_of_the_start({name: value for name, (value, _) in found.items()})
    return _Samples({name: controlled(samples, balance) for name, (_, samples) in found.items()}, shared)


def _settings(oscillator: Oscillator, step: float, path_times: float, seed: int, threads: int | None) -> Settings:
    scales, shortest = scales_of(oscillator), 1.0 / oscillator.natural_frequency
    relaxation = max(scales.energy_time, SHORTEST_RELAXATION * shortest)
    begin, length = TRANSIENT * relaxation, max(WINDOW * relaxation, SHORTEST_WINDOW * shortest)
    if not math.isfinite(begin):
        begin = length = shortest  # resolve() says that there is no stationary state
    return resolve(
        oscillator,
        paths=max(FEWEST_PATHS, round(min(path_times * relaxation / length, 4e7))),
        step=step / scales.fastest_rate,
        duration=begin + length,
        window=(begin, begin + length),
        start="stationary",
        seed=seed,
        threads=threads,
    )


def _extrapolated(oscillator: Oscillator, coarse: _Samples, fine: _Samples) -> _Samples:
    """The fine run, with the impact rate taken to step zero; its paths and the coarse ones are independent."""
    if not impacts_are_countable(oscillator):
        return fine
    first, last = _steps(oscillator)
    ratio = first / last
    rest = 1.0 / (ratio ** slow_impact_order(oscillator.restitution) - 1.0)
    few, many = coarse.of["impact_rate"], fine.of["impact_rate"]
    shift = rest * (float(many.mean()) - float(few.mean()))
    rates = many.mean() + shift + (1.0 + rest) * (many - many.mean())
    shared = math.hypot((1.0 + rest) * fine.shared["impact_rate"], rest * coarse.shared["impact_rate"])
    shared = math.hypot(shared, rest * standard_error(few))
    return _Samples({**fine.of, "impact_rate": rates}, {**fine.shared, "impact_rate": shared})


def _moments(samples: _Samples) -> Scaled:
    found, shared = dict(samples.of), samples.shared
    rates = found["impact_rate"]
    rate = float(rates.mean())
    values = {name: float(found[name].mean()) for name in MOMENTS}
    errors = {name: math.hypot(standard_error(found[name]), shared[name]) for name in MOMENTS}
    for speed, flux in _FLUXES.items():
        if not rate > 0.0:
            values[speed] = errors[speed] = math.nan
            continue
        mean = float(found[flux].mean())
        values[speed] = mean / rate
        spread = standard_error(found[flux] / mean - rates / rate)
        errors[speed] = values[speed] * math.hypot(spread, shared["impact_rate"] / rate)
    return Scaled(values, errors)
