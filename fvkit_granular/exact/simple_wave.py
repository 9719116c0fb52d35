"""Simple wave of the shallow-water equations that runs to the right into water at rest.

Exact until it breaks: with v = 2 (sqrt(g h) - sqrt(g H)) every depth travels with its own speed
c = v + sqrt(g h) = 3 sqrt(g h) - 2 sqrt(g H), so h(x, t) = h0(y), x = y + t c(y). Classical (method of
characteristics). For uniform phi and vs = vf it is exact for the two-phase model too.
"""

from collections.abc import Callable
from typing import ClassVar

import numpy as np
from attrs import frozen
from numpy.typing import ArrayLike
from scipy.optimize import minimize_scalar
from scipy.optimize.elementwise import find_root

from fvkit.validation import floats, function, real, shown
from fvkit.validation import interval as checked_interval
from fvkit_granular.exact.states import FloatArray

#: Samples of the profile that find its extreme speeds and where it steepens first.
SAMPLES = 2001


@frozen
class SimpleWave:
    """A simple wave with the depth ``h0(x)`` at time 0.

    Attributes
    ----------
    h0 : callable, x (n,) -> depth (n,), m.
    g : gravity, m/s^2.
    far_depth : depth H of the water at rest, m.
    breaking_time : first time at which the wave is vertical, s; infinite where it only spreads.
    slowest, fastest : bounds of the speeds c, m/s.
    kind : ``"exact"``.
    """

    kind: ClassVar[str] = "exact"
    h0: Callable[[FloatArray], FloatArray]
    g: float
    far_depth: float
    breaking_time: float
    slowest: float
    fastest: float

    def at(self, x: ArrayLike, t: float) -> dict[str, FloatArray]:
        """Return ``h``, ``v`` at the points ``x`` (any shape) and the time 0 <= ``t`` < breaking time."""
        t = real(t, "t", at_least=0.0)
        if t >= self.breaking_time:
            raise ValueError(f"`t` must be below the breaking time {self.breaking_time:.6g} s, got {t:.6g}: the wave is a shock "
                             "then, and the formula many-valued; compare with a fine grid instead")
        points = np.asarray(x, dtype=float)
        margin = 1e-3 * (self.fastest - self.slowest) + 1e-9 * (abs(self.slowest) + abs(self.fastest))
        bracket = points - t * (self.fastest + margin), points - t * (self.slowest - margin)
        feet = points
        if t > 0.0:
            found = find_root(lambda y, place: y + t * speed(self.h0(y), self.g, self.far_depth) - place,
                              bracket, args=(points,), tolerances={"xatol": 1e-14, "xrtol": 1e-15})
            if not np.all(found.success):
                worst = points[~found.success].ravel()[0]
                raise ValueError(f"no characteristic of the sampled profile reaches x = {worst:.6g} at t = {t:.6g}: h0 varies "
                                 "outside `interval`; widen it")
            feet = found.x
        h = np.asarray(self.h0(feet), dtype=float)
        return {"h": h, "v": 2.0 * (np.sqrt(self.g * h) - np.sqrt(self.g * self.far_depth))}


def speed(h: FloatArray, g: float, far_depth: float) -> FloatArray:
    """Return c = 3 sqrt(g h) - 2 sqrt(g H), m/s, with which the depth h travels."""
    return 3.0 * np.sqrt(g * h) - 2.0 * np.sqrt(g * far_depth)


def hump(
    amplitude: float = 0.1, width: float = 0.8, centre: float = 3.0, far_depth: float = 1.0
) -> Callable[[FloatArray], FloatArray]:
    """Return the profile h0(x) = H + amplitude exp(-((x - centre)/width)^2).

    Parameters
    ----------
    amplitude : height of the hump, m, above -H.
    width : of the hump, m, positive.
    centre : its place, m.
    far_depth : depth H far from it, m, positive.
    """
    amplitude, width, centre = real(amplitude, "amplitude"), real(width, "width", above=0.0), real(centre, "centre")
    far_depth = real(far_depth, "far_depth", above=0.0)
    if far_depth + amplitude <= 0.0:
        raise ValueError(f"`amplitude` must exceed -far_depth = {-far_depth:g} so that the layer stays wet, got {amplitude:g}")

    def h0(x: FloatArray) -> FloatArray:
        return far_depth + amplitude * np.exp(-(((x - centre) / width) ** 2))

    return h0


def simple_wave(h0: Callable[[FloatArray], FloatArray] | None = None, g: float = 9.81, far_depth: float = 1.0,
                interval: tuple[float, float] = (0.0, 10.0)) -> SimpleWave:
    """Return the simple wave that starts from the depth ``h0(x)``.

    Parameters
    ----------
    h0 : smooth callable, x (n,) -> depth (n,) > 0, m; default `hump()`: 0.1 high, 0.8 wide, at x = 3.
    g : gravity, m/s^2.
    far_depth : depth H of the water at rest that it runs into, m.
    interval : where h0 varies, m; the speeds and the breaking time -1/min c'(y) are found there, to about 1e-8.

    Returns
    -------
    SimpleWave, exact for 0 <= t < its ``breaking_time``.

    Raises
    ------
    ValueError
        For a profile that is dry or not finite, or an empty interval.
    """
    profile = hump(far_depth=far_depth) if h0 is None else function(h0, "h0", "x -> depth")
    g, far_depth = real(g, "g", above=0.0), real(far_depth, "far_depth", above=0.0)
    lower, upper = checked_interval(interval, "interval")
    y = np.linspace(lower, upper, SAMPLES)
    depth = floats(profile(y), "h0(x)")
    if depth.shape != y.shape or not np.all(np.isfinite(depth)) or not np.all(depth > 0.0):
        raise ValueError(f"`h0` must map x of shape {y.shape} to finite depths above 0 of that shape; got "
                         f"{shown(depth)}")
    c = speed(depth, g, far_depth)
    d = y[1] - y[0]

    def slope(place: float) -> float:
        around = speed(np.asarray(profile(place + 0.1 * d * np.array([-2.0, -1.0, 1.0, 2.0]))), g, far_depth)
        return float(around @ np.array([1.0, -8.0, 8.0, -1.0]) / (1.2 * d))

    steepest = y[np.argmin(np.gradient(c, d))]
    around_it = steepest - 2.0 * d, steepest + 2.0 * d
    best = minimize_scalar(slope, bounds=around_it, method="bounded", options={"xatol": 1e-9})
    breaking = -1.0 / best.fun if best.fun < -1e-9 * float(np.max(c)) / (upper - lower) else float("inf")
    return SimpleWave(profile, g, far_depth, breaking, float(c.min()), float(c.max()))
