"""The polynomial of a cell: reconstruction of faces, the integral inside, and sources at its nodes."""

from functools import reduce
from itertools import starmap

import numpy as np

from fvkit.pointwise import TINY, add, maximum, minimum, scale, subtract, where
from fvkit.pointwise.polynomial import polynomial
from fvkit.problem.answers import flux
from fvkit.schemes.background import of_background
from fvkit.schemes.scheme import NET
from fvkit.schemes.stages.faces import COMPOSITE, composite, excess_speeds
from fvkit.schemes.stages.shore_limiter import allowed_share, any_applies, rules, scaled

#: What is found of a cell: the states and aux values at its faces, and the integral over it.
FOUND = ("left", "right", "left_aux", "right_aux", "inside")


def reconstruct(parts, ratio, q, aux):
    """Return the states and aux values at both faces of a cell, and the integral over it."""
    here, bed, *deviation = cell = unlimited(parts, (*q, *aux))
    if composite(parts.model):
        cell = limited(here, bed, convex_share(parts.model, q, aux), *deviation)
    return dict(zip(FOUND, on_cell(parts.model, *cell), strict=True))


def convex_share(model, q, aux):
    """Return the share of the deviations that a composite wave, fan and shock in one, leaves.

    Sharper values would turn it into a shock that breaks the entropy condition. The share is 1 where speeds between neighbours
    leave those of both by less than 1/`COMPOSITE` of the largest in the stencil, and 0 from twice that on, so smooth flow has
    its order. Derived here.
    """
    excess, largest = 0.0, TINY
    for left, right, auxl, auxr in zip(q[:-1], q[1:], aux[:-1], aux[1:], strict=True):
        outside, s1, s2 = excess_speeds(model, left, right, auxl, auxr)
        excess, largest = maximum(excess, outside), maximum(largest, maximum(np.abs(s1), np.abs(s2)))
    return minimum(maximum(2.0 - COMPOSITE * excess / largest, 0.0), 1.0)


