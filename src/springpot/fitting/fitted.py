"""From data to numbers."""

from __future__ import annotations

import math
import warnings
from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, Any, get_args

import numpy as np

from springpot.fitting.estimate import VAGUE, confusions, correlation_of, search
from springpot.fitting.frequency_response import MeasuredFrequencyResponse
from springpot.fitting.impacts import ImpactLikelihood, law_of
from springpot.fitting.likelihood import How, LeastSquares, Likelihood, refuse_idle
from springpot.fitting.moduli import ModuliLikelihood, SteppedLikelihood
from springpot.fitting.motion_data import MeasuredRecord, MeasuredSpectrum
from springpot.fitting.part_data import MeasuredCreep, MeasuredImpacts, MeasuredModuli, MeasuredRelaxation
from springpot.fitting.reading import Data
from springpot.fitting.result import Choice, Fit
from springpot.fitting.spectra import SpectrumLikelihood
from springpot.fitting.statistics import MeasuredStatistics
from springpot.fitting.transfer import ResponseLikelihood
from springpot.machine.arguments import check_called
from springpot.machine.faults import NoFitError, Stopped, listed, shown
from springpot.problem.free_numbers import check_certain, free_numbers, with_values
from springpot.problem.messages import ProblemWarning
from springpot.problem.parts import PolynomialSpring
from springpot.problem.parts.registration import kind_of
from springpot.problem.system import System, check_single, checked_system, system_of

if TYPE_CHECKING:
    from springpot.simulation.paths.simulation import Progress

_KINDS = listed([kind.__name__ for kind in get_args(Data)], "or")


def fit(
    model: Any,
    data: Data | None = None,
    seed: int = 1,
    *,
    paths: int | None = None,
    threads: int | None = None,
    progress: Progress | None = None,
    stop: Callable[[], bool] | None = None,
) -> Fit:
    """Find the free numbers of a model that agree best with data.

    Parameters
    ----------
    model : System, part or function, or a list of them
        With numbers marked by `springpot.free`.  Of a list the model with the smallest Bayesian information criterion
        is returned, with a table of all.  For `MeasuredImpacts` it can be a function r(v, ...) of the speeds before
        impact, whose other arguments have free numbers as their defaults.  Of `MeasuredStatistics` there may be several
        sets, of one device in different states: give pairs ``[(model, statistics), ...]`` and no ``data``; free numbers
        of the same name are one number.
    data : one of the ``Measured...`` classes
        Moduli, relaxation and creep need linear springs, dampers, springpots and arms (moduli: circuits
        too); walls, noise and the mass have no influence.
        A frequency response needs a linear system without walls; its noise has no influence.
        Spectra need a linear system without walls, under stationary noise.  So do records, or one mass with walls, soft
        contacts, nonlinear springs and linear parts under white noise.  Statistics are simulated, so walls and
        nonlinear parts are allowed; the model needs a stationary state.
    seed : int
        Of the places between the bounds from which the search is repeated; those of simulations are made from it and
        from each model.
    paths : int, optional
        Of each run in the last round of a fit to `MeasuredStatistics`: a power of two from 1024.  If left out, so many
        that the simulation adds no more than a tenth to the error of each number, and 65536 at most; where it adds
        more, a warning says how much.
    threads : int, optional
        Of simulations.
    progress : callable, optional
        Called with the fraction of the simulations done.
    stop : callable, optional
        Asked again and again, from any thread: when it returns True, the fit ends with the best numbers so far, and a
        warning.

    Returns
    -------
    Fit
        With the same bits for the same seed.

    Raises
    ------
    TypeError, ValueError
        If the data are of another kind, nothing is free, or a free number has no influence on the data.
    NotCoveredError
        If the model has a part that such data cannot be computed for; the sentence names it.
    springpot.machine.faults.Stopped
        If it was stopped before there were any numbers.

    Notes
    -----
    Estimates are of maximum likelihood, of `MeasuredStatistics` of simulated moments.  Errors come from the information
    of the data; where the scatter of the data is not known, it is estimated from the residuals.  Errors of a fit to
    `MeasuredStatistics` include those of the simulation.

    Examples
    --------
    A silicone between 0.1 and 100 Hz, with errors of 2 %:

    >>> import numpy as np
    >>> import springpot as sp
    >>> f = np.geomspace(0.1, 100.0, 16)
    >>> modulus = 3.0 + 2.0 * (2j * np.pi * f) ** 0.4
    >>> noise = 1.0 + 0.02 * np.random.default_rng(1).standard_normal((2, f.size))
    >>> data = sp.MeasuredModuli(f, modulus.real * noise[0], modulus.imag * noise[1])
    >>> silicone = sp.System(
    ...     sp.Spring(sp.free("k", 1.0, (0.01, 100.0))),
    ...     sp.Springpot(sp.free("order", 0.5, (0.01, 0.99)), sp.free("C", 1.0, (0.01, 100.0))),
    ... )
    >>> found = sp.fit(silicone, data)
    >>> {name: round(value, 2) for name, value in found.values.items()}
    {'k': 3.05, 'order': 0.4, 'C': 1.98}
    """
    if isinstance(seed, bool) or not isinstance(seed, int) or seed < 0:
        raise ValueError(f"seed must be a whole number from 0, not {shown(seed)}.")
    if paths is not None and (not isinstance(paths, int) or paths < 1024 or paths & (paths - 1)):
        raise ValueError(f"paths must be a power of two, at least 1024, not {shown(paths)}.")
    check_called(progress, "progress")
    check_called(stop, "stop", "a function that says whether to stop")
    how = How(seed, paths, threads, progress, stop)
    if data is None:
        return _fit(*_pairs(model), how)
    if not isinstance(data, Data):
        raise TypeError(f"data must be {_KINDS}, not {shown(data)}.")
    if paths is not None and not isinstance(data, MeasuredStatistics):
        raise ValueError("paths must not be given: only MeasuredStatistics are simulated.")
    return _best_of(model, data, how) if isinstance(model, Sequence) else _fit(model, data, how)


