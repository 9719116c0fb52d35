"""Wet/dry fronts: thin layers, desingularised velocities, and emerged steps of the bottom.

All functions are pointwise and shared by all models of the package. Derived by this project, except the
desingularised velocity, which is common practice.
"""

from typing import Any, NamedTuple

import attrs
import numpy as np

from fvkit.pointwise import known, maximum, minimum, rarely, where

#: Smallest threshold of a dry cell, m: products of three depths stay normal numbers.
LEAST_DRY = 1e-30

#: Depth relative to ``dry`` below which a layer is absent at faces: its mass stays in the cell.
IMMOBILE = 1e-10

#: An emerged step becomes a wall once its excess exceeds a multiple of the kinetic head of the flow towards it: ``HIGH`` for a
#: step far above the water, ``HIGH + SHORE`` for a step of a shore, no higher than the water before it. ``CLOSING`` is the rate.
CLOSING, HIGH, SHORE = 4.0, 8.0, 120.0

#: A bottom counts as resolved where the depths of two neighbours together are this many times the step between them.
RESOLVED = 20.0

#: Added to denominators that vanish together with their numerators: far below any product of depths and speeds.
TINY = 1e-200


def threshold(dry):
    """Return the depth below which a cell counts as dry, m; `LEAST_DRY` for None."""
    return known(dry, LEAST_DRY)


def present(h, dry):
    """Return the depth used at faces, m: h, or 0 for an immobile film."""
    return where(h > IMMOBILE * threshold(dry), h, 0.0)


def wetness(h, dry):
    """Return h/dry, at most 1."""
    return minimum(1.0, h * (1.0 / threshold(dry)))


def velocity(h, m, dry):
    """Return the desingularised velocity m min(1, h/dry)/max(h, dry), m/s: m/h above ``dry``, tending to 0 below."""
    return m * wetness(h, dry) / maximum(h, threshold(dry))


def settled(h, m, dry):
    """Return the desingularised momentum, h times `velocity`, which prevents momentum without depth in thin films."""
    wet = wetness(h, dry)
    return m * (wet * wet)


def bed_step(hl, hr, bl, br):
    """Return the bottom step db and its excess e: db - e is the submerged part, at most the depth of the lower side.

    e acts on the depth of the upper side alone. So an emerged step (hr = 0, db >= hl) exerts no force at rest, and
    a thin film on a steep slope keeps its full weight.
    """
    db = br - bl
    beyond = maximum(db - hl, 0.0) - maximum(-db - hr, 0.0)
    return db, where(db == 0.0, 0.0, beyond)


def covered_step(hl, hr, bl, br):
    """Return the submerged part of a bottom step, m; with the full height of a cliff, corrections would hold water on it."""
    db, excess = bed_step(hl, hr, bl, br)
    return db - excess


