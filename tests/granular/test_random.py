"""`tests.tools.random_scenes`: what is drawn, how runs are judged, the report; and a small size of the whole."""

import csv
import json
import shlex

import attrs
import numpy as np
import pytest

import fvkit as fv
import fvkit_granular as gr
from fvkit.backends.compiled.numba_kernel import available
from fvkit_granular.models.registry import MODELS, RIEMANN
from tests.tools import random_draws, random_runs
from tests.tools.random_draws import BOTTOMS, CELLS, CLASSES, FAMILIES, INFLOWS, PLANE, SETTINGS, draw, random_scene
from tests.tools.random_limits import COLLAPSES, known_collapses
from tests.tools.random_runs import ROUNDING, pairs, plan, random_stress, run_random
from tests.tools.random_scenes import main

#: Indices of one turn through classes, settings and bottoms.
TURN = len(CLASSES) * len(SETTINGS) * len(BOTTOMS)


@pytest.fixture(autouse=True)
def _compiled(monkeypatch):
    monkeypatch.setenv("FVKIT_BACKEND", "auto")


def test_the_same_seed_draws_the_same_scenes_of_every_kind():
    assert [draw(1, k)[0] for k in range(8)] == list(CLASSES)
    first, again, other = (random_scene(seed, 11) for seed in (1, 1, 2))
    for one, two in zip((*first.flow, first.b), (*again.flow, again.b), strict=True):
        assert np.array_equal(one, two)
    assert not np.array_equal(first.flow[0], other.flow[0])
    seen = {(scene.kind, scene.setting, scene.bottom) for scene in (random_scene(1, k) for k in range(TURN))}
    assert len(seen) == TURN


def test_scenes_with_an_inflow_lie_on_slopes_of_up_to_one_with_friction():
    scenes = [random_scene(1, k, INFLOWS) for k in range(400)]
    assert {scene.setting for scene in scenes} == set(INFLOWS)
    falls = [scene.b[0] - scene.b[-1] for scene in scenes if scene.bottom == "step" and np.ptp(np.diff(scene.b)) < 1e-12]
    assert min(falls) < -0.8
    assert max(falls) > 0.8
    froude = np.array([v / np.sqrt(9.81 * h) for h, _, v, _ in (scene.comes for scene in scenes)])
    assert froude.min() < 0.1 < 2.9 < froude.max()
    assert all(len(scene.sources(gr.TwoPhase())) == 2 for scene in scenes)


def test_scenes_on_a_plane_have_every_direction_end_and_slope():
    scenes = [random_scene(1, k, PLANE) for k in range(600)]
    assert np.array_equal(scenes[7].across, random_scene(1, 7, PLANE).across)
    assert len({(scene.kind, scene.setting, scene.bottom) for scene in scenes}) == TURN
    assert {scene.ends for scene in scenes} == {(ends, side) for ends in (*SETTINGS, *INFLOWS) for side in random_draws.INWARDS}
    assert {len(np.unique(scene.flow[1])) for scene in scenes if scene.kind == "generic"} == {3, 4}
    headings = np.array([np.arctan2(scene.across[0].flat[0], scene.flow[2].flat[0]) for scene in scenes])
    assert np.histogram(headings, 8, (-np.pi, np.pi))[0].min() > 40
    planes = [np.gradient(scene.b) for scene in scenes if scene.bottom == "step"]
    slopes = np.array([[rise.mean() * cells for rise, cells in zip(one, random_draws.PLANE_CELLS[::-1], strict=True)]
                       for one in planes if max(np.ptp(rise) for rise in one) < 1e-12])
    level = np.abs(slopes).max(axis=1) < 1e-9
    assert 0.2 < level.mean() < 0.8
    assert np.hypot(*slopes.T).max() <= 1.0 + 1e-9
    assert (slopes.min(axis=0) < -0.7).all()
    assert (slopes.max(axis=0) > 0.7).all()
    assert {scene.model(gr.TwoPhase).slope for scene in scenes} == {"mild", "steep"}


