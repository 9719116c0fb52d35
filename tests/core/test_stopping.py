"""When a run stops, and how long its steps are."""

import attrs
import numpy as np
import pytest

import fvkit as fv
import fvkit_granular as gr


def sloshing(t_end=200.0, n=0.3):
    scene = gr.Scene((0.0, 10.0), t_end, lambda x: {"h": 1.0 + 0.2 * (x < 5.0), "phi": 0.0}, boundary=fv.Wall(),
                     sources=gr.Manning(n))
    return scene.problem(gr.ShallowWater, 40)


def steps_of(problem, **settings):
    times = [problem.t_start]
    solution = fv.solve(problem, observers=lambda stepper: times.append(stepper.t), throw=False, **settings)
    return np.diff(times), solution


@pytest.mark.parametrize("backend", ["numpy", "numba"])
def test_a_run_ends_when_all_is_at_rest(backend):
    if backend == "numba":
        pytest.importorskip("numba")
    problem = sloshing()
    solution = fv.solve(problem, backend=backend, until=fv.StopAtRest(speed=0.02, every=10))
    assert solution.success
    assert solution.status is fv.Status.STOPPED
    assert 0.0 < solution.t[-1] < problem.t_end
    assert solution.stats.steps % 10 == 0
    assert np.abs(solution.observables()["v"]).max() < 0.02
    assert "StopAtRest" in solution.message
    assert f"t = {solution.t[-1]:.8g}" in solution.message
    before = fv.solve(problem, backend=backend, limits=fv.Limits(steps=solution.stats.steps - 10), throw=False)
    assert np.abs(before.observables()["v"]).max() >= 0.02


def test_the_end_does_not_depend_on_who_watches():
    problem = sloshing()
    stop = fv.StopAtRest(speed=0.02)
    alone = fv.solve(problem, until=stop)
    watched = fv.solve(problem, until=stop, observers=lambda stepper: None, progress=lambda share: None)
    np.testing.assert_array_equal(alone.q[-1], watched.q[-1])


def test_outputs_up_to_the_stop_are_kept():
    solution = fv.solve(sloshing(), times=[0.5, 1.0, 199.0, 200.0], until=fv.StopAtRest(speed=0.02))
    assert solution.t[:3].tolist() == [0.0, 0.5, 1.0]
    assert len(solution.t) == 4
    assert 1.0 < solution.t[3] < 199.0


def test_rest_counts_only_after_a_time_and_where_it_is_deep():
    still = fv.Problem(gr.ShallowWater(), fv.Grid(0.0, 10.0, 20), np.array([[1.0], [0.0]]) * np.ones(20), 5.0, boundary=fv.Wall())
    assert fv.solve(still, until=fv.StopAtRest(every=1)).stats.steps == 1
    assert fv.solve(still, until=fv.StopAtRest(every=1, after=2.0)).t[-1] >= 2.0
    film = fv.Problem(gr.ShallowWater(), fv.Grid(0.0, 10.0, 20), np.array([[1e-4], [1e-4]]) * np.ones(20), 5.0,
                      boundary=fv.Periodic())
    assert fv.solve(film, until=fv.StopAtRest(every=1)).status is fv.Status.STOPPED
    assert fv.solve(film, until=fv.StopAtRest(every=1, depth=1e-5)).status is fv.Status.FINISHED


def test_a_rule_of_ones_own_ends_a_run():
    @attrs.frozen
    class Filled(fv.Stop):
        mass: float = 1.0

        def reached(self, problem, t, q):
            return q[0].sum() * problem.grid.dx >= self.mass

    problem = fv.Problem(fv.Advection(1.0), fv.Grid(0.0, 1.0, 50), np.zeros((1, 50)), 2.0, boundary=(fv.Inflow([3.0]), fv.Outflow()))
    solution = fv.solve(problem, until=Filled(1.5, every=1))
    assert solution.t[-1] == pytest.approx(0.5, abs=0.03)


def test_rest_needs_velocities():
    problem = fv.Problem(fv.Advection(1.0), fv.Grid(0.0, 1.0, 10), np.zeros((1, 10)), 1.0)
    with pytest.raises(ValueError, match="Advection names no observable with the unit"):
        fv.solve(problem, until=fv.StopAtRest())
    with pytest.raises(TypeError, match=r"`until` must be an instance of Stop.*fv\.StopAtRest"):
        fv.solve(problem, until=3.0)
    with pytest.raises(TypeError, match="write StopAtRest"):
        fv.solve(problem, until=fv.StopAtRest)


def test_a_resumed_run_stops_where_the_whole_one_does(tmp_path):
    problem, stop = sloshing(), fv.StopAtRest(speed=0.02)
    whole = fv.solve(problem, until=stop)
    fv.solve(problem, until=stop, limits=fv.Limits(steps=33), throw=False, checkpoint=fv.Checkpoint(tmp_path / "run.npz"))
    again = fv.resume(tmp_path / "run.npz")
    assert again.status is fv.Status.STOPPED
    np.testing.assert_array_equal(again.q[-1], whole.q[-1])
    once_more = fv.resume(tmp_path / "run.npz")
    np.testing.assert_array_equal(once_more.q[-1], whole.q[-1])
    assert once_more.stats.steps == whole.stats.steps


