"""Advection, Burgers and acoustics against their exact solutions."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import fvkit as fv
from tests.cases import LIMITERS, SOLVERS, averages, burgers_exact, l1, name_of, orders, solve

speeds = st.floats(-10.0, 10.0)
values = st.floats(-10.0, 10.0)


def advect(cells, limiter, order=2, speed=1.0, cfl=0.8, riemann=None):
    def wave(x):
        return np.sin(2.0 * np.pi * x)[None] + 0.5 * np.cos(4.0 * np.pi * x)

    grid = fv.Grid(0.0, 1.0, cells)
    problem = fv.Problem(fv.Advection(speed), grid, wave, 0.5, boundary=fv.Periodic())
    scheme = fv.WavePropagation(riemann or fv.Roe(), limiter, order, cfl)
    exact = averages(lambda x: wave(x - 0.5 * speed), grid)
    return l1(grid, solve(problem, scheme).q[-1] - exact)


@pytest.mark.parametrize("riemann", SOLVERS, ids=name_of)
@pytest.mark.parametrize("speed", [1.0, -0.7])
def test_unlimited_advection_is_second_order(speed, riemann):
    assert orders([advect(n, fv.NoLimiter(), speed=speed, riemann=riemann) for n in (50, 100, 200)]).min() > 1.95


def test_upwind_advection_is_first_order():
    measured = orders([advect(n, fv.MC(), 1) for n in (100, 200, 400)])
    assert 0.85 < measured.min() <= measured.max() < 1.1


def test_advection_with_the_default_limiter_is_second_order():
    assert orders([advect(n, fv.MC()) for n in (50, 100, 200)]).min() > 1.85


def third_order_errors(speed, limiter):
    """L1 errors on N = 40 .. 320 of an advected sine: everywhere, and where it is steep."""
    def sine(x):
        return np.sin(2.0 * np.pi * (x - 0.4 * speed))

    everywhere, steep = [], []
    for cells in (40, 80, 160, 320):
        grid = fv.Grid(0.0, 1.0, cells)
        problem = fv.Problem(
            fv.Advection(speed), grid, lambda x: np.sin(2.0 * np.pi * x)[None], 0.4, boundary=fv.Periodic()
        )
        error = solve(problem, fv.WavePropagation(fv.Roe(), limiter, cfl=0.8)).q[-1, 0] - averages(sine, grid)
        everywhere.append(l1(grid, error))
        steep.append(l1(grid, error[np.abs(averages(sine, grid)) < 0.7]))
    return everywhere, steep


@pytest.mark.parametrize("speed", [1.0, -0.7])
def test_the_third_order_limiter_exceeds_order_two_and_a_half_on_smooth_advection(speed):
    everywhere, steep = third_order_errors(speed, fv.ThirdOrder())
    assert orders(everywhere).mean() > 2.5
    assert orders(steep).mean() > 2.9


def test_the_third_order_limiter_beats_the_default_on_smooth_advection():
    third, default = third_order_errors(1.0, fv.ThirdOrder())[0], third_order_errors(1.0, fv.MC())[0]
    assert third[-1] < 0.2 * default[-1]


@pytest.mark.parametrize("limiter", [limiter for limiter in LIMITERS if limiter.limits], ids=name_of)
def test_limited_advection_of_a_box_makes_no_new_extrema(limiter):
    problem = fv.Problem(fv.Advection(1.0), fv.Grid(0.0, 1.0, 50), lambda x: 1.0 * (np.abs(x - 0.5) < 0.2)[None], 1.0,
                         boundary=fv.Periodic())
    last = solve(problem, fv.WavePropagation(fv.Roe(), limiter, cfl=0.7)).q[-1, 0]
    assert -1e-13 <= last.min() <= last.max() <= 1.0 + 1e-13
    assert np.abs(np.diff(last, append=last[0])).sum() <= 2.0 + 1e-12


def test_unlimited_advection_of_a_box_overshoots():
    problem = fv.Problem(fv.Advection(1.0), fv.Grid(0.0, 1.0, 50), lambda x: 1.0 * (np.abs(x - 0.5) < 0.2)[None], 1.0,
                         boundary=fv.Periodic())
    assert solve(problem, fv.WavePropagation(fv.Roe(), fv.NoLimiter(), cfl=0.7)).q[-1].max() > 1.05


def wave(x):
    return 0.5 + np.sin(2.0 * np.pi * x)


def slope(x):
    return 2.0 * np.pi * np.cos(2.0 * np.pi * x)


@pytest.mark.parametrize("riemann", SOLVERS, ids=name_of)
def test_burgers_before_the_shock_is_second_order_through_a_sonic_point(riemann):
    errors = []
    for cells in (80, 160, 320):
        grid = fv.Grid(0.0, 1.0, cells)
        problem = fv.Problem(fv.Burgers(), grid, lambda x: wave(x)[None], 0.08, boundary=fv.Periodic())
        solution = solve(problem, fv.WavePropagation(riemann, fv.NoLimiter()))
        errors.append(l1(grid, solution.q[-1, 0] - averages(lambda x: burgers_exact(x, 0.08, wave, slope), grid)))
    assert orders(errors).min() > 1.85


@pytest.mark.parametrize("riemann", SOLVERS, ids=name_of)
@pytest.mark.parametrize(
    ("left", "right"), [(2.0, 0.5), (1.0, -0.5), (-0.5, -1.5), (1.0, 2.0), (-1.0, 1.0), (-2.0, -1.0)]
)
def test_burgers_riemann_problems_tend_to_their_entropy_solution(left, right, riemann):
    def exact(x):
        if left > right:
            return np.where(x < 0.5 * (left + right) * 0.3, left, right)
        return np.clip(x / 0.3, left, right)

    grid = fv.Grid(-1.0, 1.0, 200)
    problem = fv.Problem(fv.Burgers(), grid, lambda x: np.where(x < 0.0, left, right)[None], 0.3)
    last = solve(problem, fv.WavePropagation(riemann)).q[-1, 0]
    assert l1(grid, last - averages(exact, grid)) < 0.012


@pytest.mark.parametrize("riemann", SOLVERS, ids=name_of)
def test_acoustics_is_second_order_with_its_own_speed_and_impedance(riemann):
    rho, bulk = 2.0, 3.0
    c, impedance = np.sqrt(bulk / rho), np.sqrt(bulk * rho)

    def exact(x, t):
        left, right = np.sin(2.0 * np.pi * (x + c * t)), 0.3 * np.cos(2.0 * np.pi * (x - c * t))
        return np.array([-impedance * left + impedance * right, left + right])

    errors = []
    for cells in (50, 100, 200):
        grid = fv.Grid(0.0, 1.0, cells)
        problem = fv.Problem(fv.Acoustics(rho, bulk), grid, lambda x: exact(x, 0.0), 0.4, boundary=fv.Periodic())
        last = solve(problem, fv.WavePropagation(riemann, fv.NoLimiter())).q[-1]
        errors.append(l1(grid, last - averages(lambda x: exact(x, 0.4), grid)))
    assert orders(errors).min() > 1.95


@settings(max_examples=50)
@given(left=values, right=values)
def test_the_roe_speed_of_burgers_satisfies_the_jump_condition(left, right):
    model = fv.Burgers()
    jump = model.jump((left,), (right,), (), ())
    ((wave,),), (speed,) = model.decompose((left,), (right,), (), (), jump)
    assert wave == jump[0]
    assert speed * (right - left) == pytest.approx(wave, abs=1e-12)


@settings(max_examples=50)
@given(speed=speeds, left=values, right=values)
def test_the_wave_of_advection_is_the_jump_with_its_speed(speed, left, right):
    model = fv.Advection(speed)
    ((wave,),), (found,) = model.decompose((left,), (right,), (), (), model.jump((left,), (right,), (), ()))
    assert found == speed
    assert wave == pytest.approx(speed * (right - left), abs=1e-12)


@settings(max_examples=50)
@given(rho=st.floats(0.1, 10.0), bulk=st.floats(0.1, 10.0), jump=st.tuples(values, values))
def test_the_waves_of_acoustics_are_eigenvectors_that_add_up(rho, bulk, jump):
    waves, found = fv.Acoustics(rho, bulk).decompose((), (), (), (), jump)
    np.testing.assert_allclose(np.sum(waves, axis=0), jump, atol=1e-12)
    matrix = np.array([[0.0, bulk], [1.0 / rho, 0.0]])
    for wave_k, speed in zip(waves, found, strict=True):
        np.testing.assert_allclose(matrix @ wave_k, speed * np.array(wave_k), atol=1e-10)


def test_models_describe_themselves():
    assert fv.Acoustics(2.0, 3.0).parameters() == (2.0, 3.0)
    assert fv.Acoustics.parameter_names() == ("rho", "bulk")
    assert fv.Burgers.defines("decompose")
    assert not fv.Burgers.defines("cross")
    assert not fv.Burgers.defines("jump")
