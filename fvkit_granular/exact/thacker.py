"""Planar oscillation in a parabolic basin: an exact solution with a moving shore.

Exact (Thacker 1981): the surface stays a plane that rocks with the frequency sqrt(2 g h0)/a over the
bottom b = h0 ((x - centre)^2/a^2 - 1). For uniform phi and vs = vf it is exact for the two-phase model too.
"""

from typing import ClassVar

import numpy as np
from attrs import frozen
from numpy.typing import ArrayLike

from fvkit.validation import real
from fvkit_granular.exact.states import FloatArray


@frozen
class ThackerBasin:
    """The rocking plane in a parabolic basin.

    Attributes
    ----------
    a, h0 : half width and depth of the basin filled to b = 0, m.
    centre : x of its lowest point, m.
    amplitude : velocity amplitude B, m/s.
    g : gravity, m/s^2.
    omega, period : frequency sqrt(2 g h0)/a, 1/s, and period, s.
    kind : ``"exact"``.
    """

    kind: ClassVar[str] = "exact"
    a: float
    h0: float
    centre: float
    amplitude: float
    g: float

    @property
    def omega(self) -> float:
        """Frequency of the oscillation, 1/s."""
        return float(np.sqrt(2.0 * self.g * self.h0)) / self.a

    @property
    def period(self) -> float:
        """Period of the oscillation, s."""
        return 2.0 * float(np.pi) / self.omega

    def bottom(self, x: ArrayLike) -> FloatArray:
        """Return the bottom b at the points ``x``, m."""
        return self.h0 * (((np.asarray(x, dtype=float) - self.centre) / self.a) ** 2 - 1.0)

    def shores(self, t: float) -> tuple[float, float]:
        """Return the two ends of the wet region at the time ``t``, m."""
        middle = self.centre - self.amplitude / self.omega * float(np.cos(self.omega * t))
        return middle - self.a, middle + self.a

    def at(self, x: ArrayLike, t: float) -> dict[str, FloatArray]:
        """Return ``h``, ``v`` at the points ``x`` (any shape) and the time ``t``; 0 and 0 on dry ground."""
        points = np.asarray(x, dtype=float)
        left, right = self.shores(real(t, "t"))
        h = np.maximum(0.0, self.h0 * (points - left) * (right - points) / self.a**2)
        v = np.where(h > 0.0, self.amplitude * np.sin(self.omega * t), 0.0)
        return {"h": h, "v": v}


def thacker_basin(
    a: float = 1.0, h0: float = 0.5, centre: float = 2.0, amplitude: float | None = None, g: float = 9.81
) -> ThackerBasin:
    """Return the planar oscillation in a parabolic basin.

    Parameters
    ----------
    a, h0 : half width and depth of the basin, m, > 0.
    centre : x of its lowest point, m.
    amplitude : velocity amplitude, m/s; by default sqrt(2 g h0)/(2 a) times one metre, the value remembered for the
        common benchmark (not confirmed from its source).
    g : gravity, m/s^2.

    Raises
    ------
    ValueError
        For a basin without width or depth.
    """
    a, h0, g = real(a, "a", above=0.0), real(h0, "h0", above=0.0), real(g, "g", above=0.0)
    velocity = float(np.sqrt(2.0 * g * h0)) / (2.0 * a) if amplitude is None else real(amplitude, "amplitude")
    return ThackerBasin(a, h0, real(centre, "centre"), velocity, g)
