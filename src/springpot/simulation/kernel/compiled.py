"""The compiled kernel as something that Python can call, with numbers and addresses."""

from __future__ import annotations

import ctypes
from collections.abc import Callable
from functools import cache
from typing import Any

import numba
import numpy as np
from numba import types

from springpot.simulation.kernel.advance import advance, signature_in
from springpot.simulation.kernel.cache import cached, find_folder
from springpot.simulation.kernel.lanes import ENTRY

_KINDS = {np.dtype(np.float32): types.float32, np.dtype(np.float64): types.float64}
_IN_C = {types.uint32: ctypes.c_uint32, types.boolean: ctypes.c_bool, types.int64: ctypes.c_int64}


def _dispatcher() -> Any:
    return cached(numba.njit(**{**ENTRY, "no_cpython_wrapper": True})(advance))


def find_kernels() -> tuple[str | None, str | None]:
    """The folder in which compiled code is kept, or None and the reason why there is none."""
    return find_folder(_dispatcher())


@cache
def kernel_in(kind: np.dtype[Any]) -> Callable[..., None]:
    """The kernel whose sweep is in a precision."""
    signature = signature_in(_KINDS[kind])
    dispatcher = _dispatcher()
    dispatcher.compile(signature)
    made = dispatcher.overloads[signature.args]
    address = made.library.get_pointer_to_function(made.fndesc.llvm_func_name)
    kinds: list[Any] = [_IN_C.get(argument, ctypes.c_void_p) for argument in signature.args]
    result: Any = ctypes.c_int32
    function = ctypes.CFUNCTYPE(result, ctypes.c_void_p, ctypes.c_void_p, *kinds)(address)
    returned, raised = ctypes.c_void_p(), ctypes.c_void_p()

    def call(*arguments: Any) -> None:
        function(ctypes.byref(returned), ctypes.byref(raised), *arguments)

    call.kept = made  # type: ignore[attr-defined]
    return call
