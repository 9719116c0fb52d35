"""Riemann problem of the reduced model: one velocity, a solid fraction that moves with it.

Exact: two waves of shallow-water type and between them a contact that carries phi, across which v and
the pressure g rho h^2/2 are continuous, rho = phi + gamma (1 - phi). Derived by this project; for uniform phi it is
the classical solution of Stoker (wet) and Ritter (dry). Accuracy: rounding.
"""

from collections.abc import Sequence
from typing import ClassVar, NamedTuple

import numpy as np
from attrs import frozen
from numpy.typing import ArrayLike
from scipy.optimize import brentq

from fvkit.validation import real
from fvkit_granular.exact.states import FloatArray, Wave, density_ratio, finite_tuple, similarity


class ReducedState(NamedTuple):
    """One state of the reduced model: depth h in m, solid fraction phi, velocity v in m/s."""

    h: float
    phi: float
    v: float


@frozen
class ReducedRiemann:
    """Self-similar solution of a Riemann problem of the reduced model.

    Call it with xi = x/t for a tuple (h, phi, v), or use ``at(x, t)`` for a dict.

    Attributes
    ----------
    left, right : the two initial states.
    star_left, star_right : the states beside the contact; both dry where a vacuum opens or a side is dry.
    waves : the `Wave` records, from left to right: family 1 and 3 are ``"R"`` or ``"S"``, family 2 is the
        contact ``"C"``. A dry side has no wave of its own; a vacuum has no contact.
    kind : ``"exact"``.

    Notes
    -----
    On dry ground h = 0 and v = 0 are returned, and phi of the nearer side.
    """

    kind: ClassVar[str] = "exact"
    left: ReducedState
    right: ReducedState
    star_left: ReducedState
    star_right: ReducedState
    waves: tuple[Wave, ...]
    g: float
    gamma: float

    def __call__(self, xi: ArrayLike) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Return h, phi, v at xi = x/t, m/s, each of the shape of ``xi``."""
        speeds = np.asarray(xi, dtype=float)
        is_left = speeds < self._divide()
        h, phi, v = (np.where(is_left, a, b) for a, b in zip(self.star_left, self.star_right, strict=True))
        for state, family, sign in ((self.left, 1, -1.0), (self.right, 3, 1.0)):
            wave = next((wave for wave in self.waves if wave.family == family), None)
            if wave is None:
                continue
            inside = (speeds >= wave.head) & (speeds <= wave.tail) & (wave.kind == "R")
            invariant = state.v - sign * 2.0 * np.sqrt(self.g * state.h)
            c = np.where(inside, sign * (speeds - invariant) / 3.0, 0.0)
            h, v = np.where(inside, c * c / self.g, h), np.where(inside, invariant + 2.0 * sign * c, v)
            outside = speeds < wave.head if family == 1 else speeds > wave.tail
            h, v = np.where(outside, state.h, h), np.where(outside, state.v, v)
        return h, phi, np.where(h > 0.0, v, 0.0)

    def at(self, x: ArrayLike, t: float, x0: float = 0.0) -> dict[str, FloatArray]:
        """Return ``h``, ``phi``, ``v`` at the points ``x`` (any shape) and the time ``t`` >= 0."""
        h, phi, v = self(similarity(x, t, x0))
        return {"h": h, "phi": phi, "v": v}

    def _divide(self) -> float:
        """Return the speed that parts what came from the left from what came from the right."""
        contact = [wave.head for wave in self.waves if wave.family == 2]
        fronts = [wave.tail for wave in self.waves if wave.family == 1]
        fronts += [wave.head for wave in self.waves if wave.family == 3]
        return (contact or [sum(fronts) / len(fronts) if fronts else 0.0])[0]


def reduced_riemann(left: Sequence[float], right: Sequence[float], g: float = 9.81, gamma: float = 0.5) -> ReducedRiemann:
    """Solve the Riemann problem of the reduced model on a flat bottom.

    With f(h) = 2 (sqrt(g h) - sqrt(g h_K)) for a fan, (h - h_K) sqrt(g (h + h_K)/(2 h h_K)) for a shock,
    the depth h1 left of the contact solves f_L(h1) + f_R(h2) + v_R - v_L = 0, h2 = h1 sqrt(rho_L/rho_R).

    Parameters
    ----------
    left, right : (h, phi, v), h >= 0 in m (0 is dry), phi in [0, 1], v in m/s.
    g, gamma : gravity, m/s^2, and density ratio in (0, 1).

    Returns
    -------
    ReducedRiemann, exact.

    Raises
    ------
    ValueError
        For values that are no states.
    """
    g, gamma = real(g, "g", above=0.0), density_ratio(gamma)
    first, last = _state(left, "left"), _state(right, "right")
    cl, cr = float(np.sqrt(g * first.h)), float(np.sqrt(g * last.h))
    if first.h == 0.0 or last.h == 0.0 or last.v - first.v >= 2.0 * (cl + cr):
        dry = [Wave(1, "R", first.v - cl, first.v + 2.0 * cl)] if first.h else []
        dry += [Wave(3, "R", last.v - 2.0 * cr, last.v + cr)] if last.h else []
        empty = first._replace(h=0.0, v=0.0), last._replace(h=0.0, v=0.0)
        return ReducedRiemann(first, last, *empty, tuple(dry), g, gamma)
    ratio = float(np.sqrt((first.phi + gamma * (1.0 - first.phi)) / (last.phi + gamma * (1.0 - last.phi))))

    def closing(c: float) -> float:
        h = c * c / g
        return _velocity_change(h, first.h, g) + _velocity_change(ratio * h, last.h, g) + last.v - first.v

    top = 2.0 * max(cl, cr)
    while closing(top) < 0.0:
        top *= 2.0
    h1 = brentq(closing, 0.0, top, xtol=1e-16 * top, rtol=1e-15) ** 2 / g
    h2 = ratio * h1
    fl, fr = _velocity_change(h1, first.h, g), _velocity_change(h2, last.h, g)
    v = 0.5 * (first.v - fl + last.v + fr)
    waves = (_wave(1, first, h1, v, g), Wave(2, "C", v, v), _wave(3, last, h2, v, g))
    return ReducedRiemann(first, last, first._replace(h=h1, v=v), last._replace(h=h2, v=v), waves, g, gamma)


def _velocity_change(h: float, outer: float, g: float) -> float:
    """Return the change of velocity across the wave from depth ``outer`` to ``h``."""
    if h <= outer:
        return 2.0 * (float(np.sqrt(g * h)) - float(np.sqrt(g * outer)))
    return (h - outer) * float(np.sqrt(0.5 * g * (h + outer) / (h * outer)))


def _wave(family: int, outer: ReducedState, h: float, v: float, g: float) -> Wave:
    """Return the wave of family 1 or 3 between an outer state and the state (h, v) inside."""
    sign = -1.0 if family == 1 else 1.0
    if h > outer.h:
        speed = outer.v + sign * float(np.sqrt(0.5 * g * h * (h + outer.h) / outer.h))
        return Wave(family, "S", speed, speed)
    edges = outer.v + sign * float(np.sqrt(g * outer.h)), v + sign * float(np.sqrt(g * h))
    return Wave(family, "R", min(edges), max(edges))


def _state(values: Sequence[float], where: str) -> ReducedState:
    h, phi, v = finite_tuple(values, "h phi v", where)
    if h < 0.0 or not 0.0 <= phi <= 1.0:
        raise ValueError(f"`{where}` needs a depth h >= 0 and a solid fraction phi in [0, 1], got h = {h}, phi = {phi}")
    return ReducedState(h, phi, v)
