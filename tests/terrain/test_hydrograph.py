"""Hydrographs on a terrain: discharge through polygons and lines, thickness and speed through lines; mistakes in them."""

import json
from contextlib import nullcontext

import numpy as np
import pytest

import fvkit as fv
import fvkit_granular as gr
from fvkit.cli import main
from fvkit_granular.models.slope import within_reach
from fvkit_granular.terrain import features
from tests.terrain.rasters import ramp
from tests.terrain.test_mountain import rectangle, terrain


def line(*points):
    return {"type": "LineString", "coordinates": [list(point) for point in points]}


@pytest.mark.parametrize("area", [rectangle(20.0, 40.0, 30.0, 50.0), line((22.0, 31.0), (26.0, 44.0), (40.0, 49.0))], ids=["area", "line"])
@pytest.mark.parametrize("start", [0.0, 50.0])
def test_a_hydrograph_brings_its_volume_also_when_it_begins_late_on_dry_ground(tmp_path, start, area):
    table = tmp_path / "inflow.csv"
    rows = "".join(f"{start + t:g},{discharge},0.5\n" for t, discharge in ((0, 0), (1, 20), (5, 20), (6, 0)))
    table.write_text(f"t [s],discharge [m3/s],phi [-]\n{rows}")
    ground = terrain(gaps=False)
    source = gr.read_hydrograph(table, area, ground)
    scene = gr.Scene(terrain=ground, t_end=90.0, sources=(source, gr.CoulombFriction(0.3)), boundary=fv.Wall())
    solution = fv.solve(scene.problem(gr.Reduced), backend="numpy", limits=fv.Limits(steps=60), throw=False)
    assert solution.t[-1] > start + 6.0
    assert solution.stats.entered_by_sources["h"] == pytest.approx(100.0, rel=1e-12)


def test_a_hydrograph_after_the_end_of_the_run_is_told(tmp_path):
    table = tmp_path / "inflow.csv"
    table.write_text("t [s],discharge [m3/s],phi [-]\n200,8,0.5\n300,8,0.5\n")
    ground = terrain(gaps=False)
    source = gr.read_hydrograph(table, rectangle(20.0, 40.0, 30.0, 50.0), ground)
    with pytest.warns(UserWarning, match="brings nothing by `t_end` = 200 s: its times are 200 to 300 s; count them from"):
        gr.Scene(terrain=ground, t_end=200.0, sources=(source,))
    gr.Scene(terrain=ground, t_end=201.0, sources=(source,))


@pytest.mark.parametrize("turned", [lambda x, y: (x, y), lambda x, y: (12.0 - x, y), lambda x, y: (y, x)])
def test_a_hydrograph_on_a_line_comes_in_by_its_length_in_each_cell(tmp_path, turned):
    table = tmp_path / "inflow.csv"
    table.write_text("t [s],discharge [m3/s],phi [-]\n0,8,0.5\n1,8,0.5\n")
    ground = gr.Terrain(fv.Grid((0.0, 0.0), (12.0, 12.0), (3, 3)), np.zeros((3, 3)))
    points = [turned(*point) for point in ((3.0, 2.0), (9.0, 2.0), (9.0, 10.0))]
    rates = gr.read_hydrograph(table, line(*points), ground).intensity.averages(0.5) * 16.0
    lengths = np.zeros((3, 3))
    for x, y, length in ((2.0, 2.0, 1.0), (6.0, 2.0, 4.0), (10.0, 2.0, 3.0), (10.0, 6.0, 4.0), (10.0, 10.0, 2.0)):
        lengths[ground.grid.index(*turned(x, y))] = length
    np.testing.assert_allclose(rates, 8.0 * lengths / 14.0, rtol=1e-13)


@pytest.mark.parametrize(("area", "words"), [
    (line((22.0, 31.0), (22.0, 500.0)), r"line must lie within the terrain, .* it reaches .* m north of it"),
    (line((50.0, 45.0), (75.0, 45.0)), "line must lie where the terrain has data"), (line((50.0, 45.0), (50.0, 45.0)), "two points"),
    ({"type": "FeatureCollection", "features": [{"type": "Feature", "properties": {}, "geometry": shape} for shape in (line((1.0, 1.0), (9.0, 9.0)), rectangle(20.0, 40.0, 30.0, 50.0))]},
     "must be a Polygon or MultiPolygon, got 'LineString'")])
def test_a_hydrograph_on_a_wrong_line_says_why(tmp_path, area, words):
    table = tmp_path / "inflow.csv"
    table.write_text("t [s],discharge [m3/s],phi [-]\n0,8,0.5\n1,8,0.5\n")
    with pytest.raises(ValueError, match=words):
        gr.read_hydrograph(table, area, terrain())


def level(n=24, cell=5.0):
    return gr.Terrain(fv.Grid((0.0, 0.0), (n * cell, n * cell), (n, n)), np.zeros((n, n)))


