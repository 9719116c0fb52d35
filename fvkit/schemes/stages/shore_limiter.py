"""Limiter of the reconstruction at wet/dry fronts: the deviation of a cell's polynomial from its mean is scaled down.

One factor in [0, 1] scales the whole polynomial, bottom included: rest, where q + lift is constant, holds for any factor.
Derived here.
"""

from functools import reduce
from operator import or_
from typing import Any

import numpy as np

from fvkit.pointwise import TINY, maximum, minimum, where
from fvkit.problem.answers import wave_speeds

#: A face keeps at least this share of the mean of its cell's mass.
LEAST = 0.1

#: The reconstruction is whole where the masses of its cells differ by less than this factor, and gone at twice that.
CONTRAST = 10.0

#: The velocity at a face may leave those of its cell and the next ones by this share of the range of the wave speeds.
HASTE = 0.1

#: Share of the whole below which the mass of a phase is no reason to give up order.
RARE = 1e-6


def rules(model, states, given, left, right, lifts):
    """Return pairs of a condition and the share that the cell may keep where it holds; ``left`` and ``right`` are deviations.

    The conditions need no division, so that they are cheap enough for every cell.
    """
    found = [*mass_ratios(model, states), *face_masses(model, states, left, right)]
    low, high = wave_speeds(model, states[len(states) // 2], given[len(given) // 2])
    for masses, momentum in model.phases:
        found += face_velocities(states, (left, right), masses[-1], momentum, HASTE * (high - low))
    return found + (smoothness(model, states, given) if lifts else [])


def any_applies(pairs):
    """Return whether any rule applies."""
    return reduce(or_, [condition for condition, _ in pairs], False)


def allowed_share(pairs):
    """Return the share of the deviation from the mean that all rules allow: 1 away from shores."""
    share: Any = 1.0
    for condition, allowed in pairs:
        share = minimum(share, where(condition, allowed, 1.0))
    return maximum(share, 0.0)


def mass_ratios(model, states):
    """Return the rule for masses that differ much among the cells."""
    rows = model.mass_rows()
    floor = RARE * reduce(maximum, [sum(state[row] for row in rows) for state in states])
    result = []
    for row in rows:
        masses = [state[row] for state in states]
        few, many = reduce(minimum, masses) + floor, reduce(maximum, masses) + floor
        result.append((CONTRAST * few < many, 2.0 * CONTRAST * few / (many + TINY) - 1.0))
    return result


def face_masses(model, states, left, right):
    """Return the rule for masses that fall too low at a face."""
    q, result = states[len(states) // 2], []
    for row in model.mass_rows():
        drop, spare = -minimum(left[row], right[row]), (1.0 - LEAST) * q[row]
        result.append((drop > spare, spare / (maximum(drop, 0.0) + TINY)))
    return result


def face_velocities(states, sides, row, momentum, sound):
    """Return the rule that keeps the velocities at both faces as close to that of the cell as those next to it are.

    A share s makes v + s (dm - v dh)/(h + s dh) of the velocity, so s (|dm - v dh| - V dh) <= V h bounds its change by V, here
    the largest difference to a neighbour and a little of the speed of sound. Where the depth of a thin cell falls to a
    tenth at a face but its momentum does not, the velocity would grow tenfold, stage after stage. Derived here.
    """
    centre = len(states) // 2
    before, here, after = ((state[row], state[momentum] / (state[row] + TINY)) for state in states[centre - 1:centre + 2])
    h, v = here
    bound = maximum(np.abs(before[1] - v), np.abs(after[1] - v)) + sound
    result = []
    for side in sides:
        excess, room = np.abs(side[momentum] - v * side[row]) - bound * side[row], bound * h
        result.append((excess > room, room / (maximum(excess, 0.0) + TINY)))
    return result


def smoothness(model, states, given):
    """Return the rule for bottoms that no cell resolves: nothing is left where third differences exceed the smallest depth.

    Rest survives without it, but a model whose density is frozen in the lift (`Reduced`) lets rounding grow there.
    """
    q = states[len(states) // 2]
    rough: Any = 0.0
    for a, b, c, d in zip(given, given[1:], given[2:], given[3:], strict=False):
        bend = tuple([(last - first) - 3.0 * (right - left) for first, left, right, last in zip(a, b, c, d, strict=True)])
        rough = maximum(rough, np.abs(sum(model.lift(q, bend)[row] for row in model.mass_rows())))
    depth = reduce(minimum, [sum(state[row] for row in model.mass_rows()) for state in states])
    return [(2.0 * rough > depth, 2.0 - 2.0 * rough / (depth + TINY))]


def scaled(share, deviation):
    """Return a share of a deviation; 0 for none of it, whatever it is: modes mean nothing where a cell is dry."""
    return tuple([where(share > 0.0, share * item, 0.0) for item in deviation])
