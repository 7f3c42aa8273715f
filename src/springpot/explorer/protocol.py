"""The messages that a tab may send: one JSON object each, validated completely before it is used; and binary replies.

A binary reply is a short header and arrays of single-precision numbers, which JavaScript reads in place.
"""

from __future__ import annotations

import struct
from collections.abc import Sequence
from typing import Annotated, Literal

import numpy as np
import numpy.typing as npt
from pydantic import BaseModel, ConfigDict, Field, TypeAdapter, ValidationError

LONGEST_MESSAGE = 16_384  # bytes; some 100, and 50 for each number that was changed
MOST_NUMBERS = 400
MOST_FREE = 20
MOST_PARTS, LONGEST_PART = 200, 7_500  # of a file of data: 1.5 MB
MOST_PATHS = 100_000
MOST_DEVICES = 4096
_Generation = Annotated[int, Field(ge=0, le=2**31 - 1)]
_Name = Annotated[str, Field(max_length=200)]
Length = Literal["m", "mm"]


class _Strict(BaseModel):
    model_config = ConfigDict(extra="forbid", frozen=True, strict=True, allow_inf_nan=False)


class Problem(_Strict):
    """The system of the page with other numbers, and the number of paths; the tab starts from the beginning.

    Parameters
    ----------
    generation : int
        Number of the problem; its results have the same number.
    numbers : dict
        Those that differ from what the page was opened with, by the names of their sliders.
    tolerances : dict
        Those that differ from what the page was opened with, by the names of the uncertain numbers; 0 for none.
    without : list of str
        Names of parts that are left out, such as a wall.
    seed, paths : int
    start : {"stationary", "rest"}
        Without a stationary state the run starts from rest.

    Examples
    --------
    >>> Problem(numbers={"springpot-order": 1.0}).seed
    1
    """

    kind: Literal["problem"] = "problem"
    generation: _Generation = 0
    numbers: Annotated[dict[str, float], Field(max_length=MOST_NUMBERS)] = {}
    tolerances: Annotated[dict[str, Annotated[float, Field(ge=0.0)]], Field(max_length=MOST_NUMBERS)] = {}
    without: Annotated[list[_Name], Field(max_length=MOST_NUMBERS)] = []
    seed: Annotated[int, Field(ge=0, le=2**53 - 1)] = 1  # what JavaScript holds exactly
    paths: Annotated[int, Field(ge=2, le=MOST_PATHS)] = 10_000
    start: Literal["rest", "stationary"] = "stationary"


class File(_Strict):
    """Send the system's file, with the numbers of now."""

    kind: Literal["file"]


class FilePart(_Strict):
    """A part of a file of measured data, a system or a table of densities; ``part`` 0 begins another file.

    Parameters
    ----------
    kind, name
    part, of : int
        Its number, and how many there are.
    text : str
        Of a binary file its bytes in base64.
    binary : bool
    unit : str
        Of a table of densities whose file does not say it.
    """

    kind: Literal["data", "system", "table"]
    name: Annotated[str, Field(min_length=1, max_length=200)]
    part: Annotated[int, Field(ge=0, lt=MOST_PARTS)]
    of: Annotated[int, Field(ge=1, le=MOST_PARTS)]
    text: Annotated[str, Field(max_length=LONGEST_PART)]
    binary: bool = False
    unit: Annotated[str, Field(max_length=20)] = ""


class Fit(_Strict):
    """Fit numbers of the system, by the names of their sliders, to the file of data."""

    kind: Literal["fit"]
    free: Annotated[list[_Name], Field(max_length=MOST_FREE)]


class Observe(_Strict):
    """Simulate the system of now again, and see more of it.

    Parameters
    ----------
    forces : list of str
        Forces and accelerations: their moments and histograms.
    levels_of, levels
        Of which displacement or force the first passages of levels are wanted.
    cycles_of, exponent, strength, cycles
        Of which displacement or force the cycles are counted, and the numbers of its `Basquin` curve.
    bins : int
        Of the profiles over time; 0 for none.
    length : {"m", "mm"}
        Of lengths and speeds in what is asked and in what is found.

    Examples
    --------
    >>> Observe(kind="observe", forces=["spring_force"]).bins
    0
    """

    kind: Literal["observe"]
    forces: Annotated[list[_Name], Field(max_length=MOST_FREE)] = []
    levels_of: _Name = ""
    levels: Annotated[list[float], Field(max_length=MOST_FREE)] = []
    cycles_of: _Name = ""
    exponent: float = 3.0
    strength: float = 1.0
    cycles: float = 1.0
    bins: Annotated[int, Field(ge=0, le=400)] = 0
    length: Length = "m"


