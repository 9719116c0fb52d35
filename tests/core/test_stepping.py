"""Steps: exact output times, rejection, ends and failures, independence of runs, and the semi-discrete form."""

import sys
import warnings
from itertools import pairwise

import attrs
import numpy as np
import pytest
from scipy.integrate import solve_ivp

import fvkit as fv
import fvkit_granular as gr
from fvkit.backends import numpy_kernel
from fvkit.run import progress
from fvkit.run.progress import duration
from tests.cases import LIMITERS, SOLVERS, Stepper, averages, l1, name_of, orders, solve


@attrs.frozen
class Clocked(fv.Model):
    """Burgers' equation and a second component that stands still: a source can write the time into it."""

    conserved = ("u", "clock")

    def flux(self, q):
        u, clock = q
        return 0.5 * u * u, 0.0 * clock

    def wave_speeds(self, q):
        u, _ = q
        return fv.minimum(u, 0.0), fv.maximum(u, 0.0)


@attrs.frozen
class Tick(fv.Source):
    """The clock runs at rate 1."""

    def step(self, model, q, aux, dt):
        return q[0], q[1] + dt

    def rate(self, model, q, aux):
        return 0.0 * q[0], 0.0 * q[1] + 1.0


@attrs.frozen
class Fragile(fv.Model):
    """Advection of u with a flux that is no number where the clock has passed 1."""

    conserved = ("u", "clock")

    def flux(self, q):
        u, clock = q
        return u * np.sqrt(1.0 - clock), 0.0 * clock

    def wave_speeds(self, q):
        return 0.0, 1.0


@attrs.frozen
class Accelerating(fv.Model):
    """Two components: advection of u at the speed that the second one holds."""

    conserved = ("u", "speed")

    def flux(self, q):
        u, speed = q
        return u * speed, 0.0 * speed

    def wave_speeds(self, q):
        return 0.0, q[1]


@attrs.frozen
class Explosion(fv.Source):
    """The speed grows without bound: its reciprocal falls linearly, to zero at t = 1 where it starts at 1."""

    def step(self, model, q, aux, dt):
        return q[0], 1.0 / fv.maximum(1.0 / q[1] - dt, 1e-300)

    def rate(self, model, q, aux):
        return 0.0 * q[0], q[1] * q[1]


def sine(x):
    return np.sin(2.0 * np.pi * x)[None]


def hump(x):
    return np.exp(-100.0 * (x - 0.5) ** 2)[None]


def burgers(cells=50, t_end=0.1, **options):
    return fv.Problem(fv.Burgers(), fv.Grid(0.0, 1.0, cells), lambda x: 1.5 + sine(x), t_end,
                      **{"boundary": fv.Periodic(), **options})


def clocked(sources=(), boundary=None, cells=20, t_end=1.0):
    def initial(x):
        return np.array([0.1 + 0.0 * x, 0.0 * x])

    boundary = boundary or (fv.Inflow([0.1, 0.0]), fv.Outflow())
    return fv.Problem(Clocked(), fv.Grid(0.0, 1.0, cells), initial, t_end, sources=sources, boundary=boundary)


def sudden_inflow(t):
    """Slow inflow that turns a hundred times faster at t = .4 and slow again at t = .6."""
    return [10.0 if 0.4 < t < 0.6 else 0.1, 0.0]


def test_output_times_are_hit_exactly():
    times = [0.0123, 1.0 / 30.0, 0.07, np.nextafter(0.07, 1.0), 0.1]
    solution = solve(burgers(), fv.WavePropagation(fv.Roe()), times)
    assert solution.t.tolist() == [0.0, *times]
    assert solution.q.shape == (6, 1, 50)
    assert solution.success


def test_a_first_output_time_at_the_start_is_not_listed_twice():
    solution = solve(burgers(), times=[0.0, 0.05])
    assert solution.t.tolist() == [0.0, 0.05]


def test_an_output_at_the_start_alone_is_one_output():
    solution = solve(burgers(), times=[0.0])
    assert solution.t.tolist() == [0.0]
    assert solution.q.shape == (1, 1, 50)


