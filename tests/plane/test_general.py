"""General systems in the plane: a velocity with two components, sound, Burgers, gas dynamics with a vector of two rows."""

from typing import ClassVar

import attrs
import numpy as np
import pytest
from numpy.testing import assert_allclose

import fvkit as fv
import fvkit_granular as gr
from fvkit.problem.directions import component_names, observables
from fvkit.testing.common import BACKENDS


@attrs.frozen
class Gas(fv.Model):
    """Euler equations of an ideal gas, q = (rho, rho u, rho v, E); u is the velocity along the sweep."""

    conserved: ClassVar[tuple[str, ...]] = ("rho", "rho u", "rho v", "E")
    vectors: ClassVar[tuple[tuple[int, ...], ...]] = ((1, 2),)

    kappa: float = 1.4

    def pressure(self, q):
        rho, m, n, e = q
        return (self.kappa - 1.0) * (e - 0.5 * (m * m + n * n) / rho)

    def flux(self, q):
        rho, m, n, e = q
        u, p = m / rho, self.pressure(q)
        return m, m * u + p, n * u, (e + p) * u

    def wave_speeds(self, q):
        u, c = q[1] / q[0], np.sqrt(self.kappa * self.pressure(q) / q[0])
        return u - c, u + c


def box(n, length=1.0):
    return fv.Grid((0.0, 0.0), (length, length), (n, n))


def test_a_hump_that_is_carried_askew_is_of_second_order():
    def hump(t):
        return lambda x, y: [np.exp(-40.0 * (np.sin(np.pi * (x - t))**2 + np.sin(np.pi * (y - 0.5 * t))**2))]

    errors = []
    for n in (50, 100):
        problem = fv.Problem(fv.Advection((1.0, 0.5)), box(n), hump(0.0), 0.5, boundary=fv.Periodic())
        exact = fv.Problem(fv.Advection((1.0, 0.5)), box(n), hump(0.5), 0.5, boundary=fv.Periodic()).q0
        errors.append(np.abs(fv.solve(problem).q[-1] - exact).mean())
    assert np.log2(errors[0] / errors[1]) > 1.8


def test_advection_needs_a_velocity_for_each_axis():
    with pytest.raises(ValueError, match="`speed` of Advection must be a pair"):
        fv.Problem(fv.Advection(1.0), box(8), np.ones((1, 8, 8)), 1.0)


@pytest.mark.parametrize("azimuth", [0.0, np.arctan2(1.0, 2.0), 0.5 * np.pi])
def test_a_plane_wave_of_sound_travels_at_any_azimuth(azimuth):
    c, s = np.cos(azimuth), np.sin(azimuth)
    wave = 2.0 * np.pi * (np.sqrt(5.0) if 0.0 < azimuth < 1.5 else 1.0)

    def sound(t):
        def values(x, y):
            p = np.sin(wave * (c * x + s * y - t))
            return [p, c * p, s * p]

        return values

    model = fv.Acoustics()
    errors = []
    for n in (40, 80):
        problem = fv.Problem(model, box(n), sound(0.0), 0.25, boundary=fv.Periodic())
        exact = fv.Problem(model, box(n), sound(0.25), 0.25, boundary=fv.Periodic()).q0
        errors.append(np.abs(fv.solve(problem, fv.WavePropagation(fv.Roe(), limiter=fv.NoLimiter())).q[-1] - exact).mean())
    assert np.log2(errors[0] / errors[1]) > 1.9
    assert component_names(model, box(8)) == ("p", "u_x", "u_y")
    assert set(observables(model, box(8), np.ones((3, 8, 8)))) == {"p", "u_x", "u_y", "speed"}


def test_burgers_along_the_diagonal_is_burgers_on_a_line():
    """u(x + y) has u_t + 2 (u^2/2)_s = 0 with s = x + y."""
    n = 80
    plane = fv.Problem(fv.Burgers(), box(n), lambda x, y: [1.5 + np.sin(2.0 * np.pi * (x + y))], 0.05, boundary=fv.Periodic())
    line = fv.Problem(fv.Burgers(), fv.Grid(0.0, 1.0, 8 * n), lambda x: [1.5 + np.sin(2.0 * np.pi * x)], 0.1, boundary=fv.Periodic())
    along = fv.solve(line).q[-1][0]
    fine = np.interp(np.linspace(0.0, 1.0, n + 1) % 1.0, line.grid.centers, along, period=1.0)
    found = fv.solve(plane).q[-1][0]
    shifted = np.array([np.roll(found[j], j) for j in range(n)])
    assert np.ptp(shifted, axis=0).max() < 0.05
    assert np.abs(shifted.mean(axis=0) - fine[1:]).mean() < 0.03


@pytest.mark.parametrize("axis", [0, 1])
def test_a_shock_tube_of_gas_turned_with_its_momenta(axis):
    model, n = Gas(), 60

    def tube(along, across=0.0):
        rho = np.where(along < 0.5, 1.0, 0.125)
        p = np.where(along < 0.5, 1.0, 0.1)
        return [rho, 0.0 * rho, across * rho, p / 0.4 + 0.5 * rho * across**2]

    def in_the_plane(x, y):
        q = tube((x, y)[axis], 0.3)
        return q if axis == 0 else [q[0], q[2], q[1], q[3]]

    grid = fv.Grid((0.0, 0.0), [(1.0, 0.1), (0.1, 1.0)][axis], [(n, 3), (3, n)][axis])
    sides = {("south", "west")[axis]: fv.Periodic(), ("north", "east")[axis]: fv.Periodic()}
    scheme, step = fv.WavePropagation(fv.HLL()), fv.Step(dt=0.002)
    line = fv.solve(fv.Problem(model, fv.Grid(0.0, 1.0, n), lambda x: tube(x, 0.3), 0.1), scheme, step=step).q[-1]
    q = fv.solve(fv.Problem(model, grid, in_the_plane, 0.1, boundary=sides), scheme, step=step).q[-1]
    along = q[:, 1, :] if axis == 0 else q[[0, 2, 1, 3]][:, :, 1]
    assert_allclose(along[:2], line[:2], atol=1e-10)
    assert_allclose(along[3], line[3], atol=1e-10)


