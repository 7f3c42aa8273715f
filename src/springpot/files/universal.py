"""Functions of a universal file (UFF), dataset 58: time histories, frequency responses and spectral densities."""

from __future__ import annotations

import re
from collections.abc import Iterator
from typing import Any, BinaryIO

import numpy as np

from springpot.files.table import MOST_NUMBERS, Column, Stated, Table
from springpot.files.units import UNITS, heading_of, spelled
from springpot.machine.faults import FileError, listed, shown
from springpot.machine.files import read_by
from springpot.machine.installed import need

_BEGIN = re.compile(rb"\s*-1[ \t]*\r?\n\s*\d+[bB]?\b")
_TIME, _SPECTRUM, _RESPONSES, _DENSITY = 1, 2, (4, 5), 9
_COHERENCE = 6
_QUANTITIES = {8: "x", 11: "v", 12: "a", 9: "force", 13: "force"}
_PLACES = {
    0: "",
    **{n * sign: f"{'+' if sign > 0 else '-'}{axis}" for n, axis in enumerate("XYZ", 1) for sign in (1, -1)},
}


def is_universal(begin: bytes) -> bool:
    """Whether a file begins as a universal one: with -1, then the number of a dataset.

    Examples
    --------
    >>> is_universal(b"    -1\\n    58\\n"), is_universal(b"-1,2\\n58,3\\n")
    (True, False)
    """
    return _BEGIN.match(begin) is not None


def read_universal(file: BinaryIO, title: str, stated: Stated) -> Table:
    """The functions of a universal file as columns, with the unit that it states, else ``unit``.

    Of several functions those that ``columns`` names are taken, by names such as ``"3+Z/1+Z"``: point and direction of
    the response and of the reference.

    Raises
    ------
    FileError
        If it cannot be read, has functions of different kinds, or a unit is not known.
    MissingExtraError
        Without pyuff.
    """
    need("uff", "a universal file")
    stated.refuse(title, "which states them", "rate", "decimal")
    sets = _datasets(file, title)
    names = [_name(each) for each in sets]
    if isinstance(stated.columns, dict):
        if unknown := [name for name in stated.columns if name not in names]:
            raise FileError(f"columns has {shown(unknown[0])}, and {title} has {listed([*map(shown, names)])}.")
        kept = [(each, name) for each, name in zip(sets, names, strict=True) if name in stated.columns]
    elif stated.columns is not None:
        raise FileError("columns of a universal file must be a mapping from the names of its functions, "
                        f"{listed([*map(shown, names)])}, to headers.")  # fmt: skip
    else:
        kept = [*zip(sets, names, strict=True)]
    kinds = {each["func_type"] for each, _ in kept}
    single = kinds & {*_RESPONSES, _SPECTRUM, _DENSITY}
    if len(kinds - {_COHERENCE}) != 1 or (single and sum(each["func_type"] in single for each, _ in kept) > 1):
        raise FileError(f"{title} has the functions {listed([*map(shown, names)])}: name the one that is meant, "
                        f"such as columns={{{names[0]!r}: ''}}; an empty header takes what it states.")  # fmt: skip
    axes = [np.asarray(each["x"], float) for each, _ in kept]
    if any(axis.shape != axes[0].shape or not np.array_equal(axis, axes[0]) for axis in axes[1:]):
        raise FileError(f"{title} has functions at different times or frequencies: name those that belong together "
                        "in columns=.")  # fmt: skip
    of_time = kinds == {_TIME}
    axis = ("time", "time", "s") if of_time else ("frequency", "frequency", "Hz")
    columns = [Column(*axis, axes[0])]
    for each, name in kept:
        header = (stated.columns or {}).get(name, "")
        columns += _columns(each, name, header, stated, title)
    return Table(title, columns)


