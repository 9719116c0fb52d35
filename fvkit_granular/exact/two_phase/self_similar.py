"""Evaluation of a self-similar solution: a row of fans and jumps between constant states."""

from collections.abc import Sequence

import numpy as np
from attrs import frozen
from numpy.typing import ArrayLike

from fvkit_granular.exact.states import FloatArray, TwoPhaseState
from fvkit_granular.exact.two_phase.integral_curves import IntegralCurve


@frozen
class Jump:
    """A shock from ``start`` to ``end`` that moves with ``speed``."""

    family: int
    start: TwoPhaseState
    end: TwoPhaseState
    strength: float
    speed: float

    @property
    def head(self) -> float:
        """Speed of the left edge: the shock's own."""
        return self.speed

    @property
    def tail(self) -> float:
        """Speed of the right edge: the shock's own."""
        return self.speed


Piece = IntegralCurve | Jump


def evaluate(left: TwoPhaseState, pieces: Sequence[Piece], xi: ArrayLike) -> dict[str, FloatArray]:
    """Return ``h``, ``phi``, ``vs``, ``vf`` at xi = x/t (any shape); ``pieces`` are in order of speed."""
    speeds = np.asarray(xi, dtype=float)
    flat = speeds.ravel()
    rows = np.repeat(np.array(left)[:, None], flat.size, axis=1)
    for piece in pieces:
        if isinstance(piece, IntegralCurve):
            inside = (flat > piece.head) & (flat < piece.tail)
            rows[:, inside] = piece.states_at(flat[inside])
        rows[:, flat >= piece.tail] = np.array(piece.end)[:, None]
    hs, hf, vs, vf = (row.reshape(speeds.shape) for row in rows)
    return {"h": hs + hf, "phi": hs / (hs + hf), "vs": vs, "vf": vf}
