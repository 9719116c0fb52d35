"""Peers' pinned numbers, at their own size: docs/validation/peers.md."""

import numpy as np
import pytest

from tests.benchmarks import peers
from tests.benchmarks.channels import bump_missed
from tests.benchmarks.chapter import SCHEMES
from tests.cases import orders


@pytest.mark.parametrize("case", [peers.SHALLOW, peers.LAYERS], ids=["shallow", "layers"])
def test_the_fifth_order_beats_elements_of_degree_3_at_equal_degrees_of_freedom(case):
    found = np.array([peers.manufactured_errors(case, SCHEMES["MP5"], cells) for cells in (32, 64)])
    assert (found[0] < np.array(case.peer) / 3.0).all()
    assert orders(found).min() > 4.5


def test_a_forcing_makes_a_manufactured_flow_one_of_second_order():
    found = np.array([peers.manufactured_errors(peers.SHALLOW, SCHEMES["Roe"], cells) for cells in (64, 128)])
    assert orders(found).min() > 1.6


@pytest.mark.parametrize("scheme", ["Roe", "Relaxation"])
def test_a_standing_jump_is_nearer_to_bernoulli_than_trixi_has_it_and_kept_with_a_background(scheme):
    def missed(background):
        return peers.rms(bump_missed("jump", SCHEMES[scheme], 512, background, t=0.25, still=False, length=32.0))

    assert (missed(False) < np.array(peers.MOVING["jump"])).all()
    assert missed(True).max() < 1e-15


def test_two_layers_that_break_over_a_step_change_as_trixi_has_it():
    np.testing.assert_allclose(peers.step_change(SCHEMES["HLL"]), peers.STEP, rtol=0.07)


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
