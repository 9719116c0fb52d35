"""Polynomials on a cell, and integrals over the cell of products of them; pointwise.

With xi in [-1/2, 1/2] a polynomial is  mean + d xi + c (xi^2 - 1/12) + t (xi^3 - xi/4): value and slope are those of the
cell average, the two face values and a third mode. Derived here.
"""

from functools import reduce
from operator import add
from typing import Any, NamedTuple


class Polynomial(NamedTuple):
    """One variable on a cell: mean, difference d of its face values, bend c, and the third mode t, zero at the faces."""

    mean: Any
    d: Any
    c: Any
    t: Any

    def at(self, xi):
        """Return the value at xi, -1/2 at the left face and 1/2 at the right one."""
        return self.mean + xi * self.d + (xi * xi - 1.0 / 12.0) * self.c + (xi * xi - 0.25) * xi * self.t

    @property
    def left(self):
        """Value at the left face."""
        return self.mean + (self.c * (1.0 / 6.0) - 0.5 * self.d)

    @property
    def right(self):
        """Value at the right face."""
        return self.mean + (self.c * (1.0 / 6.0) + 0.5 * self.d)


def polynomial(mean, left, right, third):
    """Return the polynomial of a cell average, the two face values and the third mode."""
    return Polynomial(mean, right - left, 3.0 * ((left - mean) + (right - mean)), third)


def total(*parts):
    """Return the sum of polynomials."""
    return reduce(lambda one, other: Polynomial(*map(add, one, other)), parts)


def product_slope(p, q):
    """Return the integral of P Q_x over a cell, in units of the cell: mean_P d_Q + d_P c_Q/6 + (c_P t_Q - t_P c_Q)/60.

    With ``product_slope(q, p)`` it adds up to the difference of P Q between the faces, exactly.
    """
    return p.mean * q.d + p.d * q.c * (1.0 / 6.0) + (p.c * q.t - p.t * q.c) * (1.0 / 60.0)


def exchange(p, q):
    """Return the integral of P Q_x - Q P_x over a cell: zero where both are multiples of one."""
    return (p.mean * q.d - q.mean * p.d) + (p.d * q.c - q.d * p.c) * (1.0 / 6.0) + (p.c * q.t - p.t * q.c) * (1.0 / 30.0)