class Rare(_Strict):
    """Find how likely levels of a quantity are exceeded within a time, and how often they are, from low to high.

    Parameters
    ----------
    of : str
    low, high : float
        The first and the last level.
    duration : float
        In s.
    rtol : float
        As in `springpot.exceedance`.
    length : {"m", "mm"}
        Of lengths and speeds in what is asked and in what is found.

    Examples
    --------
    >>> Rare(kind="rare", of="x", low=2.0, high=5.0, duration=60.0).rtol
    0.2
    """

    kind: Literal["rare"]
    of: _Name
    low: float
    high: float
    duration: float
    rtol: float = 0.2
    length: Length = "m"


class Scatter(_Strict):
    """Simulate devices that differ by the tolerances of now, as `springpot.scatter` does.

    Examples
    --------
    >>> Scatter(kind="scatter").devices
    512
    """

    kind: Literal["scatter"]
    devices: Annotated[int, Field(ge=64, le=MOST_DEVICES)] = 512
    length: Length = "m"


class StopWork(_Strict):
    """End a fit, with the best numbers so far, or what was asked beside; what is known by then stays."""

    kind: Literal["stop-fit", "stop-observing", "stop-rare", "stop-scatter"]


class Play(_Strict):
    """Run or stop time; ``speed`` is in units of 1 / Omega per second."""

    kind: Literal["play"]
    playing: bool
    speed: Annotated[float, Field(ge=0.01, le=1000.0)]


class Step(_Strict):
    """While time is stopped: advance by a small time step, and simulate a few more paths."""

    kind: Literal["step"]


class NextPath(_Strict):
    """Show another path of the ensemble."""

    kind: Literal["next-path"]


AnyMessage = Problem | File | FilePart | Fit | Observe | Rare | Scatter | StopWork | Play | Step | NextPath
_MESSAGES: TypeAdapter[AnyMessage] = TypeAdapter(Annotated[AnyMessage, Field(discriminator="kind")])


def parse(text: object) -> AnyMessage:
    """Parse and validate a message of a tab.

    Parameters
    ----------
    text : object
        The text of one WebSocket message.

    Raises
    ------
    ValueError
        One sentence: the error and the allowed values.

    Examples
    --------
    >>> parse('{"kind": "play", "playing": false, "speed": 2}').speed
    2.0
    >>> parse('{"kind": "problem", "paths": 1}')
    Traceback (most recent call last):
        ...
    ValueError: paths: input should be greater than or equal to 2.
    """
    if not isinstance(text, str):
        raise ValueError("a message must be text, one JSON object.")
    if len(text) > LONGEST_MESSAGE:
        raise ValueError(f"a message must not be longer than {LONGEST_MESSAGE} characters.")
    try:
        return _MESSAGES.validate_json(text)
    except ValidationError as error:
        # the first that pydantic reports, without the input, which may be long or not printable
        first = error.errors(include_url=False, include_input=False, include_context=False)[0]
        places = [str(place)[:40] for place in first["loc"][1:]]  # after the kind of message
        reason = first["msg"][:160]
        raise ValueError(f"{places[-1] if places else 'message'}: {reason[:1].lower()}{reason[1:]}.") from None


MOTION, DENSITIES, GROWTH = 1, 2, 3


def pack(kind: int, generation: int, arrays: Sequence[npt.ArrayLike]) -> bytes:
    """Kind, generation and number of arrays, their lengths (all as 32-bit whole numbers), then their numbers.

    Examples
    --------
    >>> struct.unpack("<5I2f", pack(MOTION, 7, [[1.0, 2.0], []]))
    (1, 7, 2, 2, 0, 1.0, 2.0)
    """
    packed = [np.asarray(array, "<f4").ravel() for array in arrays]
    header = struct.pack(f"<{3 + len(packed)}I", kind, generation, len(packed), *(array.size for array in packed))
    return header + b"".join(array.tobytes() for array in packed)
