"""The path-conservative, balanced HLL solver."""

import attrs
import numpy as np

from fvkit.pointwise import combine, maximum, minimum, subtract, where
from fvkit.riemann.base import RiemannSolver

#: Bounds that differ by less than this share of the larger one coincide: waves are differences over their distance, and where a
#: scalar law is smooth nothing but rounding would be left of them.
NARROW = 1e-3


@attrs.frozen
class HLL(RiemannSolver):
    """Two waves at bounds s1 <= s2 of all speeds of both sides::

        Z1 = s1 (s2 D - J)/(s2 - s1),  Z2 = J - Z1,

    where J is the total path-conservative jump and D the balanced difference, so that rest is kept exactly and
    nonconservative products count. Where both bounds coincide the jump travels with them.

    Source: Harten, Lax, van Leer, SIAM Rev. 25 (1983) 35-61; path-conservative form: Castro Diaz, Kurganov,
    Morales de Luna, M2AN 53 (2019) 959-985.
    """

    def solve(self, model, ql, qr, auxl, auxr, jump):
        lowl, highl = model.wave_speeds(ql)
        lowr, highr = model.wave_speeds(qr)
        s1, s2 = minimum(lowl, lowr), maximum(highl, highr)
        gap = s2 - s1
        opened = gap > NARROW * maximum(np.abs(s1), np.abs(s2))
        share = s1 / where(opened, gap, 1.0)
        difference = model.balanced_difference(ql, qr, auxl, auxr)
        first = combine(where(opened, share * s2, 0.0), difference, where(opened, -share, 0.5), jump)
        return (first, subtract(jump, first)), (s1, s2)
