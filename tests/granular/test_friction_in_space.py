"""Friction and drag that vary over the grid: flow and rest that they balance, both backends, and values that are refused."""

import numpy as np
import pytest

import fvkit as fv
import fvkit_granular as gr

G = 9.81
MODELS = (gr.ShallowWater(), gr.Reduced(), gr.TwoPhase())
SCHEME = fv.WavePropagation(gr.Relaxation())


def bottom(x):
    """A slope that grows from 0.2 to 0.6 over 10 m."""
    return -0.2 * x - 0.02 * x * x


def slope(x):
    return 0.2 + 0.04 * x


@pytest.mark.parametrize("solver", [gr.Relaxation(), fv.Roe(), fv.HLL(), fv.Rusanov()], ids=lambda solver: type(solver).__name__)
def test_friction_that_is_the_slope_everywhere_keeps_a_uniform_flow(solver, backend):
    """Where depth and speed are uniform, slope and friction balance cell by cell and face by face; the ends know of no slope."""
    problem = fv.Problem(gr.ShallowWater(), fv.Grid(0.0, 10.0, 200), lambda x: [np.ones_like(x), np.full_like(x, 2.0)], 0.3,
                         {"b": bottom}, sources=gr.CoulombFriction(slope))
    solution = fv.solve(problem, fv.WavePropagation(solver), backend=backend)
    away = slice(60, -60)  # from what the ends send
    np.testing.assert_allclose(solution.q[-1][:, away], problem.q0[:, away], rtol=1e-13)
    assert np.ptp(solution.q[-1][1]) > 1e-3


