"""Users' functions that lie, fail or raise: the run says when and where, and keeps what it had."""

import attrs
import numpy as np
import pytest

import fvkit as fv
import fvkit_granular as gr
from fvkit.backends.step_length import MAX_RETRIES
from tests.cases import Stepper, solve
from tests.robust.cases import avalanche

SCHEMES = [fv.WavePropagation(fv.HLL()), fv.WavePropagation(fv.Rusanov(), order=1), fv.MethodOfLines(fv.Rusanov())]
NAMES = ["HLL", "Rusanov", "MP5"]


@attrs.frozen
class Honest(fv.Model):
    """Shallow water; those below lie about its speeds."""

    conserved = ("h", "m")
    phases = (((0,), 1),)

    def flux(self, q):
        h, m = q
        return m, m * m / h + 0.5 * 9.81 * h * h

    def wave_speeds(self, q):
        h, m = q
        c = np.sqrt(9.81 * h)
        return m / h - c, m / h + c


class Small(Honest):
    def wave_speeds(self, q):
        h, m = q
        c = np.sqrt(9.81 * h)
        return 0.1 * (m / h - c), 0.1 * (m / h + c)


class Zero(Honest):
    def wave_speeds(self, q):
        return 0.0 * q[0], 0.0 * q[0]


class NoNumber(Honest):
    def wave_speeds(self, q):
        return np.nan * q[0], np.nan * q[0]


class NoNumberLater(Honest):
    """No number where the waves meet."""

    def wave_speeds(self, q):
        h, m = q
        c = np.sqrt(9.81 * h)
        return m / h - c, fv.where((h > 1.1) & (h < 1.9), np.nan, m / h + c)


class Infinite(Honest):
    def wave_speeds(self, q):
        return -np.inf * q[0], np.inf * q[0]


class Swapped(Honest):
    def wave_speeds(self, q):
        h, m = q
        c = np.sqrt(9.81 * h)
        return m / h + c, m / h - c


class NoFlux(Honest):
    """No number in the flux where the waves meet."""

    def flux(self, q):
        h, m = q
        return m, fv.where((h > 1.1) & (h < 1.9), np.nan, m * m / h + 0.5 * 9.81 * h * h)


def dam(model, t_end=0.2):
    return fv.Problem(model, fv.Grid(0.0, 1.0, 50), lambda x: np.array([np.where(x < 0.5, 2.0, 1.0), 0.0 * x]), t_end,
                      boundary=fv.Wall())


def sound(stepper):
    assert np.isfinite(stepper.q).all()
    assert (stepper.q[0] >= 0.0).all()


@pytest.mark.parametrize("scheme", SCHEMES, ids=NAMES)
@pytest.mark.parametrize(("lie", "statuses"), [
    (Small, {"NON_FINITE", "NEGATIVE_DEPTH", "DT_TOO_SMALL"}), (Zero, {"WRONG_SPEED", "NON_FINITE", "NEGATIVE_DEPTH"}),
    (NoNumber, {"WRONG_SPEED"}), (NoNumberLater, {"WRONG_SPEED", "NON_FINITE"}), (Infinite, {"WRONG_SPEED"}),
    (NoFlux, {"NON_FINITE"})], ids=lambda value: getattr(value, "__name__", None))
def test_a_model_that_lies_ends_with_a_status_that_says_when_and_where(lie, statuses, scheme):
    if lie is Small and isinstance(scheme, fv.MethodOfLines):
        pytest.skip("its later stages see larger speeds, and what is rejected for these keeps the run finite and positive")
    solution = solve(dam(lie()), scheme, observers=[sound], throw=False, limits=fv.Limits(steps=2000))
    assert solution.status.name in statuses, solution.message
    assert f"at t = {solution.t[-1]:.8g}, step {solution.stats.steps} in cell " in solution.message
    assert "x = " in solution.message
    assert np.isfinite(solution.q).all()
    assert (solution.q[:, 0] >= 0.0).all()
    assert solution.stats.rejected <= MAX_RETRIES * (solution.stats.steps + 1)
    with pytest.raises(fv.SolveError) as caught:
        solve(dam(lie()), scheme)
    assert caught.value.cell >= 0
    assert caught.value.solution.q.tobytes() == solution.q.tobytes()


@pytest.mark.parametrize("scheme", SCHEMES[::2], ids=NAMES[::2])
def test_compiled_code_sees_speeds_that_are_no_number_in_some_states(scheme):
    pytest.importorskip("numba")
    compiled, plain = (fv.solve(dam(NoNumberLater()), scheme, backend=backend, throw=False) for backend in ("numba", "numpy"))
    assert compiled.status in (fv.Status.WRONG_SPEED, fv.Status.NON_FINITE)
    assert (compiled.status, compiled.stats.steps) == (plain.status, plain.stats.steps)  # which of the cells is told may differ
    assert "in cell" in compiled.message


@pytest.mark.parametrize("scheme", SCHEMES, ids=NAMES)
def test_an_honest_model_is_not_blamed(scheme):
    assert solve(dam(Honest()), scheme, observers=[sound]).success
    still = fv.Problem(Honest(), fv.Grid(0.0, 1.0, 20), np.ones((2, 20)) * [[1.0], [0.0]], 1.0, boundary=fv.Wall())
    assert solve(still, scheme).success
    assert solve(fv.Problem(fv.Advection(0.0), fv.Grid(0.0, 1.0, 20), np.arange(20.0)[None], 1.0), scheme).success


def test_speeds_in_the_wrong_order_are_refused_before_the_first_step():
    for throw in (True, False):
        with pytest.raises(ValueError, match=r"`wave_speeds` of Swapped\(\) must return the smallest and the largest speed, in this "
                           r"order: the first is above the second in cell 0 \(x = 0.01\)"):
            solve(dam(Swapped()), SCHEMES[0], throw=throw)


