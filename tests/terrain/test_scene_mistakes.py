"""Wrong keys, units and kinds in each section of a scene file on a terrain: one sentence with the section, exit 2, nothing written."""

import pytest

from fvkit.cli import main
from tests.terrain.test_command import SCENE, folder  # noqa: F401

WHOLE = SCENE + '[[hydrograph]]\nfile = "in.csv"\narea = "release.geojson"\n[[sources]]\ntype = "constant-drag"\nD = 1.0\n'
TABLE = "t [s],discharge [m3/s],phi [-]\n0,1,0.5\n1,1,0.5\n"
TABLES = {"in.csv": TABLE, "hours.csv": TABLE.replace("m3/s", "m3/h"), "bare.csv": "t,discharge,phi\n0,1,0.5\n1,1,0.5\n"}

#: {section, as messages call it: (what stands there, what stands there instead, words of the sentence)}.
DEM, PHI, NU, IN, AREA, GAUGES = 'file = "dem.asc"', "phi = 0.6", "nu = 0.2", 'file = "in.csv"', 'area = "release.geojson"', "gauges = ["
MISTAKES = {
    "terrain": [
        (DEM, f'{DEM}\ncell = "10"', "`cell` must be a number"), (DEM, f"{DEM}\ncell = -5", "`cell` must be finite and > 0"),
        (DEM, f"{DEM}\ncell = 1.0", "at least that of the terrain, 5 m"), (DEM, f"{DEM}\nwindow = [1, 2]", "`window` must be two corners"),
        (DEM, f"{DEM}\nwindow = [[0, 0], [10, 10]]", "within the terrain"), (DEM, f'{DEM}\nfill = "yes"', "must be true or false"),
        (DEM, "file = 3", "must be a text in quotes"), (DEM, 'fil = "dem.asc"', "unknown key `fil`"), (DEM, 'file = "."', "ends in .asc"),
        (DEM, 'file = "scene.toml"', "ends in .asc")],
    "release": [
        (PHI, "phi = 60", "60 % is 0.6"), (PHI, 'phi = "60 %"', "must be a number"), (PHI, f'{PHI}\nthickness = "1.5 m"', "must be a number"),
        (PHI, f"{PHI}\nthickness = -1", "must be finite and > 0"), (PHI, f'{PHI}\nmeasured = "vert"', "did you mean vertical"),
        (PHI, f"{PHI}\nthicknes = 1", "unknown key `thicknes`; did you mean `thickness`")],
    "friction": [
        (NU, "nu = 20", "tangent of the friction angle"), (NU, 'nu = "0.2"', "must be a number"), (NU, "mu = 0.2", "unknown key `mu`"),
        (NU, 'nu = {file = "nu.asc"}', "no file nu.asc"), (NU, 'nu = {fil = "nu.asc"}', "unknown key `fil`"),
        (NU, f"nu = {{{DEM}}}", "got 5"), ('type = "coulomb"', 'type = "columb"', "did you mean coulomb")],
    "hydrograph": [
        (IN, 'file = "hours.csv"', "m3/s, l/s; got discharge [m3/h]"), (IN, 'file = "bare.csv"', "columns and units"),
        (IN, 'file = "no.csv"', "no file no.csv"), (IN, DEM, "columns and units"), (AREA, 'area = "no.geojson"', "no file no.geojson"),
        (AREA, 'area = "dem.asc"', "dem.asc must be a vector file"), (AREA, 'area = "in"', "must be a vector file"),
        (AREA, 'aera = "release.geojson"', "unknown key `aera`"), ("[[hydrograph]]", "[hydrograph]", r"write [[hydrograph]]")],
    "outputs": [
        (GAUGES, "gauges = [[32.5, 12.5], ", "`gauges` must lie within the scene"), (GAUGES, "gauges = [1032.5, ", "`gauges`"),
        (GAUGES, 'gauges = [["a", 2], ', "`gauges` must be"), (GAUGES, f"count = 0\n{GAUGES}", "`count` must be >= 1"),
        (GAUGES, f'observed = "no.geojson"\n{GAUGES}', "no file no.geojson"), (GAUGES, f"observed = 3\n{GAUGES}", "must be a text in quotes"),
        (GAUGES, f'observed = "in.csv"\n{GAUGES}', "in.csv"), (GAUGES, f"count = 2.5\n{GAUGES}", "whole number"), (GAUGES, f"times = [1.0, 99.0]\n{GAUGES}", "ascends within"),
        (GAUGES, f'threshold = "0.1 m"\n{GAUGES}', "must be a number"), (GAUGES, f"threshold = 0\n{GAUGES}", "must be finite and > 0"),
        (GAUGES, f'density = "2500 kg/m3"\n{GAUGES}', "must be a number"), ("lines = {", 'lines = {"a/b" = [[1030.0, 2001.0], [1030.0, '
                                                                           "2024.0]], ", "names of letters"),
        ("[1030.0, 2024.0]", "[1030.0, 2001.0]", "same point twice")],
    "sources": [
        ("D = 1.0", "D = -1.0", "must be finite and >= 0"), ("D = 1.0", "d = 1.0", "did you mean `D`"),
        ('type = "constant-drag"', 'typ = "constant-drag"', "the key `type` is missing")],
    "boundary": [
        ("[release]", '[boundary]\nwest = "wal"\n[release]', "did you mean wall"),
        ("[release]", '[boundary]\nleft = "wall"\n[release]', "did you mean `west`")],
    "": [
        ("t_end = 1.5", 't_end = "1.5 s"', "t_end: `t_end` must be a number"), ("t_end = 1.5", "t_end = -1", "must be finite and > 0"),
        ("t_end = 1.5", "tend = 1.5", "did you mean `t_end`"), ("t_end = 1.5", "t_end = 1.5\ngamma = 1.4", "gamma: `gamma` must be"),
        ("t_end = 1.5", 't_end = 1.5\nslope = "steap"', "did you mean steep"),
        ("t_end = 1.5", "t_end = 1.5\ninterval = [0, 1]", "exclude each other"),
        ("[release]", "[initial]\nh = 1.0\nphi = 0.5\n[release]", "exclude each other"),
        ("[release]", '[bottom]\nshape = "plane"\n[release]', "exclude each other")]}


