"""Quotients on the multipliers, where the divider would set the pace of a loop: `pieces` says where.

Processors of Intel divide vectors of 512 bits no faster than twice as many of 256: a quotient keeps the divider for 16 cycles,
a root for 18, while two products start in every cycle. A quotient is then made of products: a first guess of the reciprocal from
the bits of the denominator, right to 1/18, two steps towards it, and two with the exact remainder. The result is that of the
divider, unless it lies within 1e-11 of a unit in the last place of the middle between two numbers, or denominator or result are
beyond 2^1020 or below 2^-960. Zero, infinity and NaN are what they are for the divider.
"""

from functools import cache
from typing import Any

#: Cycles for which the divider is busy with a vector, by operation.
BUSY = {"/": 16.0, "sqrt": 18.0}

#: Instructions of a quotient made of products, and cycles until it is there; the same where another has the same denominator.
PRODUCTS, SHARING = (17, 48), (9, 24)

#: Bits of a first guess of 1/b, less those of b; and those that make inf of 0, 0 of inf, and NaN of NaN, signs included.
GUESS, SPECIAL = 0x7FDE623822FC16E6, 0x7FF0000000000000

#: Sum of the residual of the second guess and its square that no usual denominator exceeds.
WRONG = 0.5

#: Processors, as LLVM calls them, with vectors of 512 bits and a divider of half their width.
SLOW = ("skylake-avx512", "cascadelake", "cooperlake", "cannonlake", "icelake-client", "icelake-server", "rocketlake",
        "tigerlake", "sapphirerapids", "emeraldrapids", "graniterapids", "graniterapids-d", "diamondrapids")


@cache
def divides_slowly() -> bool:
    """Whether the processor that code is made for is one of them."""
    from llvmlite import binding
    from numba import config

    target = getattr(config, "CPU_NAME", None)
    if target:
        return target in SLOW
    return binding.get_host_cpu_name() in SLOW and bool(binding.get_host_cpu_features().get("avx512f", False))


def quotient(emitter: Any, a: Any, b: Any) -> Any:
    """The instructions of a / b by products; what is 0, also -0, and what is no number go the simple way."""
    builder, number, fused, whole = emitter.builder, emitter.number, emitter.fused, emitter.whole
    bits, against = builder.bitcast(b, whole), builder.fneg(b)

    def less(constant: int) -> Any:
        return builder.bitcast(builder.sub(emitter.ir.Constant(whole, constant), bits), emitter.double)

    guess, residual = less(GUESS), None
    for _ in range(2):
        residual = fused(against, guess, number(1.0))
        residual = fused(residual, residual, residual)
        guess = fused(guess, residual, guess)
    result = builder.fmul(a, guess)
    for _ in range(2):
        result = fused(fused(against, result, a), guess, result)
    usual = builder.and_(builder.fcmp_ordered("<", residual, number(WRONG)), builder.fcmp_ordered("!=", result, number(0.0)))
    return builder.select(usual, result, builder.fmul(a, less(SPECIAL)))
