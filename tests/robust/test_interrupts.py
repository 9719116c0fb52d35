"""Ctrl-C in a study, which makes many runs: it ends at once, with what was done; exceptions that cross processes."""

import copy
import importlib
import multiprocessing
import os
import pickle
import pkgutil
import signal
import subprocess
import sys
import time
from functools import partial
from pathlib import Path

import numpy as np
import pytest

import fvkit as fv
import fvkit_granular as gr
from fvkit.cli import INTERRUPTED, main
from fvkit.files import Unreadable
from fvkit_granular.stress import suite
from fvkit_granular.studies import bench
from tests.tools import advice_validation, random_runs

RIEMANN = gr.scene("riemann")
COMPARE = partial(gr.compare, RIEMANN, [gr.TwoPhase], [fv.Roe()], cells=(10, 20, 40), repeats=1)
ORDER = partial(fv.convergence, partial(RIEMANN.problem, gr.TwoPhase), None, (10, 20, 40, 80), RIEMANN.known_reference())
SWEEP = partial(fv.sweep, gr.SceneRun("riemann", cells=20), {"gamma": [0.3, 0.4, 0.5, 0.6]}, workers=1)
#: Studies that run in this process: the module that solves, the study, the run that is interrupted, runs or parts that are done.
STUDIES = {
    "compare": ("fvkit.studies.compare", COMPARE, 4, lambda report: len(report.rows) == 2),  # the first run is the warm-up
    "convergence": ("fvkit.studies.convergence", ORDER, 3, lambda found: found.runs == (10, 20)),
    "sweep": ("fvkit_granular.studies.scene_run", SWEEP, 3, lambda found: list(found.status) == ["finished"] * 2 + ["interrupted"] * 2),
    "validate": ("fvkit_granular.cli.advise", partial(advice_validation.validate, 4, cells=10), 14, lambda rows: len(rows) == 2),
}


def press(*_):
    os.kill(os.getpid(), signal.SIGINT)


def interrupted_in_run(number, module, monkeypatch):
    """Let Ctrl-C be pressed while a module makes its run of that number; return the list of its runs."""
    runs, solve = [], fv.solve

    def counted(*arguments, **options):
        runs.append(arguments)
        return solve(*arguments, **options, **({"observers": [press]} if len(runs) == number else {}))

    monkeypatch.setattr(sys.modules[module], "solve", counted)  # names of modules are those of functions as well
    return runs


@pytest.mark.parametrize("name", STUDIES)
def test_ctrl_c_in_a_run_ends_the_study_and_gives_what_was_done(name, monkeypatch):
    module, study, number, right = STUDIES[name]
    runs = interrupted_in_run(number, module, monkeypatch)
    with pytest.raises(KeyboardInterrupt) as caught:
        study()
    assert len(runs) == number, "a run after Ctrl-C"
    assert right(caught.value.result)


@pytest.mark.parametrize("name", ["compare", "convergence"])
def test_ctrl_c_in_the_first_run_leaves_nothing_to_give(name, monkeypatch):
    module, study, _, _ = STUDIES[name]
    interrupted_in_run(1, module, monkeypatch)
    with pytest.raises(KeyboardInterrupt) as caught:
        study()
    assert caught.value.result is None


def test_an_interrupted_bench_gives_the_numbers_of_cells_that_are_done(monkeypatch):
    measure = bench.measure
    monkeypatch.setattr(bench, "measure", lambda runs, cells, repeats: press() if cells == 20 else measure(runs, cells, repeats))
    monkeypatch.setattr(bench, "BLOCK", 1e-6)
    with pytest.raises(KeyboardInterrupt) as caught:
        bench.bench((10, 20, 30), (1,), ["numpy"], repeats=1)
    assert {row["cells"] for row in caught.value.result.rows} == {10}


def test_a_conformance_suite_does_not_count_ctrl_c_as_a_failed_check():
    class Suite(fv.testing.LimiterConformance):
        limiter = fv.MC()

        def test_a(self):
            fv.solve(RIEMANN.problem(gr.TwoPhase, 20), observers=[press])

    with pytest.raises(KeyboardInterrupt):
        fv.testing.run(Suite)


@pytest.mark.parametrize(("command", "module", "number", "written"), [
    (["compare", "riemann", "--models", "two-phase", "--riemann", "roe", "--cells", "10", "20", "--repeats", "1", "--plot-axes",
      "steps", "error.h"], "fvkit.studies.compare", 3, "report.json"),
    (["convergence", "riemann", "--cells", "10", "20", "40"], "fvkit.studies.convergence", 3, "convergence.json")])
def test_a_command_writes_what_was_done_and_ends_with_130(command, module, number, written, monkeypatch, tmp_path, capsys):
    interrupted_in_run(number, module, monkeypatch)
    assert main([*command, "--out", str(tmp_path)]) == INTERRUPTED
    assert (tmp_path / written).exists()
    assert "interrupted" in capsys.readouterr().err


