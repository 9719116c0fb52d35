"""Long runs and large grids: mass, rest, memory; and a sweep with many members."""

import tracemalloc
from pathlib import Path

import numpy as np

import fvkit as fv
import fvkit_granular as gr
from tests.robust.cases import resident


def waves(cells, boundary):
    """Waves of both phases over a hump, on a ring or between walls, without an end."""
    def initial(x):
        return {"h": 1.0 + 0.05 * np.sin(2.0 * np.pi * x), "phi": 0.5 + 0.05 * np.cos(2.0 * np.pi * x)}

    scene = gr.Scene((0.0, 1.0), 1e9, initial, bottom=lambda x: 0.1 * np.exp(-50.0 * (x - 0.5) ** 2), boundary=boundary)
    return scene.problem(gr.TwoPhase, cells)


def rest(cells):
    """A lake at rest in a basin, over the same hump."""
    scene = gr.Scene((0.0, 1.0), 1e9, lambda x: {"h": 1.0 - 0.1 * np.exp(-50.0 * (x - 0.5) ** 2), "phi": 0.5},
                     bottom=lambda x: 0.1 * np.exp(-50.0 * (x - 0.5) ** 2), boundary=fv.Wall())
    problem = scene.problem(gr.TwoPhase, cells)
    level = problem.q0[0] + problem.q0[2] + problem.aux_averages["b"]
    assert np.ptp(level) < 1e-14, "the averages of the start are no lake at rest"
    return problem


def long_run(problem, steps, backend):
    """Take so many steps; return the largest relative change of a mass, the largest speed, and whether all is sound."""
    solution = fv.solve(problem, fv.WavePropagation(gr.Relaxation()), backend=backend, limits=fv.Limits(steps=steps), throw=False,
                        nonhyperbolic="ignore")
    assert solution.status is fv.Status.MAX_STEPS
    assert solution.stats.steps == steps
    first, last = solution.q[0], solution.q[-1]
    change = max(abs(last[row].sum() / first[row].sum() - 1.0) for row in (0, 2))
    speed = max(float(np.abs(last[row + 1] / last[row]).max()) for row in (0, 2))
    return change, speed, bool(np.isfinite(last).all() and (last[::2] >= 0.0).all())


def large_run(cells, steps=3, backend="numba"):
    """Take a few steps on a large grid; return bytes of one state, traced peak beyond the problem, and peak of the process."""
    q = np.empty((4, cells))
    q[:] = np.array([0.5, 0.1, 0.5, 0.2])[:, None]
    q[::2, :cells // 2] *= 1.5
    problem = fv.Problem(gr.TwoPhase(), fv.Grid(0.0, 1.0, cells), q, 1.0, aux={"b": np.linspace(0.0, 0.01, cells)})
    size = q.nbytes
    small = fv.Problem(gr.TwoPhase(), fv.Grid(0.0, 1.0, 100), q[:, :100], 1.0, aux={"b": np.linspace(0.0, 0.01, 100)})
    scheme = fv.WavePropagation(gr.Relaxation())
    fv.Stepper(small, scheme, backend)  # what compiling takes is not counted
    tracemalloc.start()
    stepper = fv.Stepper(problem, scheme, backend)
    for _ in range(steps):
        stepper.step()
    traced = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    assert stepper.steps == steps
    return size, traced, resident("VmHWM")


def member(amplitude, cells):
    """A member of the soak: Burgers' equation."""
    problem = fv.Problem(fv.Burgers(), fv.Grid(0.0, 1.0, cells), lambda x: amplitude * np.sin(2.0 * np.pi * x)[None], 0.05,
                         boundary=fv.Periodic())
    solution = fv.solve(problem, fv.WavePropagation(fv.Roe()), backend="numpy")
    return {"largest": solution.q[-1].max(), "memory": resident()}


def soak(members, folder, workers=2):
    """Sweep so many members into a folder; return the result, and the growth of this process and of a worker, bytes."""
    samples = fv.Samples.latin_hypercube({"amplitude": (0.1, 1.0)}, members, seed=4)
    given = {"amplitude": samples.values["amplitude"], "cells": [20] * members}
    before = resident()
    result = fv.sweep(member, given, workers=workers, folder=folder)
    own = resident() - before
    memory = result.outputs["memory"]
    worker = float(np.median(memory[-members // 10:]) - np.median(memory[members // 10:2 * members // 10]))
    assert len(list(Path(folder).glob("member-*.npz"))) == members
    return result, own, worker
