"""What a run along one axis records: gauges, discharge, front, largest values; from a scene file, options and Python."""

import csv

import numpy as np
import pytest

import fvkit as fv
import fvkit_granular as gr
from fvkit.cli import main

SCENE = """
interval = [0.0, 100.0]
t_end = 20.0
bottom = {shape = "plane", slope = -0.02}
initial = {h = {shape = "block", centre = 20.0, half_width = 10.0, height = 2.0}, phi = 0.4}
sources = [{type = "manning", n = 0.03}]
outputs = {count = 2, gauges = [40.0, 99.0], threshold = 0.05, lines = {middle = 50.5, end = 100.0}}
"""


@pytest.fixture
def place(tmp_path, monkeypatch):
    (tmp_path / "channel.toml").write_text(SCENE)
    monkeypatch.chdir(tmp_path)
    return tmp_path


def table(path):
    """A CSV file as {column: values}; what is empty is NaN."""
    with open(path, newline="") as file:
        header, *rows = csv.reader(file)
    return {name: np.array([float(row[k] or "nan") for row in rows]) for k, name in enumerate(header)}


def run(*words):
    return main(["run", "channel.toml", "--cells", "100", "--backend", "numpy", *words])


def test_a_scene_file_records_gauges_front_and_largest_values(place, capsys):
    assert run() == 0
    said, folder = capsys.readouterr().out, place / "fvkit-run-channel-two-phase-relaxation"
    scene = gr.load_scene("channel.toml")
    gauge, front, largest = fv.Gauge([40.0, 99.0]), gr.Front(0.05), fv.Extremes()
    problem = scene.problem(gr.TwoPhase, 100)
    solution = fv.solve(problem, times=scene.times, observers=[gauge, front, largest], backend="numpy")
    series, ends, maxima = (table(folder / f"{name}.csv") for name in ("gauges", "front", "maxima"))
    assert np.array_equal(series["h at 40"], gauge.values["h"][:, 0])
    assert np.array_equal(series["surface at 99"], gauge.values["surface"][:, 1])
    assert np.array_equal(ends["right"], front.right)
    assert np.array_equal(maxima["depth [m]"], largest.largest["h"])
    assert np.array_equal(maxima["bottom [m]"], solution.aux["b"])
    deep = gauge.values["h"] >= 0.05
    arrival = gauge.t[deep.argmax(axis=0)]
    assert 0.0 < arrival[0] < arrival[1] < 20.0
    assert maxima["arrival [s]"][[40, 99]].tolist() == arrival.tolist()
    for x, when in zip((40, 99), arrival, strict=True):
        assert f"at x = {x} m first deeper than 0.05 m at t = {when:.6g} s" in said
    assert f"largest depth {largest.largest['h'].max():.4g} m at x = " in said
    assert f"in through the right: hs {solution.stats.entered['right']['hs']:.6g}, hf " in said


def test_a_threshold_needs_no_gauges(place, capsys):
    (place / "channel.toml").write_text(SCENE.replace("gauges = [40.0, 99.0], ", ""))
    assert run() == 0
    assert "deeper than 0.05 m from x = " in capsys.readouterr().out


def test_discharge_through_the_end_is_what_left(place):
    assert run() == 0
    end = table(place / "fvkit-run-channel-two-phase-relaxation" / "line-end.csv")
    solution = fv.load(place / "fvkit-run-channel-two-phase-relaxation" / "solution.npz")
    seen, left = solution.observables(), -solution.stats.entered["right"]["hs"]
    assert end["discharge hs"][-1] == pytest.approx(seen["phi"][-1] * seen["h"][-1] * seen["vs"][-1], rel=1e-12)
    assert left > 0.5
    assert end["volume hs"][-1] == pytest.approx(left, rel=0.05)  # a cell and a step beside the face


def test_a_cross_section_of_one_axis_is_exact_in_uniform_flow():
    river = fv.Problem(gr.ShallowWater(), fv.Grid(0.0, 10.0, 20), lambda x: [1.0 + 0.0 * x, 2.0 + 0.0 * x], 0.5, aux={"b": 0.0})
    here = fv.CrossSection(5.0)
    fv.solve(river, backend="numpy", observers=here)
    assert here.discharge["h"] == pytest.approx(2.0, rel=1e-13)
    assert here.volume["h"][-1] == pytest.approx(1.0, rel=1e-13)


