"""Run-out along a path line: places known by hand, files, checkpoints, and the command."""

import json

import numpy as np
import pytest

import fvkit as fv
import fvkit_granular as gr
from fvkit.cli import main
from tests.terrain.test_command import SCENE, change, folder  # noqa: F401

GRID = fv.Grid((0.0, 0.0), (40.0, 20.0), (8, 4))


def problem(h, t_end=1.0):
    return fv.Problem(gr.ShallowWater(), GRID, [h, 0.0 * h, 0.0 * h], t_end, aux={"b": 0.0})


def seen(path, *depths, threshold=0.1):
    """The record of a path over states of given depths, (4, 8)."""
    run_out = gr.RunOut(path, threshold)
    start = problem(depths[0])
    run_out.begin(start)
    for k, h in enumerate(depths):
        run_out.see(start, float(k), np.array([h, 0.0 * h, 0.0 * h]))
    return run_out


def cells(*places, h=0.2):
    found = np.zeros(GRID.shape)
    for place in places:
        found[place] = h
    return found


def test_the_distance_is_that_along_the_line_also_round_a_corner():
    path = [(2.0, 2.5), (22.5, 2.5), (22.5, 19.0)]  # east through five cells, then north
    run_out = seen(path, cells(), cells((0, 0)), cells((0, 2)), cells((2, 4)), cells((0, 1), (3, 7)), cells((0, 2), h=0.0999))
    np.testing.assert_allclose(run_out.distance, [np.nan, 1.5, 10.5, 20.5 + 10.0, 5.5, np.nan])
    assert run_out.length == pytest.approx(20.5 + 16.5)
    assert run_out.farthest == run_out.distance[3]
    assert not run_out.reaches_end
    assert "30.5 m of its 37 m, first at 3 s; nothing on it at the end" in str(run_out)


def test_a_flow_that_turns_away_keeps_its_largest_and_one_at_the_end_is_told():
    run_out = seen([(0.0, 2.5), (40.0, 2.5)], cells((0, 3)), cells((0, 7)), cells((0, 5)))
    assert run_out.farthest == 37.5
    assert run_out.reaches_end
    assert "27.5 m at the end" in str(run_out)
    assert "never deeper" in str(seen([(0.0, 2.5), (40.0, 2.5)], cells((3, 3))))


@pytest.mark.parametrize(("path", "words"), [
    ([(1.0, 1.0)], "`path` must be a list of at least two points"), ([(1.0, 1.0), (1.0, 1.0)], "same point twice"),
    ([1.0, 2.0], "`path` must be a list of at least two points")])
def test_what_is_no_path_is_refused(path, words):
    with pytest.raises(ValueError, match=words):
        gr.RunOut(path)


def test_a_path_outside_and_a_grid_with_one_axis_are_refused():
    with pytest.raises(ValueError, match="`path` of a RunOut"):
        seen([(1.0, 1.0), (41.0, 1.0)], cells())
    line = fv.Problem(gr.ShallowWater(), fv.Grid(0.0, 1.0, 10), lambda x: [1.0 + 0.0 * x, 0.0 * x], 0.1, aux={"b": 0.0})
    with pytest.raises(ValueError, match=r"gr\.Front"):
        fv.solve(line, observers=gr.RunOut([(0.0, 0.0), (1.0, 0.0)]))
    with pytest.raises(ValueError, match="`path` is for scenes with two axes"):
        gr.Scene((0.0, 10.0), 0.1, lambda x: {"h": 1.0 + 0.0 * x, "phi": 0.5}, watch=gr.Watch(path=[(0.0, 0.0), (1.0, 0.0)]))


def test_a_continued_run_has_the_same_series(tmp_path):
    h = cells((0, 0), (1, 0), (2, 0), (3, 0), h=2.0)
    path = [(1.0, 10.5), (39.0, 10.5)]
    whole, part, rest = (gr.RunOut(path) for _ in range(3))
    fv.solve(problem(h, 3.0), observers=whole)
    fv.solve(problem(h, 3.0), observers=part, limits=fv.Limits(steps=2), checkpoint=fv.Checkpoint(tmp_path / "run.npz"), throw=False)
    fv.resume(tmp_path / "run.npz", observers=[rest])
    assert len(part.t) < len(whole.t)
    np.testing.assert_array_equal(rest.distance, whole.distance)
    assert np.nanmax(whole.distance) > whole.distance[0]


