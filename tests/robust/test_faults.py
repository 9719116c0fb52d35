"""Kills, interruptions, full disks, two processes at once. Kills in full: ``python -m tests.robust.full kills``."""

import errno
import json
import os
import signal
import subprocess
import sys
import time
from importlib.util import find_spec

import numpy as np
import pytest

import fvkit as fv
from fvkit.backends.compiled import disk_cache
from fvkit.backends.compiled.numba_kernel import available
from fvkit.cli import main
from fvkit.files import write_whole
from tests import sweep_members as members
from tests.cases import solve
from tests.robust import kills
from tests.robust.cases import TIMES, avalanche, forked, full_disk

pytestmark = pytest.mark.skipif(sys.platform != "linux", reason="forks and limits the size of files")
#: What the operating system says of a full disk, or of a file that may not grow.
DISK = (errno.ENOSPC, errno.EFBIG)
NETCDF = find_spec("h5netcdf") is not None
netcdf = pytest.mark.skipif(not NETCDF, reason="needs the extra io")
SUFFIXES = ["npz", pytest.param("nc", marks=netcdf)]


def command(*arguments, **environment):
    """Start the command line in a process of its own."""
    code = f"import sys; sys.path[:0] = {[entry for entry in sys.path if entry]!r}; from fvkit.cli import main; sys.exit(main())"
    return subprocess.Popen([sys.executable, "-c", code, *map(str, arguments)], stdout=subprocess.PIPE, stderr=subprocess.PIPE,
                            text=True, env={**os.environ, "FVKIT_BACKEND": "numpy", **environment})


def leftovers(folder):
    return [path.name for path in folder.iterdir() if ".part" in path.name]


# -- kills ----------------------------------------------------------------------------------------------------------------

def test_killed_runs_are_resumed_to_the_same_bits(tmp_path):
    killed, ended, _ = kills.kill_runs(8, tmp_path)
    assert killed == 8
    assert ended >= 1


@pytest.mark.parametrize("suffix", SUFFIXES)
def test_a_file_survives_a_kill_while_it_is_written_again(suffix, tmp_path):
    assert kills.kill_writers(12, tmp_path / f"file.{suffix}") == 12


def test_the_checkpoint_of_another_run_is_not_resumed_after_a_kill_before_the_first_of_this_one(tmp_path):
    path = tmp_path / "run.npz"
    solve(avalanche(cells=30), checkpoint=fv.Checkpoint(path))

    def die(stepper):
        os.kill(os.getpid(), signal.SIGKILL)

    child = forked(lambda: solve(avalanche(cells=40), None, TIMES, observers=[die], checkpoint=fv.Checkpoint(path)) and 0)
    assert os.WIFSIGNALED(os.waitpid(child, 0)[1])
    assert fv.resume(path).q.tobytes() == solve(avalanche(cells=40), times=TIMES).q.tobytes()


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_ctrl_c_and_sigterm_leave_a_partial_solution_a_checkpoint_and_exit_code_130(number, tmp_path):
    out, path = tmp_path / "out", tmp_path / "run.npz"
    process = command("run", "riemann", "--cells", 20_000, "--checkpoint", path, "--every", 0.1, "--out", out)
    deadline = time.monotonic() + 60.0
    while not path.exists() and time.monotonic() < deadline:
        time.sleep(0.05)
    process.send_signal(number)
    said, complaint = process.communicate(timeout=60)
    assert process.returncode == 130, complaint
    assert f"fvkit run --resume {path}" in said
    partial = fv.load(out / "solution.npz")
    assert partial.status is fv.Status.INTERRUPTED
    more = fv.resume(path, limits=fv.Limits(steps=partial.stats.steps), throw=False)
    assert more.q[-1].tobytes() == partial.q[-1].tobytes()


