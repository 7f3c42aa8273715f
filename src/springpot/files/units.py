"""The columns that a table of measurements may have: their names in use, and the size of each unit in SI units."""

from __future__ import annotations

import math
import re
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal

from springpot.machine.faults import listed, meant, shown

STANDARD_GRAVITY = 9.80665
"""g in m/s^2, exact by definition (3rd General Conference on Weights and Measures, 1901)."""
INCH = 0.0254
Decimal = Literal["", ".", ","]
"""The decimal mark of a file; empty if it is found from the content."""
FREQUENCY_UNITS = {"hz": 1.0, "Hz": 1.0, "kHz": 1e3, "rad/s": 0.5 / math.pi}
"""Units of frequency, in Hz."""

_ACCELERATION = {"m/s2": 1.0, "g": STANDARD_GRAVITY, "cm/s2": 0.01, "gal": 0.01, "Gal": 0.01, "mm/s2": 1e-3,
                 "in/s2": INCH, "ft/s2": 12.0 * INCH}  # fmt: skip
_MODULUS = {"Pa": 1.0, "kPa": 1e3, "MPa": 1e6, "GPa": 1e9, "N/m": 1.0, "N/mm": 1e3, "kN/m": 1e3}
_VELOCITY = {"m/s": 1.0, "mm/s": 1e-3, "cm/s": 0.01, "in/s": INCH}
_PER_HERTZ = {
    "m2/Hz": 1.0, "mm2/Hz": 1e-6, "m2/s2/Hz": 1.0, "mm2/s2/Hz": 1e-6, "m2/s4/Hz": 1.0, "m2/s3": 1.0,
    "g2/Hz": STANDARD_GRAVITY**2, "N2/Hz": 1.0, "kN2/Hz": 1e6,
}  # fmt: skip
_RESPONSE = {
    "m/N": 1.0, "mm/N": 1e-3, "um/N": 1e-6, "m/s/N": 1.0, "mm/s/N": 1e-3, "m/s2/N": 1.0, "g/N": STANDARD_GRAVITY,
    "s2": 1.0, "s": 1.0, "1": 1.0, "g/g": 1.0,
}  # fmt: skip
UNITS: dict[str, dict[str, float]] = {
    "frequency": FREQUENCY_UNITS,
    "time": {"s": 1.0, "ms": 1e-3, "min": 60.0},
    "x": {"m": 1.0, "mm": 1e-3, "um": 1e-6, "cm": 0.01, "in": INCH},
    "v": _VELOCITY,
    "a": _ACCELERATION,
    "force": {"N": 1.0, "kN": 1e3},
    "density": _PER_HERTZ | {unit.replace("Hz", "(rad/s)"): 2.0 * math.pi * size
                             for unit, size in _PER_HERTZ.items() if "Hz" in unit},
    "storage": _MODULUS,
    "loss": _MODULUS,
    "tan_delta": {"1": 1.0},
    "modulus": _MODULUS,
    "compliance": {"1/Pa": 1.0, "1/kPa": 1e-3, "1/MPa": 1e-6, "1/GPa": 1e-9, "m/N": 1.0, "mm/N": 1e-3, "mm/kN": 1e-6},
    "magnitude": _RESPONSE,
    "phase": {"deg": math.pi / 180.0, "rad": 1.0},
    "real": _RESPONSE,
    "imaginary": _RESPONSE,
    "coherence": {"1": 1.0},
    "before": _VELOCITY,
    "after": _VELOCITY,
}  # fmt: skip
"""What a column may be, and the units it may have."""
_BARE = {"coherence", "tan_delta"}  # need no unit
BY_UNIT = ("a", "density", "frequency", "force", "time")
"""What a column of another name is, where its unit says so."""

OF_INPUT = ("input", "excitation", "drive", "input force", "input acceleration")
"""Names of a column of what drove a device, a force or an acceleration by its unit."""
OF_GROUND = tuple(
    f"{place}{word}" for place in ("ground", "base", "table") for word in ("", " acceleration", " accel", " acc")
)
"""Names of a column of the acceleration of the ground."""
_NAMES = {
    "frequency": ("frequency", "freq", "f", "angular frequency", "angular freq", "ang frequency", "ang freq"),
    "time": ("time", "t", "elapsed time"),
    "x": ("x", "displacement", "displ", "disp"),
    "v": ("v", "velocity", "vel"),
    "a": ("a", "acceleration", "accel", "acc", *OF_GROUND, *OF_INPUT),
    "force": ("force", "load", "f", *OF_INPUT),
    "density": ("density", "psd", "asd", "spectral density", "power spectral density", "acceleration spectral density"),
    "storage": ("storage", "storage modulus", "e'", "g'", "k'"),
    "loss": ("loss", "loss modulus", "e''", "g''", "k''"),
    "tan_delta": ("tan delta", "tan d", "tan δ", "tandelta", "tan(delta)", "tan(δ)", "loss factor"),
    "modulus": ("modulus", "relaxation modulus", "relaxation", "e(t)", "g(t)", "k(t)"),
    "compliance": ("compliance", "creep compliance", "creep", "j(t)", "d(t)"),
    "magnitude": ("magnitude", "mag", "transmissibility"),
    "phase": ("phase", "phase angle"),
    "real": ("real", "re", "real part"),
    "imaginary": ("imaginary", "imag", "im", "imaginary part"),
    "coherence": ("coherence", "coh"),
    "before": ("before",),
    "after": ("after",),
}
_SAME_SIGNS = str.maketrans({"²": "2", "³": "3", "⁴": "4", "′": "'", "’": "'", "`": "'", "´": "'", "″": "''", "μ": "u",
                             "µ": "u", "\u00a0": " ", "·": " "})  # fmt: skip