@pytest.mark.skipif(sys.platform == "win32", reason="signals of a terminal")
def test_one_ctrl_c_ends_stress_and_its_processes(tmp_path):
    code = f"import sys; sys.path[:0] = {[entry for entry in sys.path if entry]!r}; from fvkit.cli import main; sys.exit(main())"
    process = subprocess.Popen([sys.executable, "-c", code, "stress", "--full", "--backends", "numpy", "--workers", "2", "--out",
                                str(tmp_path)], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, start_new_session=True)
    children = Path(f"/proc/{process.pid}/task/{process.pid}/children")
    limit = time.monotonic() + 60.0
    while len(started := children.read_text().split()) < 2 and time.monotonic() < limit:
        time.sleep(0.05)
    time.sleep(1.0)
    os.killpg(process.pid, signal.SIGINT)
    _, error = process.communicate(timeout=30)
    assert process.returncode == INTERRUPTED, error
    assert "Traceback" not in error
    assert not [pid for pid in started if Path(f"/proc/{pid}").exists()], "orphans"


@pytest.mark.parametrize(("study", "owner"), [
    (partial(suite.stress, scenes=["toe"], backends=["numpy"], workers=1), suite),
    (partial(random_runs.random_stress, 24, models=["shallow-water"], riemann=["hll", "rusanov"], orders=(1,), workers=1), random_runs)])
def test_interrupted_stress_reports_the_runs_that_are_done(study, owner, monkeypatch):
    parts = owner.in_processes

    def once(*arguments):
        yield next(iter(parts(*arguments)))
        raise KeyboardInterrupt

    monkeypatch.setattr(owner, "in_processes", once)
    with pytest.raises(KeyboardInterrupt) as caught:
        study()
    assert len(caught.value.result.rows) == 1
    assert caught.value.result.summary()


@pytest.mark.parametrize("module", ["numpy", "fvkit.cli", "fvkit.run.solve", "fvkit_granular", "fvkit_granular.cli.run", "matplotlib.figure"])
def test_ctrl_c_while_the_command_is_imported_is_one_sentence(module):
    code = f"""
import os, signal, sys
sys.path[:0] = {[entry for entry in sys.path if entry]!r}
class Press:
    def find_spec(self, name, *_):
        if name == {module!r}:
            os.kill(os.getpid(), signal.SIGINT)
sys.meta_path.insert(0, Press())
from fvkit_command import main
sys.exit(main())
"""
    done = subprocess.run([sys.executable, "-c", code, "scenes"], capture_output=True, text=True, timeout=60, check=False)
    assert (done.returncode, done.stdout, done.stderr) == (INTERRUPTED, "", "fvkit: interrupted\n")


STATE = (fv.Status.MAX_STEPS, 0.5, 3, 0.25, np.array([1.0, 2.0]), 7, ("h", "hv"))
#: How the exceptions are made that take more than a sentence.
MADE = {fv.SolveError: partial(fv.SolveError, *STATE), fv.Interrupted: partial(fv.Interrupted, *STATE),
        Unreadable: partial(Unreadable, Path("run.npz"), "it is damaged"),
        fv.OrderError: partial(fv.OrderError, "too low", "a Convergence")}


def exceptions():
    """Every exception class that is defined in one of both packages."""
    for package in (fv, gr):
        for module in pkgutil.walk_packages(package.__path__, f"{package.__name__}."):
            importlib.import_module(module.name)
    found, waiting = set(), [BaseException]
    while waiting:
        kind = waiting.pop()
        waiting += kind.__subclasses__()
        found |= {kind} if kind.__module__.split(".")[0] in ("fvkit", "fvkit_granular") else set()
    return sorted(found, key=lambda kind: kind.__qualname__)


@pytest.mark.parametrize("kind", exceptions(), ids=lambda kind: kind.__name__)
@pytest.mark.parametrize("way", [*(lambda error, p=p: pickle.loads(pickle.dumps(error, p)) for p in range(pickle.HIGHEST_PROTOCOL + 1)),
                                 copy.copy, copy.deepcopy])
def test_every_exception_survives_pickling_and_copying(kind, way):
    error = MADE.get(kind, partial(kind, "a sentence"))()
    error.add_note("a note")
    again = way(error)
    assert type(again) is kind
    assert str(again) == str(error)
    assert repr(sorted(vars(again).items())) == repr(sorted(vars(error).items()))


def fails(how):
    if how == "read":
        fv.load(__file__)
    return fv.solve(RIEMANN.problem(gr.TwoPhase, 20), limits=fv.Limits(steps=how)).t[-1]


def test_exceptions_arrive_from_a_pool_of_processes():
    with multiprocessing.get_context("spawn").Pool(1) as pool:
        with pytest.raises(fv.SolveError, match="max_steps") as caught:
            pool.apply_async(fails, [2]).get(60)
        assert caught.value.solution.stats.steps == 2
        assert caught.value.step == 2
        with pytest.raises(ValueError, match=r"test_interrupts\.py"):
            pool.apply_async(fails, ["read"]).get(60)
