"""The path-conservative, balanced Rusanov (local Lax-Friedrichs) solver."""

import attrs
import numpy as np

from fvkit.pointwise import combine, maximum, subtract
from fvkit.riemann.base import RiemannSolver


@attrs.frozen
class Rusanov(RiemannSolver):
    """Two waves at -/+ s, s the largest speed of both sides: Z1 = (J - s D)/2, Z2 = (J + s D)/2.

    J is the total path-conservative jump, D the balanced difference. The simplest and most diffusive solver.

    Source: V. V. Rusanov, USSR Comput. Math. Math. Phys. 1 (1962) 304-320.
    """

    def solve(self, model, ql, qr, auxl, auxr, jump):
        lowl, highl = model.wave_speeds(ql)
        lowr, highr = model.wave_speeds(qr)
        s = maximum(maximum(np.abs(lowl), np.abs(highl)), maximum(np.abs(lowr), np.abs(highr)))
        first = combine(0.5, jump, -0.5 * s, model.balanced_difference(ql, qr, auxl, auxr))
        return (first, subtract(jump, first)), (-s, s)
