"""Comparison of theory with Monte Carlo: the gap of every method, in per cent and in standard errors."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from springpot.evidence.recommendation import recommended
from springpot.evidence.reliability import warnings_of
from springpot.machine.plain import plain
from springpot.problem.dimensionless import Dimensionless
from springpot.problem.system import System, checked_system
from springpot.simulation import Budget, Run
from springpot.simulation.monte_carlo import simulated
from springpot.simulation.paths.simulation import Progress
from springpot.simulation.plan.motions import motion_of
from springpot.simulation.plan.options import own_seed
from springpot.simulation.plan.plan import check_motion, plan_of
from springpot.simulation.plan.settings import checked_seed
from springpot.simulation.watch.spectrum import step_for
from springpot.theory import Result, solve_all
from springpot.theory.result import names_of_results

__all__ = ["Comparison", "Gap", "compare", "observe"]

SHOWN = 3.0  # frequencies Omega to which the spectrum goes
BLUR = 0.1  # of a spectral peak: resolution over its half-width, at most
LONGEST_WINDOW = 400_000  # steps
PATH_STEPS = 4e8  # of the run for distributions and spectrum


@dataclass(frozen=True)
class Gap:
    """Difference between a method and Monte Carlo.

    Attributes
    ----------
    percent : float
        100 (theory / Monte Carlo - 1); NaN where Monte Carlo is zero within three standard errors.
    standard_errors : float
        (theory - Monte Carlo) / error; the error is the root of the sum of squares of the parts of the run's budget.
    """

    percent: float
    standard_errors: float


@dataclass(frozen=True, eq=False)
class Comparison:
    """Results of all methods and of Monte Carlo for one system.

    Attributes
    ----------
    system : System
    answers : dict
        `springpot.theory.Result` of each method, by name.
    statements : dict
        For each method without a result the sentence that says why.
    recommended : str
        The recommended method; empty if the errors of all are unknown.
    simulation : Run
        With a stationary start.
    """

    system: System
    answers: Mapping[str, Result]
    statements: Mapping[str, str]
    recommended: str
    simulation: Run

    @property
    def why_none_is_recommended(self) -> str:
        """One sentence; empty if a method is recommended."""
        return recommended(self.system, self.answers).why_none

    @property
    def moments(self) -> tuple[str, ...]:
        """The moments that theory and Monte Carlo both have, by name."""
        return tuple(name for name in names_of_results(self.system) if name in self._budgets)

    @property
    def _budgets(self) -> dict[str, Budget]:
        return {name: own.budget for name, own in self.simulation.estimates.items() if own.budget is not None}

    def gaps(self, method: str) -> dict[str, Gap]:
        """Gap of each moment that both have.

        Parameters
        ----------
        method : str
            One of the keys of ``answers``.

        Returns
        -------
        dict
            `Gap` of each moment, by name.

        Examples
        --------
        >>> import springpot as sp
        >>> from springpot import Springpot
        >>> comparison = compare(sp.Oscillator(springpot=sp.Springpot(order=1.0, coefficient=1.0)), rtol=0.1)
        >>> sorted(comparison.gaps("exact"))[:2]
        ['amplitude_mean_square', 'barrier_force_mean']
        """
        moments = self.answers[method].moments
        gaps = {}
        for name in self.moments:
            theory, value, budget = moments[name], self.simulation[name].value, self._budgets[name]
            error = math.hypot(budget.standard_error, budget.step_bias, budget.memory_bias, budget.transient)
            if math.isfinite(theory) and math.isfinite(value) and error > 0.0:
                percent = 100.0 * (theory / value - 1.0) if abs(value) > 3.0 * error else math.nan
                gaps[name] = Gap(percent, (theory - value) / error)
        return gaps

    def to_dict(self) -> dict[str, Any]:
        """Everything as plain numbers, words, lists and dicts, ready for JSON.

        Returns
        -------
        dict
            ``system``, ``recommended`` and ``why_none_is_recommended``, ``simulation``,
            ``methods`` (with their gaps) and ``statements``; what is
            not a number is None.
        """
        return {
            "system": self.system.to_dict(),
            "recommended": self.recommended,
            "why_none_is_recommended": self.why_none_is_recommended,
            "simulation": self.simulation.to_dict(),
            "methods": {
                method: {
                    **answer.to_dict(),
                    "warnings": list(warnings_of(answer)),
                    "gap_percent": plain({name: gap.percent for name, gap in self.gaps(method).items()}),
                    "gap_standard_errors": {name: gap.standard_errors for name, gap in self.gaps(method).items()},
                }
                for method, answer in self.answers.items()
            },
            "statements": dict(self.statements),
        }


def compare(
    system: System,
    *,
    rtol: float = 0.01,
    quantities: Sequence[str] | None = None,
    max_time: float | None = None,
    seed: int = 1,
    threads: int | None = None,
    progress: Progress | None = None,
) -> Comparison:
    """Set every method of the theory beside an adapted Monte Carlo.

    Parameters
    ----------
    system : System
        With a stationary state.
    rtol : float
        Total relative error of the Monte Carlo, in [1e-4, 0.5].
    quantities : sequence of str
        What must be known so well; if left out, what `springpot.simulate` takes, which is <A^2> of one mass with a
        linear spring, and each mean displacement that is not near 0.
    max_time, threads, progress
        As in `springpot.simulate`.
    seed : int
        The seed of the run is made from it and from the problem, so that unlike problems are off independently.

    Returns
    -------
    Comparison

    Raises
    ------
    TypeError, ValueError
        If an argument is wrong or there is no stationary state.

    Examples
    --------
    >>> import springpot as sp
    >>> from springpot import Springpot
    >>> comparison = compare(sp.Oscillator(springpot=sp.Springpot(order=1.0, coefficient=1.0)), rtol=0.05)
    >>> comparison.recommended
    'exact'
    >>> abs(comparison.gaps("exact")["amplitude_mean_square"].percent) < 5.0
    True
    """
    system = checked_system(system)
    answers, statements = solve_all(system)
    motion = motion_of(system)
    check_motion(motion, "compare")
    best = recommended(system, answers)
    if quantities is None:
        quantities, found = motion.usual_quantities, best.answers[best.guess].moments if best.guess else None
        if found is not None:  # of a mean that is small against the spread a relative error makes no sense
            large = (name for name in motion.mean_names if abs(found[name]) > 0.1 * math.sqrt(found[f"{name}_square"]))
            quantities = *quantities, *large
    simulation = simulated(
        system,
        rtol=rtol,
        quantities=tuple(quantities),
        max_time=max_time,
        seed=own_seed(checked_seed(seed), system.to_dict()),
        threads=threads,
        progress=progress,
    )
    return Comparison(system, answers, statements, best.method, simulation)


def observe(system: System, *, seed: int = 1, threads: int | None = None, progress: Progress | None = None) -> Run:
    """An adapted run for pictures: distributions, and a spectrum over a window long enough for its peaks.

    Parameters
    ----------
    system : System
        The paper's problem, with a stationary state.
    seed, threads, progress
        As in `compare`.

    Returns
    -------
    Run

    Examples
    --------
    >>> import springpot as sp
    >>> from springpot import Springpot
    >>> run = observe(sp.Oscillator(springpot=sp.Springpot(order=1.0, coefficient=1.0)))
    >>> run.spectra["x"].frequency.size
    117
    """
    frequency, plan = Dimensionless.of(system).natural_frequency, plan_of(system)
    relaxation = max(plan.motion.scales.relaxation_time, 1.0 / frequency)
    frequencies = np.linspace(SHOWN / 30.0, SHOWN, 117) * frequency
    step = min(step_for(max(float(frequencies[-1]), plan.motion.scales.fastest_rate)), plan.settings.step)
    window = max(2.0 * math.sqrt(4.0 / 3.0) * math.pi / BLUR * relaxation, 4.001 * math.pi / float(frequencies[0]))
    steps = min(math.ceil(window / step), LONGEST_WINDOW)
    skipped = math.ceil(5.0 * relaxation / step)
    paths = int(min(max(PATH_STEPS / (steps + skipped), 256.0), 20_000.0))
    return simulated(
        system,
        paths=paths,
        step=step,
        duration=(steps + skipped) * step,
        window=(skipped * step, (steps + skipped) * step),
        start="stationary",
        distributions=True,
        spectrum=frequencies,
        seed=own_seed(checked_seed(seed), system.to_dict()),
        threads=threads,
        progress=progress,
    )
