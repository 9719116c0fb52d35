"""Shallow water equations, the baseline model."""

from collections.abc import Mapping
from typing import Any, ClassVar

import attrs
import numpy as np

from fvkit import Phase, maximum, where
from fvkit.pointwise.polynomial import product_slope, total
from fvkit.validation import number, optional_number
from fvkit_granular.models.beyond_the_end import deepened, deepening
from fvkit_granular.models.quantities import bottom, broadcast, ratio
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
    upper,
    velocity,
    wall_push,
)


@attrs.frozen
class ShallowWater(ShallowFlow):
    """Shallow water equations, q = (h, h v).

    ::

        h_t + (h v)_x = 0,  (h v)_t + (h v^2 + g/2 h^2)_x = -g h b_x.

    Parameters
    ----------
    g : gravity, m/s^2, positive.
    dry : depth, m, below which the velocity is damped; None: 1e-8 of the largest initial depth, at least 1e-30 m; 1e-9 m where
        all is dry.

    Notes
    -----
    A two-phase state is converted with v = phi vs + (1 - phi) vf, which conserves the volume flux; phi is dropped. For
    constant phi and vs = vf the solution is that of the two-phase model.

    Examples
    --------
    >>> import fvkit_granular as gr
    >>> model = gr.ShallowWater()
    >>> q = model.conserved_from(h=1.0, phi=0.6, vs=2.0, vf=2.0)
    >>> [round(float(speed), 6) for speed in model.wave_speeds(tuple(q))]
    [-1.132092, 5.132092]
    """

    conserved: ClassVar[tuple[str, ...]] = ("h", "h v")
    phases: ClassVar[tuple[Phase, ...]] = (Phase((0,), 1),)

    g: float = number(9.81, above=0.0)
    dry: float | None = optional_number(at_least=LEAST_DRY, hint=DRY_HINT)

    def layer(self, q):
        """Return h, v for fluxes at faces: 0 depth for immobile films, damped velocity below ``dry``."""
        h, m = q
        return present(h, self.dry), velocity(h, m, self.dry)

    def flux(self, q):
        h, v = self.layer(q)
        return h * v, h * v * v + 0.5 * self.g * h * h

    def wave_speeds(self, q):
        h, v = self.layer(q)
        v, a = where(h > 0.0, v, 0.0), np.sqrt(self.g) * np.sqrt(h)
        return v - a, v + a

    def jump(self, ql, qr, auxl, auxr):
        (hl, vl), (hr, vr) = self.layer(ql), self.layer(qr)
        step = face_step(hl, hr, auxl[0], auxr[0])
        surface = (hr - hl) + (step.db - step.excess)
        push = self.g * (0.5 * (hl + hr) * surface + upper(step.db, hl, hr) * step.excess)
        al, ar = sound_speeds(hl, hr, step, self.g)
        push = push + kinetic_head(step, hl, vl, hr, vr, push) + wall_push(step, hl, vl, hr, vr, hl, hr, al, ar, self.g)
        return hr * vr - hl * vl, hr * vr * vr - hl * vl * vl + push

    def balanced_difference(self, ql, qr, auxl, auxr):
        return (qr[0] - ql[0]) + (auxr[0] - auxl[0]), qr[1] - ql[1]

    def decompose(self, ql, qr, auxl, auxr, jump):
        first, second = jump
        (hl, vl), (hr, vr) = self.layer(ql), self.layer(qr)
        rootl, rootr, a = np.sqrt(hl), np.sqrt(hr), np.sqrt(0.5 * self.g * (hl + hr))
        roots = rootl + rootr
        both = 1.0 / (roots * a)
        v = (rootl * vl + rootr * vr) * (a * both)
        s1, s2 = v - a, v + a
        left = (s2 * first - second) * (0.5 * roots * both)
        right = first - left
        return ((left, left * s1), (right, right * s2)), (s1, s2)

    def depth(self, q):
        """Return the depth h, m."""
        return q[0]

    def basal_load(self, q):
        """Return the basal load per mass of the one phase, m/s^2: g."""
        return (self.g,)

    def poured(self, q, solid, fluid):
        """Return h after adding depths of solid and fluid, m; a negative depth removes at most the existing water."""
        return (maximum(q[0] + (solid + fluid), 0.0),)

    def relaxation(self, ql, qr, auxl, auxr, jump):
        (hl, vl), (hr, vr) = self.layer(ql), self.layer(qr)
        step = face_step(hl, hr, auxl[0], auxr[0])
        al, ar = sound_speeds(hl, hr, step, self.g)
        whole = before_sources(self, ql, qr, auxl, auxr, jump)[1]
        waves, speeds, _ = mass_and_momentum(hl, vl, hr, vr, al, ar, step, self.g, whole, jump)
        return waves, speeds

    def beyond(self, q, slopes, distance):
        mass, momentum, _ = deepened(q[0], deepening(self, q, slopes[0], distance), self.dry)
        return mass * q[0], momentum * q[1]

    def settle(self, q):
        return q[0], settled(q[0], q[1], self.dry)

    def matrix_product(self, ql, qr, auxl, auxr, v):
        (hl, vl), (hr, vr) = self.layer(ql), self.layer(qr)
        mean = mean_velocity(hl, vl, hr, vr)
        return v[1], (0.5 * self.g * (hl + hr) - mean * mean) * v[0] + 2.0 * mean * v[1]

    def cross(self, ql, qr, auxl, auxr):
        push = self.g * (qr[1] - ql[1]) * covered_step(ql[0], qr[0], auxl[0], auxr[0])
        return 0.0 * push, push

    def lift(self, here, aux):
        return aux[0], 0.0

    def to_modes(self, here, w):
        h, v = self.layer(here)
        sound, moving = np.sqrt(self.g * h) * w[0], w[1] - v * w[0]
        return sound - moving, sound + moving

    def from_modes(self, here, amplitudes):
        h, v = self.layer(here)
        depth = 0.5 * (amplitudes[0] + amplitudes[1]) / (np.sqrt(self.g * h) + TINY)
        return depth, 0.5 * (amplitudes[1] - amplitudes[0]) + v * depth

    def cell_integral(self, ql, qr, q, aux):
        (hl, vl), (hr, vr) = self.layer(ql), self.layer(qr)
        return qr[1] - ql[1], hr * vr * vr - hl * vl * vl + self.g * product_slope(q[0], total(q[0], aux[0]))

    def conserved_from(self, h: Any, phi: Any = 1.0, vs: Any = 0.0, vf: Any = 0.0) -> np.ndarray:
        """Return q (2, ...) from depth, solid fraction and velocities; v = phi vs + (1 - phi) vf."""
        h, phi, vs, vf = broadcast(h, phi, vs, vf)
        return np.stack([h, h * (phi * vs + (1.0 - phi) * vf)])

    def thicknesses(self, seen: Mapping[str, np.ndarray]) -> dict[str, np.ndarray]:
        return {"water": seen["h"]}

    def observables(self, q: np.ndarray, aux: Mapping[str, np.ndarray] | None = None) -> dict[str, np.ndarray]:
        """Return h, v and the surface h + b."""
        h, m = q
        return {"h": h, "v": ratio(m, h), "surface": h + bottom(aux, h)}
