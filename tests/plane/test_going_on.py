"""Checkpoints of runs on grids with two axes: a continued run is the run, bit for bit."""

from functools import partial

import numpy as np
import pytest

import fvkit as fv
import fvkit_granular as gr
from fvkit.files import Unreadable
from tests.plane.scenes import pool, same_bits

TIMES = [0.1, 0.25, 0.4]


def same(one, other):
    assert same_bits(one.t, other.t)
    assert same_bits(one.q, other.q)
    for name in ("steps", "rejected", "max_cfl", "mass_drift", "entered_by_sources"):
        assert getattr(one.stats, name) == getattr(other.stats, name), name


@pytest.mark.parametrize("steps", [1, 2, 3, 4, 5])
@pytest.mark.parametrize("model", [gr.ShallowWater(), gr.TwoPhase()])
def test_a_continued_run_is_the_run(model, steps, tmp_path):
    whole = fv.solve(pool(model), times=TIMES, backend="numpy")
    assert whole.stats.steps > 5
    fv.solve(pool(model), times=TIMES, limits=fv.Limits(steps=steps), checkpoint=fv.Checkpoint(tmp_path / "run.npz"),
             backend="numpy", throw=False)
    gone_on = fv.resume(tmp_path / "run.npz")
    same(gone_on, whole)
    assert gone_on.configuration["boundary"] == whole.configuration["boundary"]


@pytest.mark.parametrize("sources", [
    gr.Manning(np.linspace(0.01, 0.1, 84).reshape(7, 12)),
    [gr.Manning(0.05), fv.Forcing(np.linspace(0.0, 0.1, 252).reshape(3, 7, 12))]])
def test_sources_that_vary_over_the_cells_go_on(sources, tmp_path):
    whole = fv.solve(pool(sources=sources), times=TIMES, backend="numpy")
    fv.solve(pool(sources=sources), times=TIMES, limits=fv.Limits(steps=3), checkpoint=fv.Checkpoint(tmp_path / "run.npz"),
             backend="numpy", throw=False)
    same(fv.resume(tmp_path / "run.npz"), whole)


def test_steps_in_the_other_order_would_be_seen(tmp_path):
    problem = partial(pool, t_end=0.2)
    whole = fv.solve(problem(), backend="numpy")
    fv.solve(problem(), limits=fv.Limits(steps=1), checkpoint=fv.Checkpoint(tmp_path / "run.npz"), backend="numpy", throw=False)
    with np.load(tmp_path / "run.npz") as file:
        arrays = dict(file)
    arrays["count"][0] += 1
    np.savez(tmp_path / "run.npz", **arrays)
    assert not np.array_equal(fv.resume(tmp_path / "run.npz").q[-1], whole.q[-1])


def test_a_later_end_time_is_one_more_output(tmp_path):
    fv.solve(pool(t_end=0.25), times=[0.1, 0.25], checkpoint=fv.Checkpoint(tmp_path / "run.npz"), backend="numpy")
    same(fv.resume(tmp_path / "run.npz", t_end=0.4), fv.solve(pool(), times=TIMES, backend="numpy"))


def test_compiled_runs_go_on_too(tmp_path):
    pytest.importorskip("numba", reason="the compiled backend needs the extra `fast`")
    whole = fv.solve(pool(), times=TIMES, backend="numba")
    fv.solve(pool(), times=TIMES, limits=fv.Limits(steps=3), checkpoint=fv.Checkpoint(tmp_path / "run.npz"), backend="numba",
             throw=False)
    same(fv.resume(tmp_path / "run.npz"), whole)


@pytest.mark.parametrize("name", ["q", "aux_b", "now"])
def test_a_checkpoint_with_exchanged_axes_is_refused(name, tmp_path):
    fv.solve(pool(), limits=fv.Limits(steps=1), checkpoint=fv.Checkpoint(tmp_path / "run.npz"), backend="numpy", throw=False)
    with np.load(tmp_path / "run.npz") as file:
        arrays = dict(file)
    arrays[name] = arrays[name].swapaxes(-1, -2)
    np.savez(tmp_path / "run.npz", **arrays)
    with pytest.raises(Unreadable, match=r"shape"):
        fv.resume(tmp_path / "run.npz")


def test_records_of_observers_go_on(tmp_path):
    def watched():
        return fv.Gauge([(1.0, 0.0), (4.0, 1.0)], dt=0.05), fv.Extremes()

    whole, first, second = watched(), watched(), watched()
    fv.solve(pool(), observers=whole, backend="numpy")
    fv.solve(pool(), observers=first, limits=fv.Limits(steps=3), checkpoint=fv.Checkpoint(tmp_path / "run.npz"),
             backend="numpy", throw=False)
    fv.resume(tmp_path / "run.npz", observers=second)
    assert same_bits(second[0].t, whole[0].t)
    assert all(same_bits(second[0].values[name], values) for name, values in whole[0].values.items())
    for which in ("largest", "smallest", "when"):
        assert all(same_bits(getattr(second[1], which)[name], values) for name, values in getattr(whole[1], which).items())
