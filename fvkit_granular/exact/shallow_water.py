"""Riemann problem of the shallow-water equations, wet or dry.

Exact: Stoker's dam break on a wet bed, Ritter's on a dry one, colliding and parting streams, with a
vacuum in the middle where they part fast enough. It is the reduced model's solution for uniform
density. Accuracy: rounding.
"""

from collections.abc import Sequence
from typing import ClassVar, NamedTuple

from attrs import frozen
from numpy.typing import ArrayLike

from fvkit_granular.exact.reduced import ReducedRiemann, reduced_riemann
from fvkit_granular.exact.states import FloatArray, Wave, finite_tuple, similarity


class ShallowWaterState(NamedTuple):
    """One state of the shallow-water model: depth h in m, velocity v in m/s."""

    h: float
    v: float


@frozen
class ShallowWaterRiemann:
    """Self-similar solution of a shallow-water Riemann problem.

    Call it with xi = x/t for a tuple (h, v), or use ``at(x, t)`` for a dict.

    Attributes
    ----------
    left, right, star : the two initial states and the state between the waves (dry where a vacuum opens
        or a side is dry).
    waves : the `Wave` records of family 1 and 2, ``"R"`` or ``"S"``; a dry side has none.
    kind : ``"exact"``.

    Notes
    -----
    On dry ground h = 0 and v = 0 are returned.
    """

    kind: ClassVar[str] = "exact"
    left: ShallowWaterState
    right: ShallowWaterState
    star: ShallowWaterState
    waves: tuple[Wave, ...]
    _reduced: ReducedRiemann

    def __call__(self, xi: ArrayLike) -> tuple[FloatArray, FloatArray]:
        """Return h, v at xi = x/t, m/s, each of the shape of ``xi``."""
        h, _, v = self._reduced(xi)
        return h, v

    def at(self, x: ArrayLike, t: float, x0: float = 0.0) -> dict[str, FloatArray]:
        """Return ``h``, ``v`` at the points ``x`` (any shape) and the time ``t`` >= 0."""
        h, v = self(similarity(x, t, x0))
        return {"h": h, "v": v}


def shallow_water_riemann(left: Sequence[float], right: Sequence[float], g: float = 9.81) -> ShallowWaterRiemann:
    """Solve the Riemann problem of the shallow-water equations on a flat bottom.

    Parameters
    ----------
    left, right : (h, v), h >= 0 in m (0 is dry), v in m/s.
    g : gravity, m/s^2.

    Returns
    -------
    ShallowWaterRiemann, exact.

    Raises
    ------
    ValueError
        For values that are no states.

    References
    ----------
    J. J. Stoker, Water Waves, 1957; A. Ritter, Zeitschrift VDI 36, 1892.
    """
    first = ShallowWaterState(*finite_tuple(left, "h v", "left"))
    last = ShallowWaterState(*finite_tuple(right, "h v", "right"))
    reduced = reduced_riemann((first.h, 1.0, first.v), (last.h, 1.0, last.v), g)
    star = ShallowWaterState(reduced.star_left.h, reduced.star_left.v)
    waves = tuple(Wave(1 if w.family == 1 else 2, w.kind, w.head, w.tail) for w in reduced.waves if w.kind != "C")
    return ShallowWaterRiemann(first, last, star, waves, reduced)
