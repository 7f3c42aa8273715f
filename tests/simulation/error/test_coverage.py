"""Do the intervals hold the truth as often as they say?  Fifty problems with exact answers, 200 seeds each.

Three kinds of interval:

plain
    value +- 1.96 standard errors, of a run of given size.  Start, window and step are chosen here such that bias is at
    most a tenth of a standard error, so the truth must lie inside in 95 % of the trials.
corrected
    The same of a run with ``rtol``, whose value is a sum of two levels, where the step has no bias (order 1) or about
    the mean of all trials (a wall and memory, where no exact answer is known).
total
    value +- `Budget.total`: there are bounds on the bias in it, so the truth must lie inside in 95 % or more.

How often may 200 trials come out unlike 95 %?  A coverage of 95 % gives between 91 and 98.5 % (182 to 197 trials) with
probability 0.992, so of the 370 pairs of problem and quantity here three lie outside by chance alone, and to ask that
none does would fail most sound studies.  What is asked of the first two kinds instead:

- the coverage of all trials together within three of its standard errors (0.2 %) of 95 %;
- each pair of problem and quantity within limits that less than one sound study in a hundred leaves anywhere;
- no more problems with a quantity outside [91, 98.5] % than all but one sound study in a thousand have.

The last two hold whatever the correlation between the quantities of a problem (union bounds); problems are independent,
for no two of them share a seed.  Of the total intervals: 95 % of all trials together, and 93 % of each pair.
"""

import itertools
import math
from collections.abc import Callable, Iterable
from dataclasses import dataclass, field

import numpy as np
import pytest
import scipy
from scipy import integrate, optimize

import springpot as sp
from springpot.problem.dimensionless import Dimensionless
from springpot.simulation import Run, simulate
from springpot.simulation.plan.plan import plan_of
from springpot.theory.result import MOMENTS
from tests.simulation.problems import oscillator, truncated_gaussian

pytestmark = pytest.mark.validation

TRIALS = 200
COVERAGE = 0.95
BAND = (182, 197)  # of 200: 91 and 98.5 %


@dataclass(frozen=True)
class Problem:
    """An oscillator, what is known of it, and how it is run.

    Attributes
    ----------
    name : str
    oscillator : Oscillator
    exact : dict
        The truth by the name of the quantity; NaN if nobody knows it, and the mean of all trials stands in.
    options : dict
        Of the plain runs; none are made if it is empty.
    rtol : float
        Of the controlled runs; none are made if it is 0.
    """

    name: str
    oscillator: sp.Oscillator
    exact: dict[str, float]
    options: dict = field(repr=False)
    rtol: float = 0.0


@dataclass(frozen=True)
class Held:
    """Errors of all trials of one problem, in units of the half-width of one kind of interval.

    Attributes
    ----------
    problem : Problem
    kind : {"plain", "corrected", "total"}
    errors : ndarray, shape (TRIALS, quantities)
        In the order of ``problem.exact``.
    """

    problem: Problem
    kind: str
    errors: np.ndarray

    @property
    def inside(self) -> np.ndarray:
        return np.abs(self.errors) < 1.0

    @property
    def counts(self) -> np.ndarray:
        """Trials that held the truth, for each quantity."""
        return self.inside.sum(axis=0)


def spectrum_moments(order: float, coefficient: float, frequency: float, intensity: float) -> dict[str, float]:
    """No wall: <x^2> and <v^2> as integrals of q / (pi |Omega^2 - w^2 + C (i w)^alpha|^2) over w = e^u."""

    def power(u: float, moment: int) -> float:
        w = math.exp(u)
        return w ** (moment + 1) / abs(frequency**2 - w * w + coefficient * (1j * w) ** order) ** 2

    real = lambda w: w * w - frequency**2 - coefficient * w**order * math.cos(0.5 * math.pi * order)  # noqa: E731
    peak = math.log(optimize.brentq(real, 0.5 * frequency, 10.0 * (frequency + coefficient)))
    edges = [-30.0, -10.0, -4.0, peak - 1.0, peak, peak + 1.0, 8.0, 25.0]
    x, v = (
        sum(
            integrate.quad(power, *ends, args=(moment,), limit=400, epsabs=0.0, epsrel=1e-9)[0]
            for ends in itertools.pairwise(edges)
        )
        * intensity
        / math.pi
        for moment in (0, 2)
    )
    return {"x_mean_square": x, "v_mean_square": v, "amplitude_mean_square": x + v / frequency**2}


