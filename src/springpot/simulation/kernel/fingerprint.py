"""What the machine code of a function depends on, in words that are the same in every process.

It is the bytecode of the function, and of the compiled functions that it calls, with the numbers that they hold:
constants, defaults, and the values of captured and global variables at this moment.  So a function that was typed
again, or moved to another file, is the same function, and one that captures another number is another one.

Some functions have no such words: those that use an array, a list or an object, a function that Numba learned
elsewhere, or that raise an error, for which they need Python.
"""

from __future__ import annotations

import builtins
import dis
import hashlib
from collections.abc import Callable, Iterator
from functools import cache
from pathlib import Path
from types import BuiltinFunctionType, CodeType, FunctionType, ModuleType
from typing import Any

import numpy as np
from numba.core.dispatcher import Dispatcher
from numba.core.types import Type
from numba.core.typing import Signature

_KERNEL = __name__.rpartition(".")[0]
_KNOWN = ("math", "cmath", "operator", "numpy", "numba")  # modules whose content their versions tell


class _NoneError(Exception):
    """There is none."""


def fingerprint(function: Callable[..., Any]) -> str | None:
    """The words, or None if there are none.

    Examples
    --------
    >>> def push(stiffness):
    ...     return lambda x: -stiffness * x
    >>> fingerprint(push(2.0)) == fingerprint(push(2.0))
    True
    >>> fingerprint(push(2.0)) == fingerprint(push(3.0))
    False
    >>> fingerprint(lambda x: open("some file")) is None
    True
    """
    try:
        return repr((_of_kernel(), list(_function(function, ()))))
    except _NoneError:
        return None


@cache
def _of_kernel() -> str:
    """Of the compiled code in this folder, which functions may call."""
    files = sorted(Path(__file__).parent.glob("*.py"))
    return hashlib.sha256(b"".join(file.read_bytes() for file in files)).hexdigest()


def _function(function: Any, within: tuple[int, ...]) -> Iterator[object]:
    if id(function) in within:
        yield "again", within.index(id(function))
        return
    if not isinstance(function, FunctionType):
        raise _NoneError
    within = (*within, id(function))
    for value in (function.__defaults__, *sorted((function.__kwdefaults__ or {}).items())):
        yield _value(value, within)
    for cell in function.__closure__ or ():
        try:
            yield _value(cell.cell_contents, within)
        except ValueError:  # nothing in it yet
            raise _NoneError from None
    yield from _code(function.__code__, function.__globals__, within)


def _code(code: CodeType, known: dict[str, Any], within: tuple[int, ...]) -> Iterator[object]:
    yield (
        code.co_code.hex(), code.co_names, code.co_varnames, code.co_freevars, code.co_cellvars, code.co_flags,
        code.co_argcount, code.co_kwonlyargcount, code.co_exceptiontable.hex(),
    )  # fmt: skip
    for constant in code.co_consts:
        yield [*_code(constant, known, within)] if isinstance(constant, CodeType) else _value(constant, within)
    for step in dis.get_instructions(code):
        if step.opname in ("RAISE_VARARGS", "RERAISE", "IMPORT_NAME", "STORE_GLOBAL"):
            raise _NoneError
        if step.opname in ("LOAD_GLOBAL", "LOAD_NAME"):
            name = step.argval
            yield name, _value(known[name], within) if name in known else _builtin(name)


def _builtin(name: str) -> str:
    if not hasattr(builtins, name) or name in ("open", "print", "input", "eval", "exec"):
        raise _NoneError
    return name


def _value(value: Any, within: tuple[int, ...]) -> object:
    if value is None or type(value) in (bool, int, float, complex, str, bytes):
        return type(value).__name__, repr(value)
    if type(value) is tuple:
        return [_value(each, within) for each in value]
    if isinstance(value, np.generic) and value.dtype.kind in "biufc":
        return value.dtype.str, value.tobytes().hex()
    if isinstance(value, ModuleType) and value.__name__.partition(".")[0] in _KNOWN:
        return value.__name__
    if isinstance(value, Type | Signature):
        return str(value)
    of, name = getattr(value, "__module__", None) or "", getattr(value, "__qualname__", "")
    if isinstance(value, Dispatcher):
        of, name = value.py_func.__module__ or "", value.py_func.__qualname__
    if hasattr(value, "_defn"):  # an intrinsic: Python code that writes code of LLVM
        of, name = value._defn.__module__, value._defn.__qualname__
    if of.startswith(f"{_KERNEL}.") and "<locals>" not in name:
        return of, name
    if isinstance(value, Dispatcher):
        return [*_compiled(value, within)]
    if hasattr(value, "_defn") and of.startswith(f"{_KERNEL}."):
        return of, name, [_value(cell.cell_contents, within) for cell in value._defn.__closure__ or ()]
    if isinstance(value, np.ufunc):
        name = str(getattr(value, "__name__", ""))
        if getattr(np, name, None) is value:
            return name
    if isinstance(value, type | BuiltinFunctionType | FunctionType) or hasattr(value, "_implementation"):
        top = of.partition(".")[0]
        if top in _KNOWN or (top == "builtins" and hasattr(builtins, name)):
            return of, name
    raise _NoneError


def _compiled(function: Any, within: tuple[int, ...]) -> Iterator[object]:
    yield sorted((key, _option(option)) for key, option in function.targetoptions.items())
    yield str(function.locals), () if function._can_compile else tuple(map(str, function.nopython_signatures))
    yield from _function(function.py_func, within)


def _option(option: Any) -> str:
    if isinstance(option, set | frozenset):
        return repr(sorted(option))
    return option.__qualname__ if isinstance(option, type) else repr(option)
