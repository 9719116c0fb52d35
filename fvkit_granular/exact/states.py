"""Primitive states and waves of the exact solutions, argument checks, and the similarity variable x/t."""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from attrs import frozen
from numpy.typing import ArrayLike, NDArray

from fvkit.validation import is_single, real, shown

FloatArray = NDArray[np.float64]


class NoFourWaveSolution(ValueError):
    """The Riemann problem has no solution made of four separate waves; the message names the cause."""


class TwoPhaseState(NamedTuple):
    """One state of the two-phase model: depths hs, hf in m and velocities vs, vf in m/s."""

    hs: float
    hf: float
    vs: float
    vf: float

    @property
    def h(self) -> float:
        """Total depth hs + hf, m."""
        return self.hs + self.hf

    @property
    def phi(self) -> float:
        """Solid volume fraction hs/h."""
        return self.hs / self.h

    def mirrored(self) -> "TwoPhaseState":
        """Return the state as seen with the x axis turned round."""
        return TwoPhaseState(self.hs, self.hf, -self.vs, -self.vf)


@frozen
class Wave:
    """One wave of a self-similar solution.

    Attributes
    ----------
    family : number of the characteristic field, from 1 at the left.
    kind : ``"R"`` rarefaction fan, ``"S"`` shock, ``"C"`` contact; ``"RS"`` and ``"SR"`` are
        composites, named from left to right (a fan with a shock attached to it).
    head, tail : speeds of its left and of its right edge, m/s; equal for a shock or a contact.
    """

    family: int
    kind: str
    head: float
    tail: float


def finite_tuple(values: Sequence[float], names: str, where: str) -> tuple[float, ...]:
    """Return ``values`` as floats after checking that they are the finite numbers ``names``."""
    expected = names.split()
    wanted = f"({', '.join(expected)}), {len(expected)} numbers"
    if not isinstance(values, (list, tuple, np.ndarray)) or is_single(values):
        raise TypeError(f"`{where}` must hold {wanted}, but is {shown(values)}")
    if len(values) != len(expected):
        raise ValueError(f"`{where}` must hold {wanted}, but has {len(values)}, {shown(values)}")
    try:
        return tuple(real(value, f"{name} of {where}") for name, value in zip(expected, values, strict=True))
    except ValueError:
        raise ValueError(f"`{where}` must hold finite numbers ({', '.join(expected)}), but is {shown(values)}") from None


def density_ratio(gamma: float) -> float:
    """Return ``gamma`` after checking that it is a density ratio, fluid to solid, in (0, 1)."""
    return real(gamma, "gamma", above=0.0, below=1.0, hint="fluid density over solid density")


def two_phase_state(values: Sequence[float], where: str, dry: type[ValueError] = ValueError) -> TwoPhaseState:
    """Return the state (h, phi, vs, vf) in depths; negative depths raise ValueError, absent phases ``dry``."""
    h, phi, vs, vf = finite_tuple(values, "h phi vs vf", where)
    if h < 0.0 or not 0.0 <= phi <= 1.0:
        raise ValueError(f"`{where}` needs a depth h >= 0 and a solid fraction phi in [0, 1], got h = {h}, phi = {phi}")
    if h == 0.0 or phi in (0.0, 1.0):
        raise dry(f"dry state: `{where}` has h = {h}, phi = {phi}, but both phases must be present, h > 0 and 0 < phi < 1; "
                  "for dry beds with uniform phi and vs = vf use reduced_riemann")
    return TwoPhaseState(phi * h, (1.0 - phi) * h, vs, vf)


def similarity(x: ArrayLike, t: float, x0: float = 0.0) -> FloatArray:
    """Return (x - x0)/t; at t = 0 minus or plus infinity, which are the two initial states."""
    t = real(t, "t", at_least=0.0)
    distance = np.asarray(x, dtype=float) - x0
    return distance / t if t > 0.0 else np.where(distance < 0.0, -np.inf, np.inf)