def test_a_roughness_that_follows_the_slope_keeps_a_uniform_flow(backend):
    """Manning's n^2 = slope h^(4/3)/v^2: n is that of a face only to second order, and so is the balance."""
    errors = []
    for cells in (100, 200):
        problem = fv.Problem(gr.ShallowWater(), fv.Grid(0.0, 10.0, cells), lambda x: [np.ones_like(x), np.full_like(x, 2.0)], 0.3,
                             {"b": bottom}, sources=gr.Manning(lambda x: 0.5 * np.sqrt(slope(x))))
        away = slice(3 * cells // 10, -3 * cells // 10)
        errors.append(np.abs(fv.solve(problem, SCHEME, backend=backend).q[-1] - problem.q0)[:, away].max())
    assert errors[1] < 1e-6
    assert np.log2(errors[0] / errors[1]) > 1.9


@pytest.mark.parametrize("model", MODELS, ids=lambda model: type(model).__name__)
def test_a_pile_rests_where_friction_holds_it_and_slides_where_it_does_not(model, backend):
    """Steeper than the friction of the right half alone: the left half, its angle included, stays to the last bit."""
    grid = fv.Grid(0.0, 20.0, 100)
    pile = model.conserved_from(np.maximum(1.0 - 0.4 * np.abs(np.abs(grid.centers - 10.0) - 5.0), 0.0), 1.0)
    # Without pores the load of grains in water is g (1 - gamma): they push with g.
    nu = np.where(grid.centers < 10.0, 1.5, 0.1)
    solution = fv.solve(fv.Problem(model, grid, pile, 0.5, sources=gr.CoulombFriction(nu)), SCHEME, backend=backend)
    np.testing.assert_array_equal(solution.q[-1][:, :45], pile[:, :45])
    assert np.abs(solution.q[-1][1 if len(pile) != 3 else 2, 55:]).max() > 0.05


@pytest.mark.parametrize("law", [gr.CoulombFriction(lambda x: 0.3 + 0.1 * np.sin(x)), gr.Manning(np.linspace(0.01, 0.1, 600)),
                                 gr.Voellmy(lambda x: 0.1 + 0.01 * x, lambda x, t: 500.0 + 10.0 * x + t)],
                         ids=["Coulomb", "Manning", "Voellmy"])
def test_both_backends_agree(law):
    pytest.importorskip("numba", reason="the compiled backend needs the extra `fast`")
    model = gr.TwoPhase()
    initial = model.conserved_from(np.where(np.arange(600) < 250, 1.0, 0.5), 0.6)
    problem = fv.Problem(model, fv.Grid(0.0, 10.0, 600), initial, 0.15, {"b": lambda x: -0.3 * x},
                         sources=(law, gr.ConstantDrag(lambda x: 2.0 + np.cos(x))))
    one, two = (fv.solve(problem, SCHEME, backend=backend).q[-1] for backend in ("numpy", "numba"))
    np.testing.assert_allclose(one, two, rtol=1e-12, atol=1e-12)


@pytest.mark.parametrize(("drag", "scheme"), [
    (gr.ConstantDrag, SCHEME), (gr.ConstantDrag, fv.MethodOfLines(fv.HLL())),
    (gr.ConstantDrag, fv.MethodOfLines(fv.HLL(), integrator=fv.ARK4())), (lambda D: gr.VelocityDrag(D, D), SCHEME),
    (lambda D: gr.PitmanLeDrag(D, D), SCHEME)], ids=["constant", "constant-lines", "constant-implicit", "velocity", "Pitman-Le"])
def test_a_field_that_is_constant_is_a_number(drag, scheme, backend):
    """The field takes another way through the code, with the same result, for every integrator."""
    model, x = gr.TwoPhase(), np.linspace(0.0, 1.0, 40)
    initial = model.conserved_from(1.0 + 0.1 * np.sin(2.0 * np.pi * x), 0.4, 1.0, 0.5)
    problem = fv.Problem(model, fv.Grid(0.0, 1.0, 40), initial, 0.02, boundary=fv.Periodic(), sources=drag(0.7))
    one = fv.solve(problem, scheme, backend=backend).q[-1]
    for field in (np.full(40, 0.7), lambda x, t: np.full_like(x, 0.7)):
        other = fv.Problem(model, problem.grid, initial, 0.02, boundary=fv.Periodic(), sources=drag(field))
        np.testing.assert_allclose(fv.solve(other, scheme, backend=backend).q[-1], one, rtol=1e-12)


def test_friction_by_averages_goes_on_from_its_file_alone(tmp_path, backend):
    """Averages stand in the checkpoint; a function must be given again."""
    file, model = tmp_path / "friction.npz", gr.ShallowWater()
    initial = model.conserved_from(np.where(np.arange(50) < 20, 1.0, 0.2))
    problem = fv.Problem(model, fv.Grid(0.0, 10.0, 50), initial, 1.0, sources=gr.CoulombFriction(np.linspace(0.1, 0.5, 50)))
    whole = fv.solve(problem, backend=backend)
    with pytest.raises(fv.SolveError):
        fv.solve(problem, backend=backend, checkpoint=fv.Checkpoint(file), limits=fv.Limits(steps=10))
    np.testing.assert_array_equal(fv.resume(file).q[-1], whole.q[-1])


def test_rain_in_space_and_time_is_what_it_says(backend):
    """A point source and a shower: each place gets its own, in total what the books say."""
    grid, model = fv.Grid(0.0, 10.0, 50), gr.ShallowWater()
    shower = gr.Rain(lambda x, t: 1e-3 * t * (1.0 + 0.0 * x))
    spring = gr.Rain(np.where(np.arange(50) == 20, 0.1 / grid.dx, 0.0))  # 0.1 m^2/s
    problem = fv.Problem(model, grid, model.conserved_from(np.full(50, 0.5)), 2.0, boundary=fv.Wall(), sources=(shower, spring))
    solution = fv.solve(problem, backend=backend)
    entered = solution.stats.entered_by_sources["h"]
    np.testing.assert_allclose(entered, 0.2 + 10.0 * 1e-3 * 2.0, rtol=1e-12)  # linear in time: exact at the middle of steps
    np.testing.assert_allclose(solution.q[-1, 0].sum() * grid.dx, 5.0 + entered, rtol=1e-13)
    assert abs(solution.stats.mass_drift["h"]) < 1e-13


def test_values_outside_of_the_range_name_cell_and_place():
    grid, model = fv.Grid(0.0, 10.0, 10), gr.ShallowWater()

    def problem(source):
        return fv.Problem(model, grid, model.conserved_from(np.ones(10)), 1.0, sources=source)

    with pytest.raises(ValueError, match=r"`nu` must be finite and >= 0 and <= 5.67, got -0.4.* in cell 9 at x = 9.5"):
        problem(gr.CoulombFriction(lambda x: 0.5 - 0.1 * x))
    with pytest.raises(ValueError, match=r"`nu\[2\]` must be finite and >= 0 and <= 5.67, got 35.0 \(the tangent of the friction"):
        gr.CoulombFriction([0.4, 0.5, 35.0])
    with pytest.raises(ValueError, match=r"`xi` must be finite and > 0, got 0.0"):
        problem(gr.Voellmy(0.2, lambda x: 0.0 * x))
    with pytest.raises(ValueError, match=r"`n of Manning` must have shape \(10,\), got \(3,\)"):
        problem(gr.Manning([0.1, 0.1, 0.1]))
    with pytest.raises(TypeError, match=r"`nu` must be a number, got 'steep'"):
        gr.CoulombFriction("steep")


@pytest.mark.parametrize("n", [0.05, lambda x: 0.05 + 0.0 * x, lambda x, t: 0.025 * t + 0.0 * x], ids=["number", "of x", "of x and t"])
def test_rates_of_the_scheme_have_friction_that_acts_with_the_transport(n):
    """dq/dt of a uniform flow is the friction alone, at the time that is asked for."""
    problem = fv.Problem(gr.ShallowWater(), fv.Grid(0.0, 10.0, 10), np.array([[1.0] * 10, [2.0] * 10]), 1.0, boundary=fv.Periodic(),
                         sources=gr.Manning(n))
    np.testing.assert_allclose(fv.rhs(problem, SCHEME)(2.0, problem.q0), [[0.0] * 10, [-G * 0.05**2 * 4.0] * 10], rtol=1e-12)


def test_a_background_and_friction_that_varies_serve_together(backend):
    """The rows of friction stand between those of the model and those of the background: a field that is constant is a number."""
    def flow(x):
        return [np.ones_like(x), np.full_like(x, 0.5)]

    def wave(x):
        return [1.0 + 0.1 * np.exp(-(x - 5.0) ** 2), np.full_like(x, 0.5)]

    runs = []
    for n in (0.03, lambda x: 0.03 + 0.0 * x):
        problem = fv.Problem(gr.ShallowWater(), fv.Grid(0.0, 10.0, 60), wave,
                             0.2, {"b": lambda x: 0.1 * np.sin(x)}, sources=gr.Manning(n), background=flow)
        runs.append(fv.solve(problem, SCHEME, backend=backend).q[-1])
    np.testing.assert_allclose(*runs, rtol=1e-12)
