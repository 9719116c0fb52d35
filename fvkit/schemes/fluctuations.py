"""From waves to what travels left and right through a face.

Rows of masses hold the mass flux F of the face instead of its fluctuation: F in what goes left, and nothing in what goes
right. Both cells then see the same number, so that masses are conserved, and stay non-negative, to the last bit.
"""

import numpy as np

from fvkit.pointwise import subtract, weighted


def half_signs(speeds):
    """Return half the sign of every speed: 1/2 minus it is the share of the wave that travels left."""
    return tuple([0.5 * np.sign(speed) for speed in speeds])


def left_going(waves, speeds):
    """Return the sum of the waves that travel left; a standing f-wave is split in half."""
    return weighted([0.5 - side for side in half_signs(speeds)], waves)


def anchored(parts, ql, left):
    """Return what goes left with the mass fluxes in the rows of masses."""
    rows = parts.model.mass_rows()
    if not rows:
        return left
    flux = parts.model.flux(ql)
    return tuple([flux[k] + item if k in rows else item for k, item in enumerate(left)])


def right_going(parts, jump, left):
    """Return what goes right: the rest of the jump, and nothing in the rows of masses."""
    rows = parts.model.mass_rows()
    return tuple([0.0 if k in rows else item for k, item in enumerate(subtract(jump, left))])
