"""`fvkit run` and `fvkit check` on a tiny terrain, end to end, and every mistake in the files of the set through the command line."""

import json
import re
import warnings

import numpy as np
import pytest

import fvkit as fv
import fvkit_granular as gr
from fvkit.cli import main
from fvkit_granular.cli import check
from fvkit_granular.scenes.toml.read import SAMPLES, find_scene
from tests.terrain.rasters import ramp
from tests.tools import sample_torrent

SCENE = """t_end = 1.5
[terrain]
file = "dem.asc"
gaps = "outlet"
[release]
file = "release.geojson"
phi = 0.6
[friction]
type = "coulomb"
nu = 0.2
[outputs]
gauges = [[1032.5, 2012.5]]
lines = {across = [[1030.0, 2001.0], [1030.0, 2024.0]]}
"""
RING = [[1006.0, 2004.0], [1021.0, 2004.0], [1018.0, 2020.0], [1006.0, 2020.0], [1006.0, 2004.0]]
BOW = [[1006.0, 2004.0], [1021.0, 2014.0], [1021.0, 2004.0], [1006.0, 2012.0], [1006.0, 2004.0]]


def collection(ring=RING, thickness=1.5, crs="EPSG:31287"):
    feature = {"type": "Feature", "properties": {"thickness": thickness}, "geometry": {"type": "Polygon", "coordinates": [ring]}}
    return json.dumps({"type": "FeatureCollection", "crs": {"type": "name", "properties": {"name": crs}}, "features": [feature]})


def dem(value=None, gap=True):
    """12 x 6 cells of 5 m that fall to the east, with a column without data in the east."""
    rows = [[540.0 - 2.0 * i if value is None else value for i in range(12)] for _ in range(6)]
    for row in rows if gap else ():
        row[-1] = -9999.0
    body = "\n".join(" ".join(f"{height:g}" for height in row) for row in rows)
    return f"ncols 12\nnrows 6\nxllcorner 1000\nyllcorner 2000\ncellsize 5\nNODATA_value -9999\n{body}\n"


