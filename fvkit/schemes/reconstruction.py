"""Reconstructions: face values from cell averages (MP5, WENO5, MUSCL)."""

from abc import ABC, abstractmethod
from typing import ClassVar

import attrs
import numpy as np

from fvkit.pointwise import maximum, minimum
from fvkit.pointwise.part import Part
from fvkit.problem.questions import RECONSTRUCTION


@attrs.frozen
class Reconstruction(Part, ABC):
    """Abstract reconstruction of one variable. Contract:

    1. ``right(a, b, c, d, e)`` returns the value at the right face of the middle one of five cells with these averages;
       pointwise. The value at the left face is ``right(e, d, c, b, a)``.
    2. For five equal averages it returns c, to rounding; a lake at rest depends on that.
    3. ``reach`` is 1 if the result does not depend on a and e, else 2.
    4. ``cubic = True`` declares that the polynomial of a cell has the unlimited third mode of five averages, which increases
       the order of the integral over the cell from four to five.
    5. ``order`` is the order in smooth flow, for reports.

    Examples
    --------
    >>> import attrs
    >>> import fvkit as fv
    >>> @attrs.frozen
    ... class Central(fv.Reconstruction):
    ...     order, reach, cubic = 2, 1, False
    ...     def right(self, a, b, c, d, e):
    ...         return c + 0.25 * (d - b)
    >>> Central().right(0.0, 1.0, 2.0, 3.0, 4.0)
    2.5
    """

    questions = RECONSTRUCTION
    reach: ClassVar[int] = 2
    cubic: ClassVar[bool] = True
    order: ClassVar[int] = 5

    @abstractmethod
    def right(self, a, b, c, d, e):
        """Return the value at the right face of the cell with average c."""


@attrs.frozen
class MP5(Reconstruction):
    """Fifth-order monotonicity-preserving reconstruction: sharpest at jumps, fifth order also at smooth extrema.

    Source: A. Suresh, H. T. Huynh, J. Comput. Phys. 136 (1997) 83-99, with alpha = 4 (remembered, order measured).

    Examples
    --------
    >>> import fvkit as fv
    >>> import numpy as np
    >>> round(float(fv.MP5().right(*np.array([0.0, 1.0, 2.0, 3.0, 4.0]))), 12)
    2.5
    """

    def right(self, a, b, c, d, e):
        free = (2.0 * a - 13.0 * b + 47.0 * c + 27.0 * d - 3.0 * e) * (1.0 / 60.0)
        before, here, after = a - 2.0 * b + c, b - 2.0 * c + d, c - 2.0 * d + e
        bend, back = curvature(here, after), curvature(before, here)
        upper = c + 4.0 * (c - b)
        middle = 0.5 * (c + d) - 0.5 * bend
        large = c + 0.5 * (c - b) + (4.0 / 3.0) * back
        low = maximum(minimum(minimum(c, d), middle), minimum(minimum(c, upper), large))
        high = minimum(maximum(maximum(c, d), middle), maximum(maximum(c, upper), large))
        return minimum(maximum(free, low), high)


def curvature(x, y):
    """Return the minmod of 4x - y, 4y - x, x and y."""
    one, other = 4.0 * x - y, 4.0 * y - x
    low, high = minimum(minimum(one, other), minimum(x, y)), maximum(maximum(one, other), maximum(x, y))
    return maximum(low, 0.0) + minimum(high, 0.0)


@attrs.frozen
class WENO5(Reconstruction):
    """Fifth-order weighted essentially non-oscillatory reconstruction with WENO-Z weights: more diffusive at jumps than `MP5`.

    Source: R. Borges, M. Carmona, B. Costa, W. S. Don, J. Comput. Phys. 227 (2008) 3191-3211 (remembered, order
    measured), the constant in the weights relative to the data: derived here.

    Examples
    --------
    >>> import fvkit as fv
    >>> import numpy as np
    >>> round(float(fv.WENO5().right(*np.array([0.0, 1.0, 2.0, 3.0, 4.0]))), 12)
    2.5
    """

    def right(self, a, b, c, d, e):
        left = (13.0 / 12.0) * (a - 2.0 * b + c) ** 2 + 0.25 * (a - 4.0 * b + 3.0 * c) ** 2
        centre = (13.0 / 12.0) * (b - 2.0 * c + d) ** 2 + 0.25 * (b - d) ** 2
        right = (13.0 / 12.0) * (c - 2.0 * d + e) ** 2 + 0.25 * (3.0 * c - 4.0 * d + e) ** 2
        tau = np.abs(left - right)
        least = 1e-40 + 1e-16 * (left + centre + right)
        w0, w1, w2 = weight(0.1, tau, left + least), weight(0.6, tau, centre + least), weight(0.3, tau, right + least)
        value = (w0 * (2.0 * a - 7.0 * b + 11.0 * c) + w1 * (-b + 5.0 * c + 2.0 * d) + w2 * (2.0 * c + 5.0 * d - e))
        return value / (6.0 * (w0 + w1 + w2))


def weight(share, tau, smoothness):
    """Return the unnormalised weight of a stencil: share (1 + (tau/smoothness)^2)."""
    ratio = tau / smoothness
    return share * (1.0 + ratio * ratio)


@attrs.frozen
class MUSCL(Reconstruction):
    """Second-order MUSCL reconstruction with the monotonized central slope minmod(2 (c-b), (d-b)/2, 2 (d-c)).

    Source: B. van Leer, J. Comput. Phys. 32 (1979) 101-136.

    Examples
    --------
    >>> import fvkit as fv
    >>> import numpy as np
    >>> float(fv.MUSCL().right(*np.array([0.0, 1.0, 2.0, 3.0, 4.0])))
    2.5
    """

    reach: ClassVar[int] = 1
    cubic: ClassVar[bool] = False
    order: ClassVar[int] = 2

    def right(self, a, b, c, d, e):
        back, forth, central = 2.0 * (c - b), 2.0 * (d - c), 0.5 * (d - b)
        low, high = minimum(minimum(back, forth), central), maximum(maximum(back, forth), central)
        return c + 0.5 * (maximum(low, 0.0) + minimum(high, 0.0))