def from_rest(coefficient: float, frequency: float, intensity: float, time: float) -> dict[str, float]:
    """Order 1, elastic wall at the equilibrium, at rest at time 0: x is the modulus of a Gaussian variable."""
    zeta = coefficient / (2.0 * frequency)
    wd = frequency * math.sqrt(1.0 - zeta**2)
    bow = 2.0 * (zeta * frequency / wd * math.sin(wd * time)) ** 2
    double = zeta * frequency / wd * math.sin(2.0 * wd * time)
    fading = math.exp(-coefficient * time)
    x = intensity / (2.0 * coefficient * frequency**2) * (1.0 - fading * (1.0 + double + bow))
    v = intensity / (2.0 * coefficient) * (1.0 - fading * (1.0 - double + bow))
    return {
        "x_mean_end": math.sqrt(2.0 * x / math.pi),
        "x_mean_square_end": x,
        "v_mean_square_end": v,
        "amplitude_mean_square_end": x + v / frequency**2,
    }


def with_wall(
    position: float,
    coefficient: float,
    frequency: float = 1.0,
    intensity: float = 1.0,
    free_side: str = "above",
    rtol: float = 0.05,
) -> Problem:
    """Order 1, elastic wall: exact at any step, so a coarse one will do; the start is forgotten like exp(-C t)."""
    sign = 1.0 if free_side == "above" else -1.0
    exact = truncated_gaussian(sign * position, coefficient, frequency, intensity)
    exact["x_mean"] *= sign
    made = oscillator(1.0, coefficient, frequency, intensity, position, free_side=free_side)
    forget = max(coefficient / frequency**2, 1.0 / coefficient)
    begin, end = 9.0 * forget, 29.0 * forget
    step = 0.2 / plan_of(made).motion.scales.fastest_rate
    options = {"paths": 256, "duration": end, "window": (begin, end), "step": step}
    return Problem(
        f"order 1, wall {free_side} at {position:g}, C {coefficient:g}, Omega {frequency:g}, q {intensity:g}",
        made, exact, options, rtol,
    )  # fmt: skip


def without_wall(
    order: float, coefficient: float, frequency: float = 1.0, intensity: float = 1.0, rtol: float = 0.02
) -> Problem:
    """Any order, no wall: exact by quadrature of the spectrum."""
    made = oscillator(order, coefficient, frequency, intensity, None)
    forget = max(plan_of(made).motion.scales.relaxation_time, 3.0 / frequency)
    begin, end = 9.0 * forget, 29.0 * forget
    step = (0.03 if coefficient > 3.0 else 0.05) / plan_of(made).motion.scales.fastest_rate
    options = {"paths": 256, "duration": end, "window": (begin, end), "step": step}
    return Problem(
        f"order {order:g}, no wall, C {coefficient:g}, Omega {frequency:g}, q {intensity:g}",
        made, spectrum_moments(order, coefficient, frequency, intensity), options, rtol,
    )  # fmt: skip


def transient(time: float, coefficient: float, frequency: float, intensity: float) -> Problem:
    """Order 1 from rest, at one time: squares of single values are skewed, so there are more paths."""
    options = {"paths": 2048, "duration": time, "step": 0.02}
    return Problem(
        f"order 1 from rest, t {time:g}, C {coefficient:g}, Omega {frequency:g}, q {intensity:g}",
        oscillator(1.0, coefficient, frequency, intensity), from_rest(coefficient, frequency, intensity, time), options,
    )  # fmt: skip


def far_wall(order: float, coefficient: float) -> Problem:
    """A wall that is never met, with an adapted start all the same: what is owed to x(0) is in the standard errors."""
    exact = spectrum_moments(order, coefficient, 1.0, 1.0)
    position = -7.0 * math.sqrt(exact["x_mean_square"])
    made = oscillator(order, coefficient, 1.0, 1.0, position)
    return Problem(
        f"order {order:g}, adapted, wall out of reach, C {coefficient:g}",
        made, {"x_mean": 0.0, **exact}, {}, 0.05,
    )  # fmt: skip


def lossy(position: float, restitution: float, coefficient: float) -> Problem:
    """Order 1, lossy wall: known from the Fokker-Planck equation; slow impacts that steps miss are extrapolated."""
    made = oscillator(1.0, coefficient, 1.0, 1.0, position, restitution)
    found = sp.theory.fokker_planck(made)
    return Problem(
        f"order 1, wall at {position:g}, r {restitution:g}, C {coefficient:g}",
        made, {name: getattr(found, name) for name in MOMENTS}, {}, 0.05,
    )  # fmt: skip


