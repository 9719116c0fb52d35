"""The inviscid Burgers equation."""

from collections.abc import Mapping
from typing import ClassVar

import attrs

from fvkit.model import Model


@attrs.frozen
class Burgers(Model):
    """Inviscid Burgers equation u_t + (u^2/2)_x = 0."""

    conserved: ClassVar[tuple[str, ...]] = ("u",)
    quantities: ClassVar[Mapping[str, tuple[str, str]]] = {"u": ("m s-1", "velocity")}

    def flux(self, q):
        (u,) = q
        return (0.5 * u * u,)

    def wave_speeds(self, q):
        (u,) = q
        return u, u

    def decompose(self, ql, qr, auxl, auxr, jump):
        return (jump,), (0.5 * (ql[0] + qr[0]),)