def _pairs(model: Any) -> tuple[tuple[Any, ...], tuple[MeasuredStatistics, ...]]:
    """Models and their statistics."""
    if not isinstance(model, Sequence) or not model:
        raise TypeError(f"data must be given: {_KINDS}.")
    for pair in model:
        if not isinstance(pair, tuple | list) or len(pair) != 2 or not isinstance(pair[1], MeasuredStatistics):
            raise TypeError(
                f"model must be pairs (model, MeasuredStatistics) where data is left out, not {shown(pair)}."
            )
    return tuple(pair[0] for pair in model), tuple(pair[1] for pair in model)


def _best_of(models: Sequence[Any], data: Data, how: How) -> Fit:
    if len(models) < 2:
        raise ValueError(f"model must be a model, or a list of at least two, not {shown(models)}.")
    fits, faults = list[Fit](), list[NoFitError]()
    for model in models:
        try:
            fits.append(_fit(model, data, how))
        except NoFitError as fault:  # as where no wall of it is struck: the others are compared
            faults.append(fault)
        except Stopped:
            if not fits:
                raise
            break
    if not fits:
        raise faults[0]
    for left_out in faults:
        warnings.warn(f"A model is left out of the comparison: {left_out}", ProblemWarning, stacklevel=4)
    fits.sort(key=lambda fit: fit.bic)
    labels = [
        getattr(fit.model, "__name__", None) or " + ".join(map(kind_of, system_of(fit.model, "model").parts))
        for fit in fits
    ]
    choices = tuple(
        Choice(
            f"{label} ({', '.join(fit.values)})" if labels.count(label) > 1 else label,
            len(fit.values) + (not fit._likelihood.known), fit.bic, fit.aicc,
        )
        for label, fit in zip(labels, fits, strict=True)
    )  # fmt: skip
    return replace(fits[0], choices=choices)


