"""The comparison and its report: columns, orders, failures as rows, files, verdict."""

import csv
import json

import attrs
import numpy as np
import pytest

import fvkit as fv
import fvkit_granular as gr
from fvkit.pointwise.part import public_name
from fvkit.studies.report import Report, observed_orders, time_to_reach
from tests.cases import Fading

KEYS = ["model", "riemann", "limiter", "order", "backend", "cells", "steps", "rejected", "seconds", "seconds_min", "ns_per_cell_step", "error", "error_l2", "error_max", "order_observed", "mass_drift", "status"]


@pytest.fixture(scope="module")
def report() -> Report:
    return gr.compare(gr.scene("dam-break-phi"), cells=(50, 100), repeats=2)


def test_rows_hold_every_promised_column(report):
    assert [(row["model"], row["riemann"]) for row in report.rows[::2]] == [
        ("two-phase", "relaxation"), ("two-phase", "roe"), ("two-phase", "hll"), ("two-phase", "rusanov"),
        ("reduced", "relaxation"), ("shallow-water", "relaxation")]
    for row in report.rows:
        assert set(KEYS) <= row.keys()
        assert row["status"] == "finished"
        assert 0.0 < row["seconds_min"] <= row["seconds"]
        assert max(abs(drift) for drift in row["mass_drift"].values()) < 1e-13
    assert set(report.rows[0]["error"]) == {"h", "phi", "vs", "vf", "v"}
    assert set(report.rows[-1]["error"]) == {"h", "v"}


def test_errors_are_integrals_of_the_difference_to_what_the_model_sees(report):
    scene, row = gr.scene("dam-break-phi"), report.rows[3]
    problem = scene.problem(gr.TwoPhase, 100)
    solution = fv.solve(problem, fv.WavePropagation(fv.Roe()))
    x, dx = problem.grid.centers, problem.grid.dx
    wanted = scene.known_reference().at(x, 0.5)["h"]
    assert row["error"]["h"] == pytest.approx(np.abs(solution.observables()["h"] - wanted).sum() * dx, rel=0.1)
    assert row["error"]["h"] / 10.0 < row["error_l2"]["h"] < row["error_max"]["h"] * 10.0**0.5


def test_model_errors_do_not_fall_with_the_grid_and_the_table_says_so(report):
    assert report.rows[9]["error"]["h"] > 0.8 * report.rows[8]["error"]["h"]
    assert report.rows[1]["error"]["h"] < 0.7 * report.rows[0]["error"]["h"]
    text = report.table()
    assert "reduced*" in text
    assert "model error against the full model" in text
    assert "Verdict: at L1(h) = " in text
    assert "is fastest" in text.replace("\n", " ")


def test_observed_orders_follow_the_errors(report):
    first, second = report.rows[:2]
    assert first["order_observed"]["h"] is None
    assert second["order_observed"]["h"] == pytest.approx(np.log2(first["error"]["h"] / second["error"]["h"]))
    halved = {"cells": 50, "error": {"h": 4e-3}}, {"cells": 100, "error": {"h": 1e-3}}
    assert observed_orders(*halved)["h"] == pytest.approx(2.0)
    assert observed_orders({"cells": 50, "error": {"h": 4e-16}}, {"cells": 100, "error": {"h": 1e-16}})["h"] is None


def test_time_to_reach_interpolates_and_never_extrapolates():
    rows = [{"error": {"h": 1e-1}, "seconds": 1.0}, {"error": {"h": 1e-2}, "seconds": 100.0}]
    assert time_to_reach(rows, "h", 10.0**-1.5) == pytest.approx(10.0)
    assert time_to_reach(rows, "h", 1e-3) is None


def test_files_are_complete_and_valid(report, tmp_path):
    folder = report.save(tmp_path / "new" / "folder")
    document = json.loads((folder / "report.json").read_text())
    assert document["reference"]["kind"] == "semi-exact"
    assert set(KEYS) <= document["rows"][0].keys()
    assert document["machine"]["cores"] >= 1
    assert document["versions"]["numpy"] == np.__version__
    with (folder / "report.csv").open() as file:
        lines = list(csv.DictReader(file))
    assert len(lines) == len(report.rows)
    assert float(lines[1]["error.h"]) == report.rows[1]["error"]["h"]
    pictures = sorted(folder.glob("*.png"))
    assert [path.stem for path in pictures] == ["error_cells", "error_time", "profiles"]
    assert all(path.read_bytes()[:4] == b"\x89PNG" and path.stat().st_size > 10_000 for path in pictures)
    assert not list(folder.glob(".*"))


def test_a_notebook_shows_the_pictures(report):
    for figure in (*report.plot().values(), report.figure("steps", "error.h")):
        assert figure._repr_png_().startswith(b"\x89PNG")


