"""Objects that `solve` takes: limits, threads, records, sides by name, and what a checkpoint keeps of them."""

import numpy as np
import pytest

import fvkit as fv

RING = fv.Periodic()


def advected(boundary=RING, cells=40, t_end=1.0):
    return fv.Problem(fv.Advection(1.0), fv.Grid(0.0, 1.0, cells), lambda x: [1.0 + 0.5 * np.sin(2.0 * np.pi * x)], t_end, boundary=boundary)


def test_a_run_that_was_killed_goes_on_with_its_limits_and_one_that_reached_them_without(tmp_path):
    path = tmp_path / "run.npz"

    def killed(stepper):
        if stepper.steps == 5:
            raise KeyError("as a kill would")

    with pytest.raises(KeyError):
        fv.solve(advected(), limits=fv.Limits(steps=12), observers=killed, checkpoint=fv.Checkpoint(path))
    stopped = fv.resume(path, throw=False)
    assert (stopped.status, stopped.stats.steps) == (fv.Status.MAX_STEPS, 12)
    assert fv.resume(path).success


def test_a_budget_of_time_is_kept_in_the_checkpoint(tmp_path):
    path = tmp_path / "run.npz"
    part = fv.solve(advected(), limits=fv.Limits(seconds=1e6, steps=3), throw=False, checkpoint=fv.Checkpoint(path))
    assert part.status is fv.Status.MAX_STEPS
    assert fv.resume(path, limits=fv.Limits(seconds=1e-9), throw=False).status is fv.Status.OVER_BUDGET


def test_all_threads_are_one_where_they_would_not_pay():
    assert fv.Stepper(advected(), backend="numpy", threads="all").threads == 1
    with pytest.raises(TypeError, match=r"`threads` must be a whole number, got 'every' .*all"):
        fv.solve(advected(), threads="every")


def test_sides_have_names_and_a_missing_one_is_open():
    named, pair = (advected(given).ends for given in ({"left": fv.Inflow([2.0])}, (fv.Inflow([2.0]), fv.Outflow())))
    assert named == pair
    with pytest.raises(ValueError, match=r"`boundary` must be one of left, right; got 'lef'.* did you mean"):
        advected({"lef": fv.Wall()})


def test_phases_may_be_pairs_and_are_read_by_name():
    class Layer(fv.Model):
        conserved = ("h", "m")
        phases = (((0,), 1),)

        def flux(self, q):
            return q[1], q[0]

        def wave_speeds(self, q):
            return -1.0, 1.0

    assert Layer.phases == (fv.Phase((0,), 1),)
    assert Layer.phases[0].momentum == 1


def test_a_grid_knows_its_shape_and_the_volume_of_a_cell():
    grid = fv.Grid(-1.0, 1.0, 8)
    assert (grid.shape, grid.cell_volume, len(grid.axes)) == ((8,), 0.25, 1)
    np.testing.assert_array_equal(grid.axes[0].centers, grid.centers)