def line(*points, crs="EPSG:31287", kind="LineString"):
    geometry = {"type": kind, "coordinates": list(points)}
    return {"type": "FeatureCollection", "crs": {"type": "name", "properties": {"name": crs}},
            "features": [{"type": "Feature", "properties": {}, "geometry": geometry}]}


@pytest.mark.parametrize(("given", "words"), [
    (line([1.0, 2.0]), "two points"), (line([1.0, 2.0], ["a", 3.0]), "two points"), (line(), "two points"), (line([1.0, 2.0], [1.0, 2.0]), "two points"),
    (line([1.0, 2.0], [3.0, float("nan")]), "two points"),
    (line([[[0, 0], [1, 0], [0, 1], [0, 0]]], kind="Polygon"), "must hold a LineString, got 'Polygon'"),
    (line([[0.0, 0.0], [1.0, 0.0]], [[1.0, 0.0], [2.0, 0.0]], kind="MultiLineString"), "must hold one line, got 2"),
    ({"type": "FeatureCollection", "features": []}, "must hold one line, got 0"),
    (line([1.0, 2.0], [3.0, 4.0], crs="EPSG:32633"), "CRS"), ([(0.0, 1.0), (2.0, 3.0)], "`path` must be")])
def test_what_holds_no_path_is_refused(given, words):
    ground = gr.Terrain(GRID, np.zeros(GRID.shape), crs="EPSG:31287")
    with pytest.raises(ValueError, match=words):
        gr.read_path(given, ground)


def test_points_digitised_twice_and_heights_are_left_out():
    ground = gr.Terrain(GRID, np.zeros(GRID.shape))
    given = {"type": "MultiLineString", "coordinates": [[[1, 2, 300.0], [1, 2, 300.0], [3, 4, 290.0]]]}
    assert gr.read_path(given, ground) == ((1.0, 2.0), (3.0, 4.0))


def test_the_command_writes_the_series_and_says_the_run_out(folder, capsys):  # noqa: F811
    (folder / "thalweg.geojson").write_text(json.dumps(line([1003.0, 2012.0], [1058.0, 2012.0])))
    (folder / "scene.toml").write_text(SCENE + 'path = "thalweg.geojson"\n')
    assert main(["run", "scene.toml", "--out", "out", "--model", "shallow-water"]) == 0
    printed = capsys.readouterr().out
    series = np.genfromtxt(folder / "out" / "run-out.csv", delimiter=",", names=True)
    assert series["distance"][0] == pytest.approx(14.5)  # the middle of the cell of 1015 to 1020
    assert f"run-out along the path: {np.nanmax(series['distance']):.6g} m of its 55 m" in printed
    assert "run-out along the path" in (folder / "out" / "report.html").read_text()
    points = '[outputs]\npath = [[1003.0, 2012.0], [1058.0, 2012.0]]\n'
    (folder / "scene.toml").write_text(SCENE.split("[outputs]")[0] + points)
    assert main(["run", "scene.toml", "--out", "again", "--model", "shallow-water"]) == 0
    assert (folder / "again" / "run-out.csv").read_bytes() == (folder / "out" / "run-out.csv").read_bytes()
    assert main(["check", "scene.toml"]) == 0


@pytest.mark.parametrize(("text", "words"), [
    ('path = "no.geojson"', "no.geojson"), ("path = [[0.0, 0.0], [1058.0, 2012.0]]", "`path` must lie within the scene"),
    ("path = [[1003.0, 2012.0]]", "at least two points"), ('path = "dem.asc"', "path"), ("path = 3.0", "path")])
def test_a_wrong_path_in_a_file_is_one_sentence(folder, text, words, capsys):  # noqa: F811
    (folder / "scene.toml").write_text(SCENE + text + "\n")
    assert main(["run", "scene.toml", "--out", "out"]) == 2
    said = capsys.readouterr().err
    assert words in said
    assert "scene.toml, outputs" in said
    assert not (folder / "out").exists()
