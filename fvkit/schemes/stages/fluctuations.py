"""From the jump of a face to waves, and from waves to what travels left and right through it.

Rows of masses hold the mass flux F of the face instead of its fluctuation: F in what goes left, and nothing in what goes
right. Both cells then see the same number, so that masses are conserved, and stay non-negative, to the last bit.
"""

from functools import reduce

import numpy as np

from fvkit.pointwise import combine, maximum, subtract, weighted
from fvkit.problem.answers import mass_flux
from fvkit.schemes.scheme import SPEED
from fvkit.schemes.stages.driven import Net, Restrained, for_cells, jumps, without_held


def riemann_problem(parts, ratio, ql, qr, auxl, auxr, later=0.0):
    """Resolve the jump of a face, less what sources take of it, into waves; see `fvkit.schemes.stages.driven`.

    The masses that take the push are those after ``later``, a fraction of the step.
    """
    whole, net, bearing = jumps(parts, ratio, ql, qr, auxl, auxr)
    held = not all(source.between_phases for source in parts.joint)
    model = Restrained(parts.model, whole, net) if held else parts.model
    waves, speeds = parts.riemann.solve(model, ql, qr, auxl, auxr, Net(net, whole))
    if net is not whole:
        waves = without_held(parts.model, whole, net, waves)
    fastest = reduce(maximum, map(np.abs, speeds))
    found = {"jump": for_cells(parts.model, ql, qr, whole, net), "waves": waves, "speeds": speeds, SPEED: fastest}
    if bearing:
        found["bearing"] = tuple([maximum(mass - later * ratio * whole[masses[-1]], 0.0)
                                  for mass, (masses, _) in zip(bearing, parts.model.phases, strict=True)])
    return found


def fluctuations(parts, ratio, ql, qr, jump, waves, sides):
    """Split the jump of a face into what travels left and what travels right."""
    left = weighted([0.5 - side for side in sides], waves)
    if parts.joint:
        standing = subtract(jump, weighted([1.0] * len(waves), waves))
        left = combine(1.0, left, 0.5, standing)
    left = anchored(parts, ql, left)
    return {"left_going": left, "right_going": rest_of(parts, jump, left)}


def half_signs(speeds):
    """Return half the sign of every speed: 1/2 minus it is the share of the wave that travels left."""
    return tuple([0.5 * np.sign(speed) for speed in speeds])


def travelling_left(waves, speeds):
    """Return the sum of the waves that travel left; a standing f-wave is split in half."""
    return weighted([0.5 - side for side in half_signs(speeds)], waves)


def anchored(parts, ql, left):
    """Return what goes left with the mass fluxes in the rows of masses."""
    rows = parts.model.mass_rows()
    if not rows:
        return left
    flux = mass_flux(parts.model, ql)
    return tuple([flux[k] + item if k in rows else item for k, item in enumerate(left)])


def rest_of(parts, jump, left):
    """Return what goes right: the rest of the jump, and nothing in the rows of masses."""
    rows = parts.model.mass_rows()
    return tuple([0.0 if k in rows else item for k, item in enumerate(subtract(jump, left))])
