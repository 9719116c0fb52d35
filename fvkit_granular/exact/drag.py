"""Drag alone: uniform two-phase states whose slip decays in time.

Exact: uniform depths stay uniform on a bottom of constant height, the mixture momentum is conserved, and
the slip w = vf - vs obeys an ordinary differential equation with a closed solution. Derived by this
project, checked against an ODE solver to 1e-11.
"""

from collections.abc import Sequence
from typing import ClassVar

import numpy as np
from attrs import frozen
from numpy.typing import ArrayLike

from fvkit.validation import real
from fvkit_granular.exact.states import FloatArray, TwoPhaseState, density_ratio, two_phase_state
from fvkit_granular.sources.slip_decay import decayed_slip, drag_rate, velocities_from_slip


@frozen
class UniformDrag:
    """Uniform state under the drag coefficient D(w) = d0 + d1 |w|^m.

    Attributes
    ----------
    initial : the state at time 0, `TwoPhaseState`.
    rate : K = h (hs + gamma hf)/(hs hf), so that dw/dt = -D(w) K w.
    d0, d1, m, gamma : as given.
    kind : ``"exact"``.
    """

    kind: ClassVar[str] = "exact"
    initial: TwoPhaseState
    d0: float
    d1: float
    m: float
    gamma: float
    rate: float

    def slip(self, t: ArrayLike) -> FloatArray:
        """Return w = vf - vs at the times ``t`` >= 0, of the same shape."""
        times = np.asarray(t, dtype=float)
        if not np.all(times >= 0.0):
            raise ValueError(f"`t` must be >= 0 everywhere, but holds {np.min(times)}")
        w = self.initial.vf - self.initial.vs
        return decayed_slip(w, times, self.d0 * self.rate, self.d1 * self.rate, self.m)

    def at(self, t: ArrayLike) -> dict[str, FloatArray]:
        """Return ``h``, ``phi``, ``vs``, ``vf`` at the times ``t`` >= 0, each of the shape of ``t``."""
        w = self.slip(t)
        vs, vf = velocities_from_slip(*self.initial, w, self.gamma)
        return {"h": np.full_like(w, self.initial.h), "phi": np.full_like(w, self.initial.phi), "vs": vs, "vf": vf}


def uniform_drag(state: Sequence[float], d0: float = 0.0, d1: float = 0.0, m: float = 1.0, gamma: float = 0.5) -> UniformDrag:
    """Return the exact decay of the slip of a uniform state under D = d0 + d1 |vf - vs|^m.

    Parameters
    ----------
    state : (h, phi, vs, vf), h > 0 in m, phi in (0, 1), velocities in m/s.
    d0, d1 : drag coefficients >= 0, 1/s and (m/s)^-m/s, already divided by the fluid density.
    m : exponent > 0.
    gamma : density ratio in (0, 1).

    Returns
    -------
    UniformDrag, whose ``at(t)`` gives the velocities and ``slip(t)`` their difference.

    Raises
    ------
    ValueError
        For values that are no state, or a negative coefficient.
    """
    gamma = density_ratio(gamma)
    d0, d1, m = real(d0, "d0", at_least=0.0), real(d1, "d1", at_least=0.0), real(m, "m", above=0.0)
    initial = two_phase_state(state, "state")
    return UniformDrag(initial, d0, d1, m, gamma, drag_rate(initial.hs, initial.hf, gamma))
