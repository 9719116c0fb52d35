"""Vortices in the plane: of shallow water, standing or carried along, and of two phases with slip over a bottom.

A steady vortex turns each layer by its own push: v^2/r is the pressure gradient over the mass. Velocities fall like a Gaussian,
so that nothing but rest, or the drift, is left a few radii away.
"""

import math
from typing import Any, ClassVar

import attrs
import numpy as np

from fvkit import validation
from fvkit_granular.exact.states import FloatArray


def _pair(value: Any, name: str) -> tuple[float, float]:
    if not isinstance(value, (tuple, list)) or len(value) != 2:
        raise TypeError(f"`{name}` must be a pair (x, y), got {validation.shown(value)}")
    return validation.real(value[0], f"{name}[0]"), validation.real(value[1], f"{name}[1]")


@attrs.frozen
class Vortex:
    """Vortex of shallow water, steady or carried along: exact, also for two phases with uniform phi and one velocity.

    ::

        v = B (r/R) exp((1 - r^2/R^2)/2) around the centre,  h = depth - B^2/(2 g) exp(1 - r^2/R^2).

    Parameters
    ----------
    depth : far away, m.
    speed : largest speed B, at r = R, m/s.
    radius : R, m.
    centre : (x, y) at t = 0, m.
    drift : velocity (x, y) of all, m/s.
    period : lengths (x, y) of a periodic rectangle, m; None for the whole plane.
    g : gravity, m/s^2.
    """

    kind: ClassVar[str] = "exact"
    depth: float = validation.number(1.0, above=0.0)
    speed: float = validation.number(1.0, at_least=0.0)
    radius: float = validation.number(0.1, above=0.0)
    centre: Any = validation.field(_pair, (0.5, 0.5))
    drift: Any = validation.field(_pair, (0.0, 0.0))
    period: Any = validation.field(_pair, None, optional=True)
    g: float = validation.number(9.81, above=0.0)

    def __attrs_post_init__(self) -> None:
        if not self.depth > math.e * self.speed**2 / (2.0 * self.g):
            raise ValueError(f"`depth` must be > e B^2/(2 g) = {math.e * self.speed**2 / (2.0 * self.g):g} m, so that the middle "
                             f"is not dry, got {self.depth:g}")

    def at(self, x: Any, y: Any, t: float) -> dict[str, FloatArray]:
        """Return ``h``, ``v_x``, ``v_y`` at the points x and y, m, of one shape, and the time ``t``, s."""
        away = [np.asarray(place, dtype=float) - start - pace * t for place, start, pace in
                zip((x, y), self.centre, self.drift, strict=True)]
        if self.period is not None:
            away = [(place + 0.5 * length) % length - 0.5 * length for place, length in zip(away, self.period, strict=True)]
        east, north = away
        square_of = (east * east + north * north) / self.radius**2
        turning = self.speed * np.exp(0.5 * (1.0 - square_of)) / self.radius
        return {"h": self.depth - self.speed**2 * np.exp(1.0 - square_of) / (2.0 * self.g),
                "v_x": self.drift[0] - north * turning, "v_y": self.drift[1] + east * turning}


@attrs.frozen
class TwoPhaseVortex:
    """Steady vortex of two phases with slip over a bottom: exact for the two-phase model, without drag.

    ::

        hs = 0.6 - 0.1 exp(-r^2),  hf = 0.4 - 0.16 exp(-r^2/2.5),  b = 0.05 exp(-r^2/1.2),
        vf^2/r = g (hs' + hf' + b'),
        vs^2/r = g (hs' + b') + g/2 (1 - gamma) (hs hf)'/hs + gamma g hf'.

    Parameters
    ----------
    g : gravity, m/s^2.
    gamma : density ratio fluid/solid in (0, 1).

    Notes
    -----
    Any depths and bottom make such a vortex, as long as both right-hand sides are >= 0. Derived here.
    """

    kind: ClassVar[str] = "exact"
    g: float = validation.number(9.81, above=0.0)
    gamma: float = validation.number(0.5, above=0.0, below=1.0)

    def bottom(self, x: Any, y: Any) -> FloatArray:
        """Return the bottom b at the points x and y, m."""
        return np.asarray(0.05 * np.exp(-(np.square(x) + np.square(y)) / 1.2))

    def at(self, x: Any, y: Any, t: float = 0.0) -> dict[str, FloatArray]:
        """Return ``h``, ``phi``, ``vs_x``, ``vs_y``, ``vf_x``, ``vf_y`` at the points x and y, m, of one shape, at any time."""
        square_of, g = np.square(x) + np.square(y), self.g
        hs, hf = 0.6 - 0.1 * np.exp(-square_of), 0.4 - 0.16 * np.exp(-square_of / 2.5)
        # Derivatives over r, divided by r.
        solid, fluid = 0.2 * np.exp(-square_of), 0.128 * np.exp(-square_of / 2.5)
        bed = -2.0 / 1.2 * self.bottom(x, y)
        mixed = 0.5 * g * (1.0 - self.gamma) * (solid * hf / hs + fluid) + self.gamma * g * fluid
        turning = {"vs": np.sqrt(g * (solid + bed) + mixed), "vf": np.sqrt(g * (solid + fluid + bed))}
        return {"h": hs + hf, "phi": hs / (hs + hf)} | {
            f"{name}_{axis}": sign * rate * place for name, rate in turning.items()
            for axis, sign, place in (("x", -1.0, np.asarray(y)), ("y", 1.0, np.asarray(x)))}