def flow(folder, rows, area, ground, header="t [s],thickness [m],speed [m/s],phi [-]"):
    table = folder / "flow.csv"
    table.write_text(f"{header}\n" + "".join(f"{','.join(map(str, row))}\n" for row in rows))
    return gr.read_hydrograph(table, area, ground)


SKEW = line((30.0, 40.0), (42.0, 56.0), (54.0, 61.0))  # 20 m and 13 m


@pytest.mark.parametrize("model", [gr.TwoPhase, gr.Reduced, gr.ShallowWater])
def test_thickness_and_speed_through_a_line_bring_their_volume(tmp_path, model):
    """In km/h and min as other columns have them; each row is thickness times speed times length."""
    rows = [(0.0, 50.0, 0.0, 60.0), (0.1, 50.0, 18.0, 60.0), (0.2, 150.0, 36.0, 60.0), (0.3, 0.0, 7.2, 60.0)]
    source = flow(tmp_path, rows, SKEW, level(), "t [min],thickness [cm],speed [km/h],phi [%]")
    scene = gr.Scene(terrain=level(), t_end=20.0, sources=source, boundary=fv.Wall())
    solution = fv.solve(scene.problem(model), backend="numpy", nonhyperbolic="ignore", step=fv.Step(dt_initial=0.1))
    np.testing.assert_allclose(source.intensity.values, 33.0 * np.array([0.0, 0.5 * 5.0, 1.5 * 10.0, 0.0]), rtol=1e-14)
    balance = gr.mass_balance(scene, solution)
    volume = 33.0 * 6.0 * (0.5 * 2.5 + 0.5 * (2.5 + 15.0) + 0.5 * 15.0)
    shares = {"hs": 0.6, "hf": 0.4} if model is not gr.ShallowWater else {"h": 1.0}
    assert balance.entered["hydrograph"] == pytest.approx({name: share * volume for name, share in shares.items()}, rel=1e-12)
    assert max(map(abs, balance.error.values())) < 1e-12


@pytest.mark.parametrize("model", [gr.TwoPhase(gamma=0.4), gr.Reduced(gamma=0.4), gr.ShallowWater()])
@pytest.mark.parametrize("backwards", [False, True])
def test_flow_through_a_line_brings_its_momentum(tmp_path, model, backwards):
    """On level wet ground the momentum of all that flows is what came in: discharge times speed, to the right of the line."""
    points = SKEW["coordinates"][::-1 if backwards else 1]
    source = flow(tmp_path, [(0.0, 0.5, 4.0, 0.3), (2.0, 0.5, 4.0, 0.3)], line(*points), level())
    scene = gr.Scene(terrain=level(), t_end=2.0, initial=lambda x, y: {"h": 0.1, "phi": 0.3}, sources=source, boundary=fv.Wall())
    solution = fv.solve(scene.problem(model), backend="numpy", nonhyperbolic="ignore")
    q = solution.q[-1].sum(axis=(1, 2)) * solution.grid.cell_volume
    moved = q[1:3] + 0.4 * q[4:6] if len(model.phases) > 1 else q[-2:]
    density = 1.0 if isinstance(model, gr.ShallowWater) else 0.3 + 0.4 * 0.7
    to_the_right = np.array([16.0 + 5.0, -12.0 - 12.0]) * (-1.0 if backwards else 1.0)
    np.testing.assert_allclose(moved, density * 0.5 * 4.0 * 4.0 * 2.0 * to_the_right, rtol=1e-12)


@pytest.mark.parametrize("backwards", [False, True])
def test_flow_comes_in_downhill_at_its_speed_along_the_ground(tmp_path, backwards):
    ground = ramp(slope=(-0.5, 0.25))
    points = [(1010.0, 2004.0), (1020.0, 2024.0)][::-1 if backwards else 1]
    source = flow(tmp_path, [(0.0, 1.0, 6.0, 0.5), (9.0, 1.0, 6.0, 0.5)], line(*points), ground)
    within = source.intensity.shape > 0.0
    x, y = (along.averages(1.0)[within] for along in (source.speed_x, source.speed_y))
    np.testing.assert_allclose(x * 10.0 + y * 20.0, 0.0, atol=1e-13)
    assert (x > 0.0).all()
    np.testing.assert_allclose(x**2 + y**2 + (-0.5 * x + 0.25 * y) ** 2, 36.0, rtol=1e-13)


def test_fast_flow_may_reach_higher_ground(tmp_path):
    """By v^2/(2g): what decides the equations. Level ground, and a hillside from 3 m above it on."""
    heights = np.zeros((24, 24))
    heights[:, 14:] = 3.0 + 2.5 * np.arange(10.0)
    ground = gr.Terrain(level().grid, heights)
    for speed, reached in ((1.0, 0.0), (20.0, 0.5)):
        source = flow(tmp_path, [(0.0, 1.0, speed, 0.5), (9.0, 1.0, speed, 0.5)], line((40.0, 80.0), (40.0, 20.0)), ground)
        scene = gr.Scene(terrain=ground, t_end=5.0, sources=source)
        assert within_reach(scene.problem(gr.TwoPhase(slope="steep")), 9.81) == pytest.approx(reached)


