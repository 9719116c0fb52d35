"""The command line, run as a user runs it: output, files, exit codes, one line for a mistake."""

import json
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

import fvkit

COMMAND = Path(sys.executable).parent / "fvkit"


def run(*arguments: str, cwd: Path) -> subprocess.CompletedProcess[str]:
    return subprocess.run([str(COMMAND), *arguments], capture_output=True, text=True, cwd=cwd, timeout=300)


def test_compare_writes_everything_and_ends_with_a_verdict(tmp_path):
    done = run("compare", "riemann", "--cells", "40", "80", "--repeats", "1", cwd=tmp_path)
    assert done.returncode == 0, done.stderr
    assert "Verdict: at L1(h) = " in done.stdout
    assert max(map(len, done.stdout.splitlines())) <= 100
    folder = tmp_path / "fvkit-compare-riemann"
    assert {path.name for path in folder.iterdir()} == {"report.json", "report.csv", "error_time.png", "error_cells.png",
                                                        "profiles.png"}
    assert len(json.loads((folder / "report.json").read_text())["rows"]) == 12
    assert done.stderr == ""


def test_run_prints_a_summary_and_saves_the_solution(tmp_path):
    done = run("run", "dam-break", "--cells", "50", "--riemann", "hll", "--model", "reduced", "--out", "here", cwd=tmp_path)
    assert done.returncode == 0, done.stderr
    assert "L1 error h" in done.stdout
    assert "(exact)" in done.stdout
    with np.load(tmp_path / "here" / "solution.npz", allow_pickle=False) as data:
        assert data["q"].shape == (2, 3, 50)
        assert str(data["status"]) == "FINISHED"
    assert (tmp_path / "here" / "profile.png").stat().st_size > 5000


def test_a_run_that_fails_exits_1_and_still_writes(tmp_path, monkeypatch, capsys):
    from fvkit.cli import main
    from fvkit_granular import Scene
    from fvkit_granular.scenes.library import catalogue
    from tests.cases import Fading

    def fading():
        return Scene((-1.0, 1.0), 0.05, lambda x: {"h": np.where(x < 0, 1.0, 3.0), "phi": 0.5}, sources=Fading())

    monkeypatch.setitem(catalogue._SCENES, "fading", fading)
    assert main(["run", "fading", "--out", str(tmp_path / "out")]) == 1
    assert "step" in capsys.readouterr().out
    assert (tmp_path / "out" / "solution.npz").exists()


def test_methods_stand_side_by_side_and_any_axes_are_drawn(tmp_path):
    done = run("compare", "simple-wave", "--models", "two-phase", "--method", "wave-propagation", "method-of-lines", "--reconstruction",
               "mp5", "muscl", "--cells", "20", "40", "--repeats", "1", "--plot-axes", "steps", "error.h", "--backend", "numpy",
               "--seconds", "60", cwd=tmp_path)
    assert done.returncode == 0, done.stderr
    assert "ms to L1(h) =" in done.stdout
    folder = tmp_path / "fvkit-compare-simple-wave"
    rows = json.loads((folder / "report.json").read_text())["rows"]
    assert [(row["scheme"], row["limiter"], row["integrator"]) for row in rows[::2]] == [
        ("wave-propagation", "mc", None), ("method-of-lines", "mp5", "ssprk104"), ("method-of-lines", "muscl", "ssprk104")]
    assert (folder / "error.h-over-steps.png").stat().st_size > 5000


def test_run_takes_the_method_of_lines(tmp_path):
    done = run("run", "simple-wave", "--reconstruction", "weno5", "--integrator", "dp5", "--cells", "40", "--backend", "numpy", cwd=tmp_path)
    assert done.returncode == 0, done.stderr
    assert "simple-wave: two-phase, relaxation, weno5, dp5, 40 cells, numpy" in done.stdout


@pytest.mark.parametrize(("expect", "code", "words"), [("4.8", 0, "order 4.8 is reached"), ("5.5", 1, "expected order 5.5 between 80 and 160")])
def test_convergence_prints_orders_and_exits_1_where_one_is_missed(expect, code, words, tmp_path):
    done = run("convergence", "slip-over-bottom", "--riemann", "roe", "--reconstruction", "mp5", "--integrator", "dp5", "--cells", "40",
               "80", "160", "--expect", expect, "--backend", "numpy", "--out", "here", cwd=tmp_path)
    assert done.returncode == code, done.stderr
    assert words in done.stdout
    assert {path.name for path in (tmp_path / "here").iterdir()} == {"convergence.json", "convergence.png"}


