"""Vectors as a type of Numba, one number of each of WIDTH lanes, and addresses: as pointers, and called.

A vector does not depend on what LLVM's loop vectoriser thinks of loops.  ``v32`` is <WIDTH x float>, ``v64``
<WIDTH x double>, ``mask`` <WIDTH x i1>.  Scalars are spread where they meet a vector, and single numbers become double
where they meet these.  A comparison gives a mask, which is false where a number is NaN.  LLVM splits a vector where
registers are shorter, so the same source serves all processors.
"""

from __future__ import annotations

import operator
from collections.abc import Callable
from typing import Any

import llvmlite.ir as ir
from numba import types
from numba.core import cgutils
from numba.core.typing.templates import AbstractTemplate, infer_global
from numba.extending import intrinsic, lower_builtin, models, register_model

from springpot.simulation.kernel.lanes import WIDTH


class Vector(types.Type):  # type: ignore[misc]
    """A type of vectors."""

    def __init__(self, name: str, element: Any, kind: Any) -> None:
        self.element, self.llvm = element, ir.VectorType(kind, WIDTH)
        super().__init__(name=name)


@register_model(Vector)
class _Model(models.PrimitiveModel):  # type: ignore[misc]
    def __init__(self, manager: Any, kind: Vector) -> None:
        super().__init__(manager, kind, kind.llvm)


v32 = Vector(f"v{WIDTH}f32", types.float32, ir.FloatType())
v64 = Vector(f"v{WIDTH}f64", types.float64, ir.DoubleType())
mask = Vector(f"v{WIDTH}i1", types.boolean, ir.IntType(1))
_i32 = ir.IntType(32)


def _spread(context: Any, builder: Any, value: Any, kind: Any, to: Vector) -> Any:
    if kind == to:
        return value
    if isinstance(kind, Vector):
        return (builder.fpext if to is v64 else builder.fptrunc)(value, to.llvm)
    value = context.cast(builder, value, kind, to.element)
    empty = ir.Constant(to.llvm, ir.Undefined)
    return builder.shuffle_vector(
        builder.insert_element(empty, value, _i32(0)), empty, ir.Constant(ir.VectorType(_i32, WIDTH), None)
    )


def _common(*kinds: Any) -> Any:
    """The type of what is made of numbers of these types; None if none of them is a vector of numbers."""
    vectors = [kind for kind in kinds if isinstance(kind, Vector)]
    return None if not vectors or mask in vectors else v64 if v64 in vectors else v32


def _of_numbers(make: Callable[..., Any], result: Vector | None = None) -> Any:
    """An intrinsic of two vectors or numbers; ``make(builder, a, b)`` has both of one type."""

    @intrinsic
    def apply(typing_context, a, b):
        to = _common(a, b) or typing_context.unify_types(a, b)

        def codegen(context, builder, signature, args):
            both = zip(args, signature.args, strict=True)
            spread = _spread if isinstance(to, Vector) else type(context).cast
            return make(builder, *(spread(context, builder, *each, to) for each in both))

        return (result or to)(a, b), codegen

    return apply


def _operator(of: Any, make: Callable[..., Any], result: Vector | None = None) -> None:
    """The same as an operator.

    Numba types and lowers it in place; an overload would be a function of its own for each two types, which takes a
    third of the time of compilation.
    """

    class Typed(AbstractTemplate):  # type: ignore[misc]
        def generic(self, args: Any, keywords: Any) -> Any:
            if mask in args:
                return mask(*args) if of in (operator.and_, operator.or_) and args[0] == args[1] else None
            to = None if of in (operator.and_, operator.or_) else _common(*args)
            return None if to is None else (result or to)(*args)

    infer_global(of)(Typed)

    def codegen(context: Any, builder: Any, signature: Any, args: Any) -> Any:
        to = mask if mask in signature.args else _common(*signature.args)
        both = zip(args, signature.args, strict=True)
        return make(builder, *(_spread(context, builder, *each, to) for each in both))

    for kinds in ((Vector, Vector), (Vector, types.Number), (types.Number, Vector)):
        lower_builtin(of, *kinds)(codegen)


for _each, _name in (
    (operator.add, "fadd"),
    (operator.sub, "fsub"),
    (operator.mul, "fmul"),
    (operator.truediv, "fdiv"),
):
    _operator(_each, lambda builder, a, b, name=_name: getattr(builder, name)(a, b))
for _each, _sign in (
    (operator.lt, "<"),
    (operator.le, "<="),
    (operator.gt, ">"),
    (operator.ge, ">="),
    (operator.eq, "=="),
):
    _operator(_each, lambda builder, a, b, sign=_sign: builder.fcmp_ordered(sign, a, b), mask)
