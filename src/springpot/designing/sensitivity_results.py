"""What a sensitivity is: its numbers, in words, and as data."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from springpot.designing.quantities import MONTE_CARLO
from springpot.machine.faults import name_results
from springpot.machine.installed import need
from springpot.machine.plain import plain
from springpot.problem.system import System
from springpot.simulation.plan.settings import Settings

if TYPE_CHECKING:
    import xarray

Table = dict[str, dict[str, float]]


@dataclass(frozen=True, eq=False)
class Sensitivity:
    """Relative change of each quantity over the relative change of each number.

    Attributes
    ----------
    model : System
    method : str
        The analytical method, or ``"monte_carlo"``.
    numbers : dict
        Where they stand, by name.
    quantities : dict
        Their values there.
    values : dict of dict
        d ln(quantity) / d ln(number), as ``values[quantity][number]``; NaN where there is none.
    errors : dict of dict
        By Monte Carlo the standard error; by theory an estimate of the error of the differences, without that of the
        method itself.
    gains : dict of dict
        By Monte Carlo: the variance that independent random numbers on both sides would give, over that of the common
        ones; empty by theory.
    settings : Settings or None
        Of the runs, the same for all.
    warnings : tuple of str
        One sentence for each reason to doubt a number, or for its absence.
    """

    model: System
    method: str
    numbers: dict[str, float]
    quantities: dict[str, float]
    values: Table
    errors: Table
    gains: Table
    settings: Settings | None
    warnings: tuple[str, ...]

    def __post_init__(self) -> None:
        name_results(self, "numbers", "quantities", "values", "errors")

    def report(self, warnings: bool = True) -> str:
        """All of it in words.

        Parameters
        ----------
        warnings : bool
            With the warnings at its end.

        Examples
        --------
        >>> import springpot as sp
        >>> linear = sp.System(sp.Spring(9.0), sp.Dashpot(0.3), sp.WhiteNoise(1.0))
        >>> print(sp.sensitivity(linear, "x_mean_square").report())
        d ln(quantity) / d ln(number), by theory (exact)
        x_mean_square = 0.185185
          spring_stiffness      -1.00000
          dashpot_coefficient   -1.00000
          white_noise_intensity  1.00000
        """
        by_chance = self.method == MONTE_CARLO
        paths = self.settings.paths if self.settings is not None else 0
        how = f"Monte Carlo on common random numbers, {paths} paths" if by_chance else f"theory ({self.method})"
        lines = [f"d ln(quantity) / d ln(number), by {how}"]
        wide = max(map(len, self.numbers)) + 1
        for quantity, row in self.values.items():
            lines.append(f"{quantity} = {self.quantities[quantity]:.6g}")
            for name, value in row.items():
                if not by_chance:
                    lines.append(f"  {name:{wide}}{round(value, 5) + 0.0:8.5f}")  # no -0
                    continue
                gain = self.gains[quantity][name]
                lines.append(f"  {name:{wide}}{value:8.4f} +- {self.errors[quantity][name]:<8.2g} {_beats(gain)}")
        return "\n".join([*lines, *(self.warnings if warnings else ())])

    def to_dict(self) -> dict[str, Any]:
        """The numbers as plain values; NaN is None.

        Examples
        --------
        >>> import springpot as sp
        >>> linear = sp.System(sp.Spring(9.0), sp.Dashpot(0.3), sp.WhiteNoise(1.0))
        >>> round(sp.sensitivity(linear, "x_mean_square").to_dict()["values"]["x_mean_square"]["spring_stiffness"], 6)
        -1.0
        """

        names = "method", "numbers", "quantities", "values", "errors", "gains", "warnings"
        settings = None if self.settings is None else self.settings.to_dict()
        return plain({name: getattr(self, name) for name in names} | {"settings": settings})

    def to_xarray(self) -> xarray.Dataset:
        """An xarray Dataset over ``quantity`` and ``number``: ``sensitivity``, ``error`` and, by Monte Carlo, ``gain``.

        Examples
        --------
        >>> import springpot as sp
        >>> linear = sp.System(sp.Spring(9.0), sp.Dashpot(0.3), sp.WhiteNoise(1.0))
        >>> dict(sp.sensitivity(linear, ["x_mean_square", "v_mean_square"]).to_xarray().sizes)
        {'quantity': 2, 'number': 3}
        """
        need("files", "to_xarray()")
        import xarray

        tables = {"sensitivity": self.values, "error": self.errors, "gain": self.gains}
        return xarray.Dataset(
            {
                name: (("quantity", "number"), [[*row.values()] for row in table.values()])
                for name, table in tables.items() if table
            },
            coords={"quantity": [*self.values], "number": [*self.numbers]},
            attrs={"method": self.method},
        )  # fmt: skip


def _beats(gain: float) -> str:
    if math.isnan(gain):
        return ""
    if math.isinf(gain):
        return "(common numbers leave no variance)"
    word = f"{gain:.3g} times less" if gain >= 1.0 else f"{1.0 / gain:.3g} times more"
    return f"({word} variance than with independent numbers)"
