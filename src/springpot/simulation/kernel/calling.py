"""Calls of addresses in the kernel, and addresses as pointers."""

from __future__ import annotations

import operator
from typing import Any

import llvmlite.ir as ir
from numba import types
from numba.core.typing.templates import AbstractTemplate, infer_global
from numba.extending import intrinsic, lower_builtin, models, register_model

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


class Fixed(types.Type):  # type: ignore[misc]
    """A pointer to numbers that do not change while the kernel runs, whatever is written elsewhere.

    A compiler that is told so reads them once.
    """

    def __init__(self, dtype: Any) -> None:
        self.dtype = dtype
        super().__init__(name=f"Fixed({dtype})")


@register_model(Fixed)
class _Model(models.PrimitiveModel):  # type: ignore[misc]
    def __init__(self, manager: Any, kind: Fixed) -> None:
        super().__init__(manager, kind, manager.lookup(kind.dtype).get_data_type().as_pointer())


@infer_global(operator.getitem)
class _Item(AbstractTemplate):  # type: ignore[misc]
    def generic(self, arguments: Any, keywords: Any) -> Any:
        table, index = arguments
        if isinstance(table, Fixed) and isinstance(index, types.Integer):
            return table.dtype(table, types.intp)
        return None


@lower_builtin(operator.getitem, Fixed, types.Integer)
def _item(context: Any, builder: Any, signature: Any, args: Any) -> Any:
    loaded = builder.load(builder.gep(args[0], [args[1]]))
    loaded.set_metadata("invariant.load", builder.module.add_metadata([]))
    return loaded


@intrinsic
def fixed(typing_context, pointer):
    """The same numbers, which do not change."""
    return Fixed(pointer.dtype)(pointer), lambda context, builder, signature, args: args[0]


@intrinsic
def plain(typing_context, table):
    """Such numbers as an ordinary pointer, for calls of addresses."""
    return types.CPointer(table.dtype)(table), lambda context, builder, signature, args: args[0]