BOTH = "t [s],discharge [m3/s],thickness [m],speed [m/s],phi [-]"


@pytest.mark.parametrize(("header", "row", "area", "words"), [
    (BOTH, (9.0, 1.0, 2.0, 0.5), SKEW, "must have a column discharge, or thickness and speed, which make one, got discharge and thickness and speed"),
    (BOTH.replace("thickness [m],", ""), (9.0, 2.0, 0.5), SKEW, "got discharge and speed: leave out either"),
    ("t [s],thickness [m],phi [-]", (1.0, 0.5), SKEW, "`column of .*flow.csv` must be one of t, thickness, phi; got 'speed'"),
    ("t [s],phi [-]", (0.5,), SKEW, "must be one of t, phi; got 'discharge'"),
    ("t [s],thickness [m],speed [m/s],phi [-]", (1.0, 2.0, 0.5), rectangle(20.0, 40.0, 30.0, 50.0), "thickness and speed must come in through a line, got polygons"),
    ("t [s],thickness [m],speed [m/s],phi [-]", (0.0, 2.0, 0.5), SKEW, "thickness must be > 0 somewhere, got 0 in every line"),
    ("t [s],thickness [m],speed [m/s],phi [-]", (2.0, 0.0, 0.5), SKEW, "speed must be > 0 somewhere"),
    ("t [s],discharge [m3/s],phi [-]", (0.0, 0.5), SKEW, "discharge must be > 0 somewhere"),
    ("t [s],thickness [m],speed [m/s],phi [-]", (1.0, -2.0, 0.5), SKEW, "line 2: speed must be >= 0, got -2"),
    ("t [s],thickness [m],speed [m/s],phi [-]", (-1.0, 2.0, 0.5), SKEW, "line 2: thickness must be >= 0, got -1"),
    ("t [s],thickness [m],speed [mph],phi [-]", (1.0, 2.0, 0.5), SKEW, "column `speed` must be a speed in one of m/s, km/h; got speed \\[mph\\]")])
def test_a_table_without_one_discharge_says_why(tmp_path, header, row, area, words):
    with pytest.raises(ValueError, match=words):
        flow(tmp_path, [(t, *row) for t in (0.0, 4.0)], area, terrain(gaps=False), header)


@pytest.mark.parametrize(("header", "largest", "area", "words"), [
    ("discharge [m3/s]", "20000", SKEW, None), ("discharge [m3/s]", "40000", SKEW, "discharge is 40000, and plausible from 0 to 33000"),
    ("discharge [m3/s]", "15000", rectangle(20.0, 40.0, 30.0, 50.0), None), ("discharge [l/s]", "15000000", rectangle(20.0, 40.0, 30.0, 50.0), None),
    ("discharge [m3/s]", "15000000", rectangle(20.0, 40.0, 30.0, 50.0), "1000 l/s are 1"),
    ("thickness [m],speed [m/s]", "20,60", SKEW, None), ("thickness [cm],speed [km/h]", "200,200", SKEW, None),
    ("thickness [m],speed [m/s]", "200,6", SKEW, "thickness is 200.*200 cm are 2"),
    ("thickness [m],speed [m/s]", "2,200", SKEW, "speed is 200, .*36 km/h are 10")])
def test_a_flow_in_another_unit_is_warned_of(tmp_path, header, largest, area, words):
    first = ",".join("0" * (1 + header.count(",")))
    with pytest.warns(UserWarning, match=words) if words else nullcontext():
        flow(tmp_path, [(0.0, first, 0.5), (4.0, largest, 0.5)], area, level(), f"t [s],{header},phi [-]")


def test_the_file_of_a_line_is_read_once(tmp_path, monkeypatch):
    opened, read = [], features.READERS[".geojson"]
    monkeypatch.setitem(features.READERS, ".geojson", lambda path: (opened.append(path), read(path))[1])
    (tmp_path / "line.geojson").write_text(json.dumps(SKEW))
    flow(tmp_path, [(0.0, 1.0, 2.0, 0.5), (4.0, 1.0, 2.0, 0.5)], tmp_path / "line.geojson", level())
    assert len(opened) == 1


def test_check_tells_and_draws_where_flow_through_a_line_goes(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    ground = terrain(gaps=False)
    gr.write_raster("dem.asc", ground.bottom, ground)
    (tmp_path / "line.json").write_text(json.dumps(line((30.0, 30.0), (30.0, 50.0))))
    (tmp_path / "flow.csv").write_text("t [s],thickness [m],speed [m/s],phi [-]\n0,1,2,0.5\n4,1,6,0.5\n")
    (tmp_path / "line.toml").write_text('t_end = 4.0\nterrain = {file = "dem.asc"}\nhydrograph = [{file = "flow.csv", area = "line.json"}]\n')
    assert main(["check", "line.toml"]) == 0
    said = capsys.readouterr()
    assert "320 m3 by 4 s, from 0 to 4 s, at up to 6 m/s towards 90 degrees (90 is east)" in said.out
    assert said.err == ""
