"""Models, states and references that several tests share."""

from functools import partial

import attrs
import numpy as np
from scipy.integrate import solve_ivp
from scipy.optimize import brentq

import fvkit as fv
import fvkit_granular as gr
from fvkit.pointwise import combine, scale
from fvkit.pointwise.part import Part

#: These tests are about the numerics, so they run on NumPy: quick, and without compilation.
solve, Stepper = partial(fv.solve, backend="numpy"), partial(fv.Stepper, backend="numpy")

SOLVERS = (fv.Roe(), fv.HLL(), fv.Rusanov())
LIMITERS = (fv.NoLimiter(), fv.Minmod(), fv.Superbee(), fv.MC(), fv.VanLeer(), fv.ThirdOrder())
GRANULAR = (gr.TwoPhase(), gr.Reduced(), gr.ShallowWater())


def name_of(value):
    """Short identifier of a part, for parametrised tests."""
    return type(value).__name__ if isinstance(value, (Part, fv.Scheme, fv.Splitting)) else None


@attrs.frozen
class Traffic(fv.Model):
    """Lighthill-Whitham traffic, u_t + (limit u (1 - u))_x = 0: no Roe decomposition, no matrix."""

    conserved = ("density",)

    limit: float = 1.0

    def flux(self, q):
        (u,) = q
        return (self.limit * u * (1.0 - u),)

    def wave_speeds(self, q):
        (u,) = q
        speed = self.limit * (1.0 - 2.0 * u)
        return speed, speed


@attrs.frozen
class PSystem(fv.Model):
    """Isothermal gas, rho_t + m_x = 0, m_t + (m^2/rho + c^2 rho)_x = 0: no Roe decomposition, no matrix."""

    conserved = ("rho", "m")

    c: float = 1.0

    def flux(self, q):
        rho, m = q
        return m, m * m / rho + self.c * self.c * rho

    def wave_speeds(self, q):
        rho, m = q
        return m / rho - self.c, m / rho + self.c


def averages(function, grid, rows=None):
    """Cell averages by an 8-point Gauss rule, independent of the package's."""
    nodes, weights = np.polynomial.legendre.leggauss(8)
    x = grid.centers[:, None] + 0.5 * grid.dx * nodes
    values = np.asarray(function(x.ravel()))
    return values.reshape(*values.shape[:-1], grid.num_cells, 8) @ (0.5 * weights)


def l1(grid, difference):
    """L1 norm of cell averages, summed over components."""
    return float(np.abs(difference).sum() * grid.dx)


def orders(errors):
    """Observed orders between successive refinements by two."""
    return np.log2(np.array(errors[:-1]) / np.array(errors[1:]))


def coarsen(q):
    """Averages on a grid of half as many cells."""
    return 0.5 * (q[..., ::2] + q[..., 1::2])


def burgers_exact(x, t, initial, slope):
    """Smooth solution of Burgers' equation before the shock, by Newton on the characteristics."""
    foot = np.array(x, dtype=float)
    for _ in range(60):
        foot = foot - (foot + t * initial(foot) - x) / (1.0 + t * slope(foot))
    return initial(foot)


def stoker(x, t, left, right, g=9.81):
    """Depth and velocity of the wet dam break at x = 0."""
    def mismatch(h):
        fan = 2.0 * (np.sqrt(g * left) - np.sqrt(g * h))
        return fan - (h - right) * np.sqrt(0.5 * g * (h + right) / (h * right))

    h = brentq(mismatch, right, left, xtol=1e-15)
    v = 2.0 * (np.sqrt(g * left) - np.sqrt(g * h))
    shock = v * h / (h - right)
    xi = np.asarray(x) / t
    head, tail = -np.sqrt(g * left), v - np.sqrt(g * h)
    fan = (2.0 * np.sqrt(g * left) - xi) / 3.0
    depth = np.select([xi < head, xi < tail, xi < shock], [left, fan * fan / g, h], right)
    speed = np.select([xi < head, xi < tail, xi < shock], [0.0, 2.0 / 3.0 * (np.sqrt(g * left) + xi), v], 0.0)
    return depth, speed


def simple_wave(x, t, g=9.81):
    """Depth of the smooth simple wave over h0 = 1 + bump, exact until t = 2.044; v = 2 (sqrt(g h) - sqrt(g))."""
    def h0(y):
        return 1.0 + 0.1 * np.exp(-(((y - 3.0) / 0.8) ** 2))

    x, y = np.asarray(x, dtype=float), np.array(x, dtype=float)
    for _ in range(60):
        h = h0(y)
        slope = -2.0 * (y - 3.0) / 0.64 * (h - 1.0)
        y = y - (y + t * (3.0 * np.sqrt(g * h) - 2.0 * np.sqrt(g)) - x) / (1.0 + 1.5 * t * np.sqrt(g / h) * slope)
    return h0(y)


