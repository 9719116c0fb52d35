"""`Relaxation`: Riemann solver for vacuum, dry beds and absent phases, with the waves of one phase."""

from typing import ClassVar

import attrs
import numpy as np

from fvkit import RiemannSolver, maximum, minimum, where
from fvkit_granular.models.wet_dry import TINY, carried_over, wall_share

#: The stationary velocity jump at a bottom step is kept if both states beside the contact keep this distance to the outer waves,
#: relative to the relaxation speeds.
CLOSE = 0.2

#: Least distance of the contact from the outer waves, relative to the relaxation speeds: less is rounding.
LEAST = 1e-12


@attrs.frozen
class Relaxation(RiemannSolver):
    """Relaxation solver for each phase, driven by the total path-conservative jump: three waves per phase.

    Masses of each phase stay non-negative for any data and any slip, and a lake at rest with islands is preserved. Neither
    eigenvectors nor an entropy fix is needed, so complex speeds cause no problem. Slightly more diffusive on inner waves than
    Roe. `phase_waves` has the formulas.

    Source: derived here, for fluctuations of a nonconservative system; relaxation speeds in the spirit of
    F. Bouchut, Nonlinear Stability of Finite Volume Methods, 2004 (remembered).

    Examples
    --------
    >>> import fvkit as fv
    >>> import fvkit_granular as gr
    >>> problem = gr.scene("dry-dam-break").problem(gr.TwoPhase, 50)
    >>> solution = fv.solve(problem, fv.WavePropagation(gr.Relaxation()), backend="numpy")
    >>> bool(solution.q[-1][[0, 2]].min() >= 0.0)
    True
    """

    needs: ClassVar[tuple[str, ...]] = ("relaxation",)
    positive: ClassVar[bool] = True

    def solve(self, model, ql, qr, auxl, auxr, jump):
        return model.relaxation(ql, qr, auxl, auxr, jump)


def sound_speeds(hl, hr, step, g):
    """Return the relaxation sound speeds sqrt(g (h + u)) of both sides with the total depths hl and hr, m, u = |e| h_up/(hl +
    hr) the load of an emerged `fvkit_granular.models.wet_dry.BottomStep`.
    """
    pushed = np.abs(step.excess) * where(step.db > 0.0, hr, hl) / (hl + hr + TINY)
    return np.sqrt(g * (hl + pushed)), np.sqrt(g * (hr + pushed))


def phase_waves(hl, vl, hr, vr, push, taken, al, ar, step, g):
    """Return the wave speeds of a phase, s1, v*, s3, its states beside the contact, (h*, v*) of both sides, and cl, cr.

    P is the push, the part of the momentum jump that is not d(h v^2); d the stationary velocity jump at a bottom step
    (`fvkit_granular.models.wet_dry.carried_over`, which depends on the part of P ``taken`` by sources), F the mean discharge,
    x = max(vl - vr + max(d, 0), 0), and of the sound speeds the one that P pushes away from is at least w = sqrt(|P|/(hl + hr))::

        Al = al + 1.5 x + min(sqrt(P+/hl), P+/(hr ar)),   Ar = ar + 1.5 x + min(sqrt(P-/hr), P-/(hl al)),
        cl = hl Al,  cr = hr Ar,  vl* = (cl vl + cr (vr - d) - P - F d)/(cl + cr),  vr* = vl* + d,
        s1 = vl - Al,  s3 = vr + Ar,  hl* = cl/(vl* - s1),  hr* = cr/(s3 - vr*).

    The extra terms keep v* between s1 and s3 for any data, so both depths are positive; with w they are at most 2 w. Without it
    a trace of one phase beside deep flow of the other would be faster the thinner it is. Towards a wall v* is reduced by the
    wall fraction, and the rest of the jump is assigned to the lower side; d is 0 where v* would be near s1 or s3. Denominators
    are bounded away from 0; a phase absent on both sides has zero waves and speeds.
    """
    stands = carried_over(step, hl, vl, hr, vr, taken, al, ar, g)
    wall, towards = wall_share(step, vl, vr, g)
    compression = 1.5 * maximum(vl - vr + maximum(stands, 0.0), 0.0)
    forward, size = push > 0.0, np.abs(push)
    least = np.sqrt(size / (hl + hr + TINY))
    al, ar = where(forward, al, maximum(al, least)), where(forward, maximum(ar, least), ar)
    from_depth, into = where(forward, hl, hr) + TINY, where(forward, hr * ar, hl * al) + TINY
    extra = minimum(np.sqrt(size / from_depth), size / into)
    speedl, speedr = al + compression + where(forward, extra, 0.0), ar + compression + where(forward, 0.0, extra)
    cl, cr = hl * speedl, hr * speedr
    s1, s3 = vl - speedl, vr + speedr
    inverse = 1.0 / (cl + cr + TINY)
    star, moved = (cl * vl + cr * vr - push) * inverse, (cr + 0.5 * (hl * vl + hr * vr)) * stands * inverse
    between = (star - moved > s1 + CLOSE * speedl) & (star - moved + stands < s3 - CLOSE * speedr)
    opened = where(towards, 1.0 - wall, 1.0)
    starl = minimum(maximum(opened * where(between, star - moved, star), s1), s3)
    starr = minimum(maximum(opened * where(between, star - moved + stands, star), s1), s3)
    contact = where(starl * starr > 0.0, starl, 0.5 * (starl + starr))
    contact = where(opened < 0.5, minimum(maximum(-TINY * np.sign(step.db), s1), s3), contact)
    inside = hl + hr > 0.0
    return ((where(inside, s1, 0.0), where(inside, contact, 0.0), where(inside, s3, 0.0)),
            ((cl / beyond_rounding(starl - vl, speedl), starl), (cr / beyond_rounding(vr - starr, speedr), starr)), (cl, cr))


def beyond_rounding(change, speed):
    """Return v* - s1 of the ``change`` v* - vl and ``speed`` = vl - s1: in a film 1e16 times as fast as its waves both velocities
    are one number, and their difference is 0."""
    return maximum(speed + change, LEAST * speed) + TINY


def mass_and_momentum(hl, vl, hr, vr, al, ar, step, g, whole, jump):
    """Return the three waves of a phase, (mass, momentum) each, their speeds and the velocities beside the contact.

    Z1 = (hl* vl* - hl vl, hl* vl*^2 - hl vl^2 + cl (vl - vl*)),  Z3 = (hr vr - hr* vr*, hr vr^2 - hr* vr*^2 + cr (vr - vr*)),
    and Z2 = jump - Z1 - Z3, with speeds s1, v*, s3 of `phase_waves`. ``whole`` is the momentum jump before the part balanced by
    sources was subtracted.
    """
    push = jump[1] - (hr * vr * vr - hl * vl * vl)
    speeds, ((depthl, starl), (depthr, starr)), (cl, cr) = phase_waves(hl, vl, hr, vr, push, whole - jump[1], al, ar, step, g)
    massl, massr = depthl * starl, depthr * starr
    first = massl - hl * vl, massl * starl - hl * vl * vl + cl * (vl - starl)
    third = hr * vr - massr, hr * vr * vr - massr * starr + cr * (vr - starr)
    return (first, (jump[0] - first[0] - third[0], jump[1] - first[1] - third[1]), third), speeds, (starl, starr)


def before_sources(model, ql, qr, auxl, auxr, jump):
    """Return the jump of a face before sources took their part of it: schemes hand it over with ``jump``, else it is computed."""
    whole = getattr(jump, "whole", None)
    return model.jump(ql, qr, auxl, auxr) if whole is None else whole