_SPELLINGS = (
    ("**", ""), ("^", ""), ("seconds", "s"), ("second", "s"), ("secs", "s"), ("sec2", "s2"), ("sec", "s"),
    ("hertz", "Hz"), ("degrees", "deg"), ("degree", "deg"), ("°", "deg"), ("inches", "in"), ("inch", "in"),
    ("/s/s", "/s2"), ("m s-2", "m/s2"), ("m s-1", "m/s"), ("(m/s2)2", "m2/s4"), ("(m/s)2", "m2/s2"), ("(g)2", "g2"),
    ("(g2)", "g2"), ("g's", "g"), ("G's", "g"), ("gn", "g"), ("MPa-1", "1/MPa"), ("kPa-1", "1/kPa"),
    ("GPa-1", "1/GPa"), ("Pa-1", "1/Pa"),
)  # fmt: skip
"""Of the same unit, in this order."""
_LONGEST = 200  # characters of a header
_CHANNEL = re.compile(r"(.*?[a-z].*?)[ _-]?(?:[xyz]|ch ?\d{1,2}|\d{1,2})")
_CUT = re.compile(r"\s+in\s+|\s*[_,/:(\[{]|\s+(?=\S+$)")
_CLOSED = {"(": ")", "[": "]", "{": "}"}


@dataclass(frozen=True)
class Heading:
    """What the header says of a column.

    Attributes
    ----------
    text : str
        As in the file.
    quantity : str
        One of UNITS.
    unit : str
        One of its units.
    note : str
        What was assumed.
    """

    text: str
    quantity: str
    unit: str
    note: str = ""


def spelled(unit: str) -> str:
    """A unit as UNITS has it, if it is another spelling of one; else as it is.

    Examples
    --------
    >>> [spelled(text) for text in ("(sec)", "G", "G^2/Hz", "m/s/s", "[(m/s²)²/Hz]", "CM/SEC**2", "furlong")]
    ['s', 'g', 'g2/Hz', 'm/s2', 'm2/s4/Hz', 'cm/s2', 'furlong']
    """
    text = " ".join(unit.translate(_SAME_SIGNS).split())
    while len(text) > 2 and _CLOSED.get(text[0]) == text[-1] and _closes_last(text):
        text = text[1:-1].strip()
    own = "1" if text == "-" else text
    for _ in range(2):  # as it is, then with the small letters of what was written in capitals
        own = own.replace(" /", "/").replace("/ ", "/")
        for other, ours in _SPELLINGS:
            if other[0].isalpha():
                whole = rf"(?<![A-Za-z]){re.escape(other)}(?![A-Za-z])"
                own = re.sub(whole, ours, own, flags=re.IGNORECASE if len(other) > 3 or other == "sec" else 0)
            else:
                own = own.replace(other, ours)
        if own in _SIZES:
            return own
        own = own.lower() if own.isupper() or own == "hz" else re.sub(r"(?<![A-Za-z])G(?=2|\b(?!')|$)", "g", own)
    capitals = {known for known in _SIZES if known.upper() == own.upper()} if text.isupper() or "hz" in text else set()
    return capitals.pop() if len(capitals) == 1 else text


def _closes_last(text: str) -> bool:
    """Whether the bracket at the beginning closes at the end."""
    depth = 0
    for place, sign in enumerate(text):
        depth += (sign in _CLOSED) - (sign in _CLOSED.values())
        if depth == 0:
            return place == len(text) - 1
    return False


_SIZES = {unit for units in UNITS.values() for unit in units} - {"hz"}


def is_unit(text: str) -> bool:
    """Whether it is a unit of some column.

    Examples
    --------
    >>> is_unit("[m/s^2]"), is_unit("Acc")
    (True, False)
    """
    return spelled(text) in _SIZES


