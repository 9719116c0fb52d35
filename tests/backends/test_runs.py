"""Compiled runs come back to Python: progress, Ctrl-C with a partial solution, threads that change no bit."""

import os
import signal
import threading
import time

import numpy as np
import pytest

import fvkit as fv
import fvkit_granular as gr
from fvkit.backends.compiled import threads


def long_run() -> fv.Problem:
    return fv.Problem(gr.ShallowWater(), fv.Grid(0.0, 1.0, 400), lambda x: np.stack([1.0 + 0.1 * np.sin(2 * np.pi * x), 0.0 * x]),
                      1e6, boundary=fv.Periodic())


@pytest.mark.parametrize("backend", ["numba", "numpy"])
@pytest.mark.parametrize("throw", [True, False])
def test_an_interrupted_run_keeps_its_partial_solution(backend, throw):
    fv.solve(long_run(), backend=backend, limits=fv.Limits(steps=3), throw=False)
    killer = threading.Timer(1.0, os.kill, (os.getpid(), signal.SIGINT))
    killer.start()
    started = time.perf_counter()
    if throw:
        with pytest.raises(fv.Interrupted) as caught:
            fv.solve(long_run(), backend=backend)
        assert isinstance(caught.value, KeyboardInterrupt)
        assert isinstance(caught.value, fv.SolveError)
        solution = caught.value.solution
    else:
        solution = fv.solve(long_run(), backend=backend, throw=False)
    assert time.perf_counter() - started < 60.0  # it would go on for days
    assert solution.status is fv.Status.INTERRUPTED
    assert 0.0 < solution.t[-1] < 1e6
    assert solution.q.shape == (2, 2, 400)
    stepper = fv.Stepper(long_run(), backend=backend)
    stepper.run(np.inf, solution.stats.steps)
    assert stepper.t == solution.t[-1]
    assert np.array_equal(stepper.q, solution.q[-1])


def test_progress_is_told_during_a_compiled_run():
    shares: list[float] = []
    problem = fv.Problem(gr.TwoPhase(), fv.Grid(0.0, 1.0, 4000), lambda x: gr.TwoPhase().conserved_from(
        1.0 + 0.1 * np.sin(2 * np.pi * x), 0.5), 0.5, boundary=fv.Periodic())
    assert fv.solve(problem, backend="numba", progress=shares.append).success
    assert len(shares) >= 2
    assert shares == sorted(shares)
    assert shares[-1] == 1.0


def test_threads_change_no_bit(monkeypatch):
    monkeypatch.setattr(threads, "SMALLEST", 1000)
    for boundary in (fv.Periodic(), fv.Outflow()):
        problem = fv.Problem(gr.TwoPhase(), fv.Grid(0.0, 1.0, 3000), lambda x: gr.TwoPhase().conserved_from(
            1.0 + 0.1 * np.sin(6 * np.pi * x), 0.5 + 0.2 * np.cos(x), 0.3), 0.02, boundary=boundary)
        one, two, three = (fv.solve(problem, backend="numba", threads=count) for count in (1, 2, 3))
        assert np.array_equal(one.q, two.q)
        assert np.array_equal(one.q, three.q)
        assert one.stats.steps == two.stats.steps
        assert one.stats.mass_drift == pytest.approx(two.stats.mass_drift, abs=1e-15)


def test_threads_are_refused_where_they_cost_more_than_they_gain():
    with pytest.raises(ValueError, match=r"`threads` pays from 100000 cells on, got 2 threads for 400 cells"):
        fv.solve(long_run(), backend="numba", threads=2)
    with pytest.raises(ValueError, match=r"`threads` needs the compiled backend"):
        fv.solve(long_run(), backend="numpy", threads=2)
    with pytest.raises(ValueError, match=r"`threads` must be >= 1"):
        fv.solve(long_run(), threads=0)


def test_a_missing_numba_is_named_with_the_extra(monkeypatch):
    monkeypatch.setattr("fvkit.backends.available", lambda: False)
    with pytest.raises(ValueError, match=r"not installed: pip install 'fvkit\[fast\]'"):
        fv.solve(long_run(), backend="numba")
    assert fv.solve(long_run(), limits=fv.Limits(steps=2), throw=False).stats.backend == "numpy"
