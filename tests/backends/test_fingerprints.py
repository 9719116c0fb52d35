"""Compiled short runs give the numbers that are kept of NumPy's: a covering set of models, solvers, orders and settings."""

import json

import numpy as np
import pytest

import fvkit as fv
import fvkit_granular as gr
from tests.granular.fingerprints import FILE, TOLERANCE, distance, fingerprint, scene_of
from tests.tools.random_draws import setting_of

pytest.importorskip("numba")
KEPT = json.loads(FILE.read_text(encoding="utf-8"))

#: With the setting, which says ends and sources: each is a kernel.
CASES = [("two-layer", "roe", 2, "box"), ("two-phase", "hll", 1, "ring"), ("two-layer", "rusanov", 1, "channel"),
         ("two-phase", "relaxation", 5, "channel"), ("reduced", "rusanov", 5, "box"), ("shallow-water", "roe", 1, "ring")]


@pytest.mark.parametrize(("model", "riemann", "order", "setting"), CASES)
def test_compiled_short_runs_give_the_numbers_of_numpy(model, riemann, order, setting):
    kept = {int(index): values for index, values in KEPT[f"{model} {riemann} {order}"].items() if setting_of(int(index)) == setting}
    assert len(kept) >= 2
    for index, values in kept.items():
        assert distance(fingerprint(model, riemann, order, scene_of(index, order), "numba"), np.array(values)) <= TOLERANCE, f"scene {index}"


def test_compiled_cells_that_shocks_cross_are_those_of_numpy():
    q = gr.ShallowWater().conserved_from(np.where(np.arange(100) < 50, 2.0, 1.0), 0.0, 0.0)
    problem = fv.Problem(gr.ShallowWater(), fv.Grid(0.0, 10.0, 100), q, 1.0, aux={"b": np.zeros(100)})
    compiled, plain, without = (fv.solve(problem, fv.WavePropagation(fv.Roe(), in_cell_shocks=inside), backend=backend, limits=fv.Limits(steps=20), throw=False).q[-1]
                                for backend, inside in (("numba", True), ("numpy", True), ("numpy", False)))
    np.testing.assert_allclose(compiled, plain, atol=1e-12)
    assert np.abs(plain - without).max() > 1e-3
