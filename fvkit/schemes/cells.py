"""The polynomial of a cell: reconstruction of faces, the integral inside, and sources at its nodes."""

from typing import Any, NamedTuple

import numpy as np

from fvkit.pointwise import add, minimum, scale, subtract
from fvkit.polynomial import polynomial
from fvkit.schemes.shores import kept, smoothness, trust


def reconstruct(parts, ratio, *stencil):
    """Return the states and aux values at both faces of a cell, and the integral over it."""
    left, right, q, aux = polynomials(parts, *stencil)
    return (left, right, tuple([item.left for item in aux]), tuple([item.right for item in aux]),
            inside(parts.model, left, right, q, aux))


def polynomials(parts, *stencil):
    """Return the face states of a cell, and the polynomials of q and aux on it, drawn to their means at shores."""
    model, width = parts.model, len(stencil) // 2
    states, given = stencil[:width], [item[:len(model.aux)] for item in stencil[width:]]
    flows = [of_background(model, item) for item in stencil[width:]]
    q, aux, flow = states[width // 2], given[width // 2], flows[width // 2]
    bed_left, bed_right = faces(parts.reconstruction, [subtract(item, aux) for item in given])
    bed_third = third(parts.reconstruction, given)
    lifted = [subtract(item, q) for item in states]
    lifts = model.defines("lift") and flow is None
    if flow is not None:
        lifted = [subtract(item, subtract(own.mean, flow.mean)) for item, own in zip(lifted, flows, strict=True)]
    if lifts:
        lifted = [add(item, model.lift(q, subtract(bed, aux))) for item, bed in zip(lifted, given, strict=True)]
    modes = [model.to_modes(q, item) for item in lifted]
    left, right = (model.from_modes(q, amplitudes) for amplitudes in faces(parts.reconstruction, modes))
    bend = third(parts.reconstruction, lifted)
    if lifts:
        left, right, bend = (subtract(item, model.lift(q, bed)) for item, bed in
                             ((left, bed_left), (right, bed_right), (bend, bed_third)))
    if flow is not None:
        left, right = add(left, subtract(flow.left, flow.mean)), add(right, subtract(flow.right, flow.mean))
        bend = add(bend, flow.third)
    if model.phases:
        share = trust(model, states, left, right)
        if lifts:
            share = minimum(share, smoothness(model, states, given))
        left, right, bend, bed_left, bed_right, bed_third = (
            kept(share, item) for item in (left, right, bend, bed_left, bed_right, bed_third))
    left, right, bed_left, bed_right = add(q, left), add(q, right), add(aux, bed_left), add(aux, bed_right)
    return (left, right, tuple(map(polynomial, q, left, right, bend)),
            tuple(map(polynomial, aux, bed_left, bed_right, bed_third)))


class Background(NamedTuple):
    """A background on a cell: its average, face values, third mode and residual."""

    mean: Any
    left: Any
    right: Any
    third: Any
    residual: Any


def of_background(model, aux):
    """Return the background behind the aux values of a cell, None where there is none."""
    rows, own = len(model.conserved), len(model.aux)
    behind = aux[own:]
    return Background(*(behind[k:k + rows] for k in range(0, 5 * rows, rows))) if behind else None


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
    """Return the integral over a cell; nothing in the rows of masses, whose fluxes stand at the faces."""
    if model.defines("cell_integral"):
        result = model.cell_integral(left, right, q, aux)
    elif model.defines("jump"):
        result = romberg(model, left, right, q, aux)
    else:
        result = subtract(model.flux(right), model.flux(left))
    return tuple([0.0 if row in model.mass_rows() else item for row, item in enumerate(result)])


def romberg(model, left, right, q, aux):
    """Return the sum of jumps along the polynomial, extrapolated from 1, 2 and 4 pieces of the cell: seventh order."""
    def at(xi):
        return tuple([item.at(xi) for item in q]), tuple([item.at(xi) for item in aux])

    points = [(left, tuple([item.left for item in aux])), at(-0.25), at(0.0), at(0.25),
              (right, tuple([item.right for item in aux]))]

    def pieces(step):
        total = None
        for first, last in zip(points[:-1:step], points[step::step], strict=True):
            jump = model.jump(first[0], last[0], first[1], last[1])
            total = jump if total is None else add(total, jump)
        return total

    return tuple([(one - 20.0 * two + 64.0 * four) * (1.0 / 45.0)
                  for one, two, four in zip(pieces(4), pieces(2), pieces(1), strict=True)])


#: Gauss and Legendre's nodes in [-1/2, 1/2] and weights at which implicit sources act.
NODES = tuple((0.5 * float(x), 0.5 * float(w)) for x, w in zip(*np.polynomial.legendre.leggauss(3), strict=True))


def mean_source(parts, ratio, *stencil):
    """Return minus the mean over a cell of S(y), y = q + a S(y), at Gauss nodes; ``ratio`` is a."""
    _, _, q, aux = polynomials(parts, *stencil)
    result: Any = None
    for node, weight in NODES:
        state, given = tuple([item.at(node) for item in q]), tuple([item.at(node) for item in aux])
        rate = scale(-weight, parts.sources[0].implicit_rate(parts.model, state, given, ratio))
        result = rate if result is None else add(result, rate)
    return (result,)


def net_change(parts, ratio, from_left, from_right, inner, aux):
    """Sum what enters a cell through both of its faces and what happens inside, less what that makes of the background."""
    whole, flow = add(add(from_left, from_right), inner), of_background(parts.model, aux)
    return (whole if flow is None else subtract(whole, flow.residual),)
