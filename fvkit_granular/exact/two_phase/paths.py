"""Paths in the (hs, hf) plane for nonconservative products across a shock, each reduced to one number, delta.

The nonconservative products of a shock need the integral of hs d(hf) along a path that joins its two
sides (that of hf d(hs) follows by parts). Relative to the straight segment the path adds

    delta = integral of hs d(hf) - (mean of hs) (jump of hf),

the signed area between path and chord. The Roe matrix belongs to the segment in (hs, hf): delta = 0.
Which path is right is a modelling choice that the model itself leaves open.
"""

import math
from collections.abc import Callable, Mapping
from types import MappingProxyType

from scipy.integrate import quad

PathArea = Callable[[float, float, float, float], float]


def _depths(hs0: float, hf0: float, hs1: float, hf1: float) -> float:
    """Segment in (hs, hf)."""
    return 0.0


def _h_phi(hs0: float, hf0: float, hs1: float, hf1: float) -> float:
    """Segment in (h, phi)."""
    h0, h1 = hs0 + hf0, hs1 + hf1
    return -(hs1 / h1 - hs0 / h0) * (h1 - h0) ** 2 / 6.0


def _sqrt(hs0: float, hf0: float, hs1: float, hf1: float) -> float:
    """Segment in (sqrt hs, sqrt hf)."""
    p0, p1, r0, r1 = math.sqrt(hs0), math.sqrt(hs1), math.sqrt(hf0), math.sqrt(hf1)
    dp, dr = p1 - p0, r1 - r0
    return dp * dr * ((p0 + p1) * dr - (r0 + r1) * dp) / 6.0


def _log(hs0: float, hf0: float, hs1: float, hf1: float) -> float:
    """Segment in (log hs, log hf)."""
    dp, dr = math.log(hs1 / hs0), math.log(hf1 / hf0)
    half = 0.5 * (dp + dr)
    sinhc = math.sinh(half) / half if half else 1.0
    return math.sqrt(hs0 * hs1 * hf0 * hf1) * (dr * sinhc - 2.0 * math.cosh(0.5 * dp) * math.sinh(0.5 * dr))


def _square(hs0: float, hf0: float, hs1: float, hf1: float) -> float:
    """Segment in (hs^2, hf^2)."""
    p0, p1, r0, r1 = hs0 * hs0, hs1 * hs1, hf0 * hf0, hf1 * hf1

    def rate(s: float) -> float:
        return 0.5 * (r1 - r0) * math.sqrt((p0 + s * (p1 - p0)) / (r0 + s * (r1 - r0)))

    return quad(rate, 0.0, 1.0, epsabs=1e-14, epsrel=1e-12)[0] - 0.5 * (hs0 + hs1) * (hf1 - hf0)


#: Names of the paths, each a segment in the coordinates that it names.
PATHS: Mapping[str, PathArea] = MappingProxyType(
    {"depths": _depths, "h-phi": _h_phi, "sqrt": _sqrt, "log": _log, "square": _square}
)
