"""Shared by all compiled code of the simulation: compile flags, stack buffers, and casts.

A block of paths is advanced in ``LANES`` lanes; all lane arrays are flat and live on the stack, where LLVM knows that
no two of them overlap.  That, and flat indexing, is what lets it use vector instructions without run-time checks.
"""

from __future__ import annotations

import contextlib
from typing import Any

import llvmlite.ir as ir
import numba
import numpy as np
from numba import types
from numba.extending import intrinsic

from springpot.simulation.kernel.sizes import GROUP as GROUP
from springpot.simulation.kernel.sizes import LANES as LANES
from springpot.simulation.kernel.sizes import MOST_MODES as MOST_MODES
from springpot.simulation.kernel.sizes import middle_of
from springpot.simulation.kernel.targets import WIDTH as WIDTH

# without the two flags by which the compiler assumes that there is no NaN or infinity: divergence must be visible
FAST: dict[str, Any] = {
    "fastmath": {"nsz", "arcp", "contract", "afn", "reassoc"},
    "error_model": "numpy",
}
# `springpot.simulation.kernel.numba_passes` leans on private names of Numba: with versions that it was not tested
# with, Numba compiles as it always does, in twice the time; results differ by rounding
TESTED = ("0.62", "0.63", "0.64", "0.65", "0.66", "0.67", "0.68")
QUICK = numba.__version__.rpartition(".")[0] in TESTED
if QUICK:
    try:
        from springpot.simulation.kernel.numba_passes import OfUser, OptimizedOnce, WithoutMachineCode
    except ImportError:
        QUICK = False
# of what Python calls; of what only compiled code calls; the same copied into its callers; the same of a user
ENTRY: dict[str, Any] = {"nogil": True, **FAST}
LINKED = INLINE = OF_USER = FAST
# all is copied in: else the kernel calls other machine code when it comes from the disk than when it was just compiled
with contextlib.suppress(ImportError):
    from numba.core.cpu import CPUTargetOptions

    if hasattr(CPUTargetOptions, "forceinline"):
        LINKED = INLINE = OF_USER = {"forceinline": True, **FAST}
if QUICK:
    # arrays belong to the caller for the whole call: counting references to them took most of the time of an impact
    ENTRY = {**ENTRY, "_nrt": False, "no_cfunc_wrapper": True, "pipeline_class": OptimizedOnce}
    # no wrapper for Python, which would take a quarter of the compile time; no closures, comprehensions or tests for
    # None in it (`springpot.simulation.kernel.numba_passes` leaves out what they need); "forceinline" is said here
    # too, else it is taken over from a caller that is copied in
    LINKED = {
        "pipeline_class": WithoutMachineCode, "no_cpython_wrapper": True, "no_cfunc_wrapper": True,
        "forceinline": False, "_nrt": False, **FAST,
    }  # fmt: skip
    INLINE = {**LINKED, "forceinline": True}
    OF_USER = {**INLINE, "pipeline_class": OfUser, "_nrt": True}  # it may make arrays


middle = numba.njit(**INLINE)(middle_of)  # the same in compiled code

u32, u64, i8, i32, f32, f64 = np.uint32, np.uint64, np.int8, np.int32, np.float32, np.float64


_BESIDE = 80


def stack_array(count: int) -> Any:
    """Return ``array(like)``, for compiled code: ``count`` numbers of the type of ``like`` on the stack.

    They are 64-byte aligned and not initialised.  Some lines of the cache follow each array: arrays with a power of two
    between their beginnings would all want the same few lines.
    """

    @intrinsic
    def array(typing_context, like):
        def codegen(context, builder, signature, args):
            with builder.goto_entry_block():
                place = builder.alloca(ir.ArrayType(context.get_data_type(like), count + _BESIDE))
                place.align = 64
            return builder.bitcast(place, context.get_data_type(like).as_pointer())

        return types.CPointer(like)(like), codegen

    return array


@intrinsic
def beyond(typing_context, pointer, count):
    """The array that begins ``count`` numbers later."""

    def codegen(context, builder, signature, args):
        apart = getattr(signature.args[0], "apart", 1)
        return builder.gep(args[0], [args[1] if apart == 1 else builder.mul(args[1], ir.IntType(64)(apart))])

    return pointer(pointer, types.int64), codegen


@intrinsic
def typed(typing_context, number, like):
    """``number`` in the type of ``like``: one double in a sum would make doubles of all of it."""

    def codegen(context, builder, signature, args):
        return context.cast(builder, args[0], signature.args[0], like)

    return like(number, like), codegen


def _chosen(comparison: str) -> Any:
    @intrinsic
    def choose(typing_context, one, other):
        kind = typing_context.unify_types(one, other)

        def codegen(context, builder, signature, args):
            return builder.select(builder.fcmp_ordered(comparison, args[1], args[0]), args[1], args[0])

        return (kind(kind, kind), codegen) if isinstance(kind, types.Float) else None

    return choose


# as `min` and `max` of two floats, of which Numba would compile a function with machine code of its own for every type
lesser, greater = _chosen("<"), _chosen(">")


@intrinsic
def yes(typing_context):
    """True, but not as a type of its own, for which a function would be compiled again."""
    return types.boolean(), lambda context, builder, s, args: context.get_constant(types.boolean, True)


@intrinsic
def no(typing_context):
    """False, as ``yes``."""
    return types.boolean(), lambda context, builder, s, args: context.get_constant(types.boolean, False)


@intrinsic
def bits_of(typing_context, x):
    """The bits of a float32 as an int32."""
    return types.int32(types.float32), lambda c, builder, s, args: builder.bitcast(args[0], ir.IntType(32))


@intrinsic
def marked_lanes(typing_context, marks):
    """The lanes whose mark, an int8 of a stack array, is not 0: the bits of a uint64."""

    def codegen(context, builder, signature, args):
        kind = ir.VectorType(ir.IntType(8), LANES)
        found = builder.icmp_unsigned("!=", builder.load(builder.bitcast(args[0], kind.as_pointer())), kind(None))
        return builder.bitcast(found, ir.IntType(LANES))

    return types.uint64(types.CPointer(types.int8)), codegen


@intrinsic
def lowest_bit(typing_context, bits):
    """The number of the lowest bit of a uint64 that is not 0."""
    return types.int64(types.uint64), lambda c, builder, s, args: builder.cttz(args[0], ir.IntType(1)(1))


@intrinsic
def float_of(typing_context, x):
    """The float32 with the bits of an int32."""
    return types.float32(types.int32), lambda c, builder, s, args: builder.bitcast(args[0], ir.FloatType())
