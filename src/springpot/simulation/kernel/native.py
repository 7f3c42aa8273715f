"""Machine code of the functions that Python calls: from the wheel, from the disk, or compiled once.

Such a function takes numbers and addresses of arrays only, and needs nothing of Python, so its machine code is an
object file like that of any compiler.  An :class:`Entry` names the function.  When it is first called its code is

1. that of the wheel, if there is some for this processor (:mod:`springpot.simulation.kernel.targets`), its checksum is
   that of the manifest beside it, and it was made from the very source files that are installed;
2. what an earlier process kept (:mod:`springpot.simulation.kernel.kept`);
3. compiled by Numba, for the same target, and kept.

All three are loaded in the same way, in a millisecond by llvmlite, and have the same bits.  Numba is imported where
something is compiled, and not before.  While the code runs other threads of Python run too.  The functions that Python
calls are at the end.
"""

from __future__ import annotations

import ast
import ctypes
import hashlib
import importlib.util
import json
import sys
import threading
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from springpot.machine.bar import say
from springpot.machine.installed import versions
from springpot.simulation.kernel import kept
from springpot.simulation.kernel.kept import Code, MissingSymbolError, loaded
from springpot.simulation.kernel.sizes import LANES
from springpot.simulation.kernel.targets import Target, target_to_run

OBJECTS = Path(__file__).parent / "objects"
MANIFEST = "manifest.json"
COMPILER = "springpot.simulation.kernel.compiling"
NUMBERS: dict[str, Any] = {
    "int64": ctypes.c_int64, "int32": ctypes.c_int32, "uint64": ctypes.c_uint64, "uint32": ctypes.c_uint32,
    "float64": ctypes.c_double, "float32": ctypes.c_float, "uint8": ctypes.c_uint8,
}  # fmt: skip


@cache
def sources_of(*modules: str) -> str:
    """A digest of the files of these modules and of all that they import of their own packages, directly or not."""
    own, files, left = {module.partition(".")[0] for module in modules}, {}, [*modules]
    while left:
        file = _file_of(left.pop())
        if file is None or file in files:
            continue
        content = files[file] = file.read_bytes()
        for node in ast.walk(ast.parse(content)):
            if isinstance(node, ast.Import):
                names = [alias.name for alias in node.names]
            elif isinstance(node, ast.ImportFrom) and node.module:
                names = [node.module, *(f"{node.module}.{alias.name}" for alias in node.names)]
            else:
                continue
            left += [name for name in names if name.partition(".")[0] in own]
    named = []
    for file, content in files.items():  # by names that are the same wherever it is installed
        above = [folder.name for folder in file.parents if (folder / "__init__.py").is_file()]
        named.append(("/".join([*reversed(above), file.name]), hashlib.sha256(content).hexdigest()))
    return hashlib.sha256(repr(sorted(named)).encode()).hexdigest()


def _file_of(module: str) -> Path | None:
    """The file of a module, which is not imported for that."""
    top, *rest = module.split(".")
    spec = importlib.util.find_spec(top)
    if spec is None or spec.origin is None:
        return None
    if not rest:
        return None if spec.submodule_search_locations else Path(spec.origin)
    place = Path(spec.origin).parent.joinpath(*rest)
    return next((file for file in (place.with_name(f"{place.name}.py"), place / "__init__.py") if file.is_file()), None)


def compiler() -> str:
    """What else than the sources machine code depends on, besides its target."""
    return f"{versions('numba', 'llvmlite', 'numpy')} {sys.version}"


@dataclass(frozen=True)
class Shipped:
    """The object of the wheel for a target; ``content`` is None where there is none, and ``reason`` says why."""

    content: bytes | None
    reason: str = ""


def shipped(name: str, sources: str, goal: Target) -> Shipped:
    """The object of the wheel, as trusted as the source files beside it."""
    try:
        made = dict(json.loads((OBJECTS / MANIFEST).read_bytes())).get(name)
    except FileNotFoundError:
        return Shipped(None, "this installation brings no compiled code")
    except (OSError, ValueError, TypeError):
        return Shipped(None, "the list of compiled code cannot be read")
    if made is None:
        return Shipped(None, "this installation brings none of it")
    try:
        if goal.name not in made["sha256"]:
            return Shipped(None, f"this installation brings none for {goal.name}")
        if made["sources"] != sources:
            return Shipped(None, "the compiled code of this installation was made from other sources")
        content = file_of(name, goal, OBJECTS).read_bytes()
        if hashlib.sha256(content).hexdigest() != made["sha256"][goal.name]:
            return Shipped(None, "the compiled code of this installation is damaged")
    except (OSError, KeyError, TypeError, AttributeError):
        return Shipped(None, "the compiled code of this installation is not complete")
    return Shipped(content)


def file_of(name: str, goal: Target, folder: Path) -> Path:
    """The object for a target, of those that are made together."""
    return folder / f"{name}.{goal.name}.o"


