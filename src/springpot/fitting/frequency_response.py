"""A measured frequency response: frozen, checked when it is made, in SI units."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from springpot.fitting.columns import Measured, check_points, column, fixed, frequencies
from springpot.fitting.motion_data import Of, check_of
from springpot.machine.arguments import LARGEST, finite_number, numbers_in_array
from springpot.machine.arrays import Floats
from springpot.machine.faults import per_cent, shown
from springpot.problem.parts.checks import put

_MOST_ERROR = 0.5
_UNKNOWN_ERROR = 0.03  # of a phase, where none is stated
_CLEAR = 3.0  # errors by which the sign of a phase is known
_FEWEST_CLEAR = 3

_PASSIVE = {("x", "mass"): 1j, ("v", "mass"): 1.0, ("a", "mass"): -1j,
            ("x", "ground"): -1j, ("v", "ground"): -1.0, ("a", "ground"): 1j}  # fmt: skip
"""What a response to a force on the same mass, or of one mass to the ground, is multiplied by to have a positive real
part: that of a force is then a mobility, and its power is taken."""


@dataclass(frozen=True, eq=False, repr=False)
class MeasuredFrequencyResponse(Measured):
    """The complex response to a force on the mass or to an acceleration of the ground, against frequency.

    Parameters
    ----------
    frequency_hz : array_like, shape (n,)
        Positive, in ascending order, in Hz.
    response : array_like of complex, shape (n,)
        Output over input, for motions like exp(+i w t): of a force in m/N, (m/s)/N or (m/s^2)/N (receptance, mobility,
        accelerance); of the ground in s^2, s or 1.  A spring alone has a positive real receptance.
    averages : float, optional
        Number of independent averages, at least 2, with ``coherence``.
    coherence : array_like, shape (n,), optional
        The ordinary coherence of output and input at each frequency, between 0 and 1, as the analyser shows it.
    relative_error : float or array_like, shape (n,), optional
        In place of averages and coherence: standard deviation of the magnitude relative to it, and of the phase in rad.
        If none of these is given, it is estimated from the scatter about the fit, as one number for all points.
    of : {"x", "v", "a"}
        Displacement, velocity or acceleration.  Of the ground's motion x and v are relative to the ground, and the
        acceleration is that of the mass itself, so that its response is the transmissibility.
    on : str
        What the input is: a force on the ``"mass"``, or on one of several by its name, or the acceleration of the
        ``"ground"``.
    at : str, optional
        The mass whose motion is the output, by its name, where the model has several.

    Raises
    ------
    TypeError, ValueError
        If the columns are no numbers, have different lengths or fewer than three points, a number is out of its range,
        averages and coherence are not given together, or the sign of the phase is inverted.

    Notes
    -----
    Where the output is that of the mass that is pushed, the device takes power at every frequency: the imaginary part
    of a receptance is negative, the real part of a mobility and the imaginary part of an accelerance are positive, and
    the imaginary part of a transmissibility is negative.  Data of which clearly the contrary is true are refused.

    With n averages and a coherence g the random error of an estimate with the noise in the output is
    sqrt((1 - g) / (2 n g)) (J. S. Bendat and A. G. Piersol, "Random data", 4th edition, 2010, chapter 9).  Leakage of
    too short segments is not in the model: the resonance must be wider than some lines.

    Examples
    --------
    >>> measured = [1 + 0j, -2j, -0.3 - 0.1j]
    >>> found = MeasuredFrequencyResponse([1.0, 2.0, 4.0], measured, averages=50, coherence=[0.9, 0.98, 0.8])
    >>> found.size, found.errors.round(4).tolist()
    (6, [0.0333, 0.0143, 0.05])
    """

    frequency_hz: Any
    response: Any
    averages: float | None = None
    coherence: Any = None
    relative_error: Any = None
    of: Of = "x"
    on: str = "mass"
    at: str | None = None

    def __post_init__(self) -> None:
        frequency = frequencies(self.frequency_hz)
        response = numbers_in_array(self.response, "response must be a list of complex numbers", complex)
        if response.shape != frequency.shape:
            raise ValueError(
                f"response must have a number for each of the {frequency.size} points, not the shape {response.shape}."
            )
        wrong = ~((np.abs(response) > 0.0) & (np.abs(response) < LARGEST))
        check_points(wrong, response, "response", "must be a finite number other than 0, not {:g}.")
        put(self, frequency_hz=frequency, response=fixed(response))
        check_of(self.of, self.at)
        if not isinstance(self.on, str):
            raise TypeError(
                f"on must be 'mass' (a force on it), the name of a mass, or 'ground' (its acceleration), not "
                f"{shown(self.on)}."
            )
        if (self.averages is None) != (self.coherence is None):
            raise ValueError("averages and coherence must be given together: the error depends on both.")
        if self.averages is not None:
            if self.relative_error is not None:
                raise ValueError("relative_error must be left out beside averages and coherence.")
            put(self, averages=finite_number(self.averages, "averages", low=2.0, high=LARGEST))
            coherence = column(self.coherence, "coherence", frequency.size)
            outside = (coherence <= 0.0) | (coherence >= 1.0)
            check_points(outside, coherence, "coherence", "must be above 0 and below 1, not {:g}.")
            put(self, coherence=coherence)
            errors = np.asarray(self.errors)
            worst = per_cent(errors[np.argmax(errors > _MOST_ERROR)], 3)
            words = f"is too small: with {self.averages:g} averages the error of this point is {worst}. "
            words += "Leave out points with an error above 50 %."
            check_points(errors > _MOST_ERROR, errors, "coherence", words)
        elif self.relative_error is not None:
            given = numbers_in_array(self.relative_error, "relative_error must be a number, or one for each frequency")
            error = column(given if given.ndim else np.full(frequency.shape, given), "relative_error", frequency.size)
            words = "must be above 0 and at most 0.5: 2 % is 0.02, not {:g}."
            check_points((error <= 0.0) | (error > _MOST_ERROR), error, "relative_error", words)
            put(self, relative_error=error)
        self._check_phase()

    def _check_phase(self) -> None:
        """Refuse the complex conjugate, which some programs write, where the response itself shows it."""
        if self.at != (None if self.on in ("mass", "ground") else self.on):
            return  # of another mass than the one that is pushed, no sign is known
        factor = _PASSIVE[self.of, "ground" if self.on == "ground" else "mass"]
        taken = (factor * self.response).real / np.abs(self.response)  # sine of the angle from a phase without loss
        error = _UNKNOWN_ERROR if self.errors is None else self.errors
        wrong, right = (int((sign * taken > _CLEAR * error).sum()) for sign in (-1.0, 1.0))
        if wrong < _FEWEST_CLEAR or right:
            return
        part, passive = ("real" if self.of == "v" else "imaginary"), "positive" if factor in (1.0, -1j) else "negative"
        phase = "the sign of its phase is inverted: give response.conj(), or in a file the column phase, or imaginary, "
        cause = "" if self.of == "v" else f"{phase}times -1; or "
        raise ValueError(
            f"response must have a {passive} {part} part, as of a passive device and motions like exp(+i w t), but it "
            f"clearly has not at {wrong} of {taken.size} points: {cause}output and input are counted in opposite "
            "directions: give -response."
        )

    @property
    def errors(self) -> Floats | None:
        """Standard deviation of each magnitude relative to it, and of each phase in rad; None if it is not known."""
        if self.coherence is not None and self.averages is not None:
            with np.errstate(over="ignore"):  # an error that is infinite is refused
                return np.asarray(np.sqrt((1.0 - self.coherence) / (2.0 * self.averages * self.coherence)))
        return None if self.relative_error is None else np.asarray(self.relative_error)

    @property
    def size(self) -> int:
        """Of all numbers: a magnitude and a phase at each frequency."""
        return 2 * int(self.response.size)
