"""Sides of a grid with two axes: conditions of their own, parts of a side, inflow, levels, periodic axes."""

import numpy as np
import pytest
from numpy.testing import assert_allclose

import fvkit as fv
import fvkit_granular as gr
from tests.plane.problems import CLOSED, square, state


def flat(model, n=16, h=1.0, boundary=None, t_end=0.5, **more):
    grid = square(n)
    return fv.Problem(model, grid, state(model, np.full(grid.shape, h), 0.6), t_end, boundary=boundary or CLOSED, **more)


@pytest.mark.parametrize("side", ["west", "east", "south", "north"])
@pytest.mark.parametrize("model", [gr.ShallowWater(dry=1e-8), gr.TwoPhase(dry=1e-8)])
def test_a_hydrograph_through_a_gap_lets_in_exactly_its_discharge(model, side):
    gate = fv.Along(4.0, 6.0, gr.Hydrograph([0.0], [0.5], [0.4]))
    problem = flat(model, n=20, h=0.0, boundary={**CLOSED, side: gate}, t_end=2.0)
    solution = fv.solve(problem, step=fv.Step(dt_max=0.02), nonhyperbolic="ignore")
    total = solution.q[-1][list(problem.mass_rows)].sum() * problem.grid.cell_volume
    assert_allclose(total, 0.5 * 2.0 * 2.0, rtol=1e-13)
    assert max(map(abs, solution.stats.mass_drift.values())) < 1e-13
    assert solution.q[-1][list(problem.mass_rows)].min() >= 0.0


def test_a_stream_that_enters_askew_brings_its_momentum_along_the_side():
    model = gr.ShallowWater(dry=1e-8)
    problem = flat(model, h=0.0, boundary={"west": fv.Inflow([1.0, 6.0, 2.0]), "south": fv.Periodic(), "north": fv.Periodic()}, t_end=4.0)
    q = fv.solve(problem, step=fv.Step(dt_max=0.05)).q[-1]
    assert_allclose(q[:, :, :8], np.broadcast_to(np.array([1.0, 6.0, 2.0])[:, None, None], (3, 16, 8)), rtol=1e-6)


@pytest.mark.parametrize("comes", [[1.0, 3.0, 0.0], lambda t: [1.0, 3.0, 0.0]], ids=["constant", "function of time"])
def test_a_side_may_be_faster_than_its_waves_in_some_of_its_cells_alone(comes):
    """Gravity along ground of 45 degrees has half of its size: 3 m/s is fast there, and slow on level ground."""
    model = gr.ShallowWater(dry=1e-6, slope="steep")
    grid = fv.Grid((0.0, 0.0), (100.0, 40.0), (25, 10))
    problem = fv.Problem(model, grid, state(model, np.zeros(grid.shape), 0.5), 1.0,
                         aux={"b": lambda x, y: np.where(y < 20.0, -x, 0.0)}, boundary={**CLOSED, "west": fv.Inflow(comes)})
    stepper = fv.Stepper(problem, fv.WavePropagation(gr.Relaxation()), step=fv.Step(dt=0.05), backend="numpy")
    stepper.step()
    assert_allclose(stepper.q[0].sum(axis=1)[:4] * 4.0, 3.0 * 0.05, rtol=1e-9)  # the fifth has a neighbour on level ground
    assert (stepper.q[0].sum(axis=1)[6:] * 4.0 > 3.0 * 0.05).all()  # and the wave that runs out of there brings more


def test_an_inflow_states_momenta_along_both_axes():
    with pytest.raises(ValueError, match=r"`state` of Inflow must have 3 components \(h, h v_x, h v_y\), got 2"):
        flat(gr.ShallowWater(), boundary={"west": fv.Inflow([1.0, 6.0])})


@pytest.mark.parametrize("order", [1, 2])
@pytest.mark.parametrize("riemann", [fv.Roe(), fv.HLL(), fv.Rusanov(), gr.Relaxation()])
def test_a_jet_that_spreads_along_its_wall_is_no_faster_than_a_dam_break(riemann, order):
    """What parts from the wall faster than sound left its momentum behind with Roe, and the sweep along the wall brought more."""
    model, h, v, grid = gr.TwoPhase(), 4.6, 7.2, fv.Grid((0.0, 0.0), (1.0, 1.0), (14, 10))
    jet = fv.Inflow(state(model, h, 0.9, vy=(v, v)))
    problem = fv.Problem(model, grid, np.zeros((6, *grid.shape)), 0.06, boundary={"south": fv.Along(0.3, 0.7, jet)},
                         sources=gr.CoulombFriction(1.0))
    fastest = []

    def look(stepper):
        for mass, along_x, along_y in np.split(stepper.q, 2):
            wet = mass > 1e-9
            fastest.append((np.hypot(along_x, along_y)[wet] / mass[wet]).max())

    fv.solve(problem, fv.WavePropagation(riemann, order=order), observers=look, nonhyperbolic="ignore")
    assert v < max(fastest) < v + 2.0 * np.sqrt(model.g * h)


@pytest.mark.parametrize("side", ["west", "north"])
def test_a_lake_at_a_side_keeps_water_of_its_level_at_rest(side):
    grid, model = square(12), gr.ShallowWater()
    b = 0.2 * np.random.default_rng(0).uniform(size=grid.shape)
    problem = fv.Problem(model, grid, state(model, 1.0 - b, 1.0), 5.0, aux={"b": b}, boundary={**CLOSED, side: gr.FixedLevel(1.0)})
    assert_allclose(fv.solve(problem).q[-1], problem.q0, atol=1e-13)


