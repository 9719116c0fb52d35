"""Faces near dry ground: thin depths, their velocities, and the part of a bottom step that water can see.

Everything here is pointwise and shared by all models of the package. Derived by this project, except the
desingularised velocity, which is common practice.
"""

from typing import Any, NamedTuple

import attrs
import numpy as np

from fvkit.pointwise import known, maximum, minimum, where

#: Smallest threshold of a dry cell, m: products of three depths stay normal numbers.
LEAST_DRY = 1e-30

#: A face takes depths below this share of the threshold for none: the cell keeps its mass, which does not move.
IMMOBILE = 1e-10

#: How fast an emerged step closes once its excess exceeds so many times the kinetic head of what runs towards it: ``HIGH`` times
#: where it rises far above the water, ``HIGH + SHORE`` times where it is a step of a shore, no higher than the water before it.
CLOSING, HIGH, SHORE = 4.0, 8.0, 120.0

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


def covered_step(hl, hr, bl, br):
    """Return the step of the bottom that is seen through the water: by all of a cliff, corrections would hold water on it."""
    db, excess = bed_step(hl, hr, bl, br)
    return db - excess


class Step(NamedTuple):
    """The step of the bottom at a face, as the flow over it feels it.

    Parameters
    ----------
    db, excess : see `bed_step`.
    inverse : 1/(|e| + h_up), 1/m.
    raised : share |e|/(|e| + h_up) of the potential head over the step that the upper side alone bears.
    steep : share of the change of velocity over the face that the step explains: at most 2 |db|/|dh|, 0 at shores and where the
        step is below a twentieth of both depths together, a resolved bottom; whole from a tenth on.
    standing : share of it that stands: as ``steep``, between depths of similar size, where the step is at most three quarters
        of both together; a film on a slope leaves all to the waves.
    bare : max(0, 1 - h_up/h_low): 1 where the upper side is dry, 0 where it is as deep as the lower one.
    """

    db: Any
    excess: Any
    inverse: Any
    raised: Any
    steep: Any
    standing: Any
    bare: Any


def face_step(hl, hr, bl, br):
    """Return the `Step` between two depths."""
    db, excess = bed_step(hl, hr, bl, br)
    above, below = upper(db, hl, hr), upper(db, hr, hl)
    size = np.abs(excess)
    inverse = 1.0 / (size + above + TINY)
    covered = above / (below + TINY)
    steep = minimum(1.0, 2.0 * np.abs(db) / (np.abs(hr - hl) + TINY)) * minimum(1.0, 2.0 * covered)
    raised, height = size * inverse, np.abs(db) / (hl + hr + TINY)
    steep = steep * maximum(0.0, minimum(1.0, 20.0 * height - 1.0))
    abrupt = maximum(0.0, minimum(1.0, 3.0 - 4.0 * height))
    even = minimum(1.0, 2.0 * below / (above + TINY))
    return Step(db, excess, inverse, raised, steep, steep * (1.0 - raised) * abrupt * even, maximum(0.0, 1.0 - covered))


def kinetic_head(step, ml, vl, mr, vr, push):
    """Return what the momentum of a phase, masses ml and mr, gains over a step: W v^ dv - mean(m v) dv, against its push.

    W, between the smaller and the larger mass, is the weight of the potential head, push = g W d(h + b). With it in the jump,
    the kinetic head has the same weight, so that the jump vanishes where discharge and total head are constant: falling
    water gains no energy, and a step of one face lets through what a resolved ramp does. Third order in the jump, so smooth
    flow is as before; 0 on a level bottom and at rest. It takes part of the push, never more, nor adds to it, as in a steady
    flow: fast flow over rough ground would else break up. Derived here.
    """
    dm, dv = mr - ml, vr - vl
    head = step.steep * dv * dm * (0.25 * np.sign(step.db) * step.raised * (vl + vr) - 0.25 * dv)
    side = np.sign(head)
    return side * minimum(np.abs(head), maximum(-side * push, 0.0))


