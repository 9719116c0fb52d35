"""Steady curves: depths of two masses with given discharges as functions of the bottom height b, (3.8).

With the entries of the quasi-linear matrix (`couplings`) and ms, mf fixed, the momentum equations of a steady flow are

    (css - vs^2) dhs + csf dhf = -g hs db,    cff dhs + (cff - vf^2) dhf = -g hf db,

so a profile depends on x through b alone. Their determinant is P(0), the product of the characteristic speeds: where it
vanishes a wave stands, b is extremal along the curve, and hs, hf are no functions of b. With the arc length s of
(hs, hf) as variable the curve is regular there too, and one integration passes a crest. Derived here.

Accuracy: 1e-12, and the square root of rounding in b beside a critical point.
"""

from typing import Any

import numpy as np
from attrs import frozen
from scipy.integrate import solve_ivp
from scipy.optimize.elementwise import find_root

from fvkit_granular.exact.states import FloatArray

RTOL, ATOL = 1e-13, 1e-15
#: A curve is followed for this many times its depth and the height of the bottom together.
FAR = 100.0


class Lost(ValueError):
    """A steady curve cannot be followed: it loses hyperbolicity, or ends."""


@frozen
class Discharges:
    """Discharges hs vs, hf vf, m^2/s, of two masses and the model that moves them."""

    model: Any
    ms: float
    mf: float

    def standing(self, hs: Any, hf: Any) -> Any:
        """Return a number that changes sign at a standing wave: P(0), the product of the four characteristic speeds, m^4/s^4."""
        css, cff, _, rest = self.model.couplings(hs, hf)
        vs2, vf2 = (self.ms / hs) ** 2, (self.mf / hf) ** 2
        return rest - css * vf2 - cff * vs2 + vs2 * vf2

    def slope(self, s: float, y: FloatArray) -> list[float]:
        """Return d(hs, hf, b)/ds at y = (hs, hf, b)."""
        hs, hf, _ = y
        css, cff, csf, _ = self.model.couplings(hs, hf)
        solid = (cff - (self.mf / hf) ** 2) * hs - csf * hf
        fluid = (css - (self.ms / hs) ** 2) * hf - cff * hs
        length = np.hypot(solid, fluid)
        return [-solid / length, -fluid / length, self.standing(hs, hf) / (self.model.g * length)]

    def margin(self, hs: FloatArray, hf: FloatArray) -> FloatArray:
        """Return the hyperbolicity margin of the model: negative where characteristic speeds are complex."""
        ones = np.ones_like(hs)
        return self.model.hyperbolicity_margin(np.array([hs, self.ms * ones, hf, self.mf * ones]))

    def speeds(self, hs: float, hf: float) -> FloatArray:
        """Return the real parts of the characteristic speeds, ascending, m/s."""
        return self.model.eigenvalues(np.array([[hs], [self.ms], [hf], [self.mf]])).real[:, 0]


@frozen
class OneVelocity(Discharges):
    """Discharges of two phases with one velocity and uniform phi, which remain uniform: standing inner waves have no effect."""

    def standing(self, hs: Any, hf: Any) -> Any:
        """Return a number that changes sign at a standing outer wave, m^3/s^2."""
        css, _, csf, _ = self.model.couplings(hs, hf)
        return ((css - (self.ms / hs) ** 2) * hs + csf * hf) * (hs + hf) / hs

    def slope(self, s: float, y: FloatArray) -> list[float]:
        """Return d(hs, hf, b)/ds at y = (hs, hf, b), from the momentum of the solid."""
        hs, hf, _ = y
        h = hs + hf
        return [-hs / h, -hf / h, self.standing(hs, hf) / (self.model.g * h * h)]


def discharges(model: Any, hs: float, hf: float, vs: float, vf: float) -> Discharges:
    """Return the discharges of a state; those of one velocity where vs = vf and the model keeps phi uniform then."""
    general = Discharges(model, hs * vs, hf * vf)
    if vs == vf:
        dhs, dhf, _ = general.slope(0.0, np.array([1.1 * hs, 1.1 * hf, 0.0]))
        if abs(dhs * hf - dhf * hs) < 1e-12 * (hs + hf):
            return OneVelocity(model, general.ms, general.mf)
    return general


