"""Fault injection: every file of a set is damaged in turn, in every format; one sentence each that names the file, nothing is written."""

import json
import warnings

import numpy as np
import pytest

import fvkit_granular as gr
from tests.terrain.rasters import LAMBERT, ramp

RING = [[1006.0, 2004.0], [1021.0, 2004.0], [1018.0, 2012.0], [1006.0, 2014.0], [1006.0, 2004.0]]
BOW = [[1006.0, 2004.0], [1021.0, 2014.0], [1021.0, 2004.0], [1006.0, 2012.0], [1006.0, 2004.0]]
UTM = ('PROJCS["WGS 84 / UTM zone 33N",GEOGCS["WGS 84",DATUM["WGS_1984",SPHEROID["WGS 84",6378137,298.257223563]],PRIMEM["Greenwich",0],'
       'UNIT["degree",0.0174532925199433]],PROJECTION["Transverse_Mercator"],PARAMETER["central_meridian",15],UNIT["metre",1],AUTHORITY["EPSG","32633"]]')
DEGREES = 'GEOGCS["WGS 84",DATUM["WGS_1984",SPHEROID["WGS 84",6378137,298.257223563]],PRIMEM["Greenwich",0],UNIT["degree",0.0174532925199433]]'

#: {fault: (what is damaged, changes of what is written, words of the sentence)}.
FAULTS = {
    "terrain truncated": ("terrain", dict(keep=0.6), "numbers are needed|damaged"),
    "terrain empty": ("terrain", dict(keep=0.0), "header|damaged"),
    "terrain in degrees": ("terrain", dict(crs=DEGREES), "got degrees"),
    "terrain without data": ("terrain", dict(values=np.nan), "a cell with data"),
    "terrain of infinite height": ("terrain", dict(values=np.inf), "must be finite"),
    "terrain of a code": ("terrain", dict(values=-32768.0), "code for no data"),
    "release truncated": ("release", dict(keep=0.6), "ends too early|damaged"),
    "release empty": ("release", dict(keep=0.0), "ends too early|damaged"),
    "release in another CRS": ("release", dict(crs=UTM), "must have the CRS of the terrain"),
    "release in degrees": ("release", dict(crs=DEGREES), "got degrees"),
    "release outside": ("release", dict(ring=[[x + 900.0, y] for x, y in RING]), "881 m east of it"),
    "release with swapped axes": ("release", dict(ring=[[y, x] for x, y in RING]), "must lie within"),
    "release that crosses itself": ("release", dict(ring=BOW), "must not cross"),
    "release without area": ("release", dict(ring=[[1006.0, 2004.0], [1010.0, 2004.0], [1014.0, 2004.0], [1006.0, 2004.0]]), "enclose an area"),
    "release of no thickness": ("release", dict(thickness=0.0), "> 0 m"),
    "release of negative thickness": ("release", dict(thickness=-1.0), "> 0 m"),
    "release without thickness": ("release", dict(thickness=None), "must have an attribute thickness"),
    "release on no data": ("release", dict(ring=[[1036.0, 2026.0], [1039.0, 2026.0], [1039.0, 2029.0], [1036.0, 2026.0]]), "where the terrain has data"),
    "raster of release without any": ("raster", dict(values=0.0), "> 0 somewhere"),
    "raster of release that is negative": ("raster", dict(values=-1.0), ">= 0 m"),
    "raster of release truncated": ("raster", dict(keep=0.6), "numbers are needed|damaged"),
    "raster of release in another CRS": ("raster", dict(crs=UTM), "must have the CRS of the terrain"),
    "raster of release on another grid": ("raster", dict(nx=7), "number of cells in x 7"),
    "raster of release beyond the terrain": ("raster", dict(nx=9), "got 125 of its 1325 m3 beyond it"),
}


def cut(path, keep):
    data = path.read_bytes()
    path.write_bytes(data[:int(keep * len(data))])
    return path


def raster(folder, name, values=None, crs=LAMBERT, keep=1.0, nx=8):
    """Write a raster by hand, as others do: 6 rows from the north, no data in the north-east."""
    cells = np.array(ramp(nx=nx).bottom if values is None else np.full((6, nx), values))[::-1]
    cells[0, -1] = np.nan
    path = folder / name
    if path.suffix == ".asc":
        rows = "\n".join(" ".join("-1" if value != value else f"{value:.3f}" for value in row) for row in cells)
        path.write_text(f"ncols {nx}\nnrows 6\nxllcorner 1000\nyllcorner 2000\ncellsize 5\nNODATA_value -1\n{rows}\n")
        path.with_suffix(".prj").write_text(crs)
    else:
        rasterio = pytest.importorskip("rasterio", reason="needs the extra geo")
        with rasterio.open(path, "w", driver="GTiff", width=nx, height=6, count=1, dtype="float64", nodata=np.nan, crs=crs,
                           transform=rasterio.Affine(5.0, 0.0, 1000.0, 0.0, -5.0, 2030.0)) as file:
            file.write(cells, 1)
    return cut(path, keep) if keep < 1.0 else path


