"""What a tab asks: a problem as `springpot.simulate` takes it, with paths, seed and start."""

from __future__ import annotations

import shlex
from dataclasses import dataclass
from pathlib import Path

from springpot.explorer.copies import as_command, as_python, command_of_system, python_of_system
from springpot.explorer.protocol import Problem, SystemProblem
from springpot.explorer.sliders import changed
from springpot.machine.faults import NotCoveredError
from springpot.problem.oscillator import Oscillator
from springpot.problem.system import System
from springpot.simulation.plan.options import StartKind

__all__ = ["Opened", "Question", "question_of"]


@dataclass(frozen=True)
class Opened:
    """The system that the page was opened with.

    Attributes
    ----------
    system : System
    title : str
        The name of its file.
    """

    system: System
    title: str = "system.toml"

    @property
    def is_writable(self) -> bool:
        """Whether it can be written to a file."""
        return not self.system.with_functions

    def name_of(self, other: System) -> str:
        """The name of a file for the same system, or for one with other numbers.

        Examples
        --------
        >>> from springpot.problem.parts import Spring
        >>> Opened(System(Spring(1.0)), "device.toml").name_of(System(Spring(2.0)))
        'device-changed.toml'
        """
        return self.title if other == self.system else f"{Path(self.title).stem}-changed.toml"


@dataclass(frozen=True)
class Question:
    """One problem of a tab.

    Attributes
    ----------
    generation, seed, paths : int
    wanted : {"stationary", "rest"}
        The start, where there is a stationary state.
    problem : Oscillator or System
        As Monte Carlo takes it: a system that is an oscillator is simulated as one.
    system : System or None
        What theory is asked, where the page was opened with a system.
    command, python : str
        The same run without the page.
    file : str
        The name of the system's file with these numbers.
    """

    generation: int
    seed: int
    paths: int
    wanted: StartKind
    problem: Oscillator | System
    system: System | None
    command: str
    python: str
    file: str = ""

    @property
    def oscillator(self) -> Oscillator:
        """The problem of the oscillator's page."""
        assert isinstance(self.problem, Oscillator)
        return self.problem

    @property
    def start(self) -> StartKind:
        """The start of the page's run: from rest if there is no stationary state."""
        from springpot.simulation.plan.settings import default_start

        return "rest" if self.wanted == "rest" else default_start(self.problem)[0]

    @property
    def frequency(self) -> float:
        """Radians per second of the motion, for the speed at which it is shown."""
        from springpot.simulation.plan.system_scales import typical_frequency

        return typical_frequency(self.problem)


def question_of(message: Problem | SystemProblem, opened: Opened | None) -> Question:
    """What a message asks.

    Raises
    ------
    ValueError
        If the page has no system, or the system with these numbers is not possible.

    Examples
    --------
    >>> question_of(Problem(), None).oscillator == Oscillator()
    True
    """
    common = message.generation, message.seed, message.paths, message.start
    if isinstance(message, Problem):
        return Question(*common, message.oscillator(), None, as_command(message), as_python(message))
    if opened is None:
        raise ValueError("system: this page was opened without a system.")
    system = changed(opened.system, message.numbers)
    name = opened.name_of(system)
    return Question(
        *common,
        _as_simulated(system),
        system,
        command_of_system(shlex.quote(name), message),
        python_of_system(system, name, message),
        name,
    )


def _as_simulated(system: System) -> Oscillator | System:
    """An oscillator, if the system is one, as `springpot.run` takes it."""
    try:
        return system.canonical()
    except NotCoveredError:
        return system