@frozen(eq=False)
class Piece:
    """A piece of a steady curve on which b is monotone.

    Attributes
    ----------
    path : s -> (hs, hf, b), vectorised over s.
    start, end : ends of s, m.
    y_start, y_end : (hs, hf, b) there.
    critical : whether there is a standing wave at the end, so that the piece cannot be continued on this branch.
    """

    path: Any
    start: float
    end: float
    y_start: FloatArray
    y_end: FloatArray
    critical: bool

    def depths(self, b: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return hs, hf at heights ``b`` (n,); beyond the ends of the piece those of the nearer end."""
        low, high = sorted((self.y_start[2], self.y_end[2]))
        wanted = np.clip(b, low, high)
        if wanted.size == 0 or self.start == self.end:
            return np.full_like(b, self.y_end[0]), np.full_like(b, self.y_end[1])
        rising = 1.0 if self.y_end[2] > self.y_start[2] else -1.0
        ends = np.full_like(wanted, self.start), np.full_like(wanted, self.end)

        def excess(s: FloatArray, height: FloatArray) -> FloatArray:
            found = self.path(np.ravel(s))[2].reshape(np.shape(s))
            return rising * (np.where(s == self.start, self.y_start[2], np.where(s == self.end, self.y_end[2], found)) - height)

        s = find_root(excess, ends, args=(wanted,), tolerances={"xatol": 1e-16, "xrtol": 1e-15}).x
        hs, hf, _ = self.path(s)
        return hs, hf


def follow(flow: Discharges, start: tuple[float, float, float], heading: float, to: float, scale: float) -> Piece:
    """Follow the steady curve from ``start``, hs, hf, b, m, until b is ``to``, m, or a wave is standing.

    ``heading``, 1 or -1, is the direction of s, in which b must change towards ``to``; ``scale``, the height of the bottom, m,
    says how far to look. `Lost` if the curve reaches neither, or passes states where characteristic speeds are complex.
    """
    def arrived(s: float, y: FloatArray) -> float:
        return y[2] - to

    def stands(s: float, y: FloatArray) -> float:
        return float(flow.standing(y[0], y[1]))

    events: list[Any] = [arrived, stands]
    for event in events:
        event.terminal = True
    if start[2] == to:
        at = np.array(start)
        return Piece(None, 0.0, 0.0, at, at, False)
    reach = heading * FAR * (start[0] + start[1] + scale)
    # at a start where a wave stands, P(0) is rounding: its sign must not count as a crossing
    clear = abs(flow.slope(0.0, np.array(start))[2]) > 1e-8
    done = solve_ivp(flow.slope, (0.0, reach), start, method="DOP853", rtol=RTOL, atol=ATOL, dense_output=True,
                     events=events if clear else (arrived,), first_step=1e-6 * (start[0] + start[1]))
    bad = flow.margin(done.y[0], done.y[1]) < 0.0
    if bad.any():
        hs, hf, b = done.y[:, int(np.argmax(bad))]
        raise Lost(f"the steady flow loses hyperbolicity at b = {b:.6g}, where hs = {hs:.6g}, hf = {hf:.6g}, vs = "
                         f"{flow.ms / hs:.6g}, vf = {flow.mf / hf:.6g}: characteristic speeds are complex, and no scheme "
                         "keeps it; take less slip, or a lower crest")
    if done.status != 1:
        raise Lost(f"the steady flow cannot be followed from b = {start[2]:.6g} to b = {to:.6g}: lost at hs = "
                         f"{done.y[0, -1]:.6g}, hf = {done.y[1, -1]:.6g}, b = {done.y[2, -1]:.6g}")
    critical = len(done.t_events[0]) == 0
    return Piece(done.sol, 0.0, float(done.t[-1]), np.array(start), done.y[:, -1], critical)
