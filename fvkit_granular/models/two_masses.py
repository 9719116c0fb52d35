"""`TwoMasses`: base class of models with two masses, each with its own velocity."""

from abc import ABC, abstractmethod
from collections.abc import Mapping
from typing import Any, ClassVar

import attrs
import numpy as np

from fvkit import Phase, maximum, minimum, where
from fvkit.validation import number, optional_number
from fvkit_granular.models.beyond_the_end import deepened, deepening
from fvkit_granular.models.quantities import bottom, broadcast, ratio, solid_and_fluid
from fvkit_granular.models.relaxation import before_sources, mass_and_momentum, sound_speeds
from fvkit_granular.models.shallow_flow import ShallowFlow
from fvkit_granular.models.wet_dry import (
    DRY_HINT,
    LEAST_DRY,
    TINY,
    covered_step,
    face_step,
    kinetic_head,
    mean_velocity,
    present,
    settled,
    velocity,
    wall_push,
)

#: Volume fraction below which a mass counts as absent in the Roe linearisation.
RARE = 1e-4


@attrs.frozen
class TwoMasses(ShallowFlow, ABC):
    """Abstract model of two masses with their velocities, q = (hs, hs vs, hf, hf vf), h = hs + hf. Contract:

    1. hs_t + (hs vs)_x = 0, hf_t + (hf vf)_x = 0, (hs vs)_t + (hs vs^2)_x + Ps = 0, (hf vf)_t + (hf vf^2)_x + Pf = 0.
    2. ``push(left, right, bl, br)`` returns Ps and Pf integrated over a face, bottom included: zero at rest.
    3. ``couplings(hs, hf)`` returns css, cff, csf and css cff - csf cff: the solid row of the quasi-linear matrix is
       (css - vs^2, 2 vs, csf, 0), which determines the eigenvectors.
    4. ``at_state(state, v)`` and ``cross`` are those of masses coupled by pressure alone; a subclass adds further terms.
    5. ``flux``, ``balanced_difference`` and ``eigenvalues`` are defined by the subclass.

    Examples
    --------
    Every model of two masses has its initial state, speeds and distance from complex speeds (`margin`) from here:

    >>> import fvkit_granular as gr
    >>> model = gr.TwoPhase()
    >>> q = model.conserved_from(h=[2.0], phi=[0.6], vs=[1.0], vf=[1.0])
    >>> q[:, 0]  # hs, hs vs, hf, hf vf
    array([1.2, 1.2, 0.8, 0.8])
    >>> model.eigenvalues(q)[:, 0].real.round(3)
    array([-3.429, -0.401,  2.401,  5.429])
    >>> model.margin(q)
    array([0.1])
    """

    conserved: ClassVar[tuple[str, ...]] = ("hs", "hs vs", "hf", "hf vf")
    phases: ClassVar[tuple[Phase, ...]] = (Phase((0,), 1), Phase((2,), 3))

    g: float = number(9.81, above=0.0)
    gamma: float = number(0.5, above=0.0, below=1.0,
                          hint="density of the fluid over that of the solid, or of the upper over the lower layer")

    dry: float | None = optional_number(at_least=LEAST_DRY, hint=DRY_HINT)

    @abstractmethod
    def push(self, left, right, bl, br):
        """Return the pressure, nonconservative and bottom terms of both momenta over a face with sides (hs, vs, hf, vf)."""

    @abstractmethod
    def couplings(self, hs, hf):
        """Return css, cff, csf and css cff - csf cff."""

    def at_state(self, state, v):
        """Return the product of v and the quasi-linear matrix at (hs, vs, hf, vf), (3.6): coupling by pressure alone."""
        hs, vs, hf, vf = state
        css, cff, csf, _ = self.couplings(hs, hf)
        return (v[1], (css - vs * vs) * v[0] + 2.0 * vs * v[1] + csf * v[2],
                v[3], cff * v[0] + (cff - vf * vf) * v[2] + 2.0 * vf * v[3])

    def cross(self, ql, qr, auxl, auxr):
        """Return the Lax-Wendroff term of gamma g hs hf_x, g hf hs_x and the bottom: with X = d(hs vs) dhf - d(hf vf) dhs,

        (0, g (d(hs vs) db + gamma X), 0, g (d(hf vf) db - X)).
        """
        (hsl, msl, hfl, mfl), (hsr, msr, hfr, mfr) = ql, qr
        dms, dmf, db = msr - msl, mfr - mfl, covered_step(hsl + hfl, hsr + hfr, auxl[0], auxr[0])
        exchange = dms * (hfr - hfl) - dmf * (hsr - hsl)
        zero = 0.0 * exchange
        return zero, self.g * (dms * db + self.gamma * exchange), zero, self.g * (dmf * db - exchange)

    def sound(self, left, right, bl, br):
        """Return the relaxation sound speeds of both sides of a face, relative to the velocities: sqrt(g h), larger at emerged
        steps of the bottom, m/s."""
        hl, hr = left[0] + left[2], right[0] + right[2]
        return sound_speeds(hl, hr, face_step(hl, hr, bl, br), self.g)

    def layers(self, q):
        """Return hs, vs, hf, vf for fluxes at faces: 0 depth for immobile films, 0 velocity for an absent phase."""
        hs, ms, hf, mf = q
        return present(hs, self.dry), velocity(hs, ms, self.dry), present(hf, self.dry), velocity(hf, mf, self.dry)

    def wave_speeds(self, q):
        hs, vs, hf, vf = self.layers(q)
        a = np.sqrt(self.g) * np.sqrt(hs + hf)
        vs, vf = moving(hs, vs, hf, vf)
        return minimum(vs, vf) - a, maximum(vs, vf) + a

    def jump(self, ql, qr, auxl, auxr):
        left, right = self.layers(ql), self.layers(qr)
        (hsl, vsl, hfl, vfl), (hsr, vsr, hfr, vfr) = left, right
        solid, fluid = self.push(left, right, auxl[0], auxr[0])
        hl, hr = hsl + hfl, hsr + hfr
        step, (al, ar) = face_step(hl, hr, auxl[0], auxr[0]), self.sound(left, right, auxl[0], auxr[0])
        wall = hl, hr, al, ar, self.g
        solid = solid + kinetic_head(step, hsl, vsl, hsr, vsr, solid) + wall_push(step, hsl, vsl, hsr, vsr, *wall)
        fluid = fluid + kinetic_head(step, hfl, vfl, hfr, vfr, fluid) + wall_push(step, hfl, vfl, hfr, vfr, *wall)
        return (hsr * vsr - hsl * vsl, hsr * vsr * vsr - hsl * vsl * vsl + solid,
                hfr * vfr - hfl * vfl, hfr * vfr * vfr - hfl * vfl * vfl + fluid)

    def relaxation(self, ql, qr, auxl, auxr, jump):
        (hsl, vsl, hfl, vfl), (hsr, vsr, hfr, vfr) = self.layers(ql), self.layers(qr)
        al, ar = self.sound((hsl, vsl, hfl, vfl), (hsr, vsr, hfr, vfr), auxl[0], auxr[0])
        step = face_step(hsl + hfl, hsr + hfr, auxl[0], auxr[0])
        _, solid, _, fluid = before_sources(self, ql, qr, auxl, auxr, jump)
        (s1, s2, s3), s_speeds, _ = mass_and_momentum(hsl, vsl, hsr, vsr, al, ar, step, self.g, solid, jump[:2])
        (f1, f2, f3), f_speeds, _ = mass_and_momentum(hfl, vfl, hfr, vfr, al, ar, step, self.g, fluid, jump[2:])
        none = (0.0, 0.0)
        return (s1 + none, s2 + none, s3 + none, none + f1, none + f2, none + f3), s_speeds + f_speeds

    def beyond(self, q, slopes, distance):
        mass, momentum, _ = deepened(self.depth(q), deepening(self, q, slopes[0], distance), self.dry)
        return mass * q[0], momentum * q[1], mass * q[2], momentum * q[3]

    def settle(self, q):
        hs, ms, hf, mf = q
        return hs, settled(hs, ms, self.dry), hf, settled(hf, mf, self.dry)

    def roe_mean(self, ql, qr):
        """Return hs, vs, hf, vf of the Roe mean: arithmetic depths, sqrt-weighted velocities."""
        (hsl, vsl, hfl, vfl), (hsr, vsr, hfr, vfr) = self.layers(ql), self.layers(qr)
        return (0.5 * (hsl + hsr), mean_velocity(hsl, vsl, hsr, vsr), 0.5 * (hfl + hfr), mean_velocity(hfl, vfl, hfr, vfr))

    def linearised(self, ql, qr):
        """Return the Roe mean hs, vs, hf, vf; an almost absent mass gets the velocity of the other mass."""
        hs, vs, hf, vf = self.roe_mean(ql, qr)
        return hs, where(hs > RARE * (hs + hf), vs, vf), hf, where(hf > RARE * (hs + hf), vf, vs)

    def matrix_product(self, ql, qr, auxl, auxr, v):
        return self.at_state(self.linearised(ql, qr), v)

    def to_modes(self, here, w):
        _, vs, _, vf = self.layers(here)
        (along, across), (xi, fast, slow) = self.pairs(here)
        solid, fluid = w[1] - vs * w[0], w[3] - vf * w[2]
        scale = 1.0 / (along * xi - across - TINY)
        outer, inner = (xi * w[0] - w[2]) * scale, (along * w[2] - across * w[0]) * scale
        moving_outer, moving_inner = (xi * solid - fluid) * scale, (along * fluid - across * solid) * scale
        return (fast * outer - moving_outer, slow * inner - moving_inner,
                slow * inner + moving_inner, fast * outer + moving_outer)

    def from_modes(self, here, amplitudes):
        _, vs, _, vf = self.layers(here)
        (along, across), (xi, fast, slow) = self.pairs(here)
        first, second, third, fourth = amplitudes
        outer, inner = 0.5 * (first + fourth) / (fast + TINY), 0.5 * (second + third) / (slow + TINY)
        moving_outer, moving_inner = 0.5 * (fourth - first), 0.5 * (third - second)
        hs, hf = along * outer + inner, across * outer + xi * inner
        return (hs, along * moving_outer + moving_inner + vs * hs,
                hf, across * moving_outer + xi * moving_inner + vf * hf)

    def pairs(self, here):
        """Return the equal-velocity modes: eigenvector (e1, e2) of the outer pair; e2/e1 of the inner pair and both speeds.

        The speeds u are square roots of the eigenvalues of C = ((css, csf), (cff, cff)). With the larger one, u1, the
        eigenvectors are (csf, u1^2 - css)/s and (1, -u1^2/s), s = csf + u1^2 - css > 0. Always real. Derived here.
        """
        hs, _, hf, _ = self.layers(here)
        css, cff, csf, det = self.couplings(hs, hf)
        gap = np.sqrt((css - cff) * (css - cff) + 4.0 * csf * cff)
        outer = 0.5 * (css + cff + gap)
        share = 1.0 / (csf + (outer - css) + TINY)
        return (csf * share, (outer - css) * share), (-outer * share, np.sqrt(outer), np.sqrt(det / (outer + TINY)))

    def depth(self, q):
        """Return the total depth h = hs + hf, m."""
        return q[0] + q[2]

    def basal_load(self, q):
        """Return the basal load per mass of each phase, m/s^2: g (1 - gamma), the buoyant weight, and 0 for the second."""
        return self.g * (1.0 - self.gamma), 0.0

    def poured(self, q, solid, fluid):
        """Return hs, hf after adding depths of the two masses, m; a negative depth removes at most the existing mass."""
        return maximum(q[0] + solid, 0.0), maximum(q[2] + fluid, 0.0)

    def hyperbolicity_margin(self, q: np.ndarray) -> np.ndarray:
        """Return `margin`, (n,), inf where a mass is absent, since a single mass is always hyperbolic."""
        both = (q[0] > 0.0) & (q[2] > 0.0)
        result = np.full(q.shape[1], np.inf)
        result[both] = self.margin(q[:, both])
        return result

    @abstractmethod
    def margin(self, q: np.ndarray) -> np.ndarray:
        """Return the hyperbolicity margin, (n,), of states with both masses present: negative where speeds are complex."""

    def conserved_from(self, h: Any, phi: Any, vs: Any = 0.0, vf: Any = 0.0) -> np.ndarray:
        """Return q (4, ...) from depth h, m, share phi of the first mass in [0, 1] and velocities vs, vf, m/s."""
        h, phi, vs, vf = broadcast(h, phi, vs, vf)
        hs, hf = phi * h, (1.0 - phi) * h
        return np.stack([hs, hs * vs, hf, hf * vf])

    def thicknesses(self, seen: Mapping[str, np.ndarray]) -> dict[str, np.ndarray]:
        return solid_and_fluid(seen)

    def observables(self, q: np.ndarray, aux: Mapping[str, np.ndarray] | None = None) -> dict[str, np.ndarray]:
        """Return h, phi, vs, vf, the momentum mean v = (hs vs + gamma hf vf)/(hs + gamma hf), and the surface h + b."""
        hs, ms, hf, mf = q
        h = hs + hf
        return {"h": h, "phi": ratio(hs, h), "vs": ratio(ms, hs), "vf": ratio(mf, hf),
                "v": ratio(ms + self.gamma * mf, hs + self.gamma * hf), "surface": h + bottom(aux, h)}

    def matrix(self, q: np.ndarray) -> np.ndarray:
        """Return the quasi-linear matrix A(q), (4, 4, n), of q (4, n); both masses must be present."""
        state = primitive(q)
        units = np.eye(4)[:, :, None] + np.zeros_like(state[0])
        return np.array([self.at_state(state, tuple(unit)) for unit in units]).swapaxes(0, 1)

    @abstractmethod
    def eigenvalues(self, q: np.ndarray) -> np.ndarray:
        """Return the characteristic speeds, (4, n), complex, sorted by real part; both masses must be present."""

    def eigenvectors(self, q: np.ndarray) -> np.ndarray:
        """Return right eigenvectors, (4, 4, n), complex, in columns: (1, l, xi, xi l) with xi csf = (l-vs)^2 - css, (4.17).

        Both masses must be present.
        """
        hs, vs, hf, _ = primitive(q)
        css, _, csf, _ = self.couplings(hs, hf)
        speeds = self.eigenvalues(q)
        xi = ((speeds - vs) ** 2 - css) / csf
        return np.array([np.ones_like(speeds), speeds, xi, xi * speeds])


def moving(hs, vs, hf, vf):
    """Return vs, vf; an absent phase gets the velocity of the other phase, 0 where both are absent."""
    return where(hs > 0.0, vs, where(hf > 0.0, vf, 0.0)), where(hf > 0.0, vf, where(hs > 0.0, vs, 0.0))


def advected(ql, qr):
    """Return the differences of the momentum fluxes h v^2 of both masses over a cell with face states (hs, vs, hf, vf)."""
    (hsl, vsl, hfl, vfl), (hsr, vsr, hfr, vfr) = ql, qr
    return hsr * vsr * vsr - hsl * vsl * vsl, hfr * vfr * vfr - hfl * vfl * vfl


def primitive(q: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """Return hs, vs, hf, vf of q (4, n); a ValueError if a mass is absent anywhere, since no eigenvectors exist there."""
    hs, ms, hf, mf = np.asarray(q, dtype=float)
    if not ((hs > 0.0).all() and (hf > 0.0).all()):
        raise ValueError("`q` must have both phases present (hs > 0 and hf > 0): the eigenvectors do not exist else")
    return hs, ms / hs, hf, mf / hf
