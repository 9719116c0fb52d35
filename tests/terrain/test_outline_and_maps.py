"""Scores against an observed outline, and what a map shows."""

import numpy as np
import pytest
from matplotlib.contour import ContourSet
from matplotlib.figure import Figure
from PIL import Image

import fvkit as fv
import fvkit_granular as gr
from fvkit_granular.terrain.maps import film_map
from tests.terrain.rasters import LAMBERT, ramp

OUTLINE = {"type": "Polygon", "coordinates": [[[1007.0, 2005.0], [1025.0, 2005.0], [1025.0, 2020.0], [1007.0, 2020.0], [1007.0, 2005.0]]]}


def reached(rows, columns, depth=0.5):
    """Return depths on the ramp: of the cells of some rows and columns."""
    values = np.zeros((6, 8))
    values[rows, columns] = depth
    return values


def test_areas_add_up_to_what_was_computed_and_observed():
    terrain = ramp()
    score = gr.compare_outline(reached(slice(1, 3), slice(0, 4)), OUTLINE, terrain)
    assert (score.hits, score.misses, score.false_alarms, score.beyond) == pytest.approx((130.0, 140.0, 70.0, 0.0))
    assert score.hit_rate == pytest.approx(130.0 / 270.0)
    assert score.false_alarm_ratio == pytest.approx(70.0 / 200.0)
    assert score.critical_success_index == pytest.approx(130.0 / 340.0)
    assert "hits 130 m2, misses 140 m2, false alarms 70 m2" in str(score)


def test_what_was_observed_beyond_the_terrain_is_told_apart():
    wide = {"type": "Polygon", "coordinates": [[[1007.0, 1990.0], [1025.0, 1990.0], [1025.0, 2020.0], [1007.0, 2020.0]]]}
    terrain = ramp(missing=[(2, 3)])
    score = gr.compare_outline(reached(slice(0, 3), slice(0, 4)), wide, terrain)
    assert score.beyond == pytest.approx(18.0 * 10.0 + 25.0)
    assert score.hits + score.misses == pytest.approx(18.0 * 20.0 - 25.0)
    assert "205 m2 were observed beyond" in str(score)


def test_rasters_and_arrays_are_outlines_too(tmp_path):
    terrain, values = ramp(crs=LAMBERT), reached(slice(1, 3), slice(0, 4))
    values[0, 0] = np.nan
    observed = reached(slice(2, 4), slice(0, 4), 1.0)
    path = gr.write_raster(tmp_path / "observed.asc", np.where(observed > 0.0, observed, np.nan), terrain)
    assert gr.compare_outline(path, observed, terrain) == gr.compare_outline(observed, observed, terrain)
    for given in (observed, path):
        assert gr.compare_outline(values, given, terrain) == gr.OutlineScore(100.0, 100.0, 100.0)
    assert gr.compare_outline(values, observed, terrain, above=0.6).hits == 0.0
    nothing = gr.compare_outline(np.zeros((6, 8)), np.zeros((6, 8)), terrain)
    assert np.isnan([nothing.hit_rate, nothing.false_alarm_ratio, nothing.critical_success_index]).all()


@pytest.mark.parametrize(("change", "words"), [(dict(values=np.ones((2, 2))), r"shape of the terrain, \(6, 8\)"), (dict(observed=np.ones((2, 2))), r"`observed` must have shape"),
                                               (dict(observed="outline.kml"), r"`observed` must be a file that ends in \.geojson"), (dict(above="deep"), "above"),
                                               (dict(observed={"type": "FeatureCollection", "features": [{"type": "Feature", "geometry": OUTLINE}] * 2}), "must not overlap"),
                                               (dict(terrain="dem.asc"), "instance of Terrain")])
def test_outlines_that_do_not_fit_are_refused(change, words):
    with pytest.raises((ValueError, TypeError), match=words):
        gr.compare_outline(**dict(values=np.zeros((6, 8)), observed=OUTLINE, terrain=ramp()) | change)


def test_an_outline_beyond_the_terrain_is_refused():
    away = {"type": "Polygon", "coordinates": [[[47.1, 10.2], [47.2, 10.2], [47.2, 10.3]]]}
    with pytest.raises(ValueError, match="`observed` must reach into the terrain"):
        gr.compare_outline(np.zeros((6, 8)), away, gr.Terrain(fv.Grid((1000.0, 2000.0), (1080.0, 2060.0), (8, 6)), np.zeros((6, 8))))


