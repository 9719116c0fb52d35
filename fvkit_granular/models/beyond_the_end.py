"""Ghost states beyond the end of a grid over a continued bottom: a lake keeps its level, a river its depth."""

import numpy as np

from fvkit import maximum, minimum, where
from fvkit_granular.models.wet_dry import TINY, threshold

#: Largest friction coefficient S/Fr^2 of a river, which keeps its depth beyond an end; slower flow on the slope S is a lake.
FRICTION = 10.0


def mean_speed(model, q):
    """Return the mass-weighted mean velocity of all phases, m/s, 0 on dry ground."""
    wet = model.depth(q) > threshold(model.dry)
    flow, mass = 0.0, 0.0
    for masses, momentum in model.phases:
        flow, mass = flow + q[momentum], mass + q[masses[-1]]
    return where(wet, flow / where(wet, mass, 1.0), 0.0)


def gravity(model, slope):
    """Return gravity at an end over ground of this slope, m/s^2: that of the equations for steep ground where they are taken."""
    return model.on_slope(1.0 + slope * slope).g if model.slope_rows else model.g


def falling_share(model, q, slope):
    """Return the ratio of surface slope to bottom slope beyond an end, min(1, 10 Fr^2/S): 0 at rest, 1 for a river."""
    v = mean_speed(model, q)
    falls = FRICTION * v * v / (gravity(model, slope) * maximum(model.depth(q), threshold(model.dry)))
    return falls / (maximum(falls, np.abs(slope)) + TINY)


def deepening(model, q, slope, distance):
    """Return the increase of the depth of a flow with state q over ``distance`` m beyond an end with this bottom slope, m."""
    return (falling_share(model, q, slope) - 1.0) * slope * distance


def deepened(h, by, dry):
    """Return the factors of mass and momentum of a layer deepened by ``by`` m, and the remainder of ``by`` for other layers, m.

    Dry ground remains dry. A deeper layer keeps its discharge, a thinner layer its velocity.
    """
    wet = h > threshold(dry)
    factor = where(wet, maximum(h + by, 0.0) / where(wet, h, 1.0), 1.0)
    return factor, minimum(1.0, factor), where(wet, minimum(h + by, 0.0), by)
