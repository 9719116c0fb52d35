"""Comparisons of models and schemes on scenes with two axes: errors, references, reports and pictures, budgets."""

import json

import attrs
import numpy as np
import pytest

import fvkit as fv
import fvkit_granular as gr
from fvkit.cli import MISTAKE, SUCCESS, main
from fvkit.studies.cost import predicted
from tests.cases import solve


@pytest.fixture(scope="module")
def report():
    return gr.compare(gr.scene("two-phase-vortex"), riemann=[gr.Relaxation(), fv.HLL()], cells=(10, 20), repeats=1, backend="numpy")


def test_errors_are_integrals_over_the_plane(report):
    assert report.reference["kind"] == "exact"
    assert [row["status"] for row in report.rows] == ["finished"] * 12
    scene = gr.scene("two-phase-vortex")
    row = next(row for row in report.rows if (row["model"], row["riemann"], row["cells"]) == ("two-phase", "hll", 20))
    solution = solve(scene.problem(gr.TwoPhase, 20), fv.WavePropagation(fv.HLL()), nonhyperbolic="ignore")
    q = scene.known_reference().averages(solution.model, solution.grid, scene.t_end)
    difference = np.abs(solution.q[-1, 0] + solution.q[-1, 3] - q[0] - q[3])
    assert row["error"]["h"] == pytest.approx(0.36 * difference.sum(), rel=1e-12)
    assert row["error_l2"]["h"] == pytest.approx(0.6 * np.sqrt((difference**2).sum()), rel=1e-12)
    assert row["error_max"]["h"] == pytest.approx(difference.max(), rel=1e-12)
    assert set(row["error"]) == {"h", "phi", "vs_x", "vs_y", "vf_x", "vf_y", "v_x", "v_y"}
    assert set(row["mass_drift"]) == {"hs", "hf"}
    assert row["order_observed"]["h"] > 1.5


def test_deviations_of_cheaper_models_are_seen(report):
    finest = {row["model"]: row["error"]["h"] for row in report.rows if row["cells"] == 20 and row["riemann"] == "hll"}
    assert finest["shallow-water"] > 1.5 * finest["two-phase"]
    assert "* reduced, shallow-water: the error is a model error" in report.table()
    assert "L1 = integral of |error| over x and y, cells = those along x" in report.table()


def test_a_report_has_the_same_json_as_on_a_line_and_a_picture_more(report, tmp_path):
    line = gr.compare(gr.scene("dam-break"), cells=(10,), repeats=1, backend="numpy")
    documents = [json.loads(one.to_json()) for one in (report, line)]
    assert documents[0].keys() == documents[1].keys()
    assert documents[0]["rows"][0].keys() == documents[1]["rows"][0].keys()
    assert set(report.plot()) - set(line.plot()) == {"maps"}
    report.save(tmp_path)
    assert {path.name for path in tmp_path.iterdir()} == {"report.json", "report.csv", "error_time.png", "error_cells.png", "profiles.png", "maps.png"}


def test_maps_show_what_each_series_has_more_or_less_than_the_reference(report):
    figure = report.plot()["maps"]
    shown = [(ax.get_title(), ax.collections[0]) for ax in figure.axes if ax.collections and ax.get_title()]
    assert [title for title, _ in shown] == ["reference: h", *report.series()]
    profiles = report.profiles
    wanted = profiles["reference"].observables["h"]
    assert np.array_equal(np.ravel(shown[0][1].get_array()), wanted.ravel())
    for title, mesh in shown[1:]:
        assert np.allclose(np.ravel(mesh.get_array()), (profiles[title].observables["h"] - wanted).ravel(), rtol=0.0, atol=1e-15)
        assert mesh.get_clim() == shown[1][1].get_clim()
        assert mesh.get_clim()[0] == -mesh.get_clim()[1]
    cut = next(ax for ax in report.plot()["profiles"].axes if ax.get_ylabel() == "h")
    assert cut.get_xlabel() == "x, at y = 0.3"
    assert np.array_equal(cut.lines[0].get_ydata(), wanted[10])


