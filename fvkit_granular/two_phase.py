"""The two-phase shallow granular flow model of Pelanti, Bouchut and Mangeney."""

from collections.abc import Mapping
from typing import Any, ClassVar

import attrs
import numpy as np

from fvkit import Model, RiemannSolver, maximum, minimum, where
from fvkit._validate import number, optional_number
from fvkit_granular.bed import LEAST_DRY, TINY, bed_step, mean_velocity, present, settled, upper, velocity
from fvkit_granular.layer import DRY_HINT, resolved
from fvkit_granular.relaxation import Relaxation, mass_and_momentum, sound_speeds
from fvkit_granular.spectrum import couplings, quartic_discriminant, shifted_roots
from fvkit_granular.states import bottom, broadcast, ratio

#: The inner pair counts as distinct above this share of g h; below it travels as one, at its mean speed.
DISTINCT = 1e-8

#: Rounding allowance of the discriminant, whose scale is 1, before a face counts as having lost hyperbolicity.
ROUNDING = 1e-12


@attrs.frozen
class TwoPhase(Model):
    """Solid and fluid in one shallow layer, q = (hs, hs vs, hf, hf vf), (3.5).

    hs_t + (hs vs)_x = 0,  hf_t + (hf vf)_x = 0,
    (hs vs)_t + (hs vs^2 + g/2 hs^2 + g (1-gamma)/2 hs hf)_x + gamma g hs hf_x = -g hs b_x,
    (hf vf)_t + (hf vf^2 + g/2 hf^2)_x + g hf hs_x = -g hf b_x.

    Parameters
    ----------
    g : gravity, m/s^2, positive.
    gamma : density ratio fluid/solid in (0, 1).
    dry : depth of a phase, m, below which its velocity is damped: thinner films do not move. None: 1e-8 of the largest
        initial depth, at least 1e-30 m; smaller values let ever thinner films set the time step.

    Notes
    -----
    Hyperbolic while |vs - vf| <= 2 a beta or >= 2 a, with a^2 = g h, beta^2 = (1-phi)(1-gamma)/2 (sufficient, 4.16).
    Elsewhere the inner speeds may be complex: the problem is then ill-posed. The Roe decomposition keeps the outer
    waves and lets the inner pair travel together at its mean speed; the faces are counted.

    Source: Pelanti, Bouchut, Mangeney, M2AN 42 (2008) 851-885. Roe averages: the velocity means of the paper with
    arithmetic depths, derived here to satisfy A^ dq = df + w^ exactly.
    """

    conserved: ClassVar[tuple[str, ...]] = ("hs", "hs vs", "hf", "hf vf")
    aux: ClassVar[tuple[str, ...]] = ("b",)
    phases: ClassVar[tuple[tuple[tuple[int, ...], int], ...]] = (((0,), 1), ((2,), 3))

    g: float = number(9.81, above=0.0)
    gamma: float = number(0.5, above=0.0, below=1.0, hint="density of the fluid over density of the solid")

    dry: float | None = optional_number(at_least=LEAST_DRY, hint=DRY_HINT)

    def layers(self, q):
        """Return hs, vs, hf, vf as a face sees them: too thin a phase is absent, and 0 is the velocity of an absent one."""
        hs, ms, hf, mf = q
        return present(hs, self.dry), velocity(hs, ms, self.dry), present(hf, self.dry), velocity(hf, mf, self.dry)

    def flux(self, q):
        hs, vs, hf, vf = self.layers(q)
        half = 0.5 * self.g
        return hs * vs, hs * vs * vs + half * hs * (hs + (1.0 - self.gamma) * hf), hf * vf, hf * vf * vf + half * hf * hf

    def wave_speeds(self, q):
        hs, vs, hf, vf = self.layers(q)
        a = np.sqrt(self.g) * np.sqrt(hs + hf)
        vs, vf = where(hs > 0.0, vs, vf), where(hf > 0.0, vf, vs)
        return minimum(vs, vf) - a, maximum(vs, vf) + a

    def jump(self, ql, qr, auxl, auxr):
        (hsl, vsl, hfl, vfl), (hsr, vsr, hfr, vfr) = self.layers(ql), self.layers(qr)
        hs, hf, dhs, dhf = 0.5 * (hsl + hsr), 0.5 * (hfl + hfr), hsr - hsl, hfr - hfl
        db, excess = bed_step(hsl + hfl, hsr + hfr, auxl[0], auxr[0])
        surface = dhs + dhf + (db - excess)
        solid = self.g * (hs * surface + upper(db, hsl, hsr) * excess + 0.5 * (1.0 - self.gamma) * (hf * dhs - hs * dhf))
        fluid = self.g * (hf * surface + upper(db, hfl, hfr) * excess)
        return (hsr * vsr - hsl * vsl, hsr * vsr * vsr - hsl * vsl * vsl + solid,
                hfr * vfr - hfl * vfl, hfr * vfr * vfr - hfl * vfl * vfl + fluid)

    def balanced_difference(self, ql, qr, auxl, auxr):
        (hsl, msl, hfl, mfl), (hsr, msr, hfr, mfr) = ql, qr
        solid, db = hsl + hsr, auxr[0] - auxl[0]
        lift = solid / (solid + hfl + hfr + TINY) * db
        return (hsr - hsl) + lift, msr - msl, (hfr - hfl) + (db - lift), mfr - mfl

    def depth(self, q):
        """Return the depth h = hs + hf, m."""
        return q[0] + q[2]

    def basal_load(self, q):
        """Return what presses on the bed, per mass, of each phase, m/s^2: solid g (1 - gamma), its buoyancy off; fluid 0."""
        return self.g * (1.0 - self.gamma), 0.0

    def relaxation(self, ql, qr, auxl, auxr, jump):
        (hsl, vsl, hfl, vfl), (hsr, vsr, hfr, vfr) = self.layers(ql), self.layers(qr)
        hl, hr = hsl + hfl, hsr + hfr
        db, excess = bed_step(hl, hr, auxl[0], auxr[0])
        al, ar = sound_speeds(hl, hr, db, excess, self.g)
        solid = jump[1] - (hsr * vsr * vsr - hsl * vsl * vsl)
        fluid = jump[3] - (hfr * vfr * vfr - hfl * vfl * vfl)
        (s1, s2, s3), s_speeds = mass_and_momentum(hsl, vsl, hsr, vsr, solid, al, ar, jump[:2])
        (f1, f2, f3), f_speeds = mass_and_momentum(hfl, vfl, hfr, vfr, fluid, al, ar, jump[2:])
        none = (0.0, 0.0)
        return (s1 + none, s2 + none, s3 + none, none + f1, none + f2, none + f3), s_speeds + f_speeds

    def settle(self, q):
        hs, ms, hf, mf = q
        return hs, settled(hs, ms, self.dry), hf, settled(hf, mf, self.dry)

    def decompose(self, ql, qr, auxl, auxr, jump):
        hs, vs, hf, vf = self.roe_mean(ql, qr)
        css, cff, csf = couplings(hs, hf, self.g, self.gamma)
        u1, u4, mu, disc = shifted_roots(hs, hf, vs, vf, self.g, self.gamma, 1)
        a2 = self.g * (hs + hf)
        distinct = disc > DISTINCT * a2
        half_gap = np.sqrt(where(distinct, disc, a2))
        middle, d = 0.5 * (vs + vf), 0.5 * (vs - vf)
        u3 = mu + half_gap
        l1, l4 = middle + u1, middle + u4
        l2, l3 = where(distinct, middle + (mu - half_gap), middle + mu), where(distinct, middle + u3, middle + mu)
        f1, f2, f3, f4 = jump
        x0, y0 = f2 - 2.0 * vs * f1, f4 - 2.0 * vf * f3
        e1, e4 = (u1 - u4) * ((u1 - mu) * (u1 - mu) - disc), (u4 - u1) * ((u4 - mu) * (u4 - mu) - disc)
        e3 = where(distinct, 2.0 * (u3 - u1) * (u3 - u4) * half_gap, a2)
        every = 1.0 / (e1 * e3 * e4)
        s1, t1 = project(every * (e3 * e4), u1, d, l1, f1, f3, x0, y0, css, cff, csf)
        s4, t4 = project(every * (e1 * e3), u4, d, l4, f1, f3, x0, y0, css, cff, csf)
        s3, t3 = project(every * (e1 * e4), u3, d, l3, f1, f3, x0, y0, css, cff, csf)
        rest = (f1 - s1 - s4, f2 - l1 * s1 - l4 * s4, f3 - t1 - t4, f4 - l1 * t1 - l4 * t4)
        z3 = (where(distinct, s3, 0.5 * rest[0]), where(distinct, l3 * s3, 0.5 * rest[1]),
              where(distinct, t3, 0.5 * rest[2]), where(distinct, l3 * t3, 0.5 * rest[3]))
        z2 = (rest[0] - z3[0], rest[1] - z3[1], rest[2] - z3[2], rest[3] - z3[3])
        return ((s1, l1 * s1, t1, l1 * t1), z2, z3, (s4, l4 * s4, t4, l4 * t4)), (l1, l2, l3, l4)

    def roe_mean(self, ql, qr):
        """Return hs, vs, hf, vf of the Roe mean: arithmetic depths, sqrt-weighted velocities."""
        (hsl, vsl, hfl, vfl), (hsr, vsr, hfr, vfr) = self.layers(ql), self.layers(qr)
        return (0.5 * (hsl + hsr), mean_velocity(hsl, vsl, hsr, vsr), 0.5 * (hfl + hfr), mean_velocity(hfl, vfl, hfr, vfr))

    def matrix_product(self, ql, qr, auxl, auxr, v):
        hs, vs, hf, vf = self.roe_mean(ql, qr)
        css, cff, csf = couplings(hs, hf, self.g, self.gamma)
        return (v[1], (css - vs * vs) * v[0] + 2.0 * vs * v[1] + csf * v[2],
                v[3], cff * v[0] + (cff - vf * vf) * v[2] + 2.0 * vf * v[3])

    def cross(self, ql, qr, auxl, auxr):
        (hsl, msl, hfl, mfl), (hsr, msr, hfr, mfr) = ql, qr
        dms, dmf, db = msr - msl, mfr - mfl, auxr[0] - auxl[0]
        exchange = dms * (hfr - hfl) - dmf * (hsr - hsl)
        zero = 0.0 * exchange
        return zero, self.g * (dms * db + self.gamma * exchange), zero, self.g * (dmf * db - exchange)

    def may_lose_hyperbolicity(self, ql, qr):
        hs, vs, hf, vf = self.roe_mean(ql, qr)
        slip = (vs - vf) * (vs - vf)
        return (slip > 2.0 * self.g * (1.0 - self.gamma) * hf) & (slip < 4.0 * self.g * (hs + hf))

    def hyperbolic_discriminant(self, ql, qr):
        hs, vs, hf, vf = self.roe_mean(ql, qr)
        both = (hs > 0.0) & (hf > 0.0)
        return where(both, quartic_discriminant(hs, hf, vs, vf, self.g, self.gamma), 0.0) + ROUNDING

    def resolved(self, q0: np.ndarray) -> "TwoPhase":
        return resolved(self, q0)

    def default_riemann(self) -> RiemannSolver:
        return Relaxation()

    def conserved_from(self, h: Any, phi: Any, vs: Any = 0.0, vf: Any = 0.0) -> np.ndarray:
        """Return q (4, ...) from depth h, m, solid fraction phi in [0, 1] and velocities vs, vf, m/s."""
        h, phi, vs, vf = broadcast(h, phi, vs, vf)
        hs, hf = phi * h, (1.0 - phi) * h
        return np.stack([hs, hs * vs, hf, hf * vf])

    def observables(self, q: np.ndarray, aux: Mapping[str, np.ndarray] | None = None) -> dict[str, np.ndarray]:
        """Return h, phi, vs, vf, the momentum mean v = (hs vs + gamma hf vf)/(hs + gamma hf), and the surface h + b."""
        hs, ms, hf, mf = q
        h = hs + hf
        return {"h": h, "phi": ratio(hs, h), "vs": ratio(ms, hs), "vf": ratio(mf, hf),
                "v": ratio(ms + self.gamma * mf, hs + self.gamma * hf), "surface": h + bottom(aux, h)}

    def matrix(self, q: np.ndarray) -> np.ndarray:
        """Return the quasi-linear matrix A(q) (4, 4, n) of q (4, n), (3.6); both phases present."""
        hs, vs, hf, vf = _primitive(q)
        css, cff, csf = couplings(hs, hf, self.g, self.gamma)
        zero, one = np.zeros_like(hs), np.ones_like(hs)
        return np.array([[zero, one, zero, zero], [css - vs * vs, 2.0 * vs, csf, zero],
                         [zero, zero, zero, one], [cff, zero, cff - vf * vf, 2.0 * vf]])

    def eigenvalues(self, q: np.ndarray) -> np.ndarray:
        """Return the characteristic speeds (4, n), complex, sorted by real part; both phases present."""
        hs, vs, hf, vf = _primitive(q)
        u1, u4, mu, disc = shifted_roots(hs, hf, vs, vf, self.g, self.gamma)
        gap = np.sqrt(disc.astype(complex))
        return 0.5 * (vs + vf) + np.array([u1 + 0j, mu - gap, mu + gap, u4 + 0j])

    def eigenvectors(self, q: np.ndarray) -> np.ndarray:
        """Return right eigenvectors (4, 4, n), complex, in columns: (1, l, xi, xi l) with xi g (1+gamma)/2 hs = (l-vs)^2 - css.

        Both phases present; (4.17).
        """
        hs, vs, hf, _ = _primitive(q)
        css, _, csf = couplings(hs, hf, self.g, self.gamma)
        speeds = self.eigenvalues(q)
        xi = ((speeds - vs) ** 2 - css) / csf
        return np.array([np.ones_like(speeds), speeds, xi, xi * speeds])

    def hyperbolicity_margin(self, q: np.ndarray) -> np.ndarray:
        """Return the discriminant of the inner pair over a^2 = g h, (n,): negative where the speeds are complex."""
        hs, vs, hf, vf = _primitive(q)
        _, _, _, disc = shifted_roots(hs, hf, vs, vf, self.g, self.gamma)
        return disc / (self.g * (hs + hf))


def project(weight, u, d, speed, f1, f3, x0, y0, css, cff, csf):
    """Return the depth components of the wave with shifted speed u: the left eigenvector's share of the jump.

    No division by hs or hf: fine where a phase vanishes.
    """
    x, y = speed * f1 + x0, speed * f3 + y0
    up, down = u + d, u - d
    return weight * ((up * up - cff) * x + csf * y), weight * (cff * x + (down * down - css) * y)


def _primitive(q: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    hs, ms, hf, mf = np.asarray(q, dtype=float)
    if not ((hs > 0.0).all() and (hf > 0.0).all()):
        raise ValueError("`q` must have both phases present (hs > 0 and hf > 0): the eigenvectors do not exist else")
    return hs, ms / hs, hf, mf / hf