def test_workers_of_a_sweep_end_with_the_process_that_started_it():
    code = f"""
import sys
sys.path[:0] = {[entry for entry in sys.path if entry]!r}
import os, signal, threading, multiprocessing
import fvkit as fv
from tests import sweep_members as members
def kill(share):
    if share > 0.0:
        print(*[child.pid for child in multiprocessing.active_children()], flush=True)
        os.kill(os.getpid(), signal.SIGKILL)
if __name__ == "__main__":
    fv.sweep(members.slow, {{"x": range(200)}}, workers=2, progress=kill)
"""
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, timeout=60)
    assert done.returncode == -signal.SIGKILL
    workers = [int(word) for word in done.stdout.split()]
    assert len(workers) == 2
    deadline = time.monotonic() + 10.0
    while any(os.path.exists(f"/proc/{worker}") for worker in workers) and time.monotonic() < deadline:
        time.sleep(0.05)
    assert not any(os.path.exists(f"/proc/{worker}") for worker in workers)


# -- full disks -----------------------------------------------------------------------------------------------------------

@pytest.mark.parametrize("suffix", SUFFIXES)
def test_a_full_disk_leaves_the_old_file_and_no_other(suffix, tmp_path):
    path = tmp_path / f"file.{suffix}"
    old, new = solve(avalanche(cells=30)), solve(avalanche(cells=2000), limits=fv.Limits(steps=2), throw=False)
    old.save(path)
    with full_disk(20_000), pytest.raises(OSError, match=path.name) as caught:
        new.save(path)
    assert caught.value.errno in DISK
    assert fv.load(path).q.tobytes() == old.q.tobytes()
    assert os.listdir(tmp_path) == [path.name]
    new.save(path)
    assert fv.load(path).q.tobytes() == new.q.tobytes()


def test_a_checkpoint_on_a_full_disk_ends_the_run_and_names_the_last_one(tmp_path):
    path = tmp_path / "run.npz"

    def fill(stepper):
        if stepper.steps == 10:
            limit.__enter__()

    limit = full_disk(3000)
    try:
        with pytest.raises(OSError, match="so nothing was changed") as caught:
            solve(avalanche(), times=TIMES, observers=[fill], checkpoint=fv.Checkpoint(path, seconds=0.0))
    finally:
        limit.__exit__(None, None, None)
    assert caught.value.filename == str(path)
    (note,) = caught.value.__notes__
    partial = caught.value.solution
    assert partial.stats.steps == 10
    assert f"raised while writing a checkpoint, at t = {partial.t[-1]:.8g}, step 10" in note
    assert f"step 9: fv.resume({str(path)!r}) goes on from there" in note
    assert leftovers(tmp_path) == []
    assert fv.resume(path).q.tobytes() == solve(avalanche(), times=TIMES).q.tobytes()


def test_a_finished_run_whose_last_checkpoint_fails_keeps_its_solution(tmp_path):
    path = tmp_path / "run.npz"
    with full_disk(3000):
        with pytest.raises(OSError, match=r"run\.npz") as caught:
            solve(avalanche(), times=TIMES, checkpoint=fv.Checkpoint(path))
        kept = solve(avalanche(), times=TIMES, checkpoint=fv.Checkpoint(path), throw=False)
    assert f"no checkpoint was written to {path}" in caught.value.__notes__[0]
    assert kept.status is fv.Status.ERROR
    assert kept.q.tobytes() == caught.value.solution.q.tobytes() == solve(avalanche(), times=TIMES).q.tobytes()
    assert not path.exists()


@netcdf
def test_a_stream_on_a_full_disk_ends_the_run_and_keeps_the_old_file(tmp_path):
    path, times = tmp_path / "run.nc", np.linspace(0.01, 0.3, 30)
    old = solve(avalanche(cells=30), times=[0.1], record=fv.Stream(path))
    with full_disk(500_000), pytest.raises(OSError, match=r"run\.part\.nc") as caught:
        solve(avalanche(cells=1000), times=times, record=fv.Stream(path))
    assert caught.value.errno in DISK
    assert "raised while writing an output" in caught.value.__notes__[0]
    assert caught.value.solution.t[-1] in times
    assert fv.load(path).t.tolist() == old.t.tolist() == [0.0, 0.1]
    kept = fv.load(tmp_path / "run.part.nc")
    assert len(kept.t) > 1
    assert kept.t.tolist() == [0.0, *times[:len(kept.t) - 1]]
    same = solve(avalanche(cells=1000), times=times[:len(kept.t) - 1])
    assert kept.q.tobytes() == same.q.tobytes()
    solve(avalanche(cells=20), record=fv.Stream(path))
    assert fv.load(path).grid.num_cells == 20


