"""Like numbers side by side in the lanes of one instruction: a kernel's tool.

A compiler that cannot tell whether two stretches of memory overlap looks before every short loop over them, or works
number by number. What is written here as vectors it need not look at, and what a kernel holds in its variables stays in
registers: on short rows that is several times as fast.
"""

from typing import Any, Final

import numpy as np
from llvmlite import ir
from numba import types
from numba.extending import intrinsic, models, register_model

from codend.compiled import njit
from codend.net.net import Floats

LANES: Final = 16
"""Numbers in a vector: worth two instructions on processors that have the widest, so that one is under way while the
other waits."""
_CONTRACT: Final = ("contract", "nsz")
_VECTOR: Final = ir.VectorType(ir.DoubleType(), LANES)


class _Lanes(types.Type):
    """A vector, as a kernel's variable."""

    def __init__(self) -> None:
        super().__init__(name="Lanes")


@register_model(_Lanes)
class _LanesModel(models.PrimitiveModel):
    def __init__(self, manager: Any, kind: _Lanes) -> None:
        super().__init__(manager, kind, _VECTOR)


_LANES: Final = _Lanes()


@njit(cache=True)
def aligned(count: int) -> Floats:
    """Room for some numbers, (count,), of which no vector lies across two lines of the cache."""
    room = np.empty(count + LANES)
    start = -(room.ctypes.data // 8) % LANES
    return room[start : start + count]


def _load(typing_context, numbers, at):  # type: ignore[no-untyped-def]
    """The vector at a place of numbers (k,)."""

    def generate(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        return builder.load(_pointer(context, builder, signature.args[0], *arguments), align=8)

    return _LANES(numbers, at), generate


def _store(typing_context, numbers, at, vector):  # type: ignore[no-untyped-def]
    """Write a vector to a place of numbers (k,)."""

    def generate(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        builder.store(arguments[2], _pointer(context, builder, signature.args[0], *arguments[:2]), align=8)
        return context.get_dummy_value()

    return types.void(numbers, at, _LANES), generate


def _spread(typing_context, number):  # type: ignore[no-untyped-def]
    """A vector with one number in all lanes."""

    def generate(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        one = builder.insert_element(ir.Constant(_VECTOR, ir.Undefined), arguments[0], ir.Constant(ir.IntType(32), 0))
        nowhere = ir.Constant(ir.VectorType(ir.IntType(32), LANES), [0] * LANES)
        return builder.shuffle_vector(one, ir.Constant(_VECTOR, ir.Undefined), nowhere)

    return _LANES(types.float64), generate


def _times(typing_context, a, b):  # type: ignore[no-untyped-def]
    """The product a b."""
    return _LANES(a, b), lambda context, builder, signature, given: _product(builder, *given)


def _plus_product(typing_context, a, b, c):  # type: ignore[no-untyped-def]
    """The sum a + b c."""

    def generate(context: Any, builder: Any, signature: Any, given: Any) -> Any:
        return builder.fadd(given[0], _product(builder, *given[1:]), flags=_CONTRACT)

    return _LANES(a, b, c), generate


def _less_product(typing_context, a, b, c):  # type: ignore[no-untyped-def]
    """The difference a - b c."""

    def generate(context: Any, builder: Any, signature: Any, given: Any) -> Any:
        return builder.fsub(given[0], _product(builder, *given[1:]), flags=_CONTRACT)

    return _LANES(a, b, c), generate


def _one_over(typing_context, a):  # type: ignore[no-untyped-def]
    """The inverse 1 / a."""

    def generate(context: Any, builder: Any, signature: Any, given: Any) -> Any:
        return builder.fdiv(_constant(1.0), given[0])

    return _LANES(a), generate


def _one_more_if_low(typing_context, counts, a):  # type: ignore[no-untyped-def]
    """Counts, with 1 added where a is not above 0."""

    def generate(context: Any, builder: Any, signature: Any, given: Any) -> Any:
        low = builder.fcmp_unordered("<=", given[1], _constant(0.0))
        return builder.fadd(given[0], builder.select(low, _constant(1.0), _constant(0.0)))

    return _LANES(counts, a), generate


load: Any = intrinsic(_load)
store: Any = intrinsic(_store)
spread: Any = intrinsic(_spread)
times: Any = intrinsic(_times)
plus_product: Any = intrinsic(_plus_product)
less_product: Any = intrinsic(_less_product)
one_over: Any = intrinsic(_one_over)
one_more_if_low: Any = intrinsic(_one_more_if_low)


def _product(builder: Any, one: Any, other: Any) -> Any:
    return builder.fmul(one, other, flags=_CONTRACT)


def _constant(number: float) -> Any:
    return ir.Constant(_VECTOR, [number] * LANES)


def _pointer(context: Any, builder: Any, kind: Any, array: Any, place: Any) -> Any:
    """Pointer to the vector that begins at a place of an array."""
    data = context.make_array(kind)(context, builder, array).data
    return builder.bitcast(builder.gep(data, [place]), _VECTOR.as_pointer())
