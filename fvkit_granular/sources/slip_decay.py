"""Drag between the phases of one cell, in closed form: how the slip w = vf - vs decays.

Drag leaves hs, hf and the mixture momentum hs vs + gamma hf vf as they are, and changes the slip by

    dw/dt = -D K w,   K = h (hs + gamma hf)/(hs hf) = rho/(phi (1 - phi)).

Everything here is pointwise (scalars or arrays, branch-free) and shared by the drag sources and by the
exact drag solution, so that each formula exists once. Depths are only ever divided by depths: products of two
vanish below 1e-154 m. Derived by this project, checked against an ODE solver to 1e-11.
"""

import numpy as np

from fvkit.pointwise import maximum
from fvkit_granular.models.spectrum import FLOOR
from fvkit_granular.models.wet_dry import reciprocal


def exchange(hs, hf, gamma):
    """Return K of `drag_rate`, and the depths hs and hf over hs + gamma hf, with two divisions; 0 where both are absent."""
    whole = reciprocal(hs + hf)
    solid, fluid = hs * whole, hf * whole
    rho, product = maximum(solid + gamma * fluid, FLOOR), maximum(solid * fluid, FLOOR)
    both = 1.0 / (rho * product)
    return rho * rho * both, solid * (product * both), fluid * (product * both)


def drag_rate(hs, hf, gamma):
    """Return K = rho/(phi (1 - phi)), dimensionless: the slip decays at the rate D K, 1/s, for D in 1/s.

    K stays below 1e150: where a phase is absent no slip is left to decay.
    """
    return exchange(hs, hf, gamma)[0]


def decayed_slip(w, t, k0, k1, m):
    """Return the slip vf - vs, m/s, at time t >= 0 that started as w and obeys dw/dt = -(k0 + k1 |w|^m) w, m > 0.

    The rates k0 and k1 >= 0, 1/s and (m/s)^-m/s, are drag coefficients times `drag_rate`.
    """
    return w * decay(t, k0, k1 * np.abs(w) ** m, m)


def decay(t, k0, k1, m):
    """Return the share of the slip left at time t >= 0, r(0) = 1, dr/dt = -(k0 + k1 r^m) r, with rates >= 0, 1/s, and m > 0.

    exp(-k0 t) (1 + k1 (1 - exp(-m k0 t))/k0)^(-1/m); k0 = 0 and k1 = 0 are its limits.
    """
    k0 = k0 + FLOOR
    spent = -np.expm1(-m * k0 * t) / k0
    return np.exp(-k0 * t) * (1.0 + k1 * spent) ** (-1.0 / m)


def slip_momentum(hs, ms, hf, mf, gamma):
    """Return hs hf/(hs + gamma hf) (vf - vs): the momentum that the fluid loses, the solid gains gamma times, as it vanishes."""
    _, solid, fluid = exchange(hs, hf, gamma)
    return mf * solid - ms * fluid


def velocities_from_slip(hs, hf, vs, vf, w, gamma):
    """Return vs, vf with the slip w = vf - vs and the mixture momentum hs vs + gamma hf vf of the velocities given."""
    mass = hs + gamma * hf
    mean = (hs * vs + gamma * hf * vf) / mass
    return mean - gamma * hf / mass * w, mean + hs / mass * w