def slip_over_bottom(x):
    """Primitive state hs, vs, hf, vf and bottom of the smooth periodic order test."""
    k = 2.0 * np.pi * x
    return (0.6 + 0.05 * np.sin(k), 0.3 + 0.1 * np.cos(k), 0.4 + 0.03 * np.cos(k), -0.2 + 0.1 * np.sin(k),
            0.1 * np.sin(k + 0.5))


def slip_over_bottom_conserved(x):
    """Conserved state of `slip_over_bottom`."""
    hs, vs, hf, vf, _ = slip_over_bottom(x)
    return np.array([hs, hs * vs, hf, hf * vf])


def two_phase_forces(dx, hs, ms, hf, mf, bx, g, gamma):
    """Rates of the momenta of the two-phase model, from its equations; ``dx`` differentiates."""
    return (-dx(ms * ms / hs + 0.5 * g * hs * hs + 0.5 * g * (1.0 - gamma) * hs * hf) - gamma * g * hs * dx(hf) - g * hs * bx,
            -dx(mf * mf / hf + 0.5 * g * hf * hf) - g * hf * dx(hs) - g * hf * bx)


def pitman_le_forces(dx, hs, ms, hf, mf, bx, g, gamma):
    """The same with the fluid momentum of Pitman and Le, from their equation for h vf."""
    solid, _ = two_phase_forces(dx, hs, ms, hf, mf, bx, g, gamma)
    h, vf = hs + hf, mf / hf
    whole = -dx(h * vf * vf + 0.5 * g * h * h) - g * h * bx
    acceleration = (whole + vf * (dx(ms) + dx(mf))) / h
    return solid, hf * acceleration - vf * dx(mf)


def two_layer_forces(dx, hs, ms, hf, mf, bx, g, gamma):
    """The same for two layers of water."""
    return (-dx(ms * ms / hs + 0.5 * g * hs * hs) - gamma * g * hs * dx(hf) - g * hs * bx,
            -dx(mf * mf / hf + 0.5 * g * hf * hf) - g * hf * dx(hs) - g * hf * bx)


def pseudo_spectral(t, modes=96, g=9.81, gamma=0.5, forces=two_phase_forces, initial=slip_over_bottom_conserved,
                    method="DOP853", rtol=1e-12, atol=1e-14):
    """Fourier coefficients (4, modes) of the solution on [0, 1] over the bottom of `slip_over_bottom`."""
    x = np.arange(modes) / modes
    k = 2j * np.pi * np.fft.fftfreq(modes, 1.0 / modes)
    k[modes // 2] = 0.0

    def dx(values):
        return np.fft.ifft(k * np.fft.fft(values)).real

    bx = dx(slip_over_bottom(x)[4])

    def rate(_, flat):
        hs, ms, hf, mf = flat.reshape(4, modes)
        solid, fluid = forces(dx, hs, ms, hf, mf, bx, g, gamma)
        return np.concatenate([-dx(ms), solid, -dx(mf), fluid])

    result = solve_ivp(rate, (0.0, t), initial(x).ravel(), method=method, rtol=rtol, atol=atol)
    return np.fft.fft(result.y[:, -1].reshape(4, modes)) / modes


def spectral_averages(coefficients, grid):
    """Exact cell averages on [0, 1] of a trigonometric polynomial."""
    modes = coefficients.shape[-1]
    k = np.fft.fftfreq(modes, 1.0 / modes)
    return ((coefficients * np.sinc(k * grid.dx)) @ np.exp(2j * np.pi * np.outer(k, grid.centers))).real


def rest_bottom(x):
    """A smooth hump and, at cell edges of any multiple of 20 cells on [0, 2], a step."""
    hump = np.where(np.abs(x - 1.5) < 0.1, 0.25 * (np.cos(10.0 * np.pi * (x - 1.5)) + 1.0), 0.0)
    return hump + np.where((x > 0.3) & (x < 0.8), 0.4, 0.0)


def random_states(count, seed, slowest=3.0):
    """q (4, count) of random two-phase states, depths .05 to 3 and velocities within +-slowest."""
    rng = np.random.default_rng(seed)
    hs, hf = rng.uniform(0.05, 3.0, (2, count))
    vs, vf = rng.uniform(-slowest, slowest, (2, count))
    return np.array([hs, hs * vs, hf, hf * vf])


@attrs.frozen
class Fading(fv.Source):
    """Turns the masses to no number at once: a run with it fails."""

    def step(self, model, q, aux, dt):
        return combine(1.0 + np.sqrt(-dt), q, 0.0, q)

    def rate(self, model, q, aux):
        return scale(0.0, q)
