"""Checkpoints: a run that was stopped, by whatever means, goes on bit for bit."""

import os
import signal
import subprocess
import sys
import time
import zipfile

import attrs
import numpy as np
import pytest

import fvkit as fv
import fvkit_granular as gr
from fvkit.backends.compiled.numba_kernel import available
from fvkit.cli import main
from tests.cases import solve

TIMES = [0.05, 0.13, 0.3]
SCHEMES = [fv.WavePropagation(gr.Relaxation()), fv.WavePropagation(fv.Roe(), in_cell_shocks=True, splitting=fv.Godunov()),
           fv.MethodOfLines(gr.Relaxation()), fv.MethodOfLines(fv.HLL(), fv.WENO5(), fv.ARK4())]
BACKENDS = ["numpy", pytest.param("numba", marks=pytest.mark.skipif(not available(), reason="needs the extra fast"))]


def avalanche(cells=60, t_end=0.3, boundary=None, sources=None):
    scene = gr.Scene((-1.0, 2.0), t_end, lambda x: {"h": np.where(x < 0, 1.0, 0.3), "phi": 0.6 - 0.1 * np.tanh(x), "vs": 0.2},
                     bottom=lambda x: 0.1 * np.exp(-(x**2)), boundary=boundary or (fv.Wall(), fv.Outflow()),
                     sources=gr.VelocityDrag(2.0, 1.0) if sources is None else sources)
    return scene.problem(gr.TwoPhase, cells)


def swell(t):
    return [0.6 + 0.1 * np.sin(20.0 * t), 0.1, 0.4, 0.1]


class StopAt:
    """Presses Ctrl-C after so many steps."""

    def __init__(self, steps):
        self.steps = steps

    def __call__(self, stepper):
        if stepper.steps == self.steps:
            raise KeyboardInterrupt


def assert_same(one, other):
    assert one.q.tobytes() == other.q.tobytes()
    assert one.t.tobytes() == other.t.tobytes()
    assert one.status is other.status
    clockless = {"seconds": 0.0, "compile_seconds": 0.0}
    assert attrs.evolve(one.stats, **clockless) == attrs.evolve(other.stats, **clockless)


@pytest.fixture
def path(tmp_path):
    return tmp_path / "run.npz"


