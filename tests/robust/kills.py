"""SIGKILL at random times: runs with checkpoints go on bit for bit, files that are written again and again stay whole."""

import os
import signal
import time
from pathlib import Path

import numpy as np

import fvkit as fv
import fvkit_granular as gr
from tests.robust.cases import TIMES, avalanche, forked

SCHEMES = (fv.WavePropagation(gr.Relaxation()), fv.MethodOfLines(gr.Relaxation()))


def kill_runs(count, folder, backend="numpy", seed=1):
    """Kill runs ``count`` times, resume each until it ends; return (kills, runs that ended, kills before a checkpoint)."""
    rng, folder = np.random.default_rng(seed), Path(folder)
    problem = avalanche(cells=2000 if backend == "numba" else 200)  # so that a run takes longer than its start
    wholes, seconds = [], []
    for scheme in SCHEMES:
        wholes.append(fv.solve(problem, scheme, TIMES, backend=backend))
        started = time.perf_counter()
        fv.solve(problem, scheme, TIMES, backend=backend, checkpoint=fv.Checkpoint(folder / "timing.npz", seconds=0.0))
        seconds.append(time.perf_counter() - started)
    kills = ended = early = 0
    while kills < count:
        which = ended % len(SCHEMES)
        path, out = folder / f"run-{ended}.npz", folder / f"out-{ended}.npz"

        def work(which=which, path=path, out=out):
            if path.exists():
                solution = fv.resume(path)
            else:
                solution = fv.solve(problem, SCHEMES[which], TIMES, backend=backend, checkpoint=fv.Checkpoint(path, seconds=0.0))
            solution.save(out)

        while True:
            child = forked(work)
            time.sleep(rng.uniform(0.0, 0.6 * seconds[which]) if kills < count else 0.0)
            if kills < count:
                os.kill(child, signal.SIGKILL)
            _, state = os.waitpid(child, 0)
            if os.WIFSIGNALED(state):
                kills += 1
                early += not path.exists()
            elif os.WEXITSTATUS(state):
                raise AssertionError(f"run {ended} was not resumed after {kills} kills: exit {os.WEXITSTATUS(state)}")
            else:
                break
        found, whole = fv.load(out), wholes[which]
        assert found.q.tobytes() == whole.q.tobytes(), f"run {ended} differs"
        assert found.t.tobytes() == whole.t.tobytes()
        assert (found.stats.steps, found.stats.rejected) == (whole.stats.steps, whole.stats.rejected)
        assert found.stats.mass_drift == whole.stats.mass_drift
        ended += 1
    return kills, ended, early


def kill_writers(count, path, seed=2):
    """Kill a process that writes two solutions in turn under one name; each time the file is one of them. Return the kills."""
    rng, path = np.random.default_rng(seed), Path(path)
    solutions = [fv.solve(avalanche(cells=cells), backend="numpy", limits=fv.Limits(steps=3), throw=False) for cells in (500, 900)]
    known = {solution.q.tobytes() for solution in solutions}
    solutions[0].save(path)

    def work():
        while True:
            for solution in solutions:
                solution.save(path)

    for _ in range(count):
        child = forked(work)
        time.sleep(rng.uniform(0.0, 0.05))
        os.kill(child, signal.SIGKILL)
        _, state = os.waitpid(child, 0)
        assert os.WIFSIGNALED(state), "the writer ended by itself"
        assert fv.load(path).q.tobytes() in known
    return count
