"""The vocabulary of pointwise code: functions that serve whole arrays and compiled scalars alike.

Write models, solvers, limiters and sources with arithmetic, ``np.sqrt`` and its like, and these.
``where``, ``maximum`` and ``minimum`` are NumPy's own; the others work on *tuples* of components
of any length, so that a Riemann solver works for any number of equations.
"""

import operator
from functools import reduce

import numpy as np

#: The smallest normal double, added to denominators that vanish together with their numerators.
TINY = float(np.finfo(float).tiny)

#: Cells that NumPy takes at once on long grids: temporaries then stay in cache.
CHUNK = 8192

where = np.where
maximum = np.maximum
minimum = np.minimum


def combine(a, x, b, y):
    """Return the tuple a x + b y, component by component."""
    return tuple([a * s + b * t for s, t in zip(x, y, strict=True)])


def add(x, y):
    """Return the tuple x + y, component by component."""
    return tuple(map(operator.add, x, y))


def subtract(x, y):
    """Return the tuple x - y, component by component."""
    return tuple(map(operator.sub, x, y))


def scale(a, x):
    """Return the tuple a x, component by component."""
    return tuple([a * s for s in x])


def multiply(x, y):
    """Return the tuple x y, component by component."""
    return tuple(map(operator.mul, x, y))


def dot(x, y):
    """Return the sum of x y over the components."""
    return reduce(operator.add, map(operator.mul, x, y))


def weighted(weights, vectors):
    """Return the tuple sum_k weights_k vectors_k."""
    return reduce(add, map(scale, weights, vectors))


def known(value, otherwise):
    """Return a parameter, or ``otherwise`` where it was left open (None)."""
    return otherwise if value is None else value


def largest_share(change, below, above):
    """Return the largest share in [0, 1] of a change that stays within ``below`` and ``above``, both >= 0, of zero."""
    room = maximum(where(change > 0.0, above, below), 0.0)
    return minimum(1.0, room / (np.abs(change) + TINY))


def least(x, y):
    """Return the tuple of the smaller one, by size, of each component of x and y where both have one sign, else 0."""
    return tuple([maximum(minimum(a, b), 0.0) + minimum(maximum(a, b), 0.0) for a, b in zip(x, y, strict=True)])