def test_the_ranges_are_those_that_are_promised():
    scenes = [random_scene(1, k) for k in range(4000)]
    wet = np.concatenate([scene.flow[0][scene.flow[0] > 0.0] for scene in scenes])
    phi, gamma = np.concatenate([scene.flow[1] for scene in scenes]), np.array([scene.gamma for scene in scenes])
    assert wet.min() < 1e-290
    assert {0.0, 1.0} <= set(phi)
    assert ((phi > 0.0) & (phi < 1e-12)).any()
    assert ((phi < 1.0) & (phi > 1.0 - 1e-12)).any()
    assert 0.05 <= gamma.min() < 0.06 < 0.97 < gamma.max() <= 0.98
    drag = np.array([scene.drag for scene in scenes]).ravel()
    assert drag.min() == 0.0
    assert 1e11 < drag.max() <= 1e12
    flows = [scene.flow for scene in scenes if scene.kind == "fast" and scene.bottom == "step"]
    assert 49.0 < max(float((np.abs(vs) / np.sqrt(9.81 * h)).max()) for h, _, vs, _ in flows) <= 50.0
    lost = sum(run_random("two-phase", "relaxation", 1, 1, k, 1)["lost"] > 0 for k in range(5, 16 * 8, 8))
    assert lost >= 3, "slip passes through the complex range"
    islands = [scene for scene in scenes if scene.bottom == "islands" and scene.kind == "generic"]
    assert sum((scene.flow[0] == 0.0).any() for scene in islands) > 0.05 * len(islands)


@pytest.mark.skipif(not available(), reason="only compiled code is shared")
@pytest.mark.parametrize(("settings", "number"), [(SETTINGS, 0), (SETTINGS, 1), (SETTINGS, 2), (PLANE, 1)],
                         ids=[*SETTINGS, "plane"])
def test_scenes_that_share_code_run_as_each_alone_to_the_bit(settings, number):
    scenes = [random_scene(1, 8 * number + shift, settings).problem(gr.TwoPhase) for shift in (0, 24 * 3 + 4)]
    scenes.append(attrs.evolve(scenes[1], aux={}))

    def ran(problem):
        stepper = fv.Stepper(problem, fv.WavePropagation(fv.Roe()), "numba", "ignore")
        stepper.run(1e3, 20)
        return stepper.t, stepper.q.tobytes()

    with random_runs.code_kept():
        shared = [ran(problem) for problem in scenes]
    assert shared == [ran(problem) for problem in scenes]


def test_pairs_and_plan():
    every = pairs()
    assert len(every) == 19
    assert ("pitman-le", "roe") not in every
    assert pairs(["pitman-le"], ["roe", "hll"]) == [("pitman-le", "hll")]
    assert pairs(settings=PLANE) == [pair for pair in every if pair[0] != "pitman-le"]
    with pytest.raises(ValueError, match="does not serve pitman-le"):
        pairs(["pitman-le"], ["roe"])
    assert "20000 random scenes x 19 pairs" in plan(20000, every, (1, 2), 2)
    assert "760000 runs" in plan(20000, every, (1, 2), 2)


@attrs.frozen
class Leaking(gr.ShallowWater):
    """Shallow water whose settling loses a little mass in every step."""

    def settle(self, q):
        return q[0] * (1.0 - 1e-13), q[1]


@attrs.frozen
class Breaking(gr.ShallowWater):
    """Shallow water whose settling makes numbers that are none."""

    def settle(self, q):
        return q[0], q[1] / (q[0] - q[0])


@attrs.frozen
class Refusing(gr.ShallowWater):
    """Shallow water that cannot be built with these states."""

    def resolved(self, q0):
        raise ArithmeticError("for the test")


@pytest.mark.parametrize(("model", "status"), [(Leaking, "finished"), (Breaking, "non_finite"), (Refusing, "crashed")])
def test_what_loses_mass_or_breaks_is_found(model, status, monkeypatch):
    monkeypatch.setenv("FVKIT_BACKEND", "numpy")
    monkeypatch.setitem(MODELS, "shallow-water", model)
    report = random_runs._row(("shallow-water", "hll", 1), [run_random("shallow-water", "hll", 1, 1, 0, 1)])
    assert [one["status"].split(":")[0] for one in report["odd"]] == [status]
    failed = [check["name"] for check in report["checks"] if not check["passed"]]
    assert failed == ["mass drift / rounding" if status == "finished" else "broken or unnamed ends"]


def test_a_run_without_end_is_given_up_with_a_name(monkeypatch):
    monkeypatch.setattr(random_runs, "SECONDS", 0.0)
    (one,) = run_random("shallow-water", "hll", 1, 1, 0, 1)["odd"]
    assert one["status"] == "over_budget"
    monkeypatch.undo()
    monkeypatch.setattr(random_runs, "COLLAPSE", 1)
    monkeypatch.setattr(random_runs, "NOMINAL", 30)
    monkeypatch.setattr(fv.Stepper, "step", lambda stepper: stepper.run(np.inf, 1) or 2.0 * stepper.t)
    (one,) = run_random("shallow-water", "hll", 1, 1, 0, 1)["odd"]
    assert one["status"] == "max_steps"