@pytest.mark.parametrize(("model", "scene"), [("pitman-le", "pitman-le"), ("two-layer", "internal-jump")])
def test_the_relatives_run_with_the_default_solver(model, scene, tmp_path):
    done = run("run", scene, "--model", model, "--cells", "20", "--backend", "numpy", cwd=tmp_path)
    assert done.returncode == 0, done.stderr
    assert f"{scene}: {model}, relaxation, order 2" in done.stdout


@pytest.mark.parametrize(("arguments", "words"), [
    (("compare", "riemannn"), ("riemannn", "did you mean riemann?", "dam-break-phi")),
    (("compare", "rest", "--riemann", "roee"), ("--riemann", "relaxation, roe, hll, rusanov", "did you mean roe?")),
    (("run", "rest", "--limiter", "mcc"), ("--limiter", "did you mean mc?")),
    (("run", "rest", "--cells", "0"), ("`--cells` must be >= 1",)),
    (("run", "rest", "--cells", "ten"), ("--cells", "ten")),
    (("run", "rest", "--cfl", "2"), ("`--cfl` must be finite and > 0 and <= 1",)),
    (("run", "rest", "--order", "3"), ("`--order` must be one of 1, 2",)),
    (("run", "rest", "--method", "method-of-line"), ("--method", "did you mean method-of-lines?")),
    (("run", "rest", "--reconstruction", "mp6"), ("--reconstruction", "did you mean mp5?")),
    (("compare", "rest", "--method", "wave-propagation", "--integrator", "dp5"), ("--integrator", "add it to --method")),
    (("compare", "rest", "--seconds", "0"), ("`--seconds` must be finite and > 0",)),
    (("convergence", "simple-wave", "--norm", "l3"), ("`--norm` must be one of l1, l2, max; got 'l3'",)),
    (("run", "rest", "--out", "/proc/nowhere"), ("/proc/nowhere",)),
    (("fly",), ("fly",)), ((), ("COMMAND",)),
    (("sweep", "drag.toml", "--wrokers", "4"), ("unrecognized arguments: --wrokers 4 (see fvkit sweep --help)",)),
    (("scenes", "rest", "--show", "rest"), ("--show", "not allowed with argument", "fvkit scenes --help")),
])
def test_a_mistake_is_one_line_on_stderr_and_exit_code_2(arguments, words, tmp_path):
    done = run(*arguments, cwd=tmp_path)
    assert done.returncode == 2
    assert done.stdout == ""
    assert len(done.stderr.strip().splitlines()) == 1
    for word in words:
        assert word in done.stderr
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize("arguments", [("--help",), ("compare", "--help"), ("run", "--help"), ("scenes", "--help"),
                                       ("convergence", "--help"), ("cite", "--help")])
def test_help_has_an_example(arguments, tmp_path):
    done = run(*arguments, cwd=tmp_path)
    assert done.returncode == 0
    assert "example:\n  fvkit " in done.stdout


def test_version_and_scenes(tmp_path):
    assert run("--version", cwd=tmp_path).stdout.strip() == f"fvkit {fvkit.__version__}"
    listed = run("scenes", cwd=tmp_path)
    assert listed.returncode == 0
    assert {line.split()[0] for line in listed.stdout.splitlines()} >= {"riemann", "dam-break-phi", "phi-jump", "rest"}
    shown = run("scenes", "rest", cwd=tmp_path)
    assert shown.returncode == 0
    assert shown.stdout == run("scenes", "--show", "rest", cwd=tmp_path).stdout != listed.stdout


def test_a_space_time_picture_has_its_outputs(tmp_path):
    done = run("run", "dam-break", "--cells", "20", "--plot", "space-time", "slip", "--out", str(tmp_path), cwd=tmp_path)
    assert done.returncode == 0
    assert {"space-time.png", "slip.png", "profile.png"} <= {path.name for path in tmp_path.iterdir()}