def polygons(folder, name, ring=RING, thickness=1.5, crs=LAMBERT, keep=1.0):
    path = folder / name
    if path.suffix == ".geojson":
        made = {"type": "Feature", "properties": {"name": "Kot", "thickness": thickness}, "geometry": {"type": "Polygon", "coordinates": [ring]}}
        path.write_text(json.dumps({"type": "FeatureCollection", "crs": {"type": "name", "properties": {"name": crs}}, "features": [made]}))
    else:
        shapefile = pytest.importorskip("shapefile", reason="needs the extra geo")
        with shapefile.Writer(str(path), shapeType=shapefile.POLYGON) as file:
            file.field("thickness", "N", 10, 3)
            file.poly([ring[::-1]])
            file.record(thickness)
        path.with_suffix(".prj").write_text(crs)
    return cut(path, keep) if keep < 1.0 else path


@pytest.mark.parametrize("polygon", ["release.geojson", "release.shp"])
@pytest.mark.parametrize("grid", ["dem.asc", "dem.tif"])
def test_any_raster_goes_with_any_polygon(tmp_path, grid, polygon):
    terrain = gr.read_terrain(raster(tmp_path, grid))
    assert gr.read_release(polygons(tmp_path, polygon), terrain).volume == pytest.approx(1.5 * 120.0, rel=1e-12)
    thickness = raster(tmp_path, grid.replace("dem", "thickness"), values=0.5)
    assert gr.read_release(thickness, terrain).volume == pytest.approx(0.5 * 47 * 25.0)


@pytest.mark.parametrize("fault", FAULTS)
@pytest.mark.parametrize("kind", ["core", "geo"])
def test_each_fault_is_one_sentence_that_names_the_file(tmp_path, kind, fault):
    damaged, change, words = FAULTS[fault]
    grid, polygon = ("dem.asc", "release.geojson") if kind == "core" else ("dem.tif", "release.shp")
    if damaged == "terrain":
        path, read, given = raster(tmp_path, grid, **change), gr.read_terrain, ()
    else:
        read, given = gr.read_release, (gr.read_terrain(raster(tmp_path, grid)),)
        path = polygons(tmp_path, polygon, **change) if damaged == "release" else raster(tmp_path, grid.replace("dem", "thick"), **{"values": 1.0} | change)
    before = set(tmp_path.iterdir())
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        with pytest.raises(ValueError, match=words) as caught:
            read(path, *given)
    said = str(caught.value)
    assert path.name in said
    assert "\n" not in said
    assert len(said) < 600
    assert set(tmp_path.iterdir()) == before


def shapes(folder, number, turned=False):
    """Write a shapefile of rings side by side; ``turned`` in the direction of holes."""
    shapefile = pytest.importorskip("shapefile", reason="needs the extra geo")
    path = folder / "release.shp"
    with shapefile.Writer(str(path), shapeType=shapefile.POLYGON) as file:
        file.field("thickness", "N", 10, 3)
        for k in range(number):
            file.poly([[[x + 3.0 * k, y + 12.0 * k] for x, y in (RING if turned else RING[::-1])]])
            file.record(1.5)
    return path


@pytest.mark.parametrize("kept", [0, 1])
def test_a_truncated_index_of_a_shapefile_loses_no_shape_in_silence(tmp_path, kept):
    path = shapes(tmp_path, 2)
    assert gr.read_release(path, ramp()).volume == pytest.approx(2.0 * 1.5 * 120.0, rel=1e-12)
    index = path.with_suffix(".shx")
    index.write_bytes(index.read_bytes()[:100 + 8 * kept])
    with pytest.raises(ValueError, match=f"release.shp cannot be read: .*its .shx has {kept} shapes, its .dbf 2 records"):
        gr.read_release(path, ramp())


def test_a_ring_in_the_direction_of_holes_is_read_without_a_remark(tmp_path, caplog):
    assert gr.read_release(shapes(tmp_path, 1, turned=True), ramp()).volume == pytest.approx(1.5 * 120.0, rel=1e-12)
    assert not caplog.records


def test_a_code_of_a_system_in_feet_is_refused_where_gdal_knows_it():
    pytest.importorskip("rasterio", reason="needs the extra geo")
    for code, unit in (("EPSG:2263", "US survey foot"), ("EPSG:4258", "degrees")):
        with pytest.raises(ValueError, match=f"must have coordinates in metres, got {unit} \\({code}\\)"):
            ramp(crs=code)
    for fine in ("EPSG:31287", "urn:ogc:def:crs:EPSG::32632", "local grid"):
        assert ramp(crs=fine).crs == fine
