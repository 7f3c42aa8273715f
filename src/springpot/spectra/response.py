"""`response_spectrum`: the largest values of many systems under one excitation, against their period."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace
from typing import Any, get_args

import numpy as np
from numpy.typing import ArrayLike

from springpot.machine.arguments import check_called, finite_number, finite_numbers, one_of
from springpot.machine.arrays import Floats
from springpot.machine.faults import shown
from springpot.problem.parts import Dashpot, Mass, RecordedExcitation, Spring
from springpot.problem.parts.excitations import Excitation
from springpot.problem.system import System
from springpot.simulation.paths.simulation import Progress
from springpot.simulation.plan.motions import motion_of
from springpot.simulation.plan.settings import checked_seed, checked_threads, whole_number
from springpot.spectra import recursion, stationary
from springpot.spectra.largest import Largest, check_outputs, largest_values, of_each, unit_of_output
from springpot.spectra.recursion import Kind
from springpot.spectra.spectrum import ResponseSpectrum, Spectrum
from springpot.spectra.templates import USUAL_DAMPING, Template, systems_of

SHARES = 0.16, 0.5, 0.84
_USUAL = "displacement", "pseudo_acceleration", "acceleration"
_PSEUDO = {"pseudo_acceleration": 2, "pseudo_velocity": 1}
"""Displacements times so many powers of the frequency."""
_USUAL_PATHS = 256
_TAIL = 2.0  # periods after the last point of a record, where the kernel has to find the largest values
_MOST_PERIODS = 10_000
_CHANCE = 0.025  # on either side of a 95 % interval


def response_spectrum(
    excitation: Excitation, periods: ArrayLike, system: Template = None, *, output: str | Sequence[str] = _USUAL,
    damping: float | None = None, varied: str | Sequence[str] | None = None, kind: Kind = "maximax",
    duration: float | None = None, quantiles: Sequence[float] = SHARES, paths: int | None = None, rtol: float = 0.005,
    step: float | None = None, seed: int = 1, threads: int | None = None, progress: Progress | None = None,
) -> ResponseSpectrum:  # fmt: skip
    """The response spectrum of records or noise: the largest values of many systems, one for each period.

    One mass on a spring and a dashpot is solved exactly, with straight lines between the points of a record.  With
    stops, springpots, parts that yield or several masses the compiled kernel simulates each system.

    Parameters
    ----------
    excitation : RecordedExcitation or another excitation
        Records, each with a spectrum of its own; or noise.
    periods : array_like
        In s: 2 pi over the natural frequency.  For frequencies f in Hz, as shock spectra have them, 1 / f.
    system : System or callable, optional
        The template, without this excitation: one of its springs is varied until the slowest mode has the period.  Or a
        function of the period in s that returns the system.  If left out, one mass of 1 kg on a spring and a dashpot.
    output : str or sequence of str
        Of one mass ``"displacement"``, ``"velocity"``, ``"acceleration"`` (absolute, that of the ground included),
        ``"pseudo_velocity"`` and ``"pseudo_acceleration"``: the displacement times the frequency, or its square; and
        ``"impact_speed"``.  Forces and impulses have the names of ``forces`` in `springpot.simulate`, such as
        ``"stop_peak_force"``; of several masses there are ``"box_x"``, ``"box_v"``, ``"box_acceleration"``,
        ``"stop_impact_speed"``.  It is always the largest size, of either sign.
    damping : float, optional
        Ratio of a dashpot beside the varied spring; 0.05 without a template, and no dashpot with one if left out.
    varied : str or sequence of str, optional
        The springs, or parts that yield, whose stiffness is varied, all by one factor.  The only spring if left out.
    kind : {"maximax", "primary", "residual"}
        Which times count, of records: all, those until the last point, or those after it.
    duration : float, optional
        Of noise without an envelope, in s.
    quantiles : sequence of float
        Shares, between 0 and 1, of the records or paths below them.
    paths : int, optional
        Of noise: Monte Carlo with so many paths.  If left out, theory where it covers the system, else 256 paths.
    rtol : float
        Where the kernel simulates records: the step is halved until the largest values change by less than this.
    step : float, optional
        Of the kernel, in s; of records it is not halved then.
    seed, threads : optional
        As in `springpot.simulate`.
    progress : callable, optional
        Called with the fraction done, from any thread.

    Returns
    -------
    ResponseSpectrum
        ``found["acceleration"].values`` has the shape (periods, records).  Printed, it is a table.

    Raises
    ------
    TypeError, ValueError
        If an argument is wrong; nothing has been computed then.
    NotCoveredError
        If an output cannot be seen.

    Notes
    -----
    A record is 0 after its last point.  The exact recursion has steps of at most a 24th of a period, and cubics between
    them: its largest values are right to 3e-5.  What is sampled (``interpolation="band-limited"``) is made denser until
    two such spectra agree, and their difference is the error.  The kernel goes on for two periods after a record.

    Intervals of quantiles are those of the sample's own order, and hold with 95 % for any distribution; of few records
    they may be without an end.

    Of stationary noise theory has the rms, and Vanmarcke's distribution of the largest value in the duration.  At
    damping ratios of 0.02 to 0.2 its medians and 95 % quantiles were within 5 % of Monte Carlo, those of 5 % within
    11 %.  Where noise begins near the resonance, or faster motion is on it, medians were up to 16 % too high, which a
    warning says.

    Examples
    --------
    A pulse of half a sine, and the spectrum without damping at a period of twice its length:

    >>> import numpy as np
    >>> import springpot as sp
    >>> t = np.linspace(0.0, 0.011, 200)
    >>> pulse = sp.RecordedExcitation(t, 100.0 * np.sin(np.pi * t / t[-1]))
    >>> found = sp.response_spectrum(pulse, [0.022], damping=0.0, kind="residual")
    >>> round(float(found["acceleration"].values[0, 0]), 1)
    157.1

    With a stop 0.1 mm away, the fastest impact at three frequencies:

    >>> mount = sp.System(sp.Mass(0.8), sp.Spring(1.0), sp.Barrier(-1e-4, restitution=0.7))
    >>> found = sp.response_spectrum(pulse, 1.0 / np.array([20.0, 40.0, 80.0]), mount, output="impact_speed")
    >>> found["impact_speed"].values.shape, found.method
    ((3, 1), 'kernel')
    """
    if not isinstance(excitation, Excitation):
        raise TypeError(
            f"excitation must be records or noise, such as RecordedExcitation(...), not {shown(excitation)}."
        )
    own = finite_numbers(periods, "periods", "period", low=0.0, open_low=True).ravel()
    if own.size > _MOST_PERIODS:
        raise ValueError(f"periods must be at most {_MOST_PERIODS}, not {own.size}.")
    names = [output] if isinstance(output, str) else output
    if not isinstance(names, Sequence) or not names or not all(isinstance(word, str) for word in names):
        raise TypeError(f"output must be a name or a list of names, not {shown(output)}.")
    words = [*dict.fromkeys(names)]
    one_of(kind, "kind", get_args(Kind))
    if damping is None and system is None:
        damping = USUAL_DAMPING
    if damping is not None:
        damping = finite_number(damping, "damping", low=0.0, high=10.0, hint="It is a ratio: 0.05 is 5 %.")
    shares = finite_numbers(quantiles, "quantiles", "quantile", low=1e-6, high=1.0 - 1e-6).ravel().tolist()
    rtol = finite_number(rtol, "rtol", low=1e-5, high=0.5)
    if paths is not None:
        paths = whole_number(paths, "paths", 2, 10**7)
    if step is not None:
        step = finite_number(step, "step", low=0.0, open_low=True, hint="It is in s.")
    check_called(progress, "progress")
    seed, threads = checked_seed(seed), checked_threads(threads)
    if isinstance(excitation, RecordedExcitation) and excitation.taken != "in turn":
        excitation = replace(excitation, taken="in turn")  # each has its spectrum
    systems = systems_of(system, excitation, own.tolist(), damping, varied)
    asked = [*dict.fromkeys("displacement" if word in _PSEUDO else word for word in words)]
    motions = motion_of(systems[0])
    check_outputs(motions, asked, "output")
    lasts = motions.recorded > 0.0
    if duration is None and not lasts:
        raise ValueError("duration must be given for noise that does not end: the largest value grows with the time.")
    if duration is not None:
        duration = finite_number(duration, "duration", low=0.0, open_low=True, hint="It is in s.")
        if lasts:
            raise ValueError(
                "duration must be left out where the excitation ends: records and envelopes have their own."
            )
    lengths = (round((time[-1] - time[0]) / excitation.duration, 9) for time, _ in excitation.records)
    if kind != "maximax" and (not lasts or len({*lengths}) > 1):
        raise ValueError(f"kind must be 'maximax' for records of different lengths and for noise, not {kind!r}.")
    common = {"periods": own, "shares": (*shares,), "kind": kind, "systems": (*systems,), "damping": damping}
    if isinstance(excitation, RecordedExcitation) and _is_simple(systems) and {*asked} <= {*recursion.OF_ONE}:
        values, errors = _exact(excitation, systems, own, kind, asked, threads, progress)
        return _put(common, "exact", words, values, errors, ())
    if (
        not lasts
        and paths is None
        and all(stationary.covered(each, asked) for each in systems[:: len(systems) - 1 or 1])
    ):
        assert duration is not None
        return _by_theory(common, words, asked, duration)
    drawn = paths or _USUAL_PATHS if motions.is_random else None

    def one(number: int) -> Any:
        return largest_values(
            systems[number], asked, kind=kind, tail=_TAIL * own[number] if lasts else 0.0, duration=duration,
            paths=drawn or motions.different_paths, rtol=rtol, step=step, seed=seed, threads=1,
        )  # fmt: skip

    why = ": small changes grow from impact to impact; quantiles over many records are known better than single ones"
    found = Largest.of_all(of_each(one, own.size, threads, progress), rtol, "largest values", why)
    return _put(common, "kernel", words, found.values, found.errors, found.warnings)


def _is_simple(systems: Sequence[System]) -> bool:
    """Whether all are one mass on springs and dashpots under one excitation by records."""
    kinds = Mass, Spring, Dashpot, RecordedExcitation
    return all(
        len(each.of(*kinds)) == len(each.parts) and len(each.records) == 1
        and each.stiffness_matrix.size == 1 and each.natural_frequency > 0.0
        for each in systems
    )  # fmt: skip


def _exact(
    excitation: RecordedExcitation, systems: Sequence[System], periods: Floats, kind: Kind, outputs: Sequence[str],
    threads: int, progress: Progress | None,
) -> tuple[dict[str, Floats], dict[str, Floats]]:  # fmt: skip
    groups = recursion.grouped(excitation.records, excitation.interpolation == "band-limited")
    ground = excitation.on == "ground"

    def one(number: int) -> Any:
        system = systems[number]
        frequency = float(system.natural_frequency)
        ratio = 0.5 * float(system.damping / system.inertia) / frequency
        return recursion.largest_of_all(
            groups, recursion.Oscillator(frequency, ratio, ground, outputs), kind, excitation.count
        )

    found = of_each(one, periods.size, threads, progress)
    factors = [excitation.scale * (1.0 if ground else 1.0 / float(system.inertia)) for system in systems]
    return tuple(  # type: ignore[return-value]
        {name: np.stack([k * each[side][name] for k, each in zip(factors, found, strict=True)])
         for name in outputs}
        for side in (0, 1)
    )  # fmt: skip


def _by_theory(common: dict[str, Any], words: Sequence[str], asked: Sequence[str], duration: float) -> ResponseSpectrum:
    shares, systems = common["shares"], common["systems"]
    found = {word: [stationary.rms_and_quantiles(each, word, duration, shares) for each in systems] for word in asked}
    periods, results, warnings = common["periods"], dict[str, Spectrum](), list[str]()
    for word in asked:
        doubtful = [stationary.is_doubtful(each, word, 1.0 / t) for each, t in zip(systems, periods, strict=True)]
        if any(doubtful):
            some = periods[doubtful]
            warnings.append(
                f"{word} by theory may be too high at {some.size} of the periods, from {some.min():.3g} to "
                f"{some.max():.3g} s, where the noise begins near the resonance or moves the mass faster: give paths= "
                "for Monte Carlo."
            )
    for word in words:
        factor, of = _factor(periods, word), "displacement" if word in _PSEUDO else word
        rms = factor * np.array([each for each, _ in found[of]])
        middle = factor * np.array([each for _, each in found[of]]).T
        none = np.full_like(middle, math.nan)
        empty = np.zeros((rms.size, 0))
        results[word] = Spectrum(
            word, _unit(systems[0], word), empty, empty, shares, middle, none, none, rms
        )  # fmt: skip
    return ResponseSpectrum(**common, method="theory", outputs=results, warnings=tuple(warnings))


def _put(
    common: dict[str, Any], method: str, words: Sequence[str], values: dict[str, Floats], errors: dict[str, Floats],
    warnings: tuple[str, ...],
) -> ResponseSpectrum:  # fmt: skip
    results = {}
    for word in words:
        factor, of = _factor(common["periods"], word)[:, None], "displacement" if word in _PSEUDO else word
        own = factor * values[of]
        middle, low, high = quantiles_of(own, common["shares"])
        results[word] = Spectrum(
            word, _unit(common["systems"][0], word), own, factor * errors[of], common["shares"], middle, low, high, None
        )  # fmt: skip
    return ResponseSpectrum(**common, method=method, outputs=results, warnings=warnings)


def _factor(periods: Floats, word: str) -> Floats:
    return np.asarray((2.0 * math.pi / periods) ** _PSEUDO.get(word, 0))


def _unit(system: System, word: str) -> str:
    return {"pseudo_acceleration": "m s-2", "pseudo_velocity": "m s-1"}.get(word) or unit_of_output(system, word)


def quantiles_of(values: Floats, shares: Sequence[float]) -> Floats:
    """Quantiles of the last axis, and the ends of their 95 % intervals, shape (3, shares, ...).

    The ends are values of the sample: how many of them lie below a quantile has a binomial law.  Where the sample is
    too small for an end it is 0 or infinite.

    Examples
    --------
    >>> quantiles_of(np.arange(1.0, 12.0), [0.5]).ravel().tolist()
    [6.0, 2.0, 10.0]
    >>> quantiles_of(np.array([1.0, 2.0]), [0.5]).ravel().tolist()
    [1.5, 0.0, inf]
    """
    from scipy.stats import binom  # slow to import

    count = values.shape[-1]
    ordered = np.concatenate(
        [np.zeros((*values.shape[:-1], 1)), np.sort(values, axis=-1), np.full((*values.shape[:-1], 1), math.inf)],
        axis=-1,
    )
    low = [int(binom.ppf(_CHANCE, count, share)) for share in shares]
    high = [int(binom.ppf(1.0 - _CHANCE, count, share)) + 1 for share in shares]
    middle = np.quantile(values, shares, axis=-1)
    return np.stack([middle, np.moveaxis(ordered[..., low], -1, 0), np.moveaxis(ordered[..., high], -1, 0)])
