"""Wave curve of one field: fans, shocks and their composites, chosen by the Liu condition.

Fields 2 and 3 are not genuinely nonlinear (for vs = vf they change sense at phi = (1+gamma)/(4+gamma)),
so a wave may be a fan with a shock attached. Rule, for one inflection on the way:

* the curve starts as a fan (e dl/de > 0) and l passes its maximum: a single shock where its speed does
  not exceed l of the start; else a fan up to the state q* from which a shock moves with sigma = l(q*);
* it starts as a shock: a single shock where sigma is not below l behind it; else the shock up to the
  first state with sigma = l behind it, and a fan from there.
"""

from attrs import frozen
from scipy.optimize import brentq

from fvkit_granular.exact.states import NoFourWaveSolution, TwoPhaseState
from fvkit_granular.exact.two_phase.fields import characteristic
from fvkit_granular.exact.two_phase.integral_curves import TINY, IntegralCurve, integral_curve
from fvkit_granular.exact.two_phase.self_similar import Jump, Piece
from fvkit_granular.exact.two_phase.shock_locus import ShockLocus, ShockPoint

#: Speeds closer than this times the largest one count as equal in the Liu condition.
SAME_SPEED = 1e-10


@frozen
class WaveCurve:
    """The forward wave curves (left state given) of one choice of path and parameters.

    With ``mirrored`` the x axis is reversed; messages name the true field and velocities.
    """

    path: str
    g: float
    gamma: float
    mirrored: bool = False

    def wave(self, start: TwoPhaseState, family: int, strength: float) -> tuple[Piece, ...]:
        """Return the one or two pieces of the wave of given strength that has ``start`` on its left."""
        here = characteristic(family, *start, self.g, self.gamma)
        if not here.disc > 0.0:
            raise NoFourWaveSolution(self._not_hyperbolic(family, start))
        if not 0.0 < here.share < 1.0:
            raise NoFourWaveSolution(
                f"the slip |vs - vf| = {abs(start.vs - start.vf):.6g} m/s before the {self._name(family)}-wave exceeds "
                "2 sqrt(g h): the four fields change their roles there; reduce the slip"
            )
        if strength * here.slope > 0.0 or abs(strength) < TINY * start.h:
            return self._from_fan(start, family, strength)
        return self._from_shock(start, family, strength)

    def _from_fan(self, start: TwoPhaseState, family: int, strength: float) -> tuple[Piece, ...]:
        fan = self._fan(start, family, strength)
        if fan.stopped == "strength":
            return (fan,)
        single = self._locus(start, family).point(strength)
        if single.speed <= fan.head:
            return (self._jump(start, family, single),)

        def detached(part: float) -> float:
            """Return how much the shock of the remaining strength outruns the fan's last state."""
            last = self._fan(start, family, part)
            rest = self._locus(last.end, family).point(strength - part)
            return rest.speed - last.tail

        if detached(0.0) <= 0.0 or detached(fan.strength) > 0.0:
            raise NoFourWaveSolution(self._second_inflection(family))
        part = brentq(detached, 0.0, fan.strength, xtol=1e-15, rtol=1e-14)
        first = self._fan(start, family, part)
        rest = self._locus(first.end, family).point(strength - part)
        jump = self._jump(first.end, family, rest)
        if self._behind(family, jump.end) > jump.speed + SAME_SPEED * (abs(jump.speed) + fan.tail - fan.head):
            raise NoFourWaveSolution(self._second_inflection(family))
        return first, jump

    def _from_shock(self, start: TwoPhaseState, family: int, strength: float) -> tuple[Piece, ...]:
        locus = self._locus(start, family)
        before = locus.origin()
        for point in locus.points(strength):
            if point.speed < self._behind(family, point.state):
                break
            before = point
        else:
            return (self._jump(start, family, before),)

        def excess(e: float) -> float:
            shock = locus.refined(e, point)
            return shock.speed - self._behind(family, shock.state)

        lower = before.strength if before.strength else 0.1 * point.strength
        while excess(lower) <= 0.0:
            lower *= 0.1
            if abs(lower) < TINY * start.h:
                # it starts at the inflection itself: the shock in front of the fan is lost in rounding
                return self._from_fan(start, family, strength)
        touching = locus.refined(brentq(excess, lower, point.strength, xtol=1e-15, rtol=1e-14), point)
        jump = self._jump(start, family, touching)
        fan = self._fan(jump.end, family, strength - touching.strength)
        if fan.stopped != "strength":
            raise NoFourWaveSolution(self._second_inflection(family))
        return jump, fan

    def _fan(self, start: TwoPhaseState, family: int, strength: float) -> IntegralCurve:
        curve = integral_curve(start, family, strength, self.g, self.gamma)
        if curve.stopped == "complex":
            raise NoFourWaveSolution(self._not_hyperbolic(family, curve.end))
        if curve.stopped == "empty":
            raise NoFourWaveSolution(
                f"the fan of field {self._name(family)} runs dry (hs = {curve.end.hs:.3g}, hf = {curve.end.hf:.3g}): "
                "a vacuum opens; for uniform phi and vs = vf use reduced_riemann"
            )
        return curve

    def _behind(self, family: int, state: TwoPhaseState) -> float:
        """Return the speed of the field behind a shock, where it must be hyperbolic."""
        here = characteristic(family, *state, self.g, self.gamma)
        if not here.disc > 0.0:
            raise NoFourWaveSolution(self._not_hyperbolic(family, state))
        return float(here.speed)

    def _jump(self, start: TwoPhaseState, family: int, point: ShockPoint) -> Jump:
        self._behind(family, point.state)
        return Jump(family, start, point.state, point.strength, point.speed)

    def _locus(self, start: TwoPhaseState, family: int) -> ShockLocus:
        return ShockLocus(start, family, self.path, self.g, self.gamma, name=self._name(family))

    def _name(self, family: int) -> int:
        """Return the number of the field as the user counts it."""
        return 5 - family if self.mirrored else family

    def _not_hyperbolic(self, family: int, state: TwoPhaseState) -> str:
        hs, hf, vs, vf = state.mirrored() if self.mirrored else state
        return (f"hyperbolicity is lost at the {self._name(family)}-wave: the state hs = {hs:.6g}, hf = {hf:.6g}, "
                f"vs = {vs:.6g}, vf = {vf:.6g} has a complex inner pair of speeds; reduce the slip vs - vf or the jump")

    def _second_inflection(self, family: int) -> str:
        return (f"the {self._name(family)}-wave crosses more than one inflection of its field; only composites of one fan "
                "and one shock are solved")