def carried_over(step, hl, vl, hr, vr, taken, al, ar, g):
    """Return the change of velocity, m/s, that stands at a steep step: -v^ dh/h^, with one discharge on both sides.

    Where the discharge changes by more than a third of what depth and velocity alone would change it, less stands, and nothing
    from two thirds on: that is a wave. The push of the bottom, g h^ db, makes the change: as much as friction takes of the push,
    as much less of it stands. A flow that friction balances over the steps of a slope would else grow waves. Less stands where
    flow is faster than 3/4 of its waves on both sides, and nothing where it is faster than these, since all waves go down then;
    and where one depth is over five times the other, nothing from eleven times on: what has all but gone would be shot out.
    """
    shallower, faster, depths = (vl + vr) * (hr - hl), (hl + hr) * (vr - vl), hl + hr
    steady = 2.0 - 3.0 * np.abs(shallower + faster) / (np.abs(shallower) + np.abs(faster) + TINY)
    bottom = 0.5 * g * depths * np.abs(step.db)
    even, sound = minimum(maximum(5.0 * depths - 6.0 * np.abs(hr - hl), 0.0), depths), al + ar
    slower = minimum(maximum(8.0 * maximum(al - np.abs(vl), ar - np.abs(vr)), 0.0), sound)
    left = slower * even * maximum(bottom - np.abs(taken), 0.0) / (sound * bottom * depths * depths + TINY)
    return -step.standing * minimum(1.0, maximum(0.0, steady)) * left * shallower


def wall_share(step, vl, vr, g):
    """Return the share of a wall in an emerged step, for the phase on its lower side, and whether that runs towards it.

    With k = v^2/2g, 1 towards the step where k lies below about a tenth of its excess e, and 0 from e/8 on: what has the
    energy to climb climbs. Both bounds are 16 times lower where e is not larger than the depth of the lower side: smooth
    slopes are no walls to a wave that runs up them. Away from the step 1 - 10 k/e. All fade where the upper side is as deep as
    the lower one: water that comes down a step runs on.
    """
    v, size = upper(step.db, vr, vl), np.abs(step.excess)
    k = 0.5 / g * v * v
    towards = np.sign(step.db) * v > 0.0
    shore = minimum(1.0, maximum(0.0, 2.0 * (np.abs(step.db) - size) * step.inverse - 0.2))
    closed = minimum(1.0, CLOSING * (size - (HIGH + SHORE * shore) * k) * step.inverse)
    share = where(towards, closed, (size - 10.0 * k) * step.inverse)
    return where(size > 0.0, step.bare * maximum(share, 0.0), 0.0), towards


def wall_push(step, ml, vl, mr, vr, hl, hr, al, ar, g):
    """Return the push of an emerged step on the phase of mass m on its lower side: a wall, as far as `wall_share` has it.

    m v (a + 3/2 max(v, 0)) for v towards the step, what a mirror image would exert in the relaxation solver, which then lets
    nothing climb; pulled back by no more than the static pressure. An emerged step without it is a valve: water climbs it
    without energy and does not come back, and at rest rounding grows to metres per second. Derived here.
    """
    share, _ = wall_share(step, vl, vr, g)
    side, v, m = np.sign(step.db), upper(step.db, vr, vl), upper(step.db, mr, ml)
    towards = side * v
    push = m * towards * (upper(step.db, ar, al) + 1.5 * maximum(towards, 0.0))
    return share * side * maximum(push, -0.5 * g * m * upper(step.db, hr, hl))


def upper(db, left, right):
    """Return the value of the side with the higher bottom."""
    return where(db > 0.0, right, left)


def mean_velocity(hl, vl, hr, vr):
    """Return the Roe mean (sqrt(hl) vl + sqrt(hr) vr)/(sqrt(hl) + sqrt(hr)); 0 where both depths are."""
    rootl, rootr = np.sqrt(hl), np.sqrt(hr)
    return (rootl * vl + rootr * vr) / (rootl + rootr + TINY)


#: Default threshold of a dry cell, as a share of the largest initial depth.
DRY_SHARE = 1e-8

DRY_HINT = "depth in metres below which a film does not move; None for 1e-8 of the largest initial depth"


def resolved(model: Any, q0: np.ndarray) -> Any:
    """Return the model with its ``dry``, where it is None, set to fit the initial state."""
    if model.dry is not None:
        return model
    largest = float(q0[[row for masses, _ in model.phases for row in masses]].sum(axis=0).max())
    return attrs.evolve(model, dry=max(DRY_SHARE * largest, LEAST_DRY))


def share(part, whole):
    """Return part/whole, and part where the whole is 0.

    Parameters
    ----------
    part, whole : of the same unit, whole >= 0.
    """
    return part / where(whole > 0.0, whole, 1.0)


def reciprocal(depth):
    """Return 1/depth, m^-1, for depths >= 0 down to 1e-300 m, and 1e300 below."""
    return 1.0 / maximum(depth, 1e-300)
