"""Sweeps along lines: one-dimensional problems, conservation, bounds, symmetry, order, both backends."""

import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal

import fvkit as fv
import fvkit_granular as gr
from fvkit.problem.directions import directions
from tests.plane.problems import CLOSED, MODELS, SOLVERS, rough, square, state, transposed, vortex

PAIRS = [(MODELS[k % 4], SOLVERS[(k + k // 4) % 4], 1 + k % 2) for k in range(8)]


def on_a_line(model, sources=()):
    def initial(x):
        return model.conserved_from(np.where(x < 5.0, 2.0, 0.5), 0.6, 0.3, 0.2)

    return initial, fv.Problem(model, fv.Grid(0.0, 10.0, 60), initial, 0.3, aux={"b": lambda x: 0.1 * np.sin(x)},
                               boundary=(fv.Wall(), fv.Outflow()), sources=sources)


@pytest.mark.parametrize(("model", "riemann", "order"), [(m, s, o) for m in MODELS[:3] for s in SOLVERS[:3] for o in (1, 2)])
@pytest.mark.parametrize("axis", [0, 1])
def test_what_varies_along_one_axis_is_the_run_on_a_line(model, riemann, order, axis):
    initial, line = on_a_line(model)
    lower, upper, count = (0.0, 0.0), [(10.0, 1.0), (1.0, 10.0)][axis], [(60, 4), (4, 60)][axis]
    grid = fv.Grid(lower, upper, count)
    rows = list(directions(model, grid)[axis].rows)

    def in_the_plane(x, y):
        q = np.zeros((len(rows) + len(model.phases), *x.shape))
        q[rows] = initial((x, y)[axis])
        return q

    sides = {"west": fv.Wall(), "south": fv.Wall(), ("north", "east")[axis]: fv.Wall()}
    plane = fv.Problem(model, grid, in_the_plane, 0.3, aux={"b": lambda x, y: 0.1 * np.sin((x, y)[axis])}, boundary=sides)
    scheme, step = fv.WavePropagation(riemann, order=order), fv.Step(dt=0.005)
    found = fv.solve(plane, scheme, step=step).q[-1]
    along = np.moveaxis(found[rows], 2 - axis, 1)
    assert_allclose(along, np.broadcast_to(fv.solve(line, scheme, step=step).q[-1][..., None], along.shape), atol=1e-13)
    assert not np.delete(found, rows, axis=0).any()


@pytest.mark.parametrize(("model", "riemann", "order"), PAIRS)
def test_masses_stay_in_a_closed_box_and_nothing_is_negative(model, riemann, order):
    grid = square(12)
    q, b = rough(model, grid)
    problem = fv.Problem(model, grid, q, 0.2, aux={"b": b}, boundary=CLOSED)
    solution = fv.solve(problem, fv.WavePropagation(riemann, order=order), nonhyperbolic="ignore")
    assert max(map(abs, solution.stats.mass_drift.values())) < 1e-13
    assert solution.q[-1][list(problem.mass_rows)].min() >= 0.0


@pytest.mark.parametrize("model", MODELS[1:])
def test_momenta_of_the_mixture_stay_on_a_flat_periodic_plane(model):
    if isinstance(model, gr.TwoLayer):
        pytest.skip("the momentum of two layers is conserved with their own densities, see its model")
    grid, rng = square(16), np.random.default_rng(1)
    q = state(model, rng.uniform(0.5, 2.0, grid.shape), 0.5, rng.uniform(-1, 1, (2, *grid.shape)), rng.uniform(-1, 1, (2, *grid.shape)))
    problem = fv.Problem(model, grid, q, 0.2, boundary=fv.Periodic())
    end = fv.solve(problem, fv.WavePropagation(gr.Relaxation())).q[-1]
    weights = {"TwoPhase": [(1, 1.0), (4, model.gamma)], "Reduced": [(2, 1.0)]}[type(model).__name__]
    for shift in (0, 1):
        before, after = (sum(weight * q[row + shift].sum() for row, weight in weights) for q in (problem.q0, end))
        assert abs(after - before) < 1e-12 * np.abs(problem.q0).sum()


@pytest.mark.parametrize("order", [1, 2])
@pytest.mark.parametrize("limiter", [fv.MC(), fv.Superbee(), fv.ThirdOrder()])
def test_a_velocity_across_has_no_new_extrema(order, limiter):
    model, grid, rng = gr.ShallowWater(dry=1e-30), square(40, m=4), np.random.default_rng(2)
    h = 10.0**rng.uniform(-3.0, 0.5, grid.shape[1])[None] * np.ones(grid.shape)
    u = rng.uniform(1.0, 2.0, grid.shape[1])[None] * np.ones(grid.shape)
    q = np.stack([h, h * rng.uniform(-10.0, 10.0, grid.shape[1]), h * u])
    stepper = fv.Stepper(fv.Problem(model, grid, q, 1.0, boundary=fv.Periodic()),
                         fv.WavePropagation(gr.Relaxation(), order=order, limiter=limiter))
    for _ in range(40):
        stepper.step()
        found = stepper.q[2] / stepper.q[0]
        assert found.min() >= 1.0 - 1e-13
        assert found.max() <= 2.0 + 1e-13


def test_steps_come_in_pairs_of_equal_length_and_outputs_after_them():
    problem, _ = vortex(20, t_end=0.1)
    lengths, ends = [], []

    def note(stepper):
        lengths.append(stepper.t - sum(lengths))
        ends.append(stepper.t)

    fv.solve(problem, times=[0.04, 0.1], observers=note)
    assert len(lengths) % 2 == 0
    assert_allclose(lengths[::2], lengths[1::2], rtol=1e-9)
    assert ends[-1] == 0.1
    assert (1 + ends.index(0.04)) % 2 == 0


def test_a_step_begins_along_y_for_the_transposed_problem():
    """xy of a problem is yx of its transpose, to the bit: one step of each kind."""
    grid, model = square(14), gr.TwoPhase()
    q, b = rough(model, grid, seed=3)
    step = fv.Step(dt=1e-3)
    first = fv.Stepper(fv.Problem(model, grid, q, 1.0, aux={"b": b}, boundary=CLOSED), step=step, nonhyperbolic="ignore")
    other = fv.Stepper(fv.Problem(model, grid, transposed(q), 1.0, aux={"b": b.T}, boundary=CLOSED), step=step,
                       nonhyperbolic="ignore")
    other._march.count[0] = 1
    first.step()
    other.step()
    assert_array_equal(transposed(first.q), other.q)


@pytest.mark.parametrize(("drift", "bound", "t_end"), [(0.0, 5.6e-4, 0.5), (1.0, 2.2e-3, 1.0)])
def test_a_vortex_keeps_its_shape_to_second_order(drift, bound, t_end):
    errors = []
    for n in (50, 100):
        problem, exact = vortex(n, drift, t_end)
        errors.append(np.abs(fv.solve(problem).q[-1] - exact)[1:].mean(axis=(1, 2)).sum())
    assert errors[-1] <= bound
    assert np.log2(errors[0] / errors[1]) > 1.9


@pytest.mark.parametrize(("model", "riemann", "order"), [(m, s, 1 + k % 2) for k, (m, s) in enumerate(
    (m, s) for m in MODELS[:3] for s in SOLVERS)])
def test_water_at_rest_stays_at_rest_among_islands(model, riemann, order):
    grid = square(16)
    x, y = np.meshgrid(*(axis.centers for axis in grid.axes))
    b = np.where((np.abs(x - 5.0) < 2.0) & (np.abs(y - 4.0) < 2.0), 3.0, 0.8 * np.sin(x) * np.cos(y))
    q = state(model, np.maximum(1.0 - b, 0.0), 0.6)
    stepper = fv.Stepper(fv.Problem(model, grid, q, 1e9, aux={"b": b}, boundary=CLOSED), fv.WavePropagation(riemann, order=order))
    stepper.run(1e9, 300)
    assert_allclose(stepper.q, q, atol=1e-13)


def test_what_serves_a_line_alone_says_so():
    grid = square(8)
    with pytest.raises(ValueError, match="PitmanLe serves one axis alone"):
        fv.Problem(gr.PitmanLe(), grid, np.ones((6, 8, 8)), 1.0)
    problem = fv.Problem(gr.ShallowWater(), grid, np.ones((3, 8, 8)), 1.0)
    with pytest.raises(ValueError, match="MethodOfLines serves a grid with one axis"):
        fv.solve(problem, fv.MethodOfLines(fv.HLL()))
    with pytest.raises(ValueError, match="rhs serves a grid with one axis"):
        fv.rhs(problem)
    with pytest.raises(ValueError, match="`background` serves a grid with one axis"):
        fv.Problem(gr.ShallowWater(), grid, np.ones((3, 8, 8)), 1.0, background=np.ones((3, 8, 8)))


@pytest.mark.parametrize("froude", [5.0, 10.0, 30.0])
def test_a_jump_that_stands_along_a_line_of_the_grid_stays_straight(froude):
    """Noise of 1e-6 of the momenta along it does not grow in 600 cell times."""
    nx, ny, rng = 80, 20, np.random.default_rng(0)
    u1, depth = froude * np.sqrt(9.81), 0.5 * (np.sqrt(1.0 + 8.0 * froude**2) - 1.0)
    ahead = np.arange(nx)[None] < nx // 2
    h, m = np.where(ahead, 1.0, depth) + np.zeros((ny, 1)), np.full((ny, nx), u1)
    q = np.stack([h, m, 1e-6 * u1 * h * rng.uniform(-1.0, 1.0, h.shape)])
    sides = {"west": fv.Inflow([1.0, u1, 0.0]), "east": fv.Inflow([depth, u1, 0.0]), "south": fv.Periodic(), "north": fv.Periodic()}
    problem = fv.Problem(gr.ShallowWater(), fv.Grid((0.0, 0.0), (80.0, 20.0), (nx, ny)), q, 600.0 / u1, boundary=sides)
    end = fv.solve(problem, fv.WavePropagation(gr.Relaxation())).q[-1]
    assert np.abs(end[2] / end[0]).max() < 1e-6 * u1
