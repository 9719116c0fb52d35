"""Linear advection."""

from typing import ClassVar

import attrs

from fvkit._validate import within
from fvkit.model import Model


@attrs.frozen
class Advection(Model):
    """Linear advection u_t + speed u_x = 0.

    Parameters
    ----------
    speed : velocity, m/s, any sign.
    """

    conserved: ClassVar[tuple[str, ...]] = ("u",)

    speed: float = attrs.field(converter=within())  # type: ignore[misc]

    def flux(self, q):
        (u,) = q
        return (self.speed * u,)

    def wave_speeds(self, q):
        return self.speed, self.speed

    def decompose(self, ql, qr, auxl, auxr, jump):
        return (jump,), (self.speed,)
