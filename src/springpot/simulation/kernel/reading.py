"""Tables as compiled code reads them: numbers that all lanes have in common, or numbers of each lane.

The source of the kernel is the same for both.  ``F[i]`` is a number in the first case and a vector in the second.
`of_lane` gives what one lane reads, and `shared` a number that all lanes have in any case, such as the step.
"""

from __future__ import annotations

import operator
from typing import Any

import llvmlite.ir as ir
from numba import types
from numba.core.typing.templates import AbstractTemplate, infer_global
from numba.extending import intrinsic, lower_builtin, models, register_model

from springpot.simulation.kernel.lanes import LANES
from springpot.simulation.kernel.vectors import v32, v64


class Table(types.Type):  # type: ignore[misc]
    """A pointer to numbers that do not change while the kernel runs, whatever is written elsewhere.

    A compiler that is told so reads them once.  ``apart`` is the distance of a number from the next.
    """

    apart = 1

    def __init__(self, dtype: Any) -> None:
        self.dtype = dtype
        super().__init__(name=f"{type(self).__name__}({dtype})")

    @property
    def item(self) -> Any:
        """What an index gives."""
        return self.dtype


class OfLane(Table):
    """As one lane reads numbers of each lane."""

    apart = LANES


class ByLane(OfLane):
    """Numbers of each lane: those of all lanes stand side by side."""

    @property
    def item(self) -> Any:
        """A vector."""
        return v64 if self.dtype == types.float64 else v32


@register_model(Table)
@register_model(OfLane)
@register_model(ByLane)
class _Model(models.PrimitiveModel):  # type: ignore[misc]
    def __init__(self, manager: Any, kind: Table) -> None:
        super().__init__(manager, kind, manager.lookup(kind.dtype).get_data_type().as_pointer())


@infer_global(operator.getitem)
class _Item(AbstractTemplate):  # type: ignore[misc]
    def generic(self, arguments: Any, keywords: Any) -> Any:
        table, index = arguments
        if isinstance(table, Table) and isinstance(index, types.Integer):
            return table.item(table, types.intp)
        return None


def _read(builder: Any, table: Any, kind: Any, at: Any, item: Any) -> Any:
    """A number or a vector, of which the compiler knows that it does not change."""
    apart = getattr(kind, "apart", 1)
    place = builder.gep(table, [at if apart == 1 else builder.mul(at, ir.IntType(64)(apart))])
    if item is not kind.dtype:
        place = builder.bitcast(place, item.llvm.as_pointer())
    loaded = builder.load(place) if item is kind.dtype else builder.load(place, align=8 if item is v64 else 4)
    if isinstance(kind, Table):
        loaded.set_metadata("invariant.load", builder.module.add_metadata([]))
    return loaded


@lower_builtin(operator.getitem, Table, types.Integer)
def _item(context: Any, builder: Any, signature: Any, args: Any) -> Any:
    kind = signature.args[0]
    return _read(builder, args[0], kind, args[1], kind.item)


def _as(kind_of: Any) -> Any:
    """An intrinsic that reads a pointer as a table."""

    @intrinsic
    def table(typing_context, pointer):
        return kind_of(pointer.dtype)(pointer), lambda context, builder, signature, args: args[0]

    return table


fixed, by_lane, plain = _as(Table), _as(ByLane), _as(types.CPointer)  # the last: as an ordinary pointer, for calls


def _from_lane(kind_of: Any) -> Any:
    """An intrinsic that shifts numbers of each lane to those from one lane on; all others stay as they are."""

    @intrinsic
    def shifted(typing_context, table, lane):
        apart = isinstance(table, ByLane)
        to = kind_of(table.dtype) if apart else table
        return to(
            table, lane
        ), lambda context, builder, signature, args: builder.gep(args[0], [args[1]]) if apart else args[0]

    return shifted


from_lane, of_lane = _from_lane(ByLane), _from_lane(OfLane)


@intrinsic
def shared(typing_context, table, index):
    """A number that all lanes have."""
    return table.dtype(table, types.intp), lambda context, builder, signature, args: _read(
        builder, args[0], signature.args[0], args[1], signature.args[0].dtype
    )


@intrinsic
def alike(typing_context, table):
    """Whether all numbers are shared, which the compiler knows."""
    return types.boolean(table), lambda context, builder, signature, args: context.get_constant(
        types.boolean, not isinstance(signature.args[0], ByLane)
    )
