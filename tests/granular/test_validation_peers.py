"""Peers' pinned numbers, at their own size: docs/validation/peers.md."""

import numpy as np
import pytest

from tests.benchmarks import peers
from tests.benchmarks.chapter import SCHEMES
from tests.cases import orders


@pytest.mark.parametrize("case", [peers.SHALLOW, peers.LAYERS], ids=["shallow", "layers"])
def test_the_fifth_order_beats_elements_of_degree_3_at_equal_degrees_of_freedom(case):
    found = np.array([peers.manufactured_errors(case, SCHEMES["MP5"], cells) for cells in (32, 64)])
    assert (found[0] < np.array(case.peer) / 3.0).all()
    assert orders(found).min() > 4.5


def test_sources_of_manufactured_flows_are_those_that_the_equations_leave():
    """Of the flow at one speed v the mass is left with h_t + v h_x."""
    x, t = np.linspace(0.0, 1.4, 9), 0.02
    wave, pulse = peers.WAVE, 2.0 * np.pi
    bed = 0.25 * wave * np.cos(0.5 * wave * x)
    expected = -pulse * np.cos(wave * x) * np.sin(pulse * t) + 0.5 * (-wave * np.sin(wave * x) * np.cos(pulse * t) - bed)
    np.testing.assert_allclose(peers.source(peers.SHALLOW, x, t)[0], expected, rtol=0.0, atol=1e-9)


def test_the_dam_break_is_as_near_as_pyclaws():
    assert peers.dam_error(SCHEMES["Roe"]) < 1.1 * peers.PYCLAW_DAM["PyClaw, classic, Roe"]
    assert peers.dam_error(SCHEMES["HLL"]) < peers.PYCLAW_DAM["PyClaw, classic, HLLE"]


def test_the_sill_comes_nearer_to_a_finer_grid():
    reference = peers.sill_depth(SCHEMES["Roe"], 1000)
    found = [peers.sill_error(SCHEMES["Roe"], cells, reference) for cells in (125, 250)]
    assert orders(found)[0] > 0.9
    assert found[1] < 2e-4
