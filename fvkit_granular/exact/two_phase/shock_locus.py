"""Shock locus of one field: the states that a single shock can join to a given one.

With the velocities eliminated by [h v] = sigma [h] two unknowns are left, the share y = d(hs)/e and
the shock speed sigma; with z = c - c y, means hs^, hf^ and the path's area delta (see `paths`)

    y (vs - sigma)^2 = (hs+/hs-) g [(hs^ + (1-gamma)/2 hf^) y + (1+gamma)/2 hs^ z + gamma delta/e]
    z (vf - sigma)^2 = (hf+/hf-) g [hf^ (y + z) - delta/e],

which for delta = 0 is (A^ - sigma) [q] = 0 with the Roe matrix A^. Solved by SciPy from the tangent of
the field, continued in e by steps of about a tenth of the depth. Derived by this project.
"""

import math
from collections import deque
from collections.abc import Iterator
from typing import NamedTuple

import numpy as np
from attrs import frozen
from scipy.optimize import root

from fvkit_granular.exact.states import FloatArray, NoFourWaveSolution, TwoPhaseState
from fvkit_granular.exact.two_phase.fields import characteristic, orientation
from fvkit_granular.exact.two_phase.paths import PATHS, PathArea
from fvkit_granular.models.spectrum import couplings

#: Length of a continuation step over the depth, and the shortest before the locus is said to end.
STEP, SHORTEST = 0.1, 1e-4
#: Accepted residual of the two equations over g h, reached or bettered at every point.
RESIDUAL = 1e-11


class ShockPoint(NamedTuple):
    """A shock of strength e: its share y, its speed and the state behind it."""

    strength: float
    share: float
    speed: float
    state: TwoPhaseState


@frozen
class ShockLocus:
    """The shocks of one ``family`` that have the state ``start`` on their left; ``name`` is its number in messages."""

    start: TwoPhaseState
    family: int
    path: str
    g: float
    gamma: float
    name: int

    def origin(self) -> ShockPoint:
        """Return the shock of zero strength."""
        here = characteristic(self.family, *self.start, self.g, self.gamma)
        return ShockPoint(0.0, float(here.share), float(here.speed), self.start)

    def points(self, strength: float) -> Iterator[ShockPoint]:
        """Yield the points of the locus up to ``strength``, a tenth of the depth apart."""
        before, here = None, self.origin()
        sign, depth = math.copysign(1.0, strength), self.start.h
        step = STEP * depth
        while here.strength != strength:
            left = abs(strength) - abs(here.strength)
            target = strength if left <= 1.01 * step else here.strength + sign * step
            found = self._solve(target, *_extrapolated(before, here, target))
            if found is None or abs(found.speed - here.speed) > 0.5 * math.sqrt(self.g * here.state.h):
                step *= 0.5
                if step < SHORTEST * depth:
                    raise NoFourWaveSolution(self._end(here))
                continue
            before, here = here, found
            step = min(1.5 * step, STEP * here.state.h)
            yield here

    def point(self, strength: float) -> ShockPoint:
        """Return the shock of the given strength."""
        last = deque(self.points(strength), maxlen=1)
        return last[0] if last else self.origin()

    def refined(self, strength: float, near: ShockPoint) -> ShockPoint:
        """Return the shock of the given strength from a neighbour on the locus."""
        found = self._solve(strength, near.share, near.speed)
        return self.point(strength) if found is None else found

    def _solve(self, e: float, share: float, speed: float) -> ShockPoint | None:
        """Return the point at strength ``e`` from a guess, or None where the iteration fails."""
        hs, hf, vs, vf = self.start
        c, g, gamma, area, size = orientation(self.family), self.g, self.gamma, PATHS[self.path], self.g * self.start.h

        def residual(y: float, sigma: float) -> tuple[float, float]:
            return _residual(y, sigma, e, c, hs, hf, vs, vf, area, g, gamma)

        def equations(unknown: FloatArray) -> tuple[float, float]:
            return residual(*unknown.tolist())

        def jacobian(unknown: FloatArray) -> FloatArray:
            y, sigma = unknown.tolist()
            dy = 1e-6
            (up_s, up_f), (down_s, down_f) = residual(y + dy, sigma), residual(y - dy, sigma)
            by_speed = -2.0 * y * (vs - sigma), -2.0 * c * (1.0 - y) * (vf - sigma)
            return np.array([[(up_s - down_s) / (2 * dy), by_speed[0]], [(up_f - down_f) / (2 * dy), by_speed[1]]])

        try:
            result = root(equations, (share, speed), jac=jacobian, options={"xtol": 1e-15})
        except _EmptyPhase:
            return None
        y, sigma = result.x.tolist()
        if not (0.0 < y < 1.0 and max(abs(value) for value in result.fun) < RESIDUAL * size):
            return None
        hs1, hf1 = hs + y * e, hf + c * (1.0 - y) * e
        behind = TwoPhaseState(hs1, hf1, vs + (sigma - vs) * y * e / hs1, vf + (sigma - vf) * c * (1.0 - y) * e / hf1)
        return ShockPoint(e, y, sigma, behind)

    def _end(self, last: ShockPoint) -> str:
        return (f"the shock locus of field {self.name} from hs = {self.start.hs:.6g}, hf = {self.start.hf:.6g} ends at "
                f"hs = {last.state.hs:.6g}, hf = {last.state.hf:.6g}: no stronger shock of this field exists there")


class _EmptyPhase(ArithmeticError):
    """The iteration left the range of positive depths."""


def _residual(y: float, sigma: float, e: float, c: float, hs: float, hf: float, vs: float, vf: float,
              area: PathArea, g: float, gamma: float) -> tuple[float, float]:
    """Return the residuals of the two jump conditions."""
    z = c * (1.0 - y)
    hs1, hf1 = hs + y * e, hf + z * e
    if hs1 <= 0.0 or hf1 <= 0.0:
        raise _EmptyPhase
    css, cff, csf, _ = couplings(0.5 * (hs + hs1), 0.5 * (hf + hf1), g, gamma)
    excess = g * area(hs, hf, hs1, hf1) / e
    solid = y * (vs - sigma) ** 2 - hs1 / hs * (css * y + csf * z + gamma * excess)
    fluid = z * (vf - sigma) ** 2 - hf1 / hf * (cff * (y + z) - excess)
    return solid, fluid


def _extrapolated(before: ShockPoint | None, here: ShockPoint, target: float) -> tuple[float, float]:
    """Return a guess of share and speed at ``target`` by a line through the last two points."""
    if before is None:
        return here.share, here.speed
    ratio = (target - here.strength) / (here.strength - before.strength)
    return here.share + ratio * (here.share - before.share), here.speed + ratio * (here.speed - before.speed)
