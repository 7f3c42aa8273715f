"""Stationary moments from runs scaled to the problem, so that all points of a wide grid have the same relative error.

Steps are given in units of the shortest time scale, transient and window in relaxation times of the energy.  The start
is stationary, and the energy balance is a control variate (see :mod:`springpot.simulation.error.reach`).

With a lossy wall slow impacts are frequent, and a step h misses those slower than about sqrt(h).  The relative bias of
the impact rate is proportional to h^p, with p of `springpot.simulation.estimate.slow_impacts.slow_impact_order`.
Compared with the Fokker-Planck equation at order 1, r = 0.3, 0.4, 0.5 and 0.65, this holds for steps from 0.1 down to
0.003 to within the standard errors of 0.15 %, so that extrapolation from two steps removes the bias.  With a preload
the steps have to be shorter.  Rate times mean speed and rate times mean square speed have no such bias: slow impacts
add little to them.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

from springpot.machine.arguments import finite_number
from springpot.problem.oscillator import Oscillator
from springpot.simulation.estimate.few_events import errors_of_unseen
from springpot.simulation.estimate.slow_impacts import extrapolation_step, impacts_are_countable, slow_impact_order
from springpot.simulation.estimate.stationary_start import adapt
from springpot.simulation.estimate.statistics import controlled, standard_error
from springpot.simulation.lowering.compose import Floats
from springpot.simulation.paths.simulation import Progress, Simulation, simulation_of
from springpot.simulation.plan.scales import scales_of
from springpot.simulation.plan.settings import Settings, resolve
from springpot.theory.result import MOMENTS

__all__ = ["Scaled", "stationary"]

ELASTIC_STEP = 0.05  # in units of the shortest time scale; leaves 0.1 %
LOSSY_STEPS = (0.1, 0.025, 8.0)  # two steps; with a preload the first is at most this many `extrapolation_step`
LOSSIER_STEPS = (0.1, 0.0125, 2.0)  # where slow impacts are frequent: order of the bias in the step below CROWDED
CROWDED = 0.7
SHORTEST = 0.05  # least factor on these steps
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
    >>> moments = stationary(Oscillator(springpot=Springpot(order=1.0, coefficient=1.0)), path_times=1e5)
    >>> abs(moments.values["x_mean_square"] - 0.5) < 5.0 * moments.errors["x_mean_square"] < 0.01
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
    done, samples = 0.0, []
    for each, stream in zip(settings, STREAMS, strict=False):
        share = each.paths * each.steps / whole
        part = None if progress is None else _part_of(progress, done, share)
        samples.append(_run(simulation_of(oscillator, each, adapted), stream, part))
        done += share
    return _moments(samples[0] if len(samples) == 1 else _extrapolated(oscillator, *samples))


def _part_of(progress: Progress, before: float, share: float) -> Progress:
    """Progress of one of several runs, as a fraction of all of them."""
    return lambda fraction: progress(before + share * fraction)


def _steps(oscillator: Oscillator) -> tuple[float, ...]:
    if not oscillator.restitution < 1.0:
        return (ELASTIC_STEP,)
    order = slow_impact_order(oscillator.restitution)
    first, last, even = LOSSY_STEPS if order > CROWDED else LOSSIER_STEPS
    longest = even * extrapolation_step(oscillator) * scales_of(oscillator).fastest_rate
    shorter = max(min(1.0, longest / first), SHORTEST)
    return first * shorter, last * shorter


@dataclass(frozen=True, eq=False)
class _Samples:
    """Samples per path of each estimate, and the standard errors common to all paths (of x(0))."""

    of: dict[str, Floats]
    shared: dict[str, float]


def _run(simulation: Simulation, stream: int, progress: Progress | None) -> _Samples:
    rows = simulation.advance(stream=stream, progress=progress).rows
    estimates = simulation.samples(rows)
    balance = estimates["energy_residual"][1][:, None]
    for speed, flux in _FLUXES.items():  # rate times speed, linearized
        (rate, rates), (mean, means) = estimates["impact_rate"], estimates[speed]
        estimates[flux] = rate * mean, rates * mean + rate * (means - mean)
    values = {name: value for name, (value, _) in estimates.items()}
    shared = simulation.errors_of_the_start(values)
    shared |= errors_of_unseen(values, simulation.impacts(rows), simulation.watched(rows))
    return _Samples({name: controlled(samples, balance) for name, (_, samples) in estimates.items()}, shared)


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
    """The fine run, with the impact rate extrapolated to step zero; fine and coarse paths are independent."""
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
    per_path, shared = dict(samples.of), samples.shared
    rates = per_path["impact_rate"]
    rate = float(rates.mean())
    values = {name: float(per_path[name].mean()) for name in MOMENTS}
    errors = {name: math.hypot(standard_error(per_path[name]), shared[name]) for name in MOMENTS}
    for speed, flux in _FLUXES.items():
        if not rate > 0.0:
            values[speed] = errors[speed] = math.nan
            continue
        mean = float(per_path[flux].mean())
        values[speed] = mean / rate
        spread = standard_error(per_path[flux] / mean - rates / rate)
        errors[speed] = values[speed] * math.hypot(spread, shared["impact_rate"] / rate)
    return Scaled(values, errors)
