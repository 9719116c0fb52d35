"""The benchmark: every case is measured, the files are whole, the ratio to PyClaw is computed from rows of one run."""

import json

import pytest

from fvkit_granular.studies.bench import Bench, bench

MACHINE = {"processor": "p", "cores": 2, "system": "s"}


def test_every_model_solver_and_order_is_measured(tmp_path, monkeypatch):
    monkeypatch.setattr("fvkit_granular.studies.bench.BLOCK", 1e-4)
    monkeypatch.setattr("fvkit_granular.studies.bench.find_spec", lambda name: None)
    lines: list[str] = []
    result = bench((20, 40), (1, 2), ("numpy",), repeats=2, progress=lines.append)
    assert len(result.rows) == 2 * 3 * 4 * 2
    assert all(0.0 < row["ns_per_cell_step_min"] <= row["ns_per_cell_step"] for row in result.rows)
    assert any("measuring" in line for line in lines)
    folder = result.save(tmp_path / "out")
    assert len(json.loads((folder / "bench.json").read_text())["rows"]) == 48
    assert (folder / "bench.png").read_bytes()[:4] == b"\x89PNG"
    assert "two-phase roe, order 2, numpy" in result.table()


def test_the_ratio_to_pyclaw_is_that_of_the_medians():
    common = {"model": "shallow-water", "order": 2, "cells": 1000, "steps": 1}
    rows = [{**common, "riemann": "roe", "backend": "numba", "ns_per_cell_step": 5.0, "ns_per_cell_step_min": 4.0},
            {**common, "riemann": "f-wave", "backend": "pyclaw", "ns_per_cell_step": 110.0, "ns_per_cell_step_min": 100.0}]
    assert Bench(rows, MACHINE, {}).ratios() == ["PyClaw (f-wave, order 2) over our compiled Roe: 22.0 at 1000 cells"]
    assert Bench(rows[:1], MACHINE, {}).ratios() == []


@pytest.mark.filterwarnings("ignore")  # PyClaw's own
def test_pyclaw_runs_where_it_is_installed(monkeypatch, tmp_path):
    pytest.importorskip("clawpack", reason="PyClaw is not installed", exc_type=ImportError)
    monkeypatch.chdir(tmp_path)
    from fvkit_granular.studies.bench import bottom
    from fvkit_granular.studies.bench_pyclaw import pyclaw_runs

    for run in pyclaw_runs(100, (2,), bottom).values():
        assert run(3) > 0.0


def test_a_stage_of_fifth_order_is_compared_with_a_second_order_step():
    result = bench([40], [2, 5], ["numpy"], repeats=1)
    assert {row["order"] for row in result.rows} >= {2, 5}
    assert "a stage over a second-order Roe step" in result.table()


def test_two_axes_stand_in_a_table_and_a_panel_of_their_own(monkeypatch):
    monkeypatch.setattr("fvkit_granular.studies.bench.BLOCK", 1e-4)
    monkeypatch.setattr("fvkit_granular.studies.bench.find_spec", lambda name: None)
    result = bench([20], [2, 5], ["numpy"], repeats=1, plane=[12])
    rows = [row for row in result.rows if row["axes"] == 2]
    assert [(row["model"], row["riemann"], row["order"], row["cells"]) for row in rows] == [
        ("shallow-water", "roe", 2, 144), ("two-phase", "relaxation", 2, 144)]
    lines = result.table().splitlines()
    assert sum("N = 20" in line for line in lines) == sum("N = 12 x 12" in line for line in lines) == 1
    assert [ax.get_title() for ax in result.plot().axes] == ["two-phase", "reduced", "shallow-water", "shallow-water, two axes", "two-phase, two axes"]


def test_the_ratio_to_pyclaw_with_two_axes_is_that_to_our_two_axes():
    common = {"model": "shallow-water", "riemann": "roe", "order": 2, "cells": 90_000, "steps": 1}
    rows = [{**common, "backend": backend, "axes": axes, "ns_per_cell_step": time, "ns_per_cell_step_min": time}
            for backend, axes, time in (("numba", 1, 5.0), ("numba", 2, 20.0), ("pyclaw", 2, 200.0))]
    assert Bench(rows, MACHINE, {}).ratios() == ["PyClaw (roe, order 2) over our compiled Roe: 10.0 at 300 x 300 cells"]


@pytest.mark.filterwarnings("ignore")  # PyClaw's own
def test_pyclaw_runs_in_the_plane_where_it_is_installed(monkeypatch, tmp_path):
    pytest.importorskip("clawpack", reason="PyClaw is not installed", exc_type=ImportError)
    monkeypatch.chdir(tmp_path)
    from fvkit_granular.studies.bench_pyclaw import pyclaw_runs_in_the_plane

    for run in pyclaw_runs_in_the_plane(20, (1, 2)).values():
        assert run(3) > 0.0


def test_an_order_that_cannot_be_measured_is_named():
    with pytest.raises(ValueError, match=r"`orders`.*4"):
        bench([40], [4])