for _each, _name in ((operator.and_, "and_"), (operator.or_, "or_")):
    _operator(_each, lambda builder, a, b, name=_name: getattr(builder, name)(a, b), mask)

smaller = _of_numbers(lambda builder, a, b: builder.select(builder.fcmp_ordered("<", b, a), b, a))
larger = _of_numbers(lambda builder, a, b: builder.select(builder.fcmp_ordered(">", b, a), b, a))


@intrinsic
def opposite(typing_context, a):
    """Where a mask is not set."""
    return mask(a), lambda context, builder, signature, args: builder.not_(args[0])


@intrinsic
def choose(typing_context, m, a, b):
    """a where m, else b; one of them a vector."""
    to = _common(a, b)

    def codegen(context, builder, signature, args):
        x, y = (_spread(context, builder, *both, to) for both in zip(args[1:], signature.args[1:], strict=True))
        return builder.select(args[0], x, y)

    return None if to is None else (to(m, a, b), codegen)


@intrinsic
def some(typing_context, m):
    """Whether a mask is set in any lane."""

    def codegen(context, builder, signature, args):
        bits = builder.bitcast(args[0], ir.IntType(WIDTH))
        return builder.icmp_unsigned("!=", bits, ir.IntType(WIDTH)(0))

    return types.boolean(m), codegen


@intrinsic
def lanes_of(typing_context, m):
    """The lanes in which a mask is set: the bits of a uint64."""

    def codegen(context, builder, signature, args):
        bits = builder.bitcast(args[0], ir.IntType(WIDTH))
        return bits if WIDTH == 64 else builder.zext(bits, ir.IntType(64))

    return types.uint64(m), codegen


def _of(pointer: Any) -> Vector:
    return v64 if pointer.dtype == types.float64 else v32


@intrinsic
def load(typing_context, pointer, at):
    """The vector that begins at a place."""
    to = _of(pointer)

    def codegen(context, builder, signature, args):
        place = builder.bitcast(builder.gep(args[0], [args[1]]), to.llvm.as_pointer())
        return builder.load(place, align=8 if to is v64 else 4)

    return to(pointer, at), codegen


@intrinsic
def store(typing_context, pointer, at, value):
    """Write a vector, or a number in all lanes, from a place on."""
    to = _of(pointer)

    def codegen(context, builder, signature, args):
        place = builder.bitcast(builder.gep(args[0], [args[1]]), to.llvm.as_pointer())
        builder.store(_spread(context, builder, args[2], signature.args[2], to), place, align=8 if to is v64 else 4)
        return context.get_dummy_value()

    return types.void(pointer, at, value), codegen


@intrinsic
def like(typing_context, pointer, number):
    """A number in all lanes, or a vector, in the precision of a pointer."""
    to = _of(pointer)

    def codegen(context, builder, signature, args):
        return _spread(context, builder, args[1], signature.args[1], to)

    return to(pointer, number), codegen


@intrinsic
def filled(typing_context, a, number):
    """A number in all lanes, in the precision of a vector."""
    return a(a, number), lambda context, builder, signature, args: _spread(
        context, builder, args[1], signature.args[1], signature.return_type
    )


@intrinsic
def double(typing_context, a):
    """A vector in double precision."""
    return v64(a), lambda context, builder, signature, args: _spread(context, builder, args[0], signature.args[0], v64)


def _function(name: str, count: int) -> Any:
    """An intrinsic of LLVM, of a number or lane by lane; llvmlite does not know its name for vectors."""

    def call(context: Any, builder: Any, signature: Any, args: Any) -> Any:
        kind = signature.return_type
        lanes = f"v{WIDTH}" if isinstance(kind, Vector) else ""
        suffix = f".{lanes}{'f64' if kind in (v64, types.float64) else 'f32'}"
        own, spread = context.get_value_type(kind), _spread if lanes else type(context).cast
        of = ir.FunctionType(own, [own] * count)
        values = [spread(context, builder, *both, kind) for both in zip(args, signature.args, strict=True)]
        return builder.call(cgutils.get_or_insert_function(builder.module, of, "llvm." + name + suffix), values)

    if count == 1:

        @intrinsic
        def apply(typing_context, a):
            return a(a), call
    else:

        @intrinsic
        def apply(typing_context, a, b):
            return _common(a, b)(a, b), call

    return apply


root, size, power = _function("sqrt", 1), _function("fabs", 1), _function("pow", 2)


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
