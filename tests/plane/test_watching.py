"""Observers and stop rules on grids with two axes."""

import numpy as np
import pytest

import fvkit as fv
import fvkit_granular as gr
from tests.cases import solve
from tests.plane.scenes import pool

PLACES = [(0.3, -0.9), (4.1, 1.2), (6.0, 2.5)]


def every_state(problem, observers=()):
    """Times and states of a run, with the observers of it."""
    seen = []
    solve(problem, observers=[lambda stepper: seen.append((stepper.t, stepper.q.copy())), *observers])
    return [problem.t_start, *(t for t, _ in seen)], [problem.q0, *(q for _, q in seen)]


def test_a_gauge_sees_the_cells_that_contain_its_places():
    problem, gauge = pool(), fv.Gauge(PLACES)
    times, states = every_state(problem, [gauge])
    assert gauge.t.tolist() == times
    cells = [(0, 0), (4, 8), (6, 11)]  # rows of y, columns of x
    for k, (row, column) in enumerate(cells):
        h, mx, my = np.array([q[:, row, column] for q in states]).T
        assert np.array_equal(gauge.values["h"][:, k], h)
        assert np.array_equal(gauge.values["v_y"][:, k], my / h)
        assert np.allclose(gauge.values["speed"][:, k], np.hypot(mx, my) / h, rtol=1e-14)
        assert np.array_equal(gauge.values["surface"][:, k], h + problem.aux_averages["b"][row, column])
    assert np.ptp(gauge.values["h"][:, 0]) > 0.01


@pytest.mark.parametrize(("places", "words"), [
    ([(0.3, 2.6)], r"`x` of a Gauge must be within \[-1, 2.5\], got 2.6"),
    ([(6.1, 0.0)], r"`x` of a Gauge must be within \[0, 6\], got 6.1"),
    ([1.0, 2.0], r"`x` of a Gauge must be a list of pairs \(x, y\), for a grid with two axes"),
    (1.0, r"`x` of a Gauge must be a list of pairs")])
def test_a_gauge_refuses_what_is_no_place(places, words):
    with pytest.raises(ValueError, match=words):
        solve(pool(), observers=fv.Gauge(places))


def test_a_gauge_of_pairs_is_refused_on_one_axis():
    problem = fv.Problem(fv.Advection(1.0), fv.Grid(0.0, 1.0, 5), lambda x: [x], 0.1)
    with pytest.raises(ValueError, match=r"must be a list of numbers x, for a grid with one axis"):
        solve(problem, observers=fv.Gauge([(0.1, 0.2)]))


def test_extremes_are_maps():
    extremes = fv.Extremes()
    times, states = every_state(pool(), [extremes])
    depths = np.array([q[0] for q in states])
    assert extremes.largest["h"].shape == (7, 12)
    assert np.array_equal(extremes.largest["h"], depths.max(axis=0))
    assert np.array_equal(extremes.smallest["h"], depths.min(axis=0))
    assert np.array_equal(extremes.when["h"], np.array(times)[depths.argmax(axis=0)])
    across = np.array([q[2] / q[0] for q in states])
    assert np.array_equal(extremes.magnitude("v_y"), np.abs(across).max(axis=0))


def test_a_front_refuses_two_axes():
    with pytest.raises(ValueError, match=r"Front follows both ends of a flow along one axis, got a grid with two"):
        solve(pool(), observers=gr.Front(0.1))


@pytest.mark.parametrize(("model", "state"), [
    (gr.ShallowWater(), [1.0, 0.3, 0.4]), (gr.TwoPhase(), [0.5, 0.0, 0.0, 0.5, 0.15, 0.2])])
@pytest.mark.parametrize(("speed", "stops"), [(0.45, False), (0.55, True)])
def test_a_run_stops_by_the_size_of_vectors(model, state, speed, stops):
    problem = fv.Problem(model, fv.Grid((0.0, 0.0), (1.0, 1.0), (4, 5)),
                         lambda x, y: np.array(state)[:, None, None] * np.ones_like(x), 1.0, boundary=fv.Periodic())
    found = solve(problem, until=fv.StopAtRest(speed, every=1))
    assert (found.status is fv.Status.STOPPED) == stops


def test_a_stop_rule_looks_where_the_flow_is_deep():
    problem = fv.Problem(gr.ShallowWater(), fv.Grid((0.0, 0.0), (1.0, 1.0), (4, 5)),
                         lambda x, y: [0.01 + 0.0 * x, 0.02 + 0.0 * x, 0.0 * x], 1.0, boundary=fv.Periodic())
    assert solve(problem, until=fv.StopAtRest(1.0, depth=0.02, every=1)).status is fv.Status.STOPPED
    assert solve(problem, until=fv.StopAtRest(1.0, depth=0.005, every=1)).status is fv.Status.FINISHED


def test_a_stop_rule_needs_velocities():
    problem = fv.Problem(fv.Advection((1.0, 1.0)), fv.Grid((0.0, 0.0), (1.0, 1.0), (4, 5)), lambda x, y: [x], 1.0)
    with pytest.raises(ValueError, match=r"StopAtRest needs velocities"):
        solve(problem, until=fv.StopAtRest(0.1))
