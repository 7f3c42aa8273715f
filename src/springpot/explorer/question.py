"""What a tab asks: the system that the page was opened with, with other numbers, and paths, seed and start."""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING

from springpot.explorer.copies import command_of, python_of
from springpot.explorer.protocol import Problem
from springpot.explorer.sliders import changed, laws_in_words
from springpot.explorer.tolerances import laws_of, toleranced
from springpot.machine.faults import NotCoveredError
from springpot.problem.dimensionless import Dimensionless
from springpot.problem.free_numbers import nominal
from springpot.problem.oscillator import Oscillator
from springpot.problem.system import System
from springpot.simulation.plan.options import StartKind

if TYPE_CHECKING:
    from springpot.simulation.plan.motion import Motion


@dataclass(frozen=True)
class Opened:
    """What the page was opened with.

    Attributes
    ----------
    system : System
        The paper's oscillator, if left out; it may have uncertain numbers.
    file : str
        The name of its file; empty if it was not read from one.
    """

    system: System = field(default_factory=Oscillator)
    file: str = ""

    @cached_property
    def nominal(self) -> System:
        """The device with the nominal values."""
        return nominal(self.system)

    def name_of(self, other: System) -> str:
        """The name of a file for the same system, or for one with other numbers.

        Examples
        --------
        >>> from springpot.problem.parts import Spring
        >>> Opened(System(Spring(1.0)), "device.toml").name_of(System(Spring(2.0)))
        'device-changed.toml'
        """
        if not self.file:
            return "system.toml"
        same = other == self.system and laws_of(other) == laws_of(self.system)
        return self.file if same else f"{Path(self.file).stem}-changed.toml"


@dataclass(frozen=True)
class Question:
    """One problem of a tab.

    Attributes
    ----------
    asked : Problem
        Its start is taken where there is a stationary state.
    devices : System
        With its uncertain numbers.
    system : System
        The device with their nominal values, which the page simulates.
    papers : tuple of Dimensionless
        The same as the paper's problem; empty if it is another one.
    command, python : str
        The same run without the page.
    file : str
        The name of the system's file with these numbers.
    """

    asked: Problem
    devices: System
    system: System
    papers: tuple[Dimensionless, ...]
    command: str
    python: str
    file: str

    @cached_property
    def laws(self) -> dict[str, str]:
        """In words, the laws that a tolerance alone does not describe."""
        return laws_in_words(self.devices)

    @cached_property
    def motion(self) -> Motion:
        """What is known of the motion before it is simulated."""
        from springpot.simulation.plan.motions import motion_of

        return motion_of(self.system)

    @cached_property
    def start(self) -> StartKind:
        """The start of the page's run: from rest if there is no stationary state."""
        from springpot.simulation.plan.plan import default_start

        return "rest" if self.asked.start == "rest" else default_start(self.motion)[0]

    @property
    def speeds(self) -> float:
        """What v^2 counts in the mean square over time: <A^2> of the paper's problem, <x^2> of any other."""
        return sum(paper.natural_frequency**-2 for paper in self.papers)

    @property
    def frequency(self) -> float:
        """Radians per second of the motion, for the speed at which it is shown."""
        return self.motion.scales.frequency


def papers_of(system: System) -> tuple[Dimensionless, ...]:
    """A system as the paper's problem; none if it is another, or without noise, where there is no length scale.

    Examples
    --------
    >>> from springpot.problem.parts import Friction, Spring, WhiteNoise
    >>> papers_of(System(Spring(1.0), WhiteNoise(1.0), Friction(0.1)))
    ()
    """
    try:
        paper = Dimensionless.of(system)
    except NotCoveredError:
        return ()
    return (paper,) if paper.length_scale > 0.0 else ()


def question_of(message: Problem, opened: Opened) -> Question:
    """What a message asks.

    Raises
    ------
    ValueError
        If the system with these numbers is not possible.

    Examples
    --------
    >>> question_of(Problem(numbers={"springpot-order": 0.7}), Opened()).papers[0].springpot.order
    0.7
    """
    devices = toleranced(changed(opened.system, message.numbers), opened.system, message.tolerances)
    if message.without:
        devices = System(**{name: part for name, part in devices.stated() if name not in message.without})
    system, file = nominal(devices), opened.name_of(devices)
    papers = papers_of(system)
    command = command_of(opened.file and file, papers, message, differ=bool(laws_of(devices)))
    return Question(message, devices, system, papers, command, python_of(devices, file, message), file)
