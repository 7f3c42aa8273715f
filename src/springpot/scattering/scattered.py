"""`scatter`: the results of many devices, and which of their numbers matter."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from typing import Any

import numpy as np

from springpot.machine.arguments import Uncertain, check_called, finite_number, finite_numbers
from springpot.machine.arrays import Floats
from springpot.machine.faults import NotCoveredError, known_word, shown
from springpot.machine.progress import counted
from springpot.problem.free_numbers import nominal, uncertain_numbers
from springpot.problem.system import System, checked_system
from springpot.problem.uncertain import Bounded, Measured
from springpot.scattering.devices import (
    Correlation,
    correlated,
    drawn,
    linear_names,
    plan_of_all,
    scrambled,
    simulations_of,
    systems_of,
    values_of,
)
from springpot.scattering.estimates import PREDICTED, SHARES, Estimates, Means, estimated
from springpot.scattering.result import Scatter
from springpot.simulation.estimate.stationary_start import adapt
from springpot.simulation.kernel.sizes import LANES
from springpot.simulation.monte_carlo import simulated
from springpot.simulation.paths.simulation import Progress, Simulation, simulation_of
from springpot.simulation.paths.together import alike
from springpot.simulation.plan.plan import plan_of
from springpot.simulation.plan.settings import Settings, checked_seed, checked_threads, whole_number
from springpot.simulation.result.results import Estimate, estimates_from
from springpot.theory.registry import METHODS
from springpot.theory.result import names_of_results
from springpot.theory.solve import solve_one

MONTE_CARLO = "monte_carlo"
MOST_INPUTS = 12
FEWEST = 0.005  # share of the devices whose quantile is estimated
_FEWEST_DEVICES, _MOST_DEVICES, _FEW_DEVICES = 64, 2**16, 256
_MOST_PATHS = 4096
_USUAL_PATHS = 8
_SHARE_OF_THE_NOMINAL = 8  # of all paths, one in so many is of the nominal device
_LEFT = 0.1  # share of the variance that a surface leaves from which on it is said
_SAID_CUT, _FEW_VALUES = 1e-6, 20
_MOST_NUMBERS = 2e8  # sums of all paths


def scatter(
    system: System, quantities: Sequence[str] | None = None, *, devices: int = 1024, paths: int | None = None,
    duration: float | None = None, step: float | None = None, window: tuple[float, float] | None = None,
    limits: Mapping[str, float] | None = None, quantiles: Sequence[float] = SHARES,
    correlation: Mapping[tuple[str, str], float] | None = None,
    method: str = MONTE_CARLO, seed: int = 1, threads: int | None = None, progress: Progress | None = None,
) -> Scatter:  # fmt: skip
    """How results differ from device to device, and which uncertain numbers matter.

    Devices are drawn from the laws of the uncertain numbers, by 16 independent scramblings of Sobol's sequence, and a
    few paths of each are simulated.  What differs between devices is told apart from what differs between paths.

    Parameters
    ----------
    system : System
        With numbers that are marked by `springpot.uncertain`, at most 12.
    quantities : sequence of str, optional
        Names of results; if left out, all that are means over the paths.  Impact speeds, which are ratios of two means,
        are not among them.
    devices : int
        A power of two, 64 or more.
    paths : int, optional
        Of each device: a power of two, 2 or more; 8 if left out.  The scatter is known best with 1 + (variance from
        path to path) / (variance from device to device), and 4 to 8 are usual.  Devices that differ in a rate of their
        memory (Maxwell arms, circuits) or in the exponent of a law need 64 or more, which they have if left out.
    duration, step, window : optional
        As in `springpot.simulate`, the same for all devices.  If left out, the step is the shortest that one of 64
        devices would have, and the duration the longest.
    limits : mapping of str to float, optional
        For each of some quantities a limit: the share of the devices above it is estimated.
    quantiles : sequence of float
        Shares of the devices, from 0.005 to 0.995: below which numbers they are is estimated.
    correlation : mapping of (str, str) to float, optional
        Of pairs of uncertain numbers: the correlation of their normal scores, a Gaussian copula.  Spearman's is
        6 / pi asin(r / 2).  Numbers that depend on each other are one input with one index.
    method : str
        "monte_carlo", or the name of a method of theory, such as ``"linear"`` or ``"envelope"``: then nothing is
        simulated, and a result is what the method says of each device.
    seed, threads : optional
        As in `springpot.simulate`; the same seed gives the same bits for any number of threads.
    progress : callable, optional
        Called with the fraction done, from any thread.

    Returns
    -------
    Scatter
        ``print`` shows it on a screen.

    Raises
    ------
    TypeError, ValueError
        If an argument is wrong, no number is uncertain, or a device cannot be simulated.

    Notes
    -----
    All intervals hold with 95 %, by a jackknife over the scramblings.  Quantiles, limits and Sobol indices come from a
    polynomial of the uncertain numbers through the means of the devices [1]_, whose noise is taken out; what it leaves
    is said.  It needs results that depend smoothly on the numbers.

    One start serves all devices, the stationary mean of the nominal one: what this does to a device fades like the
    memory of any start.

    References
    ----------
    .. [1] B. Sudret, "Global sensitivity analysis using polynomial chaos expansions", Reliability Engineering and
       System Safety 93, 2008.

    Examples
    --------
    >>> import springpot as sp
    >>> device = sp.System(
    ...     sp.Mass(0.8), sp.Spring(sp.uncertain("k", 3200.0, cov=0.05)), sp.Dashpot(sp.uncertain("c", 20.0, cov=0.3)),
    ...     sp.WhiteNoise.from_psd(0.01, "g2/Hz"),
    ... )
    >>> found = sp.scatter(device, ["x_mean_square"], devices=64, duration=20.0)
    >>> estimates = found["x_mean_square"]
    >>> estimates.alone["c"].value > estimates.alone["k"].value
    True
    """
    numbers = check_numbers(uncertain_numbers(checked_system(system)), "system")
    check_stops(system)
    known_word(method, [MONTE_CARLO, *METHODS], "method")
    _check_power_of_two(devices, "devices", _FEWEST_DEVICES, _MOST_DEVICES)
    if paths is not None:
        _check_power_of_two(paths, "paths", 2, _MOST_PATHS)
    shares = finite_numbers(quantiles, "quantiles", "quantiles", low=FEWEST, high=1.0 - FEWEST).ravel().tolist()
    check_called(progress, "progress")
    seed, threads = checked_seed(seed), checked_threads(threads)
    together, told = correlated(correlation or {}, numbers), shares_of_progress(progress)
    draws = drawn(numbers, devices, seed, together)
    middle, all_systems = nominal(system), partial(systems_of, system, [*numbers], draws.values)
    asked = partial(_asked, quantities, limits)
    if method == MONTE_CARLO:
        given = {"duration": duration, "step": step, "window": window, "seed": seed, "threads": threads}
        given = {name: value for name, value in given.items() if value is not None}
        results = _by_monte_carlo(middle, devices, all_systems, asked, paths, told, given)
    else:
        results = _by_theory(middle, all_systems, asked, method, told(0.0, 0.9))
    groups, (scores, normal, new, beside) = together.groups, _scores(numbers, together, draws.chances, seed)
    inputs = together.inputs(numbers)
    found = dict[str, Estimates]()
    for name, values in counted(results.values.items(), told(0.9, 0.1)):
        means = Means(scores, normal, values, new, beside)
        found[name] = estimated(means, inputs, groups, results.limits.get(name, ()), shares)
    return Scatter(
        system=system, method=method, settings=results.settings, numbers=tuple(numbers), inputs=inputs,
        draws=draws.values, paths=results.paths, estimates=found,
        means={name: values.mean(axis=1) for name, values in results.values.items()}, nominal=results.nominal,
        warnings=(*_doubts(numbers, devices, found), *(f"of the nominal device: {each}" for each in results.warnings)),
    )  # fmt: skip


@dataclass(frozen=True, eq=False)
class _Results:
    """Of all devices, shape (devices, paths) by name, and of the nominal one; limits by name."""

    values: dict[str, Floats]
    nominal: dict[str, Estimate]
    limits: dict[str, tuple[float, ...]]
    warnings: Sequence[str]
    settings: Settings | None = None
    paths: int = 0


Asked = Callable[[Sequence[str]], tuple[list[str], dict[str, tuple[float, ...]]]]
Devices = Callable[[Progress | None], list[System]]


def _by_monte_carlo(
    middle: System, devices: int, systems: Devices, asked: Asked, paths: int | None,
    told: Callable[[float, float], Progress | None], given: dict[str, Any],
) -> _Results:  # fmt: skip
    given = {**given, "paths": paths or _USUAL_PATHS}
    first = plan_of(middle, **given)
    alone = simulation_of(adapt(first, paths=LANES))  # before all devices are made, which takes long
    names, limits = asked(linear_names(alone))
    _check_room(devices, alone)
    whole, plans = plan_of_all(first, systems(told(0.0, 0.1)), given, told(0.1, 0.1))
    simulations = simulations_of(plans, whole, told(0.2, 0.1))
    if paths is None and not alike([each.parts.tables for each in simulations]):
        simulations = [each.but(paths=LANES) for each in simulations]
        _check_room(devices, simulations[0])
    values, settings = values_of(simulations, names, told(0.3, 0.5)), simulations[0].settings
    run = simulated(
        middle, paths=max(devices * settings.paths // _SHARE_OF_THE_NOMINAL, LANES), duration=settings.duration,
        step=settings.step, window=settings.window, seed=settings.seed, threads=settings.threads,
        progress=told(0.8, 0.1),
    )  # fmt: skip
    return _Results(values, {name: run[name] for name in names}, limits, run.warnings, whole.settings, settings.paths)


def _check_room(devices: int, one: Simulation) -> None:
    paths, columns = one.settings.paths, len(one.parts.columns)
    if (count := devices * paths * columns) > _MOST_NUMBERS:
        raise ValueError(
            f"devices and paths must be fewer: {devices} devices of {paths} paths need {count:.2g} sums, and at most "
            f"{_MOST_NUMBERS:.0e} are kept."
        )


def _by_theory(
    middle: System, systems: Devices, asked: Asked, method: str, progress: Progress | None
) -> _Results:  # fmt: skip
    result, why = solve_one(middle, method)
    if result is None:
        raise NotCoveredError(f"method must cover the system, and {method} does not: {why}")
    moments = {name: result.moments[name] for name in names_of_results(middle)}
    names, limits = asked([name for name, value in moments.items() if math.isfinite(value)])
    rows = []
    for device in counted(systems(None), progress):
        own, why = solve_one(device, method)
        if own is None:
            raise NotCoveredError(f"method must cover all devices, and {method} does not cover one of them: {why}")
        rows.append([own.moments[name] for name in names])
    values = np.array(rows)
    nominal_values = estimates_from(middle, {name: moments[name] for name in names}, dict.fromkeys(names, 0.0))
    found = {name: values[:, n : n + 1] for n, name in enumerate(names)}
    return _Results(found, nominal_values, limits, result.warnings)


def _asked(quantities: Any, limits: Any, known: Sequence[str]) -> tuple[list[str], dict[str, tuple[float, ...]]]:
    """The results, and limits by name, of those that are known."""
    names = _quantities(quantities, known)
    bounds = checked_limits(limits, known, "names and numbers, such as {'impact_rate': 3.0}")
    return [*dict.fromkeys([*names, *bounds])], {name: (limit,) for name, limit in bounds.items()}


def check_numbers(numbers: dict[str, Uncertain], where: str) -> dict[str, Uncertain]:
    """The uncertain numbers, if there are neither none nor too many."""
    if not numbers:
        raise ValueError(
            f'{where} must have uncertain numbers, such as sp.Spring(sp.uncertain("k", 3200.0, cov=0.05)).'
        )
    if len(numbers) > MOST_INPUTS:
        raise ValueError(f"{where} must have at most {MOST_INPUTS} uncertain numbers, not {len(numbers)}.")
    return numbers


def check_stops(system: System) -> None:
    """Raise an error if a gap may become negative, where a stop presses the mass in place of standing off."""
    for stop in system.stops.values():
        position: Any = stop.position
        if isinstance(position, Uncertain) and position.low < 0.0 < position.high and float(position) != 0.0:
            below = float(position.law.cdf((-position.plus / position.times) ** (1.0 / position.power)))
            beyond = min(below, 1.0 - below)
            if beyond > _SAID_CUT:
                raise ValueError(
                    f"position must keep its sign in all devices, but {100.0 * beyond:.2g} % of the law of "
                    f"{position.name} are beyond 0, where the stop presses the mass: give bounds."
                )


def _check_power_of_two(given: Any, name: str, low: int, high: int) -> None:
    number = whole_number(given, name, low, high)
    if number & (number - 1):
        raise ValueError(f"{name} must be a power of two, not {number}: {2 ** (number.bit_length() - 1)} is one.")


def _quantities(given: Any, known: Sequence[str]) -> list[str]:
    if given is None:
        return [*known]
    if isinstance(given, str) or not isinstance(given, Sequence) or not given:
        raise TypeError(f"quantities must be a list of names, not {shown(given)}.")
    return [*dict.fromkeys(known_word(name, known, "quantities", "must be of") for name in given)]


def checked_limits(given: Any, known: Sequence[str], words: str, **allowed: Any) -> dict[str, float]:
    """A limit for some of the known names, within the range that `finite_number` is told."""
    if given is None:
        return {}
    if not isinstance(given, Mapping):
        raise TypeError(f"limits must be a dict of {words}, not {shown(given)}.")
    for name, limit in given.items():
        known_word(name, known, "limits", "must be of")
        finite_number(limit, f"limits of {name}", **allowed)
    return {name: float(limit) for name, limit in given.items()}


def shares_of_progress(progress: Progress | None) -> Callable[[float, float], Progress | None]:
    """What tells a share of the progress, from where on."""

    def told(begin: float, share: float) -> Progress | None:
        return None if progress is None else lambda fraction: progress(begin + share * fraction)

    return told


def _scores(
    numbers: Mapping[str, Uncertain], together: Correlation, chances: Floats, seed: int
) -> tuple[Floats, tuple[bool, ...], Floats, Floats]:
    """Of the draws, of which numbers they are normal, of other devices, and of what surfaces leave in these."""
    from scipy.special import ndtri

    new = scrambled(len(numbers) + 1, PREDICTED, np.random.default_rng([seed, 0x5CA8]))
    normal = tuple(tied or number.law.is_gaussian for tied, number in zip(together.tied, numbers.values(), strict=True))
    at, later = (np.where(normal, ndtri(own[:, : len(normal)]), own[:, : len(normal)]) for own in (chances, new))
    return at, normal, later, ndtri(new[:, -1])


def doubts_of_laws(numbers: Mapping[str, Uncertain]) -> list[str]:
    """What the laws of the numbers leave out."""
    said = []
    for name, number in numbers.items():
        if isinstance(number.law, Measured) and len(number.law.values) < _FEW_VALUES:
            count = len(number.law.values)
            said.append(f"{name}: the law of {count} measured values has no tails, and scatters less than they do.")
        if isinstance(number.law, Bounded) and number.law.cut > _SAID_CUT:
            mean = float(np.mean(number.law.ppf((np.arange(4096) + 0.5) / 4096)))
            said.append(
                f"bounds leave out {100.0 * number.law.cut:.2g} % of the law of {name}, whose mean is then {mean:.5g}."
            )
    return said


def _doubts(numbers: Mapping[str, Uncertain], devices: int, found: Mapping[str, Estimates]) -> list[str]:
    said = doubts_of_laws(numbers)
    if devices < _FEW_DEVICES:
        said.append(f"intervals from {devices} devices are rough: use {_FEW_DEVICES} or more.")
    for name, own in found.items():
        if own.unexplained.low > _LEFT:
            said.append(
                f"{name}: the polynomial leaves {100.0 * own.unexplained.value:.2g} % of the variance between devices: "
                "indices hold for the rest, and quantiles and limits are rough."
            )
        if own.scatter.value == 0.0:
            said.append(f"{name}: no scatter is seen; it is below {own.scatter.high:.3g}, with 95 %.")
    return said
