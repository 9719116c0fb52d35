"""Short runs of every model, solver and order give the numbers that they gave: see `fingerprints`."""

import json

import numpy as np
import pytest

from tests.granular.fingerprints import CASES, FILE, SCENES, TOLERANCE, distance, fingerprint, label, scene_of

KEPT = json.loads(FILE.read_text(encoding="utf-8"))


@pytest.mark.parametrize("case", CASES, ids=label)
def test_short_runs_give_the_numbers_that_they_gave(case):
    kept = KEPT[label(case)]
    assert len(kept) == SCENES
    for index, values in kept.items():
        found = distance(fingerprint(*case, scene_of(int(index), case[2])), np.array(values))
        assert found <= TOLERANCE, f"scene {index}; if the change is meant: python -m tests.granular.fingerprints --write"