@pytest.mark.parametrize(("line", "words"), [(11.0, r"must be within \[0, 10\], got 11"), ([(1.0, 1.0), (2.0, 2.0)], "a number x on a grid with one axis")])
def test_a_cross_section_refuses_what_is_no_place_of_one_axis(line, words):
    river = fv.Problem(gr.ShallowWater(), fv.Grid(0.0, 10.0, 20), lambda x: [1.0 + 0.0 * x, 2.0 + 0.0 * x], 0.5, aux={"b": 0.0})
    with pytest.raises(ValueError, match=words):
        fv.solve(river, backend="numpy", observers=fv.CrossSection(line))


def test_options_record_in_place_of_the_scene_and_a_run_goes_on_with_them(place, capsys):
    words = ("--gauges", "30", "60", "--threshold", "0.2")
    assert run(*words, "--out", "whole", "--checkpoint", "run.npz") == 0
    assert "fvkit run channel.toml --gauges 30.0 60.0 --threshold 0.2 --resume run.npz" in capsys.readouterr().out
    assert main(["run", "channel.toml", *words, "--resume", "run.npz", "--out", "again", "--backend", "numpy"]) == 0
    for name in ("gauges.csv", "front.csv", "maxima.csv"):
        assert (place / "whole" / name).read_bytes() == (place / "again" / name).read_bytes()
    assert "h at 30" in table(place / "whole" / "gauges.csv")


def test_a_name_with_blanks_is_quoted_in_what_goes_on(place, capsys):
    (place / "my channel.toml").write_text(SCENE)
    assert main(["run", "my channel.toml", "--cells", "20", "--backend", "numpy", "--checkpoint", "my run.npz"]) == 0
    assert "fvkit run 'my channel.toml' --resume 'my run.npz'" in capsys.readouterr().out
    assert (place / "fvkit-run-my channel-two-phase-relaxation" / "run.txt").exists()


def test_a_later_run_that_records_nothing_leaves_no_series_of_this_one(place):
    assert run("--out", "here") == 0
    (place / "channel.toml").write_text(SCENE.rsplit("outputs", 1)[0])
    assert run("--out", "here") == 0
    assert {path.name for path in (place / "here").iterdir()} == {"solution.npz", "run.txt", "profile.png"}


@pytest.mark.parametrize(("outputs", "words"), [
    ("{density = 1000.0}", "`density` is for scenes with two axes"), ("{least = 0.1}", "with a `threshold`: give that"),
    ("{lines = {a = [[0.0, 1.0], [2.0, 1.0]]}}", "`lines`, a must be a place x in one with one axis"),
    ("{lines = {a = 101.0}}", "must lie within the scene, x from 0 to 100 m, got x = 101"), ("{threshold = -1.0}", "`threshold`")])
def test_what_has_no_effect_along_one_axis_is_refused(place, capsys, outputs, words):
    (place / "channel.toml").write_text(SCENE.rsplit("outputs", 1)[0] + f"outputs = {outputs}\n")
    assert run() == 2
    said = capsys.readouterr()
    assert words in said.err
    assert said.out == ""
    assert [path.name for path in place.iterdir()] == ["channel.toml"]


@pytest.mark.parametrize(("words", "message"), [
    (("--gauges", "1,2"), "must have 1 coordinate for each place"), (("--gauges", "101"), "`--gauges` must lie within the scene"),
    (("--gauges", "nan"), "`--gauges` must be places x"), (("--threshold", "0"), "`--threshold` must be finite and > 0")])
def test_options_that_are_mistakes(place, capsys, words, message):
    assert run(*words) == 2
    assert message in capsys.readouterr().err


def test_a_plane_has_no_front():
    assert main(["run", "vortex", "--threshold", "0.1", "--cells", "10"]) == 2


def test_the_text_of_a_scene_keeps_what_it_records(place):
    scene = gr.load_scene("channel.toml")
    (place / "again.toml").write_text(gr.scene_text(scene))
    assert gr.load_scene("again.toml").watch == scene.watch


