"""Matching of wave curves: the four wave strengths that connect two states of the two-phase model.

The wave curves of fields 1 and 2 start at the left state, those of fields 4 and 3 at the right state in
the mirrored frame (x, v -> -x, -v turns field k into 5 - k); they must meet in the middle state.
Newton's method (SciPy) starts from the strengths of the Roe linearisation; where it fails, the right
state is moved there from the left one by continuation.
"""

import math
from functools import lru_cache

import numpy as np
from attrs import evolve
from scipy.optimize import root

from fvkit_granular.exact.states import FloatArray, NoFourWaveSolution, TwoPhaseState
from fvkit_granular.exact.two_phase.fields import characteristic, orientation
from fvkit_granular.exact.two_phase.self_similar import Piece
from fvkit_granular.exact.two_phase.wave_curves import WaveCurve

#: Accepted mismatch of the middle states, relative to the depth and to sqrt(g h).
MISMATCH = 1e-10
#: Shortest continuation step (of 1) and the step of the difference Jacobian (of the depth).
SHORTEST, DIFFERENCE = 1.0 / 64.0, 1e-7
#: Failed waves that one Newton iteration may meet before it gives up.
PATIENCE = 10
#: Stands for the mismatch where a wave cannot be built: the trust region of the solver then shrinks.
UNREACHABLE = 1e3

Pieces = tuple[Piece, ...]


class Curves:
    """Wave curves from both sides, each wave cached: a difference Jacobian needs the same ones again."""

    def __init__(self, curves: WaveCurve) -> None:
        self.g, self.gamma = curves.g, curves.gamma
        self._forward = lru_cache(maxsize=256)(curves.wave)
        self._backward = lru_cache(maxsize=256)(evolve(curves, mirrored=True).wave)

    def from_left(self, left: TwoPhaseState, e1: float, e2: float) -> tuple[Pieces, Pieces]:
        """Return the waves 1 and 2 that follow ``left``."""
        first = self._forward(left, 1, e1)
        return first, self._forward(first[-1].end, 2, e2)

    def from_right(self, right: TwoPhaseState, e3: float, e4: float) -> tuple[Pieces, Pieces]:
        """Return the waves 4 and 3 that follow ``right`` in the mirrored frame, where they are 1 and 2."""
        first = self._backward(right.mirrored(), 1, e4)
        return first, self._backward(first[-1].end, 2, e3)

    def gap(self, left: TwoPhaseState, right: TwoPhaseState, e: FloatArray) -> FloatArray:
        """Return by how much the waves of strengths ``e`` from both sides miss each other."""
        e1, e2, e3, e4 = e.tolist()
        meeting = self.from_left(left, e1, e2)[1][-1].end, self.from_right(right, e3, e4)[1][-1].end.mirrored()
        return np.array(meeting[0]) - np.array(meeting[1])


def match(left: TwoPhaseState, right: TwoPhaseState, curves: Curves) -> tuple[FloatArray, float]:
    """Return the strengths (e1, e2, e3, e4), m, and the mismatch left in the middle state.

    e1, e2 count from the left state, e3, e4 from the right one in the mirrored frame.
    """
    try:
        return _newton(left, right, roe_strengths(left, right, curves), curves)
    except NoFourWaveSolution:
        return _continuation(left, right, curves)


def roe_strengths(left: TwoPhaseState, right: TwoPhaseState, curves: Curves) -> FloatArray:
    """Return the wave strengths of the Roe linearisation, e3 and e4 counted from the right."""
    roots = [math.sqrt(depth) for depth in (left.hs, left.hf, right.hs, right.hf)]
    vs = (roots[0] * left.vs + roots[2] * right.vs) / (roots[0] + roots[2])
    vf = (roots[1] * left.vf + roots[3] * right.vf) / (roots[1] + roots[3])
    mean = 0.5 * (left.hs + right.hs), 0.5 * (left.hf + right.hf), vs, vf
    columns = []
    for family in (1, 2, 3, 4):
        here = characteristic(family, *mean, curves.g, curves.gamma)
        if not here.disc > 0.0:
            raise NoFourWaveSolution("the Roe mean of the two states is not hyperbolic; reduce the slip vs - vf")
        y, z = here.share, orientation(family) * (1.0 - here.share)
        columns.append((y, here.speed * y, z, here.speed * z))
    dq = _conserved(right) - _conserved(left)
    return np.linalg.solve(np.array(columns).T, dq) * np.array([1.0, 1.0, -1.0, -1.0])


def _conserved(state: TwoPhaseState) -> FloatArray:
    return np.array((state.hs, state.hs * state.vs, state.hf, state.hf * state.vf))


def _newton(left: TwoPhaseState, right: TwoPhaseState, guess: FloatArray, curves: Curves) -> tuple[FloatArray, float]:
    """Solve from ``guess``, or raise with the cause of the last failure."""
    depth = max(left.h, right.h)
    velocity = math.sqrt(curves.g * depth)
    scale = np.array([depth, depth, velocity, velocity])
    causes: list[NoFourWaveSolution] = []

    def mismatch(e: FloatArray) -> FloatArray:
        return curves.gap(left, right, e) / scale

    def guarded(e: FloatArray) -> FloatArray:
        try:
            return mismatch(e)
        except NoFourWaveSolution as cause:
            causes.append(cause)
            if len(causes) > PATIENCE:
                raise
            return np.full(4, UNREACHABLE)

    def jacobian(e: FloatArray) -> FloatArray:
        here, step = mismatch(e), DIFFERENCE * depth
        return np.array([(mismatch(e + step * unit) - here) / step for unit in np.eye(4)]).T

    mismatch(guess)
    result = root(guarded, guess, jac=jacobian, options={"xtol": 1e-14, "maxfev": 60})
    error = float(np.max(np.abs(result.fun)))
    if error <= MISMATCH:
        return result.x, error
    if causes:
        raise causes[-1]
    raise NoFourWaveSolution(f"Newton's method for the four wave strengths stalls at a relative mismatch of {error:.1e} "
                             f"(allowed {MISMATCH:.0e}); the states may lie at the edge of what four waves can join")


def _continuation(left: TwoPhaseState, right: TwoPhaseState, curves: Curves) -> tuple[FloatArray, float]:
    """Move the right state from ``left`` to ``right`` in steps, each solved from the last two."""
    start, goal = np.array(left), np.array(right)
    before_s, before = 0.0, np.zeros(4)
    s, strengths, error, step = 0.0, np.zeros(4), 0.0, 0.25
    while s < 1.0:
        target = min(1.0, s + step)
        between = right if target == 1.0 else TwoPhaseState(*(start + target * (goal - start)).tolist())
        try:
            if s > 0.0:
                guess = strengths + (target - s) / (s - before_s) * (strengths - before)
            else:
                guess = roe_strengths(left, between, curves)
            found, error = _newton(left, between, guess, curves)
        except NoFourWaveSolution:
            step = 0.5 * (target - s)
            if step < SHORTEST:
                raise
            continue
        before_s, before, s, strengths = s, strengths, target, found
        step *= 1.5
    return strengths, error
