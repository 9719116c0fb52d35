"""The path-conservative, balanced HLL solver."""

from typing import ClassVar

import attrs
import numpy as np

from fvkit.answers import face_speeds
from fvkit.pointwise import add, combine, maximum, subtract, where
from fvkit.riemann.base import RiemannSolver
from fvkit.riemann.viscous import explained, towards_left

#: Bounds that differ by less than this share of the larger one coincide: waves are differences over their distance, and where a
#: scalar law is smooth nothing but rounding would be left of them.
NARROW = 1e-3


@attrs.frozen
class HLL(RiemannSolver):
    """Two waves at bounds s1 <= s2 of all speeds of both sides::

        Z1 = s1 (s2 D - A^ D)/(s2 - s1) + K-,  Z2 = J - Z1,  K = J - A^ D,

    where J is the total path-conservative jump, A^ the Roe-mean matrix (``matrix_product``) and D the difference that
    viscosity acts on: 0 at rest and in uniform flow down a slope, see `fvkit.riemann.viscous`. A conservation law has D = qr -
    ql, A^ D = J and K = 0: the usual HLL. Where both bounds coincide the jump travels with them.

    Notes
    -----
    Fails, by smearing, where waves between the outer ones matter: contacts, internal waves of two phases. Over a bottom and
    with sources it is as good as the model's ``matrix_product``.

    Source: Harten, Lax, van Leer, SIAM Rev. 25 (1983) 35-61; path-conservative form: Castro Diaz, Kurganov,
    Morales de Luna, M2AN 53 (2019) 959-985; D and K derived here.
    """

    bounds: ClassVar[bool] = True

    def solve(self, model, ql, qr, auxl, auxr, jump):
        s1, s2 = face_speeds(model, ql, qr, auxl, auxr)
        gap = s2 - s1
        opened = gap > NARROW * maximum(np.abs(s1), np.abs(s2))
        share = s1 / where(opened, gap, 1.0)
        difference, moved, rest = explained(model, ql, qr, auxl, auxr, jump)
        first = combine(where(opened, share * s2, 0.0), difference, where(opened, -share, 0.5), moved)
        first = add(first, towards_left(model, ql, qr, auxl, auxr, rest, s1, s2, opened))
        return (first, subtract(jump, first)), (s1, s2)
