"""Records of the ground as PEER has them (.AT2, .VT2, .DT2), in the SMC and in the COSMOS format."""

from __future__ import annotations

import itertools
import re
from array import array
from collections.abc import Iterable, Sequence

import numpy as np

from springpot.files.table import MOST_NUMBERS, RATES, Column, Stated, Table
from springpot.files.text import Line, are_numbers
from springpot.files.units import UNITS, quantities_of, spelled
from springpot.machine.arrays import Floats
from springpot.machine.faults import FileError, few, listed, shown

_NUMBER = re.compile(r"[+-]?(?:\d+\.?\d*|\.\d+)(?:[EeDd][+-]?\d+)?")
_UNIT = re.compile(
    r"\bUNITS?\b(?:\s|OF|ARE|IS|IN|[:=(])*([A-Z%][A-Z0-9/*^.]*)|\bIN\s+\(?(G|CM(?:/\S+)?|M(?:/\S+)?)(?=[\s)]|$)"
)
_MOST_WORDS = 100  # lines before the numbers
_WORDS = {"ACCEL": "a", "VELOC": "v", "DISPL": "x"}


def is_peer(head: Sequence[Line]) -> bool:
    """Whether a text has the line of PEER's records.

    Examples
    --------
    >>> is_peer([(4, "NPTS=   40, DT= .02000 SEC")]), is_peer([(1, "time_s,acceleration_g")])
    (True, False)
    """
    return any(_has_points(text) for _, text in head[:_MOST_WORDS])


def _has_points(text: str) -> bool:
    """Whether a line states the number of points and their step; not in a comment of a table."""
    return {"NPTS", "DT"} <= {*re.split(r"\W+", text.upper())} and text.lstrip()[:1] not in ("#", "%", "/")


def read_peer(lines: Iterable[Line], title: str, stated: Stated) -> Table:
    """A record in PEER's layout, whose fourth line or so has the number of points and their step.

    Raises
    ------
    FileError
        If the numbers are not as many as the file says, or its unit is not known.

    Examples
    --------
    >>> text = "SOME RECORD\\nACCELERATION IN UNITS OF G\\n2 0.01 NPTS, DT\\n .1E+00-.2E+00\\n"
    >>> read = read_peer([*enumerate(text.splitlines(), 1)], "a.at2", Stated())
    >>> read.rate, [round(value, 6) for value in read.columns[0].values.tolist()]
    (100.0, [0.980665, -1.96133])
    """
    stated.refuse(title, "which states them", "rate", "columns", "decimal")
    words: list[str] = []
    rows: list[Line] = []
    count = step = None
    for at, text in lines:
        if count is None:
            words.append(text)
            if _has_points(text):
                count, step = _points_and_step(text, f"{title}, line {at}")
        elif rows or are_numbers(text):
            if text.strip():
                rows.append((at, text))
        else:
            words.append(text)
    assert count is not None
    assert step is not None
    values, places = _values(rows, count, title)
    if len(values) != count:
        raise FileError(f"{title} states NPTS = {count}, and has {len(values)} numbers: correct the line with NPTS, or "
                        "the numbers.")  # fmt: skip
    whole = " ".join(words).upper()
    quantity, unit = _quantity_and_unit(whole, stated, title)
    return Table(title, [Column(quantity, quantity, unit, values * UNITS[quantity][unit])], places, 1.0 / step)


def _points_and_step(text: str, where: str) -> tuple[int, float]:
    """The number of points and their step, in s, from the line that has them in one of several forms."""
    words = re.sub(r"[=:,;()]", " ", text.upper()).split()
    words = [word for word in (re.sub(r"(?<=[\d.])S(EC)?\.?$", "", word) for word in words) if word not in ("SEC", "S")]
    i, j = (words.index(name) if name in words else -1 for name in ("NPTS", "DT"))
    if j == i + 1:  # both names, then both numbers, or before
        at = j + 1 if len(words) > j + 2 and words[j + 1].isdigit() else i - 2
        found = words[at : at + 2] if at >= 0 else []
    else:
        found = [*words[i + 1 : i + 2], *words[j + 1 : j + 2]]
    if min(i, j) < 0 or len(found) < 2 or not found[0].isdigit() or not _NUMBER.fullmatch(found[1]):
        raise FileError(f"{where}: it must state the points and their step, as NPTS= 4000, DT= .005 SEC, not "
                        f"{shown(text.strip())}.")  # fmt: skip
    count, step = int(found[0]), float(found[1].replace("D", "E"))
    if not (0 < count <= MOST_NUMBERS and RATES[0] < step < RATES[1]):
        raise FileError(f"{where}: NPTS and DT must be greater than 0, not {count} and {step:g}.")
    return count, step