def test_a_failed_run_is_a_row_with_its_status(tmp_path):
    fading = gr.Scene((-1.0, 1.0), 0.05, lambda x: {"h": np.where(x < 0, 1.0, 3.0), "phi": 0.5}, sources=Fading())
    report = gr.compare(fading, [gr.TwoPhase], [fv.Roe()], cells=(40,), repeats=1,
                        reference=gr.FunctionReference("exact", "", at=lambda x, t: {"h": np.ones_like(x), "phi": 0.5}))
    assert report.rows[0]["status"] == "non_finite"
    assert report.rows[0]["error"] == {}
    assert "no run of the full model finished" in report.table()
    assert report.rows[0]["status"] in report.table()
    report.save(tmp_path)


def test_limiters_and_orders_become_series():
    report = gr.compare(gr.scene("simple-wave"), [gr.ShallowWater], [fv.HLL()], (40,), [fv.MC(), fv.Superbee()], [1, 2], repeats=1)
    assert list(report.series()) == [f"shallow-water hll {limiter} order {order}"
                                     for limiter in ("mc", "superbee") for order in (1, 2)]


@pytest.mark.parametrize(("settings", "word"), [({"cells": ()}, "cells"), ({"repeats": 0}, "repeats"), ({"cells": (10.5,)}, "cells"),
                                                ({"order": 3}, "order"), ({"models": [gr.scene]}, "model")])
def test_bad_input_is_refused_by_name(settings, word):
    with pytest.raises((ValueError, TypeError), match=word):
        gr.compare(gr.scene("rest"), **({"repeats": 1, "cells": (20,)} | settings))


@pytest.mark.parametrize(("settings", "message"), [
    ({"scene": "riemann"}, r"`scene` must be an instance of Scene, got 'riemann' \(such as gr.scene\('riemann'\)\)"),
    ({"models": gr.TwoPhase}, r"`models` must be a list such as \[gr.TwoPhase\], got"),
    ({"riemann": fv.HLL()}, r"`riemann` must be a list such as \[fv.HLL\(\)\], got HLL\(\)"),
    ({"schemes": fv.WavePropagation(fv.HLL())}, "`schemes` must be a list"),
    ({"cells": 100}, r"`cells` must be a list such as \[100, 200\], got 100"),
    ({"reference": lambda x, t: {}}, "`reference` must be an instance of Reference"),
])
def test_one_for_a_list_and_other_mistakes_are_named(settings, message):
    with pytest.raises(TypeError, match=message):
        gr.compare(**{"scene": gr.scene("dam-break"), "cells": (10,), "repeats": 1} | settings)


def test_rest_is_kept_to_rounding_and_the_verdict_says_so(tmp_path):
    report = gr.compare(gr.scene("rest"), cells=(50,), repeats=1)
    assert "to rounding" in report.verdict()
    report.save(tmp_path)


@pytest.mark.parametrize(("scene", "model", "solvers"), [("internal-dam-break", gr.TwoLayer, {"relaxation", "roe", "hll", "rusanov"}),
                                                         ("pitman-le", gr.PitmanLe, {"relaxation", "hll", "rusanov"})])
def test_a_relative_is_compared_with_its_own_fine_solution_and_the_solvers_that_serve_it(scene, model, solvers):
    report = gr.compare(gr.scene(scene), [model, gr.ShallowWater], cells=(20, 40), repeats=1, backend="numpy")
    assert report.full_model == public_name(model)
    assert {row["riemann"] for row in report.rows if row["model"] == report.full_model} == solvers
    assert all(row["status"] == "finished" for row in report.rows)
    first = report.rows[:2]
    assert first[1]["error"]["phi"] < 0.8 * first[0]["error"]["phi"]


@pytest.fixture(scope="module")
def methods() -> Report:
    """Both methods side by side on a smooth wave."""
    schemes = [fv.WavePropagation(fv.Roe()), fv.WavePropagation(fv.Roe(), cfl=0.45), fv.MethodOfLines(fv.Roe(), fv.WENO5()),
               fv.MethodOfLines(fv.Roe(), integrator=fv.DP5())]
    return gr.compare(gr.scene("simple-wave"), [gr.TwoPhase], cells=(50, 100, 200), schemes=schemes, repeats=1, backend="numpy")


def test_rows_of_both_methods_name_their_scheme(methods):
    keys = ("scheme", "limiter", "order", "integrator", "options")
    assert [tuple(row[key] for key in keys) for row in methods.rows[::3]] == [
        ("wave-propagation", "mc", 2, None, ""), ("wave-propagation", "mc", 2, None, "cfl=0.45"),
        ("method-of-lines", "weno5", 5, "ssprk104", ""), ("method-of-lines", "mp5", 5, "dp5", "")]
    assert list(methods.series()) == ["two-phase roe mc", "two-phase roe mc cfl=0.45", "two-phase roe weno5 ssprk104",
                                      "two-phase roe mp5 dp5"]
    assert methods.rows[11]["error"]["h"] == pytest.approx(2.5e-6, rel=0.1), "a twentieth of that of mc"
    assert methods.rows[2]["error"]["h"] == pytest.approx(1.37e-4, rel=0.1)


