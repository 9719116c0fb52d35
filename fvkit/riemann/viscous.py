"""The part of a jump that a viscosity explains, and the rest of it: what HLL and Rusanov share over a bottom and with sources.

A viscosity must not act on a flow in balance: not on still water, whose depths differ over a bottom, nor on a flow that runs
down a slope, whose surface does. So it acts on D, the smaller one of both differences,

    D_mass = 0 where d(q) and the balanced difference have different signs, else the smaller one of both,
    D_momentum = d(m v) + v^ (D_mass - d(q)_mass),   v^ = (F_l + F_r)/(q_l + q_r),

where mass that is left out takes its momentum with it. D explains A^ D of the jump J; the rest, K = J - A^ D, is split by the
straight line through the signs of both bounds of the speeds, (s2 - A^) K/(s2 - s1) of it to the left. On a flat bottom without
sources K = 0. Derived here.
"""

from fvkit.answers import mass_flux
from fvkit.pointwise import TINY, combine, least, scale, subtract, where


def explained(model, ql, qr, auxl, auxr, jump):
    """Return D, A^ D, and K, None where the jump is a flux difference: D explains all of it."""
    change = model.difference(ql, qr, auxl, auxr)
    if not model.defines("jump"):
        return change, jump, None
    result = list(least(change, model.balanced_difference(ql, qr, auxl, auxr)))
    fluxl, fluxr = mass_flux(model, ql), mass_flux(model, qr)
    for masses, momentum in model.phases:
        row = masses[-1]
        v = (fluxl[row] + fluxr[row]) / (ql[row] + qr[row] + TINY)
        result[momentum] = change[momentum] + v * (result[row] - change[row])
    moved = model.matrix_product(ql, qr, auxl, auxr, tuple(result))
    return tuple(result), moved, subtract(jump, moved)


def towards_left(model, ql, qr, auxl, auxr, rest, s1, s2, apart):
    """Return what travels left of K: (s2 - A^) K/(s2 - s1) where the bounds lie ``apart``, else all of it, half or nothing."""
    if rest is None:
        return (0.0,) * len(ql)
    part = scale(1.0 / where(apart, s2 - s1, 1.0), rest)
    split = combine(s2, part, -1.0, model.matrix_product(ql, qr, auxl, auxr, part))
    whole = scale(where(s1 >= 0.0, 0.0, where(s2 <= 0.0, 1.0, 0.5)), rest)
    return tuple([where(apart, item, other) for item, other in zip(split, whole, strict=True)])
