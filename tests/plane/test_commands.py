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
    assert sorted(path.name for path in (folder / "out").iterdir()) == ["cut.png", "map.png", "run.txt", "solution.npz", "vectors.png"]
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
    assert "`--line` must be within [-0.5, 0.5], got 3" in mistake(capsys, "run", "--resume", "run.npz", "--line", "0", "0", "3", "0")
    assert "--plot profile needs a scene with one axis" in mistake(capsys, "run", "--resume", "run.npz", "--plot", "profile")


@pytest.mark.parametrize(("words", "message"), [
    ([*RUN, "--plot", "state"], "--plot state needs a scene with one axis, and this one has two: leave it out, map.png, vectors.png, cut.png are"),
    ([*RUN, "--plot", "space-time"], "--plot space-time needs a scene with one axis"), ([*RUN, "--plot", "slip"], "--plot slip needs a scene with one axis"),
    ([*RUN, "--line", "0", "0", "9", "0"], "`--line` must be within [-0.5, 0.5], got 9"),
    ([*RUN, "--line", "0", "0", "0", "0"], "`--line` must have two ends that differ"),
    (["run", "riemann", "--line", "0", "0", "1", "0"], "--line needs a scene with two axes, and this one has one"),
    (["run", "vortex", "--cells", "3x4x5"], "`--cells` must be a whole number, or NXxNY"),
    (["run", "vortex", "--cells", "ten"], "`--cells` must be a whole number, or NXxNY"),
    (["run", "vortex", "--cells", "0"], "`--cells` must be >= 1, got 0"), (["run", "vortex", "--cells", "9x0"], "`--cells[1]` must be >= 1, got 0"),
    (["run", "riemann", "--cells", "10x10"], "`--cells` must be a number for a scene with one axis, got (10, 10)"),
    ([*RUN[:-1], "pitman-le"], "PitmanLe serves one axis alone, got a grid with 2"),
    ([*RUN, "--reconstruction", "mp5"], "MethodOfLines serves a grid with one axis, got one with two: take fv.WavePropagation"),
    (["advise", "vortex"], "advice was validated for scenes with one axis alone, got one with two")])
def test_what_has_no_meaning_on_a_plane_is_refused_before_the_run(words, message, capsys):
    said = mistake(capsys, *words)
    assert message in said
    assert said.count("\n") == 1


# Sweeps, convergence, stress.


def test_a_scene_run_takes_parameters_of_a_plane():
    run = gr.SceneRun("vortex", gr.ShallowWater, cells=(8, 6), backend="numpy")
    solution = run(**{"t_end": 0.1, "initial.vs_x": 0.5, "initial.vf_x": 0.5, "drift": 0.0})
    whole = run.setup({})[0]
    assert solution.grid.shape == (6, 8)
    assert np.allclose(solution.q[0, 1], 0.5 * whole.q0[1], rtol=1e-13, atol=1e-15)
    assert np.array_equal(solution.q[0, 2], whole.q0[2])
    with pytest.raises(ValueError, match=r"`parameter` must be one of .*initial.vs_y.*got 'initial.vs'"):
        run(**{"initial.vs": 2.0})
    assert gr.SceneRun("vortex").setup({})[0].grid.shape == (100, 100)
    assert gr.SceneRun("rest").setup({})[0].grid.shape == (400,)


SWEEP = """
scene = "vortex"
model = "shallow-water"
cells = 8
samples = "grid"
backend = "numpy"
{more}
[parameters]
t_end = [0.02, 0.04]
"""


def test_a_sweep_over_a_plane_keeps_what_has_a_meaning_there(folder, capsys):
    (folder / "s.toml").write_text(SWEEP.format(more=""))
    assert main(["sweep", "s.toml", "--workers", "1"]) == SUCCESS
    said = capsys.readouterr().out
    assert "2 of 2 members finished" in said
    assert "max.h: " in said
    assert "mean.h: " in said


def test_a_front_on_a_plane_is_refused_before_the_sweep(folder, capsys):
    (folder / "s.toml").write_text(SWEEP.format(more='outputs = ["front.h"]'))
    assert "front.h needs a grid with one axis, got one with two: keep h, max.h or mean.h" in mistake(capsys, "sweep", "s.toml")
    (folder / "s.toml").write_text(SWEEP.format(more='outputs = ["max.speed"]'))
    assert main(["sweep", "s.toml", "--workers", "1"]) == SUCCESS
    (folder / "s.toml").write_text(SWEEP.format(more='scheme = {reconstruction = "mp5"}'))
    assert "MethodOfLines serves a grid with one axis" in mistake(capsys, "sweep", "s.toml")


def test_convergence_of_a_built_in_scene_and_of_one_without_a_reference(folder, capsys):
    given = ["--model", "shallow-water", "--backend", "numpy"]
    assert main(["convergence", "travelling-vortex", "--cells", "16", "32", *given, "--expect", "1.2", "--out", "out"]) == SUCCESS
    assert "order 1.2 is reached" in capsys.readouterr().out
    assert (folder / "out/convergence.png").is_file()
    assert main(["convergence", "dam-break-island", "--cells", "10", "20", "40", *given]) == SUCCESS
    assert "self-converged" in capsys.readouterr().out


def test_stress_judges_one_axis_alone(folder, capsys):
    (folder / "plane.toml").write_text(gr.scene_text(gr.scene("lake-with-islands")))
    for name in ("vortex", "plane.toml"):
        assert f"`scene` must have one axis for stress, got {name}, which has two" in mistake(capsys, "stress", name)