def test_work_precision_is_the_interpolated_time_and_its_winner(methods):
    found = methods.work_precision("h")
    assert found.targets == (1e-3, 1e-4, 1e-5)
    fast = methods.series()["two-phase roe mp5 dp5"]
    assert found.seconds["two-phase roe mp5 dp5"][2] == pytest.approx(time_to_reach(fast, "h", 1e-5))
    assert found.seconds["two-phase roe mc"][1:] == (None, None)
    assert found.fastest[0] == "two-phase roe mc"
    assert found.fastest[2] in ("two-phase roe mp5 dp5", "two-phase roe weno5 ssprk104")
    lines = found.table().splitlines()
    assert lines[0].split() == ["ms", "to", "L1(h)", "=", "1e-03", "1e-04", "1e-05"]
    assert lines[2].split()[-3].startswith("[")
    assert lines[2].split()[-2:] == ["-", "-"]
    assert found.table() in methods.table()
    easy = methods.work_precision("h", [1.0])
    assert easy.easy["two-phase roe mc"] == (True,)
    assert "<" in str(easy)
    assert json.loads(methods.to_json())["work_precision"]["h"]["fastest"] == list(found.fastest)
    with pytest.raises(ValueError, match="did you mean phi"):
        methods.work_precision("phy")


def test_any_column_is_drawn_over_any_other_and_an_unknown_one_is_refused(methods):
    ax = methods.figure("steps", "error_l2.h").axes[0]
    assert (ax.get_xlabel(), ax.get_ylabel(), ax.get_xscale()) == ("steps", "error_l2.h", "log")
    np.testing.assert_array_equal(ax.lines[0].get_xdata(), [row["steps"] for row in methods.rows[:3]])
    assert methods.figure("cells", "rejected").axes[0].get_yscale() == "linear"
    with pytest.raises(ValueError, match=r"`y` must be a known name.*did you mean error\.h\? known: .*error_l2\.h"):
        methods.figure("seconds", "eror.h")


def test_a_scheme_runs_with_the_models_that_it_serves_and_one_that_serves_none_is_refused():
    schemes = [fv.WavePropagation(fv.HLL(), in_cell_shocks=True), fv.WavePropagation(fv.HLL())]
    rows = gr.compare(gr.scene("pitman-le"), [gr.TwoPhase, gr.PitmanLe], cells=(20,), schemes=schemes, repeats=1, backend="numpy").rows
    assert [(row["model"], row["options"]) for row in rows] == [("two-phase", "in_cell_shocks=on"), ("two-phase", ""), ("pitman-le", "")]
    with pytest.raises(ValueError, match="`schemes` serve none of the models"):
        gr.compare(gr.scene("pitman-le"), [gr.PitmanLe], cells=(20,), schemes=schemes[:1], repeats=1, backend="numpy")
    with pytest.raises(ValueError, match="leave `riemann` and `limiter` out"):
        gr.compare(gr.scene("rest"), [gr.PitmanLe], [fv.HLL()], cells=(20,), schemes=schemes, repeats=1)


def test_a_budget_leaves_slow_runs_out_and_the_reference_says_how_fine_it_is(tmp_path):
    schemes = [fv.WavePropagation(fv.HLL()), fv.MethodOfLines(fv.HLL())]
    scene = attrs.evolve(gr.scene("perturbed-rest"), t_end=0.1)
    report = gr.compare(scene, [gr.TwoPhase], cells=(10, 20, 40_960), schemes=schemes, repeats=1, backend="numpy", seconds=0.3)
    assert [row["status"] for row in report.rows] == ["finished", "finished", "over_budget"] * 2
    assert report.rows[2]["error"] == {}
    assert report.rows[2]["backend"] == "numpy"
    assert "over_budget" in report.table()
    assert "N = 163840 would take more than the 4.8 s of the reference" in report.reference["detail"]
    assert "by Richardson" in report.reference["detail"]
    assert "method-of-lines" in report.reference["detail"]
    report.save(tmp_path)


def test_the_reference_estimates_its_own_error():
    scene = gr.Scene((0.0, 1.0), 0.05, lambda x: {"h": 1.0 + 0.1 * np.sin(2 * np.pi * x), "phi": 0.5}, boundary=fv.Periodic())
    report = gr.compare(scene, [gr.TwoPhase], [fv.HLL()], (20, 40), repeats=1, backend="numpy")
    words = report.reference["detail"].split()
    claimed = float(words[words.index("about") + 1])
    finer = gr.compare(scene, [gr.TwoPhase], [fv.HLL()], (160, 320), repeats=1, backend="numpy").rows[0]
    assert claimed == pytest.approx(finer["error"]["h"], rel=0.5), "HLL with as many cells as that reference"
