"""Oscillations in parabolic basins, along a line and in the plane: exact solutions with moving shores.

Exact (Thacker 1981): the surface stays a plane that rocks with the frequency sqrt(2 g h0)/a over the
bottom b = h0 ((x - centre)^2/a^2 - 1). In a round basin a plane turns round, or a curved surface swings. For uniform phi
and vs = vf both are exact for the two-phase model too.
"""

from typing import Any, ClassVar

import numpy as np
from attrs import frozen
from numpy.typing import ArrayLike

from fvkit.validation import choice, field, number, real
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


@frozen
class ThackerBowl:
    """Oscillation in a round parabolic basin, of a rotating plane surface or of a paraboloid.

    ::

        b = h0 (r^2/a^2 - 1),
        "rotating": surface = eta h0/a^2 (2 x cos wt + 2 y sin wt - eta),  v = eta w (-sin wt, cos wt),  w = sqrt(2 g h0)/a,
        "paraboloid": surface = h0 (sqrt(1 - A^2)/C - 1 - r^2/a^2 ((1 - A^2)/C^2 - 1)),  C = 1 - A cos wt,
                      v = w A sin wt/(2 C) (x, y),  w = sqrt(8 g h0)/a,  A = (a^2 - r0^2)/(a^2 + r0^2).

    Parameters
    ----------
    motion : ``"rotating"`` or ``"paraboloid"``.
    a, h0 : radius and depth of the basin filled to b = 0, m.
    eta : of the plane: how far its wet disc is from the middle, m.
    r0 : of the paraboloid: its smallest radius, at t = 0, m, below ``a``.
    g : gravity, m/s^2.

    Notes
    -----
    Source: Thacker, J. Fluid Mech. 107 (1981) 499-508.
    """

    kind: ClassVar[str] = "exact"
    motion: str = field(choice, "rotating", known=("rotating", "paraboloid"))
    a: float = number(1.0, above=0.0)
    h0: float = number(0.1, above=0.0)
    eta: float = number(0.5)
    r0: float = number(0.8, above=0.0)
    g: float = number(9.81, above=0.0)

    def __attrs_post_init__(self) -> None:
        if not self.r0 < self.a:
            raise ValueError(f"`r0` must be < `a`, got {self.r0:g} and {self.a:g}")

    @property
    def omega(self) -> float:
        """Frequency of the oscillation, 1/s."""
        return float(np.sqrt((2.0 if self.motion == "rotating" else 8.0) * self.g * self.h0)) / self.a

    @property
    def period(self) -> float:
        """Period of the oscillation, s."""
        return 2.0 * float(np.pi) / self.omega

    def bottom(self, x: Any, y: Any) -> FloatArray:
        """Return the bottom b at the points x and y, m."""
        return np.asarray(self.h0 * ((np.square(x) + np.square(y)) / self.a**2 - 1.0))

    def at(self, x: Any, y: Any, t: float) -> dict[str, FloatArray]:
        """Return ``h``, ``v_x``, ``v_y`` at the points x and y, m, of one shape, and the time ``t``, s; 0 on dry ground."""
        x, y = np.asarray(x, dtype=float), np.asarray(y, dtype=float)
        c, s = np.cos(self.omega * real(t, "t")), np.sin(self.omega * t)
        if self.motion == "rotating":
            level = self.eta * self.h0 / self.a**2 * (2.0 * x * c + 2.0 * y * s - self.eta)
            v_x, v_y = -self.eta * self.omega * s, self.eta * self.omega * c
        else:
            ratio = (self.a**2 - self.r0**2) / (self.a**2 + self.r0**2)
            near = 1.0 - ratio * c
            level = self.h0 * (np.sqrt(1.0 - ratio**2) / near - 1.0
                               - (x * x + y * y) / self.a**2 * ((1.0 - ratio**2) / near**2 - 1.0))
            pace = 0.5 * self.omega * ratio * s / near
            v_x, v_y = pace * x, pace * y
        h = np.maximum(level - self.bottom(x, y), 0.0)
        return {"h": h, "v_x": np.where(h > 0.0, v_x, 0.0), "v_y": np.where(h > 0.0, v_y, 0.0)}
