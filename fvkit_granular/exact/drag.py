"""Drag alone: uniform two-phase states whose slip decays in time.

Exact: uniform depths stay uniform on a bottom of constant height, the mixture momentum is conserved, and
the slip w = vf - vs obeys an ordinary differential equation with a closed solution. Derived by this
project, checked against an ODE solver to 1e-11.
"""

from typing import ClassVar

import numpy as np
from attrs import frozen
from numpy.typing import ArrayLike

from fvkit.validation import field, number
from fvkit_granular.exact.states import FloatArray, TwoPhaseState, density_ratio, two_phase_state
from fvkit_granular.sources.slip_decay import decayed_slip, drag_rate, velocities_from_slip


@frozen
class UniformDrag:
    """Uniform state whose slip w = vf - vs decays under the drag coefficient D(w) = d0 + d1 |w|^m.

    Parameters
    ----------
    initial : the state at time 0, (h, phi, vs, vf): h > 0 in m, phi in (0, 1), velocities in m/s; kept as a `TwoPhaseState`.
    d0, d1 : drag coefficients >= 0, 1/s and (m/s)^-m/s, already divided by the fluid density.
    m : exponent > 0.
    gamma : density ratio in (0, 1).

    Notes
    -----
    dw/dt = -D(w) K w with K = h (hs + gamma hf)/(hs hf).
    """

    kind: ClassVar[str] = "exact"
    initial: TwoPhaseState = field(two_phase_state)
    d0: float = number(0.0, at_least=0.0)
    d1: float = number(0.0, at_least=0.0)
    m: float = number(1.0, above=0.0)
    gamma: float = field(density_ratio, 0.5)

    def slip(self, t: ArrayLike) -> FloatArray:
        """Return the slip w = vf - vs at the times ``t`` >= 0, of the same shape."""
        times = np.asarray(t, dtype=float)
        if not np.all(times >= 0.0):
            raise ValueError(f"`t` must be >= 0 everywhere, but holds {np.min(times)}")
        rate = drag_rate(self.initial.hs, self.initial.hf, self.gamma)
        return decayed_slip(self.initial.vf - self.initial.vs, times, self.d0 * rate, self.d1 * rate, self.m)

    def at(self, t: ArrayLike) -> dict[str, FloatArray]:
        """Return ``h``, ``phi``, ``vs``, ``vf`` at the times ``t`` >= 0, each of the shape of ``t``."""
        w = self.slip(t)
        vs, vf = velocities_from_slip(*self.initial, w, self.gamma)
        return {"h": np.full_like(w, self.initial.h), "phi": np.full_like(w, self.initial.phi), "vs": vs, "vf": vf}
