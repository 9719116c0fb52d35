"""Riemann problem of the shallow-water equations, wet or dry.

Exact: Stoker's dam break on a wet bed, Ritter's on a dry one, colliding and parting streams, with a
vacuum in the middle where they part fast enough. It is the reduced model's solution for uniform
density. Accuracy: rounding.
"""

from collections.abc import Sequence
from typing import ClassVar

from attrs import frozen
from numpy.typing import ArrayLike

from fvkit_granular.exact.reduced import ReducedRiemann, reduced_riemann
from fvkit_granular.exact.states import FloatArray, finite_tuple, similarity


@frozen
class ShallowWaterRiemann:
    """Self-similar solution of a shallow-water Riemann problem.

    Call it with xi = x/t for a tuple (h, v), or use ``at(x, t)`` for a dict.

    Attributes
    ----------
    reduced : the solution of the reduced model with phi = 1 on both sides, which has the states and the waves.
    kind : ``"exact"``.

    Notes
    -----
    On dry ground h = 0 and v = 0 are returned.
    """

    kind: ClassVar[str] = "exact"
    reduced: ReducedRiemann

    def __call__(self, xi: ArrayLike) -> tuple[FloatArray, FloatArray]:
        """Return h, v at xi = x/t, m/s, each of the shape of ``xi``."""
        h, _, v = self.reduced(xi)
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
    (h_l, v_l), (h_r, v_r) = finite_tuple(left, "h v", "left"), finite_tuple(right, "h v", "right")
    return ShallowWaterRiemann(reduced_riemann((h_l, 1.0, v_l), (h_r, 1.0, v_r), g))