def _values(rows: Sequence[Line], count: int, title: str, width: int = 0) -> tuple[Floats, array[int]]:
    """The numbers in lines, between blanks or in columns of one width that touch, and the line of each."""
    numbers, lines = array("d"), array("I")
    fault, counts = "", []
    for at, text in rows:
        words = [text[n : n + width] for n in range(0, len(text.rstrip()), width)] if width else text.split()
        if not all(_NUMBER.fullmatch(word.strip()) and (not width or "." in word) for word in words):
            fault = fault or f"{title}, line {at}: {shown(text.strip())} is no row of numbers."
            continue
        counts.append(len(words))
        numbers.extend([float(word.replace("D", "E")) for word in words])
        lines.extend([at] * len(words))
    if not fault and counts and (uneven := [n for n, own in enumerate(counts[:-1]) if own != counts[0]]):
        where = f"{title}, line {rows[uneven[0]][0]}"
        raise FileError(f"{where}: {counts[0]} numbers are needed, as in the first line, not {counts[uneven[0]]}.")
    if not fault:
        return np.asarray(numbers), lines
    if width:
        return np.empty(0), lines
    longest = max(len(text.rstrip()) for _, text in rows)
    found = []
    for each in range(1, 21):
        last, rest = count - each * (len(rows) - 1), divmod(longest, each)
        if 0 < last <= each and not rest[1] and len(rows[-1][1].rstrip()) == last * rest[0]:
            own, places = _values(rows, count, title, rest[0])
            if len(own) == count:
                found.append((own, places))
    if len(found) != 1:
        raise FileError(fault)
    return found[0]


def _quantity_and_unit(words: str, stated: Stated, title: str) -> tuple[str, str]:
    """What the numbers are, and in which unit, from the words before them."""
    named = [spelled(unit.rstrip(".")) for match in _UNIT.findall(words) for unit in match if unit]
    units = {unit for unit in named if {*quantities_of(unit)} & {*_WORDS.values()}}
    quantities = {quantity for word, quantity in _WORDS.items() if word in words}
    if len(units) > 1 or (named and not units and not stated.unit):
        raise FileError(f"{title}: its first lines must name one unit, such as UNITS OF G, not "
                        f"{listed([*map(shown, dict.fromkeys(named))])}; unit= states it.")  # fmt: skip
    if units and stated.unit and units != {spelled(stated.unit)}:
        raise FileError(f"unit must be left out of {title}, which states {units.pop()}.")
    if not (unit := units.pop() if units else spelled(stated.unit)):
        raise FileError(f"{title} does not say the unit of its numbers: give unit=, such as unit='g'.")
    quantity = next((each for each in quantities_of(unit) if each in _WORDS.values()), "")
    if not quantity or (len(quantities) == 1 and quantity not in quantities):
        raise FileError(f"{title}: {unit} is no unit of what its first lines name.")
    return quantity, unit


_SMC_TEXT, _SMC_WHOLE, _SMC_REAL = 11, 6, 10  # lines of the header of the SMC format
_SMC_KINDS = {"ACCELEROGRAM": ("a", "cm/s2"), "VELOCITY": ("v", "cm/s"), "DISPLACEMENT": ("x", "cm")}


def is_smc(head: Sequence[Line]) -> bool:
    """Whether a text is in the SMC format: its kind, 10 lines of words, 6 of whole numbers, 10 of numbers."""
    if len(head) < _SMC_TEXT + _SMC_WHOLE + _SMC_REAL or not any(kind in head[0][1].upper() for kind in _SMC_KINDS):
        return False
    numbers = head[_SMC_TEXT : _SMC_TEXT + _SMC_WHOLE]
    return all(re.fullmatch(r"[\s\d-]*", text) and text.strip() for _, text in numbers)


def read_smc(lines: Iterable[Line], title: str, stated: Stated) -> Table:
    """A record in the SMC format of the U.S. Geological Survey: accelerations in cm/s2, velocities in cm/s.

    Raises
    ------
    FileError
        If the numbers are not as many as the file says, or its header is damaged.
    """
    stated.refuse(title, "which states them", "rate", "columns", "decimal", "unit")
    rows = [(at, text.rstrip()) for at, text in lines]
    kind = next(kind for kind in _SMC_KINDS if kind in rows[0][1].upper())
    whole = _fields(rows[_SMC_TEXT : _SMC_TEXT + _SMC_WHOLE], 10, title)
    real = _fields(rows[_SMC_TEXT + _SMC_WHOLE : _SMC_TEXT + _SMC_WHOLE + _SMC_REAL], 15, title)
    if len(whole) != 48 or len(real) != 50:
        raise FileError(f"{title}: the header of an SMC file has 48 whole numbers and 50 others, not {len(whole)} and "
                        f"{len(real)}.")  # fmt: skip
    comments, count, rate = int(whole[15]), int(whole[16]), real[1]
    if not (0 <= comments < len(rows) and 0 < count <= MOST_NUMBERS and RATES[0] < rate < RATES[1]):
        raise FileError(f"{title}: its header states {comments} comments, {count} values and {rate:g} samples per "
                        "second, which cannot be.")  # fmt: skip
    begin = _SMC_TEXT + _SMC_WHOLE + _SMC_REAL + comments
    values = _fields([row for row in rows[begin:] if row[1].strip()], 14 if whole[46] == 8 else 10, title)
    if len(values) != count:
        raise FileError(f"{title} states {count} values, and has {len(values)}: correct its header, or the numbers.")
    quantity, unit = _SMC_KINDS[kind]
    return Table(title, [Column(kind.lower(), quantity, unit, np.array(values) * UNITS[quantity][unit])], rate=rate)