def unknown(order: float, position: float, restitution: float) -> Problem:
    """A wall and memory: nobody knows the truth, but the spread between seeds must be what standard errors say."""
    return Problem(
        f"order {order:g}, wall at {position:g}, r {restitution:g}",
        oscillator(order, 1.0, 1.0, 1.0, position, restitution), dict.fromkeys(MOMENTS, math.nan), {}, 0.05,
    )  # fmt: skip


def problems() -> tuple[Problem, ...]:
    """All of them, made only when they are tried: their exact numbers take most of a second."""
    return (
        *(with_wall(b, 0.8, 1.3, 2.0) for b in (-1.5, -1.2, -0.9, -0.3, 0.3, 0.6, 1.5)),
        *(with_wall(b, 0.8, 1.3, 2.0, rtol=0.02) for b in (-0.6, 0.0)),
        *(with_wall(b, 0.8, 1.3, 2.0, rtol=0.0) for b in (0.9, 1.2)),
        with_wall(0.0, 0.2),
        with_wall(0.4, 0.5, 3.0, 10.0, rtol=0.0),
        with_wall(-0.4, 2.0, 1.0, 0.3),
        with_wall(-0.5, 0.3, 0.5, 0.1),
        with_wall(0.0, 5.0),
        *(with_wall(b, 5.0, rtol=0.0) for b in (-0.2, 0.2)),
        *(with_wall(b, 10.0, rtol=0.0) for b in (-0.2, 0.0, 0.2)),
        *(with_wall(b, 0.8, 1.3, 2.0, "below") for b in (0.0, 0.8)),
        with_wall(-0.8, 0.8, 1.3, 2.0, "below", rtol=0.0),
        *(transient(time, 0.5, 1.2, 1.5) for time in (0.7, 2.0, 5.0)),
        transient(3.0, 1.0, 1.0, 1.0),
        *(without_wall(*given) for given in (
            (0.05, 1.0), (0.1, 1.0), (0.1, 0.4), (0.2, 0.5), (0.3, 1.0), (0.4, 0.2), (0.5, 0.3), (0.5, 1.0), (0.6, 2.0),
            (0.7, 0.6), (0.8, 1.0), (0.9, 0.3), (0.95, 1.0), (0.9, 5.0), (0.9, 10.0), (0.4, 0.6, 2.0),
            (0.7, 0.4, 0.5, 3.0),
        )),
        *(without_wall(order, coefficient, rtol=0.05) for order, coefficient in ((0.05, 0.3), (0.5, 5.0))),
        without_wall(1.0, 10.0, rtol=0.0),
        far_wall(0.5, 1.0),
        far_wall(0.2, 0.5),
        *(lossy(*given) for given in (
            (0.0, 0.5, 0.3), (-0.5, 0.65, 0.5), (0.5, 0.8, 0.5), (0.5, 0.5, 0.3), (1.0, 0.5, 0.3),
        )),
        unknown(0.5, 0.0, 1.0),
        unknown(0.3, -0.5, 0.8),
        unknown(0.5, 0.0, 0.5),
    )  # fmt: skip


def scaled(problem: Problem, kind: str, runs: Iterable[Run], width: Callable[[Run, str], float]) -> Held:
    """Errors of the runs over their intervals' half-widths."""
    names = list(problem.exact)
    rows = np.array([[[found[name].value, width(found, name)] for name in names] for found in runs])
    truth = [rows[:, i, 0].mean() if math.isnan(problem.exact[name]) else problem.exact[name]
             for i, name in enumerate(names)]  # fmt: skip
    return Held(problem, kind, (rows[:, :, 0] - truth) / rows[:, :, 1])


def sampling(found: Run, name: str) -> float:
    return 1.959964 * found[name].error


def total(found: Run, name: str) -> float:
    return found[name].budget.total


def tried(number: int, problem: Problem) -> list[Held]:
    """All kinds of interval of one problem."""
    held = []
    if problem.options:
        seeds = range(20_000 * number, 20_000 * number + TRIALS)
        runs = [simulate(problem.oscillator, seed=seed, threads=1, **problem.options, start="rest") for seed in seeds]
        held.append(scaled(problem, "plain", runs, sampling))
    if problem.rtol > 0.0:
        seeds = range(20_000 * number + 10_000, 20_000 * number + 10_000 + TRIALS)
        runs = [simulate(problem.oscillator, seed=seed, threads=1, rtol=problem.rtol) for seed in seeds]
        known = not math.isnan(min(problem.exact.values()))
        paper = Dimensionless.of(problem.oscillator)
        elastic = paper.restitution == 1.0 and paper.barrier is not None
        if not known or (paper.springpot.order == 1.0 and elastic):
            held.append(scaled(problem, "corrected", runs, sampling))
        if known:
            held.append(scaled(problem, "total", runs, total))
    return held


