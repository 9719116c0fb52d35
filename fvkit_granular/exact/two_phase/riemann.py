"""Riemann problem of the full two-phase model: four waves between two constant states.

Semi-exact: each wave is computed to rounding, but across a shock the nonconservative products depend
on a path in the (hs, hf) plane, which is a modelling choice (``path``). Where vs = vf and phi is
uniform, and for fans, no choice enters. Derived by this project; verified by the jump conditions
(residual below 1e-10) and by fine grids of a path-consistent scheme (plateaus within 1e-4).
"""

import math
from collections.abc import Sequence
from itertools import pairwise
from typing import ClassVar

from attrs import evolve, field, frozen
from numpy.typing import ArrayLike

from fvkit.validation import choice, real
from fvkit_granular.exact.states import FloatArray, NoFourWaveSolution, TwoPhaseState, density_ratio, similarity, two_phase_state
from fvkit_granular.exact.two_phase.fields import characteristic
from fvkit_granular.exact.two_phase.integral_curves import TINY, integral_curve
from fvkit_granular.exact.two_phase.matching import Curves, match
from fvkit_granular.exact.two_phase.paths import PATHS
from fvkit_granular.exact.two_phase.self_similar import Jump, Piece, evaluate
from fvkit_granular.exact.two_phase.wave_curves import WaveCurve


@frozen
class TwoPhaseWave:
    """One of the four waves.

    Attributes
    ----------
    family : 1 to 4; 1 and 4 are the external (surface) waves, 2 and 3 the internal ones.
    kind : ``"R"`` fan, ``"S"`` shock; ``"RS"``, ``"SR"`` a fan with an attached shock, named from left to right.
    head, tail : speeds of the left and right edge, m/s; equal for a shock.
    shock : speed of the shock in the wave, None for a fan.
    strength : change of hs + hf (families 1, 4) or of hs - hf (2, 3) from left to right, m.
    left, right : the states beside the wave, `TwoPhaseState` (hs, hf, vs, vf and h, phi).
    middle : the state between the fan and the shock of a composite, else None.
    """

    family: int
    kind: str
    head: float
    tail: float
    shock: float | None
    strength: float
    left: TwoPhaseState
    right: TwoPhaseState
    middle: TwoPhaseState | None

    @property
    def absent(self) -> bool:
        """True where the wave is too weak to be told from rounding."""
        return abs(self.strength) < TINY * max(self.left.h, self.right.h)


@frozen(repr=False)
class TwoPhaseRiemann:
    """Self-similar solution made of four waves.

    Attributes
    ----------
    waves : the four waves, `TwoPhaseWave`, from left to right.
    states : the five constant states around them, `TwoPhaseState`.
    path : name of the path across shocks.
    g, gamma : gravity, m/s^2, and density ratio fluid/solid.
    mismatch : distance of the wave curves in the middle, relative to h and sqrt(g h).
    kind : ``"semi-exact"``.
    """

    kind: ClassVar[str] = "semi-exact"
    waves: tuple[TwoPhaseWave, ...]
    states: tuple[TwoPhaseState, ...]
    path: str
    g: float
    gamma: float
    mismatch: float
    _pieces: tuple[Piece, ...] = field(repr=False)

    def __repr__(self) -> str:
        waves = " ".join(f"{wave.family}-{'absent' if wave.absent else wave.kind}" for wave in self.waves)
        ends = " | ".join(f"h {state.h:g} phi {state.phi:g} vs {state.vs:g} vf {state.vf:g}"
                          for state in (self.states[0], self.states[-1]))
        return f"<TwoPhaseRiemann {ends}: waves {waves}; path {self.path}, g {self.g:g}, gamma {self.gamma:g}>"

    def at(self, x: ArrayLike, t: float, x0: float = 0.0) -> dict[str, FloatArray]:
        """Return ``h``, ``phi``, ``vs``, ``vf`` at the points ``x`` (any shape) and the time ``t`` >= 0."""
        return evaluate(self.states[0], self._pieces, similarity(x, t, x0))

    def describe(self) -> str:
        """Return a table of the waves and of the states between them."""
        rows = [f"two-phase Riemann problem, {self.kind}, path {self.path}, g {self.g:g}, gamma {self.gamma:g}"]
        rows.append(f"{'':28}{'h':>10}{'phi':>10}{'vs':>11}{'vf':>11}{'hs':>10}{'hf':>10}")
        rows.append(_row("left state", self.states[0]))
        for wave in self.waves:
            speeds = f"{wave.head:.6f}" if wave.head == wave.tail else f"{wave.head:.6f} .. {wave.tail:.6f}"
            rows.append(f"{wave.family}-{wave.kind}  {'absent' if wave.absent else speeds}")
            rows += [_row("  within", wave.middle)] if wave.middle is not None else []
            rows.append(_row("right state" if wave.family == 4 else "  behind", wave.right))
        return "\n".join(rows)


