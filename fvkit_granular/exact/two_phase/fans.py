"""Rarefaction fans through all four fields: exact Riemann solutions of the full two-phase model.

Exact: the solution is continuous and self-similar and made of integral curves only, so no shock and
no choice of path enters, and every consistent scheme must converge to it. Derived by this project.
Accuracy of the evaluation: better than 1e-10 (the curves are integrated at tolerance 1e-12).
"""

import math
from collections.abc import Sequence
from typing import ClassVar

from attrs import frozen
from numpy.typing import ArrayLike

from fvkit.validation import real
from fvkit_granular.exact.states import FloatArray, TwoPhaseState, Wave, density_ratio, finite_tuple, similarity, two_phase_state
from fvkit_granular.exact.two_phase.fields import characteristic
from fvkit_granular.exact.two_phase.integral_curves import IntegralCurve, integral_curve
from fvkit_granular.exact.two_phase.self_similar import evaluate

_CAUSES = {
    "inflection": "field {k} loses genuine nonlinearity there (grad l . r = 0); choose a narrower fan",
    "complex": "the system loses hyperbolicity there (complex inner pair); choose a narrower fan or less slip vs - vf",
    "empty": "a phase runs out there; choose a narrower fan",
    "strength": "the curve does not reach that speed; choose a narrower fan",
}


@frozen
class RarefactionFans:
    """Continuous self-similar solution made of up to four fans.

    Attributes
    ----------
    left, right : the two initial states, `TwoPhaseState`.
    states : the constant states between the fans, ``left`` first and ``right`` last.
    waves : one `Wave` of kind ``"R"`` for each fan of nonzero width.
    """

    kind: ClassVar[str] = "exact"
    left: TwoPhaseState
    right: TwoPhaseState
    states: tuple[TwoPhaseState, ...]
    waves: tuple[Wave, ...]
    _curves: tuple[IntegralCurve, ...]

    def at(self, x: ArrayLike, t: float, x0: float = 0.0) -> dict[str, FloatArray]:
        """Return ``h``, ``phi``, ``vs``, ``vf`` at the points ``x`` (any shape) and the time ``t`` >= 0."""
        return evaluate(self.left, self._curves, similarity(x, t, x0))


def rarefaction_fans(left: Sequence[float], widths: Sequence[float], g: float = 9.81, gamma: float = 0.5) -> RarefactionFans:
    """Build the exact solution that starts at ``left`` and opens a fan of given width in each field.

    Each fan follows dq/dl = r_k / (grad l_k . r_k) with growing speed l.

    Parameters
    ----------
    left : (h, phi, vs, vf), h > 0 in m, phi in (0, 1), velocities in m/s.
    widths : four widths >= 0, m/s: tail speed minus head speed of the fans of fields 1 to 4; 0 for no fan.
    g, gamma : gravity, m/s^2, and density ratio in (0, 1).

    Returns
    -------
    RarefactionFans, whose ``right`` is the other initial state.

    Raises
    ------
    ValueError
        When a fan would leave the region where its field is genuinely nonlinear, or hyperbolicity or a
        phase is lost along it.

    Notes
    -----
    Fans cannot overlap: at the state between two of them the speeds of the fields are distinct and ordered.
    """
    g, gamma = real(g, "g", above=0.0), density_ratio(gamma)
    state = first = two_phase_state(left, "left")
    spreads = finite_tuple(widths, "width1 width2 width3 width4", "widths")
    if min(spreads) < 0.0:
        raise ValueError(f"`widths` must be >= 0 (a fan spreads with time), got {spreads}")
    curves: list[IntegralCurve] = []
    for family, width in enumerate(spreads, start=1):
        begin = characteristic(family, *state, g, gamma)
        if not begin.disc > 0.0:
            raise ValueError(f"the state {state} before field {family} is not hyperbolic; reduce the slip vs - vf")
        if width == 0.0:
            continue
        curves.append(_fan(state, family, width, float(begin.speed), begin.slope, g, gamma))
        state = curves[-1].end
    waves = tuple(Wave(curve.family, "R", curve.head, curve.tail) for curve in curves)
    return RarefactionFans(first, state, (first, *(curve.end for curve in curves)), waves, tuple(curves))


def _fan(state: TwoPhaseState, family: int, width: float, head: float, slope: float, g: float, gamma: float) -> IntegralCurve:
    """Return the curve whose speed grows from ``head`` by ``width``, or raise with the cause."""
    reach = math.copysign(100.0 * state.h, slope)
    curve = integral_curve(state, family, reach, g, gamma, stop_speed=head + width, dense=True)
    if curve.stopped != "speed":
        cause = _CAUSES[curve.stopped].format(k=family)
        raise ValueError(f"the fan of field {family} was to span {head:.6g} .. {head + width:.6g} m/s, but its curve ends at "
                         f"{curve.tail:.6g} m/s, h = {curve.end.h:.6g}, phi = {curve.end.phi:.6g}: {cause}")
    return curve