def near_shore(parts, ratio, q, aux, left, right, **others):
    """Whether the polynomial of a cell must be limited."""
    states, given = states_and_aux(parts.model, (*q, *aux))
    here = states[len(states) // 2]
    lifted = uses_lift(parts.model, (*q, *aux))
    return any_applies(rules(parts.model, states, given, subtract(left, here), subtract(right, here), lifted))


def limit_at_shore(parts, ratio, q, aux, left, right, left_aux, right_aux, inside):
    """Scale the polynomial that `reconstruct` returned for a cell towards its mean; unchanged where no condition requires it."""
    stencil, found = (*q, *aux), (left, right, left_aux, right_aux, inside)
    states, given = states_and_aux(parts.model, stencil)
    here, bed = states[len(states) // 2], given[len(given) // 2]
    sides = (subtract(left, here), subtract(right, here), subtract(left_aux, bed), subtract(right_aux, bed))
    share = shore_share(parts, stencil, sides)
    cell = limited(here, bed, share, sides, third_modes_of(parts, stencil, deviations(parts, stencil)))
    return {name: tuple([where(share >= 1.0, old, new) for old, new in zip(before, after, strict=True)])
            for name, before, after in zip(FOUND, found, on_cell(parts.model, *cell), strict=True)}


def polynomials(parts, stencil):
    """Return the polynomials of q and aux on a cell, limited towards their means at shores."""
    q, aux, sides, third_modes = unlimited(parts, stencil)
    if parts.model.phases:
        q, aux, sides, third_modes = limited(q, aux, shore_share(parts, stencil, sides), sides, third_modes)
    _, _, inner, bed = assembled(q, aux, sides, third_modes)
    return inner, bed


def states_and_aux(model, stencil):
    """Return the states and the aux values of a stencil, without the rows behind the aux values."""
    width = len(stencil) // 2
    return stencil[:width], [item[:len(model.aux)] for item in stencil[width:]]


def uses_lift(model, stencil):
    """Whether q + lift is reconstructed: not with a background, whose deviation is."""
    return model.defines("lift") and of_background(model, stencil[-1]) is None


def deviations(parts, stencil):
    """Return the reconstructed variable, less its value in the cell: q + lift, or q - background."""
    model, (states, given) = parts.model, states_and_aux(parts.model, stencil)
    flows = [of_background(model, item) for item in stencil[len(states):]]
    q, aux, flow = states[len(states) // 2], given[len(given) // 2], flows[len(flows) // 2]
    found = [subtract(item, q) for item in states]
    if flow is not None:
        return [subtract(item, subtract(own.mean, flow.mean)) for item, own in zip(found, flows, strict=True)]
    if model.defines("lift"):
        return [add(item, model.lift(q, subtract(bed, aux))) for item, bed in zip(found, given, strict=True)]
    return found


def third_modes_of(parts, stencil, found):
    """Return the third modes of q and of aux; ``found`` are the `deviations`."""
    model, (states, given) = parts.model, states_and_aux(parts.model, stencil)
    flow, bed = of_background(model, stencil[-1 - len(states) // 2]), third(parts.reconstruction, given)
    bend = third(parts.reconstruction, found)
    if flow is not None:
        return add(bend, flow.third), bed
    return (subtract(bend, model.lift(states[len(states) // 2], bed)) if model.defines("lift") else bend), bed


def unlimited(parts, stencil):
    """Return q and aux of a cell, the deviations at its faces, (left, right) of each, and the third modes of both."""
    model, (states, given) = parts.model, states_and_aux(parts.model, stencil)
    q, aux, flow = states[len(states) // 2], given[len(given) // 2], of_background(model, stencil[-1 - len(states) // 2])
    beds = faces(parts.reconstruction, [subtract(item, aux) for item in given])
    found = deviations(parts, stencil)
    modes = [model.to_modes(q, item) for item in found]
    left, right = (model.from_modes(q, amplitudes) for amplitudes in faces(parts.reconstruction, modes))
    if flow is not None:
        left, right = add(left, subtract(flow.left, flow.mean)), add(right, subtract(flow.right, flow.mean))
    elif model.defines("lift"):
        left, right = (subtract(item, model.lift(q, bed)) for item, bed in zip((left, right), beds, strict=True))
    return q, aux, (left, right, *beds), third_modes_of(parts, stencil, found)


def shore_share(parts, stencil, sides):
    """Return the share of the deviations that a shore leaves."""
    states, given = states_and_aux(parts.model, stencil)
    return allowed_share(rules(parts.model, states, given, sides[0], sides[1], uses_lift(parts.model, stencil)))


def limited(q, aux, share, sides, third_modes):
    """Return what `unlimited` does with a share of the deviations."""
    return q, aux, tuple([scaled(share, item) for item in sides]), tuple([scaled(share, item) for item in third_modes])


def assembled(q, aux, sides, third_modes):
    """Return the states at both faces, and the polynomials of q and aux."""
    left, right, bed_left, bed_right = add(q, sides[0]), add(q, sides[1]), add(aux, sides[2]), add(aux, sides[3])
    return (left, right, tuple(map(polynomial, q, left, right, third_modes[0])),
            tuple(map(polynomial, aux, bed_left, bed_right, third_modes[1])))


def on_cell(model, q, aux, sides, third_modes):
    """Return the states and aux values at both faces of a cell, and the integral over it."""
    left, right, inner, bed = assembled(q, aux, sides, third_modes)
    return (left, right, add(aux, sides[2]), add(aux, sides[3]), inside(model, left, right, inner, bed))


def faces(reconstruction, stencil):
    """Return the left and right values of each component of a stencil of tuples."""
    pad = (None,) * (2 - reconstruction.reach)
    cells = [(*pad, *values, *pad) for values in zip(*stencil, strict=True)]
    return (tuple([reconstruction.right(*values[::-1]) for values in cells]),
            tuple([reconstruction.right(*values) for values in cells]))


def third(reconstruction, stencil):
    """Return the third mode of each component: the third difference of its averages over 6."""
    if not reconstruction.cubic:
        return tuple([0.0 for _ in stencil[0]])
    return tuple([((e - a) - 2.0 * (d - b)) * (1.0 / 12.0) for a, b, _, d, e in zip(*stencil, strict=True)])


def inside(model, left, right, q, aux):
    """Return the integral over a cell; 0 in the rows of masses, whose fluxes act at the faces."""
    if model.defines("cell_integral"):
        result = model.cell_integral(left, right, q, aux)
    elif model.defines("jump"):
        result = romberg(model, left, right, q, aux)
    else:
        bedl, bedr = tuple([item.left for item in aux]), tuple([item.right for item in aux])
        result = subtract(flux(model, right, bedr), flux(model, left, bedl))
    return tuple([0.0 if row in model.mass_rows() else item for row, item in enumerate(result)])


def romberg(model, left, right, q, aux):
    """Return the sum of jumps along the polynomial, extrapolated from 1, 2 and 4 pieces of the cell: seventh order."""
    def at(xi):
        return tuple([item.at(xi) for item in q]), tuple([item.at(xi) for item in aux])

    points = [(left, tuple([item.left for item in aux])), at(-0.25), at(0.0), at(0.25),
              (right, tuple([item.right for item in aux]))]

    def pieces(step):
        return reduce(add, [model.jump(first[0], last[0], first[1], last[1])
                            for first, last in zip(points[:-1:step], points[step::step], strict=True)])

    return tuple([(one - 20.0 * two + 64.0 * four) * (1.0 / 45.0)
                  for one, two, four in zip(pieces(4), pieces(2), pieces(1), strict=True)])


#: Gauss and Legendre's nodes in [-1/2, 1/2] and weights at which implicit sources act.
NODES = tuple((0.5 * float(x), 0.5 * float(w)) for x, w in zip(*np.polynomial.legendre.leggauss(3), strict=True))


def mean_source(parts, ratio, q, aux):
    """Return minus the mean over a cell of S(y), y = q + a S(y), at Gauss nodes; ``ratio`` is a."""
    inner, bed = polynomials(parts, (*q, *aux))

    def share(node, weight):
        state, given = tuple([item.at(node) for item in inner]), tuple([item.at(node) for item in bed])
        return scale(-weight, parts.sources[0].implicit_rate(parts.model, state, given, ratio))

    return {NET: reduce(add, starmap(share, NODES))}


def net_change(parts, ratio, from_left, from_right, inside, aux):
    """Sum what enters a cell through both of its faces and what happens inside, less what that makes of the background."""
    total, flow = add(add(from_left, from_right), inside), of_background(parts.model, aux)
    return {NET: total if flow is None else subtract(total, flow.residual)}
