"""What commands write, and where: paths are tried before the computation, and no file of an earlier run passes for one of this."""

import attrs
import numpy as np
import pytest

import fvkit as fv
import fvkit_granular as gr
from fvkit.cli import MISTAKE, SUCCESS, main
from fvkit.problem.teaching_models import Burgers

RUN = ["run", "riemann", "--cells", "20"]
COMPARE = ["compare", "riemann", "--models", "two-phase", "--riemann", "hll", "--cells", "10", "20", "--repeats", "1"]
SWEEP = 'scene = "riemann"\nmembers = 2\ncells = 20\n[parameters]\ng = [9.0, 10.0]\n'


def names(folder):
    return {str(path.relative_to(folder)) for path in folder.rglob("*") if path.is_file()}


@pytest.fixture(autouse=True)
def here(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "s.toml").write_text(SWEEP)
    return tmp_path


@pytest.mark.parametrize(("command", "more"), [
    (RUN, ["--plot", "speeds", "slip", "space-time", "--animate", "film.gif"]), (RUN, ["--animate", "films/a.gif"]),
    (COMPARE, ["--plot-axes", "steps", "error.h", "--plot-axes", "cells", "seconds"]), (["sweep", "s.toml", "--workers", "1"], []),
    (["convergence", "riemann", "--cells", "10", "20"], []),
    (["bench", "--cells", "10", "--plane", "--orders", "1", "--backends", "numpy", "--repeats", "1"], [])])
def test_a_second_run_leaves_no_picture_of_the_first_and_all_files_of_the_user(command, more, here, monkeypatch, capsys):
    monkeypatch.setattr("fvkit_granular.studies.bench.BLOCK", 1e-6)
    monkeypatch.setattr("fvkit_granular.cli.run.FRAMES", 3)
    out = here / "out"
    assert main([*command, "--out", str(out / "fresh")]) == SUCCESS
    assert main([*command, *more, "--out", str(out)]) == SUCCESS
    own = ["notes.txt", "mine.png", "a-over-b.png", "film2.gif"]
    for name in own:
        (out / name).write_text("mine")
    capsys.readouterr()
    assert main([*command, "--out", str(out)]) == SUCCESS
    said = capsys.readouterr().out
    assert not any(name in said for name in own), "a file of the user is said to be written"
    assert {name for name in names(out) if not name.startswith("fresh")} == names(out / "fresh") | set(own)


@pytest.mark.parametrize("listed", [["../kept.png"], ["notes.txt"], [3], "kept.png", None])
def test_only_pictures_in_the_folder_are_removed_whatever_a_file_says(listed, here):
    out = here / "out"
    assert main([*RUN, "--out", str(out)]) == SUCCESS
    solution = fv.load(out / "solution.npz")
    attrs.evolve(solution, configuration=solution.configuration | {"files": listed}).save(out / "solution.npz")
    for path in (here / "kept.png", out / "notes.txt"):
        path.write_text("mine")
    assert main([*RUN, "--out", str(out)]) == SUCCESS
    assert (here / "kept.png").exists()
    assert (out / "notes.txt").exists()


def test_a_damaged_solution_of_an_earlier_run_is_replaced(here):
    (here / "out").mkdir()
    (here / "out" / "solution.npz").write_text("no archive")
    assert main([*RUN, "--out", "out"]) == SUCCESS


def interrupted(stepper):
    raise KeyboardInterrupt


@pytest.mark.parametrize("fails", [lambda _: 1 / 0, interrupted])
def test_a_run_that_does_not_succeed_keeps_the_result_of_one_that_did(fails, here, monkeypatch, capsys):
    out, solve = here / "out", fv.solve
    bad = ("fvkit_granular.cli.run.solve", lambda *given, **options: solve(*given, **{**options, "observers": [fails]}))

    def contents():
        return {path.name: path.read_bytes() for path in out.iterdir() if path.is_file()}

    with monkeypatch.context() as patched:
        patched.setattr(*bad)
        for _ in range(2):  # with no good result there, its own take the place of those of the run before
            assert main([*RUN, "--out", str(out)]) not in (SUCCESS, MISTAKE)
            assert names(out) == {"solution.npz", "run.txt", "profile.png"}
    assert main([*RUN, "--out", str(out), "--plot", "slip"]) == SUCCESS
    good = contents()
    monkeypatch.setattr(*bad)
    capsys.readouterr()
    for _ in range(2):
        assert main([*RUN, "--out", str(out)]) not in (SUCCESS, MISTAKE)
        assert contents() == good
        said = capsys.readouterr().out
        assert f"written to {out}/unsuccessful/: solution.npz, run.txt, profile.png; {out}/ keeps the result of an earlier run" in said
        assert not fv.load(out / "unsuccessful" / "solution.npz").success
    monkeypatch.setattr("fvkit_granular.cli.run.solve", solve)
    assert main([*RUN, "--out", str(out)]) == SUCCESS
    assert names(out) == {"solution.npz", "run.txt", "profile.png", "unsuccessful/solution.npz", "unsuccessful/run.txt",
                          "unsuccessful/profile.png"}


