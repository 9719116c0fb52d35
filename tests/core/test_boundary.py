"""Boundary conditions: walls, rings, open ends and inflow."""

import numpy as np
import pytest

import fvkit as fv
import fvkit_granular as gr
from tests.cases import GRANULAR, SOLVERS, Stepper, Traffic, name_of, solve


def splash(model):
    def initial(x):
        h = 1.0 + 0.5 * np.exp(-200.0 * (x - 0.3) ** 2)
        return model.conserved_from(h, 0.4 + 0.2 * x, 0.3 * np.sin(np.pi * x), 0.2 * np.sin(np.pi * x))

    return initial


@pytest.mark.parametrize("order", [1, 2])
@pytest.mark.parametrize("riemann", SOLVERS, ids=name_of)
@pytest.mark.parametrize("model", GRANULAR, ids=name_of)
def test_walls_keep_every_mass(model, riemann, order):
    problem = fv.Problem(model, fv.Grid(0.0, 1.0, 60), splash(model), 0.5, {"b": lambda x: 0.2 * x}, fv.Wall())
    solution = solve(problem, fv.WavePropagation(riemann, order=order))
    for row in model.mass_rows():
        assert solution.q[-1, row].sum() == pytest.approx(solution.q[0, row].sum(), rel=1e-13)
    assert max(abs(drift) for drift in solution.stats.mass_drift.values()) < 1e-13


@pytest.mark.parametrize("order", [1, 2])
@pytest.mark.parametrize("riemann", SOLVERS, ids=name_of)
@pytest.mark.parametrize("model", [*GRANULAR, fv.Acoustics()], ids=name_of)
def test_a_wall_is_the_plane_of_symmetry_of_a_mirrored_problem(model, riemann, order):
    rng = np.random.default_rng(1)
    half = rng.uniform(0.8, 1.2, (len(model.conserved), 16))
    bottom = rng.uniform(0.0, 0.2, 16)
    signs = np.array(model.wall_signs())[:, None]
    doubled = np.concatenate([signs * half[:, ::-1], half], axis=1)
    aux = {"b": bottom} if model.aux else {}
    aux_doubled = {"b": np.concatenate([bottom[::-1], bottom])} if model.aux else {}
    scheme = fv.WavePropagation(riemann, order=order)
    walled = Stepper(
        fv.Problem(model, fv.Grid(0.0, 1.0, 16), half, 1.0, aux, fv.Wall()), scheme, nonhyperbolic="ignore"
    )
    whole = Stepper(
        fv.Problem(model, fv.Grid(-1.0, 1.0, 32), doubled, 1.0, aux_doubled, fv.Wall()), scheme, nonhyperbolic="ignore"
    )
    for _ in range(6):
        dt = min(walled.dt, whole.dt)
        assert walled.step(dt) == whole.step(dt)
    np.testing.assert_allclose(walled.q, whole.q[:, 16:], atol=2e-13)


def test_a_pulse_comes_back_from_a_wall_with_its_sign():
    def initial(x):
        pulse = np.exp(-200.0 * (x - 0.5) ** 2)
        return np.array([pulse, pulse])

    problem = fv.Problem(fv.Acoustics(), fv.Grid(0.0, 1.0, 200), initial, 1.0, boundary=fv.Wall())
    p, u = solve(problem, fv.WavePropagation(fv.Roe())).q[-1]
    np.testing.assert_allclose(p, problem.q0[0], atol=0.03)
    np.testing.assert_allclose(u, -problem.q0[1], atol=0.03)


@pytest.mark.parametrize("speed", [1.0, -1.0])
def test_a_ring_carries_a_pulse_once_round(speed):
    problem = fv.Problem(
        fv.Advection(speed),
        fv.Grid(0.0, 1.0, 64),
        lambda x: np.exp(-60.0 * (x - 0.9) ** 2)[None],
        1.0,
        boundary=fv.Periodic(),
    )
    exact = solve(problem, fv.WavePropagation(fv.Roe(), order=1, cfl=1.0)).q[-1]
    np.testing.assert_allclose(exact, problem.q0, atol=1e-12)


