"""Teaching models: linear advection, Burgers and linear acoustics."""

from collections.abc import Mapping
from typing import ClassVar

import attrs
import numpy as np

from fvkit.problem.model import Model
from fvkit.validation import field, number, per_axis, real


@attrs.frozen
class Advection(Model):
    """Linear advection u_t + speed u_x = 0; with two axes u_t + speed_x u_x + speed_y u_y = 0.

    Parameters
    ----------
    speed : velocity, m/s, any sign; with two axes a pair (x, y).

    Examples
    --------
    >>> import fvkit as fv
    >>> fv.Advection(2.0).flux((3.0,))
    (6.0,)
    """

    conserved: ClassVar[tuple[str, ...]] = ("u",)

    speed: float = field(per_axis, each=real, hint="a velocity in m/s")

    def along(self, axis: int) -> "Advection":
        if not isinstance(self.speed, tuple):
            raise ValueError(f"`speed` of Advection must be a pair (x, y) on a grid with two axes, got {self.speed:g}")
        return Advection(self.speed[axis])

    def flux(self, q):
        (u,) = q
        return (self.speed * u,)

    def wave_speeds(self, q):
        return self.speed, self.speed

    def decompose(self, ql, qr, auxl, auxr, jump):
        return (jump,), (self.speed,)


@attrs.frozen
class Burgers(Model):
    """Inviscid Burgers equation u_t + (u^2/2)_x = 0; with two axes u_t + (u^2/2)_x + (u^2/2)_y = 0.

    Examples
    --------
    >>> import fvkit as fv
    >>> fv.Burgers().flux((3.0,)), fv.Burgers().wave_speeds((3.0,))
    ((4.5,), (3.0, 3.0))
    """

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


@attrs.frozen
class Acoustics(Model):
    """Linear acoustics p_t + K u_x = 0, u_t + p_x/rho = 0; waves travel at -/+ sqrt(K/rho).

    With two axes the velocity has two components, q = (p, u_x, u_y).

    Parameters
    ----------
    rho : density, kg/m^3, positive.
    bulk : bulk modulus K, Pa, positive.

    Examples
    --------
    >>> import fvkit as fv
    >>> [float(speed) for speed in fv.Acoustics(rho=1.0, bulk=4.0).wave_speeds((0.0, 0.0))]
    [-2.0, 2.0]
    """

    conserved: ClassVar[tuple[str, ...]] = ("p", "u")
    vectors: ClassVar[tuple[tuple[int, ...], ...]] = ((1,),)
    quantities: ClassVar[Mapping[str, tuple[str, str]]] = {"p": ("Pa", "pressure"), "u": ("m s-1", "velocity")}

    rho: float = number(1.0, above=0.0)
    bulk: float = number(1.0, above=0.0)

    def flux(self, q):
        p, u = q
        return self.bulk * u, p / self.rho

    def wave_speeds(self, q):
        c = np.sqrt(self.bulk / self.rho)
        return -c, c

    def decompose(self, ql, qr, auxl, auxr, jump):
        impedance, c = np.sqrt(self.bulk * self.rho), np.sqrt(self.bulk / self.rho)
        first, second = jump
        left = 0.5 * (second - first / impedance)
        right = second - left
        return ((-impedance * left, left), (impedance * right, right)), (-c, c)
