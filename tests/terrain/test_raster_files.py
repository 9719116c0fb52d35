"""Raster files: what is written reads back to the bit, at its place, also by other programs; each mistake is a sentence with its place."""

import errno
import os
import sys
import warnings

import numpy as np
import pytest

import fvkit as fv
import fvkit_granular as gr
from fvkit_granular.terrain.rasters import read_raster
from tests.terrain.rasters import LAMBERT, ramp

HEADER = "ncols 3\nnrows 2\nxllcorner 100\nyllcorner 200\ncellsize 5\nNODATA_value -9999\n"
BODY = "4 5 -9999\n1 2 3\n"


@pytest.fixture
def write(tmp_path):
    def make(text, name="dem.asc", crs=None):
        path = tmp_path / name
        path.write_bytes(text if isinstance(text, bytes) else text.encode())
        if crs is not None:
            path.with_suffix(".prj").write_text(crs)
        return path

    return make


@pytest.mark.parametrize("text", [
    HEADER + BODY, HEADER.upper() + BODY, HEADER.replace("\n", "\r\n") + BODY, "\n".join(reversed(HEADER.split("\n"))).strip() + "\n" + BODY,
    HEADER.replace("xllcorner 100", "xllcenter 102.5").replace("yllcorner 200", "YLLCENTER 202,5") + BODY,
    HEADER.replace("cellsize 5", "dx 5.0\ndy 5") + BODY, HEADER.replace("NODATA_value -9999\n", "") + BODY,
    HEADER + "4,0 5,0e0 -9999,0 1 2 3", "\n" + HEADER + "\n" + BODY, HEADER + "4\n5 -9999\n1 2\n3", HEADER.replace("-9999", "nan") + "4 5 NaN 1 2 3",
    HEADER.replace("-9999", "-3.4028234663852886e+38") + "4 5 -3.40282e+38 1 2 3"])
def test_an_esri_ascii_raster_is_read_however_it_is_spelled(write, text):
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        terrain = gr.read_terrain(write(text))
    np.testing.assert_array_equal(terrain.bottom, [[1.0, 2.0, 3.0], [4.0, 5.0, np.nan]])
    x, y = terrain.grid.axes
    assert (x.lower, x.upper, y.lower, y.upper, terrain.name, terrain.crs) == (100.0, 115.0, 200.0, 210.0, "dem", None)


@pytest.mark.parametrize(("text", "words"), [
    ("", "the header must have nrows, got no header"), ("x [m], b [m]\n0, 1\n", "got no header"), (HEADER, "= 6 numbers are needed, got 0"),
    (HEADER + "4 5 -9999\n1 2", "= 6 numbers are needed, got 5: the file ends too early, at line 8"),
    (HEADER + BODY + "7 8\n", "= 6 numbers are needed, got 8: more numbers follow in line 9"),
    (HEADER.replace("ncols 3\n", "") + BODY, "must have ncols"), (HEADER.replace("cellsize 5\n", "") + BODY, "must have cellsize"),
    (HEADER.replace("xllcorner 100\n", "") + BODY, "must have xllcorner or xllcenter"), (HEADER + "xllcenter 3\n" + BODY, "one of xllcorner and xllcenter"),
    (HEADER + "NROWS 2\n" + BODY, "line 7: the key nrows must be there once"), (HEADER + "colour 2\n" + BODY, "line 7: .*key 'colour'"),
    (HEADER.replace("ncols 3", "ncols 3.5") + BODY, "ncols must be a whole number"), (HEADER.replace("ncols 3", "ncols -3") + BODY, "ncols must be a whole number"),
    (HEADER.replace("ncols 3", "ncols three") + BODY, "ncols must be a number, got 'three'"), (HEADER.replace("cellsize 5", "cellsize 0") + BODY, "cellsize must be > 0"),
    (HEADER.replace("xllcorner 100", "xllcorner inf") + BODY, "xllcorner must be finite"),
    (HEADER.replace("cellsize 5", "dx 5\ndy 6") + BODY, "must be square, got dx = 5 and dy = 6: resample"), (HEADER + "4 5 -9999\n1 two 3", "line 8: a number is needed, got 'two'"),
    (HEADER.replace("ncols 3\nnrows 2", "ncols 2\nnrows 3") + BODY, "got 2 x 3 for 2 lines of 3 numbers: exchange ncols and nrows"),
    (HEADER + "4 5 -9999\n1 nan 3", "line 8: numbers must be finite"), (HEADER + "4 inf -9999\n1 2 3", "line 7: numbers must be finite"),
    (HEADER + "1.004,5 5 6 1 2 3", "points or commas, got both"), (HEADER + "-9999 " * 6, "a cell with data"), (HEADER + "4 5 -32768 1 2 3", "code for no data"),
    (HEADER.encode() + b"\xff\xfe", "not UTF-8"), (b"II*\x00\x08\x00\x00\x00", "header")])