@pytest.mark.parametrize(("section", "old", "new", "words"),
                         [(section, *case) for section, cases in MISTAKES.items() for case in cases])
def test_a_mistake_is_one_sentence_with_its_section_and_nothing_is_written(folder, section, old, new, words, capsys):  # noqa: F811
    for name, text in TABLES.items():
        (folder / name).write_text(text)
    assert old in WHOLE
    (folder / "scene.toml").write_text(WHOLE.replace(old, new, 1))
    assert main(["run", "scene.toml", "--out", "out", "--model", "reduced"]) == 2
    said = capsys.readouterr().err
    assert words in said
    assert said.startswith(f"fvkit: scene.toml, {section}" if section else "fvkit: scene.toml")
    assert said.count("\n") == 1
    assert not (folder / "out").exists()


@pytest.mark.filterwarnings("default:.*density:UserWarning")
def test_what_is_right_but_for_these_mistakes_runs_and_a_density_in_another_unit_is_told(folder, capsys):  # noqa: F811
    (folder / "in.csv").write_text(TABLE)
    (folder / "scene.toml").write_text(WHOLE.replace("gauges", "density = 2.5\ngauges", 1))
    assert main(["check", "scene.toml"]) == 0
    assert main(["run", "scene.toml", "--out", "out", "--model", "reduced"]) == 0
    printed = capsys.readouterr()
    assert "`density` of HazardMaps is 2.5, and plausible from 10 to 10000: it is in kg/m^3, and 2.5 g/cm^3 is 2500" in printed.err
    assert "in by hydrograph" in printed.out


def test_geotiff_and_shapefiles_go_in_and_out_through_the_command(folder, capsys):  # noqa: F811
    rasterio, shapefile = pytest.importorskip("rasterio"), pytest.importorskip("shapefile")
    import numpy as np

    import fvkit as fv
    import fvkit_granular as gr

    ground = gr.read_terrain("dem.asc")
    values = np.where(ground.missing, -9999.0, ground.bottom)[::-1]
    x, y = ground.grid.axes
    place = rasterio.Affine(x.dx, 0.0, x.lower, 0.0, -y.dx, y.upper)
    with rasterio.open("dem.tif", "w", driver="GTiff", height=6, width=12, count=1, dtype="float32", crs="EPSG:31287", transform=place,
                       nodata=-9999.0, compress="LZW") as file:
        file.write(values.astype("float32"), 1)
    for name, draw, shape in (("release", "poly", [[1006.0, 2004.0], [1006.0, 2020.0], [1018.0, 2020.0], [1021.0, 2004.0], [1006.0, 2004.0]]),
                              ("thalweg", "line", [[1003.0, 2012.0], [1050.0, 2012.0]])):
        with shapefile.Writer(name) as file:
            file.field("thickness", "N", decimal=2)
            getattr(file, draw)([shape])
            file.record(1.5)
        (folder / f"{name}.prj").write_text(rasterio.crs.CRS.from_epsg(31287).to_wkt())
    (folder / "tif.toml").write_text(SCENE.replace("dem.asc", "dem.tif").replace(".geojson", ".shp") + 'path = "thalweg.shp"\n')
    plain, of_files = SCENE + "path = [[1003.0, 2012.0], [1050.0, 2012.0]]\n", []
    (folder / "plain.toml").write_text(plain)
    for name, ending in (("plain", "asc"), ("tif", "tif")):
        assert main(["run", f"{name}.toml", "--out", name, "--model", "reduced", "--rasters", ending]) == 0
        of_files.append(fv.load(f"{name}/solution.npz"))
    np.testing.assert_array_equal(of_files[0].q, of_files[1].q)
    assert (folder / "tif/run-out.csv").read_bytes() == (folder / "plain/run-out.csv").read_bytes()
    with rasterio.open("tif/deposit.tif") as file:
        read = file.read(1)[::-1]
        assert (file.crs.to_epsg(), file.transform, file.nodata) == (31287, place, -9999.0)
    known = ~ground.missing
    np.testing.assert_array_equal(read[known], of_files[1].observables()["h"][known])
    assert (read[~known] == -9999.0).all()
