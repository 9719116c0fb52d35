"""Exact solutions with Coulomb friction: flow sliding down a plane slope, and a block that stops.

In a frame that accelerates uniformly the shallow-water equations keep their form. So on a plane slope b_x = -S with Coulomb
friction, as long as everything moves downhill (v > 0), every solution h(x, t), v(x, t) on a flat bottom gives one that
slides: h(x - a t^2/2, t) and v(x - a t^2/2, t) + a t, a the acceleration of a block. Derived here; the single-phase case
is that of Mangeney, Heinrich and Roche (Pure Appl. Geophys. 157, 2000, remembered). Accuracy: that of the solution inside.
"""

from typing import Any

import numpy as np
from attrs import frozen
from numpy.typing import ArrayLike

from fvkit.validation import array, real, shown
from fvkit_granular.exact.states import FloatArray


@frozen
class Accelerated:
    """A solution in a frame that starts with the velocity v0 and accelerates uniformly.

    Attributes
    ----------
    solution : the solution that slides: an object with ``kind`` and ``at(x, t)`` -> dict with h and v.
    acceleration : of the frame, m/s^2.
    v0 : its velocity at t = 0, m/s.
    """

    solution: Any
    acceleration: float
    v0: float = 0.0

    @property
    def kind(self) -> str:
        """The kind of the solution inside."""
        return str(self.solution.kind)

    def at(self, x: ArrayLike, t: float) -> dict[str, FloatArray]:
        """Return ``h``, ``v`` and what else the solution gives, at points ``x`` and time ``t`` >= 0; v = 0 on dry ground."""
        seen = self.solution.at(np.asarray(x, dtype=float) - (self.v0 + 0.5 * self.acceleration * t) * t, t)
        return {**seen, "v": np.where(seen["h"] > 0.0, seen["v"] + self.v0 + self.acceleration * t, 0.0)}


def accelerated(solution: Any, acceleration: float, v0: float = 0.0) -> Accelerated:
    """Return ``solution`` as it slides, with the acceleration of `sliding_acceleration`.

    Parameters
    ----------
    solution : a solution on a flat bottom with ``at(x, t)`` -> dict with h and v, of `shallow_water_riemann` or, with
        uniform phi, `reduced_riemann`.
    acceleration : m/s^2.
    v0 : velocity that is added at the start, m/s. With friction all must move downhill: v0 > 0, or S > nu.

    Raises
    ------
    ValueError, TypeError
        For a solution without ``at``, and for numbers that are none.
    """
    if not callable(getattr(solution, "at", None)):
        raise TypeError("`solution` must have a method at(x, t), such as exact.shallow_water_riemann(...), got "
                        f"{shown(solution)}")
    return Accelerated(solution, real(acceleration, "acceleration"), real(v0, "v0"))


def sliding_acceleration(slope: float, nu: float, g: float = 9.81, buoyancy: float = 0.0) -> float:
    """Return g (S - nu (1 - buoyancy)), m/s^2: the acceleration of a layer that moves down a plane slope.

    Parameters
    ----------
    slope : S = -b_x.
    nu : coefficient of friction, >= 0.
    g : gravity, m/s^2.
    buoyancy : share of the weight that the bed does not feel, in [0, 1]: 0 for shallow water, gamma/rho for the reduced model.
    """
    share = real(buoyancy, "buoyancy", at_least=0.0, at_most=1.0)
    return real(g, "g", above=0.0) * (real(slope, "slope") - real(nu, "nu", at_least=0.0) * (1.0 - share))


def block_stop(v0: float, nu: float, t: ArrayLike, g: float = 9.81) -> FloatArray:
    """Return the velocity sgn(v0) max(|v0| - nu g t, 0) of a block on a level bed, m/s: exactly 0 from |v0|/(nu g) on.

    Parameters
    ----------
    v0 : velocity at t = 0, m/s.
    nu : coefficient of friction, >= 0; times 1 - gamma/rho where grains are carried by fluid.
    t : times >= 0, s, of any shape.
    g : gravity, m/s^2.
    """
    start = real(v0, "v0")
    lost = real(nu, "nu", at_least=0.0) * real(g, "g", above=0.0) * array(t, "t")
    return np.asarray(np.sign(start) * np.maximum(abs(start) - lost, 0.0))
