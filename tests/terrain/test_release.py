"""Release areas: volumes are area times thickness to rounding, and each mistake in a file is one sentence that names the feature."""

import json
import sys
import warnings

import numpy as np
import pytest

import fvkit_granular as gr
from tests.terrain.rasters import LAMBERT, ramp

BOX = [[1006.0, 2004.0], [1021.0, 2004.0], [1018.0, 2022.0], [1006.0, 2019.0], [1006.0, 2004.0]]
HOLE = [[1008.0, 2008.0], [1008.0, 2014.0], [1014.0, 2014.0], [1014.0, 2008.0], [1008.0, 2008.0]]
SMALL = [[1025.0, 2005.0], [1035.0, 2005.0], [1035.0, 2012.0], [1025.0, 2005.0]]
AREA = 0.5 * (12.0 + 15.0) * 18.0 - 0.5 * 12.0 * 3.0


def feature(*rings, kind="Polygon", **properties):
    return {"type": "Feature", "properties": properties, "geometry": {"type": kind, "coordinates": list(rings)}}


def collection(*features, **more):
    return {"type": "FeatureCollection", "features": list(features), **more}


def test_volumes_are_area_times_thickness_to_rounding():
    terrain = ramp(cell=0.73, nx=60, ny=50)
    made = collection(feature(BOX, HOLE, name="upper", thickness=1.3, PHI=0.6), feature([SMALL], kind="MultiPolygon", D0="0,7", phi=0.4))
    release = gr.read_release(made, terrain)
    first, second = release.parts
    assert first.name == "upper"
    assert first.area == pytest.approx(AREA - 36.0, rel=1e-13)
    assert (second.name, second.area, second.thickness) == ("feature 2", 35.0, 0.7)
    for part in release.parts:
        assert part.volume == pytest.approx(part.area * part.thickness, rel=1e-12)
    assert release.volume == pytest.approx(first.volume + second.volume, rel=1e-13)
    assert release.thickness.max() == pytest.approx(1.3, rel=1e-12)
    assert (release.thickness * release.phi).sum() * terrain.grid.cell_volume == pytest.approx(0.6 * first.volume + 0.4 * second.volume, rel=1e-12)
    assert set(np.unique(release.phi.round(12)).tolist()) == {0.0, 0.4, 0.6}
    assert "upper" in str(release)
    assert repr(release).startswith("Release(2 on 'terrain': ")


def test_shares_of_nothing_but_rounding_release_nothing():
    terrain = ramp(corner=(176973.437998359208, 376237.836376162944), cell=4.997688906601)
    x, y = terrain.grid.axes
    corners = [(x.edges[i], y.edges[j]) for i, j in ((2, 1), (4, 1), (4, 3), (2, 3))]
    release = gr.read_release(feature(corners), terrain, thickness=1.0)
    assert (release.thickness > 0.0).sum() == 4


@pytest.mark.parametrize("slope", [(0.0, 0.0), (-0.6, 0.8)])
def test_thickness_normal_to_the_ground_is_longer_measured_vertically(slope):
    terrain, factor = ramp(slope=slope), np.sqrt(1.0 + slope[0]**2 + slope[1]**2)
    vertical, normal = (gr.read_release(feature(BOX), terrain, 1.5, measured=how) for how in ("vertical", "normal"))
    np.testing.assert_allclose(normal.thickness, factor * vertical.thickness, rtol=1e-12)
    assert (vertical.phi, normal.parts[0].area) == (None, vertical.parts[0].area)
    assert normal.volume == pytest.approx(factor * AREA * 1.5)
    assert "area x thickness" in str(normal)
    assert "normal to the ground" in str(normal)
    array = gr.read_release(vertical.thickness, terrain, solid_fraction=0.5, measured="normal")
    np.testing.assert_allclose(array.thickness, normal.thickness)
    assert set(np.unique(array.phi)) == {0.0, 0.5}


def test_the_argument_holds_for_every_polygon():
    made = collection(feature(BOX, thickness=9.0, phi=0.1), feature(SMALL))
    release = gr.read_release(made, ramp(), thickness=2.0, solid_fraction=0.6)
    assert [part.thickness for part in release.parts] == [2.0, 2.0]
    assert set(np.unique(release.phi).round(12)) == {0.0, 0.6}


