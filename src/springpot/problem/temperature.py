"""Time-temperature superposition: a material at another temperature is the same one at other times."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import TypeVar, cast

import numpy as np

from springpot.machine.arguments import LARGEST, check_plain, finite_number, numbers_in_array, positive_number
from springpot.problem.parts.registration import Part
from springpot.problem.system import System, checked_system

Model = TypeVar("Model")

_GAS = 8.314462618  # J/(mol K)
_ZERO = -273.15  # K, in degrees Celsius
_MOST = 50.0  # decades
_CELSIUS = "It is in degrees Celsius."
_MARK_SHIFTED = "mark numbers of the shifted parts instead"


@dataclass(frozen=True, repr=False)
class Shift:
    """The shift factor a of a material: at another temperature all its times are a times those at the reference.

    It is made by `wlf`, `arrhenius` or `table`, and `at` puts a part or a system to a temperature.

    Attributes
    ----------
    words : str
        How it was made.
    decades : callable
        log10 a at a temperature in degrees Celsius.

    Notes
    -----
    A modulus K(w) becomes K(a w).  So springs stay as they are, a dashpot c becomes a c and a springpot C becomes
    C a^order, alone and in an arm.  That the stiffness of rubber itself grows like its absolute temperature, 0.3 % per
    degree, is not counted.

    Examples
    --------
    A mount that was measured at 20 degrees, at 0:

    >>> import springpot as sp
    >>> rubber = sp.Shift.wlf(8.86, 101.6, reference=20.0)
    >>> round(rubber.of(0.0), 1)
    148.4
    >>> mount = sp.System(sp.Mass(0.8), sp.Spring(3200.0), sp.Springpot(0.3, 150.0))
    >>> cold = rubber.at(0.0, mount)
    >>> cold.of(sp.Spring)[0].stiffness, round(cold.of(sp.Springpot)[0].coefficient)
    (3200.0, 672)
    """

    words: str
    decades: Callable[[float], float]

    def __repr__(self) -> str:
        """How it was made."""
        return self.words

    @classmethod
    def wlf(cls, c1: float, c2: float, *, reference: float) -> Shift:
        """The law of Williams, Landel and Ferry: log10 a = -c1 (T - reference) / (c2 + T - reference).

        Parameters
        ----------
        c1 : float
            Of logarithms to the base 10.
        c2 : float
            In K.
        reference : float
            In degrees Celsius.

        Raises
        ------
        TypeError, ValueError
            If a number is not one, or not above 0.

        References
        ----------
        M. L. Williams, R. F. Landel and J. D. Ferry, "The temperature dependence of relaxation mechanisms in amorphous
        polymers and other glass-forming liquids", Journal of the American Chemical Society 77 (1955).

        Examples
        --------
        >>> round(Shift.wlf(17.44, 51.6, reference=-60.0).of(-50.0), 6)
        0.001475
        """
        for name, value in (("c1", c1), ("c2", c2), ("reference", reference)):
            check_plain(value, name, _MARK_SHIFTED)
        first = positive_number(c1, "c1")
        second = positive_number(c2, "c2", "It is in K.")
        base = finite_number(reference, "reference", low=_ZERO, high=LARGEST, hint=_CELSIUS)

        def decades(celsius: float) -> float:
            apart = celsius - base
            if apart <= -second:
                raise ValueError(f"celsius must be above {base - second:g}, where this law ends, not {celsius:g}.")
            return -first * apart / (second + apart)

        return cls(f"Shift.wlf({first:g}, {second:g}, reference={base:g})", decades)

    @classmethod
    def arrhenius(cls, energy: float, *, reference: float) -> Shift:
        """Arrhenius's law: ln a = energy / R (1 / T - 1 / reference), of absolute temperatures.

        Parameters
        ----------
        energy : float
            Of activation, in J/mol.
        reference : float
            In degrees Celsius.

        Raises
        ------
        TypeError, ValueError
            If a number is not one or out of its range.

        Examples
        --------
        >>> round(Shift.arrhenius(90e3, reference=20.0).of(30.0), 4)
        0.2958
        """
        for name, value in (("energy", energy), ("reference", reference)):
            check_plain(value, name, _MARK_SHIFTED)
        height = positive_number(energy, "energy", "It is in J/mol.")
        base = finite_number(reference, "reference", low=_ZERO, high=LARGEST, open_low=True, hint=_CELSIUS)
        slope = height / (_GAS * math.log(10.0))
        return cls(
            f"Shift.arrhenius({height:g}, reference={base:g})",
            lambda celsius: slope * (1.0 / (celsius - _ZERO) - 1.0 / (base - _ZERO)),
        )

    @classmethod
    def table(cls, celsius: Sequence[float], factors: Sequence[float]) -> Shift:
        """Measured factors, between which log a is a straight line.

        Parameters
        ----------
        celsius : sequence of float
            At least two, ascending, in degrees Celsius.
        factors : sequence of float
            a at each, above 0; 1 at the reference.

        Raises
        ------
        TypeError, ValueError
            If they are not as said.

        Examples
        --------
        >>> round(Shift.table([0.0, 20.0, 40.0], [100.0, 1.0, 0.1]).of(10.0), 9)
        10.0
        """
        for name, value in (("celsius", celsius), ("factors", factors)):
            check_plain(value, name, _MARK_SHIFTED)
        at = numbers_in_array(celsius, "celsius must be a list of numbers")
        found = numbers_in_array(factors, "factors must be a list of numbers")
        if at.ndim != 1 or at.size < 2 or found.shape != at.shape:
            raise ValueError("celsius and factors must have as many numbers, two or more.")
        if not (np.isfinite(at).all() and at[0] >= _ZERO and (np.diff(at) > 0.0).all()):
            raise ValueError(f"celsius must ascend from {_ZERO} or above.")
        if not (np.isfinite(found).all() and (found > 0.0).all()):
            raise ValueError("factors must be above 0.")
        logs = np.log10(found)

        def decades(asked: float) -> float:
            if not at[0] <= asked <= at[-1]:
                raise ValueError(f"celsius must be in the table, from {at[0]:g} to {at[-1]:g}, not {asked:g}.")
            return float(np.interp(asked, at, logs))

        return cls(f"Shift.table({at.tolist()}, {found.tolist()})", decades)

    def of(self, celsius: float) -> float:
        """The factor a at a temperature.

        Parameters
        ----------
        celsius : float
            In degrees Celsius.

        Raises
        ------
        TypeError, ValueError
            If it is no temperature, or the law does not reach it.

        Examples
        --------
        >>> Shift.wlf(8.86, 101.6, reference=20.0).of(20.0)
        1.0
        """
        check_plain(celsius, "celsius", _MARK_SHIFTED)
        warm = finite_number(celsius, "celsius", low=_ZERO, high=LARGEST, open_low=True, hint=_CELSIUS)
        found = self.decades(warm)
        if abs(found) > _MOST:
            raise ValueError(f"celsius must be nearer to the reference: at {warm:g} the factor is 10^{found:.0f}.")
        return math.pow(10.0, found)

    def at(self, celsius: float, model: Model) -> Model:
        """A part, or a system with all its parts, at a temperature.

        Parameters
        ----------
        celsius : float
            In degrees Celsius.
        model : System or part
            At the reference.  Of a system in which not all parts are of one material, give the parts.

        Returns
        -------
        System or part
            Of the same kind and names; free and uncertain numbers stay so.

        Raises
        ------
        TypeError, ValueError
            As `of`, or if the model is none, or the order of a springpot is free or uncertain.

        Examples
        --------
        >>> from springpot.problem.parts import Dashpot
        >>> Shift.table([0.0, 20.0], [4.0, 1.0]).at(0.0, Dashpot(0.5))
        Dashpot(coefficient=2.0)
        """
        factor = self.of(celsius)
        if isinstance(model, Part):
            return model.slowed(factor)
        stated = checked_system(model, "model", "a System or a part").stated()
        return cast(Model, System(**{name: part.slowed(factor) for name, part in stated}))
