"""The granular part of the validation chapter, at a small size: docs/validation/granular.md."""

import numpy as np
import pytest

import fvkit_granular as gr
from tests.benchmarks import granular
from tests.benchmarks.chapter import SCHEMES
from tests.benchmarks.granular import CAPS, DAMS, LAWS, Cap
from tests.cases import orders

SOLVERS = ("Relaxation", "Roe", "HLL", "Rusanov")


def test_the_cap_keeps_its_energy():
    """The half length is that of a body that the pressure pushes: L'^2/2 = 2 g H0 L0 (1/L0 - 1/L)."""
    cap = Cap(9.0)
    half, rate = cap.size(3.0)
    assert 0.5 * rate**2 == pytest.approx(2.0 * 9.0 * cap.height * cap.half * (1.0 / cap.half - 1.0 / half), rel=1e-10)
    assert half > 1.5 * cap.half


@pytest.mark.parametrize("solver", SOLVERS)
@pytest.mark.parametrize("name", CAPS)
def test_a_cap_slides_and_spreads_with_every_solver(name, solver):
    found = np.array([granular.cap_errors(CAPS[name], SCHEMES[solver], cells) for cells in (100, 200)])
    assert orders(found[:, 0])[0] > 1.0
    assert found[1, 0] < 0.03 * 0.17  # of the mean depth
    assert abs(found[1, 2]) < 0.1


@pytest.mark.parametrize("solver", ["Relaxation", "Roe"])
@pytest.mark.parametrize("name", CAPS)
def test_dry_grains_slide_alike_in_every_model(name, solver):
    """Fluid that is absent has no velocity, and so no slip: friction once lost its hold on the waves of grains alone."""
    errors = [granular.cap_errors(CAPS[name], SCHEMES[solver], 200, model)[0] for model in (gr.ShallowWater, gr.Reduced, gr.TwoPhase)]
    assert max(errors) < 1.1 * min(errors)


@pytest.mark.parametrize("solver", SOLVERS)
@pytest.mark.parametrize("name", DAMS)
def test_a_dam_break_slides_down_a_dry_slope(name, solver):
    found = np.array([granular.dam_errors(DAMS[name], SCHEMES[solver], cells) for cells in (100, 200)])
    assert orders(found[:, 0])[0] > 0.6
    assert found[1, 0] < 0.01
    assert np.abs(found[:, 1]).max() < 1e-2


@pytest.mark.parametrize("name", LAWS)
def test_a_layer_gains_its_speed_to_second_order(name):
    found = [granular.speed_error(name, cells) for cells in (25, 50, 100)]
    assert found[-1] < 1e-12 or orders(found).min() > 1.5


@pytest.mark.parametrize("name", ["pile", "toe"])
def test_piles_rest_to_the_last_bit(name):
    assert granular.moved(name, gr.TwoPhase, SCHEMES["Relaxation"]) == 0.0


def test_the_column_runs_out_farther_than_measured_and_that_is_the_model():
    """One to five times too far, whatever the cells: constant friction and hydrostatic pressure."""
    far, _ = granular.run_out(1.0, 200)
    assert 1.2 < far < 5.0 * 1.2
