"""`fragility`: the probability that a limit is exceeded, against the intensity of the excitation."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from typing import Any, Literal, get_args

import numpy as np
from numpy.typing import ArrayLike

from springpot.machine.arguments import LARGEST, check_called, finite_number, finite_numbers, one_of
from springpot.machine.arrays import Floats
from springpot.machine.faults import listed, shown
from springpot.machine.progress import counted
from springpot.problem.parts import RecordedExcitation
from springpot.problem.system import System, checked_system
from springpot.simulation.paths.simulation import Progress
from springpot.simulation.plan.motions import motion_of
from springpot.simulation.plan.settings import checked_seed, checked_threads, whole_number
from springpot.simulation.rare.exceedance import exceeded
from springpot.spectra.curves import Fragility, FragilityCurve
from springpot.spectra.largest import Largest, check_outputs, largest_values, of_each, unit_of_output
from springpot.spectra.lognormal import Fit, fit_brackets, fit_cloud, fit_counts, fit_probabilities
from springpot.spectra.response import response_spectrum

Method = Literal["plain", "splitting"]
_SIZES = {"displacement": "distance", "velocity": "speed"}
"""The names in `springpot.exceedance` of what has two sides."""
_CURVED, _UNLIKELY = 3.0, 1e-3
_FEWEST, _FEWEST_RARE = 5, 2  # records of a cloud, and intensities with a rare probability
_USUAL_PATHS = 256
_USUAL_RTOL = {"plain": 0.005, "splitting": 0.2}
_TAIL = 2.0  # periods after the last point of a record
_NORMAL = 1.959964


def fragility(
    system: System | Callable[[float], System], limits: Mapping[str, Any], intensities: ArrayLike | None = None, *,
    measure: Any = None, method: Method = "plain", duration: float | None = None, paths: int | None = None,
    rtol: float | None = None, step: float | None = None, seed: int = 1, threads: int | None = None,
    progress: Progress | None = None,
) -> Fragility:  # fmt: skip
    """The probability that an output exceeds a limit, against the intensity: a lognormal law with intervals.

    Parameters
    ----------
    system : System or callable
        A system with one `RecordedExcitation`, whose records are scaled.  Or a function of the intensity that returns
        the system, such as ``lambda rms: sp.System(..., sp.KanaiTajimiNoise.from_rms(rms, "g", ...))``.
    limits : dict
        Outputs as in `springpot.response_spectrum`, each with a limit or a list of them, such as
        ``{"displacement": [0.02, 0.05], "impact_speed": 0.3}``.  Displacements and elongations count on both sides;
        for one side alone, limit the impact speed on a stop there.
    intensities : array_like, optional
        Multiple stripes: all records are scaled to each of these, in m/s^2 (of forces in N) or the unit of ``measure``.
        If left out, each record is taken as it is, a cloud.
    measure : optional
        Of the intensity of a record: ``"peak"``, its largest size, which it is if left out; a pair of a period in s and
        a damping ratio, its pseudo-acceleration there; or a list of numbers, one for each record.
    method : {"plain", "splitting"}
        ``"splitting"``: the probabilities of noise by `springpot.exceedance`, also those far below one in the number of
        paths; outputs are then those of its ``levels``, with ``"displacement"`` for ``"distance"``.
    duration : float, optional
        Of noise without an envelope, in s.
    paths : int, optional
        Of noise, at each intensity; 256 if left out.
    rtol : float, optional
        As in `springpot.response_spectrum`, 0.005; of splitting as in `springpot.exceedance`, 0.2.
    step, seed, threads, progress : optional
        As in `springpot.response_spectrum`.

    Returns
    -------
    Fragility
        ``found["displacement"]`` has ``median`` and ``dispersion`` with their intervals; of a list of limits
        ``found["displacement > 0.02"]``.

    Raises
    ------
    TypeError, ValueError
        If an argument is wrong, or the records exceed a limit at no or at all intensities.

    Notes
    -----
    A record that is scaled from stripe to stripe has one capacity.  So stripes of records are fitted by the intensities
    between which the capacity of each record lies, not by counts as if they were independent: 95 % intervals from
    counts of the same 10 to 40 records at 8 stripes held the median in 72 to 80 of 100 cases only.  A record that
    exceeds the limit at one intensity and not at a larger one has its capacity below the first.  Stripes of noise have
    paths of their own, and are fitted by their counts.  A cloud is fitted by a straight line through the logarithms of
    demand and intensity, with normal deviations of one size; a warning says where it is curved, as behind a stop.

    Intervals are those of the profiles of the likelihood.

    Examples
    --------
    >>> import springpot as sp
    >>> device = lambda rms: sp.System(
    ...     sp.Mass(1.0), sp.Spring(400.0), sp.Dashpot(2.0), sp.WhiteNoise((0.01 * rms) ** 2, on="ground")
    ... )
    >>> found = sp.fragility(device, {"displacement": 0.012}, [10.0, 14.0, 18.0, 25.0], duration=20.0, paths=64)
    >>> curve = found["displacement"]
    >>> bool(curve.median.low < curve.median.value < curve.median.high)
    True
    """
    wanted = _limits(limits)
    one_of(method, "method", get_args(Method))
    check_called(progress, "progress")
    seed, threads = checked_seed(seed), checked_threads(threads)
    rtol = finite_number(_USUAL_RTOL[method] if rtol is None else rtol, "rtol", low=1e-5, high=1.0)
    if paths is not None:
        paths = whole_number(paths, "paths", 2, 10**7)
    own = None
    if intensities is not None:
        own = np.unique(finite_numbers(intensities, "intensities", "intensity", low=0.0, open_low=True))
    elif callable(system):
        raise ValueError("intensities must be given where system is a function of the intensity.")
    if callable(system):
        if measure is not None:
            raise ValueError("measure must be left out where system is a function of the intensity.")
        assert own is not None
        systems = [checked_system(system(float(each)), f"system({each:g})") for each in own]
        size = None
    else:
        records = [*checked_system(system).records.items()]
        if len(records) != 1:
            raise ValueError(
                "system must have one recorded excitation, whose records are scaled, or be a function of the "
                "intensity, such as lambda rms: sp.System(..., sp.KanaiTajimiNoise.from_rms(rms, 'g', ...))."
            )
        [(name, record)] = records
        if own is not None and record.count < 2:
            raise ValueError("system must have two or more records: one has a capacity, and no dispersion.")
        size = _sizes(record, measure)
        factors = [np.ones(size.size)] if own is None else [each / size for each in own]
        systems = [_scaled(system, name, record, each) for each in factors]
    motion = motion_of(systems[0])
    if motion.is_random and size is not None:
        raise ValueError("system must be a function of the intensity where there is noise beside the records.")
    if not motion.recorded and duration is None:
        raise ValueError("duration must be given for noise that does not end.")
    if duration is not None:
        duration = finite_number(duration, "duration", low=0.0, open_low=True, hint="It is in s.")
    common = {"duration": duration, "step": step, "seed": seed, "threads": threads}
    if method == "splitting":
        if not motion.is_random or own is None:
            raise ValueError("method must be 'plain' where nothing is by chance.")
        return _by_splitting(systems, wanted, own, rtol, {**common, "duration": duration or motion.recorded}, progress)
    check_outputs(motion, [*wanted], "limits")
    found = _demands(systems, [*wanted], rtol, paths or _USUAL_PATHS if motion.is_random else None, common, progress)

    def curve(label: str, word: str, limit: float) -> tuple[FragilityCurve, list[str]]:
        demands, said = found.values[word], list[str]()
        over, stripes = demands > limit, np.zeros(0) if own is None else own
        places = np.repeat(stripes[:, None], demands.shape[1], axis=1)
        exceeded = over.sum(axis=1) if own is not None else np.zeros(0, int)
        tried = np.full(exceeded.size, over.shape[1])
        if own is None:
            assert size is not None
            places, kind = size[None, :], "cloud"
            cloud = demands[0]
            if cloud.size < _FEWEST:
                raise ValueError(f"intensities must be given for {cloud.size} records: a cloud has {_FEWEST} or more.")
            if zeros := int((cloud == 0.0).sum()):
                raise ValueError(
                    f"intensities must be given for {word}, which is 0 in {zeros} of the records: a cloud needs its "
                    "logarithm."
                )
            fit, _, curved = fit_cloud(size, cloud, limit)
            if curved > _CURVED:  # by so many standard errors
                said.append(f"{word} is no power of the intensity in this cloud: scale the records to intensities=.")
        elif motion.is_random:
            fit, kind = fit_counts(own, exceeded.astype(float), tried.astype(float)), "counts"
        else:
            fit, kind = _fit_of_capacities(own, over), "capacities"
        unit = unit_of_output(systems[0], word)
        return FragilityCurve(
            label, word, limit, unit, kind, fit, stripes, exceeded=exceeded, tried=tried, places=places, demands=demands
        ), said

    curves, warnings = _curves(wanted, curve)
    return Fragility(curves, own, "plain", (*found.warnings, *warnings))


def _curves(
    wanted: Mapping[str, Sequence[float]], make: Callable[[str, str, float], tuple[FragilityCurve, list[str]]]
) -> tuple[dict[str, FragilityCurve], list[str]]:
    """Those that there are, and what is to be said; an error if there is none.

    The intervals take a lognormal law for granted, so points that do not follow one are said.
    """
    curves, warnings, faults = dict[str, FragilityCurve](), list[str](), list[ValueError]()
    for word, limits in wanted.items():
        for limit in limits:
            label = word if len(limits) == 1 else f"{word} > {limit:g}"
            try:
                curves[label], said = make(label, word, limit)
            except ValueError as fault:
                faults.append(fault)
                warnings.append(f"{label} has no curve: {fault}")
                continue
            if curves[label].fit.chance < _UNLIKELY:
                said.append(
                    f"{label} does not follow a lognormal law over these intensities (a chance of "
                    f"{curves[label].fit.chance:.1g}): fit fewer of them, near the probability that matters."
                )
            warnings += said
    if not curves:
        raise faults[0]
    return curves, warnings


def _limits(given: Any) -> dict[str, list[float]]:
    if not isinstance(given, Mapping) or not given:
        raise TypeError(
            f"limits must be a dict of outputs and limits, such as {{'displacement': 0.05}}, not {shown(given)}."
        )
    found = dict[str, list[float]]()
    for name, each in given.items():
        own = finite_numbers(each, f"limits of {name}", f"limit of {name}", low=0.0, high=LARGEST, open_low=True)
        found[name] = own.ravel().tolist()
    return found


def _sizes(record: RecordedExcitation, measure: Any) -> Floats:
    """The intensity of each record."""
    if measure is None or (isinstance(measure, str) and measure == "peak"):
        return np.array([record.scale * max(map(abs, values)) for _, values in record.records])
    if isinstance(measure, tuple) and len(measure) == 2:
        found = response_spectrum(record, [measure[0]], damping=measure[1], output="pseudo_acceleration")
        return np.asarray(found["pseudo_acceleration"].values[0])
    if isinstance(measure, str):
        raise ValueError(
            f"measure must be 'peak', a pair (period, damping ratio) or a list of numbers, not {measure!r}."
        )
    own = finite_numbers(measure, "measure", "measure", low=0.0, open_low=True).ravel()
    if own.size != record.count:
        raise ValueError(f"measure must have a number for each of {record.count} records, not {own.size}.")
    return own


def _scaled(system: System, name: str, record: RecordedExcitation, factors: Floats) -> System:
    """Each record times its factor, all in turn."""
    own = tuple(
        tuple((factor * np.array(values)).tolist()) for factor, (_, values) in zip(factors, record.records, strict=True)
    )
    values: Any = own if record.count > 1 else own[0]
    return system.but(**{name: replace(record, values=values, taken="in turn")})


def _demands(
    systems: Sequence[System], words: Sequence[str], rtol: float, paths: int | None, common: dict[str, Any],
    progress: Progress | None,
) -> Largest:  # fmt: skip
    """Of each intensity and path."""
    seed, threads = common["seed"], common["threads"]
    motions = [motion_of(each) for each in systems]

    def one(number: int) -> Any:
        motion = motions[number]
        tail = _TAIL * 2.0 * math.pi / motion.scales.frequency if motion.recorded else 0.0
        return largest_values(
            systems[number], words, tail=tail, duration=None if motion.recorded else common["duration"],
            paths=paths or motion.different_paths, rtol=rtol, step=common["step"], seed=seed + number, threads=1,
            argument="limits",
        )  # fmt: skip

    return Largest.of_all(of_each(one, len(systems), threads, progress), rtol, "demands")


def _fit_of_capacities(intensities: Floats, over: Any) -> Fit:
    """Of the same records at all intensities: each has its capacity below the first at which it exceeds the limit."""
    first = np.where(over.any(axis=0), over.argmax(axis=0), intensities.size)
    ends = np.concatenate([[0.0], intensities, [math.inf]])
    return fit_brackets(ends[first], ends[first + 1])


def _by_splitting(
    systems: Sequence[System], wanted: Mapping[str, Sequence[float]], intensities: Floats, rtol: float,
    common: dict[str, Any], progress: Progress | None,
) -> Fragility:  # fmt: skip
    """Each intensity has the probabilities of `springpot.exceedance`, with independent errors."""
    names = {_SIZES.get(word, word): np.array(sorted(limits)) for word, limits in wanted.items()}
    found = []
    for number, system in enumerate(counted(systems, progress)):
        own = {**common, "seed": common["seed"] + number}
        found.append(exceeded(system, names, rtol=rtol, progress=None, **own))

    def curve(label: str, word: str, limit: float) -> tuple[FragilityCurve, list[str]]:
        name, place, said = _SIZES.get(word, word), sorted(wanted[word]).index(limit), list[str]()
        p, low, high, error = (
            np.array([getattr(each[name], of)[place] for each in found])
            for of in ("probability", "low", "high", "error")
        )
        known = (p > 0.0) & (p < 1.0) & (error > 0.0)
        if known.sum() < _FEWEST_RARE:
            raise ValueError(f"intensities must have two or more at which {label} is exceeded, and not always.")
        if not known.all():
            some = listed([f"{each:g}" for each in intensities[~known]])
            said.append(f"{label} is exceeded never or always at the intensity {some}, which is left out of its fit.")
        errors = np.log(high[known] / low[known]) / (2.0 * _NORMAL)
        fit = fit_probabilities(intensities[known], np.log(p[known]), np.maximum(errors, 1e-9))
        unit, shares = unit_of_output(systems[0], word), np.stack([p, low, high])
        return FragilityCurve(label, word, limit, unit, "splitting", fit, intensities, known=shares), said

    curves, warnings = _curves(wanted, curve)
    warnings += [str(sentence) for each in found for sentence in each.warnings]
    return Fragility(curves, intensities, "splitting", tuple(dict.fromkeys(warnings)))
