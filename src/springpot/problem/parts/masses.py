"""The mass."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Annotated

from springpot.machine.faults import shown
from springpot.problem.parts.registration import Number, Part, Point

__all__ = ["Mass"]


@dataclass(frozen=True)
class Mass(Part):
    """The mass on the coordinate x, or one of several masses.

    Without one, every other number of a system is per unit mass, as in `springpot.Oscillator`.

    Parameters
    ----------
    value : float
        m > 0, in kg.
    at : str, optional
        The name of the point that it is, which parts are `between` and excitations are `on`.  Needed where there are
        several masses.

    Raises
    ------
    TypeError, ValueError
        If it is not a positive finite number.

    Examples
    --------
    >>> Mass(0.2)
    Mass(value=0.2)
    >>> Mass(0.2, at="box").at
    'box'
    """

    said, glyph, powers = "mass", "mass", ("inertia",)
    is_linear, remembers, dissipates, is_thermal, is_odd = True, False, False, True, True

    value: Annotated[float, Number("m", "mass", "kg", "positive", "It is the mass in kg.")]
    at: Point = field(default="", repr=False, kw_only=True)

    def __post_init__(self) -> None:
        super().__post_init__()
        if not isinstance(self.at, str) or (self.at and not self.at.isidentifier()) or self.at in ("ground", "mass"):
            raise ValueError(
                "at must be a name for the mass, of letters, digits and _ but not 'ground' or 'mass', not "
                f"{shown(self.at)}."
            )

    @property
    def inertia(self) -> float:
        """The mass."""
        return self.value
