"""Compiled short runs give the numbers that are kept of NumPy's: a covering set of models, solvers, orders and settings."""

import json

import numpy as np
import pytest

from fvkit_granular.stress.draws import setting_of
from tests.granular.fingerprints import FILE, TOLERANCE, distance, fingerprint, scene_of

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