@pytest.mark.parametrize("backend", ["numpy", "numba"])
@pytest.mark.parametrize("order", ["wave", "lines"])
def test_steps_of_fixed_length(backend, order):
    if backend == "numba":
        pytest.importorskip("numba")
    scheme = None if order == "wave" else fv.MethodOfLines(gr.Relaxation(), integrator=fv.ARK4())
    taken, solution = steps_of(sloshing(1.0), backend=backend, step=fv.Step(dt=0.01), scheme=scheme)
    assert solution.success
    np.testing.assert_allclose(taken, 0.01, rtol=1e-9)
    assert len(taken) == 100
    taken, solution = steps_of(sloshing(1.0), backend=backend, step=fv.Step(dt=0.015), scheme=scheme)
    assert len(taken) == 67
    assert taken.max() <= 0.015


@pytest.mark.parametrize("backend", ["numpy", "numba"])
def test_a_fixed_step_that_is_too_long_ends_the_run(backend):
    if backend == "numba":
        pytest.importorskip("numba")
    with pytest.raises(fv.SolveError, match=r"longer than the Courant number.*dt_max.*at t = ") as caught:
        fv.solve(sloshing(5.0), backend=backend, step=fv.Step(dt=0.2))
    assert caught.value.status is fv.Status.DT_TOO_LARGE
    assert caught.value.solution.stats.steps == 0


@pytest.mark.parametrize("backend", ["numpy", "numba"])
def test_longest_and_first_step(backend):
    if backend == "numba":
        pytest.importorskip("numba")
    free, _ = steps_of(sloshing(1.0), backend=backend)
    assert free.max() > 0.02
    taken, _ = steps_of(sloshing(1.0), backend=backend, step=fv.Step(dt_max=0.02, dt_initial=1e-4))
    assert taken[0] == pytest.approx(1e-4, rel=1e-3)
    assert taken[1:].max() <= 0.02
    assert taken[1:].min() > 0.015


def test_the_length_of_steps_is_kept_by_a_checkpoint(tmp_path):
    whole = fv.solve(sloshing(1.0), step=fv.Step(dt=0.011))
    fv.solve(sloshing(1.0), step=fv.Step(dt=0.011), limits=fv.Limits(steps=7), throw=False, checkpoint=fv.Checkpoint(tmp_path / "run.npz"))
    again = fv.resume(tmp_path / "run.npz")
    assert again.stats.steps == whole.stats.steps
    np.testing.assert_array_equal(again.q[-1], whole.q[-1])


@pytest.mark.parametrize(("settings", "words"), [
    ({"dt": 0.0}, "`dt` must be finite and > 0"), ({"dt_max": -1.0}, "`dt_max` must be"), ({"dt_initial": np.nan}, "`dt_initial`"),
    ({"dt": 0.1, "dt_max": 0.2}, "give it without"), ({"dt": "0.1"}, "`dt` must be a number"),
])
def test_lengths_that_cannot_be_are_refused(settings, words):
    with pytest.raises((ValueError, TypeError), match=words):
        fv.Step(**settings)


@pytest.mark.parametrize("backend", ["numpy", "numba"])
def test_an_inflow_that_varies_is_of_second_order_in_time(backend):
    if backend == "numba":
        pytest.importorskip("numba")

    def wave(t):
        return [2.0 + np.sin(2.0 * np.pi * t)]

    errors = []
    for cells in (50, 100, 200):
        grid = fv.Grid(0.0, 1.0, cells)
        edges = np.cos(2.0 * np.pi * (1.5 - grid.edges)) / (2.0 * np.pi)
        exact = 2.0 + np.diff(edges) / grid.dx
        problem = fv.Problem(fv.Advection(1.0), grid, np.full((1, cells), 2.0), 1.5, boundary=(fv.Inflow(wave), fv.Outflow()))
        end = fv.solve(problem, fv.WavePropagation(fv.Roe(), limiter=fv.MC(), cfl=0.8), backend=backend)
        errors.append(np.abs(end.q[-1, 0] - exact)[: cells // 2].mean())
    assert np.log2(errors[0] / errors[1]) > 1.8
    assert np.log2(errors[1] / errors[2]) > 1.8


@pytest.mark.parametrize("times", [[0.0], [0.2], [0.1, 0.3]])
def test_a_run_whose_last_output_is_before_the_end_says_so(times):
    solution = fv.solve(gr.scene("dam-break").problem(gr.ShallowWater, 50), times=times)
    assert solution.status is fv.Status.FINISHED
    assert solution.message == f"the last of the output times was reached, t = {times[-1]:.8g} of t_end = 0.5"
    assert solution.configuration["message"] == solution.message


@pytest.mark.parametrize("times", [None, [0.5], [0.2, 0.5]])
def test_a_run_to_the_end_time_says_that(times):
    assert fv.solve(gr.scene("dam-break").problem(gr.ShallowWater, 50), times=times).message == "the end time was reached"
