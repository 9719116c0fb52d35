"""Integral curves of the characteristic fields: the states inside a rarefaction fan.

Along the curve of field k, with strength e (see `fields`), share y and speed l,

    d(hs, hs vs, hf, hf vf)/de = (y, l y, z, l z),   z = c - c y,

integrated by an embedded Runge-Kutta method of order 8 at relative tolerance 1e-12.
"""

from typing import Any

import numpy as np
from attrs import field, frozen
from numpy.typing import ArrayLike
from scipy.integrate import solve_ivp

from fvkit_granular.exact.states import FloatArray, NoFourWaveSolution, TwoPhaseState
from fvkit_granular.exact.two_phase.fields import Characteristic, characteristic, orientation

#: Tolerances of the integration, the absolute one relative to the depth and to sqrt(g h) of the start.
RTOL, ATOL = 1e-12, 1e-14
#: Curves shorter than this times the depth are one straight step, exact to rounding.
TINY = 1e-9
#: A curve stops when a depth falls below this times the depth of the start.
EMPTY = 1e-7

_STOPS = ("inflection", "complex", "empty", "speed")


@frozen
class IntegralCurve:
    """A piece of the integral curve of one field, from ``start`` to ``end``.

    Attributes
    ----------
    family : 1, 2, 3 or 4.
    start, end : its two ends; ``end`` is ``start`` changed by ``strength``.
    strength : signed, m.
    head, tail : speeds of the field at ``start`` and ``end``, m/s.
    stopped : why it ended: ``"strength"`` or ``"speed"`` (what was asked for), ``"inflection"`` (the
        field stops being genuinely nonlinear), ``"complex"`` (hyperbolicity is lost), ``"empty"`` (a phase runs out).
    """

    family: int
    start: TwoPhaseState
    end: TwoPhaseState
    strength: float
    head: float
    tail: float
    stopped: str
    g: float
    gamma: float
    _dense: Any = field(repr=False, eq=False)

    def states_at(self, xi: ArrayLike) -> tuple[FloatArray, FloatArray, FloatArray, FloatArray]:
        """Return hs, hf, vs, vf, each of the shape of ``xi``, where the field moves with speed ``xi``.

        Speeds outside [head, tail] give the nearer end. Inverts l(e) = xi from a table, then by Newton.
        """
        wanted = np.atleast_1d(np.clip(np.asarray(xi, dtype=float), self.head, self.tail))
        if self._dense is None or wanted.size == 0:
            hs, hf, vs, vf = (np.full(wanted.shape, value) for value in self.start)
            return hs, hf, vs, vf
        length = abs(self.strength)
        nodes = length * 0.5 * (1.0 - np.cos(np.linspace(0.0, np.pi, 257)))
        s = np.interp(wanted, self._field(nodes).speed, nodes)
        for _ in range(4):
            here = self._field(s)
            slope = np.copysign(np.maximum(np.abs(here.slope), 1e-12 * abs(self.tail - self.head) / length), here.slope)
            s = np.clip(s - (here.speed - wanted) / (slope * np.sign(self.strength)), 0.0, length)
        hs, hf, vs, vf = self._dense(s)
        return hs, hf, vs, vf

    def _field(self, s: FloatArray) -> Characteristic:
        hs, hf, vs, vf = self._dense(s)
        return characteristic(self.family, hs, hf, vs, vf, self.g, self.gamma)


def integral_curve(start: TwoPhaseState, family: int, strength: float, g: float, gamma: float, *, stop_speed: float | None = None,
                   dense: bool = False) -> IntegralCurve:
    """Follow field ``family`` from ``start``, its speed growing, to ``strength``, ``stop_speed`` or a singular point.

    With ``dense`` the result can be evaluated between its ends (`IntegralCurve.states_at`).
    """
    begin = characteristic(family, *start, g, gamma)
    c, sign, depth = orientation(family), (1.0 if strength >= 0.0 else -1.0), start.h
    if abs(strength) < TINY * depth:
        end = _straight(start, begin, c, strength)
        tail = float(characteristic(family, *end, g, gamma).speed)
        return IntegralCurve(family, start, end, strength, float(begin.speed), tail, "strength", g, gamma, None)

    def at(q: FloatArray) -> tuple[float, float, float, float, Characteristic]:
        hs, hf, vs, vf = q.tolist()
        hs, hf = max(hs, EMPTY * depth), max(hf, EMPTY * depth)
        return hs, hf, vs, vf, characteristic(family, hs, hf, vs, vf, g, gamma)

    def rate(s: float, q: FloatArray) -> tuple[float, float, float, float]:
        hs, hf, vs, vf, here = at(q)
        y = sign * here.share
        z = c * (sign - y)
        return y, z, (here.speed - vs) * y / hs, (here.speed - vf) * z / hf

    def inflection(s: float, q: FloatArray) -> float:
        here = at(q)[-1]
        return sign * here.bend * (1.0 if here.p_prime > 0.0 else -1.0)

    def complex_pair(s: float, q: FloatArray) -> float:
        return at(q)[-1].disc - 1e-9 * g * depth

    def empty(s: float, q: FloatArray) -> float:
        return min(q[0], q[1]) - 2.0 * EMPTY * depth

    def speed(s: float, q: FloatArray) -> float:
        return at(q)[-1].speed - stop_speed

    events: list[Any] = [inflection, complex_pair, empty] + ([speed] if stop_speed is not None else [])
    for event in events:
        event.terminal = True
    events[0].direction = -1.0  # a start at the inflection may leave it upwards
    velocity = np.sqrt(g * depth)
    result = solve_ivp(rate, (0.0, abs(strength)), np.array(start), method="DOP853", events=events, dense_output=dense,
                       rtol=RTOL, atol=ATOL * np.array([depth, depth, velocity, velocity]),
                       first_step=min(abs(strength), 0.05 * depth))
    if not result.success:
        raise NoFourWaveSolution(f"the integral curve of field {family} cannot be followed: {result.message}")
    stopped = "strength"
    for name, times in zip(_STOPS, result.t_events, strict=False):
        stopped = name if len(times) else stopped
    end = TwoPhaseState(*result.y[:, -1].tolist())
    tail = float(characteristic(family, *end, g, gamma).speed)
    return IntegralCurve(family, start, end, sign * float(result.t[-1]), float(begin.speed), tail, stopped, g, gamma, result.sol)


def _straight(start: TwoPhaseState, here: Characteristic, c: float, strength: float) -> TwoPhaseState:
    """Return the end of a very short curve: one step along the eigenvector."""
    hs, hf, vs, vf = start
    dhs, dhf = here.share * strength, c * (1.0 - here.share) * strength
    return TwoPhaseState(float(hs + dhs), float(hf + dhf),
                         float(vs + (here.speed - vs) * dhs / hs), float(vf + (here.speed - vf) * dhf / hf))
