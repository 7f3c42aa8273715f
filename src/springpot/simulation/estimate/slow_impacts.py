"""Slow impacts on a lossy wall: the share that a step misses, and the impact rate completed by them.

Near the wall the motion is that of a free mass under white noise (`springpot.theory.mckean`): the rate of impacts
slower than u is proportional to K u^m.  A step h resolves speeds above about s = sqrt(q h) only; slower impacts are
missed, a share of all impacts that is proportional to h^(m / 2).  Momentum and energy lost in impacts hardly change.

With speeds in units of s the law depends on the restitution only: of the impacts slower than u a run misses

    K s^m D phi((u / s)^m / D),    D = exp(-3.6 (r - 0.163)),    phi(y) = (1 - exp(-y^4))^(1/4),

almost all of those slower than s D^(1/m) and none of the faster ones.  Compared with the Fokker-Planck equation at
order 1, c = 0.3 and r from 0.2 to 0.5, D is right to 10 % at b = 0, and up to 25 % too large at b = 0.5 and -1; D phi
is then up to 20 % too large below s D^(1/m), and 10 % too small at s.

An elastic wall (r = 1) is left out: no impacts are missed there, at order 1 exactly (`settings.keeps_the_law`).

With ``rtol`` the rate is completed.  The number N(u) of impacts faster than u is counted at two speeds; by the law,
N(0) = N(u) + (N(u) - N(2 u)) / (2^m - 1).  At u = k sqrt(q h), with k of `StruckWalls.resolved_speed`, the errors
that the step causes in N(u) and N(2 u) cancel.  The plain count is too low by 8 % at r = 0.41 and a step of
0.05 / Omega.  k was fitted to the Fokker-Planck equation at order 1 (b = 0, C = 0.2, h = 0.05, 100,000 paths): 0.59,
0.60, 0.61, 0.65 and 0.69 at r = 0.25, 0.3, 0.35, 0.41 and 0.5.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
import numpy.typing as npt

from springpot.machine.arrays import Floats
from springpot.simulation.lowering.observers import Observer
from springpot.simulation.paths.simulation import Simulation
from springpot.simulation.plan.struck import StruckWalls, missed_impacts
from springpot.theory.mckean import COLLAPSE_BELOW, slow_impact_power

if TYPE_CHECKING:
    from springpot.simulation.watch.distributions import Distribution

MARGIN = 1.25
"""A bound is this many times the estimate: the law is accurate to about 20 %."""

UNSURE = 4.0  # speed in units of sqrt(q h) above which D phi equals its limit to a few per cent
MARGIN_PRESSED = 1.6  # instead of MARGIN for `missed_impacts` with a preload: up to 30 % too low at b = 1 and 2
SPAN = 3.0  # K is estimated from the impacts slower than this, in units of sqrt(q h)


def extrapolation_step(walls: StruckWalls) -> float:
    """The largest step, in s, whose bias of the impact rate is proportional to h^p; infinite without a preload.

    A preload presses the mass against the wall with the acceleration g = Omega^2 b.  Within a step this changes speeds
    by about g h, which must be small against those due to noise, sqrt(q h).  Compared with the Fokker-Planck equation
    at order 1, r = 0.3, 0.5 and 0.65, b = 0.5, 1 and 2, the extrapolation by h^p leaves 0.2 of a difference at
    g sqrt(h / q) = 0.2 r, proportional to h^2; the bound used is 0.3.

    Examples
    --------
    >>> round(extrapolation_step(StruckWalls(restitution=0.5, intensity=1.0, press=1.0)), 4)
    0.01
    """
    if walls.restitution == 1.0 or not walls.press > 0.0 or walls.intensity == 0.0:
        return math.inf
    ratio = 0.2 * walls.restitution / walls.press
    return walls.intensity * ratio * ratio  # inf where ** 2 would overflow


@dataclass(frozen=True)
class SlowImpacts:
    """The impacts that a run has missed, relative to those that it has counted.

    Attributes
    ----------
    blur : float
        sqrt(q h) in m/s.
    power : float
        m.
    limit : float
        D.
    front : float
        K sqrt(q h)^m: the share of impacts slower than ``blur`` if none were missed.
    pressed : bool
        Whether a preload presses the mass against the wall.
    """

    blur: float
    power: float
    limit: float
    front: float
    pressed: bool = False

    @property
    def share(self) -> float:
        """Share of all missed impacts."""
        return self.front * self.limit

    def below(self, speed: npt.ArrayLike) -> Floats:
        """Share of missed impacts slower than each of these speeds in m/s.

        Examples
        --------
        >>> SlowImpacts(blur=0.1, power=1.0, limit=0.3, front=0.05).below([0.0, 0.01, 1.0]).round(4)
        array([0.   , 0.005, 0.015])
        """
        scaled = np.maximum(np.asarray(speed, dtype=float), 0.0) / self.blur
        places = np.minimum(scaled**self.power / self.limit, 10.0)
        return np.asarray(self.share * (-np.expm1(-(places**4))) ** 0.25)


def slow_impacts(walls: StruckWalls, step: float, distribution: Distribution) -> SlowImpacts | None:
    """The impacts that a run with this step has missed, from its distribution of the impact speed.

    None without noise, without impacts, or with infinitely many impacts.
    """
    q = walls.intensity
    if walls.restitution <= COLLAPSE_BELOW or not (q > 0.0 and distribution.size > 0.0):
        return None
    blur, power = math.sqrt(q * step), slow_impact_power(walls.restitution)
    limit = math.exp(-3.6 * (walls.restitution - COLLAPSE_BELOW))
    counted = float(np.interp(SPAN * blur, distribution.edges, _shares(distribution), left=0.0, right=1.0))
    front = 0.0 if walls.restitution == 1.0 else counted / (SPAN**power - limit)
    return SlowImpacts(blur, power, limit, front, walls.press > 0.0)


def quantile_step_bias(missed: SlowImpacts, distribution: Distribution, probability: Sequence[float]) -> Floats:
    """Bounds on the step bias of quantiles of the impact speed, in m/s.

    Quantiles are too high where slow impacts are missed.  With a preload the flight between two kicks ends in
    chattering, with impacts slower than under continuous noise, so the lowest quantiles may also be too low: they are
    compared with the law u^m.
    """
    slow = missed.blur * np.geomspace(1e-9, 30.0, 600)
    speed = np.unique(np.concatenate([[0.0], slow, distribution.edges]))
    seen = np.interp(speed, distribution.edges, _shares(distribution), left=0.0, right=1.0)
    there = (seen + MARGIN * missed.below(speed)) / (1.0 + MARGIN * missed.share)
    wanted = np.asarray(probability, dtype=float)
    at, _ = distribution.quantile(wanted)
    bias = np.maximum(at - np.interp(wanted, there, speed), 0.0)
    if missed.pressed and missed.front > 0.0:
        law = (MARGIN * wanted * (1.0 + missed.share) / missed.front) ** (1.0 / missed.power)
        bias = np.maximum(bias, np.where(law < 1.0, missed.blur * law - at, 0.0))
    return np.asarray(bias)


def density_step_bias(missed: SlowImpacts, edges: Floats, density: Floats) -> Floats:
    """Bounds on the step bias of the density of the impact speed in the bins with these edges, in s/m."""
    width, all_missed = np.diff(edges), MARGIN * missed.share
    lacking = MARGIN * np.diff(missed.below(edges)) / width
    # the bin of a missed impact is known less well than the number of missed impacts
    unsure = np.where(edges[:-1] < UNSURE * missed.blur, (MARGIN - 1.0) * missed.share / width, 0.0)
    return np.asarray((np.abs(lacking - all_missed * density) + unsure) / (1.0 + all_missed))


def impact_step_biases(walls: StruckWalls, step: float, values: dict[str, float]) -> dict[str, float]:
    """Bounds on the step bias of impact rate and speeds, by name; empty without impacts.

    Examples
    --------
    >>> values = {"impact_rate": 0.3, "impact_speed_mean": 0.9, "impact_speed_mean_square": 1.0}
    >>> biases = impact_step_biases(StruckWalls(0.5, 1.0), 0.01, values)
    >>> {name: round(bias, 4) for name, bias in biases.items()}
    {'impact_rate': 0.0086, 'impact_speed_mean': 0.0252, 'impact_speed_mean_square': 0.028}
    """
    speed = values["impact_speed_mean_square"]
    if not (speed > 0.0 and walls.restitution > COLLAPSE_BELOW):
        return {}
    missed = min((MARGIN_PRESSED if walls.press > 0.0 else MARGIN) * missed_impacts(walls, step, speed), 0.95)
    biases = {"impact_rate": missed / (1.0 - missed) * values["impact_rate"]}
    return biases | {name: missed * values[name] for name in ("impact_speed_mean", "impact_speed_mean_square")}


def _shares(distribution: Distribution) -> Floats:
    """Share of the impacts below each edge."""
    return np.concatenate([[0.0], np.cumsum(distribution.counts.sum(axis=0))]) / distribution.size


def counts_of_fast_impacts(simulation: Simulation) -> tuple[Observer, ...]:
    """For each of the walls that `Motion.completed` has: the impacts of each path that are not slower than the resolved
    speed, and those that are not slower than twice that speed."""
    from springpot.simulation.watch.counted_impacts import faster_than  # brings Numba, and other runs need none of it

    step = simulation.settings.step
    return tuple(
        faster_than(times * walls.resolved_speed(step), before.removesuffix("_"))
        for before, walls in simulation.motion.completed.items()
        for times in (1.0, 2.0)
    )


def with_completed_rate(simulation: Simulation, samples: dict[str, Floats], counted: Floats) -> dict[str, Floats]:
    """Samples of each estimate with the completed impact rates; the counted rate is ``plain_rate``.

    Parameters
    ----------
    simulation : Simulation
    samples : dict
    counted : ndarray, shape (paths, 2 times the walls that are completed)
        Counts of the observers of `counts_of_fast_impacts`.
    """
    result, completed, (low, high) = samples, simulation.motion.completed, simulation.settings.window_steps
    for n, before in enumerate(completed):
        fast, faster = counted[:, 2 * n], counted[:, 2 * n + 1]
        slower = (fast - faster) / (2.0 ** slow_impact_power(completed[before].restitution) - 1.0)
        rates = samples[f"{before}impact_rate"]
        whole = np.asarray((fast + slower) / ((high - low) * simulation.settings.step))
        result = result | {f"{before}impact_rate": whole, f"{before}plain_rate": rates}
        rate = float(whole.mean())
        for name in ("impact_speed_mean", "impact_speed_mean_square") if rate > 0.0 else ():
            # the added impacts are so slow that rate times speed does not change
            own = samples[f"{before}{name}"]
            plain = float(own.mean())
            flux = plain * rates + float(rates.mean()) * (own - plain)  # its mean is rate times speed
            speed = float(flux.mean()) / rate
            result[f"{before}{name}"] = speed + (flux - speed * whole) / rate
    walls = list(simulation.motion.touched)
    for wall in walls if len(walls) == 1 and "" in completed else ():  # its numbers are those of all impacts
        result |= {f"{wall}_{name}": result[name] for name in ("impact_rate", "impact_speed_mean")}
    return result
