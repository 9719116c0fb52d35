"""Characteristic fields of the two-phase system along its wave curves.

A wave of field k is measured by its strength e, with de = d(hs) + c d(hf), c = +1 for the external
fields 1, 4 and c = -1 for the internal fields 2, 3. The right eigenvector is (1, l, r, r l) with
l the speed and r = d(hf)/d(hs), positive for external and negative for internal fields as long as
|vs - vf| < 2 sqrt(g h), so the share y = d(hs)/de = 1/(1 + c r) lies in (0, 1) and e never turns
back, as hs alone may do along a strong external shock.
"""

from typing import Any, NamedTuple

import numpy as np

from fvkit_granular.models.spectrum import couplings, shifted_roots


class Characteristic(NamedTuple):
    """Field k at a state: speed l, share y = d(hs)/de, slope dl/de = bend/P'(l), and the inner discriminant.

    The bend stays finite, and changes sign with genuine nonlinearity only, where two speeds merge.
    """

    speed: Any
    share: Any
    bend: Any
    p_prime: Any
    disc: Any

    @property
    def slope(self) -> Any:
        """Rate dl/de of the speed along the curve, 1/s."""
        return self.bend / self.p_prime


def orientation(family: int) -> float:
    """Return c = d(hf)/de + d(hs)/de in sign: +1 for the external fields, -1 for the internal ones."""
    return 1.0 if family in (1, 4) else -1.0


def shifted_speed(family: int, u1: Any, u4: Any, mu: Any, disc: Any) -> Any:
    """Return the root of field ``family`` of the quartic, relative to (vs + vf)/2."""
    if family in (1, 4):
        return u1 if family == 1 else u4
    inner = np.sqrt(np.maximum(disc, 0.0))
    return mu - inner if family == 2 else mu + inner


def characteristic(family: int, hs: Any, hf: Any, vs: Any, vf: Any, g: float, gamma: float) -> Characteristic:
    """Return speed, share, slope and discriminant of one field; scalars or arrays.

    The slope is y (grad l . r) with

        grad l . r = [2 T (l-vs)^2/hs + 2 r^2 F (l-vf)^2/hf + g (1+r)(T + r F)] / P'(l),
        T = (l-vf)^2 - g hf,  F = g (1+gamma)/2 hs,  P'(l) = 2 (l-vs) T + 2 (l-vf) r F.
    """
    coupled = couplings(hs, hf, g, gamma)
    u1, u4, mu, disc = shifted_roots(coupled, vs, vf, g * (hs + hf))
    css, cff, csf, _ = coupled
    d = 0.5 * (vs - vf)
    u = shifted_speed(family, u1, u4, mu, disc)
    from_s, from_f = u - d, u + d
    t = from_f * from_f - cff
    # two forms of the same ratio; each is free of cancellation for its own fields
    ratio = (from_s * from_s - css) / csf if family in (1, 4) else cff / t
    if family in (1, 4):
        t = cff / ratio
    f = ratio * csf
    p_prime = 2.0 * (from_s * t + from_f * f)
    gradient = 2.0 * t * from_s * from_s / hs + 2.0 * ratio * f * from_f * from_f / hf + g * (1.0 + ratio) * (t + f)
    share = 1.0 / (1.0 + orientation(family) * ratio)
    return Characteristic(0.5 * (vs + vf) + u, share, share * gradient, p_prime, disc)
