"""What a flow is beyond the end of a grid, over a bottom that goes on: a lake at its level, a river at its depth."""

import numpy as np

from fvkit import maximum, minimum, where
from fvkit_granular.models.wet_dry import TINY, threshold

#: Rivers with a coefficient of friction S/Fr^2 up to this have their depth beyond an end; slower flow over the slope S is a lake.
FRICTION = 10.0


def mean_speed(model, q):
    """Return the velocity of all phases together, m/s, 0 where it is dry."""
    wet = model.depth(q) > threshold(model.dry)
    flow, mass = 0.0, 0.0
    for masses, momentum in model.phases:
        flow, mass = flow + q[momentum], mass + q[masses[-1]]
    return where(wet, flow / where(wet, mass, 1.0), 0.0)


def falling_share(model, q, slope):
    """Return the share of the fall of the bottom by which the surface falls as well, min(1, 10 Fr^2/S): 0 at rest."""
    v = mean_speed(model, q)
    falls = FRICTION * v * v / (model.g * maximum(model.depth(q), threshold(model.dry)))
    return falls / (maximum(falls, np.abs(slope)) + TINY)


def deepening(model, q, slope, distance):
    """Return by how much a flow with state q is deeper ``distance`` m beyond it, over a bottom of this slope, m."""
    return (falling_share(model, q, slope) - 1.0) * slope * distance


def deepened(h, by, dry):
    """Return the factors of the mass and of the momentum of a layer that gets deeper, and what is left to others of ``by``, m.

    Dry ground stays dry. A layer that gets deeper keeps its discharge, one that gets thinner its velocity.
    """
    wet = h > threshold(dry)
    factor = where(wet, maximum(h + by, 0.0) / where(wet, h, 1.0), 1.0)
    return factor, minimum(1.0, factor), where(wet, minimum(h + by, 0.0), by)