def quantities_of(unit: str) -> list[str]:
    """What has such a unit.

    Examples
    --------
    >>> quantities_of("G"), quantities_of("Pa")
    (['a'], ['storage', 'loss', 'modulus'])
    """
    return [quantity for quantity, units in UNITS.items() if spelled(unit) in units]


def heading_of(text: str, unit: str = "") -> Heading:
    """What a column is, and its unit, from its header.

    Parameters
    ----------
    text : str
    unit : str
        That of values whose header has none.

    Raises
    ------
    ValueError
        The rest of a sentence that begins with the place of the header.

    Examples
    --------
    >>> heading_of("frequency (rad/s)"), heading_of("Acc_g").quantity, heading_of("tan delta").quantity
    (Heading(text='frequency (rad/s)', quantity='frequency', unit='rad/s', note=''), 'a', 'tan_delta')
    >>> heading_of("Ch 3 [g]").note
    "'Ch 3 [g]' is taken for an acceleration, by its unit"
    """
    if len(text) > _LONGEST:
        raise ValueError(f"{shown(text)} is not a column: its header must have at most {_LONGEST} characters.")
    own = " ".join(text.translate(_SAME_SIGNS).split())
    whole = spelled(own)
    by_unit = [(quantity, whole) for quantity in BY_UNIT if whole in UNITS[quantity]]
    cuts = [] if by_unit else [*_CUT.finditer(own)]
    splits = [(own, ""), *((own[: cut.start()], own[cut.end() - (cut[0].strip() in _CLOSED) :]) for cut in cuts)]
    known = [(name, quantities, rest.strip()) for name, rest in splits if (quantities := _named(name))]
    for _, quantities, rest in known:
        for quantity in quantities:
            if rest and (found := spelled(rest)) in UNITS[quantity]:
                return Heading(text, quantity, found)
    for _, rest in splits:
        by_unit += [(quantity, found) for quantity in BY_UNIT if (found := spelled(rest)) in UNITS[quantity]]
    if by_unit and not any(rest and (len(name) > 1 or not is_unit(rest)) for name, _, rest in known):
        quantity, found = by_unit[0]
        word = {"a": "an acceleration", "density": "a spectral density", "force": "a force"}.get(
            quantity, f"the {quantity}"
        )
        return Heading(text, quantity, found, f"{shown(text)} is taken for {word}, by its unit")
    if not known:
        names = [name for own_names in _NAMES.values() for name in own_names]
        near = meant(re.split(r"[_(\[]", own.lower())[0].strip(), names)
        such = "time_s, acceleration_g, x_mm, frequency_hz, psd_g2/Hz, storage_Pa or magnitude_m/N"
        raise ValueError(f"{shown(text)} is not a column: its header must be a name and a unit, such as {such}"
                         f"{near or '; columns= gives another header, or leaves the column out.'}")  # fmt: skip
    name, quantities, rest = next((each for each in known if each[2]), known[0])
    if rest:
        units = listed([*dict.fromkeys(unit for quantity in quantities for unit in UNITS[quantity])], "or")
        raise ValueError(f"the unit of {name} must be {units}, not {shown(rest)}.")
    for quantity in quantities:
        if quantity in _BARE:
            return Heading(text, quantity, "1")
        if unit and quantity not in ("time", "frequency", "phase") and (found := spelled(unit)) in UNITS[quantity]:
            return Heading(text, quantity, found)
    such, other = f"{own}_{next(iter(UNITS[quantities[0]]))}", quantities[0] in ("time", "frequency", "phase")
    raise ValueError(f"{own} must have its unit, as {such}: {'columns=' if other else 'unit='} states it.")


def is_called(header: str, names: Sequence[str]) -> bool:
    """Whether a header has one of these names, perhaps with an axis or the number of a channel.

    Examples
    --------
    >>> is_called("Ground acceleration x (g)", OF_GROUND), is_called("acceleration_g", OF_GROUND)
    (True, False)
    """
    own = " ".join(header.translate(_SAME_SIGNS).split())
    begins = [own, *(own[: cut.start()] for cut in _CUT.finditer(own))]
    return any(name in names for begin in begins for name in _names_in(begin))


def _names_in(text: str) -> list[str]:
    """A name as those of columns are written, and the same without an axis or the number of a channel."""
    name = " ".join(text.lower().replace("_", " ").replace("-", " ").replace(".", " ").split())
    name = re.sub(r'(?<=\b[egk])"', "''", name)
    match = _CHANNEL.fullmatch(name)
    return [name, match[1].strip()] if match else [name]


def _named(text: str) -> list[str]:
    """What has such a name, perhaps with an axis or the number of a channel."""
    kinds = ([quantity for quantity, names in _NAMES.items() if name in names] for name in _names_in(text))
    return next(filter(None, kinds), [])
