"""Wave limiters: factors of the second-order corrections of wave propagation.

phi(theta, nu) multiplies a wave. theta is the ratio of the projection of the upwind wave to the wave
itself, nu = |s| dt/dx the Courant number of the wave. phi = 1 is Lax-Wendroff, phi = theta Beam-Warming.
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

    1. ``phi(theta, nu)`` is pointwise: it takes scalars or arrays of one shape, returns the same shape and has no branches.
    2. phi is bounded for every finite theta, and phi(1, nu) = 1 (second order).
    3. ``limits = False`` declares that phi = 1 for every theta; theta is then not computed.

    A subclass is one formula; see `MC` (5 lines).

    Examples
    --------
    >>> import fvkit as fv
    >>> import numpy as np
    >>> class Upwind(fv.Limiter):
    ...     def phi(self, theta, nu):
    ...         return fv.minimum(fv.maximum(theta, 0.0), 1.0)
    >>> Upwind().phi(np.array([-1.0, 0.5, 2.0]), 0.5).tolist()
    [0.0, 0.5, 1.0]
    """

    questions = LIMITER
    limits: ClassVar[bool] = True

    @abstractmethod
    def phi(self, theta, nu):
        """Return the factor of the wave, of the shape of theta and nu."""


@attrs.frozen
class NoLimiter(Limiter):
    """Lax-Wendroff, phi = 1: accurate for smooth data, oscillates at jumps.

    Examples
    --------
    >>> import fvkit as fv
    >>> import numpy as np
    >>> float(fv.NoLimiter().phi(np.array(0.3), 0.5))
    1.0
    """

    limits: ClassVar[bool] = False

    def phi(self, theta, nu):
        return 1.0 + 0.0 * theta


@attrs.frozen
class Minmod(Limiter):
    """Minmod limiter, phi = max(0, min(1, theta)): the most diffusive of the second-order limiters.

    Examples
    --------
    >>> import fvkit as fv
    >>> import numpy as np
    >>> fv.Minmod().phi(np.array([-1.0, 0.5, 1.0, 4.0]), 0.5).tolist()
    [0.0, 0.5, 1.0, 1.0]
    """

    def phi(self, theta, nu):
        return maximum(0.0, minimum(1.0, theta))


@attrs.frozen
class Superbee(Limiter):
    """Superbee limiter, phi = max(0, min(1, 2 theta), min(2, theta)): sharpest at jumps; turns smooth waves into square ones.

    Examples
    --------
    >>> import fvkit as fv
    >>> import numpy as np
    >>> fv.Superbee().phi(np.array([-1.0, 0.5, 1.0, 4.0]), 0.5).tolist()
    [0.0, 1.0, 1.0, 2.0]
    """

    def phi(self, theta, nu):
        return maximum(0.0, maximum(minimum(1.0, 2.0 * theta), minimum(2.0, theta)))


@attrs.frozen
class MC(Limiter):
    """Monotonized central limiter, phi = max(0, min((1 + theta)/2, 2, 2 theta)): the default: sharp, with little oscillation.

    Examples
    --------
    >>> import fvkit as fv
    >>> import numpy as np
    >>> fv.MC().phi(np.array([-1.0, 0.5, 1.0, 4.0]), 0.5).tolist()
    [0.0, 0.75, 1.0, 2.0]
    """

    def phi(self, theta, nu):
        return maximum(0.0, minimum(minimum(0.5 * (1.0 + theta), 2.0), 2.0 * theta))


@attrs.frozen
class VanLeer(Limiter):
    """Van Leer limiter, phi = (theta + |theta|)/(1 + |theta|): smooth for theta > 0.

    Examples
    --------
    >>> import fvkit as fv
    >>> import numpy as np
    >>> fv.VanLeer().phi(np.array([-1.0, 1.0, 4.0]), 0.5).tolist()
    [0.0, 1.0, 1.6]
    """

    def phi(self, theta, nu):
        return 2.0 * (maximum(0.0, theta) / (1.0 + np.abs(theta)))


@attrs.frozen
class ThirdOrder(Limiter):
    """Third-order limiter, phi = (2-nu)/3 + (1+nu)/3 theta, at most 2 theta/nu and 2/(1-nu): best for smooth and mixed flow.

    Third order for linear waves of constant speed. nu and 1 - nu in the bounds are at least 1e-3, so the bounds are finite.

    Examples
    --------
    >>> import fvkit as fv
    >>> import numpy as np
    >>> fv.ThirdOrder().phi(np.array([-1.0, 1.0, 10.0]), 0.5).tolist()
    [0.0, 1.0, 4.0]
    """

    def phi(self, theta, nu):
        slope = (2.0 - nu) / 3.0 + (1.0 + nu) / 3.0 * theta
        return maximum(0.0, minimum(slope, minimum(2.0 * theta / maximum(nu, 1e-3), 2.0 / maximum(1.0 - nu, 1e-3))))