def test_without_times_the_solution_holds_start_and_end():
    solution = solve(burgers())
    assert solution.t.tolist() == [0.0, 0.1]


def test_a_run_may_end_before_the_end_time():
    assert solve(burgers(), times=[0.03]).t[-1] == 0.03


def test_the_clock_starts_at_t_start():
    solution = solve(burgers(t_start=-1.0, t_end=-0.9), times=[-0.95, -0.9])
    assert solution.t.tolist() == [-1.0, -0.95, -0.9]
    np.testing.assert_allclose(solution.q, solve(burgers(), times=[0.05, 0.1]).q, atol=1e-12)


def test_the_stepper_and_solve_are_bit_identical():
    solution = solve(burgers(), times=[0.04, 0.1])
    stepper = Stepper(burgers())
    stepper.advance(0.04)
    assert stepper.t == 0.04
    np.testing.assert_array_equal(stepper.q, solution.q[1])
    stepper.advance(0.1)
    np.testing.assert_array_equal(stepper.q, solution.q[2])


def test_single_steps_to_the_end_are_bit_identical_to_solve():
    stepper = Stepper(burgers())
    while stepper.t < 0.1:
        stepper.step()
    solution = solve(burgers())
    assert stepper.t == pytest.approx(0.1, rel=1e-15)
    np.testing.assert_array_equal(stepper.q, solution.q[-1])
    assert stepper.stats().steps == solution.stats.steps


def test_a_step_past_the_end_needs_a_length():
    stepper = Stepper(burgers())
    stepper.advance(0.1)
    with pytest.raises(ValueError, match=r"`dt`"):
        stepper.step()
    assert stepper.step(1e-3) == pytest.approx(1e-3, rel=1e-12)
    assert stepper.t == pytest.approx(0.101)


def test_a_step_is_never_longer_than_asked_nor_than_the_courant_number_allows():
    stepper = Stepper(burgers())
    assert stepper.step(1e-5) == 1e-5
    assert stepper.step(1.0) <= 0.9 * 0.02 / 2.4


def test_the_states_of_the_stepper_cannot_be_written():
    stepper = Stepper(burgers())
    with pytest.raises(ValueError, match=r"read-only"):
        stepper.q[0, 0] = 1.0


def test_a_run_leaves_the_problem_as_it_was():
    problem = burgers()
    before = problem.q0.copy()
    first, second = solve(problem), solve(problem)
    np.testing.assert_array_equal(problem.q0, before)
    np.testing.assert_array_equal(first.q, second.q)


def test_the_first_step_is_not_rejected():
    stepper = Stepper(burgers())
    stepper.step()
    assert (stepper.stats().steps, stepper.stats().rejected) == (1, 0)


@pytest.mark.parametrize("splitting", [fv.Godunov(), fv.Strang()], ids=name_of)
@pytest.mark.parametrize("order", [1, 2])
def test_sources_act_once_per_accepted_step_although_steps_are_rejected(splitting, order):
    problem = clocked(Tick(), (fv.Inflow(sudden_inflow), fv.Outflow()))
    solution = solve(problem, fv.WavePropagation(fv.HLL(), order=order, splitting=splitting))
    assert solution.stats.rejected >= 1
    clock = solution.q[-1, 1]
    np.testing.assert_allclose(clock, 1.0, atol=1e-12)


def test_observers_see_accepted_steps_only():
    seen = []
    problem = clocked(boundary=(fv.Inflow(sudden_inflow), fv.Outflow()))
    solution = solve(problem, fv.WavePropagation(fv.HLL()),
                        observers=[lambda stepper: seen.append((stepper.t, stepper.steps, stepper.stats().rejected))])
    assert solution.stats.rejected >= 1
    assert [steps for _, steps, _ in seen] == list(range(1, solution.stats.steps + 1))
    assert (np.diff([t for t, _, _ in seen]) > 0.0).all()
    assert seen[-1][0] == 1.0


