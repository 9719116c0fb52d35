"""Parameters of the ground: rasters and zones."""

import numpy as np
import pytest

import fvkit as fv
import fvkit_granular as gr

TERRAIN = gr.Terrain(fv.Grid((0.0, 0.0), (40.0, 20.0), (4, 2)), [[0.0, 1.0, 2.0, 3.0], [0.0, 1.0, 2.0, np.nan]])


def zone(x0, x1, **properties):
    ring = [[x0, 0], [x1, 0], [x1, 20], [x0, 20], [x0, 0]]
    return {"type": "Feature", "properties": properties, "geometry": {"type": "Polygon", "coordinates": [ring]}}


def zones(*features):
    return {"type": "FeatureCollection", "features": list(features)}


def test_zones_are_means_by_area():
    found = gr.read_parameter(zones(zone(0, 15, NU=0.5), zone(15, 30, NU=0.1)), TERRAIN, "nu", elsewhere=0.2)
    np.testing.assert_allclose(found, [[0.5, 0.3, 0.1, 0.2]] * 2, rtol=1e-14)


def test_a_raster_is_itself_and_its_gaps_are_elsewhere(tmp_path):
    values = np.array([[0.1, 0.2, 0.3, 0.4], [0.1, np.nan, 0.3, np.nan]])
    path = gr.write_raster(tmp_path / "nu.asc", values, TERRAIN)
    np.testing.assert_array_equal(gr.read_parameter(path, TERRAIN, elsewhere=0.9), [[0.1, 0.2, 0.3, 0.4], [0.1, 0.9, 0.3, 0.9]])
    with pytest.raises(ValueError, match="1 cells have no value, the first at x = 15, y = 15: give `elsewhere`"):
        gr.read_parameter(path, TERRAIN)
    assert np.isfinite(gr.read_parameter(np.where(np.isnan(values), 0.5, values), TERRAIN)).all()


@pytest.mark.parametrize(("arguments", "words"), [
    ((zones(zone(0, 40, nu=0.5)), TERRAIN), "`attribute`"), ((zones(zone(0, 40, mu=0.5)), TERRAIN, "nu"), "must have a finite attribute 'nu', got mu"),
    ((zones(zone(0, 40, nu="much")), TERRAIN, "nu"), "attribute `nu` must be a number"),
    ((zones(zone(0, 30, nu=0.5)), TERRAIN, "nu"), "cells have no value"), ((zones(zone(0, 30, nu=0.5), zone(20, 40, nu=0.1)), TERRAIN, "nu"), "overlap"),
    ((zones(zone(0, 40, nu=float("nan"))), TERRAIN, "nu"), "finite attribute 'nu', got nan"), ((zones(zone(0, 40, nu=True)), TERRAIN, "nu"), "must be a number, got True"),
    ((zones(zone(60, 90, nu=0.5)), TERRAIN, "nu", 0.2), "must lie within the terrain.* 50 m east of it"),
    ((np.ones((2, 4)), TERRAIN, "nu"), "`attribute` is for polygons"), ((np.ones((4, 2)), TERRAIN), "shape")])
def test_what_is_no_parameter_of_the_terrain(arguments, words):
    with pytest.raises((ValueError, TypeError), match=words):
        gr.read_parameter(*arguments)


def test_a_scene_file_with_zones_stops_the_flow_in_them(tmp_path):
    x = np.broadcast_to(np.arange(20) * 5.0 + 2.5, (6, 20))
    terrain = gr.Terrain(fv.Grid((0.0, 0.0), (100.0, 30.0), (20, 6)), 50.0 - 0.3 * x)
    gr.write_raster(tmp_path / "dem.asc", terrain.bottom, terrain)
    import json
    block = {"type": "Polygon", "coordinates": [[[10, 5], [30, 5], [30, 25], [10, 25], [10, 5]]]}
    (tmp_path / "release.geojson").write_text(json.dumps(block))
    rough = {"type": "Feature", "properties": {"nu": 2.0}, "geometry": {"type": "Polygon", "coordinates": [[[50, 0], [100, 0], [100, 30], [50, 30], [50, 0]]]}}
    (tmp_path / "zones.geojson").write_text(json.dumps(rough))
    text = """t_end = 12.0
phi = 1.0
[terrain]
file = "dem.asc"
[release]
file = "release.geojson"
thickness = 1.0
[friction]
type = "coulomb"
nu = NU
"""
    reached = []
    for nu in ('{file = "zones.geojson", attribute = "nu", elsewhere = 0.1}', "0.1"):
        (tmp_path / "scene.toml").write_text(text.replace("NU", nu))
        scene = gr.load_scene(tmp_path / "scene.toml")
        h = fv.solve(scene.problem(gr.ShallowWater), backend="numpy").observables()["h"]
        reached.append(h[:, 12:].sum() / h.sum() if h.sum() > 0.0 else 1.0)
    assert reached[0] < 0.3
    assert reached[1] > reached[0] + 0.4