def test_a_quarter_plane_problem_of_gas_keeps_its_diagonal_symmetry():
    """A two-dimensional Riemann problem with four states, symmetric about its diagonal: up to the splitting error."""
    model, n = Gas(), 40

    def states(x, y):
        near = (x < 0.5).astype(int) + (y < 0.5).astype(int)
        rho, p = np.array([1.5, 0.5323, 0.138])[near], np.array([1.5, 0.3, 0.029])[near]
        u, v = np.where(x < 0.5, 1.206, 0.0), np.where(y < 0.5, 1.206, 0.0)
        return [rho, rho * u, rho * v, p / 0.4 + 0.5 * rho * (u * u + v * v)]

    q = fv.solve(fv.Problem(model, box(n), states, 0.2), fv.WavePropagation(fv.HLL())).q[-1]
    assert q[0].min() > 0.0
    assert np.abs(q[0] - q[0].T).mean() < 0.01 * q[0].mean()


def pyclaw_roe(q_l, q_r, aux_l, aux_r, problem_data):
    """Roe's solver for shallow water in PyClaw's form: arrays of one line of faces, whatever the grid."""
    (hl, ml), (hr, mr) = q_l, q_r
    h, dh, dm = 0.5 * (hl + hr), hr - hl, mr - ml
    v = (ml / np.sqrt(hl) + mr / np.sqrt(hr)) / (np.sqrt(hl) + np.sqrt(hr))
    c = np.sqrt(problem_data["grav"] * h)
    wave, s = np.empty((2, 2, q_l.shape[1])), np.array([v - c, v + c])
    wave[0, 0], wave[0, 1] = 0.5 * (s[1] * dh - dm) / c, 0.5 * (dm - s[0] * dh) / c
    wave[1] = s * wave[0]
    return wave, s, None, None


def test_a_solver_of_pyclaw_serves_two_axes_as_it_is():
    def dam(x, y):
        return [np.where(np.hypot(x - 5.0, y - 4.0) < 2.0, 2.0, 1.0), 0.0 * x, 0.0 * x]

    problem = fv.Problem(gr.ShallowWater(), fv.Grid((0.0, 0.0), (10.0, 8.0), (30, 24)), dam, 0.3, boundary=fv.Wall())
    solvers = (fv.PyClawRiemann(pyclaw_roe, {"grav": 9.81}), fv.Roe())
    found, wanted = (fv.solve(problem, fv.WavePropagation(solver), backend="numpy").q[-1] for solver in solvers)
    assert_allclose(found, wanted, atol=1e-13)


@attrs.frozen
class Pipe(fv.Model):
    """Isothermal gas of one axis, whose momentum a sweep along y would push along x."""

    conserved = ("rho", "m")

    def flux(self, q):
        rho, m = q
        return m, m * m / rho + rho

    def wave_speeds(self, q):
        u = q[1] / q[0]
        return u - 1.0, u + 1.0


@attrs.frozen
class Pair(Pipe):
    """The same law, said to hold no vector."""

    vectors: ClassVar[tuple[tuple[int, ...], ...]] = ()


def test_a_law_of_several_components_says_which_of_them_turn():
    plane, start = fv.Grid((0.0, 0.0), (1.0, 1.0), (4, 4)), lambda x, y: [1.0 + x, 0.0 * x]
    with pytest.raises(ValueError, match=r"Pipe has 2 components and does not say which .* set `vectors`"):
        fv.Problem(Pipe(), plane, start, 0.1)
    assert fv.Problem(Pair(), plane, start, 0.1).q0.shape == (2, 4, 4)
    assert fv.Problem(Pipe(), fv.Grid(0.0, 1.0, 4), lambda x: [1.0 + x, 0.0 * x], 0.1).q0.shape == (2, 4)


@attrs.frozen
class Dyed(fv.Model):
    """Shallow water with a dissolved mass, absent from half of the plane."""

    conserved: ClassVar[tuple[str, ...]] = ("h", "hc", "m")
    phases: ClassVar[tuple[fv.Phase, ...]] = (fv.Phase((1, 0), 2),)

    def flux(self, q):
        h, hc, m = q
        v = m / h
        return m, hc * v, m * v + 0.5 * 9.81 * h * h

    def wave_speeds(self, q):
        v, c = q[2] / q[0], np.sqrt(9.81 * q[0])
        return v - c, v + c


def test_rounding_in_a_mass_that_is_absent_does_not_reduce_the_corrections_of_the_others():
    def start(x, y):
        h = np.where(np.hypot(x, y) < 1.0, 2.0, 1.0)
        return [h, h * (x < 0.0), 0.0 * h, 0.0 * h]

    problem = fv.Problem(Dyed(), fv.Grid((-3.0, -3.0), (3.0, 3.0), (120, 120)), start, 0.25, boundary=fv.Wall())
    ends = [fv.solve(problem, fv.WavePropagation(fv.HLL()), backend=backend) for backend in BACKENDS]
    for solution in ends:
        assert_allclose(solution.q[-1].sum(axis=(1, 2)), problem.q0.sum(axis=(1, 2)), atol=1e-10)
    assert_allclose(ends[0].q[-1], ends[-1].q[-1], atol=1e-6)