@pytest.mark.parametrize("settings", FAMILIES.values(), ids=["in turn", "inflow", "plane"])
def test_the_report_names_every_odd_run_by_a_command_that_makes_it_again(tmp_path, capsys, monkeypatch, settings):
    monkeypatch.setattr(random_runs, "COLLAPSE", 1)
    report = random_stress(24, 1, ["shallow-water"], ["hll"], (1,), workers=1, settings=settings)
    kept = report.save(tmp_path / "kept")
    document = json.loads((kept / "report.json").read_text())
    assert document["rows"][0]["problems"] == 24
    assert document["versions"]["fvkit"]
    with open(kept / "report.csv", newline="") as file:
        (line,) = csv.DictReader(file)
    assert (line["model"], line["problems"]) == ("shallow-water", "24")
    assert (kept / "report.png").stat().st_size > 5000
    told = next(line for line in report.summary().splitlines() if line.startswith("  python"))
    first = report.rows[0]["odd"][0]
    assert told.split("  # ")[1].startswith(f"max_steps: {first['class']}")
    words = shlex.split(told, comments=True)
    assert words == ["python", "-m", "tests.tools.random_scenes", "1", "--seed", "1", "--first", str(first["index"]), "--models", "shallow-water",
                     "--riemann", "hll", "--orders", "1", *{id(INFLOWS): ["--inflow"], id(PLANE): ["--plane"]}.get(id(settings), [])]
    assert main([*words[3:], "--workers", "1", "--out", str(tmp_path / "out")]) == 0
    assert "0 finished, 1 collapsed, 0 broken" in capsys.readouterr().out


def test_the_command_refuses_what_it_cannot_run(tmp_path, capsys):
    for arguments, told in ((["--orders", "3"], "--orders"), (["--models", "two-phases"], "two-phase"),
                            (["--models", "pitman-le", "--riemann", "roe"], "does not serve pitman-le"), (["--first", "-1"], "--first"),
                            (["--plane", "--orders", "5"], "serves a line"), (["--plane", "--models", "pitman-le"], "two axes"),
                            (["--plane", "--inflow"], "not allowed")):
        with pytest.raises(SystemExit, match="2"):
            main(["8", *arguments, "--out", str(tmp_path)])
        assert told in capsys.readouterr().err


def test_known_shares_are_explained():
    assert {name.split()[0] for name in COLLAPSES} == set(MODELS)
    assert known_collapses("two-layer", "rusanov").share > known_collapses("two-layer", "roe").share == COLLAPSES["two-layer"].share
    for known in COLLAPSES.values():
        assert len(known.cause) > 10


@pytest.mark.skipif(not available(), reason="too slow uncompiled")
@pytest.mark.parametrize(("model", "riemann", "order"), [
    ("two-phase", "roe", 2), ("reduced", "hll", 2), ("pitman-le", "relaxation", 1), ("two-layer", "rusanov", 1)])
def test_random_scenes_end_with_a_name_and_lose_nothing(model, riemann, order):
    """The small size of `python -m tests.tools.random_scenes 20000`: three turns through every class, setting and bottom."""
    assert riemann in RIEMANN
    row = random_runs._row((model, riemann, order), [run_random(model, riemann, order, 7, 0, 3 * TURN)])
    assert row["problems"] == 3 * TURN
    assert [check for check in row["checks"] if not check["passed"]] == []
    expected = known_collapses(model, riemann).share * row["problems"]
    assert row["collapses"] <= expected + 3.0 * np.sqrt(expected)


@pytest.mark.skipif(not available(), reason="too slow uncompiled")
def test_random_scenes_on_a_plane_end_with_a_name_and_lose_nothing():
    (row,) = random_stress(TURN // 4, 7, ["two-phase"], ["relaxation"], (2,), workers=1, settings=PLANE).rows
    assert row["finished"] == row["problems"] == TURN // 4
    assert [check for check in row["checks"] if not check["passed"]] == []


@pytest.mark.skipif(not available(), reason="too slow uncompiled")
def test_the_method_of_lines_keeps_masses_to_the_same_bound():
    found = run_random("shallow-water", "hll", 5, 3, 0, 288, "channel")
    assert found["odd"] == []
    assert found["shares"].max() < 1.0
    assert found["drifts"].max() < ROUNDING * np.sqrt(10.0 * 60.0 * found["ratios"].max())


def test_a_scene_is_as_long_as_its_cells():
    assert random_scene(3, 5).problem(gr.Reduced).grid.num_cells == CELLS