def test_files_and_what_has_a_geo_interface_give_the_same(tmp_path):
    class Frame:
        __geo_interface__ = collection(feature(BOX, thickness=1.0))

    (tmp_path / "release.geojson").write_text(json.dumps(Frame.__geo_interface__))
    terrain = ramp()
    expected = gr.read_release(Frame(), terrain)
    assert np.array_equal(gr.read_release(str(tmp_path / "release.geojson"), terrain).thickness, expected.thickness)
    path = gr.write_raster(tmp_path / "thickness.asc", expected.thickness, terrain)
    assert np.array_equal(gr.read_release(path, terrain).thickness, expected.thickness)
    gaps = np.where(expected.thickness > 0.0, expected.thickness, np.nan)
    assert np.array_equal(gr.read_release(gr.write_raster(path, gaps, terrain), terrain).thickness, expected.thickness)


URN = {"type": "name", "properties": {"name": "urn:ogc:def:crs:EPSG::31287"}}
UTM = {"type": "name", "properties": {"name": "EPSG:32633"}}
SWAPPED = [[y - 1000.0, x + 1000.0] for x, y in BOX]


@pytest.mark.parametrize(("made", "words"), [
    (collection(feature([[x + 1000.0, y] for x, y in BOX], name="Kot")), r"feature 'Kot' must lie within the terrain, x 1000 to 1040 m.*981 m east of it.*MGI / Austria Lambert"),
    (feature([*BOX[:-1], [1006.0, 1999.0]]), "1 m south of it"), (feature([[11.1, 47.1], [11.2, 47.1], [11.2, 47.2]]), "these look like degrees"),
    (feature([[1012.0, 2002.0], [1012.0, 2020.0], [1024.0, 2002.0], [1024.0, 2020.0]]), "must not cross.*x = 1012, y = 2020"), (feature([[1012.0, 2002.0], [1013.0, 2003.0], [1014.0, 2004.0]]), "points on a line"),
    (feature(BOX, [[p[0] + 8.0, p[1]] for p in HOLE]), "must not cross"), (feature(BOX, SMALL), "holes must lie within"),
    (feature([BOX], [HOLE], kind="MultiPolygon"), "must not overlap"), (collection(feature(BOX), feature(HOLE)), "feature 2: features must not overlap"),
    (feature(), "feature 1 must have a polygon, got an empty one"), ({"type": "Feature", "geometry": None}, "an empty one"), (collection(), "must have a feature, got none"),
    (feature([[0, 0], [1, 1]]), "enclose an area"), (feature([[1010.0, float("nan")], *BOX]), "finite"), (feature(3), "list of points"),
    ({"type": "Point", "coordinates": [0, 0]}, "GeoJSON.*got type 'Point'"), (feature([1010.0, 2010.0], kind="LineString"), "Polygon or MultiPolygon, got 'LineString'"),
    ({"type": "Topology"}, "got type 'Topology'"), ({"type": "FeatureCollection", "features": 3}, "must be GeoJSON"), ({}, "got type None"),
    (collection(feature(BOX), crs=UTM), "must have the CRS of the terrain, MGI / Austria Lambert, got EPSG:32633"),
    (collection(feature(BOX), crs={"type": "name", "properties": {"name": "urn:ogc:def:crs:OGC:1.3:CRS84"}}), "metres, got degrees"),
    (collection(feature(BOX), crs={"type": "link"}), "must name a system")])
def test_a_release_that_does_not_fit_is_one_sentence(made, words, tmp_path):
    terrain = ramp(crs=LAMBERT)
    (tmp_path / "release.json").write_text(json.dumps(made))
    for source in (made, tmp_path / "release.json"):
        with pytest.raises(ValueError, match=words) as caught:
            gr.read_release(source, terrain, thickness=1.0)
        assert "\n" not in str(caught.value)
        assert ("release.json" if source is not made else "GeoJSON") in str(caught.value)


def test_exchanged_coordinates_are_noticed():
    terrain = ramp(corner=(1000.0, 1000.0), nx=20, ny=6)
    with pytest.raises(ValueError, match="with x and y exchanged it would lie within"):
        gr.read_release(feature([[1005.0, 1060.0], [1010.0, 1060.0], [1010.0, 1080.0]]), terrain, 1.0)