def test_a_step_at_no_speed_is_taken_back():
    stepper = Stepper(dam(Zero()), SCHEMES[0])
    before = stepper.snapshot()
    with pytest.raises(fv.SolveError, match="0 where the state moves"):
        stepper.step()
    after = stepper.snapshot()
    assert all(np.array_equal(before[name], after[name], equal_nan=True) for name in ("now", "real", "count", "masses"))


def test_a_first_step_far_too_long_is_shortened_by_both_families_of_schemes():
    """The speeds of the start, 0.1 of the true ones, make the stages of the first step overflow: it is tried again, shorter."""
    fast = attrs.evolve(dam(gr.ShallowWater()), boundary=(fv.Inflow(lambda t: [2.0, 400.0]), fv.Outflow()), t_end=1e-3)
    for scheme in SCHEMES:
        solution = solve(fast, scheme, observers=[sound])
        assert solution.success
        assert 0 < solution.stats.rejected <= MAX_RETRIES * solution.stats.steps


def test_retries_are_bounded_where_no_step_is_good_enough():
    solution = solve(dam(Honest()), SCHEMES[0], step=fv.Step(dt=1.0), throw=False)
    assert (solution.status, solution.stats.steps, solution.stats.rejected) == (fv.Status.DT_TOO_LARGE, 0, 1)
    assert "in cell" in solution.message


class Trouble(ArithmeticError):
    """What a user's code raises."""


@attrs.define
class After:
    """Raises when it has been asked so often."""

    calls: int

    def __call__(self, *_):
        self.calls -= 1
        if self.calls < 0:
            raise Trouble("a mistake of the user's")


@attrs.frozen
class StopAfter(fv.Stop):
    asked: After = attrs.field(factory=lambda: After(2))

    def reached(self, problem, t, q):
        self.asked()
        return False


def swell(after):
    def state(t):
        after()
        return [1.0, 0.1 * np.sin(t)]

    return state


def upwind(after):
    def function(ql, qr, auxl, auxr, data):
        after()
        return (qr - ql)[:, None], np.ones((1, ql.shape[1])), None, None

    return fv.PyClawRiemann(function)


def cases():
    """Keyword arguments of a run whose user's code raises after some steps, and what it says was going on."""
    advection = fv.Problem(fv.Advection(1.0), fv.Grid(0.0, 1.0, 40), lambda x: np.sin(2.0 * np.pi * x)[None], 1.0,
                           boundary=fv.Periodic())
    return {"pointwise": (dict(problem=advection, scheme=fv.WavePropagation(upwind(After(12)))), "stepping on"),
            "boundary": (dict(problem=attrs.evolve(dam(Honest()), boundary=(fv.Inflow(swell(After(12))), fv.Outflow()))),
                         "stepping on"),
            "observer": (dict(problem=dam(Honest()), observers=[After(7)]), "calling the observer After(calls=0)"),
            "progress": (dict(problem=dam(Honest()), observers=[lambda stepper: None], progress=After(0)), "showing progress"),
            "until": (dict(problem=dam(Honest()), until=StopAfter(every=3)), "evaluating StopAfter(every=3, asked=After(calls=0))")}


@pytest.mark.parametrize("which", cases())
def test_what_a_user_raises_is_passed_on_with_time_and_step_and_nothing_is_lost(which, tmp_path):
    given, doing = cases()[which]
    with pytest.raises(Trouble, match=r"^a mistake of the user's") as caught:
        solve(**given, checkpoint=fv.Checkpoint(tmp_path / "run.npz"))
    partial, (note,) = caught.value.solution, caught.value.__notes__
    when, where = note.split("; ")
    assert when == f"raised while {doing}, at t = {partial.t[-1]:.8g}, step {partial.stats.steps}"
    assert where == f"fv.resume({str(tmp_path / 'run.npz')!r}) goes on from here"
    assert (tmp_path / "run.npz").exists()
    assert partial.status is fv.Status.ERROR
    assert partial.stats.steps > 0
    given, _ = cases()[which]
    kept = solve(**given, throw=False)
    assert kept.status is fv.Status.ERROR
    assert not kept.success
    if which != "progress":  # that is shown when the clock says so
        assert kept.message == f"Trouble: a mistake of the user's; {when}"
        assert kept.q.tobytes() == partial.q.tobytes()


def test_the_partial_solution_is_that_of_a_run_that_stops_there(tmp_path):
    path = tmp_path / "run.npz"
    with pytest.raises(Trouble) as caught:
        solve(avalanche(), times=[0.05, 0.3], observers=[After(9)], checkpoint=fv.Checkpoint(path))
    partial = caught.value.solution
    same = solve(avalanche(), times=[0.05, 0.3], limits=fv.Limits(steps=10), throw=False)
    assert partial.stats.steps == 10
    assert partial.q.tobytes() == same.q.tobytes()
    whole = solve(avalanche(), times=[0.05, 0.3])
    assert fv.resume(path).q.tobytes() == whole.q.tobytes()


def test_an_exception_that_takes_no_attributes_is_passed_on_all_the_same():
    class Frozen(Exception):
        def __setattr__(self, name, value):
            raise AttributeError(f"no {name} here")

    def observer(stepper):
        raise Frozen

    with pytest.raises(Frozen):
        solve(dam(Honest()), observers=[observer])


def test_a_failed_member_of_a_sweep_says_when():
    def member(x):
        solve(dam(Honest()), observers=[After(x)])

    result = fv.sweep(member, {"x": [3]}, workers=1)
    assert result.status.tolist() == ["error"]
    assert "Trouble: a mistake of the user's; raised while calling the observer" in result.message[0]
    assert "step 4" in result.message[0]
