"""MacDonald's channels converge, between the ends that a user would take."""

import numpy as np
import pytest

import fvkit as fv
import fvkit_granular as gr
from tests.benchmarks.macdonald import CHANNELS, RAINY, error
from tests.cases import name_of, orders


@pytest.mark.parametrize(("name", "riemann"), list(zip(CHANNELS | RAINY, (gr.Relaxation(), fv.Roe()) * 3, strict=True)), ids=name_of)
def test_steady_channels_with_friction_converge(name, riemann):
    pytest.importorskip("numba", reason="too slow uncompiled")
    found = [error((CHANNELS | RAINY)[name], riemann, cells, "numba") for cells in (100, 200, 400)]
    depths, discharges = np.array(found).T
    if name in ("super- to subcritical", "supercritical, rain"):  # a jump; an end whose ghost cells know nothing of the rain
        assert orders(depths).min() > 0.9
        assert depths[-1] < 1e-3
    else:
        assert orders(depths)[-1] > 1.9
        assert orders(discharges)[-1] > 1.9 if name in RAINY else discharges[-1] < 2e-6
        assert depths[-1] < 1e-5