def test_a_film_makes_its_folder(here, monkeypatch):
    monkeypatch.setattr("fvkit_granular.cli.run.FRAMES", 3)
    assert main([*RUN, "--out", "out", "--animate", "a/b/c.gif"]) == SUCCESS
    assert (here / "out" / "a" / "b" / "c.gif").exists()


@pytest.mark.parametrize(("command", "folders", "said"), [
    ([*RUN, "--out", "out", "--animate", "file/a.gif"], ["out"], "`--animate`"), ([*RUN, "--out", "out"], ["out/solution.npz"], "solution.npz"),
    ([*RUN, "--out", "out", "--plot", "speeds"], ["out/speeds.png"], "speeds.png"),
    ([*RUN, "--out", "out", "--animate", "a.gif"], ["out/a.gif"], "a.gif"), ([*RUN, "--animate", "a.avi"], [], "must end in .gif"),
    ([*RUN, "--checkpoint", "missing/c.npz"], [], "checkpoint must be in a folder that exists"), ([*COMPARE, "--out", "out"], ["out/report.csv"], "report.csv"),
    ([*COMPARE, "--out", "out"], ["out/profiles.png"], "profiles.png"),
    ([*COMPARE, "--out", "out", "--plot-axes", "steps", "error.h"], ["out/error.h-over-steps.png"], "error.h-over-steps.png"),
    ([*COMPARE, "--plot-axes", "steps", "error.pressure"], [], "--plot-axes"), ([*COMPARE, "--plot-axes", "steps", "error"], [], "--plot-axes"),
    (["convergence", "riemann", "--out", "out"], ["out/convergence.png"], "convergence.png"),
    (["sweep", "s.toml", "--out", "out"], ["out/sweep.csv"], "sweep.csv"), (["bench", "--out", "out"], ["out/bench.json"], "bench.json"),
    (["stress", "--out", "out"], ["out/stress.txt"], "stress.txt"),
    *[([*command, "--out", "file"], [], "`--out` must be a folder") for command in
      (RUN, COMPARE, ["convergence", "riemann"], ["sweep", "s.toml"], ["bench"], ["stress"])]])
def test_every_path_is_tried_before_the_computation(command, folders, said, here, monkeypatch, capsys):
    for name in folders:
        (here / name).mkdir(parents=True)
    (here / "file").write_text("mine")
    (here / "out").mkdir(exist_ok=True)
    (here / "out" / "file").write_text("mine")

    def computed(*_, **__):
        raise AssertionError("a computation began")

    for name in ("run.solve", "compare.compare", "bench.bench", "convergence.convergence", "sweep.sweep", "stress.stress"):
        monkeypatch.setattr(f"fvkit_granular.cli.{name}", computed)
    assert main(command) == MISTAKE
    error = capsys.readouterr().err
    assert said in error
    assert len(error.strip().splitlines()) == 1


@pytest.mark.parametrize(("options", "names"), [
    (["--limiter", "mc", "--reconstruction", "mp5"], ["--limiter", "--reconstruction"]),
    (["--order", "1", "--integrator", "dp5"], ["--order", "--integrator"]),
    (["--limiter", "minmod", "--integrator", "ssprk3"], ["--limiter", "--integrator"])])
@pytest.mark.parametrize("command", [RUN, ["convergence", "riemann"]])
def test_options_of_both_methods_are_one_sentence(command, options, names, capsys):
    assert main([*command, *options]) == MISTAKE
    error = capsys.readouterr().err
    assert all(f"`{name}`" in error for name in names)
    assert "leave one of them out" in error


@pytest.mark.parametrize("scheme", ['{limiter = "mc", reconstruction = "mp5"}', '{limiter = ["mc", "minmod"]}',
                                    '{method = ["wave-propagation", "method-of-lines"]}'])
def test_a_sweep_takes_one_scheme(scheme, here, capsys):
    (here / "s.toml").write_text(SWEEP.replace("[parameters]", f"scheme = {scheme}\n[parameters]"))
    assert main(["sweep", "s.toml"]) == MISTAKE
    assert len(capsys.readouterr().err.strip().splitlines()) == 1


class Bottomless(gr.ShallowWater):
    aux = ()


def test_a_model_without_a_bottom_runs_flat_scenes_and_refuses_others():
    flat = gr.Scene((0.0, 1.0), 0.1, lambda x: {"h": 1.0 + 0.1 * x, "phi": 0.5})
    for bottom in (lambda x: 0.1 * x, 0.5, np.full(10, 0.1)):
        with pytest.raises(ValueError, match="`bottom` of the scene is not flat, but Bottomless has no `b` in its `aux`"):
            attrs.evolve(flat, bottom=bottom).problem(Bottomless, 10)
    for scene in (flat, gr.scene("rest")):
        with pytest.raises(ValueError, match=r"Burgers has no `conserved_from`"):
            scene.problem(Burgers, 10)
    with pytest.raises(ValueError, match="`aux` must be empty, got 'b': Burgers has no `aux`"):
        fv.Problem(Burgers(), fv.Grid(0.0, 1.0, 10), lambda x: x[None], 1.0, aux={"b": 0.0})
