"""The small sizes of long and large runs. In full: ``python -m tests.robust.full long|large|soak``."""

import sys

import numpy as np
import pytest

import fvkit as fv
from tests.robust import long_runs

linux = pytest.mark.skipif(sys.platform != "linux", reason="reads /proc")


@pytest.mark.parametrize("boundary", [fv.Periodic(), fv.Wall()], ids=["ring", "basin"])
def test_mass_is_kept_over_many_steps(boundary):
    change, speed, sound = long_runs.long_run(long_runs.waves(60, boundary), 2000, "numpy")
    assert change < 1e-12
    assert sound
    assert speed > 1e-6, "nothing moves: this says nothing"


def test_rest_does_not_drift():
    few = long_runs.long_run(long_runs.rest(60), 200, "numpy")[1]
    change, speed, _ = long_runs.long_run(long_runs.rest(60), 2000, "numpy")
    assert change < 1e-13
    assert speed < 1e-13
    assert speed < 5.0 * few + 1e-15


@linux
def test_a_large_grid_needs_no_more_states_than_stated():
    """On NumPy 2.x copies and temporaries of a chunk; compiled, two copies: tests/backends/test_kernels.py and tests/LOG.md."""
    state, traced, _ = long_runs.large_run(500_000, 2, "numpy")
    assert traced < 3.6 * state + 20_000_000


@linux
def test_a_sweep_of_many_members_keeps_all_and_does_not_grow(tmp_path):
    result, own, worker = long_runs.soak(300, tmp_path / "sweep")
    assert result.success
    assert np.isfinite(result.outputs["largest"]).all()
    assert own < 20_000_000
    assert worker < 2_000_000
    again = fv.sweep(long_runs.member, {"amplitude": result.samples.values["amplitude"], "cells": [20] * 300}, workers=1,
                     folder=tmp_path / "sweep")
    assert again.outputs["largest"].tobytes() == result.outputs["largest"].tobytes()
