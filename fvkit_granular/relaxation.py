"""`Relaxation`: the Riemann solver for vacuum, dry beds and absent phases, and the waves of one phase."""

from typing import ClassVar

import attrs
import numpy as np

from fvkit import RiemannSolver, maximum, minimum, where
from fvkit_granular.bed import TINY


@attrs.frozen
class Relaxation(RiemannSolver):
    """A relaxation solver per phase, driven by the total path-conservative jump: three waves for each phase.

    Each phase keeps a non-negative mass for any data, at any slip, and rest is kept with islands; neither eigenvectors
    nor an entropy fix is needed, and complex speeds do not matter. A little more diffusive on inner waves than Roe. Its
    formulas are in `phase_waves`.

    Source: derived here, for fluctuations of a nonconservative system; relaxation speeds in the spirit of
    F. Bouchut, Nonlinear Stability of Finite Volume Methods, 2004 (remembered).
    """

    needs: ClassVar[tuple[str, ...]] = ("relaxation",)
    positive: ClassVar[bool] = True

    def solve(self, model, ql, qr, auxl, auxr, jump):
        return model.relaxation(ql, qr, auxl, auxr, jump)


def sound_speeds(hl, hr, db, excess, g):
    """Return sqrt(g (h + u)) of both sides, u = |e| h_up/(hl + hr): the depth that pushes through an emerged step.

    Parameters
    ----------
    hl, hr : total depths, m, >= 0.
    db, excess : see `fvkit_granular.bed.bed_step`.
    g : gravity, m/s^2.
    """
    pushed = np.abs(excess) * where(db > 0.0, hr, hl) / (hl + hr + TINY)
    return np.sqrt(g * (hl + pushed)), np.sqrt(g * (hr + pushed))


def phase_waves(hl, vl, hr, vr, push, al, ar, jump):
    """Return the middle state and the speeds of a phase: s1, v*, s3, and the depths beside the contact.

    With push P, the part of the momentum jump that is not d(h v^2), and x = max(vl - vr, 0),

        Al = al + 1.5 x + min(sqrt(P+/hl), P+/(hr ar)),   Ar = ar + 1.5 x + min(sqrt(P-/hr), P-/(hl al)),
        cl = hl Al,  cr = hr Ar,  v* = (cl vl + cr vr - P)/(cl + cr),  s1 = vl - Al,  s3 = vr + Ar,
        hl* = cl/(v* - s1),  hr* = cr/(s3 - v*).

    The extra terms keep v* between s1 and s3 for any data, so both depths stay positive. All denominators are kept
    from 0; a phase that is absent on both sides has no waves and no speeds.

    Returns
    -------
    (s1, v*, s3), (Al, Ar), (hl*, hr*), (cl, cr)
    """
    compression = 1.5 * maximum(vl - vr, 0.0)
    forward, size = push > 0.0, np.abs(push)
    from_depth, into = where(forward, hl, hr) + TINY, where(forward, hr * ar, hl * al) + TINY
    extra = minimum(np.sqrt(size / from_depth), size / into)
    speedl, speedr = al + compression + where(forward, extra, 0.0), ar + compression + where(forward, 0.0, extra)
    cl, cr = hl * speedl, hr * speedr
    s1, s3 = vl - speedl, vr + speedr
    star = minimum(maximum((cl * vl + cr * vr - push) / (cl + cr + TINY), s1), s3)
    inside = hl + hr > 0.0
    return ((where(inside, s1, 0.0), where(inside, star, 0.0), where(inside, s3, 0.0)), (speedl, speedr),
            (cl / (star - s1 + TINY), cr / (s3 - star + TINY)), (cl, cr))


def mass_and_momentum(hl, vl, hr, vr, push, al, ar, jump):
    """Return the three waves of a phase, (mass, momentum) each, and their speeds; they add up to its jump.

    Z1 = (hl* v* - hl vl, hl* v*^2 - hl vl^2 + cl (vl - v*)),  Z3 = (hr vr - hr* v*, hr vr^2 - hr* v*^2 + cr (vr - v*)),
    and Z2 is the rest, with speeds s1, s3 and v* of `phase_waves`.
    """
    speeds, _, (starl, starr), (cl, cr) = phase_waves(hl, vl, hr, vr, push, al, ar, jump)
    _, star, _ = speeds
    massl, massr = starl * star, starr * star
    first = massl - hl * vl, massl * star - hl * vl * vl + cl * (vl - star)
    third = hr * vr - massr, hr * vr * vr - massr * star + cr * (vr - star)
    return (first, (jump[0] - first[0] - third[0], jump[1] - first[1] - third[1]), third), speeds
