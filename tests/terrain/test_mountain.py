"""Scenes on a terrain: made anew with other parts, mirrored, with curved ground; runs and checks of the command."""

import json
import pickle

import attrs
import numpy as np
import pytest

import fvkit as fv
import fvkit_granular as gr
from fvkit.cli import main

DX, SHAPE = 5.0, (18, 24)


def terrain(heights=None, gaps=True, cells=SHAPE):
    """A valley that falls to the east, with a hole without data in the way of the flow."""
    ny, nx = cells
    grid = fv.Grid((0.0, 0.0), (nx * DX, ny * DX), (nx, ny))
    x, y = np.meshgrid(*(axis.centers for axis in grid.axes))
    b = 100.0 + 80.0 * np.exp(-x / 70.0) + 0.006 * (y - 40.0 - 8.0 * np.sin(x / 30.0)) ** 2
    if gaps:
        b[(x > 60.0) & (x < 80.0) & (abs(y - 45.0) < 10.0)] = np.nan
    return gr.Terrain(grid, b if heights is None else heights)


def rectangle(x0, x1, y0, y1):
    return {"type": "Polygon", "coordinates": [[[x0, y0], [x1, y0], [x1, y1], [x0, y1], [x0, y0]]]}


def release(on, thickness=1.0):
    return gr.read_release(rectangle(10.0, 40.0, 25.0, 60.0), on, thickness=thickness)


def volumes(scene):
    return scene.problem(gr.TwoPhase).q0[[0, 3]].sum(axis=(1, 2)) * DX**2


def test_an_evolved_scene_takes_its_new_release_gaps_and_terrain():
    ground = terrain()
    scene = gr.Scene(terrain=ground, release=release(ground), phi=0.6, t_end=2.0)
    np.testing.assert_allclose(volumes(attrs.evolve(scene, release=release(ground, 3.0))), 3.0 * volumes(scene))
    np.testing.assert_allclose(volumes(attrs.evolve(scene, phi=0.1)), np.array([0.1, 0.9]) * volumes(scene).sum())
    walls = gr.Scene(terrain=ground, release=release(ground), phi=0.6, t_end=2.0, gaps="wall")
    for made in (scene, pickle.loads(pickle.dumps(scene))):
        np.testing.assert_array_equal(attrs.evolve(made, gaps="wall").bottom, walls.bottom)
        other = terrain(cells=(15, 20))
        moved = attrs.evolve(made, terrain=other, release=release(other))
        assert moved.problem(gr.Reduced).grid == other.grid
        assert moved.ends == ((0.0, 100.0), (0.0, 75.0))


@pytest.mark.parametrize(("change", "words"), [
    ({"initial": lambda x, y: {"h": 0.5, "phi": 0.1}}, "`initial` and `release` exclude each other"),
    ({"bottom": 5.0}, "`bottom` must be left out with a `terrain`"),
    ({"bottom": lambda x, y: 0.0 * x}, "`bottom` must be left out with a `terrain`"),
    ({"release": None, "initial": lambda x, y: {"h": 0.5, "phi": 0.1}}, "`phi` is the solid fraction of a `release`"),
    ({"gaps": "wall", "sources": gr.Curvature()}, "`gaps` must be \"outlet\" with gr.Curvature")])
def test_what_a_scene_would_leave_out_is_refused(change, words):
    ground = terrain()
    with pytest.raises(ValueError, match=words):
        gr.Scene(**{"terrain": ground, "release": release(ground), "phi": 0.6, "t_end": 2.0} | change)


@pytest.mark.parametrize("sources", [(), (gr.Curvature(),)])
def test_a_mirrored_terrain_has_mirrored_maps(sources):
    """Also beside outlets, whose cells have several nearest neighbours with data."""
    heights = terrain().bottom + np.random.default_rng(1).uniform(0.0, 0.5, SHAPE)
    heights[9] -= 3.0  # a gully, one cell wide
    heights[3:5, 8:10] -= 6.0  # a pit
    heights[:, 14:] -= 10.0  # a cliff
    heights = np.where(terrain().missing, np.nan, heights)
    maps = []
    for way in (np.s_[:, :], np.s_[:, ::-1], np.s_[::-1], np.s_[::-1, ::-1]):
        ground = terrain(heights[way].copy())
        thick = np.zeros(SHAPE)
        thick[5:12, 2:8] = 1.5
        scene = gr.Scene(terrain=ground, release=gr.read_release(thick[way].copy(), ground), phi=0.6, t_end=3.0,
                         sources=(gr.CoulombFriction(0.2), gr.ConstantDrag(5.0), *sources))
        hazard = gr.HazardMaps()
        assert fv.solve(scene.problem(gr.Reduced), backend="numpy", observers=hazard).model.slope == "steep"
        maps.append({name: values[way] for name, values in hazard.maps.items()})
    for name in ("depth", "speed", "pressure", "thickness"):
        for mirrored in maps[1:]:
            np.testing.assert_allclose(mirrored[name], maps[0][name], rtol=1e-10, atol=1e-10 * maps[0][name].max())


@pytest.mark.parametrize("slope", ["auto", "steep"])
def test_curvature_and_hazard_maps_in_a_scene(slope):
    """A class gets the equations that the source needs; the maps see slopes, not second derivatives."""
    ground = terrain(gaps=False)
    scene = gr.Scene(terrain=ground, release=release(ground), phi=0.6, t_end=0.5, sources=gr.Curvature(), slope=slope)
    hazard = gr.HazardMaps()
    assert fv.solve(scene.problem(gr.ShallowWater), backend="numpy", observers=hazard).model.slope == "steep"
    slopes = scene.problem(gr.ShallowWater).given[1:3]
    np.testing.assert_allclose(hazard.maps["thickness"], hazard.maps["depth"] / np.sqrt(1.0 + slopes[0] ** 2 + slopes[1] ** 2))
    with pytest.raises(ValueError, match="Curvature needs the equations for steep ground"):
        attrs.evolve(scene, slope="mild").problem(gr.ShallowWater)


