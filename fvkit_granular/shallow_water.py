"""The shallow-water baseline."""

from collections.abc import Mapping
from typing import Any, ClassVar

import attrs
import numpy as np

from fvkit import Model
from fvkit._validate import number
from fvkit_granular.states import bottom, broadcast, ratio


@attrs.frozen
class ShallowWater(Model):
    """Single-phase shallow water, q = (h, h v).

    h_t + (h v)_x = 0,  (h v)_t + (h v^2 + g/2 h^2)_x = -g h b_x.

    Parameters
    ----------
    g : gravity, m/s^2, positive.

    Notes
    -----
    As a model of a two-phase flow it takes v = phi vs + (1 - phi) vf, which keeps the volume flux, and forgets phi.
    On {phi constant, vs = vf} it is exact.
    """

    conserved: ClassVar[tuple[str, ...]] = ("h", "h v")
    aux: ClassVar[tuple[str, ...]] = ("b",)
    phases: ClassVar[tuple[tuple[tuple[int, ...], int], ...]] = (((0,), 1),)

    g: float = number(9.81, above=0.0)

    def flux(self, q):
        h, m = q
        return m, m * m / h + 0.5 * self.g * h * h

    def wave_speeds(self, q):
        h, m = q
        v, a = m / h, np.sqrt(self.g) * np.sqrt(h)
        return v - a, v + a

    def jump(self, ql, qr, auxl, auxr):
        (hl, ml), (hr, mr) = ql, qr
        surface = (hr - hl) + (auxr[0] - auxl[0])
        return mr - ml, mr * (mr / hr) - ml * (ml / hl) + 0.5 * self.g * (hl + hr) * surface

    def balanced_difference(self, ql, qr, auxl, auxr):
        return (qr[0] - ql[0]) + (auxr[0] - auxl[0]), qr[1] - ql[1]

    def decompose(self, ql, qr, auxl, auxr, jump):
        first, second = jump
        (hl, ml), (hr, mr) = ql, qr
        rootl, rootr, a = np.sqrt(hl), np.sqrt(hr), np.sqrt(0.5 * self.g * (hl + hr))
        roots = rootl + rootr
        both = 1.0 / (roots * a)
        v = (rootl * (ml / hl) + rootr * (mr / hr)) * (a * both)
        s1, s2 = v - a, v + a
        left = (s2 * first - second) * (0.5 * roots * both)
        right = first - left
        return ((left, left * s1), (right, right * s2)), (s1, s2)

    def matrix_product(self, ql, qr, auxl, auxr, v):
        velocity = roe_velocity(ql[0], ql[1], qr[0], qr[1])
        pressure = 0.5 * self.g * (ql[0] + qr[0])
        return v[1], (pressure - velocity * velocity) * v[0] + 2.0 * velocity * v[1]

    def cross(self, ql, qr, auxl, auxr):
        push = self.g * (qr[1] - ql[1]) * (auxr[0] - auxl[0])
        return 0.0 * push, push

    def conserved_from(self, h: Any, phi: Any = 1.0, vs: Any = 0.0, vf: Any = 0.0) -> np.ndarray:
        """Return q (2, ...) from depth, solid fraction and velocities; v = phi vs + (1 - phi) vf."""
        h, phi, vs, vf = broadcast(h, phi, vs, vf)
        return np.stack([h, h * (phi * vs + (1.0 - phi) * vf)])

    def observables(self, q: np.ndarray, aux: Mapping[str, np.ndarray] | None = None) -> dict[str, np.ndarray]:
        """Return h, v and the surface h + b."""
        h, m = q
        return {"h": h, "v": ratio(m, h), "surface": h + bottom(aux, h)}


def roe_velocity(hl, ml, hr, mr):
    """Return the Roe mean (sqrt(hl) vl + sqrt(hr) vr)/(sqrt(hl) + sqrt(hr)) of the velocities m/h."""
    rootl, rootr = np.sqrt(hl), np.sqrt(hr)
    return (rootl * (ml / hl) + rootr * (mr / hr)) / (rootl + rootr)