def test_a_river_runs_through_with_slopes_that_go_on():
    model, s = gr.ShallowWater(), 0.01
    grid = fv.Grid((0.0, 0.0), (100.0, 20.0), (50, 10))
    v = np.sqrt(s) / 0.03
    problem = fv.Problem(model, grid, state(model, np.ones(grid.shape), 1.0, (v, v)), 60.0, aux={"b": lambda x, y: -s * x},
                         boundary={"west": gr.Hydrograph([0.0], [v], [0.0], [1.0]), "south": fv.Wall(), "north": fv.Wall()},
                         sources=gr.Manning(0.03))
    assert_allclose(fv.solve(problem).q[-1][0], 1.0, atol=1e-12)


def test_a_side_that_differs_from_its_opposite_cannot_be_periodic():
    with pytest.raises(ValueError, match="periodic boundary is the same on both sides, west and east"):
        flat(gr.ShallowWater(), boundary={"west": fv.Periodic()})
    with pytest.raises(ValueError, match="Periodic closes a whole axis"):
        fv.Along(0.0, 1.0, fv.Periodic())


@pytest.mark.parametrize(("boundary", "words"), [
    ({"left": fv.Wall()}, "must be one of west, east, south, north"), ((fv.Wall(), fv.Wall()), "must be one condition, four"),
    ({"west": 3}, r"boundary\['west'\]")])
def test_sides_are_named_for_what_they_are(boundary, words):
    with pytest.raises((ValueError, TypeError), match=words):
        flat(gr.ShallowWater(), boundary=boundary)


def test_walls_on_one_axis_and_a_ring_on_the_other():
    grid, model = square(16), gr.ShallowWater()
    x, y = np.meshgrid(*(axis.centers for axis in grid.axes))
    q = state(model, 1.0 + 0.2 * np.exp(-((x - 5.0)**2 + (y - 1.0)**2)), 1.0)
    ring = fv.Problem(model, grid, q, 0.4, boundary={**CLOSED, "south": fv.Periodic(), "north": fv.Periodic()})
    shifted = fv.Problem(model, grid, np.roll(q, 5, axis=1), 0.4, boundary=ring.boundary)
    assert_allclose(fv.solve(shifted).q[-1], np.roll(fv.solve(ring).q[-1], 5, axis=1), atol=1e-13)


def test_data_of_another_shape_are_refused_by_their_shape():
    with pytest.raises(ValueError, match=r"`initial` must have shape \(3, 16, 16\), got \(2, 16, 16\)"):
        fv.Problem(gr.ShallowWater(), square(16), np.ones((2, 16, 16)), 1.0)
    with pytest.raises(ValueError, match=r"`initial\(x, y\)` must return shape"):
        fv.Problem(gr.ShallowWater(), square(16), lambda x, y: [x, y], 1.0)
    with pytest.raises(TypeError, match="must be three numbers, or three pairs"):
        fv.Grid((0.0, 0.0), (1.0, 1.0), 8)


@pytest.mark.parametrize(("make", "error", "words"), [
    (lambda: flat(gr.ShallowWater(), boundary={"left": fv.Wall()}), ValueError, "write 'west'"),
    (lambda: flat(gr.ShallowWater(), boundary={"west": fv.Along(50.0, 60.0, fv.Outflow())}), ValueError, "must cover the centre of a cell"),
    (lambda: fv.Problem(fv.Burgers(), fv.Grid(0.0, 1.0, 8), np.ones((1, 8)), 1.0, boundary=fv.Along(0.0, 1.0, fv.Wall())), TypeError,
     "needs a grid with two axes"),
    (lambda: fv.Problem(fv.Burgers(), square(8), lambda x: [x], 1.0), TypeError, "`initial` must be a function of x and y"),
    (lambda: flat(gr.ShallowWater(), sources=gr.CoulombFriction(lambda x, t: 0.3 + 0.0 * x)), ValueError, r"got one of \(x, t\)"),
    (lambda: fv.Stepper(fv.Problem(gr.ShallowWater(), fv.Grid((0.0, 0.0), (1.0, 1.0), (1, 8)), np.ones((3, 8, 1)), 1.0)), ValueError,
     "what varies along one axis alone")])
def test_what_would_be_lost_in_silence_is_refused_with_the_fix(make, error, words):
    with pytest.raises(error, match=words):
        make()


@pytest.mark.parametrize("backend", ["numpy"])
def test_in_cell_shocks_serve_the_plane_as_they_serve_a_line(backend):
    model, grid = gr.TwoPhase(), fv.Grid((0.0, 0.0), (10.0, 1.0), (60, 6))
    line = fv.Problem(model, fv.Grid(0.0, 10.0, 60), lambda x: model.conserved_from(np.where(x < 5.0, 3.0, 1.0), np.where(x < 5.0, 0.7, 0.4)), 0.4)
    q = np.zeros((6, 6, 60))
    q[[0, 1, 3, 4]] = line.q0[:, None]
    plane = fv.Problem(model, grid, q, 0.4, boundary={"south": fv.Periodic(), "north": fv.Periodic()})
    scheme, step = fv.WavePropagation(fv.Roe(), in_cell_shocks=True), fv.Step(dt=0.005)
    found = fv.solve(plane, scheme, step=step, backend=backend).q[-1][[0, 1, 3, 4]]
    assert_allclose(found, np.broadcast_to(fv.solve(line, scheme, step=step, backend=backend).q[-1][:, None], found.shape), atol=1e-12)