def _fit(model: Any, data: Any, how: How) -> Fit:
    check_certain(model, "a fit")
    likelihood = _likelihood(model, data, how)
    own = likelihood.coordinates
    if not likelihood.simulated:  # those of statistics were checked before any work
        _check_size(len(own.free), likelihood.size, 2)
        if isinstance(likelihood, LeastSquares):
            moves = np.abs(likelihood.sensitivity(own.outer(own.start))).max(axis=0)
            idle = [name for name, move in zip(own.names, moves.tolist(), strict=True) if move == 0.0]
            refuse_idle(idle, "such data do not depend on it")
    best = search(likelihood, how.seed)
    likelihood.stop = None  # what is asked of it later is answered
    theta = own.outer(best.u)
    named = own.named(theta)
    if fault := "" if likelihood.stopped else likelihood.without_influence(theta, best.moves):
        raise NoFitError(fault)
    whole = likelihood.covariance(theta, np.ones(theta.size, bool))
    covariance = np.full(whole.shape, math.nan)
    if best.moves.any():
        slope = own.slope(theta)[best.moves]
        part = whole if best.moves.all() else likelihood.covariance(theta, best.moves)
        covariance[np.ix_(best.moves, best.moves)] = part * np.outer(slope, slope)
    likelihood.ended = True
    # a function keeps its free numbers as its arguments, and the noise of a measurement is no number of the model
    in_model = {} if callable(model) else {name: named[name] for name in free_numbers(model)}
    n, k = likelihood.size, len(own.free) + (not likelihood.known)
    whole_deviance, spare = likelihood.whole(best.deviance), n - k - 1
    bic = whole_deviance + k * math.log(n)
    aicc = whole_deviance + 2.0 * k + (2.0 * k * (k + 1.0) / spare if spare > 0 else math.inf)
    return Fit(
        model=with_values(model, in_model) if in_model else model,
        given=model,
        data=data,
        values=named,
        errors=dict(zip(own.names, np.sqrt(np.diag(covariance)).tolist(), strict=True)),
        at_bounds={
            name: "low" if best.u[n] == own.low[n] else "high" for n, name in enumerate(own.names) if not best.moves[n]
        },
        not_told_apart=confusions(own.names, whole, own.relative(theta, np.sqrt(np.diag(whole))) > VAGUE, ~best.moves),
        extras=likelihood.extras(theta),
        covariance=covariance,
        correlations=correlation_of(whole),
        deviance=best.deviance / likelihood.scatter(theta, int(best.moves.sum())),
        bic=bic,
        aicc=aicc,
        table=likelihood.table(theta),
        _likelihood=likelihood,
        _best=best,
    )  # fmt: skip


def _check_size(numbers: int, points: int, spare: int) -> None:
    """There must be a free number, and as many points, with some to spare."""
    if not numbers:
        raise ValueError("model must have a free number, such as Spring(sp.free('k', 80.0, (10.0, 200.0))).")
    if points < numbers + spare:
        raise ValueError(f"data must have more points than the model has free numbers: {points} are too few "
                         f"for {numbers}.")  # fmt: skip


def _likelihood(model: Any, data: Any, how: How) -> Likelihood:
    if isinstance(data, MeasuredImpacts):
        return ImpactLikelihood(law_of(model), data, how)
    if isinstance(data, MeasuredStatistics | tuple):
        cases = [(model, data)] if isinstance(data, MeasuredStatistics) else [*zip(model, data, strict=True)]
        for each, _ in cases:
            checked_system(each, "model")
        _check_size(len(free_numbers(tuple(each for each, _ in cases))), sum(own.size for _, own in cases), 0)
        from springpot.fitting.simulated_search import search_by_simulation  # brings the whole engine

        return search_by_simulation(cases, how)
    system = system_of(model, "model")
    match data:
        case MeasuredModuli():
            check_single(system)
            return ModuliLikelihood(system, data, how)
        case MeasuredRelaxation() | MeasuredCreep():
            check_single(system)
            return SteppedLikelihood(system, data, how)
        case MeasuredFrequencyResponse():
            return ResponseLikelihood(system, data, how)
        case MeasuredSpectrum():
            return SpectrumLikelihood(system, data, how)
        case MeasuredRecord() if data.has_input:
            from springpot.fitting.driven_records import DrivenLikelihood  # brings the whole engine

            return DrivenLikelihood(system, data, how)
        case _:
            if is_nonlinear(system):
                from springpot.fitting.nonlinear_records import NonlinearRecordLikelihood

                return NonlinearRecordLikelihood(system, data, how)
            from springpot.fitting.records import RecordLikelihood  # brings Numba

            return RecordLikelihood(system, data, how)


def is_nonlinear(system: System) -> bool:
    """Whether a system has walls, contacts or nonlinear springs."""
    return bool(system.stops) or any(not part.is_linear for part in system.of(PolynomialSpring))
