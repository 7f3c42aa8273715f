"""Calls of addresses in the kernel, and addresses as pointers."""

from __future__ import annotations

from typing import Any

import llvmlite.ir as ir
from numba import types
from numba.extending import intrinsic

_numbers = types.CPointer(types.float64)
FORCE = types.void(types.float64, _numbers, _numbers, _numbers, _numbers, types.int64)
"""(time of the kick, numbers, x, v, change of v, count) of a function of the user, in the kernel's units."""
SHARE = types.void(types.float64, _numbers)
"""(speed in m/s, restitution): written to its first number."""


def calling(signature: Any, last_is_address: bool = False) -> Any:
    """An intrinsic that calls an address with a tuple of arguments, the last of which may itself be an address."""

    @intrinsic
    def call(typing_context, address, arguments):
        def codegen(context, builder, call_signature, values):
            kinds = [context.get_value_type(kind) for kind in signature.args]
            function = builder.inttoptr(values[0], ir.FunctionType(ir.VoidType(), kinds).as_pointer())
            given = [builder.extract_value(values[1], i) for i in range(len(kinds))]
            if last_is_address:
                given[-1] = builder.inttoptr(given[-1], kinds[-1])
            builder.call(function, given)
            return context.get_dummy_value()

        own = (*signature.args[:-1], types.int64) if last_is_address else tuple(signature.args)
        return types.void(types.int64, types.Tuple(own)), codegen

    return call


call_force, call_share = calling(FORCE), calling(SHARE)


def _pointer_of(kind: Any) -> Any:
    @intrinsic
    def pointer(typing_context, address):
        to = types.CPointer(kind)

        def codegen(context, builder, signature, args):
            return builder.inttoptr(args[0], context.get_value_type(to))

        return to(types.int64), codegen

    return pointer


doubles, integers, words = map(_pointer_of, (types.float64, types.int64, types.uint32))


@intrinsic
def pointer_like(typing_context, address, pointer):
    """An address as a pointer of the type of another."""
    return pointer(types.int64, pointer), lambda context, builder, signature, args: builder.inttoptr(
        args[0], context.get_value_type(signature.return_type)
    )