@pytest.fixture
def folder(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("FVKIT_BACKEND", "numpy")
    (tmp_path / "scene.toml").write_text(SCENE)
    (tmp_path / "dem.asc").write_text(dem())
    (tmp_path / "dem.prj").write_text("EPSG:31287")
    (tmp_path / "release.geojson").write_text(collection())
    return tmp_path


def files(folder):
    return sorted(path.relative_to(folder) for path in folder.rglob("*"))


def change(folder, name, old, new):
    text = (folder / name).read_text()
    assert old in text
    (folder / name).write_text(text.replace(old, new))


def test_a_run_is_scored_against_what_was_observed(folder, capsys):
    change(folder, "scene.toml", "gauges = [", 'observed = "release.geojson"\ngauges = [')
    assert main(["run", "scene.toml", "--out", "out", "--model", "shallow-water", "--format", "svg"]) == 0
    score = gr.compare_outline("out/max_depth.asc", "release.geojson", gr.read_terrain("dem.asc"))
    assert score.hits > 0.0
    line = f"deeper than 0.1 m against what was observed: {score}"
    assert line in capsys.readouterr().out
    assert line in (folder / "out" / "report.html").read_text(encoding="utf-8")
    assert line in (folder / "out" / "run.txt").read_text(encoding="utf-8")
    assert (folder / "out" / "max_depth.svg").read_bytes().startswith(b"<?xml")
    assert not list((folder / "out").glob("*.png"))


def test_the_report_has_the_range_of_friction_by_cell(folder):
    gr.write_raster("nu.asc", np.where(np.arange(12) < 6, 0.1, 0.3) * np.ones((6, 12)), gr.read_terrain("dem.asc"))
    change(folder, "scene.toml", "nu = 0.2", 'nu = {file = "nu.asc", elsewhere = 0.1}')
    assert main(["run", "scene.toml", "--out", "out", "--model", "shallow-water"]) == 0
    assert "CoulombFriction(nu=0.1 to 0.3, by cell)" in (folder / "out" / "report.html").read_text(encoding="utf-8")


def test_a_run_writes_rasters_series_and_a_report(folder, capsys):
    assert main(["run", "scene.toml", "--out", "out", "--model", "shallow-water"]) == 0
    printed = capsys.readouterr().out
    named = printed.split("written to out/: ")[1].strip().split(", ")
    assert {"max_depth.asc", "arrival.asc", "deposit.asc", "gauges.csv", "line-across.csv", "report.html"} <= set(named)
    assert all((folder / "out" / name).stat().st_size > 0 for name in named)
    solution, terrain = fv.load("out/solution.npz"), gr.read_terrain("dem.asc")
    deposit = gr.read_terrain("out/deposit.asc")
    assert deposit.grid == terrain.grid
    assert deposit.crs == terrain.crs
    np.testing.assert_array_equal(deposit.missing, terrain.missing)
    known = ~terrain.missing
    np.testing.assert_array_equal(deposit.bottom[known], solution.observables()["h"][known])
    page = (folder / "out" / "report.html").read_text()
    assert page.count('src="data:image/png;base64,') == 4
    assert "equations for steep slopes" in page


@pytest.mark.parametrize("gaps", ["outlet", "wall"])
def test_volumes_balance_and_gaps_drain_or_keep(folder, gaps):
    change(folder, "scene.toml", 'gaps = "outlet"', f'gaps = "{gaps}"')
    change(folder, "scene.toml", "t_end = 1.5", "t_end = 6.0")
    with open("scene.toml", "a") as file:
        file.write('[boundary]\nall = "wall"\n')
    assert main(["run", "scene.toml", "--out", "out", "--model", "shallow-water"]) == 0
    solution = fv.load("out/solution.npz")
    first, last = (solution.q[k, 0].sum() * solution.grid.cell_volume for k in (0, -1))
    brought = solution.stats.entered_by_sources["h"]
    assert abs(last - first - brought) <= 1e-12 * first
    if gaps == "outlet":
        assert brought < -0.05 * first
    else:
        assert brought == 0.0
        assert solution.q[-1, 0][:, -1].max() < 1e-15


def test_check_says_what_a_run_would_take_and_draws_it(folder, capsys):
    before = set(files(folder))
    assert main(["check", "scene.toml", "--out", "look.png"]) == 0
    printed = capsys.readouterr().out
    for words in ("12 x 6 cells of 5 m", "6 without data", "area x thickness", "computed with the equations for steep ground",
                  "source: Drain", "about"):
        assert words in printed
    assert {path.name for path in set(files(folder)) - before} == {"look.png"}
    assert (folder / "look.png").read_bytes().startswith(b"\x89PNG")


def test_check_draws_the_cells_of_a_hydrograph(tmp_path):
    terrain = ramp(nx=12, ny=6)
    (tmp_path / "inflow.csv").write_text("t [s],discharge [m3/s],phi [-]\n0,1,0.5\n9,1,0.5\n")
    here = {"type": "Polygon", "coordinates": [[[1010.0, 2005.0], [1020.0, 2005.0], [1020.0, 2010.0], [1010.0, 2010.0], [1010.0, 2005.0]]]}
    scene = gr.Scene(terrain=terrain, t_end=9.0, sources=gr.read_hydrograph(tmp_path / "inflow.csv", here, terrain))
    picture = check._picture(scene)
    assert [line.get_xydata().tolist() for line in picture.axes[0].get_lines()] == [[[1012.5, 2007.5], [1017.5, 2007.5]]]
    assert picture.get_supxlabel() == "west: outflow, east: outflow, south: outflow, north: outflow"  # below the map, however narrow


def test_an_observed_raster_of_nothing_is_refused(folder, capsys):
    terrain = gr.read_terrain("dem.asc")
    gr.write_raster("observed.asc", np.full(terrain.grid.shape, np.nan), terrain)
    change(folder, "scene.toml", "gauges = [", 'observed = "observed.asc"\ngauges = [')
    assert main(["check", "scene.toml"]) == 2
    assert "outputs.observed: `observed` must hold cells > 0, or polygons, where the terrain has data" in capsys.readouterr().err


#: {fault: (file, what is changed: (old, new), a new content, or None for no file; words of the sentence)}.
FAULTS = {
    "no terrain": ("dem.asc", None, "terrain.*there is no file dem.asc"),
    "terrain truncated": ("dem.asc", dem()[:150], "dem.asc.*numbers are needed"),
    "terrain empty": ("dem.asc", "", "dem.asc.*header"),
    "terrain without data": ("dem.asc", dem(-9999.0), "terrain.*cell with data"),
    "terrain not a number": ("dem.asc", dem().replace("530", "nan", 1), "dem.asc|terrain"),
    "terrain in another CRS": ("dem.prj", "EPSG:32633", "release.*CRS"),
    "no release": ("release.geojson", None, "release.*there is no file release.geojson"),
    "release of 5000 digits": ("release.geojson", '{"type": "FeatureCollection", "features": [' + 5000 * "9" + "]}", "release.geojson.*digits"),
    "release truncated": ("release.geojson", collection()[:120], "release.geojson.*(ends too early|damaged|JSON)"),
    "release in kilometres": ("release.geojson", collection([[0.001 * x, 0.001 * y] for x, y in RING]), "these look like kilometres"),
    "release with swapped axes": ("release.geojson", collection([[y, x] for x, y in RING]), "x and y exchanged"),
    "release outside": ("release.geojson", collection([[x + 900.0, y] for x, y in RING]), "east of it"),
    "release that crosses itself": ("release.geojson", collection(BOW), "must not cross"),
    "release of no thickness": ("release.geojson", collection(thickness=0.0), "thickness must be finite and > 0"),
    "release of NaN": ("release.geojson", collection(thickness=float("nan")), "release.geojson"),
    "release without thickness": ("release.geojson", collection(thickness=None), "attribute thickness"),
    "no solid fraction": ("scene.toml", ("phi = 0.6\n", ""), "phi"),
    "unknown key of the terrain": ("scene.toml", ('gaps = "outlet"', 'gap = "outlet"'), "terrain: unknown key `gap`; did you mean `gaps`"),
    "unknown key of the outputs": ("scene.toml", ("gauges =", "gages ="), "outputs: unknown key `gages`; did you mean `gauges`"),
    "unknown gaps": ("scene.toml", ('gaps = "outlet"', 'gaps = "hole"'), r"terrain\.gaps: .*outlet, wall"),
    "gaps of another kind": ("scene.toml", ('gaps = "outlet"', "gaps = 3"), r"terrain\.gaps"),
    "file of another kind": ("scene.toml", ('file = "dem.asc"', "file = 3"), r"terrain\.file: `file` must be a text"),
    "terrain of another kind": ("scene.toml", ('[terrain]\nfile = "dem.asc"\ngaps = "outlet"', 'terrain = "dem.asc"'), "`terrain` must be a table"),
    "fill of another kind": ("scene.toml", ('gaps = "outlet"', 'fill = "yes"'), r"terrain\.fill: `fill` must be true or false"),
    "window of another kind": ("scene.toml", ('gaps = "outlet"', "window = 3"), r"terrain\.window"),
    "window outside": ("scene.toml", ('gaps = "outlet"', "window = [[0, 0], [10, 10]]"), "terrain.*within the terrain"),
    "cell too small": ("scene.toml", ('gaps = "outlet"', "cell = 1.0"), r"terrain\.cell: `cell` must be at least"),
    "phi in per cent": ("scene.toml", ("phi = 0.6", "phi = 60.0"), r"release\.phi: "),
    "thickness of zero": ("scene.toml", ("phi = 0.6", "phi = 0.6\nthickness = 0.0"), r"release\.thickness: "),
    "measured in a third way": ("scene.toml", ("phi = 0.6", 'phi = 0.6\nmeasured = "along"'), r"release\.measured: .*vertical"),
    "measured of another kind": ("scene.toml", ("phi = 0.6", "phi = 0.6\nmeasured = true"), r"release\.measured"),
    "gauge outside": ("scene.toml", ("1032.5, 2012.5", "32.5, 2012.5"), r"outputs\.gauges: .*32\.5"),
    "gauge with swapped axes": ("scene.toml", ("1032.5, 2012.5", "2012.5, 1032.5"), "with x and y exchanged it would"),
    "gauge with one coordinate": ("scene.toml", ("[[1032.5, 2012.5]]", "[1032.5]"), r"outputs\.gauges"),
    "gauge of text": ("scene.toml", ("[[1032.5, 2012.5]]", '"here"'), r"outputs\.gauges"),
    "line outside": ("scene.toml", ("[1030.0, 2001.0]", "[1030.0, 1.0]"), r"outputs\.lines: .*across"),
    "line on no data": ("scene.toml", ("[[1030.0, 2001.0], [1030.0, 2024.0]]", "[[1057.0, 2001.0], [1057.0, 2024.0]]"), r"outputs\.lines: `lines`, across must cross cells"),
    "thickness that is true": ("release.geojson", collection(thickness=True), "attribute `thickness` must be a number, got True"),
    "line of one point": ("scene.toml", (", [1030.0, 2024.0]", ""), r"outputs\.lines: .*across"),
    "threshold below zero": ("scene.toml", ("gauges =", "threshold = -1.0\ngauges ="), r"outputs\.threshold"),
    "threshold not a number": ("scene.toml", ("gauges =", "threshold = nan\ngauges ="), r"outputs\.threshold"),
    "friction not a number": ("scene.toml", ("nu = 0.2", "nu = nan"), r"friction\.nu"),
    "friction from no raster": ("scene.toml", ("nu = 0.2", 'nu = {file = "nu.asc"}'), r"friction\.nu.*there is no file nu.asc"),
    "hydrograph without area": ("scene.toml", ("[friction]", '[[hydrograph]]\nfile = "q.csv"\n[friction]'), r"hydrograph\[0\].*`area` is missing"),
    "hydrograph without file": ("scene.toml", ("[friction]", '[[hydrograph]]\nfile = "q.csv"\narea = "release.geojson"\n[friction]'), r"hydrograph\[0\].*there is no file q.csv"),
    "interval beside a terrain": ("scene.toml", ("t_end = 1.5", "t_end = 1.5\ninterval = [0.0, 1.0]"), "exclude each other"),
    "name that is a path": ("scene.toml", ("across =", '"../across" ='), r"outputs\.lines"),
}


@pytest.mark.parametrize("command", ["run", "check"])
@pytest.mark.parametrize("fault", FAULTS)
def test_each_fault_is_one_sentence_and_nothing_is_written(folder, capsys, fault, command):
    name, made, words = FAULTS[fault]
    if made is None:
        (folder / name).unlink()
    elif isinstance(made, str):
        (folder / name).write_text(made)
    else:
        change(folder, name, *made)
    before = files(folder)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        code = main([command, "scene.toml"])
    said = capsys.readouterr().err
    assert code == 2, said
    assert said.startswith("fvkit: ")
    assert said.count("\n") == 1, said
    assert name in said or "scene.toml" in said
    assert re.search(words, said), said
    assert files(folder) == before


def test_the_sample_is_what_its_script_makes(tmp_path):
    sample_torrent.main(tmp_path)
    packaged = SAMPLES["sample-torrent"].parent
    for name in ("terrain.asc", "release.geojson"):
        assert (tmp_path / name).read_bytes() == (packaged / name).read_bytes()
    assert sum(path.stat().st_size for path in packaged.iterdir()) < 300_000
    scene = find_scene("sample-torrent")
    assert scene.terrain.grid.shape == (150, 250)
    with pytest.raises(ValueError, match=r"did you mean sample-torrent\?"):
        find_scene("sample-torent")


def test_pictures_over_the_plane_are_drawn_where_they_are_asked_for(folder, capsys):
    run = ["run", "scene.toml", "--model", "shallow-water", "--out"]
    assert main([*run, "out", "--plot", "vectors", "--line", "1002", "2010", "1050", "2010"]) == 0
    drawn = {path.stem for path in (folder / "out").glob("*.png")}
    assert drawn == {"vectors", "cut", "max_depth", "max_speed", "max_pressure", "arrival"}
    assert main([*run, "out"]) == 0
    assert {path.stem for path in (folder / "out").glob("*.png")} == drawn - {"vectors", "cut"}
    capsys.readouterr()
    assert main([*run, "other", "--plot", "speeds"]) == 2
    assert "--plot speeds needs a scene with one axis" in capsys.readouterr().err
    assert main(["run", "dam-break", "--plot", "map", "--out", "other"]) == 2
    assert "--plot map needs a scene with two axes" in capsys.readouterr().err
    assert not (folder / "other").exists()


def test_the_report_says_what_limits_the_result(folder, capsys):
    """A flow that still moves, and one that has left or stopped."""
    run = ["run", "scene.toml", "--model", "shallow-water", "--out"]
    change(folder, "scene.toml", 't_end = 1.5', 't_end = 3.0')
    assert main([*run, "out"]) == 0
    printed, page = capsys.readouterr().out, (folder / "out/report.html").read_text()
    assert "the flow still moves at the end" in printed
    left = re.search(r"caution: ([0-9.]+) m3, ([0-9.]+)% of all, left through the south", printed)
    solution = fv.load("out/solution.npz")
    gone, first = -solution.stats.entered["south"]["h"], solution.q[0, 0].sum() * 25.0
    assert (float(left[1]), float(left[2])) == (pytest.approx(gone, rel=1e-3), pytest.approx(100.0 * gone / first, abs=0.051))
    assert page.count("<li>") == printed.count("caution: ") + 1
    assert "no error of the grid was estimated: a run with cell = 10" in page
    change(folder, "scene.toml", "nu = 0.2", "nu = 2.0")
    with open("scene.toml", "a") as file:
        file.write('[boundary]\nall = "wall"\n')
    assert main([*run, "rest"]) == 0
    assert "caution:" not in capsys.readouterr().out