class BottomStep(NamedTuple):
    """Bottom step at a face, with its weights in the jump.

    Parameters
    ----------
    db, excess : see `bed_step`.
    inverse : 1/(|e| + h_up), 1/m.
    raised : |e|/(|e| + h_up), fraction of the potential head over the step that acts on the upper side alone.
    steep : fraction of the velocity change over the face attributed to the step: at most 2 |db|/|dh|; 0 at shores and where
        the step is below 1/20 of hl + hr (a resolved bottom), full from 1/10 on.
    standing : fraction of the velocity change that is stationary: as ``steep``, for depths of similar size and steps of at
        most 3/4 of hl + hr; 0 for a film on a slope.
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
    """Return the `BottomStep` at a face with depths hl, hr and bottoms bl, br, m: of a resolved bottom nothing but db."""
    db, depths = br - bl, hl + hr
    abrupt = (RESOLVED * np.abs(db) > depths) | (db > hl) | (-db > hr)
    return rarely((db != 0.0) & (depths > 0.0) & abrupt, lambda: abrupt_step(hl, hr, bl, br),
                  BottomStep(db, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0))


def abrupt_step(hl, hr, bl, br):
    """Return the `BottomStep` at a face where the bottom is not resolved, or emerges."""
    db, excess = bed_step(hl, hr, bl, br)
    above, below = upper(db, hl, hr), upper(db, hr, hl)
    size = np.abs(excess)
    inverse = 1.0 / (size + above + TINY)
    covered = above / (below + TINY)
    steep = minimum(1.0, 2.0 * np.abs(db) / (np.abs(hr - hl) + TINY)) * minimum(1.0, 2.0 * covered)
    raised, height = size * inverse, np.abs(db) / (hl + hr + TINY)
    steep = steep * maximum(0.0, minimum(1.0, RESOLVED * height - 1.0))
    abrupt = maximum(0.0, minimum(1.0, 3.0 - 4.0 * height))
    even = minimum(1.0, 2.0 * below / (above + TINY))
    return BottomStep(db, excess, inverse, raised, steep, steep * (1.0 - raised) * abrupt * even, maximum(0.0, 1.0 - covered))


def kinetic_head(step, ml, vl, mr, vr, push):
    """Return the kinetic head term of a phase with masses ml, mr at a step: W v^ dv - mean(m v) dv, opposed to the push.

    W, between the smaller and the larger mass, is the weight of the potential head, push = g W d(h + b). With this term the
    kinetic head has the same weight, so the jump vanishes where discharge and total head are constant: falling water gains no
    energy, and a step of one face has the discharge of a resolved ramp. The term is of third order in the jump, so smooth
    flow is unaffected; it is 0 on a level bottom and at rest. It never exceeds the push and never adds to it, as in steady
    flow; otherwise fast flow over rough ground would be unstable. Derived here.
    """
    dm, dv = mr - ml, vr - vl
    head = step.steep * dv * dm * (0.25 * np.sign(step.db) * step.raised * (vl + vr) - 0.25 * dv)
    side = np.sign(head)
    return side * minimum(np.abs(head), maximum(-side * push, 0.0))


def carried_over(step, hl, vl, hr, vr, taken, al, ar, g):
    """Return the stationary velocity jump at a steep step, m/s: -v^ dh/h^, of a flow with equal discharge on both sides.

    The jump is reduced in these cases:

    * The discharge changes by more than 1/3 of |v^ dh| + |h^ dv|; 0 from 2/3 on, since that is a wave.
    * Friction balances part of the push of the bottom, g h^ db: reduced in proportion. Otherwise a flow balanced by friction
      over the steps of a slope would develop waves.
    * The flow is faster than 3/4 of the wave speed on both sides; 0 for supercritical flow, where all waves travel downstream.
    * One depth is more than 5 times the other; 0 from 11 times on, to avoid excessive velocities in thin layers.
    """
    shallower, faster, depths = (vl + vr) * (hr - hl), (hl + hr) * (vr - vl), hl + hr
    steady = 2.0 - 3.0 * np.abs(shallower + faster) / (np.abs(shallower) + np.abs(faster) + TINY)
    bottom = 0.5 * g * depths * np.abs(step.db)
    even, sound = minimum(maximum(5.0 * depths - 6.0 * np.abs(hr - hl), 0.0), depths), al + ar
    slower = minimum(maximum(8.0 * maximum(al - np.abs(vl), ar - np.abs(vr)), 0.0), sound)
    left = slower * even * maximum(bottom - np.abs(taken), 0.0) / (sound * bottom * depths * depths + TINY)
    return -step.standing * minimum(1.0, maximum(0.0, steady)) * left * shallower


def wall_share(step, vl, vr, g):
    """Return the wall fraction of an emerged step for the phase on its lower side, and whether the flow is towards the step.

    With kinetic head k = v^2/2g and flow towards the step, the fraction is 1 for k below about e/10, e the excess, and 0 from
    e/8 on, where the flow has enough energy to climb. Both bounds are 16 times lower where e is at most the depth of the lower
    side, so that waves run up smooth slopes. For flow away from the step it is 1 - 10 k/e. The fraction vanishes as the upper
    side becomes as deep as the lower one.
    """
    v, size = upper(step.db, vr, vl), np.abs(step.excess)
    k = 0.5 / g * v * v
    towards = np.sign(step.db) * v > 0.0
    shore = minimum(1.0, maximum(0.0, 2.0 * (np.abs(step.db) - size) * step.inverse - 0.2))
    closed = minimum(1.0, CLOSING * (size - (HIGH + SHORE * shore) * k) * step.inverse)
    share = where(towards, closed, (size - 10.0 * k) * step.inverse)
    return where(size > 0.0, step.bare * maximum(share, 0.0), 0.0), towards


def wall_push(step, ml, vl, mr, vr, hl, hr, al, ar, g):
    """Return the wall force of an emerged step on the phase of mass m on its lower side, weighted by `wall_share`.

    The force is m v (a + 3/2 max(v, 0)), v towards the step: that of a reflecting wall in the relaxation solver. A negative
    force is limited by half the static pressure. Without it an emerged step acts as a valve: water climbs it without energy
    and does not return, and at rest round-off grows to metres per second. Derived here.
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


#: Default ``dry`` relative to the largest initial depth.
DRY_SHARE = 1e-8

#: Default ``dry`` of ground that is dry everywhere at the start, m.
DRY_START = 1e-9

DRY_HINT = "depth in metres below which a film does not move; None for 1e-8 of the largest initial depth"


def resolved(model: Any, q0: np.ndarray) -> Any:
    """Return the model with ``dry`` set from the initial state if it is None."""
    if model.dry is not None:
        return model
    largest = float(q0[[row for masses, _ in model.phases for row in masses]].sum(axis=0).max())
    return attrs.evolve(model, dry=max(DRY_SHARE * largest, LEAST_DRY) if largest > 0.0 else DRY_START)


def share(part, whole):
    """Return the ratio part/whole of quantities of the same unit, whole >= 0, and part where the whole is 0."""
    return part / where(whole > 0.0, whole, 1.0)


def reciprocal(depth):
    """Return 1/depth, m^-1, for depths >= 0 down to 1e-300 m, and 1e300 below."""
    return 1.0 / maximum(depth, 1e-300)
