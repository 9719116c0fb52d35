"""Terrain: cells without data have no height, windows and averages keep what they cover, reports count what is there."""

import warnings

import numpy as np
import pytest

import fvkit as fv
import fvkit_granular as gr
from tests.terrain.rasters import LAMBERT, ramp


def test_a_cell_without_data_has_no_height():
    masked = np.zeros((2, 3), dtype=bool)
    masked[1, 2] = True
    grid = fv.Grid((0.0, 0.0), (30.0, 20.0), (3, 2))
    given = gr.Terrain(grid, np.ones((2, 3)), missing=masked)
    assert np.isnan(given.bottom[1, 2])
    as_nan = gr.Terrain(grid, [[1, 1, 1], [1, 1, np.nan]])
    as_masked_array = gr.Terrain(grid, np.ma.array(np.ones((2, 3)), mask=masked))
    assert given == as_nan == as_masked_array
    np.testing.assert_array_equal(as_nan.missing, masked)
    for values in (given.bottom, given.missing):
        with pytest.raises(ValueError, match="read-only"):
            values[0, 0] = 0


@pytest.mark.parametrize(("change", "words"), [
    (dict(grid=fv.Grid(0.0, 1.0, 3)), "two axes"), (dict(bottom=np.ones((3, 2))), "shape"), (dict(bottom=np.full((2, 3), np.nan)), "a cell with data"),
    (dict(bottom=[[1, 1, 1], [1, np.inf, 1]]), "finite"), (dict(bottom=[[1, 1, 1], [1, -9999, 1]]), r"x = 15, y = 15.*code for no data"),
    (dict(bottom=np.full((2, 3), 20000.0)), "code for no data"), (dict(missing=np.ones((2, 3), dtype=bool)), "a cell with data"),
    (dict(missing=np.ones((3, 3), dtype=bool)), "missing.*shape"), (dict(missing=np.ones((2, 3))), "True and False"),
    (dict(crs='GEOGCS["WGS 84"]'), "degrees"), (dict(crs="EPSG:4326"), "degrees"), (dict(crs='COMPD_CS["WGS 84 + EGM96",GEOGCS["WGS 84"]]'), "degrees"), (dict(crs="Projection GEOGRAPHIC\nUnits DD"), "degrees"),
    (dict(crs='PROJCS["NAD83 / Ohio",UNIT["US survey foot",0.3048006096012192]]'), "feet"), (dict(crs=31287), "text")])
def test_what_is_no_terrain_is_refused(change, words):
    good = dict(grid=fv.Grid((0.0, 0.0), (30.0, 20.0), (3, 2)), bottom=np.ones((2, 3)))
    with pytest.raises((ValueError, TypeError), match=words):
        gr.Terrain(**good | change)


def test_a_window_has_the_cells_whose_centres_it_contains():
    whole = ramp(crs=LAMBERT, name="ramp")
    part = whole.window((1004.0, 2007.5), (1019.0, 2020.0))
    np.testing.assert_array_equal(part.bottom, whole.bottom[1:4, 1:4])
    assert part.grid == fv.Grid((1005.0, 2005.0), (1020.0, 2020.0), (3, 3))
    assert (part.crs, part.name) == (LAMBERT, "ramp")
    assert whole.window((1000.0, 2000.0), (1040.0, 2030.0)) == whole
    for corners, words in [(((1004.0, 2000.0), (1006.0, 2030.0)), "centre of a cell"), (((1000.0, 2020.0), (1040.0, 2010.0)), "y from 2020 to 2010"),
                           (((900.0, 2000.0), (1040.0, 2030.0)), "within the terrain, x from 1000 to 1040 m, got x from 900"),
                           ((1000.0, (1040.0, 2030.0)), "lower")]:
        with pytest.raises((ValueError, TypeError), match=words):
            whole.window(*corners)


@pytest.mark.parametrize("cell", [10.0, 7.5, 9.1])
def test_a_plane_stays_a_plane_on_larger_cells(cell):
    fine = ramp()
    coarse = fine.coarser(cell)
    x, y = coarse.grid.axes
    assert x.dx == pytest.approx(cell)
    assert (x.lower, y.lower) == (1000.0, 2000.0)
    assert 0.0 <= fine.grid.axes[0].upper - x.upper < cell
    covered = (x.upper - 1000.0) / 2.0, (y.upper - 2000.0) / 2.0
    assert np.mean(coarse.bottom) == pytest.approx(500.0 - 0.5 * covered[0] + 0.25 * covered[1], abs=0.0 if cell == 10.0 else 0.3)
    if cell == 10.0:
        np.testing.assert_allclose(coarse.bottom, 500.0 - 0.5 * (x.centers - 1000.0) + 0.25 * (y.centers - 2000.0)[:, None], rtol=1e-14)