def test_a_crs_is_the_same_in_other_words():
    made = collection(feature(BOX), crs=URN)
    for crs in (LAMBERT, "EPSG:31287", "urn:ogc:def:crs:EPSG::31287", None, LAMBERT.replace(",", ", ")):
        assert gr.read_release(made, ramp(crs=crs), 1.0).volume == pytest.approx(AREA)
    made["crs"] = None
    assert gr.read_release(made, ramp(crs=LAMBERT), 1.0).volume == pytest.approx(AREA)


@pytest.mark.parametrize(("properties", "words"), [({}, "must have an attribute thickness or d0 or h, got none"), ({"depth": 1.0}, "got depth"),
                                                   ({"thickness": 0.0}, "finite and > 0 m, got 0"), ({"thickness": -1}, "> 0 m, got -1"),
                                                   ({"thickness": float("nan")}, "> 0 m, got nan"), ({"thickness": "deep"}, "`thickness` must be a number, got 'deep'"),
                                                   ({"thickness": 1.0, "phi": 60.0}, "60 % is 0.6"), ({"h": [1.0]}, "`h` must be a number")])
def test_attributes_are_checked(properties, words):
    with pytest.raises(ValueError, match=rf"feature 1:? .*{words}"):
        gr.read_release(feature(BOX, **properties), ramp())
    with pytest.raises(ValueError, match="solid_fraction must be given for every feature or for none"):
        gr.read_release(collection(feature(BOX, phi=0.5), feature(SMALL)), ramp(), 1.0)


@pytest.mark.parametrize(("change", "error", "words"), [
    (dict(thickness=0.0), ValueError, "`thickness` must be finite and > 0"), (dict(thickness="1"), TypeError, "thickness"), (dict(solid_fraction=60.0), ValueError, "60 % is 0.6"),
    (dict(measured="slope"), ValueError, "vertical, normal"), (dict(terrain=None), TypeError, "`terrain` must be an instance of Terrain"),
    (dict(source="release.kml"), ValueError, r"must be a file that ends in \.geojson, \.json, \.shp, \.asc"), (dict(source="nowhere.geojson"), FileNotFoundError, "nowhere"),
    (dict(source=np.ones((2, 2))), ValueError, r"shape \(6, 8\)"), (dict(source=np.zeros((6, 8)), thickness=None), ValueError, "> 0 somewhere"),
    (dict(source=-np.ones((6, 8)), thickness=None), ValueError, ">= 0"), (dict(source=np.ones((6, 8))), ValueError, "`thickness` must be None"),
    (dict(source=np.full((6, 8), np.nan)), ValueError, "finite"), (dict(source=None), TypeError, "numbers")])
def test_arguments_are_checked(change, error, words):
    with pytest.raises(error, match=words):
        gr.read_release(**dict(source=feature(BOX), terrain=ramp(), thickness=1.0) | change)


def test_nothing_is_released_where_there_is_no_data():
    terrain = ramp(missing=[(3, 2)])
    with pytest.raises(ValueError, match=r"where the terrain has data, got 1 cells without, the first at x = 1012.5, y = 2017.5"):
        gr.read_release(feature(BOX), terrain, 1.0)
    assert gr.read_release(feature(BOX), terrain.filled(), 1.0).volume == pytest.approx(AREA)
    with pytest.raises(ValueError, match="where the terrain has data"):
        gr.read_release(np.ones((6, 8)), terrain)


@pytest.mark.parametrize(("other", "words"), [(dict(nx=7), "must be on the grid of the terrain, or on that of the file .*, got the number of cells in x 7 instead of 8"), (dict(nx=9), "must lie within the terrain, got 150 of its 1350 m3 beyond it"), (dict(corner=(1001.0, 2000.0)), ".*lower edge in x 1001 instead of 1000"),
                                              (dict(cell=4.0), ".*upper edge in x 1032 instead of 1040"), (dict(crs="EPSG:32633"), "must have the CRS of the terrain")])
def test_a_raster_of_another_grid_says_where_it_differs(tmp_path, other, words):
    there = ramp(**other)
    path = gr.write_raster(tmp_path / "thickness.asc", np.ones(there.grid.shape), there)
    with pytest.raises(ValueError, match=rf"thickness\.asc {words}"):
        gr.read_release(path, ramp(crs=LAMBERT))


