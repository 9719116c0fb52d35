"""Sources in the plane: a state is turned along the velocity of each phase, or along the slip, for a one-dimensional law.

Friction acts against the velocity, whatever its direction, and drag along the slip. States have their momenta across behind them,
one for each phase. A state whose momenta across are 0 is not turned, to the bit. Derived here.
"""

import numpy as np

from fvkit.pointwise import maximum, minimum, where


def turned(source, model, reference, before, after, law, along_only=False):
    """Return what ``law(before, after)`` makes of two one-dimensional states, turned along ``reference``, and turned back.

    ``along_only`` leaves out the components across, where the result has none; else the law acts on these alike.
    """
    ways = ways_of(source, model, reference)
    (first, start), (second, end) = (components(model, state, ways) for state in (before, after))
    result = law(first, second)
    across = tuple([0.0 * item for item in end]) if along_only else momenta(model, law(
        with_momenta(model, first, start), with_momenta(model, second, end)))
    return turned_back(model, result, across, ways)


def stepped(source, model, state, law):
    """Return what a one-dimensional ``law`` makes of a state: along its velocities, or along the slip and alike across it.

    A momentum along the velocity is scaled as the law scales it, so one that the law leaves is the same to the bit.
    """
    if source.between_phases:
        return turned(source, model, state, state, state, lambda _, end: law(end))
    ways = ways_of(source, model, state)
    along, _ = components(model, state, ways)
    result, both = law(along), []
    old = zip(momenta(model, state), state[len(model.conserved):], strict=True)
    for (m, w), now, then, (c, s) in zip(old, momenta(model, result), momenta(model, along), ways, strict=True):
        moves = then != 0.0
        factor = now / where(moves, then, 1.0)
        both.append((where(moves, m * factor, now * c), where(moves, w * factor, now * s)))
    return (*with_momenta(model, result, [m for m, _ in both]), *(w for _, w in both))


def driven_in_plane(source, model, before, after, bearing, aux, dt):
    """Return the state after dt under a drive and a source, see `fvkit.Source.driven`, with the momenta across behind it.

    Along the mean momentum of the step friction acts as on a line. Across it the momentum runs from -a to a under the drive
    alone, so that friction takes nothing of first order; of strong friction it leaves as little as it leaves along.
    """
    middle = tuple([one + other for one, other in zip(before, after, strict=True)])

    def law(start, end):
        return source.driven(model, start, end, bearing, aux, dt)

    if source.between_phases:
        return turned(source, model, middle, before, after, law)
    ways = ways_of(source, model, middle)
    (first, _), (second, end) = (components(model, state, ways) for state in (before, after))
    result = law(first, second)
    left = []
    for free, kept, across in zip(momenta(model, second), momenta(model, result), end, strict=True):
        moves = free != 0.0
        taken = 1.0 - where(moves, maximum(minimum(kept / where(moves, free, 1.0), 1.0), 0.0), 1.0)
        left.append(across * (1.0 - taken * taken))
    return turned_back(model, result, tuple(left), ways)


def ways_of(source, model, state):
    """Return the direction of each phase, cosine and sine: of its velocity, or of the slip for a source between phases."""
    own = len(model.conserved)
    along, across = momenta(model, state), state[own:]
    if not source.between_phases:
        return [unit(m, w) for m, w in zip(along, across, strict=True)]
    first, second = (state[phase.masses[-1]] for phase in model.phases[:2])
    way = unit(first * along[1] - second * along[0], first * across[1] - second * across[0])
    return [way] * len(along)


def unit(x, y):
    """Return the direction of a vector, along the axis of x for none."""
    size = np.sqrt(x * x + y * y)
    some = size > 0.0
    safe = where(some, size, 1.0)
    return where(some, x / safe, 1.0), where(some, y / safe, 0.0)


def momenta(model, q):
    """Return the momentum of each phase."""
    return tuple([q[phase.momentum] for phase in model.phases])


def with_momenta(model, q, given):
    """Return a state with other momenta."""
    result = list(q[:len(model.conserved)])
    for phase, momentum in zip(model.phases, given, strict=True):
        result[phase.momentum] = momentum
    return tuple(result)


def components(model, state, ways):
    """Return a state with the momenta along the directions, and the momenta across them."""
    pairs = list(zip(momenta(model, state), state[len(model.conserved):], ways, strict=True))
    return (with_momenta(model, state, [m * c + w * s for m, w, (c, s) in pairs]),
            tuple([w * c - m * s for m, w, (c, s) in pairs]))


def turned_back(model, q, across, ways):
    """Return the state that has these components, with its momenta across behind it."""
    pairs = list(zip(momenta(model, q), across, ways, strict=True))
    return (*with_momenta(model, q, [m * c - w * s for m, w, (c, s) in pairs]), *(m * s + w * c for m, w, (c, s) in pairs))
