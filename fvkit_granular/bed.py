"""Faces near dry ground: thin depths, their velocities, and the part of a bottom step that water can see.

Everything here is pointwise and shared by all models of the package. Derived by this project, except the
desingularised velocity, which is common practice.
"""

import numpy as np

from fvkit.pointwise import known, maximum, minimum, where

#: Smallest threshold of a dry cell, m: products of three depths stay normal numbers.
LEAST_DRY = 1e-30

#: A face takes depths below this share of the threshold for none: the cell keeps its mass, which does not move.
IMMOBILE = 1e-10

#: Added to denominators that vanish together with their numerators: far below any product of depths and speeds.
TINY = 1e-200


def threshold(dry):
    """Return the depth below which a cell counts as dry, m; the smallest one where a model leaves it open."""
    return known(dry, LEAST_DRY)


def present(h, dry):
    """Return the depth that a face sees: h, or 0 where it is too thin to move."""
    return where(h > IMMOBILE * threshold(dry), h, 0.0)


def wetness(h, dry):
    """Return h/dry, at most 1."""
    return minimum(1.0, h * (1.0 / threshold(dry)))


def velocity(h, m, dry):
    """Return m/h from ``dry`` on, and less below it, tending to 0: m min(1, h/dry)/max(h, dry)."""
    return m * wetness(h, dry) / maximum(h, threshold(dry))


def settled(h, m, dry):
    """Return the momentum h v with the velocity of `velocity`: below ``dry`` it would else pile up without depth."""
    wet = wetness(h, dry)
    return m * (wet * wet)


def bed_step(hl, hr, bl, br):
    """Return db and its excess e: db - e is the step seen through the water, at most the depth of the lower side.

    e acts on the depth of the upper side alone. An emerged step (hr = 0, db >= hl) then exerts no force at rest, and
    a thin film on a steep slope keeps its full weight.
    """
    db = br - bl
    beyond = maximum(db - hl, 0.0) - maximum(-db - hr, 0.0)
    return db, where(db == 0.0, 0.0, beyond)


def upper(db, left, right):
    """Return the value of the side with the higher bottom."""
    return where(db > 0.0, right, left)


def mean_velocity(hl, vl, hr, vr):
    """Return the Roe mean (sqrt(hl) vl + sqrt(hr) vr)/(sqrt(hl) + sqrt(hr)); 0 where both depths are."""
    rootl, rootr = np.sqrt(hl), np.sqrt(hr)
    return (rootl * vl + rootr * vr) / (rootl + rootr + TINY)