def test_a_damaged_raster_is_one_sentence(write, text, words):
    path = write(text)
    with pytest.raises(ValueError, match=words) as caught:
        gr.read_terrain(path)
    assert str(path) in str(caught.value)
    assert "\n" not in str(caught.value)


def test_other_files_are_refused_by_name(write, tmp_path):
    with pytest.raises(FileNotFoundError, match=r"nowhere\.asc"):
        gr.read_terrain(tmp_path / "nowhere.asc")
    with pytest.raises(ValueError, match=r"must be a file that ends in \.asc, \.txt, \.tif, \.tiff, \.geotiff, got 'dem\.las'"):
        gr.read_terrain("dem.las")


def test_window_cell_units_and_crs_of_a_file(write):
    path = write(HEADER.replace("cellsize 5", "cellsize 500").replace("-9999", "-1") + "0.4 0.5 0.6\n0.7 0.8 0.9\n", crs=LAMBERT + "\n")
    with pytest.warns(RuntimeWarning, match="elevations may be in km") as told:
        assert gr.read_terrain(path).crs == LAMBERT
    assert told[0].filename == __file__
    path = write(HEADER + BODY)
    assert gr.read_terrain(path, window=((100, 200), (110, 210)), cell=10.0).bottom.tolist() == [[3.0]]
    for window, words in [(((0, 0), (1, 1)), r"dem\.asc: a window must lie within"), ((1, 2, 3), "two corners"), (5.0, "list"), (((0, 0, 0), (1, 1, 1)), "two corners")]:
        with pytest.raises((ValueError, TypeError), match=words):
            gr.read_terrain(path, window=window)
    with pytest.raises(ValueError, match=r"dem\.asc must have coordinates in metres, got degrees \(WGS 84\)"):
        gr.read_terrain(write(HEADER + BODY, crs='GEOGCS["WGS 84",DATUM["WGS_1984"]]'))


@pytest.mark.parametrize("ending", [".asc", ".tif"])
def test_what_is_written_reads_back_to_the_bit(tmp_path, ending):
    if ending == ".tif":
        pytest.importorskip("rasterio", reason="needs the extra geo")
    terrain = ramp(corner=(176973.437998359208, 376237.836376162944), cell=4.997688906601, missing=[(0, 0), (5, 7)], crs=LAMBERT)
    values = np.random.default_rng(5).normal(size=terrain.grid.shape) * 10.0 ** np.arange(-20, 28, 8)[:, None]
    values[2, 3], values[1, 1], values[1, 2] = np.nan, 5e-324, -0.0
    path = gr.write_raster(tmp_path / f"depth{ending}", values, terrain)
    read = read_raster(path)
    expected = np.where(terrain.missing, np.nan, values)
    np.testing.assert_array_equal(read.values, expected)
    np.testing.assert_array_equal(np.signbit(read.values), np.signbit(expected))
    terrain.check_on_grid(read.grid, path)
    for own, there in zip(terrain.grid.axes, read.grid.axes, strict=True):
        np.testing.assert_allclose([there.lower, there.upper], [own.lower, own.upper], rtol=1e-15)
    if ending == ".asc":
        assert read.crs == LAMBERT


def test_gdal_reads_the_ascii_raster_at_its_place(tmp_path):
    rasterio = pytest.importorskip("rasterio", reason="needs the extra geo")
    terrain = ramp(corner=(176973.25, 376237.5), cell=2.5, missing=[(0, 0)], crs=rasterio.crs.CRS.from_epsg(31287).to_wkt())
    values = np.random.default_rng(5).normal(size=terrain.grid.shape)
    path = gr.write_raster(tmp_path / "depth.asc", values, terrain)
    with rasterio.open(path, datatype="Float64") as file:
        there = file.read(1, masked=True)
        assert tuple(file.bounds) == (176973.25, 376237.5, 176973.25 + 8 * 2.5, 376237.5 + 6 * 2.5)
        assert file.crs.to_epsg() == 31287
    np.testing.assert_array_equal(there.mask[::-1], terrain.missing)
    np.testing.assert_array_equal(there.data[::-1][~terrain.missing], values[~terrain.missing])


def test_a_raster_is_written_whole_or_not_at_all(tmp_path, monkeypatch):
    terrain = ramp(crs=LAMBERT)
    path = gr.write_raster(tmp_path / "depth.asc", np.ones(terrain.grid.shape), terrain)
    before = path.read_bytes()
    assert (tmp_path / "depth.prj").read_text() == LAMBERT

    def full(*_):
        raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))

    with monkeypatch.context() as patch:
        patch.setattr(os, "replace", full)
        with pytest.raises(OSError, match=r"No space left.*depth\.asc"):
            gr.write_raster(path, np.zeros(terrain.grid.shape), terrain)
    assert path.read_bytes() == before
    assert sorted(file.name for file in tmp_path.iterdir()) == ["depth.asc", "depth.prj"]
    gr.write_raster(path, np.zeros(terrain.grid.shape), ramp())
    assert not (tmp_path / "depth.prj").exists()