# -- files of a run --------------------------------------------------------------------------------------------------------

HEADS = {"png": b"\x89PNG", "pdf": b"%PDF", "svg": b"<?xml"}


@pytest.mark.parametrize("kind", HEADS)
def test_pictures_are_of_the_format_that_is_asked_for_and_those_of_another_go(place, kind):
    assert run("--out", "here", "--plot", "depth", "--format", "svg" if kind == "pdf" else "pdf") == 0
    assert run("--out", "here", "--format", kind) == 0
    pictures = [path for path in (place / "here").iterdir() if path.suffix[1:] in HEADS]
    assert [path.name for path in pictures] == [f"profile.{kind}"]
    assert pictures[0].read_bytes().startswith(HEADS[kind])


@pytest.mark.parametrize("kind", HEADS)
def test_a_comparison_draws_in_the_format_that_is_asked_for(place, kind):
    words = ["compare", "riemann", "--models", "shallow-water", "--riemann", "hll", "--cells", "10", "20", "--repeats", "1",
             "--backend", "numpy", "--out", "here", "--plot-axes", "steps", "error.h"]
    for one in ("pdf" if kind == "svg" else "svg", kind):
        assert main([*words, "--format", one]) == 0
    pictures = {path.name: path for path in (place / "here").iterdir() if path.suffix[1:] in HEADS}
    assert set(pictures) == {f"{name}.{kind}" for name in ("error_time", "error_cells", "profiles", "error.h-over-steps")}
    assert all(path.read_bytes().startswith(HEADS[kind]) for path in pictures.values())


def test_a_report_refuses_another_format(place):
    report = gr.compare(gr.scene("riemann"), [gr.ShallowWater], cells=[10, 20], riemann=[fv.HLL()], repeats=1, backend="numpy")
    with pytest.raises(ValueError, match="`picture` must be one of png, pdf, svg"):
        report.save("here", "bmp")
    assert not (place / "here").exists()


def test_the_solution_goes_where_save_says_too(place, capsys):
    pytest.importorskip("h5netcdf")
    assert run("--save", "far/x.nc") == 0
    here = fv.load(place / "fvkit-run-channel-two-phase-relaxation" / "solution.npz")
    assert np.array_equal(fv.load(place / "far" / "x.nc").q, here.q)
    assert "far/x.nc" in capsys.readouterr().out


def test_the_folder_says_what_was_run_under_the_name_of_the_scene(place, capsys):
    (place / "channel.toml").write_text('name = "Mühlbach, 2 km"\n' + SCENE)
    assert run("--model", "reduced", "--riemann", "hll") == 0
    said = (place / "fvkit-run-channel-reduced-hll" / "run.txt").read_text(encoding="utf-8")
    assert said.startswith("Mühlbach, 2 km: reduced, hll, order 2, 100 cells, numpy\n")
    assert capsys.readouterr().out.startswith(said)
    kept = fv.load(place / "fvkit-run-channel-reduced-hll" / "solution.npz")
    assert (kept.configuration["scene"], type(kept.model)) == ("Mühlbach, 2 km", gr.Reduced)


@pytest.mark.filterwarnings("ignore:SSPRK3 alternates")
@pytest.mark.parametrize(("words", "folder"), [
    ((), "two-phase-relaxation"), (("--riemann", "roe"), "two-phase-roe"), (("--model", "shallow-water"), "shallow-water-relaxation"),
    (("--order", "1"), "two-phase-relaxation-order-1"), (("--limiter", "superbee"), "two-phase-relaxation-superbee"),
    (("--reconstruction", "muscl", "--integrator", "ssprk3"), "two-phase-relaxation-muscl-ssprk3"),
])
def test_runs_with_another_model_or_solver_have_a_folder_of_their_own(words, folder, place, capsys):
    assert run("--checkpoint", "c.npz", *words) == 0
    assert [path.name for path in place.glob("fvkit-run-*")] == [f"fvkit-run-channel-{folder}"]
    assert main(["run", "channel.toml", "--resume", "c.npz", "--backend", "numpy"]) == 0
    assert f"written to fvkit-run-channel-{folder}/" in capsys.readouterr().out