def test_observers_are_called_in_order_with_the_stepper():
    calls = []
    solve(
        burgers(),
        limits=fv.Limits(steps=100),
        observers=[lambda s: calls.append(("a", s.q.shape)), lambda s: calls.append(("b", s.t))],
    )
    assert [name for name, _ in calls] == ["a", "b"] * (len(calls) // 2)
    assert calls[0][1] == (1, 50)


def test_a_rejected_step_leaves_no_trace():
    """The run equals one whose steps are all short enough from the start, given the same step lengths."""
    problem = clocked(Tick(), (fv.Inflow(sudden_inflow), fv.Outflow()))
    scheme = fv.WavePropagation(fv.HLL())
    stepper, lengths = Stepper(problem, scheme), []
    while stepper.t < 0.9:
        lengths.append(stepper.step())
    assert stepper.stats().rejected >= 1
    replayed = Stepper(problem, fv.WavePropagation(fv.HLL(), cfl=1.0))
    for dt in lengths:
        assert replayed.step(dt) == pytest.approx(dt, rel=1e-12)
    assert replayed.stats().rejected <= stepper.stats().rejected
    np.testing.assert_allclose(replayed.q, stepper.q, rtol=1e-12)


def test_a_rejected_step_is_counted_as_work():
    problem = clocked(boundary=(fv.Inflow(sudden_inflow), fv.Outflow()))
    stats = solve(problem, fv.WavePropagation(fv.HLL())).stats
    assert stats.cell_updates == 20 * (stats.steps + stats.rejected)
    assert stats.max_cfl <= 1.0 + 1e-12


@pytest.mark.parametrize("splitting", [fv.Godunov(), fv.Strang()], ids=name_of)
def test_the_source_acts_in_every_step_at_a_courant_number_of_exactly_one(splitting):
    def initial(x):
        return np.array([1.0 + 0.0 * x, 0.0 * x])

    problem = fv.Problem(Clocked(), fv.Grid(0.0, 1.0, 32), initial, 1.0, sources=Tick(), boundary=fv.Periodic())
    solution = solve(problem, fv.WavePropagation(fv.HLL(), cfl=1.0, splitting=splitting))
    assert solution.stats.max_cfl == pytest.approx(1.0, abs=1e-12)
    assert solution.stats.rejected == 0
    np.testing.assert_allclose(solution.q[-1, 1], 1.0, atol=1e-13)


@pytest.mark.parametrize("order", [1, 2])
def test_at_a_courant_number_of_exactly_one_advection_is_exact(order):
    problem = fv.Problem(fv.Advection(1.0), fv.Grid(0.0, 1.0, 100), hump, 1.0, boundary=fv.Periodic())
    solution = solve(problem, fv.WavePropagation(fv.Roe(), order=order, cfl=1.0))
    np.testing.assert_allclose(solution.q[-1], problem.q0, atol=1e-12)


def test_max_steps_ends_with_its_own_status_and_the_partial_solution():
    solution = solve(burgers(), limits=fv.Limits(steps=3), throw=False)
    assert solution.status is fv.Status.MAX_STEPS
    assert not solution.success
    assert solution.stats.steps == 3
    assert 0.0 < solution.t[-1] < 0.1
    assert solution.message.startswith(fv.Status.MAX_STEPS.value)


def test_max_steps_raises_where_failures_are_thrown():
    with pytest.raises(fv.SolveError) as error:
        solve(burgers(), limits=fv.Limits(steps=3))
    assert error.value.status is fv.Status.MAX_STEPS
    assert error.value.solution.stats.steps == 3


def test_max_steps_counts_accepted_steps_only():
    problem = clocked(boundary=(fv.Inflow(sudden_inflow), fv.Outflow()))
    scheme = fv.WavePropagation(fv.HLL())
    whole = solve(problem, scheme)
    assert whole.stats.rejected >= 1
    assert solve(problem, scheme, limits=fv.Limits(steps=whole.stats.steps)).success


@pytest.mark.parametrize("t_end", [0.0, -1.0])
def test_an_end_time_not_after_the_start_is_refused_at_construction(t_end):
    with pytest.raises(ValueError, match=r"`t_end` must be > `t_start`"):
        burgers(t_end=t_end)


def fragile(weak=13, cells=30):
    def initial(x):
        clock = np.where(np.abs(x - (weak + 0.5) / cells) < 0.5 / cells, 0.5, 0.0)
        return np.array([1.0 + 0.0 * x, clock])

    return fv.Problem(Fragile(), fv.Grid(0.0, 1.0, cells), initial, 1.0, sources=Tick(), boundary=fv.Periodic())


@pytest.mark.parametrize("order", [1, 2])
def test_a_state_that_turns_nan_half_way_is_never_success(order):
    solution = solve(fragile(), fv.WavePropagation(fv.HLL(), order=order), times=[0.2, 0.4, 0.6, 1.0], throw=False)
    assert solution.status is fv.Status.NON_FINITE
    assert solution.t[:3].tolist() == [0.0, 0.2, 0.4]
    assert 0.4 < solution.t[3] <= 0.52
    assert len(solution.t) == len(solution.q) == 4
    assert np.isfinite(solution.q).all()


def test_the_error_of_a_nan_carries_time_cell_x_state_and_the_partial_solution():
    with pytest.raises(fv.SolveError) as caught:
        solve(fragile(), fv.WavePropagation(fv.HLL()))
    error = caught.value
    assert error.status is fv.Status.NON_FINITE
    assert abs(error.cell - 13) <= 2
    assert error.x == pytest.approx((error.cell + 0.5) / 30)
    assert not np.isfinite(error.state).all()
    assert error.time == error.solution.t[-1]
    assert 0.45 < error.time <= 0.52
    for text in (f"cell {error.cell}", f"x = {error.x:.6g}", f"t = {error.time:.8g}", "u = ", "clock = "):
        assert text in str(error)
    assert error.solution.message == str(error)


def test_a_failed_step_leaves_the_stepper_at_the_last_accepted_state():
    stepper = Stepper(fragile(), fv.WavePropagation(fv.HLL()))
    with pytest.raises(fv.SolveError) as error:
        stepper.advance(1.0)
    assert error.value.solution is None
    assert stepper.t == error.value.time
    np.testing.assert_allclose(stepper.q[1], fragile().q0[1] + stepper.t, atol=1e-13)


def test_speeds_that_grow_without_bound_end_the_run_with_a_status():
    problem = fv.Problem(Accelerating(), fv.Grid(0.0, 1.0, 10), np.ones((2, 10)), 2.0, sources=Explosion())
    solution = solve(problem, fv.WavePropagation(fv.HLL()), throw=False, limits=fv.Limits(steps=20_000))
    assert solution.status in (fv.Status.DT_TOO_SMALL, fv.Status.NON_FINITE)
    assert solution.t[-1] == pytest.approx(1.0, abs=1e-6)


def test_a_negative_mass_ends_the_run_with_time_cell_and_state():
    class Drain(fv.Source):
        def step(self, model, q, aux, dt):
            return q[0] - 10.0 * dt, q[1]

        def rate(self, model, q, aux):
            return -10.0 + 0.0 * q[0], 0.0 * q[1]

    q = np.array([[1.0, 1.0, 1.0, 0.9, 1.0], [0.0, 0.0, 0.0, 0.0, 0.0]])
    with pytest.raises(fv.SolveError) as error:
        solve(fv.Problem(gr.ShallowWater(), fv.Grid(0.0, 1.0, 5), q, 1.0, sources=Drain()), fv.WavePropagation(fv.Roe()))
    assert error.value.status is fv.Status.NEGATIVE_DEPTH
    assert 0 <= error.value.cell < 5
    assert error.value.state[0] < 0.0
    assert error.value.solution.t[-1] == error.value.time


def test_a_state_outside_what_the_model_admits_ends_the_run():
    class Capped(fv.Burgers):
        def admissible(self, q):
            return q[0] < 1.4

    def initial(x):
        return 1.0 + 0.39 * hump(x)

    problem = fv.Problem(Capped(), fv.Grid(0.0, 1.0, 50), initial, 5.0, boundary=fv.Inflow(lambda t: [1.0 + 0.2 * t]))
    solution = solve(problem, throw=False)
    assert solution.status is fv.Status.INADMISSIBLE
    assert solution.q[-1].max() < 1.4
    assert 2.0 - 0.02 <= solution.t[-1] < 3.0  # the inflow of a step is that of its middle


def test_runs_with_different_gravity_do_not_touch_each_other():
    def make(g):
        def initial(x):
            return gr.TwoPhase(g).conserved_from(np.where(x < 0.5, 2.0, 1.0), np.where(x < 0.5, 0.7, 0.4))

        return Stepper(fv.Problem(gr.TwoPhase(g), fv.Grid(0.0, 1.0, 40), initial, 1.0))

    alone = []
    for g in (1.0, 9.81):
        stepper = make(g)
        for _ in range(10):
            stepper.step()
        alone.append(stepper.q.copy())
    first, second = make(1.0), make(9.81)
    for _ in range(10):
        first.step()
        second.step()
    np.testing.assert_array_equal(first.q, alone[0])
    np.testing.assert_array_equal(second.q, alone[1])


def test_a_refused_problem_does_not_poison_the_next():
    before = solve(burgers()).q
    with pytest.raises(ValueError, match=r"`initial`"):
        fv.Problem(gr.ShallowWater(), fv.Grid(0.0, 1.0, 5), -np.ones((2, 5)), 1.0)
    with pytest.raises(fv.SolveError):
        solve(fragile(), fv.WavePropagation(fv.HLL()))
    np.testing.assert_array_equal(solve(burgers()).q, before)


def test_progress_reports_growing_shares_up_to_one():
    shares = []
    solve(burgers(t_start=1.0, t_end=1.1), progress=shares.append)
    assert shares[-1] == 1.0
    assert all(0.0 < a <= b <= 1.0 for a, b in pairwise(shares))


def test_progress_is_silent_by_default_and_a_line_on_stderr_where_asked(capsys):
    solve(burgers())
    assert capsys.readouterr() == ("", "")
    solve(burgers(), progress=True)
    shown = capsys.readouterr()
    assert shown.out == ""
    assert "100" in shown.err


@pytest.mark.parametrize(("seconds", "said"), [(0.04, "0.04 s"), (59.0, "59 s"), (90.0, "1.5 min"), (7300.0, "2 h"), (8.2e5, "9.5 days"),
                                               (1e9, "32 years")])
def test_a_wall_time_has_the_unit_that_suits_it(seconds, said):
    assert duration(seconds) == said


def test_the_line_of_progress_estimates_the_time_that_is_left(capsys, monkeypatch):
    monkeypatch.setitem(sys.modules, "tqdm.auto", None)
    times = iter(range(0, 1000, 10))
    monkeypatch.setattr(progress, "perf_counter", lambda: next(times))
    with progress.reporter(True, 0.0, 1e9) as report:
        report(1e3, 7)
    assert "7 steps, dt 143 s, about 116 days left" in capsys.readouterr().err
    with progress.reporter(True, 0.0, 100.0) as report:
        report(25.0, 5)
        report(100.0, 20)
    shown = capsys.readouterr().err
    assert "5 steps, dt 5 s, about 30 s left" in shown
    assert shown.count("left") == 1


@pytest.mark.parametrize(("t_end", "limits", "until", "warns"), [
    (1e9, None, None, True), (1e9, fv.Limits(steps=10**15), None, False), (1e9, fv.Limits(steps=1000), None, False), (1e9, None, fv.StopAtRest(1e-9), False), (0.5, None, None, False),
])
def test_a_run_that_cannot_reach_its_end_within_its_steps_says_so_once(t_end, limits, until, warns, monkeypatch):
    monkeypatch.setattr(sys.modules["fvkit.run.solve"], "LOOK", 0.0)

    def stop(stepper):
        if stepper.steps > 20:
            raise KeyError("as a user would")

    problem = fv.Problem(gr.ShallowWater(), fv.Grid(0.0, 1.0, 20), np.ones((2, 20)), t_end)
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        fv.solve(problem, limits=limits, until=until, observers=stop, backend="numpy", throw=False)
    assert ["at this rate it needs about" in str(one.message) for one in caught] == [True] * warns


def test_an_inflow_that_depends_on_time_is_advected_exactly():
    def inflow(t):
        return [np.sin(3.0 * t)]

    problem = fv.Problem(fv.Advection(1.0), fv.Grid(0.0, 1.0, 64), np.zeros((1, 64)), 2.0,
                         boundary=(fv.Inflow(inflow), fv.Outflow()))
    solution = solve(problem, fv.WavePropagation(fv.Roe(), order=1, cfl=1.0))
    np.testing.assert_allclose(solution.q[-1, 0], np.sin(3.0 * (2.0 - problem.grid.centers)), atol=1e-12)


def test_an_inflow_that_changes_its_shape_or_turns_nan_is_named():
    def short(t):
        return [1.0, 2.0] if t > 0.05 else [1.0]

    with pytest.raises(ValueError, match=r"`state` of Inflow must have 1 components"):
        solve(burgers(boundary=fv.Inflow(short)))
    with pytest.raises(ValueError, match=r"Inflow state at t"):
        solve(burgers(boundary=fv.Inflow(lambda t: [np.nan if t > 0.05 else 1.0])))


BOUNDARIES = {
    "outflow": fv.Outflow(), "wall": fv.Wall(), "periodic": fv.Periodic(drop=0.0),
    "inflow": (fv.Inflow([1.0, 0.2]), fv.Outflow()), "inflow of time": (fv.Inflow(lambda t: [1.0 + t, 0.2]), fv.Wall()),
}


@pytest.mark.parametrize("order", [1, 2])
@pytest.mark.parametrize("name", BOUNDARIES)
@pytest.mark.parametrize("chunk", [7, 16])
def test_a_run_cut_into_chunks_is_bit_identical(monkeypatch, name, order, chunk):
    def initial(x):
        return np.array([1.0 + 0.5 * (np.abs(x - 0.5) < 0.2), 0.3 * np.sin(9.0 * x)])

    problem = fv.Problem(gr.ShallowWater(), fv.Grid(0.0, 1.0, 64), initial, 0.1, {"b": lambda x: 0.2 * x * x},
                         BOUNDARIES[name], Shaking())
    scheme = fv.WavePropagation(fv.Roe(), order=order)
    whole = solve(problem, scheme)
    monkeypatch.setattr(numpy_kernel, "CHUNK", chunk)
    monkeypatch.setattr(numpy_kernel, "UNCHUNKED", chunk)
    cut = solve(problem, scheme)
    np.testing.assert_array_equal(cut.q, whole.q)
    assert (cut.stats.steps, cut.stats.max_cfl) == (whole.stats.steps, whole.stats.max_cfl)
    assert cut.stats.mass_drift == pytest.approx(whole.stats.mass_drift, abs=1e-14)


def test_the_rhs_cut_into_chunks_is_bit_identical(monkeypatch):
    problem = burgers()
    whole = fv.rhs(problem)(0.0, problem.q0)
    monkeypatch.setattr(numpy_kernel, "CHUNK", 7)
    monkeypatch.setattr(numpy_kernel, "UNCHUNKED", 7)
    np.testing.assert_array_equal(fv.rhs(problem)(0.0, problem.q0), whole)


@attrs.frozen
class Shaking(fv.Source):
    """Momentum that decays towards the bottom's value: reads the aux."""

    def step(self, model, q, aux, dt):
        share = np.exp(-dt)
        return q[0], q[1] * share + (1.0 - share) * aux[0]

    def rate(self, model, q, aux):
        return 0.0 * q[0], aux[0] - q[1]


def test_faces_that_lose_hyperbolicity_are_counted_alike_in_chunks(monkeypatch):
    def initial(x):
        return gr.TwoPhase().conserved_from(np.ones_like(x), 0.6, np.where(np.abs(x - 0.5) < 0.3, 4.0, 0.5), 0.0)

    problem = fv.Problem(gr.TwoPhase(), fv.Grid(0.0, 1.0, 60), initial, 0.005)
    scheme = fv.WavePropagation(fv.HLL(), order=1)
    whole = solve(problem, scheme, nonhyperbolic="ignore", throw=False)
    monkeypatch.setattr(numpy_kernel, "CHUNK", 7)
    monkeypatch.setattr(numpy_kernel, "UNCHUNKED", 7)
    cut = solve(problem, scheme, nonhyperbolic="ignore", throw=False)
    assert whole.stats.nonhyperbolic_faces > 30
    assert cut.stats.nonhyperbolic_faces == whole.stats.nonhyperbolic_faces
    np.testing.assert_array_equal(cut.q, whole.q)


def test_lost_hyperbolicity_warns_once_or_raises_or_is_silent_as_asked(recwarn):
    def initial(x):
        return gr.TwoPhase().conserved_from(np.ones_like(x), 0.6, np.where(x > 0.5, 4.0, 0.5), 0.0)

    problem = fv.Problem(gr.TwoPhase(), fv.Grid(0.0, 1.0, 30), initial, 0.005)
    scheme = fv.WavePropagation(fv.HLL(), order=1)
    solve(problem, scheme, nonhyperbolic="ignore", throw=False)
    assert not recwarn.list
    solve(problem, scheme, throw=False)
    assert len(recwarn.list) == 1
    assert "complex" in str(recwarn.list[0].message)
    stopped = solve(problem, scheme, nonhyperbolic="raise", throw=False)
    assert stopped.status is fv.Status.NONHYPERBOLIC
    assert stopped.stats.steps == 0
    assert stopped.t.tolist() == [0.0]


@pytest.mark.parametrize(("riemann", "limiter"), [
    *((fv.Roe(), limiter) for limiter in LIMITERS), (fv.HLL(), fv.MC()), (fv.Rusanov(), fv.MC()),
], ids=name_of)
def test_the_rhs_is_the_limit_of_a_tiny_step(riemann, limiter):
    def initial(x):
        return np.array([np.sin(2.0 * np.pi * x), np.cos(4.0 * np.pi * x)])

    problem = fv.Problem(fv.Acoustics(2.0, 3.0), fv.Grid(0.0, 1.0, 30), initial, 1.0, boundary=fv.Periodic())
    scheme = fv.WavePropagation(riemann, limiter)
    stepper, dt = Stepper(problem, scheme), 1e-7
    stepper.step(dt)
    rate = fv.rhs(problem, scheme)(0.0, problem.q0)
    np.testing.assert_allclose((stepper.q - problem.q0) / dt, rate, atol=2e-5 * np.abs(rate).max())


def test_the_rhs_contains_the_rates_of_all_sources_and_takes_flat_states():
    problem = clocked((Tick(), Tick()))
    rate = fv.rhs(problem, fv.WavePropagation(fv.HLL()))
    np.testing.assert_allclose(rate(0.0, problem.q0)[1], 2.0)
    flat = rate(0.0, problem.q0.ravel())
    assert flat.shape == (40,)
    np.testing.assert_array_equal(flat.reshape(2, 20), rate(0.0, problem.q0))


def test_the_rhs_leaves_its_argument_alone_and_sees_the_inflow_of_its_time():
    problem = fv.Problem(fv.Advection(1.0), fv.Grid(0.0, 1.0, 10), np.zeros((1, 10)), 1.0,
                         boundary=(fv.Inflow(lambda t: [t]), fv.Outflow()))
    rate, q = fv.rhs(problem, fv.WavePropagation(fv.Roe(), order=1)), np.zeros((1, 10))
    np.testing.assert_allclose(rate(0.5, q)[0, 0], 5.0)
    np.testing.assert_allclose(rate(2.0, q)[0, 0], 20.0)
    assert not q.any()


def test_scipy_drives_the_semi_discrete_form_of_advection_to_second_order():
    errors = []
    for cells in (40, 80, 160):
        grid = fv.Grid(0.0, 1.0, cells)
        problem = fv.Problem(fv.Advection(1.0), grid, sine, 1.0, boundary=fv.Periodic())
        rate = fv.rhs(problem, fv.WavePropagation(fv.Roe(), fv.NoLimiter()))
        result = solve_ivp(rate, (0.0, 1.0), problem.q0.ravel(), rtol=1e-8, atol=1e-10)
        errors.append(l1(grid, result.y[:, -1] - problem.q0[0]))
    assert orders(errors).min() > 1.9


def test_scipy_drives_the_semi_discrete_form_of_acoustics_to_the_exact_solution():
    grid = fv.Grid(0.0, 1.0, 100)
    problem = fv.Problem(
        fv.Acoustics(), grid, lambda x: np.array([np.sin(2.0 * np.pi * x), 0.0 * x]), 0.3, boundary=fv.Periodic()
    )
    rate = fv.rhs(problem, fv.WavePropagation(fv.HLL(), fv.NoLimiter()))
    result = solve_ivp(rate, (0.0, 0.3), problem.q0.ravel(), rtol=1e-8, atol=1e-10).y[:, -1].reshape(2, 100)
    exact = averages(lambda x: np.array([np.sin(2.0 * np.pi * x) * np.cos(0.6 * np.pi),
                                         -np.cos(2.0 * np.pi * x) * np.sin(0.6 * np.pi)]), grid)
    assert l1(grid, result - exact) < 2e-3


@pytest.mark.parametrize("riemann", SOLVERS, ids=name_of)
@pytest.mark.parametrize("limiter", LIMITERS, ids=name_of)
@pytest.mark.parametrize("size", [1e-160, 1e-308, 1e-320])
def test_noise_far_below_any_scale_stays_noise(limiter, riemann, size):
    noise = size * np.random.default_rng(9).uniform(-1.0, 1.0, (1, 40))
    problem = fv.Problem(fv.Advection(1.0), fv.Grid(0.0, 1.0, 40), noise, 0.5, boundary=fv.Periodic())
    solution = solve(problem, fv.WavePropagation(riemann, limiter))
    assert solution.success
    assert np.abs(solution.q[-1]).max() <= 3.0 * size


def test_noise_on_a_wave_does_not_touch_the_other_component():
    rng = np.random.default_rng(10)
    q = np.array([1.0 + 1e-16 * rng.uniform(-1.0, 1.0, 50), 1e-16 * rng.uniform(-1.0, 1.0, 50)])
    problem = fv.Problem(gr.ShallowWater(), fv.Grid(0.0, 1.0, 50), q, 0.5, boundary=fv.Periodic())
    for limiter in LIMITERS:
        last = solve(problem, fv.WavePropagation(fv.Roe(), limiter)).q[-1]
        assert np.abs(last - [[1.0], [0.0]]).max() < 1e-13


def test_a_state_where_nothing_moves_reaches_the_end_in_one_step():
    problem = fv.Problem(fv.Burgers(), fv.Grid(0.0, 1.0, 10), np.zeros((1, 10)), 7.0)
    solution = solve(problem)
    assert solution.success
    assert (solution.stats.steps, solution.t[-1]) == (1, 7.0)


def test_the_statistics_describe_the_run():
    stats = solve(burgers()).stats
    assert stats.backend == "numpy"
    assert 0.5 < stats.max_cfl <= 1.0
    assert stats.cell_updates == 50 * stats.steps
    assert stats.seconds > 0.0
    assert stats.ns_per_cell_step == pytest.approx(1e9 * stats.seconds / stats.cell_updates)
    assert stats.nonhyperbolic_faces == 0


def test_the_mass_drift_accounts_for_what_flows_through_the_ends():
    def initial(x):
        return np.array([1.0 + 0.3 * np.sin(9.0 * x), 0.8 + 0.0 * x])

    for boundary in (fv.Outflow(), fv.Wall(), (fv.Inflow([1.2, 1.0]), fv.Outflow())):
        problem = fv.Problem(gr.ShallowWater(), fv.Grid(0.0, 1.0, 50), initial, 0.3, boundary=boundary)
        solution = solve(problem)
        assert abs(solution.stats.mass_drift["h"]) < 1e-13
    assert abs(solution.q[-1, 0].sum() / solution.q[0, 0].sum() - 1.0) > 1e-3