@pytest.mark.parametrize(("values", "words"), [(np.ones((8, 6)), r"shape of the terrain, \(6, 8\), got \(8, 6\)"), (np.full((6, 8), np.inf), "finite"),
                                               (np.full((6, 8), -9999.0), "-9999, which means no data"), ("depth", "numbers")])
def test_what_is_no_result_is_not_written(tmp_path, values, words):
    with pytest.raises((ValueError, TypeError), match=words):
        gr.write_raster(tmp_path / "depth.asc", values, ramp())
    assert not list(tmp_path.iterdir())


def test_endings_and_cells_that_the_format_lacks_are_refused(tmp_path):
    flat = gr.Terrain(fv.Grid((0.0, 0.0), (20.0, 10.0), (2, 2)), np.zeros((2, 2)))
    with pytest.raises(ValueError, match="must be square, got 10 x 5 m: write a GeoTIFF"):
        gr.write_raster(tmp_path / "depth.asc", np.zeros((2, 2)), flat)
    with pytest.raises(ValueError, match=r"must end in \.asc"):
        gr.write_raster(tmp_path / "depth.png", np.zeros((2, 2)), flat)


def test_a_geotiff_without_its_extra_names_it(tmp_path, monkeypatch):
    monkeypatch.setitem(sys.modules, "rasterio", None)
    for call in (lambda: gr.read_terrain(tmp_path / "dem.tif"), lambda: gr.write_raster(tmp_path / "depth.tif", np.zeros((6, 8)), ramp())):
        with pytest.raises(ImportError, match=r"needs rasterio: pip install 'fvkit\[geo\]'"):
            call()


@pytest.fixture
def geotiff(tmp_path):
    rasterio = pytest.importorskip("rasterio", reason="needs the extra geo")

    def make(values=((4.0, 5.0, -1.0), (1.0, 2.0, 3.0)), name="dem.tif", **more):
        values = np.asarray(values)
        profile = dict(driver="GTiff", width=3, height=2, count=1, dtype="float32", nodata=-1.0, crs="EPSG:31287",
                       transform=rasterio.Affine(5.0, 0.0, 100.0, 0.0, -5.0, 210.0)) | more
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", rasterio.errors.NotGeoreferencedWarning)
            with rasterio.open(tmp_path / name, "w", **profile) as file:
                for band in range(profile["count"]):
                    file.write(values.astype(profile["dtype"]), band + 1)
        return tmp_path / name

    return make


@pytest.mark.parametrize("more", [{}, dict(compress="lzw"), dict(compress="deflate", predictor=3), dict(compress="zstd"), dict(tiled=True, blockxsize=16, blockysize=16),
                                  dict(dtype="int16")], ids=str)
def test_a_geotiff_of_any_codec_is_read(geotiff, more):
    terrain = gr.read_terrain(geotiff(**more))
    np.testing.assert_array_equal(terrain.bottom, [[1.0, 2.0, 3.0], [4.0, 5.0, np.nan]])
    assert terrain.grid.axes[1].lower == 200.0
    assert "MGI / Austria Lambert" in terrain.crs


def test_a_geotiff_that_runs_north_and_one_with_oblong_cells(geotiff):
    from rasterio.transform import Affine

    north = gr.read_terrain(geotiff(transform=Affine(5.0, 0.0, 100.0, 0.0, 2.5, 200.0)))
    np.testing.assert_array_equal(north.bottom, [[4.0, 5.0, np.nan], [1.0, 2.0, 3.0]])
    assert (north.grid.axes[1].lower, north.grid.axes[1].upper) == (200.0, 205.0)


def test_geotiffs_that_are_no_terrain_are_one_sentence_each(geotiff):
    from rasterio.transform import Affine

    cases = [(dict(transform=Affine(4.0, -3.0, 100.0, 3.0, 4.0, 210.0)), "not rotated"), (dict(crs="EPSG:4326"), "got degrees"), (dict(crs="EPSG:2225"), "got feet"),
             (dict(count=2), "one band, got 2"), (dict(transform=Affine.identity()), "place on the map"), (dict(values=-np.ones((2, 3))), "a cell with data")]
    for change, words in cases:
        path = geotiff(**change)
        with pytest.raises(ValueError, match=words) as caught:
            gr.read_terrain(path)
        assert str(path) in str(caught.value)
        assert "\n" not in str(caught.value)
    path = geotiff()
    path.write_bytes(path.read_bytes()[:200])
    with pytest.raises(ValueError, match=r"dem\.tif cannot be read: it is damaged or no GeoTIFF"):
        gr.read_terrain(path)
    with pytest.raises(FileNotFoundError):
        gr.read_terrain(path.with_name("nowhere.tif"))