def test_a_larger_cell_averages_by_area_what_it_knows_of_at_least_half():
    tall = gr.Terrain(fv.Grid((0.0, 0.0), (6.0, 3.0), (6, 3)), [[1.0, 2.0, 3.0, np.nan, np.nan, 6.0]] * 3)
    np.testing.assert_allclose(tall.coarser(1.5).bottom[0], [(1.0 + 0.5 * 2.0) / 1.5, (0.5 * 2.0 + 3.0) / 1.5, np.nan, 6.0])
    assert tall.coarser(1.0) is tall
    for cell, words in [(0.5, "no finer"), (4.0, "at most the size of the terrain, 6 x 3 m"), (0.0, "> 0")]:
        with pytest.raises(ValueError, match=words):
            tall.coarser(cell)


def test_enclosed_holes_are_filled_smoothly_and_the_rest_stays():
    hole = [(2, 2), (2, 3), (3, 3), (0, 0), (0, 1)]
    terrain = ramp(missing=hole)
    filled = terrain.filled()
    np.testing.assert_allclose(filled.bottom[2:4, 2:4], ramp().bottom[2:4, 2:4], rtol=1e-13)  # a plane solves Laplace's equation
    assert set(map(tuple, np.argwhere(filled.missing).tolist())) == {(0, 0), (0, 1)}
    assert "3 of them in holes" in terrain.describe()
    assert ramp().filled() == ramp()


def test_slopes_are_those_of_the_plane_also_beside_cells_without_data():
    terrain = ramp(slope=(-0.6, 0.8), missing=[(0, 0), (3, 3), (3, 4)])
    b_x, b_y = terrain.gradient
    np.testing.assert_allclose(b_x[~terrain.missing], -0.6)
    np.testing.assert_allclose(b_y[~terrain.missing], 0.8)
    assert b_x[3, 3] == b_y[3, 3] == 0.0
    report = ramp(slope=(-0.6, 0.8)).slopes()
    assert report.steepest == pytest.approx(45.0)
    assert report.over[30.0] == 1.0
    assert "steepest 45.0 degrees at x = " in str(report)


def test_depressions_hold_what_does_not_reach_an_edge_or_a_cell_without_data():
    bottom = np.full((5, 9), 10.0)
    bottom[2, 2], bottom[2, 5:7], bottom[0, 8], bottom[1, 4] = 7.0, 9.0, 0.0, 9.5
    bottom[2, 1] = 9.0
    grid = fv.Grid((0.0, 0.0), (18.0, 10.0), (9, 5))
    found = gr.Terrain(grid, bottom).depressions()
    assert (found.count, found.volume, found.deepest) == (3, (3.0 + 1.0 + 2.0 + 0.5) * 4.0, 3.0)
    bottom[2, 3] = np.nan
    assert gr.Terrain(grid, bottom).depressions().volume == (2.0 + 0.5) * 4.0
    assert "3 depressions hold 26 m3" in str(found)


@pytest.mark.parametrize(("cell", "factor", "words"), [(5.0, 1.0, None), (0.001, 1.0, "coordinates may be in km or degrees"), (50.0, 1e-3, "elevations may be in km")])
def test_another_unit_is_noticed(cell, factor, words):
    grid = fv.Grid((0.0, 0.0), (8 * cell, 6 * cell), (8, 6))
    terrain = gr.Terrain(grid, factor * (100.0 + ramp().bottom - 500.0))
    if words is None:
        with warnings.catch_warnings():
            warnings.simplefilter("error")
            terrain.warn_of_units()
    else:
        with pytest.warns(RuntimeWarning, match=words):
            terrain.warn_of_units()


def test_a_terrain_says_what_it_is():
    assert repr(ramp(missing=[(0, 0)], name="slope")) == "Terrain('slope': 8 x 6 cells of 5 m, 481.88 to 505.62 m, 1 without data)"
    text = ramp(crs=LAMBERT).describe()
    assert "x 1000 to 1040 m, y 2000 to 2030 m, MGI / Austria Lambert" in text
    assert "over 45 degrees" in text


def test_places_on_a_map_have_digits_enough():
    terrain = ramp(corner=(4_512_000.0, 5_300_000.0), cell=2.5, missing=[(0, 0)])
    assert terrain.grid.located(0) == "x = 4512001.25, y = 5300001.25"
    with pytest.raises(ValueError, match=r"x = 4512001\.25, y = 5300001\.25, which looks like a code"):
        gr.Terrain(terrain.grid, np.where(terrain.missing, -32768.0, 5.0))
