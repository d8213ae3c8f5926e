"""Many like numbers side by side in the lanes of one instruction: a kernel's tool.

A compiler that cannot tell whether two stretches of memory overlap looks before every short loop over them, or works
number by number. What is written here as vectors it need not look at: on short rows that is three times as fast.
"""

from typing import Any, Final

from llvmlite import ir
from numba import types
from numba.extending import intrinsic

LANES: Final = 8
"""Numbers in a vector: an instruction's worth on processors that have the widest."""
_CONTRACT: Final = ("contract", "nsz")


def _take_conjugate_product(  # type: ignore[no-untyped-def]
    typing_context, numbers, others, real, imaginary, x, y, u, v
):
    """Take (x + i y) times (u + i v) conjugate from complex numbers in ``LANES`` lanes.

    Args:
        typing_context: numba's.
        numbers: contiguous array (k,) with what is changed, and x and y.
        others: contiguous array (k,) with u and v.
        real: where in ``numbers`` the first real part is that is changed.
        imaginary: where the first imaginary part is.
        x: where in ``numbers`` the first x is.
        y: where the first y is.
        u: where in ``others`` the first u is.
        v: where the first v is.
    """
    signature = types.void(numbers, others, real, imaginary, x, y, u, v)

    def generate(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        first, second, *places = arguments
        arrays = [(signature.args[0], first)] * 4 + [(signature.args[1], second)] * 2
        at = [_vector(context, builder, *array, place) for array, place in zip(arrays, places, strict=True)]
        a, b, x, y, u, v = (builder.load(pointer, align=8) for pointer in at)

        def product(one: Any, other: Any) -> Any:
            return builder.fmul(one, other, flags=_CONTRACT)

        a = builder.fsub(a, product(y, v), flags=_CONTRACT)
        b = builder.fsub(b, product(y, u), flags=_CONTRACT)
        builder.store(builder.fsub(a, product(x, u), flags=_CONTRACT), at[0], align=8)
        builder.store(builder.fadd(b, product(x, v), flags=_CONTRACT), at[1], align=8)
        return context.get_dummy_value()

    return signature, generate


take_conjugate_product: Any = intrinsic(_take_conjugate_product)


def _vector(context: Any, builder: Any, kind: Any, array: Any, place: Any) -> Any:
    """Pointer to a vector that begins at a place of an array."""
    data = context.make_array(kind)(context, builder, array).data
    return builder.bitcast(builder.gep(data, [place]), ir.VectorType(ir.DoubleType(), LANES).as_pointer())
