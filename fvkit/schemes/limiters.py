"""Limiters: how much of a wave's second-order correction is kept.

phi(theta, nu) multiplies a wave; theta is the ratio of the upwind wave's projection to the wave
itself, nu = |s| dt/dx its Courant number. phi = 1 is Lax-Wendroff, phi = theta Beam-Warming.
"""

from abc import ABC, abstractmethod
from typing import ClassVar

import attrs
import numpy as np

from fvkit.pointwise import maximum, minimum
from fvkit.pointwise.part import Part
from fvkit.problem.questions import LIMITER


@attrs.frozen
class Limiter(Part, ABC):
    """Abstract limiter. Contract:

    1. ``phi(theta, nu)`` is pointwise: scalars or arrays of one shape in, the same out, no branches.
    2. phi is bounded for every theta, infinite ones excepted, and phi(1, nu) = 1 (second order).
    3. ``limits = False`` says that phi is 1 whatever theta: then theta is not even computed.

    A subclass is one formula; see `MC` (5 lines).
    """

    questions = LIMITER
    limits: ClassVar[bool] = True

    @abstractmethod
    def phi(self, theta, nu):
        """Return the factor of the wave, for theta and nu of the same shape."""


@attrs.frozen
class NoLimiter(Limiter):
    """Lax-Wendroff, phi = 1: sharp on smooth data, oscillates at jumps."""

    limits: ClassVar[bool] = False

    def phi(self, theta, nu):
        return 1.0 + 0.0 * theta


@attrs.frozen
class Minmod(Limiter):
    """phi = max(0, min(1, theta)): the most diffusive of the second-order limiters."""

    def phi(self, theta, nu):
        return maximum(0.0, minimum(1.0, theta))


@attrs.frozen
class Superbee(Limiter):
    """phi = max(0, min(1, 2 theta), min(2, theta)): sharpest at jumps, squares smooth waves."""

    def phi(self, theta, nu):
        return maximum(0.0, maximum(minimum(1.0, 2.0 * theta), minimum(2.0, theta)))


@attrs.frozen
class MC(Limiter):
    """Monotonized central, phi = max(0, min((1 + theta)/2, 2, 2 theta)): the default, the quietest of the sharp."""

    def phi(self, theta, nu):
        return maximum(0.0, minimum(minimum(0.5 * (1.0 + theta), 2.0), 2.0 * theta))


@attrs.frozen
class VanLeer(Limiter):
    """phi = (theta + |theta|)/(1 + |theta|): smooth in theta."""

    def phi(self, theta, nu):
        return 2.0 * (maximum(0.0, theta) / (1.0 + np.abs(theta)))


@attrs.frozen
class ThirdOrder(Limiter):
    """phi = (2-nu)/3 + (1+nu)/3 theta within the caps 2 theta/nu and 2/(1-nu): best on smooth and mixed flow.

    Third order for linear waves of constant speed. The caps are kept finite by nu, 1 - nu >= 1e-3.
    """

    def phi(self, theta, nu):
        slope = (2.0 - nu) / 3.0 + (1.0 + nu) / 3.0 * theta
        return maximum(0.0, minimum(slope, minimum(2.0 * theta / maximum(nu, 1e-3), 2.0 / maximum(1.0 - nu, 1e-3))))