def test_a_map_shows_ground_results_release_and_scale(tmp_path):
    terrain = ramp(nx=80, ny=60, missing=[(0, 0), (59, 79)])
    release = gr.read_release(OUTLINE, terrain, 1.0)
    values = np.where(release.thickness > 0.0, 2.0, 0.01)
    axes = gr.draw_map(terrain, values, "depth, m", release=release, above=0.05, highest=3.0)
    ground, results = axes.get_images()
    assert ground.get_array().mask.sum() == 2
    assert 0.0 < ground.get_array().min() <= ground.get_array().max() <= 1.0
    np.testing.assert_array_equal(~np.ma.getmaskarray(results.get_array()), release.thickness > 0.0)
    assert results.get_extent() == [1000.0, 1400.0, 2000.0, 2300.0]
    assert results.origin == "lower"
    assert results.colorbar.ax.get_ylabel() == "depth, m"
    assert results.get_clim() == (0.05, 3.0)
    assert sum(isinstance(item, ContourSet) for item in axes.get_children()) == 2
    assert any("100 m" in text.get_text() for text in axes.artists[0].findobj(lambda item: hasattr(item, "get_text")))
    assert "N" in [text.get_text() for text in axes.texts]
    axes.figure.savefig(tmp_path / "map.png")
    alone = gr.draw_map(ramp(), ax=Figure().subplots())
    assert len(alone.get_images()) == 1


@pytest.mark.parametrize("size", [(80, 60), (120, 12), (12, 120)])
def test_the_scale_bar_lies_beside_the_map_and_within_the_picture(size):
    axes = gr.draw_map(ramp(*size), np.ones(size[::-1]))
    figure = axes.figure
    figure.canvas.draw()
    bar, ground = axes.artists[0].get_window_extent(), axes.get_window_extent()
    assert bar.y0 >= ground.y1 - 1.0
    assert figure.bbox.x0 <= bar.x0 < bar.x1 <= figure.bbox.x1
    assert bar.y1 <= figure.bbox.y1


def test_a_film_of_a_terrain_shows_every_output_over_its_relief(tmp_path):
    terrain = ramp(nx=20, ny=15)
    scene = gr.Scene(terrain=terrain, release=gr.read_release(OUTLINE, terrain, 1.0, 0.5), t_end=4.0)
    solution = fv.solve(scene.problem(gr.ShallowWater), times=[1.0, 2.0, 3.0, 4.0], backend="numpy")
    film = film_map(solution, terrain, tmp_path / "film.gif", scene.release)
    with Image.open(film) as frames:
        assert frames.n_frames == len(solution.t) == 5
        first = np.array(frames.convert("RGB"))
        frames.seek(4)
        assert (np.array(frames.convert("RGB")) != first).mean() > 0.005
    with pytest.raises(ValueError, match="`solution` must be on the grid of the terrain"):
        film_map(solution, ramp(), tmp_path / "other.gif")


def test_the_side_towards_the_sun_is_the_brighter_one():
    x = np.arange(20.0)
    ridge = gr.Terrain(fv.Grid((0.0, 0.0), (20.0, 20.0), (20, 20)), 10.0 - np.abs(x - 9.5) + np.zeros((20, 1)))
    light = gr.draw_map(ridge).get_images()[0].get_array()
    assert light[:, :8].min() > light[:, 12:].max()  # the sun stands in the north-west
    light = gr.draw_map(gr.Terrain(ridge.grid, ridge.bottom.T)).get_images()[0].get_array()
    assert light[12:].min() > light[:8].max()


@pytest.mark.parametrize(("change", "words"), [(dict(values=np.ones((2, 2))), "shape of the terrain"), (dict(terrain=None), "Terrain"), (dict(release=3), "Release"),
                                               (dict(highest=-1.0), "highest"), (dict(above="deep"), "above")])
def test_maps_of_what_does_not_fit_are_refused(change, words):
    with pytest.raises((ValueError, TypeError), match=words):
        gr.draw_map(**dict(terrain=ramp(), values=np.ones((6, 8))) | change)
