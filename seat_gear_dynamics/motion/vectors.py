"""Four numbers that go through every instruction together: one register of a processor with wide vectors.

Compiled code that handles numbers one by one leaves most of such a register empty, and a compiler seldom finds by
itself which of them belong together. Here they are told: a `Four` is LLVM's vector of four doubles, added, subtracted
and multiplied lane by lane. Where registers are narrower LLVM takes two or four of them.

Nothing is fused and nothing reordered: each lane holds the very bits that the same operations on plain numbers give.
All names but the type `Four` exist in compiled code only.
"""

import operator
from collections.abc import Callable
from typing import Any, Protocol

from llvmlite import ir  # type: ignore[import-untyped]  # what numba builds its code with
from numba import types
from numba.core.cgutils import alloca_once
from numba.extending import intrinsic, lower_builtin, models, register_model, type_callable

_LANES = 4
_CACHE_LINE = 64  # bytes
_DOUBLE = ir.DoubleType()
_VECTOR = ir.VectorType(_DOUBLE, _LANES)
_NUMBER = ir.IntType(32)
_function: Any = intrinsic  # numba would have it called with the arguments of what emits code
_lowers: Any = lower_builtin
_at_entry: Any = alloca_once
_OPERATIONS = {operator.add: "fadd", operator.sub: "fsub", operator.mul: "fmul"}


class Four(Protocol):
    """Four doubles; the operators work lane by lane, and a plain number on the left stands in all lanes."""

    def __add__(self, other: "Four") -> "Four": ...
    def __sub__(self, other: "Four") -> "Four": ...
    def __mul__(self, other: "Four") -> "Four": ...
    def __rmul__(self, factor: float) -> "Four": ...


class _FourType(types.Type):
    """What numba's type inference knows a `Four` as."""

    def __init__(self) -> None:
        super().__init__(name="Four")


_FOUR = _FourType()


@register_model(_FourType)
class _FourModel(models.PrimitiveModel):
    def __init__(self, manager: Any, kind: Any) -> None:
        initialise: Any = super().__init__
        initialise(manager, kind, _VECTOR)


def _gathered(builder: Any, numbers: Any) -> Any:
    """Emit the vector of four plain numbers."""
    vector = ir.Constant(_VECTOR, ir.Undefined)
    for lane, number in enumerate(numbers):
        vector = builder.insert_element(vector, number, ir.Constant(_NUMBER, lane))
    return vector


def _operator_type(context: Any) -> Any:
    def result(left: Any, right: Any) -> Any:
        return _FOUR if right is _FOUR and (left is _FOUR or left == types.float64) else None

    return result


def _lowered(instruction: str) -> Callable[..., Any]:
    def emit(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        left, right = arguments
        if signature.args[0] != _FOUR:
            left = _gathered(builder, [left] * _LANES)
        return getattr(builder, instruction)(left, right)

    return emit


for _operation, _instruction in _OPERATIONS.items():
    type_callable(_operation)(_operator_type)
    _lowers(_operation, _FourType, _FourType)(_lowered(_instruction))
    _lowers(_operation, types.Float, _FourType)(_lowered(_instruction))


def _mask(lanes: tuple[int, ...]) -> Any:
    return ir.Constant(ir.VectorType(_NUMBER, _LANES), list(lanes))


def _chosen(*lanes: int) -> Callable[[Four], Four]:
    """Return the function of a four that gives its lanes in the order `lanes`."""

    def chosen(typing: Any, values: Any) -> Any:
        def emit(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
            return builder.shuffle_vector(arguments[0], arguments[0], _mask(lanes))

        return _FOUR(_FOUR), emit

    found: Callable[[Four], Four] = _function(chosen)
    return found


def _merged(*lanes: int) -> Callable[[Four, Four], Four]:
    """Return the function of two fours that takes `lanes`: 0 to 3 of the first, 4 to 7 of the second."""

    def merged(typing: Any, first: Any, second: Any) -> Any:
        def emit(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
            return builder.shuffle_vector(*arguments, _mask(lanes))

        return _FOUR(_FOUR, _FOUR), emit

    found: Callable[[Four, Four], Four] = _function(merged)
    return found


front_twice = _chosen(0, 1, 0, 1)
"""Return lanes 0 and 1 of a four, and the same again."""
neighbours = _chosen(1, 0, 3, 2)
"""Return a four with lanes 0 and 1 exchanged, and 2 and 3."""
front_and_back = _merged(0, 1, 6, 7)
"""Return lanes 0 and 1 of the first four with 2 and 3 of the second."""
even_and_odd = _merged(0, 5, 2, 7)
"""Return lanes 0 and 2 of the first four with 1 and 3 of the second."""


def _four(typing: Any, first: Any, second: Any, third: Any, fourth: Any) -> Any:
    def emit(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        return _gathered(builder, arguments)

    return _FOUR(*(types.float64,) * _LANES), emit


def _lane(typing: Any, values: Any, index: Any) -> Any:
    place = index.literal_value

    def emit(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        return builder.extract_element(arguments[0], ir.Constant(_NUMBER, place))

    return types.float64(_FOUR, index), emit


def _where_above(typing: Any, left: Any, right: Any, then: Any, otherwise: Any) -> Any:
    def emit(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        left, right, then, otherwise = arguments
        return builder.select(builder.fcmp_ordered(">", left, right), then, otherwise)

    return _FOUR(*(_FOUR,) * 4), emit


def _align_stack(typing: Any) -> Any:
    def emit(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        room = _at_entry(builder, ir.IntType(8))
        room.align = _CACHE_LINE
        # Nothing is done with the room, but as it is said to be used it stays.
        builder.asm(ir.FunctionType(ir.VoidType(), [room.type]), "", "r", [room], side_effect=True)
        return context.get_dummy_value()

    return types.void(), emit


align_stack: Callable[[], None] = _function(_align_stack)
"""Have the function that calls this lay its memory out by cache lines.

Vectors that find no register wait in that memory. LLVM aligns it to 16 bytes as the caller left it, so that by chance
of the process most of them lie across two cache lines, which takes twice the time. Costs one instruction.
"""
four: Callable[[float, float, float, float], Four] = _function(_four)
"""Return four plain numbers as one `Four`."""
lane: Callable[[Four, int], float] = _function(prefer_literal=True)(_lane)
"""Return the plain number in a lane; its index is a literal, 0 to 3."""
where_above: Callable[[Four, Four, Four, Four], Four] = _function(_where_above)
"""Return lane by lane the third four where the first is greater than the second, else, or where one is NaN, the fourth.
"""
