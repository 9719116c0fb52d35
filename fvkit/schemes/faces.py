"""What happens at a face, for every scheme: the Riemann problem, its fluctuations, entropy fix and fallback."""

from functools import partial

import numpy as np

from fvkit.pointwise import add, combine, maximum, scale, subtract, where
from fvkit.schemes.base import Parts, Read, Stage
from fvkit.schemes.dry import distrusted, fall_back
from fvkit.schemes.fluctuations import fluctuations, half_signs, riemann_problem

#: The fields of what a face sends to both sides.
BOTH = ("left_going", "right_going")


def here(*fields: str) -> tuple[Read, ...]:
    """Read fields of the face itself."""
    return tuple(Read(field, 0, 0) for field in fields)


def face_stages(parts: Parts, face: tuple[Read, ...], fixes: bool, waves: bool = False) -> list[Stage]:
    """Return the stages from the Riemann problem of a face to what travels left and right.

    Parameters
    ----------
    parts : the parts of the scheme.
    face : reads of the states left and right of a face and of the aux values there.
    fixes : whether outer fields get the entropy fix.
    waves : whether later stages need the waves, so that the fallback keeps them too.
    """
    model, riemann = parts.model, parts.riemann
    states = face[:len(face) // 2]
    found = ("jump", "waves", "speeds", "fastest", *(("bearing",) if parts.joint else ()))
    problem = partial(riemann_problem, later=0.5) if waves and parts.joint else riemann_problem
    result = [Stage(problem, face, found),
              Stage(upwinding, here("speeds"), ("sides",), light=True),
              Stage(fluctuations, (*states, *here("jump", "waves", "sides")), BOTH)]
    if fixes:
        result.append(Stage(entropy_viscosity, (*face, *here("speeds", *BOTH)), BOTH, guard=transonic))
    if model.defines("relaxation") and not riemann.positive:
        first = (*BOTH, "fastest")
        every = (*first, "speeds", "waves") if waves else (*first, "speeds") if fixes else first
        result.append(Stage(fall_back, (*face, *here(*every)), every if waves else first,
                            guard=distrusted_or_fixed if fixes else distrusted))
    return result


def upwinding(parts, ratio, speeds):
    """Return half the sign of every speed."""
    return (half_signs(speeds),)


def transonic(parts, ratio, ql, qr, auxl, auxr, speeds, left, right):
    """Whether an outer field passes through zero speed in a rarefaction of this face."""
    lowl, highl = parts.model.wave_speeds(ql)
    lowr, highr = parts.model.wave_speeds(qr)
    return maximum((lowr - lowl) - np.abs(speeds[0]), (highr - highl) - np.abs(speeds[-1])) > 0.0


def distrusted_or_fixed(parts, ratio, ql, qr, auxl, auxr, left, right, fastest, speeds, waves=None):
    """Whether a face needs the fallback, perhaps after the entropy fix."""
    return (distrusted(parts, ratio, ql, qr, auxl, auxr, left)
            | transonic(parts, ratio, ql, qr, auxl, auxr, speeds, left, right))


def entropy_viscosity(parts, ratio, ql, qr, auxl, auxr, speeds, left, right):
    """Add 1/2 (eta_k - |s_k|) p_k of the outer fields, p_k the parts of the balanced difference (Harten's eta)."""
    lowl, highl = parts.model.wave_speeds(ql)
    lowr, highr = parts.model.wave_speeds(qr)
    difference = parts.model.balanced_difference(ql, qr, auxl, auxr)
    pieces, _ = parts.model.decompose(ql, qr, auxl, auxr, difference)
    extra = scale(0.5 * harten(speeds[0], lowr - lowl), pieces[0])
    if len(speeds) > 1:
        extra = combine(1.0, extra, 0.5 * harten(speeds[-1], highr - highl), pieces[-1])
    left = subtract(left, extra)
    return left, tuple([0.0 if k in parts.model.mass_rows() else item for k, item in enumerate(add(right, extra))])


def harten(speed, width):
    """Return eta - |s|: (s^2/w + w)/2 - |s| where |s| is below the width w of the rarefaction, else 0."""
    size = np.abs(speed)
    fixed = size < width
    opening = where(fixed, width, 1.0)
    return where(fixed, 0.5 * (size * size / opening + opening) - size, 0.0)


def to_left(parts, ratio, left, *terms):
    """Return all that enters the cell left of a face, and the mass fluxes through it."""
    return (corrected(parts, left, 1.0, *terms),)


def to_right(parts, ratio, right, *terms):
    """Return all that enters the cell right of a face; of masses, what leaves the other one."""
    return (corrected(parts, right, -1.0, *terms),)


def corrected(parts, total, side, *terms):
    """Add the correction on one side, take the cross term from both, and put the mass fluxes in the rows of masses."""
    rows = parts.model.mass_rows()
    carried = dict(zip(rows, terms[-1], strict=True)) if rows else {}
    terms = terms[:-1] if rows else terms
    result = []
    for k, item in enumerate(total):
        if k in rows:
            item = side * carried[k]
        elif terms:
            item = item + side * terms[0][k]
            item = item - terms[1][k] if len(terms) > 1 else item
        result.append(item)
    return tuple(result)
