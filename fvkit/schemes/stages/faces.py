"""What happens at a face, for every scheme: the Riemann problem, its fluctuations, entropy fix and fallback."""

from collections.abc import Mapping
from functools import partial

import numpy as np

from fvkit.pointwise import TINY, add, combine, maximum, scale, subtract, where
from fvkit.problem.answers import end_speeds, face_speeds, looks_between, wave_speeds
from fvkit.schemes.scheme import SPEED, Parts, Read, Stage, here
from fvkit.schemes.stages.dry_fallback import blend_with_relaxation, needs_fallback
from fvkit.schemes.stages.fluctuations import fluctuations, half_signs, riemann_problem

#: Share of a speed that the speed of a jump may be off by rounding.
ROUNDING = 1e-8

#: Corrections are gone where speeds between both sides leave those of both sides by one over this share of the largest.
COMPOSITE = 20.0

#: The fields with the fluctuations of a face to both sides.
BOTH = ("left_going", "right_going")


def face_stages(parts: Parts, face: Mapping[str, Read], fixes: bool, waves: bool = False) -> list[Stage]:
    """Return the stages from the Riemann problem of a face, which reads ``face``, to what travels left and right.

    ``fixes``: outer fields get the entropy fix; ``waves``: later stages need the waves, so that the fallback keeps them too.
    """
    model, riemann = parts.model, parts.riemann
    states = {name: face[name] for name in ("ql", "qr")}
    found = ("jump", "waves", "speeds", SPEED, *(("bearing",) if parts.joint else ()))
    problem = partial(riemann_problem, later=0.5) if waves and parts.joint else riemann_problem
    result = [Stage(problem, face, found),
              Stage(upwinding, here("speeds"), ("sides",), light=True),
              Stage(fluctuations, {**states, **here("jump", "waves", "sides")}, BOTH)]
    if fixes:
        result.append(Stage(entropy_viscosity, {**face, **here("speeds", *BOTH)}, BOTH, guard=transonic))
    if model.defines("relaxation") and not riemann.positive:
        first = (*BOTH, SPEED)
        every = (*first, "speeds", "waves") if waves else (*first, "speeds") if fixes else first
        result.append(Stage(blend_with_relaxation, {**face, **here(*every)}, every if waves else first,
                            guard=needs_fallback_or_fix if fixes else needs_fallback))
    return result


def upwinding(parts, ratio, speeds):
    """Return half the sign of every speed."""
    return {"sides": half_signs(speeds)}


def transonic(parts, ratio, ql, qr, auxl, auxr, speeds, **others):
    """Whether an outer field passes through zero speed in a rarefaction of this face."""
    lowl, highl = wave_speeds(parts.model, ql, auxl)
    lowr, highr = wave_speeds(parts.model, qr, auxr)
    found = maximum((lowr - lowl) - np.abs(speeds[0]), (highr - highl) - np.abs(speeds[-1])) > 0.0
    return found | (turning(parts.model, ql, qr, auxl, auxr) > np.abs(speeds[0])) if composite(parts.model) else found


def needs_fallback_or_fix(parts, ratio, ql, qr, auxl, auxr, left_going, speeds, **others):
    """Whether a face needs the fallback, perhaps after the entropy fix."""
    return needs_fallback(parts, ratio, ql, qr, auxl, auxr, left_going) | transonic(parts, ratio, ql, qr, auxl, auxr, speeds)


def entropy_viscosity(parts, ratio, ql, qr, auxl, auxr, speeds, left_going, right_going):
    """Add 1/2 (eta_k - |s_k|) p_k of the outer fields, p_k the parts of the balanced difference (Harten's eta)."""
    lowl, highl = wave_speeds(parts.model, ql, auxl)
    lowr, highr = wave_speeds(parts.model, qr, auxr)
    difference = parts.model.balanced_difference(ql, qr, auxl, auxr)
    pieces, _ = parts.model.decompose(ql, qr, auxl, auxr, difference)
    eta = harten(speeds[0], lowr - lowl)
    if composite(parts.model):
        eta = maximum(eta, turning(parts.model, ql, qr, auxl, auxr) - np.abs(speeds[0]))
    extra = scale(0.5 * eta, pieces[0])
    if len(speeds) > 1:
        extra = combine(1.0, extra, 0.5 * harten(speeds[-1], highr - highl), pieces[-1])
    right = tuple([0.0 if k in parts.model.mass_rows() else item for k, item in enumerate(add(right_going, extra))])
    return {"left_going": subtract(left_going, extra), "right_going": right}


def composite(model):
    """Whether one wave of the model may be fan and shock in one (composite wave): a scalar law that is not convex."""
    return len(model.conserved) == 1 and looks_between(model)


def convexity(model, ql, qr, auxl, auxr):
    """Return 1 where speeds between both sides of a face are within those of both sides, and less, down to 0, where they are not.

    There a correction may sharpen a composite wave, fan and shock in one, into a shock that breaks the entropy condition. Where
    the flow is smooth it is 1 - O(dx^2). Derived here.
    """
    excess, s1, s2 = excess_speeds(model, ql, qr, auxl, auxr)
    return maximum(1.0 - COMPOSITE * excess / (maximum(np.abs(s1), np.abs(s2)) + TINY), 0.0)


def turning(model, ql, qr, auxl, auxr):
    """Return the largest speed between both sides where speeds change their sign there and leave those of both sides, else 0."""
    excess, s1, s2 = excess_speeds(model, ql, qr, auxl, auxr)
    return where((excess > 0.0) & (s1 < 0.0) & (s2 > 0.0), maximum(-s1, s2), 0.0)


def excess_speeds(model, ql, qr, auxl, auxr):
    """Return by how much speeds between both sides leave those of both sides, 0 for rounding, and their bounds."""
    low, high = end_speeds(model, ql, qr, auxl, auxr)
    s1, s2 = face_speeds(model, ql, qr, auxl, auxr)
    slack = ROUNDING * maximum(np.abs(low), np.abs(high))
    return maximum(maximum(low - s1, s2 - high) - slack, 0.0), s1, s2


def harten(speed, width):
    """Return eta - |s|: (s^2/w + w)/2 - |s| where |s| is below the width w of the rarefaction, else 0."""
    size = np.abs(speed)
    fixed = size < width
    opening = where(fixed, width, 1.0)
    return where(fixed, 0.5 * (size * size / opening + opening) - size, 0.0)


def to_left(parts, ratio, left_going, **terms):
    """Return all that enters the cell left of a face, and the mass fluxes through it."""
    return {"to_left": corrected(parts, left_going, 1.0, **terms)}


def to_right(parts, ratio, right_going, **terms):
    """Return all that enters the cell right of a face; of masses, what leaves the other one."""
    return {"to_right": corrected(parts, right_going, -1.0, **terms)}


def corrected(parts, total, side, correction=None, cross=None, mass_flux=()):
    """Add the correction on one side, take the cross term from both, and put the mass fluxes in the rows of masses."""
    fluxes = dict(zip(parts.model.mass_rows(), mass_flux, strict=True))
    result = []
    for k, item in enumerate(total):
        if k in fluxes:
            item = side * fluxes[k]
        else:
            item = item if correction is None else item + side * correction[k]
            item = item if cross is None else item - cross[k]
        result.append(item)
    return tuple(result)
