"""The cases of docs/validation/terrain.md that need no data, at a small size. Bounds: the page's claims, with room for coarser cells."""

import numpy as np
import pytest

from tests.benchmarks import similarity, turned_releases


def test_a_turned_release_runs_out_as_far_to_one_cell():
    cell = 20.0
    found = np.array([turned_releases.reach(angle, cell) for angle in (0.0, 20.0, 45.0, 90.0)])
    assert np.abs(found[:, 0] - found[:, 0].mean()).max() < cell
    assert found[3] == pytest.approx(found[0], rel=0.01)


def test_a_cap_that_slides_and_spreads_comes_nearer_to_its_similarity_solution():
    coarse, fine = (similarity.errors(0.4, cells)[0] for cells in (80, 160))
    assert fine < 2.0**-0.5 * coarse, "order one half at least: its shore is of first order, and cells are coarse"


def test_the_waves_along_a_slope_are_those_of_vertical_columns_and_the_page_says_how_far_that_is():
    (coarse, _, _), (fine, thin, _) = (similarity.errors(0.0, cells) for cells in (80, 160))
    assert fine < 2.0**-0.5 * coarse
    assert fine < thin