def _datasets(file: BinaryIO, title: str) -> list[dict[str, Any]]:
    """The datasets 58 of a file, whose numbers are as many as each says."""
    import pyuff

    def functions(place: str) -> list[dict[str, Any]]:
        whole = pyuff.UFF(place)
        return [whole.read_sets(n) for n, kind in enumerate(whole.get_set_types()) if int(kind) == 58]

    file.seek(0)
    content = file.read()
    sets = read_by(functions, content, title, "a universal file")
    if not sets or sum(np.size(each["data"]) for each in sets) > MOST_NUMBERS:
        raise FileError(f"{title} has no functions (dataset 58), or too many.")
    bodies = _bodies(content.decode("latin-1"))
    for n, each in enumerate(sets, 1):
        data, stated = np.asarray(each["data"]), each["num_pts"]
        if data.size != stated or data.size == 0:
            raise FileError(f"{title} states {stated} points of its function {n}, and has {data.size}.")
        if each["binary"]:
            continue
        columns = [] if each["abscissa_spacing"] else [np.asarray(each["x"])]
        columns += [data.real, data.imag] if np.iscomplexobj(data) else [data]
        read, body = np.column_stack(columns).ravel(), np.array(next(bodies, []))
        if body.size != read.size or not np.allclose(body, read, 1e-12, 0.0):
            raise FileError(f"{title} has lines in its function {n} whose numbers are not in their columns.")
    return sets


def _bodies(text: str) -> Iterator[list[float]]:
    """The numbers of each dataset 58 in text, wherever in their lines they are."""
    for block in re.split(r"(?m)^\s*-1\s*$", text):
        lines = block.strip("\r\n").splitlines()
        if lines and lines[0].strip() == "58":
            numbers = re.findall(r"[+-]?\d+\.?\d*(?:[eE][+-]?\d+)?", "\n".join(lines[12:]))
            yield [float(number) for number in numbers]


def _name(each: dict[str, Any]) -> str:
    """Point and direction of the response, and of the reference where there is one."""
    response = f"{each['rsp_node']}{_PLACES.get(each['rsp_dir'], '')}"
    return f"{response}/{each['ref_node']}{_PLACES.get(each['ref_dir'], '')}" if each["ref_node"] else response


def _columns(each: dict[str, Any], name: str, header: str, stated: Stated, title: str) -> list[Column]:
    """The columns of a function: one, or the real and the imaginary part."""
    data, kind = np.asarray(each["data"]), each["func_type"]
    if kind == _COHERENCE:
        return [Column(name, "coherence", "1", data.real)]
    top, bottom = (spelled(str(each[f"{part}_axis_units_lab"])) for part in ("ordinate", "orddenom"))
    if kind in _RESPONSES:
        quantities = ["real"]
        units = ["1" if top == bottom != "NONE" and top else "", f"{top}/{bottom}", top]
    else:
        own = _QUANTITIES.get(each["ordinate_spec_data_type"])
        quantities = ["density"] if kind != _TIME else [own] if own else ["a", "v", "x", "force"]
        units = [top]
    if header:
        try:
            heading = heading_of(header)
        except ValueError as fault:
            raise FileError(f"columns: {fault}") from None
        quantities = ["real"] if kind in _RESPONSES else [heading.quantity]
        units = [heading.unit]
    elif stated.unit and not any(unit in UNITS[quantity] for quantity in quantities for unit in units):
        units = [spelled(stated.unit)]
    for quantity in quantities:
        for unit in units:
            if unit in UNITS[quantity]:
                size = UNITS[quantity][unit]
                if kind not in _RESPONSES:
                    return [Column(name, quantity, unit, data.real * size)]
                parts = ("real", data.real), ("imaginary", data.imag)
                return [Column(name, part, unit, own * size) for part, own in parts]
    such = {"density": "g2/Hz", "real": "g/N"}.get(quantities[0] or "", "m/s2")
    raise FileError(f"{title}: the unit of {shown(name)} is {shown(top)}, which does not say enough: give unit=, such "
                    f"as unit={such!r}.")  # fmt: skip
