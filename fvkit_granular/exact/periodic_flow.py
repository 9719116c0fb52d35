"""Smooth periodic flow of the full model, by a Fourier pseudo-spectral method: an independent way to the solution.

The equations of hs, hs vs, hf, hf vf are differentiated through their Fourier series and marched by an adaptive
Runge-Kutta method of order 8 to rounding. Spectral accuracy while the flow is smooth; no Riemann solver, no cells.
"""

from collections.abc import Callable, Mapping
from typing import Any, ClassVar

import numpy as np
from attrs import frozen
from scipy.integrate import solve_ivp

from fvkit.validation import function, real, whole
from fvkit.validation import interval as checked_interval
from fvkit_granular.exact.states import FloatArray, density_ratio
from fvkit_granular.models.quantities import over, whole_flow


@frozen(eq=False)
class PeriodicFlow:
    """A smooth periodic flow as Fourier series at one time.

    Attributes
    ----------
    lower, length : the interval, m.
    t : time, s.
    coefficients : (4, modes) of hs, hs vs, hf, hf vf.
    accuracy : largest difference of the four to the solution with two thirds of the modes, measured.
    kind : ``"self-converged"``.
    """

    kind: ClassVar[str] = "self-converged"
    lower: float
    length: float
    t: float
    coefficients: np.ndarray
    accuracy: float

    def at(self, x: Any, t: float) -> dict[str, FloatArray]:
        """Return ``h``, ``phi``, ``vs``, ``vf`` at the points ``x`` (any shape); ``t`` must be that of the flow."""
        if abs(t - self.t) > 1e-12 * max(1.0, self.t):
            raise ValueError(f"`t` must be that of the flow, {self.t:g} s, got {t:g}: call periodic_flow for another time")
        hs, ms, hf, mf = _values(self.coefficients, (np.asarray(x, dtype=float) - self.lower) / self.length)
        return {"h": hs + hf, "phi": hs / (hs + hf), "vs": ms / hs, "vf": mf / hf}


def periodic_flow(initial: Callable[[np.ndarray], Mapping[str, Any]], bottom: Callable[[np.ndarray], Any], t: float,
                  interval: tuple[float, float] = (0.0, 1.0), g: float = 9.81, gamma: float = 0.5,
                  modes: int = 96, drag: float = 0.0) -> PeriodicFlow:
    """Return the flow at time ``t``.

    Parameters
    ----------
    initial : x (m,) -> {h, phi, vs, vf}, smooth and periodic on ``interval``, both phases present.
    bottom : x (m,) -> height of the bottom, m, smooth and periodic.
    t : time, s, positive, before anything steepens into a shock.
    interval : (lower, upper), m.
    g, gamma : gravity, m/s^2; density ratio in (0, 1).
    modes : Fourier modes; ``accuracy`` of the result shows whether they suffice.
    drag : constant drag coefficient D, 1/s, >= 0; the march is explicit, so its time grows with D beyond 1e3.

    Raises
    ------
    ValueError
        If the solution is not resolved: it is too rough, or ``t`` too late.
    """
    time, count = real(t, "t", above=0.0), whole(modes, "modes", at_least=6)
    force = real(drag, "drag", at_least=0.0)
    function(initial, "initial", "x -> {h, phi, vs, vf}")
    function(bottom, "bottom", "x -> height")
    g, gamma = real(g, "g", above=0.0), density_ratio(gamma)
    lower, upper = checked_interval(interval, "interval")
    length = upper - lower
    fine, coarse = (_march(initial, bottom, time, lower, length, g, gamma, m, force) for m in (count, 2 * (count // 3)))
    x = np.linspace(0.0, 1.0, 4 * count, endpoint=False)
    accuracy = float(np.abs(_values(fine, x) - _values(coarse, x)).max())
    if not accuracy < 1e-3:
        raise ValueError(f"the flow is not resolved by {count} modes at t = {time:g} s (difference {accuracy:.1e}): take an "
                         "earlier time, more modes or a smoother flow")
    return PeriodicFlow(lower, length, time, fine, accuracy)


def _march(initial: Any, bottom: Any, t: float, lower: float, length: float, g: float, gamma: float, modes: int,
           drag: float) -> np.ndarray:
    """Return the coefficients (4, modes) at time t."""
    x = lower + length * np.arange(modes) / modes
    k = 2j * np.pi / length * np.fft.fftfreq(modes, 1.0 / modes)
    k[modes // 2] *= modes % 2  # the lone highest mode of an even number has no derivative

    def dx(values: np.ndarray) -> np.ndarray:
        return np.fft.ifft(k * np.fft.fft(values)).real

    slope = dx(over(x, bottom(x), "bottom(x)"))
    state = {name: over(x, value, name) for name, value in whole_flow(initial(x)).items()}
    hs, hf = state["h"] * state["phi"], state["h"] * (1.0 - state["phi"])

    def rate(_: float, flat: np.ndarray) -> np.ndarray:
        hs, ms, hf, mf = flat.reshape(4, modes)
        solid = -dx(ms * ms / hs + 0.5 * g * hs * (hs + (1.0 - gamma) * hf)) - g * hs * (gamma * dx(hf) + slope)
        fluid = -dx(mf * mf / hf + 0.5 * g * hf * hf) - g * hf * (dx(hs) + slope)
        force = drag * (hs + hf) * (mf / hf - ms / hs)
        return np.concatenate([-dx(ms), solid + gamma * force, -dx(mf), fluid - force])

    start = np.concatenate([hs, hs * state["vs"], hf, hf * state["vf"]])
    with np.errstate(all="ignore"):
        result = solve_ivp(rate, (0.0, t), start, method="DOP853", rtol=1e-12, atol=1e-14)
    end = result.y[:, -1] if result.success else np.full_like(start, np.nan)
    return np.fft.fft(end.reshape(4, modes)) / modes


def _values(coefficients: np.ndarray, s: np.ndarray) -> np.ndarray:
    """The Fourier series at ``s`` in units of the period, (4, *s.shape)."""
    modes = coefficients.shape[1]
    waves = np.exp(2j * np.pi * np.multiply.outer(np.fft.fftfreq(modes, 1.0 / modes), s))
    return np.tensordot(coefficients, waves, 1).real