class Entry:
    """A compiled function that Python calls.

    Parameters
    ----------
    function : str
        "module:name" of a plain Python function that Numba can compile; imported only where it is compiled.
    arguments : tuple of str
        One of NUMBERS each, with a star behind it for an array of them.
    announced : str
        What is said to be compiled, on stderr; empty: nothing is said.
    named : str
        Of its files, if the same function has several kinds of arguments; otherwise its own name.

    Notes
    -----
    The function returns nothing and raises nothing.
    """

    def __init__(self, function: str, arguments: tuple[str, ...], announced: str = "", named: str = "") -> None:
        unknown = [each for each in arguments if each.removesuffix("*") not in NUMBERS]
        if unknown:
            raise ValueError(f"arguments must be of {', '.join(NUMBERS)}, with * for arrays, not {', '.join(unknown)}.")
        self.function, self.arguments, self.announced = function, arguments, announced
        self.module, _, self.function_name = function.partition(":")
        self.name = named or self.function_name
        self._lock = threading.Lock()
        self._loaded: Code | None = None
        self._call: Any = None
        self._convert = [_array(each[:-1]) if each.endswith("*") else _number(each) for each in arguments]

    def __call__(self, *given: Any) -> None:
        """Call it with numbers, and with arrays of NumPy or their addresses.

        Raises
        ------
        TypeError
            If an array has another type of numbers, or gaps.
        """
        if (call := self._call) is None:
            kinds = [ctypes.c_void_p if each.endswith("*") else NUMBERS[each] for each in self.arguments]
            call = self._call = ctypes.CFUNCTYPE(None, *kinds)(self.load().address)
        if len(given) != len(self._convert):
            raise TypeError(f"{self.name} takes {len(self._convert)} arguments, not {len(given)}.")
        call(*[convert(value) for convert, value in zip(self._convert, given, strict=True)])

    @property
    def is_loaded(self) -> bool:
        """Whether a call begins at once."""
        return self._loaded is not None

    def load(self) -> Code:
        """Have the code, from wherever it is."""
        with self._lock:
            if self._loaded is None:
                self._loaded = self._found()
            return self._loaded

    @property
    def sources(self) -> str:
        """The digest of all files that decide the code."""
        return sources_of(self.module, COMPILER)

    def _found(self) -> Code:
        goal, reasons = target_to_run(), []
        brought = shipped(self.name, self.sources, goal)
        if brought.content is None:
            reasons.append(brought.reason)
        else:
            try:
                return loaded(brought.content, f"of this installation, for {goal.name}")
            except MissingSymbolError as error:
                reasons.append(f"the compiled code of this installation cannot be used: {error}")
        key = repr((self.function, self.arguments, self.sources, compiler(), goal.key))
        if content := kept.load(f"{self.name}.{goal.name}", key):
            try:
                return loaded(content, f"kept on disk for {goal.name}, since {reasons[0]}")
            except MissingSymbolError as error:
                reasons.append(f"what is kept cannot be used: {error}")
        kept.warn_if_unused()
        if self.announced:
            once = "once on this machine" if kept.folder()[0] else "in each process, since it cannot be kept"
            say(f"compiling {self.announced} for {goal.name}; {once}.")
        from springpot.simulation.kernel.compiling import IF_UNTESTED, entry_alone

        try:
            content = self.compiled(goal)
        except IF_UNTESTED:
            return entry_alone(self.module, self.function_name, self.arguments)
        kept.save(f"{self.name}.{goal.name}", key, content)
        return loaded(content, f"compiled in this process for {goal.name}, since {' and '.join(reasons)}")

    def compiled(self, goal: Target) -> bytes:
        """An object file for a target: what the release makes, and what is kept."""
        from springpot.simulation.kernel.compiling import object_of_entry

        return object_of_entry(self.module, self.function_name, self.arguments, goal)


def _number(kind: str) -> Any:
    return float if kind.startswith("float") else int


def _array(kind: str) -> Any:
    wanted = np.dtype(kind)

    def address(array: Any) -> int:
        if not isinstance(array, np.ndarray):
            return int(array)
        if array.dtype != wanted or not array.flags.c_contiguous:
            raise TypeError(f"an array of {wanted} without gaps is wanted, not of {array.dtype}.")
        return int(array.ctypes.data)

    return address


FILL_NORMALS = Entry(
    "springpot.simulation.kernel.random:fill_normals",
    ("int64", "uint32", "uint32", "uint32", "uint32", "int64", "int64", "float32*"),
)


def _kernel(kind: str, function: str) -> Entry:
    words = "the kernel" if function == "advance" else "the kernel of systems in neighbouring lanes"
    return Entry(
        f"springpot.simulation.kernel.advance:{function}",
        ("int64*", f"{kind}*", "float64*", "float64*", *("int64",) * 6, "uint32", "uint32", "int64", "int64", "int64*",
         "int64*", "float64*", *("int64",) * 4, "uint8*", "float64*"),
        words if kind == "float32" else f"{words} in double precision", f"{function}-{kind}",
    )  # fmt: skip


KERNELS, KERNELS_BY_LANE = (
    {kind: _kernel(kind, function) for kind in ("float32", "float64")} for function in ("advance", "advance_by_lane")
)
"""The functions of `springpot.simulation.kernel.advance` by the precision of their sweep."""

ENTRIES = (FILL_NORMALS, *KERNELS.values(), KERNELS_BY_LANE["float32"])
"""What a release makes for each target: all but the kernel by lane in double precision, which fits of records with
their measured input need, and compile once."""


def normals(seed: int, paths: int, steps: int, *, stream: int = 0) -> npt.NDArray[np.float32]:
    """The normals of a run: element [p, n] is that of step n of path p.

    Parameters
    ----------
    seed : int
        0 <= seed < 2^64.
    paths, steps : int
    stream : int
        0 for the run itself; the pilot runs of an adapted start use the ones after it.

    Returns
    -------
    ndarray of float32, shape (paths, steps)

    Examples
    --------
    >>> normals(seed=1, paths=2, steps=5).shape
    (2, 5)
    """
    out = np.empty((paths, steps), np.float32)
    k0, k1 = key_words(seed)
    for first in range(0, paths, LANES):
        part = out[first : first + LANES]
        FILL_NORMALS(first, stream, 0, k0, k1, len(part), steps, part)
    return out


def key_words(seed: int) -> tuple[np.uint32, np.uint32]:
    """The two 32-bit words of a 64-bit seed, low word first."""
    return np.uint32(seed & 0xFFFFFFFF), np.uint32(seed >> 32)
