"""The list of analytical methods: function, what it covers, name, color and line of each.

The command, the page, the figures, studies and the validity map take names, order and styles of the methods from here.
A method's module is imported at its first use.
"""

from __future__ import annotations

import importlib
from collections.abc import Mapping
from dataclasses import dataclass, field
from types import ModuleType
from typing import TYPE_CHECKING, Literal

if TYPE_CHECKING:
    from springpot.problem.system import System
    from springpot.theory.result import Result


@dataclass(frozen=True)
class Method:
    """One method: how it is called, how it is drawn, and where it is computed.

    Parameters
    ----------
    name : str
        In Python, files, studies and on the command line.
    label : str
        In legends and on the page.
    function : str
        Module below ``springpot.theory.methods`` and function in it, with a dot between them: it takes a system and
        returns a `springpot.theory.Result`.  Its module's ``check_covered`` refuses what it does not cover.
    color : str
        Key of `springpot.figures.COLORS`; the page has a lighter and a darker shade of each.
    dash : tuple of float
        Lengths of strokes and gaps, in line widths; empty for a full line.
    options : dict
        Further arguments of the function.
    exact : bool
        Whether nothing is approximated: it is then recommended where it has an answer.
    seconds : float
        That an answer takes, about: for choices between methods and Monte Carlo, which must not depend on the machine.
    over_order : {"", "at once", "one by one"}
        Whether the page draws its <A^2> over the order: all orders at once where an answer takes no time, or one order
        after the other.
    """

    name: str
    label: str
    function: str
    color: str
    dash: tuple[float, ...] = ()
    options: Mapping[str, str] = field(default_factory=dict)
    exact: bool = False
    seconds: float = 0.03
    over_order: Literal["", "at once", "one by one"] = ""

    def covers(self, system: System) -> str:
        """Why the method does not cover a system, in one sentence; empty if it does.  Nothing is solved.

        Examples
        --------
        >>> from springpot.problem.parts import Spring
        >>> from springpot.problem.system import System
        >>> METHODS["half_cycles"].covers(System(Spring(1.0)))
        'The half cycles cover two rigid walls, one on each side of the equilibrium 0; here there is no wall.'
        """
        from springpot.machine.faults import NotCoveredError

        check = getattr(self._module, "check_covered", None)
        try:
            if check is not None:
                check(system, **self.options)
        except NotCoveredError as refusal:
            return str(refusal)
        return ""

    def solve(self, system: System) -> Result:
        """The method's result.

        Examples
        --------
        >>> from springpot.problem.oscillator import Oscillator
        >>> round(METHODS["envelope"].solve(Oscillator()).x_mean, 2)
        0.78
        """
        found: Result = getattr(self._module, self.function.rpartition(".")[2])(system, **self.options)
        return found

    @property
    def _module(self) -> ModuleType:
        return importlib.import_module(f"springpot.theory.methods.{self.function.rpartition('.')[0]}")


_LISTED = (
    Method("averaging_printed", "averaging, as printed", "averaging.averaging", "orange", (5.0, 2.0),
           options={"form": "printed"}, over_order="at once"),
    Method("averaging", "averaging", "averaging.averaging", "purple", (1.0, 1.5), over_order="at once"),
    Method("averaging_amplitude", "averaging of the amplitude", "systems.amplitude.averaging_amplitude", "green",
           (2.5, 1.0, 2.5, 3.0)),
    Method("linearization", "linearization", "systems.linearization.linearization", "blue", (1.0, 1.5), seconds=0.1),
    Method("envelope", "envelope", "envelope.method.envelope", "vermilion", over_order="one by one"),
    Method("memory_closure", "memory closure", "memory_closure.method.memory_closure", "blue", (3.5, 2.0)),
    Method("half_cycles", "half cycles", "systems.half_cycles.half_cycles", "orange",
           (5.0, 1.5, 1.0, 1.5, 1.0, 1.5), seconds=0.4),
    Method("path_integration", "path integration", "systems.path_integration.path_integration", "sky", (6.0, 1.5),
           seconds=1.0),
    Method("fokker_planck", "Fokker-Planck", "fokker_planck.method.fokker_planck", "black", (4.0, 2.0), exact=True),
    Method("linear", "linear", "systems.linear.linear", "black", (1.0, 1.5), exact=True),
    Method("exact", "exact", "exact.exact", "black", exact=True),
)  # fmt: skip

METHODS: Mapping[str, Method] = {method.name: method for method in _LISTED}
"""Every method by name, in the order of tables, from the simplest to the most exact."""