def test_the_command_line_says_what_a_full_disk_means(tmp_path, capfd):
    path, arguments = tmp_path / "run.npz", ["run", "dam-break", "--cells", "2000", "--out", str(tmp_path / "out")]
    assert main([*arguments, "--checkpoint", str(path)]) == 0
    kept = path.read_bytes()
    capfd.readouterr()
    with full_disk(60_000):
        codes = [main(arguments), main([*arguments, "--checkpoint", str(path)])]
    lost, named = capfd.readouterr().err.strip().splitlines()
    assert codes == [2, 2]
    assert "solution.npz" in lost
    assert "with --checkpoint FILE it can go on" in lost
    assert "so nothing was changed" in named
    assert f"no checkpoint was written: {path} is as it was; checkpoint {path}: fvkit run --resume {path}" in named
    assert path.read_bytes() == kept
    assert leftovers(tmp_path / "out") == []
    assert main(["run", "dam-break", "--cells", "20", "--out", "/dev/full/out"]) == 2


def test_a_sweep_on_a_full_disk_keeps_what_it_had(tmp_path):
    given = {"x": np.arange(6.0)}

    def fill(share):
        if share >= 0.5:
            limit.__enter__()

    limit = full_disk(100)
    try:
        with pytest.raises(OSError, match=r"member-000003\.npz"):
            fv.sweep(members.square, given, workers=1, folder=tmp_path, progress=fill)
    finally:
        limit.__exit__(None, None, None)
    assert leftovers(tmp_path) == []
    shares = []
    assert fv.sweep(members.square, given, workers=1, folder=tmp_path, progress=shares.append).success
    assert shares[0] == 0.5


# -- two at once ----------------------------------------------------------------------------------------------------------

def test_two_runs_into_one_folder_leave_whole_files(tmp_path):
    both = [command("run", "dam-break", "--cells", cells, "--out", tmp_path / "out") for cells in (60, 80)]
    for process in both:
        said, complaint = process.communicate(timeout=100)
        assert process.returncode == 0, complaint
        assert "written to" in said
    assert fv.load(tmp_path / "out" / "solution.npz").grid.num_cells in (60, 80)
    assert sorted(os.listdir(tmp_path / "out")) == ["profile.png", "run.txt", "solution.npz"]


def together(*works):
    """Run functions in children that begin at the same moment; return their exit codes."""
    reader, writer = os.pipe()

    def wait(work):
        os.close(writer)
        os.read(reader, 1)
        return work()

    children = [forked(lambda work=work: wait(work)) for work in works]
    os.close(reader)
    os.close(writer)
    return [os.WEXITSTATUS(os.waitpid(child, 0)[1]) for child in children]


def swept(folder, given):
    """0: the sweep is right; 3: refused with a sentence."""
    try:
        result = fv.sweep(members.square, given, workers=1, folder=folder)
    except ValueError as error:
        return 3 if "holds another sweep, of other parameters" in str(error) else 4
    return 0 if np.array_equal(result.outputs["value"], np.square(given["x"])) else 5


def test_two_equal_sweeps_with_one_folder_are_both_right_and_of_two_others_one_is_refused(tmp_path):
    given, other = {"x": np.arange(40.0)}, {"x": np.arange(41.0)}
    for attempt in range(5):
        folder = tmp_path / f"same-{attempt}"
        assert together(lambda folder=folder: swept(folder, given), lambda folder=folder: swept(folder, given)) == [0, 0]
        assert len(list(folder.glob("member-*.npz"))) == 40
        folder = tmp_path / f"other-{attempt}"
        codes = together(lambda folder=folder: swept(folder, given), lambda folder=folder: swept(folder, other))
        assert sorted(codes) == [0, 3]
        assert len(json.loads((folder / "sweep.json").read_text())["parameters"]["x"]) == (40 if codes[0] == 0 else 41)


