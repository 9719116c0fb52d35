"""The path-conservative, balanced Rusanov (local Lax-Friedrichs) solver."""

from typing import ClassVar

import attrs
import numpy as np

from fvkit.answers import face_speeds
from fvkit.pointwise import add, combine, maximum, subtract
from fvkit.riemann.base import RiemannSolver
from fvkit.riemann.viscous import explained, towards_left


@attrs.frozen
class Rusanov(RiemannSolver):
    """Two waves at -/+ s, s the largest speed of both sides: Z1 = (A^ D - s D)/2 + K-, Z2 = J - Z1.

    D and K as in `HLL`, K- what HLL sends left of K. A conservation law has K = 0, so Z1 = (J - s D)/2. The simplest and most
    diffusive solver.

    Source: V. V. Rusanov, USSR Comput. Math. Math. Phys. 1 (1962) 304-320; D and K derived here.
    """

    bounds: ClassVar[bool] = True

    def solve(self, model, ql, qr, auxl, auxr, jump):
        s1, s2 = face_speeds(model, ql, qr, auxl, auxr)
        s = maximum(np.abs(s1), np.abs(s2))
        difference, moved, rest = explained(model, ql, qr, auxl, auxr, jump)
        first = combine(0.5, moved, -0.5 * s, difference)
        first = add(first, towards_left(model, ql, qr, auxl, auxr, rest, s1, s2, (s1 < 0.0) & (s2 > 0.0)))
        return (first, subtract(jump, first)), (-s, s)