@pytest.mark.parametrize("cell", [None, 10.0, 12.0])
@pytest.mark.parametrize("window", [((1000.0, 2000.0), (1060.0, 2050.0)), ((1010.0, 2000.0), (1060.0, 2040.0))])
def test_rasters_on_the_grid_of_the_file_go_through_the_window_and_cell_of_the_terrain(tmp_path, window, cell):
    fine = ramp(nx=12, ny=10, missing=[(0, 0)])
    rng = np.random.default_rng(1)
    h, nu, seen = rng.uniform(0.0, 2.0, (10, 12)), rng.uniform(0.1, 0.5, (10, 12)), rng.integers(0, 2, (10, 12)).astype(float)
    h[:, :4] = h[7:] = h[:, 9:] = 0.0
    h[:2] = np.nan
    paths = [gr.write_raster(tmp_path / f"{name}.asc", values, fine) for name, values in (("h", h), ("nu", nu), ("seen", seen))]
    terrain = gr.read_terrain(gr.write_raster(tmp_path / "dem.asc", fine.bottom, fine), window, cell)
    assert terrain.grid != fine.grid or (cell is None and window[0][0] == 1000.0)
    release = gr.read_release(paths[0], terrain)
    assert release.volume == pytest.approx(np.nansum(h) * 25.0, rel=1e-13)
    assert release.parts[0].volume == pytest.approx(release.volume, rel=1e-13)
    friction = gr.Terrain(fine.grid, np.where(fine.missing, np.nan, nu)).window(*window)
    friction = friction if cell is None else friction.coarser(cell)
    assert gr.read_parameter(paths[1], terrain, elsewhere=0.3) == pytest.approx(np.where(terrain.missing, 0.3, friction.bottom), rel=1e-13)
    score = gr.compare_outline(np.ones(terrain.grid.shape), paths[2], terrain)
    assert score.hits + score.beyond == pytest.approx((seen * ~fine.missing).sum() * 25.0, rel=1e-12)


@pytest.mark.parametrize("text", ["", "{", '{"type": "FeatureCollection", "features": [', "[" * 100_000, "3", "null"])
def test_what_is_no_geojson_is_one_sentence(tmp_path, text):
    path = tmp_path / "release.geojson"
    path.write_text(text)
    with pytest.raises(ValueError, match=r"release\.geojson") as caught:
        gr.read_release(path, ramp(), 1.0)
    assert "\n" not in str(caught.value)


def test_a_shapefile_without_its_extra_names_it(monkeypatch):
    monkeypatch.setitem(sys.modules, "shapefile", None)
    with pytest.raises(ImportError, match=r"a shapefile needs shapefile: pip install 'fvkit\[geo\]'"):
        gr.read_release("release.shp", ramp())


@pytest.fixture
def shapefile(tmp_path):
    module = pytest.importorskip("shapefile", reason="needs the extra geo")

    def make(*parts, crs=None, kind=module.POLYGON, **record):
        path = tmp_path / "release.shp"
        with module.Writer(str(path), shapeType=kind) as file:
            file.field("Name", "C", 20)
            file.field("Thickness", "N", 10, 3)
            if kind == module.POLYGON:
                file.poly([points[::-1] for points in parts]) if parts else file.null()
            else:
                file.point(1010.0, 2010.0)
            file.record(**{"Name": "Kot", "Thickness": 1.5} | record)
        if crs:
            path.with_suffix(".prj").write_text(crs)
        return path

    return make


def test_a_shapefile_is_read_with_its_holes(shapefile):
    release = gr.read_release(shapefile(BOX, HOLE, crs=LAMBERT), ramp(crs=LAMBERT))
    (part,) = release.parts
    assert (part.name, part.thickness) == ("Kot", 1.5)
    assert part.area == pytest.approx(AREA - 36.0)
    assert release.volume == pytest.approx(1.5 * part.area, rel=1e-12)


