"""Cube roots without a division: no library has one that loops over vectors may call."""

import math
from typing import Any

#: Upper halves of the bits of a first guess of x^(-1/3), less a third of those of x: right to 1/28.
GUESS = 0x553EE800

#: A third of a number below 2^31, as a product whose upper half it is.
THIRD = 0x55555556


def cube_root(emitter: Any, x: Any) -> Any:
    """The instructions of the cube root, to one unit in the last place.

    With e = 1 - x y^3 of a guess y of x^(-1/3), y (1 + e/3 + 2 e^2/9 + 14 e^3/81) is right to 0.43 e^4, twice: and x y^2 is
    corrected by its own cube.
    """
    builder, number, fused, whole = emitter.builder, emitter.number, emitter.fused, emitter.whole

    def integer(value: int) -> Any:
        return emitter.ir.Constant(whole, value)

    size = emitter.intrinsic("llvm.fabs", x)
    small = builder.fcmp_ordered("<", size, number(2.0**-1022))
    size = builder.select(small, builder.fmul(size, number(2.0**54)), size)
    upper, half = builder.lshr(builder.bitcast(size, whole), integer(32)), integer(32)
    guess = builder.sub(integer(GUESS), builder.lshr(builder.mul(upper, integer(THIRD)), half))
    y = builder.bitcast(builder.shl(guess, half), emitter.double)
    for _ in range(2):
        e = fused(builder.fneg(builder.fmul(size, y)), builder.fmul(y, y), number(1.0))
        series = fused(fused(e, number(14.0 / 81.0), number(2.0 / 9.0)), e, number(1.0 / 3.0))
        y = fused(builder.fmul(y, e), series, y)
    square = builder.fmul(y, y)
    rough = builder.fmul(size, square)
    left = fused(builder.fneg(builder.fmul(rough, rough)), rough, size)
    fine = fused(builder.fmul(left, number(1.0 / 3.0)), square, rough)
    fine = builder.select(small, builder.fmul(fine, number(2.0**-18)), fine)
    usual = builder.fcmp_ordered("<", size, number(math.inf))  # else infinity or NaN, its own root
    sign = builder.and_(builder.bitcast(x, whole), integer(-2**63))
    return builder.bitcast(builder.or_(builder.bitcast(builder.select(usual, fine, size), whole), sign), emitter.double)
