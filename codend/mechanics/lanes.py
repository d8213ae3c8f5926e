"""Like numbers side by side in the lanes of one instruction: a kernel's tool.

A compiler that cannot tell whether two stretches of memory overlap looks before every short loop over them, or works
number by number. What is written here as vectors it need not look at: on short rows that is several times as fast.
"""

from typing import Any, Final

import numpy as np
from llvmlite import ir
from numba import types
from numba.core import cgutils
from numba.extending import intrinsic

from codend.compiled import njit
from codend.net.net import Floats

LANES: Final = 8
"""Numbers in a vector: an instruction's worth on processors that have the widest."""
_CONTRACT: Final = ("contract", "nsz")


@njit(cache=True)
def aligned(count: int) -> Floats:
    """Room for some numbers, (count,), of which no vector lies across two lines of the cache."""
    room = np.empty(count + LANES)
    start = -(room.ctypes.data // 8) % LANES
    return room[start : start + count]


def _add_multiple(typing_context, numbers, at, others, place, factor):  # type: ignore[no-untyped-def]
    """Add ``factor`` times the vector at a place of ``others`` to that at a place of ``numbers``, both (k,)."""

    def generate(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        first, at, second, place, factor = arguments
        target = _vector(context, builder, signature.args[0], first, at)
        vector = _load(builder, _vector(context, builder, signature.args[2], second, place))
        factors = _of_one(builder, factor)
        _store(builder, _add(builder, _load(builder, target), _multiply(builder, factors, vector)), target)
        return context.get_dummy_value()

    return types.void(numbers, at, others, place, factor), generate


def _write_multiple(typing_context, numbers, at, others, place, factor):  # type: ignore[no-untyped-def]
    """Write ``factor`` times the vector at a place of ``others`` to that at a place of ``numbers``, both (k,)."""

    def generate(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        first, at, second, place, factor = arguments
        vector = _load(builder, _vector(context, builder, signature.args[2], second, place))
        target = _vector(context, builder, signature.args[0], first, at)
        _store(builder, _multiply(builder, _of_one(builder, factor), vector), target)
        return context.get_dummy_value()

    return types.void(numbers, at, others, place, factor), generate


def _write_product(typing_context, numbers, at, others, place, factors, by):  # type: ignore[no-untyped-def]
    """Write the product, lane by lane, of vectors at places of ``others`` and ``factors`` to a place of ``numbers``."""

    def generate(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        target, one, other = (
            _vector(context, builder, signature.args[i], arguments[i], arguments[i + 1]) for i in (0, 2, 4)
        )
        _store(builder, _multiply(builder, _load(builder, one), _load(builder, other)), target)
        return context.get_dummy_value()

    return types.void(numbers, at, others, place, factors, by), generate


def _write_inverse(typing_context, numbers, others, place, counts):  # type: ignore[no-untyped-def]
    """Write one over the vector at a place of ``others``, and add 1 to the counts of lanes in which it is not above 0.

    Args:
        typing_context: numba's.
        numbers: is written, (lanes,).
        others: (k,).
        place: where the vector is.
        counts: floating-point numbers, (lanes,).
    """

    def generate(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        first, second, place, third = arguments
        kinds, start = signature.args, ir.Constant(place.type, 0)
        vector = _load(builder, _vector(context, builder, kinds[1], second, place))
        one, none = (ir.Constant(vector.type, [number] * LANES) for number in (1.0, 0.0))
        _store(builder, builder.fdiv(one, vector), _vector(context, builder, kinds[0], first, start))
        counts = _vector(context, builder, kinds[3], third, start)
        low = builder.fcmp_unordered("<=", vector, none)
        _store(builder, _add(builder, _load(builder, counts), builder.select(low, one, none)), counts)
        return context.get_dummy_value()

    return types.void(numbers, others, place, counts), generate


def _take_conjugate_products(typing_context, numbers, at, others, places, count):  # type: ignore[no-untyped-def]
    """Take a complex number times the conjugates of some others from the numbers so far before it, lane by lane.

    Of a complex number the real parts of all lanes come first, then the imaginary ones.

    Args:
        typing_context: numba's.
        numbers: (k,), with the number z at ``at``; that at ``at`` - p is less z times the conjugate of ``others`` at p.
        at: where z is.
        others: (l,).
        places: the p, int64, (m,).
        count: how many of them count.
    """

    def generate(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        first, at, second, places, count = arguments
        kind, other_kind, place_kind = signature.args[0], signature.args[2], signature.args[3]
        step = ir.Constant(at.type, LANES)
        x, y = (_load(builder, _vector(context, builder, kind, first, a)) for a in (at, builder.add(at, step)))
        of_places = context.make_array(place_kind)(context, builder, places).data
        with cgutils.for_range(builder, count) as loop:
            p = builder.load(builder.gep(of_places, [loop.index]))
            u, v = (_load(builder, _vector(context, builder, other_kind, second, a)) for a in (p, builder.add(p, step)))
            real_at = builder.sub(at, p)
            real, imaginary = (_vector(context, builder, kind, first, a) for a in (real_at, builder.add(real_at, step)))
            a = _subtract(builder, _load(builder, real), _multiply(builder, y, v))
            b = _subtract(builder, _load(builder, imaginary), _multiply(builder, y, u))
            _store(builder, _subtract(builder, a, _multiply(builder, x, u)), real)
            _store(builder, _add(builder, b, _multiply(builder, x, v)), imaginary)
        return context.get_dummy_value()

    return types.void(numbers, at, others, places, count), generate


add_multiple: Any = intrinsic(_add_multiple)
write_multiple: Any = intrinsic(_write_multiple)
write_product: Any = intrinsic(_write_product)
write_inverse: Any = intrinsic(_write_inverse)
take_conjugate_products: Any = intrinsic(_take_conjugate_products)


def _vector(context: Any, builder: Any, kind: Any, array: Any, place: Any) -> Any:
    """Pointer to a vector that begins at a place of an array."""
    data = context.make_array(kind)(context, builder, array).data
    return builder.bitcast(builder.gep(data, [place]), ir.VectorType(ir.DoubleType(), LANES).as_pointer())


def _of_one(builder: Any, number: Any) -> Any:
    """A vector with one number in all lanes."""
    kind = ir.VectorType(ir.DoubleType(), LANES)
    one = builder.insert_element(ir.Constant(kind, ir.Undefined), number, ir.Constant(ir.IntType(32), 0))
    nowhere = ir.Constant(ir.VectorType(ir.IntType(32), LANES), [0] * LANES)
    return builder.shuffle_vector(one, ir.Constant(kind, ir.Undefined), nowhere)


def _load(builder: Any, pointer: Any) -> Any:
    return builder.load(pointer, align=8)


def _store(builder: Any, vector: Any, pointer: Any) -> None:
    builder.store(vector, pointer, align=8)


def _multiply(builder: Any, one: Any, other: Any) -> Any:
    return builder.fmul(one, other, flags=_CONTRACT)


def _add(builder: Any, one: Any, other: Any) -> Any:
    return builder.fadd(one, other, flags=_CONTRACT)


def _subtract(builder: Any, one: Any, other: Any) -> Any:
    return builder.fsub(one, other, flags=_CONTRACT)