SCENE = """
t_end = 4.0
phi = 0.6
release = {file = "release.geojson", thickness = 1.0}
terrain = {file = "dem.asc"}
sources = [{type = "coulomb", nu = 0.2}, {type = "constant-drag", D = 5.0}]
hydrograph = [{file = "inflow.csv", area = "release.geojson"}]
outputs = {count = 2, gauges = [[50.0, 45.0]], lines = {bridge = [[55.0, 5.0], [55.0, 80.0]]}}
"""


@pytest.fixture
def folder(tmp_path, monkeypatch):
    """A working folder with a scene on a terrain."""
    monkeypatch.chdir(tmp_path)
    ground = terrain()
    gr.write_raster("dem.asc", ground.bottom, ground)
    (tmp_path / "release.geojson").write_text(json.dumps(rectangle(10.0, 40.0, 25.0, 60.0)))
    (tmp_path / "inflow.csv").write_text("t [s],discharge [m3/s],phi [-]\n0,0,0.2\n1,40,0.5\n3,0,0.3\n")
    (tmp_path / "valley.toml").write_text(SCENE)
    return tmp_path


@pytest.mark.filterwarnings("ignore:characteristic speeds:RuntimeWarning")
def test_a_run_on_a_terrain_goes_on_with_its_maps_and_series(folder, capsys):
    assert main(["run", "valley.toml", "--backend", "numpy", "--out", "whole"]) == 0
    scene = gr.load_scene("valley.toml")
    fv.solve(scene.problem(gr.TwoPhase), None, scene.times, backend="numpy", limits=fv.Limits(steps=9), throw=False,
             observers=tuple(scene.watch.observers(2).values()), checkpoint=fv.Checkpoint("run.npz", 0.0))
    assert main(["run", "--resume", "run.npz", "--out", "parts"]) == 2
    assert "give the scene too, fvkit run SCENE --resume run.npz" in capsys.readouterr().err
    assert main(["run", "valley.toml", "--resume", "run.npz", "--out", "parts"]) == 0
    names = [path.name for path in (folder / "whole").iterdir() if path.suffix in (".asc", ".csv")]
    assert len(names) == 10
    for name in names:
        assert (folder / "parts" / name).read_bytes() == (folder / "whole" / name).read_bytes(), name
    assert (folder / "parts/report.html").is_file()


@pytest.mark.parametrize(("old", "new", "words"), [
    ("[50.0, 45.0]", "[500.0, 45.0]", "`gauges` must lie within the scene, x from 0 to 120 m, got x = 500"),
    ("[50.0, 45.0]", "[70.0, 45.0]", "`gauges` must lie where the terrain has data, got (70.0, 45.0)"),
    ("[55.0, 5.0]", "[55.0, -5.0]", "`lines`, bridge must lie within the scene, y from 0 to 90 m, got y = -5"),
    ("bridge =", "'a/b' =", "`lines` must have names of letters"),
    ("inflow.csv", "one.csv", "a hydrograph must have two rows or more"),
    ('"coulomb", nu = 0.2', '"curvature"', "gaps")])
def test_what_a_run_would_stumble_over_is_told_by_check(folder, capsys, old, new, words):
    (folder / "one.csv").write_text("t [s],discharge [m3/s],phi [-]\n0,40,0.2\n")
    text = SCENE.replace(old, new)
    (folder / "other.toml").write_text(text.replace('"dem.asc"', '"dem.asc", gaps = "wall"') if words == "gaps" else text)
    for command in ("check", "run"):
        assert main([command, "other.toml"]) == 2
        assert words in capsys.readouterr().err


def test_check_says_what_a_hydrograph_brings(folder, capsys):
    assert main(["check", "valley.toml"]) == 0
    assert "a hydrograph: 60 m3 by 4 s, from 0 to 3 s" in capsys.readouterr().out
    (folder / "short.toml").write_text(SCENE.replace("t_end = 4.0", "t_end = 1.0"))
    assert main(["check", "short.toml"]) == 0
    assert "a hydrograph: 20 m3 by 1 s" in capsys.readouterr().out


@pytest.mark.filterwarnings("ignore:characteristic speeds:RuntimeWarning")
def test_a_folder_holds_the_records_of_one_run(folder, capsys):
    (folder / "out/report.html").mkdir(parents=True)
    assert main(["run", "valley.toml", "--backend", "numpy", "--out", "out"]) == 2
    assert "to write report.html into" in capsys.readouterr().err
    (folder / "out/report.html").rmdir()
    assert not list((folder / "out").iterdir())  # told before anything was computed
    assert main(["run", "valley.toml", "--backend", "numpy", "--out", "out"]) == 0
    (folder / "out/line-mine.csv").write_text("kept")
    (folder / "bare.toml").write_text("\n".join(line for line in SCENE.splitlines() if not line.startswith("outputs")))
    assert main(["run", "bare.toml", "--backend", "numpy", "--out", "out"]) == 0
    left = {path.name for path in (folder / "out").iterdir()}
    assert not {"gauges.csv", "line-bridge.csv"} & left
    assert {"line-mine.csv", "max_depth.asc", "report.html"} <= left