@pytest.mark.parametrize("riemann", SOLVERS, ids=name_of)
def test_a_ring_has_no_seam(riemann):
    def rolled(shift):
        q = np.roll(np.random.default_rng(2).uniform(0.5, 1.5, (4, 30)), shift, axis=1)
        problem = fv.Problem(gr.TwoPhase(), fv.Grid(0.0, 1.0, 30), q, 0.02, boundary=fv.Periodic())
        return solve(problem, fv.WavePropagation(riemann), nonhyperbolic="ignore").q[-1]

    np.testing.assert_array_equal(np.roll(rolled(0), 11, axis=1), rolled(11))


@pytest.mark.parametrize("order", [1, 2])
@pytest.mark.parametrize("riemann", SOLVERS, ids=name_of)
@pytest.mark.parametrize("model", GRANULAR, ids=name_of)
def test_open_ends_keep_rest_over_a_slope(model, riemann, order):
    def initial(x):
        return model.conserved_from(2.0 - 0.7 * x, 0.6)

    problem = fv.Problem(model, fv.Grid(0.0, 1.0, 40), initial, 0.5, {"b": lambda x: 0.7 * x})
    last = solve(problem, fv.WavePropagation(riemann, order=order)).q[-1]
    np.testing.assert_allclose(last, problem.q0, atol=1e-13)


def test_an_open_end_lets_a_pulse_out():
    problem = fv.Problem(
        fv.Advection(1.0), fv.Grid(0.0, 1.0, 100), lambda x: np.exp(-100.0 * (x - 0.5) ** 2)[None], 1.5
    )
    assert np.abs(solve(problem, fv.WavePropagation(fv.Roe())).q[-1]).max() < 1e-6


def test_an_inflow_fills_the_domain_with_its_state():
    problem = fv.Problem(
        fv.Advection(1.0), fv.Grid(0.0, 1.0, 50), np.zeros((1, 50)), 2.0, boundary=(fv.Inflow([3.0]), fv.Outflow())
    )
    np.testing.assert_allclose(solve(problem).q[-1], 3.0, atol=1e-12)


def test_an_inflow_lets_out_what_travels_outwards():
    problem = fv.Problem(
        fv.Advection(-1.0), fv.Grid(0.0, 1.0, 50), np.ones((1, 50)), 1.0, boundary=(fv.Inflow([3.0]), fv.Outflow())
    )
    np.testing.assert_array_equal(solve(problem).q[-1], 1.0)


@pytest.mark.parametrize("sides", [(fv.Periodic(), fv.Wall()), (fv.Outflow(), fv.Periodic())])
def test_one_periodic_side_is_refused(sides):
    with pytest.raises(ValueError, match=r"periodic boundary needs both sides"):
        fv.Problem(fv.Acoustics(), fv.Grid(0.0, 1.0, 10), np.ones((2, 10)), 1.0, boundary=sides)


def test_a_wall_for_a_model_that_does_not_say_what_it_reflects_is_refused():
    with pytest.raises(ValueError, match=r"Wall needs to know what Traffic reflects.*wall_signs"):
        fv.Problem(Traffic(), fv.Grid(0.0, 1.0, 10), np.ones((1, 10)), 1.0, boundary=fv.Wall())


def test_walls_reflect_the_momenta_that_the_phases_or_vectors_name():
    assert fv.Acoustics().wall_signs() == (1.0, -1.0)
    assert gr.TwoPhase().wall_signs() == (1.0, -1.0, 1.0, -1.0)
    assert gr.Reduced().wall_signs() == (1.0, 1.0, -1.0)
    assert gr.ShallowWater().wall_signs() == (1.0, -1.0)


def test_a_boundary_condition_of_the_user_works():
    class Fixed(fv.BoundaryCondition):
        """A clamped value, twice the nearest one at all times."""

        def ghost(self, model, q, values):
            (u,) = q
            return (2.0 * u,)

    problem = fv.Problem(
        fv.Advection(1.0), fv.Grid(0.0, 1.0, 4), np.ones((1, 4)), 1.0, boundary=(Fixed(), fv.Outflow())
    )
    stepper = Stepper(problem, fv.WavePropagation(fv.Roe(), order=1, cfl=1.0))
    stepper.step()
    assert stepper.q[0].tolist() == [2.0, 1.0, 1.0, 1.0]