@pytest.fixture(scope="module")
def study() -> list[Held]:
    found = [held for number, problem in enumerate(problems()) for held in tried(number, problem)]
    print("\n" + table(found))
    return found


def table(found: list[Held]) -> str:
    """Per cent of the trials that held the truth, each followed by the root mean square error in standard errors.

    Of total intervals: in half-widths.
    """
    lines = []
    for held in found:
        unit = 1.0 if held.kind == "total" else 1.959964
        spread = unit * np.sqrt((held.errors**2).mean(axis=0))
        numbers = " ".join(f"{100.0 * n / TRIALS:5.1f} ({s:.2f})" for n, s in zip(held.counts, spread, strict=True))
        lines.append(f"{held.problem.name:<56} {held.kind:<9} {numbers}   {', '.join(held.problem.exact)}")
    return "\n".join(lines)


def pooled(found: list[Held]) -> tuple[float, float]:
    """Coverage of all trials together and its standard error; quantities of a trial may be correlated."""
    size = sum(held.inside.size for held in found)
    variance = sum(TRIALS * held.inside.sum(axis=1).var(ddof=1) for held in found)
    return sum(int(held.counts.sum()) for held in found) / size, math.sqrt(variance) / size


def widest(pairs: int) -> tuple[int, int]:
    """Least and greatest count that a pair may have: all of ``pairs`` are within with probability 0.99 at least."""
    law = scipy.stats.binom(TRIALS, COVERAGE)
    each = 0.01 / pairs
    low = next(k for k in range(TRIALS) if law.cdf(k) > 0.5 * each)
    left = each - law.cdf(low - 1)
    return low, next(k for k in range(TRIALS + 1) if law.sf(k) <= left)


def most_outside(found: list[Held]) -> int:
    """Problems that may have a quantity outside the band: more of them are less likely than 0.001."""
    law = scipy.stats.binom(TRIALS, COVERAGE)
    alone = law.cdf(BAND[0] - 1) + law.sf(BAND[1])
    chances = np.array([1.0])
    for held in found:
        chance = min(1.0, alone * held.counts.size)  # at most, whatever their correlation
        chances = np.convolve(chances, [1.0 - chance, chance])
    return int(np.searchsorted(np.cumsum(chances), 0.999))


def outside(held: Held) -> bool:
    return bool(((held.counts < BAND[0]) | (held.counts > BAND[1])).any())


def test_the_limits_are_what_they_are_said_to_be() -> None:
    law = scipy.stats.binom(TRIALS, COVERAGE)
    assert law.cdf(BAND[1]) - law.cdf(BAND[0] - 1) == pytest.approx(0.992, abs=5e-4)
    low, high = widest(300)
    assert law.cdf(low - 1) + law.sf(high) < 0.01 / 300
    assert (low, high) == (175, 200)


@pytest.mark.parametrize("kinds", [("plain",), ("corrected",), ("plain", "corrected")])
def test_standard_errors_hold_the_truth_in_95_per_cent(study: list[Held], kinds: tuple[str, ...]) -> None:
    found = [held for held in study if held.kind in kinds]
    share, error = pooled(found)
    low, high = widest(sum(held.counts.size for held in found))
    strange = [held for held in found if outside(held)]
    print(f"{kinds}: {100 * share:.2f} +- {100 * error:.2f} %, outside {len(strange)}, {most_outside(found)} allowed")
    assert abs(share - COVERAGE) < 3.0 * error
    for held in found:
        assert low <= held.counts.min() <= held.counts.max() <= high, held.problem.name
    assert len(strange) <= most_outside(found), table(strange)


def test_total_intervals_hold_the_truth_in_95_per_cent_or_more(study: list[Held]) -> None:
    found = [held for held in study if held.kind == "total"]
    share, error = pooled(found)
    print(f"total: {100 * share:.2f} +- {100 * error:.2f} %")
    assert share > COVERAGE
    for held in found:
        assert held.counts.min() >= 0.93 * TRIALS, table([held])