def test_damaged_shapefiles_are_one_sentence_each(shapefile):
    utm = 'PROJCS["UTM 33",UNIT["metre",1],AUTHORITY["EPSG","32633"]]'
    for parts, more, words in [((), {}, "an empty one"), ((BOX,), dict(Thickness=0), "> 0 m"), ((BOX,), dict(Thickness=None), "got name, thickness"),
                               ((BOX,), dict(crs=utm), "CRS of the terrain"), ((), dict(kind=1), "must be a Polygon or MultiPolygon, got 'Point'")]:
        path = shapefile(*parts, **more)
        with pytest.raises(ValueError, match=words) as caught:
            gr.read_release(path, ramp(crs=LAMBERT))
        assert "release.shp" in str(caught.value)
        path.with_suffix(".prj").unlink(missing_ok=True)
    for keep in (60, 150):
        path = shapefile(BOX)
        path.write_bytes(path.read_bytes()[:keep])
        with pytest.raises(ValueError, match=r"release\.shp cannot be read: it is damaged") as caught:
            gr.read_release(path, ramp())
        assert "\n" not in str(caught.value)
    path.with_suffix(".dbf").unlink()
    with pytest.raises(ValueError, match=r"release\.shp"):
        gr.read_release(path, ramp())


def test_gdal_knows_that_two_texts_name_one_crs():
    crs = pytest.importorskip("rasterio.crs", reason="needs the extra geo")
    esri = crs.CRS.from_epsg(31287).to_wkt(version="WKT1_ESRI")
    assert gr.read_release(collection(feature(BOX), crs=URN), ramp(crs=esri), 1.0).volume == pytest.approx(AREA)
    with pytest.raises(ValueError, match="must have the CRS of the terrain"):
        gr.read_release(collection(feature(BOX), crs=UTM), ramp(crs=esri), 1.0)
    with pytest.raises(ValueError, match="write both in the same words"):
        gr.read_release(collection(feature(BOX), crs=UTM), ramp(crs="local grid of the valley"), 1.0)


def test_without_gdal_texts_that_cannot_be_compared_are_told(monkeypatch):
    monkeypatch.setitem(sys.modules, "rasterio.crs", None)
    with pytest.raises(ValueError, match=r"or let GDAL compare them: pip install 'fvkit\[geo\]'"):
        gr.read_release(collection(feature(BOX), crs=UTM), ramp(crs="local grid of the valley"), 1.0)


@pytest.mark.parametrize(("change", "words"), [(dict(thickness=np.ones((2, 2))), "`thickness` must have the shape"), (dict(thickness=-np.ones((6, 8))), "`thickness` must be >= 0 m"),
                                               (dict(phi=np.full((6, 8), 60.0)), "`phi` must be >= 0 and <= 1"), (dict(measured="slope"), "vertical, normal"),
                                               (dict(terrain=None), "instance of Terrain")])
def test_a_release_made_by_hand_is_checked(change, words):
    good = dict(terrain=ramp(), thickness=np.ones((6, 8)))
    assert gr.Release(**good).volume == 48 * 25.0
    with pytest.raises((ValueError, TypeError), match=words):
        gr.Release(**good | change)


HILLS = 0.5 * ramp(nx=40, ny=30).bottom - 150.0


@pytest.mark.parametrize(("thickness", "words"), [
    (2.0, None), (200.0, "200 cm are 2"), (60.0, None), (HILLS, "follows the elevation of the ground"), (HILLS + 2.0, "follows the elevation"),
    (np.where(HILLS > 70.0, HILLS, 0.0), "follows the elevation"), (HILLS.max() - HILLS, None), (0.001 * HILLS, None), (HILLS - HILLS.min(), None),
    (np.where(np.arange(40) < 4, 11.0, 0.0) * (np.arange(30) < 4)[:, None], "10: it is in m, and 200 cm are 2; the release is 20 m wide"),
    (np.where(np.arange(40) < 4, 9.0, 0.0) * (np.arange(30) < 4)[:, None], None)],
    ids=["plausible", "cm", "rock avalanche", "elevations", "surface", "some elevations", "lake", "more above", "wedge", "pillar", "pile"])
def test_a_thickness_in_another_unit_or_of_a_surface_is_warned_of(thickness, words):
    """On ground from 51 to 118 m; a lake and a wedge vary as the ground does, but are not its elevation."""
    terrain = gr.Terrain(ramp(nx=40, ny=30).grid, HILLS)
    release = gr.read_release(np.broadcast_to(thickness, terrain.grid.shape), terrain)
    with warnings.catch_warnings(record=True) as seen:
        warnings.simplefilter("always")
        gr.Scene(terrain=terrain, release=release, t_end=1.0, phi=0.5)
    assert [words in str(one.message) for one in seen] == [True] * (words is not None)