@pytest.mark.parametrize("backend", BACKENDS)
@pytest.mark.parametrize("scheme", SCHEMES, ids=["relaxation", "in-cell", "MP5", "WENO5-ARK4"])
def test_a_stopped_run_goes_on_bit_for_bit(scheme, backend, path):
    problem = avalanche()
    whole = fv.solve(problem, scheme, TIMES, backend=backend)
    for steps in {1, whole.stats.steps // 2, whole.stats.steps - 1}:
        half = fv.solve(problem, scheme, TIMES, backend=backend, limits=fv.Limits(steps=steps), throw=False, checkpoint=fv.Checkpoint(path))
        assert half.status is fv.Status.MAX_STEPS
        assert_same(fv.resume(path), whole)
    with pytest.raises(KeyboardInterrupt):
        fv.solve(problem, scheme, TIMES, backend=backend, observers=[StopAt(whole.stats.steps // 3)], checkpoint=fv.Checkpoint(path))
    assert_same(fv.resume(path), whole)


def test_a_run_may_be_stopped_again_and_again(path):
    whole = solve(avalanche(), times=TIMES)
    part = solve(avalanche(), times=TIMES, limits=fv.Limits(steps=3), throw=False, checkpoint=fv.Checkpoint(path))
    while not part.success:
        part = fv.resume(path, limits=fv.Limits(steps=part.stats.steps + 5), throw=False)
    assert_same(part, whole)


def test_a_finished_run_is_resumed_to_itself(path):
    whole = solve(avalanche(), times=TIMES, checkpoint=fv.Checkpoint(path))
    assert_same(fv.resume(path), whole)


@pytest.mark.parametrize(("seconds", "interval"), [(0.0, None), (None, 0.04), (None, None)])
def test_checkpoints_leave_the_run_as_it_is_and_are_written_when_due(seconds, interval, path, monkeypatch):
    seen = []
    monkeypatch.setattr("fvkit.run.checkpoint.write_archive", lambda target, arrays: seen.append(float(arrays["real"][0])))
    whole = solve(avalanche(), times=TIMES)
    kept = solve(avalanche(), times=TIMES, observers=[lambda stepper: None], checkpoint=fv.Checkpoint(path, seconds, interval))
    assert_same(kept, whole)
    assert seen[-1] == 0.3
    assert len(seen) == 1 + (whole.stats.steps if seconds == 0.0 else 0 if interval is None else len(seen) - 1)
    if interval is not None:
        assert (np.diff([0.0, *seen[:-1]]) >= interval).all()
        assert len(seen) >= 6


def test_a_longer_run_begins_like_the_one_before(path):
    short = solve(avalanche(), times=TIMES, checkpoint=fv.Checkpoint(path))
    longer = fv.resume(path, 0.5)
    assert longer.t.tolist() == [0.0, *TIMES, 0.5]
    assert longer.q[:4].tobytes() == short.q.tobytes()
    assert_same(longer, solve(avalanche(t_end=0.5), times=[*TIMES, 0.5]))
    assert_same(fv.resume(path), longer)


def test_an_earlier_end_leaves_out_what_lies_behind_it(path):
    solve(avalanche(), times=TIMES, limits=fv.Limits(steps=5), throw=False, checkpoint=fv.Checkpoint(path))
    assert_same(fv.resume(path, 0.2), solve(avalanche(), times=[0.05, 0.13, 0.2]))
    with pytest.raises(ValueError, match=r"`t_end` must be finite and >= 0.2"):
        fv.resume(path, 0.1)


def test_friction_background_and_all_aux_values_are_kept(path):
    rest = avalanche(sources=gr.CoulombFriction(0.4), boundary=fv.Wall())
    flow = attrs.evolve(rest, background=gr.TwoPhase().conserved_from(np.full(60, 0.8), 0.5))
    for problem in (rest, flow):
        whole = solve(problem, times=TIMES)
        solve(problem, times=TIMES, limits=fv.Limits(steps=7), throw=False, checkpoint=fv.Checkpoint(path))
        assert_same(fv.resume(path), whole)


def test_what_a_file_cannot_hold_is_named_and_can_be_given(path):
    problem = avalanche(boundary=(fv.Inflow(swell), fv.Outflow()))
    whole = solve(problem, times=TIMES)
    solve(problem, times=TIMES, limits=fv.Limits(steps=7), throw=False, checkpoint=fv.Checkpoint(path))
    with pytest.raises(ValueError, match=r"boundary\[0\].state is tests.core.test_checkpoint.swell, which no file can hold; or give `problem`"):
        fv.resume(path)
    assert_same(fv.resume(path, problem=problem), whole)
    with pytest.raises(ValueError, match="`problem` has another grid or initial state"):
        fv.resume(path, problem=avalanche(cells=61))
    with pytest.raises(ValueError, match="`problem` has another 'b' than the run"):
        fv.resume(path, problem=attrs.evolve(problem, aux={"b": 0.0}))


def test_a_run_goes_on_with_its_own_physics_and_scheme_alone(path):
    problem = avalanche(sources=(gr.CoulombFriction(0.4), gr.ConstantDrag(2.0)))
    solve(problem, times=TIMES, limits=fv.Limits(steps=7), throw=False, checkpoint=fv.Checkpoint(path))
    rough = gr.CoulombFriction(np.full(60, 0.4))
    for change, words in (({"sources": (gr.CoulombFriction(0.3), gr.ConstantDrag(2.0))}, r"sources\[0\].nu is 0.3, but 0.4 in the run"),
                          ({"sources": (gr.CoulombFriction(0.4), gr.ConstantDrag(3.0))}, r"sources\[1\].D is 3.0, but 2.0"),
                          ({"sources": (rough, gr.ConstantDrag(2.0))}, r"sources\[0\].nu is .*, but 0.4"),
                          ({"sources": (gr.Voellmy(0.4, 500.0), gr.ConstantDrag(2.0))}, r"sources\[0\] is "),
                          ({"sources": ()}, "sources is "),
                          ({"boundary": fv.Wall()}, r"boundary"),
                          ({"model": gr.TwoPhase(gamma=0.4)}, r"model.gamma is 0.4, but 0.5")):
        with pytest.raises(ValueError, match=words):
            fv.resume(path, problem=attrs.evolve(problem, **change))
    with pytest.raises(ValueError, match=r"scheme.cfl is 0.5, but 0.9"):
        fv.resume(path, scheme=fv.WavePropagation(gr.Relaxation(), cfl=0.5))
    assert_same(fv.resume(path, problem=problem), solve(problem, times=TIMES))


def test_a_background_that_the_scheme_asks_at_faces_is_not_replaced_in_silence(path):
    def flow(x):
        return gr.TwoPhase().conserved_from(0.8 + 0.01 * np.sin(x), 0.5)

    problem = attrs.evolve(avalanche(sources=()), background=flow)
    for scheme in (fv.WavePropagation(gr.Relaxation()), fv.MethodOfLines(gr.Relaxation())):
        whole = solve(problem, scheme, TIMES)
        solve(problem, scheme, TIMES, limits=fv.Limits(steps=2), throw=False, checkpoint=fv.Checkpoint(path))
        if isinstance(scheme, fv.MethodOfLines):
            with pytest.raises(ValueError, match="background is a function whose values at faces the scheme uses"):
                fv.resume(path)
        assert_same(fv.resume(path, problem=problem), whole)


def test_the_failure_names_the_checkpoint(path):
    with pytest.raises(fv.SolveError, match=r"max_steps,? .* step 4; fv.resume\('.*run.npz'\) goes on from here") as caught:
        solve(avalanche(), times=TIMES, limits=fv.Limits(steps=4), checkpoint=fv.Checkpoint(path))
    assert str(caught.value) == caught.value.solution.message


def test_a_checkpoint_is_no_solution_and_the_other_way_round(path, tmp_path):
    whole = solve(avalanche(), times=TIMES, checkpoint=fv.Checkpoint(path))
    with pytest.raises(ValueError, match=r"it is no 'fvkit solution 1' but 'fvkit checkpoint 3': fv.resume continues it"):
        fv.load(path)
    with pytest.raises(ValueError, match=r"it is no 'fvkit checkpoint 3' but 'fvkit solution 1': fv.load reads it"):
        fv.resume(whole.save(tmp_path / "other.npz"))


def test_a_damaged_checkpoint_is_refused(path):
    solve(avalanche(), times=TIMES, checkpoint=fv.Checkpoint(path))
    content = path.read_bytes()
    for part in (b"", content[:1000], content[:-30]):
        path.write_bytes(part)
        with pytest.raises(ValueError, match=r"run.npz cannot be read"):
            fv.resume(path)
    for name in ("now", "real", "count", "masses", "plan", "times"):
        path.write_bytes(content)
        with zipfile.ZipFile(path) as archive:
            kept = {entry: archive.read(entry) for entry in archive.namelist() if entry != f"{name}.npy"}
        with zipfile.ZipFile(path, "w") as archive:
            for entry, data in kept.items():
                archive.writestr(entry, data)
        with pytest.raises(ValueError, match=f"run.npz cannot be read: it has no '{name}'"):
            fv.resume(path)


@pytest.mark.parametrize(("arguments", "words"), [
    (("run.nc",), "must end in .npz"), (("/nowhere/run.npz",), "must be in a folder that exists"),
    (("run.npz", -1.0), "`seconds` must be finite and >= 0"), (("run.npz", 1.0, 0.0), "`interval` must be finite and > 0")])
def test_a_checkpoint_that_cannot_be_is_refused_at_once(arguments, words):
    with pytest.raises(ValueError, match=words):
        fv.Checkpoint(*arguments)


def test_an_interruption_within_the_bookkeeping_leaves_a_whole_step():
    """Ctrl-C at every line of it: what is left is the state before or after the step, never a mixture."""
    lines = 0
    while True:
        stepper = fv.Stepper(avalanche(), backend="numpy")
        stepper.step()
        before = stepper.snapshot()
        interrupted = False

        def trace(frame, event, argument, left=[lines]):  # noqa: B006
            if frame.f_code.co_name != "accept":
                return None
            if event == "line":
                left[0] -= 1
                if left[0] < 0:
                    raise KeyboardInterrupt
            return trace

        sys.settrace(trace)
        try:
            stepper.step()
        except KeyboardInterrupt:
            interrupted = True
        finally:
            sys.settrace(None)
        if not interrupted:
            break
        after = stepper.snapshot()
        assert all(np.array_equal(before[name], after[name], equal_nan=True) for name in ("now", "real", "count", "masses"))
        lines += 1
    assert lines >= 4


KILLED = """
import sys
sys.path[:0] = {paths!r}
import fvkit as fv
from tests.core.test_checkpoint import TIMES, avalanche
print("ready", flush=True)
while True:
    fv.solve(avalanche(200), times=TIMES, backend="numpy", checkpoint=fv.Checkpoint({path!r}, seconds=0.0), limits=fv.Limits(steps=150), throw=False)
"""


@pytest.mark.parametrize("seed", range(3))
def test_a_killed_run_goes_on_bit_for_bit(seed, path):
    """SIGKILL at a random moment of a process that does little but write checkpoints."""
    code = KILLED.format(path=str(path), paths=[entry for entry in sys.path if entry])
    process = subprocess.Popen([sys.executable, "-c", code], stdout=subprocess.PIPE, env={**os.environ, "FVKIT_BACKEND": "numpy"})
    try:
        assert process.stdout.readline() == b"ready\n"
        deadline = time.monotonic() + 20.0
        while not path.exists() and time.monotonic() < deadline:
            time.sleep(0.01)
        time.sleep(float(np.random.default_rng(seed).uniform(0.0, 0.4)))
    finally:
        process.send_signal(signal.SIGKILL)
        process.wait()
        process.stdout.close()
    assert_same(fv.resume(path), solve(avalanche(200), times=TIMES))


def test_the_command_line_checkpoints_and_resumes(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    assert main(["run", "dam-break", "--cells", "40", "--checkpoint", "run.npz", "--every", "0", "--out", "one"]) == 0
    assert "checkpoint run.npz" in capsys.readouterr().out
    assert main(["run", "--resume", "run.npz", "--out", "two"]) == 0
    assert "the end time was reached" in capsys.readouterr().out
    assert_same(fv.load("one/solution.npz"), fv.load("two/solution.npz"))
    assert main(["run", "dam-break", "--resume", "run.npz", "--out", "three"]) == 0
    assert_same(fv.load("one/solution.npz"), fv.load("three/solution.npz"))
    capsys.readouterr()
    for mistake in (["run"], ["run", "--resume", "gone.npz"],
                    ["run", "--resume", "one/solution.npz"], ["run", "dam-break", "--checkpoint", "a/b.npz"],
                    ["run", "dam-break", "--every", "3"]):
        assert main(mistake) == 2, mistake
        assert len(capsys.readouterr().err.strip().splitlines()) == 1
