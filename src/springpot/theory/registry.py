"""The list of analytical methods.

The command, the page, the figures, studies and the validity map take names, order and styles of the methods from here.
A method's module is imported at its first use.
"""

from __future__ import annotations

import importlib
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any, Literal

__all__ = ["MAPPED", "METHODS", "SYSTEM_MAPPED", "SYSTEM_METHODS", "Method"]


@dataclass(frozen=True)
class Method:
    """One method: how it is called, how it is drawn, where it is computed, and what is known of its errors.

    Parameters
    ----------
    name : str
        In Python, files, studies and on the command line.
    label : str
        In legends and on the page.
    function : str
        Module below ``springpot.theory.methods`` and function in it, with a dot between them: it takes an oscillator
        and returns a `springpot.theory.Result`.
    color : str
        Key of `springpot.figures.COLORS`; the page has a lighter and a darker shade of each.
    dash : tuple of float
        Lengths of strokes and gaps, in line widths; empty for a full line.
    options : dict
        Further arguments of the function.
    exact : bool
        Whether nothing is approximated: it is then recommended where it has an answer.
    mapped : bool
        Whether the validity map has its gaps to Monte Carlo.
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
    mapped: bool = False
    seconds: float = 0.03
    over_order: Literal["", "at once", "one by one"] = ""

    def solve(self, oscillator: Any) -> Any:
        """The method's result, a `springpot.theory.Result`; a method for systems takes a `springpot.System`.

        Examples
        --------
        >>> from springpot.problem.oscillator import Oscillator
        >>> round(METHODS["envelope"].solve(Oscillator()).x_mean, 2)
        0.78
        """
        module, _, function = self.function.rpartition(".")
        solve = getattr(importlib.import_module(f"springpot.theory.methods.{module}"), function)
        return solve(oscillator, **self.options)


_LISTED = (
    Method("averaging_printed", "averaging, as printed", "averaging.averaging", "orange", (5.0, 2.0),
           options={"form": "printed"}, over_order="at once"),
    Method("averaging", "averaging", "averaging.averaging", "purple", (1.0, 1.5), mapped=True, over_order="at once"),
    Method("averaging_shifted", "averaging, shifted", "averaging.averaging", "green", (4.0, 1.5, 1.0, 1.5),
           options={"form": "shifted"}, mapped=True),
    Method("envelope", "envelope", "envelope.method.envelope", "vermilion", mapped=True, over_order="one by one"),
    Method("closure", "closure", "closure.method.closure", "blue", (3.5, 2.0), mapped=True),
    Method("fokker_planck", "Fokker-Planck", "fokker_planck.method.fokker_planck", "black", (4.0, 2.0), exact=True),
    Method("exact", "exact", "exact.exact", "black", exact=True),
)  # fmt: skip

METHODS: Mapping[str, Method] = {method.name: method for method in _LISTED}
"""Every method by name, in the order of tables, from the simplest to the most exact."""
MAPPED: tuple[str, ...] = tuple(method.name for method in _LISTED if method.mapped)
"""Names of the methods that are on the validity map."""

_FOR_SYSTEMS = (
    Method("averaging_amplitude", "averaging of the amplitude", "systems.amplitude.averaging_amplitude", "purple",
           (1.0, 1.5), mapped=True),
    Method("linearization", "linearization", "systems.linearization.linearization", "blue", (3.5, 2.0), mapped=True,
           seconds=0.1),
    Method("envelope", "envelope", "envelope.method.envelope", "vermilion", mapped=True, seconds=0.3),
    Method("half_cycles", "half cycles", "systems.half_cycles.half_cycles", "orange",
           (5.0, 1.5, 1.0, 1.5, 1.0, 1.5), mapped=True, seconds=0.4),
    Method("path_integration", "path integration", "systems.path_integration.path_integration", "sky", (6.0, 1.5),
           mapped=True, seconds=1.0),
    Method("linear", "linear", "systems.linear.linear", "black", (4.0, 2.0), exact=True),
    Method("exact", "exact", "systems.energy.exact_law", "black", exact=True),
)  # fmt: skip
SYSTEM_METHODS: Mapping[str, Method] = {method.name: method for method in _FOR_SYSTEMS}
"""The methods for systems of parts by name; the others cover a system that is an `springpot.Oscillator`."""
SYSTEM_MAPPED: tuple[str, ...] = tuple(method.name for method in _FOR_SYSTEMS if method.mapped)
"""Names of those that are on the validity map of systems."""