_COSMOS_REAL = re.compile(r"\s*(\d+) Real-header values follow on\s+(\d+) lines, Format= ?\(\d+F(\d+)\.\d+\)\s*")
_COSMOS_DATA = re.compile(
    r"\s*(\d+) (\w+) pts, approx\s+(\d+) secs, units= ?([^,(]*)(?:\(\d+\))?, ?"
    r"Format= ?\(\d+[EFI](\d+)(?:\.\d+)?E?\d*\)\s*"
)
_COSMOS_STEPS = 62, 34  # of the real header: the step of the series in ms, and that of the recorder


def is_cosmos(head: Sequence[Line]) -> bool:
    """Whether a text has the header of the COSMOS strong-motion format."""
    return any(_COSMOS_REAL.fullmatch(text) for _, text in head)


def read_cosmos(lines: Iterable[Line], title: str, stated: Stated) -> Table:
    """A record of one channel in the COSMOS strong-motion format, version 1.20; of several the one in ``columns``.

    Raises
    ------
    FileError
        If the numbers are not as many as the file says, their step is not known, or it is not said which channel.
    """
    stated.refuse(title, "which states them", "rate", "decimal", "unit")
    every = [(at, text.rstrip()) for at, text in lines]
    ends = [n + 1 for n, (_, text) in enumerate(every) if text.startswith("End-of-data")]
    pieces = [every[begin:end] for begin, end in itertools.pairwise([0, *ends, len(every)])]
    channels = [piece for piece in pieces if any(_COSMOS_DATA.fullmatch(text) for _, text in piece)]
    names = [f"channel {number}" for number in range(1, len(channels) + 1)]
    chosen = dict.fromkeys(names, "") if stated.columns is None else stated.columns
    if not isinstance(chosen, dict) or len(chosen) != 1 or {*chosen} - {*names} or any(chosen.values()):
        which = few(names) if names else "no values"
        raise FileError(f"{title} has {which}, and one is read: choose it, such as columns={{'channel 1': ''}}.")
    rows = channels[names.index(*chosen)]
    found = [(n, match) for n, (_, text) in enumerate(rows) if (match := _COSMOS_DATA.fullmatch(text))]
    reals = [(n, match) for n, (_, text) in enumerate(rows) if (match := _COSMOS_REAL.fullmatch(text))]
    if len(found) != 1 or not reals:
        raise FileError(f"{title} seems damaged: a channel must have one header of real numbers, and one series.")
    (begin, data), count, duration = found[0], int(found[0][1][1]), int(found[0][1][3])
    header, real = reals[0]
    numbers = _fields(rows[header + 1 : header + 1 + int(real[2])], int(real[3]), title)
    end = next((n for n, (_, text) in enumerate(rows) if text.startswith("End-of-data")), len(rows))
    values = _fields([row for row in rows[begin + 1 : end] if row[1].strip()], max(1, int(data[5])), title)
    if len(numbers) != int(real[1]) or len(values) != count:
        has = f"{len(numbers)} and {len(values)}: correct them"
        raise FileError(f"{title} states {real[1]} numbers of its header and {count} values, and has {has}.")
    steps = [1e-3 * numbers[place - 1] for place in _COSMOS_STEPS if place <= len(numbers)]
    step = next((step for step in steps if abs(step * count - duration) <= 1.0 + 0.01 * duration), 0.0)
    if not RATES[0] < step < RATES[1]:
        raise FileError(f"{title} does not state the step of its {count} values in about {duration} s: give them as a "
                        "table, with rate=.")  # fmt: skip
    unit = spelled(data[4])
    quantity = next((quantity for quantity in quantities_of(unit) if quantity in _WORDS.values()), "")
    if not quantity or quantity != next((own for word, own in _WORDS.items() if data[2].upper().startswith(word)), ""):
        raise FileError(f"{title} has {shown(data[2])} in {shown(data[4].strip())}, which is not read.")
    return Table(title, [Column(data[2], quantity, unit, np.array(values) * UNITS[quantity][unit])], rate=1.0 / step)


def _fields(rows: Sequence[Line], width: int, title: str) -> list[float]:
    """Numbers in columns of one width."""
    found = []
    for at, text in rows:
        for place in range(0, len(text), width):
            if not _NUMBER.fullmatch(word := text[place : place + width].strip()):
                raise FileError(f"{title}, line {at}: {shown(word)} is no number of {width} characters.")
            found.append(float(word.replace("D", "E")))
    return found
