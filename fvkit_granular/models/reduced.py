"""The reduced equilibrium model: one velocity and an advected mixture density."""

from collections.abc import Mapping
from typing import Any, ClassVar

import attrs
import numpy as np

from fvkit import Phase, maximum, minimum, where
from fvkit.output.citation import Work
from fvkit.pointwise.polynomial import exchange, product_slope, total
from fvkit.validation import number, optional_number
from fvkit_granular.models.beyond_the_end import deepened, deepening
from fvkit_granular.models.literature import PELANTI_2008
from fvkit_granular.models.quantities import bottom, broadcast, ratio, solid_and_fluid
from fvkit_granular.models.relaxation import before_sources, mass_and_momentum, sound_speeds
from fvkit_granular.models.shallow_flow import ShallowFlow
from fvkit_granular.models.wet_dry import (
    DRY_HINT,
    IMMOBILE,
    LEAST_DRY,
    TINY,
    covered_step,
    face_step,
    kinetic_head,
    present,
    settled,
    share,
    threshold,
    upper,
    velocity,
    wall_push,
)


@attrs.frozen
class Reduced(ShallowFlow):
    """Reduced equilibrium model, the limit of strong drag: vs = vf = v, q = (h, rho h, rho h v), rho = phi + gamma (1 - phi).

    ::

        h_t + (h v)_x = 0,  (rho h)_t + (rho h v)_x = 0,
        (rho h v)_t + (rho h v^2 + g/2 rho h^2)_x = -g rho h b_x.

    Parameters
    ----------
    g : gravity, m/s^2, positive.
    gamma : density ratio fluid/solid in (0, 1).
    dry : depth rho h, m, below which the velocity is damped; None: 1e-8 of the largest initial depth, at least 1e-30 m; 1e-9 m
        where all is dry.

    Notes
    -----
    A two-phase state is converted with v = (phi vs + gamma (1 - phi) vf)/rho, which conserves the momentum. The Roe matrix
    has speeds v and v -/+ c with c^2 = g (h^ + kappa M^)/2 and M = rho h; kappa and v are sqrt(M)-weighted means of 1/rho and
    of the velocity, h^ and M^ arithmetic means. The Roe matrix satisfies A^ dq = df exactly (derived here).

    Source: Pelanti, Bouchut, Mangeney, M2AN 42 (2008) 851-885, (5.1).

    Examples
    --------
    >>> import fvkit_granular as gr
    >>> model = gr.Reduced(gamma=0.5)
    >>> model.conserved_from(h=1.0, phi=0.6, vs=1.0, vf=1.0).round(12).tolist()
    [1.0, 0.8, 0.8]
    """

    cite: ClassVar[tuple[Work, ...]] = (PELANTI_2008,)
    conserved: ClassVar[tuple[str, ...]] = ("h", "rho h", "rho h v")
    phases: ClassVar[tuple[Phase, ...]] = (Phase((0, 1), 2),)

    g: float = number(9.81, above=0.0)
    gamma: float = number(0.5, above=0.0, below=1.0, hint="density of the fluid over density of the solid")

    dry: float | None = optional_number(at_least=LEAST_DRY, hint=DRY_HINT)

    def layer(self, q):
        """Return h, M = rho h, v for fluxes at faces: 0 depth for immobile films, damped velocity below ``dry``."""
        h, mass, m = q
        return where(mass > IMMOBILE * threshold(self.dry), h, 0.0), present(mass, self.dry), velocity(mass, m, self.dry)

    def flux(self, q):
        h, mass, v = self.layer(q)
        return h * v, mass * v, mass * v * v + 0.5 * self.g * mass * h

    def wave_speeds(self, q):
        h, _, v = self.layer(q)
        v, a = where(h > 0.0, v, 0.0), np.sqrt(self.g) * np.sqrt(h)
        return v - a, v + a

    def jump(self, ql, qr, auxl, auxr):
        (hl, massl, vl), (hr, massr, vr) = self.layer(ql), self.layer(qr)
        dh, dmass = hr - hl, massr - massl
        step = face_step(hl, hr, auxl[0], auxr[0])
        push = self.g * (0.5 * (massl + massr) * (dh + (step.db - step.excess)) + upper(step.db, massl, massr) * step.excess
                         + 0.25 * ((hl + hr) * dmass - (massl + massr) * dh))
        al, ar = sound_speeds(hl, hr, step, self.g)
        push = push + (kinetic_head(step, massl, vl, massr, vr, push)
                       + wall_push(step, massl, vl, massr, vr, hl, hr, al, ar, self.g))
        return hr * vr - hl * vl, massr * vr - massl * vl, massr * vr * vr - massl * vl * vl + push

    def balanced_difference(self, ql, qr, auxl, auxr):
        volume, mass, _ = self.lift((ql[0] + qr[0], ql[1] + qr[1], 0.0), (auxr[0] - auxl[0],))
        return (qr[0] - ql[0]) + volume, (qr[1] - ql[1]) + mass, qr[2] - ql[2]

    def decompose(self, ql, qr, auxl, auxr, jump):
        h, mass, kappa, v = self.roe_mean(ql, qr)
        c = np.sqrt(0.5 * self.g * (h + kappa * mass))
        first, second, third = jump
        contact = (first - kappa * second) / (h + kappa * mass)
        both = second + mass * contact
        right = 0.5 * (both + (third - v * second) / c)
        left = both - right
        s1, s3 = v - c, v + c
        outer1, outer3 = (kappa * left, left, s1 * left), (kappa * right, right, s3 * right)
        middle = (first - outer1[0] - outer3[0], second - outer1[1] - outer3[1], third - outer1[2] - outer3[2])
        return (outer1, middle, outer3), (s1, v, s3)

    def roe_mean(self, ql, qr):
        """Return h^, M^ (arithmetic) and kappa, v (sqrt(M)-weighted means of h/M and of the velocity)."""
        (hl, massl, vl), (hr, massr, vr) = self.layer(ql), self.layer(qr)
        rootl, rootr = np.sqrt(massl), np.sqrt(massr)
        share = 1.0 / (rootl + rootr + TINY)
        kappa = (hl / (rootl + TINY) + hr / (rootr + TINY)) * share
        return 0.5 * (hl + hr), 0.5 * (massl + massr), kappa, (rootl * vl + rootr * vr) * share

    def matrix_product(self, ql, qr, auxl, auxr, v):
        h, mass, kappa, mean = self.roe_mean(ql, qr)
        drift = v[2] - mean * v[1]
        return (mean * v[0] + kappa * drift, v[2],
                0.5 * self.g * (mass * v[0] + h * v[1]) + mean * (drift + v[2]))

    def depth(self, q):
        """Return the depth h, m."""
        return q[0]

    def basal_load(self, q):
        """Return the basal load per mass of each phase, m/s^2: the buoyant weight of the grains, g (1 - gamma/rho)."""
        h, mass, _ = q
        return (self.g * share(maximum(mass - self.gamma * h, 0.0), mass),)

    def poured(self, q, solid, fluid):
        """Return h, rho h after adding depths of solid >= 0 and fluid, m; a negative depth removes at most the existing fluid."""
        h, mass, _ = q
        fluid = maximum(fluid, -maximum(h - mass, 0.0) / (1.0 - self.gamma))
        volume, heavy = maximum(h + (solid + fluid), 0.0), mass + (solid + self.gamma * fluid)
        # Round-off may leave the density outside the range between fluid and solid when all fluid is removed.
        return volume, where(fluid < 0.0, maximum(self.gamma * volume, minimum(heavy, volume)), heavy)

    def relaxation(self, ql, qr, auxl, auxr, jump):
        (hl, massl, vl), (hr, massr, vr) = self.layer(ql), self.layer(qr)
        step = face_step(hl, hr, auxl[0], auxr[0])
        al, ar = sound_speeds(hl, hr, step, self.g)
        whole = before_sources(self, ql, qr, auxl, auxr, jump)[2]
        waves, speeds, (starl, starr) = mass_and_momentum(massl, vl, massr, vr, al, ar, step, self.g, whole, jump[1:])
        (first, second, third), (s1, _, s3) = waves, speeds
        carried1 = hl * ((vl - s1) / (starl - s1 + TINY)) * starl - hl * vl
        carried3 = hr * vr - hr * ((s3 - vr) / (s3 - starr + TINY)) * starr
        return ((carried1, *first), (jump[0] - carried1 - carried3, *second), (carried3, *third)), speeds

    def beyond(self, q, slopes, distance):
        mass, momentum, _ = deepened(q[0], deepening(self, q, slopes[0], distance), self.dry)
        return mass * q[0], mass * q[1], momentum * q[2]

    def settle(self, q):
        return q[0], q[1], settled(q[1], q[2], self.dry)

    def cross(self, ql, qr, auxl, auxr):
        push = self.g * (qr[2] - ql[2]) * covered_step(ql[0], qr[0], auxl[0], auxr[0])
        return 0.0 * push, 0.0 * push, push

    def lift(self, here, aux):
        h, mass, _ = here
        return aux[0], share(mass, h) * aux[0], 0.0

    def to_modes(self, here, w):
        h, mass, v = self.layer(here)
        volume = share(h, mass)
        sound, moving = 0.5 * np.sqrt(self.g * h) * (w[1] + share(mass, h) * w[0]), w[2] - v * w[1]
        return sound - moving, w[0] - volume * w[1], sound + moving

    def from_modes(self, here, amplitudes):
        h, mass, v = self.layer(here)
        first, contact, third = amplitudes
        both = 0.5 * (first + third) / (np.sqrt(self.g * h) + TINY)
        density = both - 0.5 * share(mass, h) * contact
        return contact + share(h, mass) * density, density, 0.5 * (third - first) + v * density

    def cell_integral(self, ql, qr, q, aux):
        (_, massl, vl), (_, massr, vr) = self.layer(ql), self.layer(qr)
        h, mass, _ = q
        push = product_slope(mass, total(h, aux[0])) + 0.5 * exchange(h, mass)
        return (share(qr[2], qr[1]) * qr[0] - share(ql[2], ql[1]) * ql[0], qr[2] - ql[2],
                massr * vr * vr - massl * vl * vl + self.g * push)

    def conserved_from(self, h: Any, phi: Any, vs: Any = 0.0, vf: Any = 0.0) -> np.ndarray:
        """Return q (3, ...) from depth, solid fraction and velocities, keeping the momentum."""
        h, phi, vs, vf = broadcast(h, phi, vs, vf)
        solid, fluid = phi * h, self.gamma * (1.0 - phi) * h
        return np.stack([h, solid + fluid, solid * vs + fluid * vf])

    def thicknesses(self, seen: Mapping[str, np.ndarray]) -> dict[str, np.ndarray]:
        return solid_and_fluid(seen)

    def observables(self, q: np.ndarray, aux: Mapping[str, np.ndarray] | None = None) -> dict[str, np.ndarray]:
        """Return h, phi, v and the surface h + b."""
        h, mass, m = q
        phi = np.where(h > 0.0, (ratio(mass, h) - self.gamma) / (1.0 - self.gamma), 0.0)
        phi = np.where(h > (self.dry or 0.0), phi, np.clip(phi, 0.0, 1.0))  # the last bits of neighbours may be all of a film
        return {"h": h, "phi": phi, "v": ratio(m, mass), "surface": h + bottom(aux, h)}