def test_a_damaged_plan_of_a_sweep_is_a_sentence(tmp_path):
    (tmp_path / "sweep.json").write_text("{")
    with pytest.raises(ValueError, match=r"has a sweep\.json that is no plan of a sweep"):
        fv.sweep(members.square, {"x": [1.0]}, workers=1, folder=tmp_path)


@netcdf
def test_a_second_stream_to_one_file_is_refused_and_the_first_goes_on(tmp_path):
    path, refused = tmp_path / "run.nc", []

    def second(stepper):
        if stepper.steps == 20:
            child = forked(lambda: streamed(path))
            refused.append(os.WEXITSTATUS(os.waitpid(child, 0)[1]))

    whole = solve(avalanche(), times=TIMES, observers=[second], record=fv.Stream(path))
    assert refused == [3]
    assert fv.load(path).q.tobytes() == solve(avalanche(), times=TIMES).q.tobytes()
    assert whole.success


def streamed(path):
    try:
        solve(avalanche(cells=20), record=fv.Stream(path))
    except ValueError as error:
        return 3 if "is open elsewhere" in str(error) else 4
    return 0


def test_files_are_made_with_the_usual_permissions_and_new_ones_replace_nothing(tmp_path):
    path = tmp_path / "file"
    before = os.umask(0o027)
    try:
        write_whole(path, lambda file: file.write(b"one"), replace=False)
    finally:
        os.umask(before)
    assert path.stat().st_mode & 0o777 == 0o640
    with pytest.raises(FileExistsError):
        write_whole(path, lambda file: file.write(b"two"), replace=False)
    assert path.read_bytes() == b"one"
    assert os.listdir(tmp_path) == ["file"]
    with pytest.raises(OSError, match="nowhere"):
        write_whole(tmp_path / "nowhere" / "file", lambda file: None)


# -- the cache of compiled kernels ----------------------------------------------------------------------------------------

COMPILED = """
import sys, warnings
sys.path[:0] = {paths!r}
import numpy as np
import fvkit as fv
problem = fv.Problem(fv.Advection(1.0), fv.Grid(0.0, 1.0, 50), lambda x: np.sin(2.0 * np.pi * x)[None], 0.1, boundary=fv.Periodic())
with warnings.catch_warnings(record=True) as caught:
    warnings.simplefilter("always")
    solution = fv.solve(problem, fv.WavePropagation(fv.Roe(), order=1), backend="numba")
print(solution.q[-1].tobytes().hex(), *[str(item.message) for item in caught], sep="|")
"""


def compiled(folder):
    code = COMPILED.format(paths=[entry for entry in sys.path if entry])
    return subprocess.Popen([sys.executable, "-c", code], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True,
                            env={**os.environ, disk_cache.VARIABLE: str(folder)})


def result_of(process):
    said, complaint = process.communicate(timeout=200)
    assert process.returncode == 0, complaint
    state, *warned = said.strip().split("|")
    return state, warned


@pytest.mark.skipif(not available(), reason="needs the extra fast")
def test_two_processes_share_a_cache_and_damage_to_it_costs_time_alone(tmp_path):
    (one, first), (other, second) = [result_of(process) for process in [compiled(tmp_path), compiled(tmp_path)]]
    assert one == other
    assert first == second == []
    files = list((tmp_path / "__pycache__").glob("*.nbi"))
    assert files
    for path in files:
        path.write_bytes(path.read_bytes()[:50])
    again, warned = result_of(compiled(tmp_path))
    assert again == one
    assert len(warned) == 1
    assert "could not be read" in warned[0]


def test_a_cache_that_cannot_be_written_is_a_warning(monkeypatch, tmp_path):
    monkeypatch.setenv(disk_cache.VARIABLE, "/dev/null/kernels")
    with pytest.warns(RuntimeWarning, match="the cache of compiled kernels cannot be written"):
        _, lasting = disk_cache.place("kernel_x", "")
    assert not lasting
    monkeypatch.setenv(disk_cache.VARIABLE, str(tmp_path))
    with full_disk(10), pytest.warns(RuntimeWarning, match="cannot be written"):
        _, lasting = disk_cache.place("kernel_x", "a text of more than ten bytes")
    assert not lasting
    assert os.listdir(tmp_path) == []