def collapse(**options):
    return gr.Scene(((-2.0, -1.0), (2.0, 1.0)), 0.1, lambda x, y: {"h": 1.0 + np.exp(-4.0 * (x * x + y * y)), "phi": 0.5}, **options)


def test_a_reference_of_its_own_is_the_full_model_on_a_finer_grid():
    found = gr.compare(collapse(), [gr.ShallowWater], cells=(5, 10), repeats=1, backend="numpy")
    assert found.reference["kind"] == "self-converged"
    assert "N = 40 x 20; own L1 error of h about" in found.reference["detail"]
    assert found.full_model == "two-phase"
    fine = solve(collapse().problem(gr.TwoPhase, 40), fv.WavePropagation(fv.Roe()))
    blocks = fine.observables()["h"].reshape(5, 4, 10, 4).mean(axis=(1, 3))
    assert np.allclose(found.profiles["reference"].observables["h"], blocks, rtol=0.0, atol=1e-14)


def test_a_self_converged_reference_averages_exactly_onto_any_grid():
    fine = solve(collapse().problem(gr.TwoPhase, (24, 12)))
    reference = gr.SelfConverged("self-converged", "", solution=fine)
    for cells in ((7, 5), (24, 12), (12, 12)):
        averages = reference.averages(gr.TwoPhase(), collapse().grid(cells), 0.1)
        assert averages.shape == (6, cells[1], cells[0])
        assert averages.mean(axis=(1, 2)) == pytest.approx(fine.q[-1].mean(axis=(1, 2)), abs=1e-14)
    assert np.abs(reference.averages(gr.TwoPhase(), fine.grid, 0.1) - fine.q[-1]).max() < 1e-13
    assert reference.averages(gr.ShallowWater(), fine.grid, 0.1).shape == (3, 12, 24)


def test_a_budget_leaves_out_what_takes_too_long(monkeypatch):
    assert predicted(40, [(20, 1.0)], axes=2) == 4.0
    assert predicted(40, [(20, 8.0), (10, 1.0)], axes=2) == pytest.approx(64.0)
    asked = []

    def expected(cells, done, axes):
        asked.append((cells, len(done), axes))
        return 1e9 if cells == 12 else 0.0

    monkeypatch.setattr("fvkit.studies.compare.predicted", expected)
    found = gr.compare(gr.scene("vortex"), [gr.ShallowWater], [fv.HLL()], cells=(4, 8, 12), repeats=1, backend="numpy", seconds=1e3)
    assert [row["status"] for row in found.rows] == ["finished", "finished", "over_budget"]
    assert asked == [(8, 1, 2), (12, 2, 2)]


@pytest.mark.parametrize(("options", "words"), [
    ({"models": [gr.ShallowWater, gr.PitmanLe]}, "PitmanLe serves one axis alone, got a grid with 2"),
    ({"schemes": [fv.MethodOfLines(fv.Roe())]}, "`schemes` serve none of the models: MethodOfLines serves a grid with one axis"),
    ({"cells": [(10, 10)]}, "`cells` must be a whole number"), ({"cells": []}, "`cells` must not be empty")])
def test_what_serves_one_axis_is_refused_before_any_run(options, words, monkeypatch):
    def refused(*arguments, **more):
        raise RuntimeError("a run began")

    monkeypatch.setattr("fvkit.studies.compare.solve", refused)
    monkeypatch.setattr("fvkit.studies.fine_grid_reference.solve", refused)
    with pytest.raises((ValueError, TypeError), match=words):
        gr.compare(attrs.evolve(collapse()), **{"cells": (5,), "backend": "numpy"} | options)


def test_the_command_writes_maps_and_any_columns(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    given = ["compare", "vortex", "--models", "shallow-water", "--riemann", "hll", "--cells", "6", "12", "--repeats", "1", "--backend", "numpy"]
    assert main([*given, "--plot-axes", "steps", "error.v_y", "--out", "out"]) == SUCCESS
    assert "written to out/: report.json, report.csv, error_time.png, error_cells.png, profiles.png, maps.png, error.v_y-over-steps.png" in \
        capsys.readouterr().out.replace("\n", " ")
    assert main([*given, "--plot-axes", "steps", "error.v"]) == MISTAKE
    assert "error.v_x" in capsys.readouterr().err