def two_phase_riemann(
    left: Sequence[float], right: Sequence[float], g: float = 9.81, gamma: float = 0.5, path: str = "depths"
) -> TwoPhaseRiemann:
    """Solve the Riemann problem of the full two-phase model on a flat bottom, without drag or friction.

    Parameters
    ----------
    left, right : (h, phi, vs, vf), h > 0 in m, phi in (0, 1), velocities in m/s.
    g, gamma : gravity, m/s^2, and density ratio in (0, 1).
    path : the path across shocks in the (hs, hf) plane: a segment in ``"depths"`` (hs, hf: the one that
        the Roe matrix belongs to), ``"h-phi"``, ``"sqrt"``, ``"log"`` or ``"square"`` of the depths.

    Returns
    -------
    TwoPhaseRiemann, semi-exact.

    Raises
    ------
    NoFourWaveSolution
        A `ValueError` that names the cause: a dry state, hyperbolicity lost behind a wave, the end of
        a shock locus, waves out of order, or a stalled iteration.
    ValueError
        For values that are no states, or an unknown path.
    """
    g, gamma = real(g, "g", above=0.0), density_ratio(gamma)
    path = choice(path, "path", PATHS)
    first, last = (two_phase_state(state, where, dry=NoFourWaveSolution) for state, where in ((left, "left"), (right, "right")))
    for state, where in ((first, "left"), (last, "right")):
        _check_hyperbolic(state, where, g, gamma)
    _check_vacuum(first, last, g)
    curves = Curves(WaveCurve(path, g, gamma))
    strengths, mismatch = match(first, last, curves)
    e1, e2, e3, e4 = strengths.tolist()
    on_left, on_right = curves.from_left(first, e1, e2), curves.from_right(last, e3, e4)
    groups = [tuple(_with_interior(piece, g, gamma) for piece in group) for group in on_left]
    groups += [tuple(_mirrored(piece, g, gamma) for piece in reversed(group)) for group in reversed(on_right)]
    waves = tuple(_wave(group) for group in groups)
    _check_order(waves)
    pieces = tuple(piece for wave, group in zip(waves, groups, strict=True) if not wave.absent for piece in group)
    states = (first, *(wave.right for wave in waves[:3]), last)
    return TwoPhaseRiemann(waves, states, path, g, gamma, mismatch, pieces)


def _row(name: str, state: TwoPhaseState) -> str:
    numbers = f"{state.h:10.6f}{state.phi:10.6f}{state.vs:11.6f}{state.vf:11.6f}{state.hs:10.6f}{state.hf:10.6f}"
    return f"{name:28}{numbers}"


def _check_hyperbolic(state: TwoPhaseState, where: str, g: float, gamma: float) -> None:
    """Raise unless the inner pair of speeds is real and distinct."""
    if not characteristic(2, *state, g, gamma).disc > 0.0:
        raise NoFourWaveSolution(
            f"`{where}` is not hyperbolic: its slip vs - vf = {state.vs - state.vf:.6g} m/s makes the inner pair of "
            f"speeds complex at h = {state.h:.6g}, phi = {state.phi:.6g}; reduce the slip"
        )


def _check_vacuum(left: TwoPhaseState, right: TwoPhaseState, g: float) -> None:
    """Raise where the streams part so fast that the bed falls dry between them (sharp where vs = vf)."""
    parting = min(right.vs, right.vf) - max(left.vs, left.vf)
    limit = 2.0 * (math.sqrt(g * left.h) + math.sqrt(g * right.h))
    if parting >= limit:
        raise NoFourWaveSolution(
            f"a vacuum opens: the streams part with {parting:.6g} m/s, at least 2 (sqrt(g h_L) + sqrt(g h_R)) = "
            f"{limit:.6g} m/s; for uniform phi and vs = vf use reduced_riemann"
        )


def _with_interior(piece: Piece, g: float, gamma: float) -> Piece:
    """Return a piece that can be evaluated inside."""
    if isinstance(piece, Jump):
        return piece
    fan = integral_curve(piece.start, piece.family, piece.strength, g, gamma, dense=True)
    return evolve(fan, end=piece.end)


def _mirrored(piece: Piece, g: float, gamma: float) -> Piece:
    """Return the piece as seen with the x axis turned back, from left to right."""
    family, start, end = 5 - piece.family, piece.end.mirrored(), piece.start.mirrored()
    if isinstance(piece, Jump):
        return Jump(family, start, end, -piece.strength, -piece.speed)
    fan = integral_curve(start, family, -piece.strength, g, gamma, dense=True)
    return evolve(fan, end=end)


def _wave(group: tuple[Piece, ...]) -> TwoPhaseWave:
    """Return the record of the wave that one or two pieces make."""
    kind = "".join("S" if isinstance(piece, Jump) else "R" for piece in group)
    shocks = [piece.speed for piece in group if isinstance(piece, Jump)]
    return TwoPhaseWave(family=group[0].family, kind=kind, head=group[0].head, tail=group[-1].tail,
                        shock=shocks[0] if shocks else None, strength=sum(piece.strength for piece in group), left=group[0].start,
                        right=group[-1].end, middle=group[0].end if len(group) == 2 else None)


def _check_order(waves: tuple[TwoPhaseWave, ...]) -> None:
    """Raise where one wave runs into the next, so that four separate waves do not exist."""
    present = [wave for wave in waves if not wave.absent]
    for slow, fast in pairwise(present):
        if slow.tail < fast.head:
            continue
        raise NoFourWaveSolution(
            f"waves out of order: the {slow.family}-wave ends at {slow.tail:.6g} m/s but the {fast.family}-wave starts "
            f"at {fast.head:.6g} m/s. Behind a bore of depth ratio r the internal sound runs into the bore where "
            f"(1-phi)(1-gamma)/2 > (1+r)/(2 r^2), and no solution made of four separate waves exists; "
            "take a smaller depth ratio or uniform phi with vs = vf"
        )
