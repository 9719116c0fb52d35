"""Commands on scenes with two axes: files and pictures of a run, checkpoints, what is refused before anything is computed."""

import numpy as np
import pytest
from PIL import Image

import fvkit as fv
import fvkit_granular as gr
from fvkit.cli import MISTAKE, SUCCESS, main
from tests.cases import solve

RUN = ("run", "vortex", "--cells", "12", "--backend", "numpy", "--model", "shallow-water")


@pytest.fixture(autouse=True)
def folder(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    return tmp_path


def mistake(capsys, *words):
    """What a command says that must not run."""
    assert main(list(words)) == MISTAKE
    return capsys.readouterr().err


def test_a_run_writes_its_solution_and_three_pictures(folder, capsys):
    assert main([*RUN, "--out", "out", "--line", "-0.5", "-0.5", "0.5", "0.5"]) == SUCCESS
    said = capsys.readouterr().out
    assert "12 x 12 cells" in said
    assert sorted(path.name for path in (folder / "out").iterdir()) == ["cut.png", "map.png", "solution.npz", "vectors.png"]
    solution, scene = fv.load("out/solution.npz"), gr.scene("vortex")
    wanted = scene.known_reference().averages(solution.model, solution.grid, scene.t_end)
    error = np.abs(solution.q[-1, 0] - wanted[0]).sum() / 144.0
    assert f"L1 error h {error:.3e}" in said
    assert "speed" not in said
    assert np.array_equal(solution.q[-1], solve(scene.problem(gr.ShallowWater, 12)).q[-1])


def test_cells_may_be_a_pair(capsys):
    assert main(["run", "vortex", "--cells", "12x8", "--backend", "numpy", "--out", "out"]) == SUCCESS
    assert "12 x 8 cells" in capsys.readouterr().out
    assert fv.load("out/solution.npz").grid.shape == (8, 12)


def test_a_film_of_a_plane_has_all_its_outputs():
    assert main([*RUN, "--out", "out", "--animate", "film.gif"]) == SUCCESS
    with Image.open("out/film.gif") as film:
        assert film.n_frames == 61


def test_a_run_goes_on_from_its_checkpoint_to_the_same_bits(folder, capsys):
    stepper = fv.Stepper(gr.scene("vortex").problem(gr.ShallowWater, 12), backend="numpy")
    whole = solve(stepper.problem)
    with pytest.raises(fv.SolveError, match="step"):
        fv.solve(stepper.problem, limits=fv.Limits(steps=4), checkpoint=fv.Checkpoint("run.npz", 0.0), backend="numpy")
    assert main(["run", "--resume", "run.npz", "--out", "out"]) in (SUCCESS, 1)
    fv.resume("run.npz", limits=fv.Limits())
    assert main(["run", "--resume", "run.npz", "--out", "out", "--line", "0", "-0.5", "0", "0.5"]) == SUCCESS
    assert (folder / "out/map.png").is_file()
    assert np.array_equal(fv.load("out/solution.npz").q[-1], whole.q[-1])
    assert "--line must be within [-0.5, 0.5], got 3" in mistake(capsys, "run", "--resume", "run.npz", "--line", "0", "0", "3", "0")
    assert "--plot profile draws over one axis" in mistake(capsys, "run", "--resume", "run.npz", "--plot", "profile")


@pytest.mark.parametrize(("words", "message"), [
    ([*RUN, "--plot", "state"], "--plot state draws over one axis, and this scene has two: leave it out, map.png, vectors.png, cut.png are"),
    ([*RUN, "--plot", "space-time"], "--plot space-time draws over one axis"), ([*RUN, "--plot", "slip"], "--plot slip draws over one axis"),
    ([*RUN, "--line", "0", "0", "9", "0"], "--line must be within [-0.5, 0.5], got 9"),
    (["run", "riemann", "--line", "0", "0", "1", "0"], "--line is the line of a cut through a plane, and this scene has one axis"),
    (["run", "vortex", "--cells", "3x4x5"], "argument --cells: `value` must be a whole number, or NXxNY"),
    (["run", "vortex", "--cells", "ten"], "argument --cells: `value` must be a whole number, or NXxNY"),
    (["run", "vortex", "--cells", "0"], "argument --cells: `value` must be >= 1"),
    (["run", "riemann", "--cells", "10x10"], "`cells` must be a number for a scene with one axis, got (10, 10)"),
    ([*RUN[:-1], "pitman-le"], "PitmanLe serves one axis alone, got a grid with 2"),
    ([*RUN, "--reconstruction", "mp5"], "MethodOfLines serves a grid with one axis, got one with two: take fv.WavePropagation"),
    (["advise", "vortex"], "advice was validated for scenes with one axis alone, got one with two")])
def test_what_has_no_meaning_on_a_plane_is_refused_before_the_run(words, message, capsys):
    said = mistake(capsys, *words)
    assert message in said
    assert said.count("\n") == 1
