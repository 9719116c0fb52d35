"""Members of sweeps that worker processes import: everything here must be quick to import."""

import os
import time
from pathlib import Path

import numpy as np

import fvkit as fv


def square(x, y=0.0):
    return {"value": x * x + y, "row": np.arange(3) * x}


def pid(x):
    return {"pid": os.getpid(), "x": x}


def troubled(x):
    if x == 1:
        raise ZeroDivisionError("one is too much")
    if x == 2:
        raise fv.SolveError(fv.Status.NON_FINITE, 0.5, 3, 1.5, np.array([np.inf]), 7, ("u",))
    return {"value": x, "whole": 2}


def deadly(x):
    """Member 5 ends its process, always."""
    if x == 5:
        os._exit(1)
    return {"value": x}


def deadly_once(x, folder):
    """Member 3 ends its process the first time it runs."""
    mark = Path(folder) / "died"
    if x == 3 and not mark.exists():
        mark.touch()
        os._exit(1)
    return {"value": 2.0 * x}


def counted(x, folder):
    """Leave a mark of every run."""
    (Path(folder) / f"run-{x}-{time.perf_counter_ns()}").touch()
    if x == 7 and not (Path(folder) / "mended").exists():
        raise OSError("no such disk")
    return {"value": 10.0 * x}


def slow(x):
    time.sleep(0.05)
    return {"value": x + 0.5, "pid": os.getpid()}


def burgers(amplitude, cells):
    problem = fv.Problem(fv.Burgers(), fv.Grid(0.0, 1.0, cells), lambda x: amplitude * np.sin(2.0 * np.pi * x)[None], 0.05,
                         boundary=fv.Periodic())
    return fv.solve(problem, fv.WavePropagation(fv.Roe()), backend="numpy")


def blows_up(cells):
    problem = fv.Problem(fv.Burgers(), fv.Grid(0.0, 1.0, cells), lambda x: 1.0 + x[None], 1.0)
    return fv.solve(problem, fv.WavePropagation(fv.Roe()), limits=fv.Limits(steps=3), backend="numpy", throw=False)


def interrupted(x):
    """A run that the user stops, as fv.solve(throw=False) returns it."""
    def stop(stepper):
        raise KeyboardInterrupt

    problem = fv.Problem(fv.Burgers(), fv.Grid(0.0, 1.0, 20), lambda x: 1.0 + x[None], 1.0)
    return fv.solve(problem, fv.WavePropagation(fv.Roe()), observers=[stop], backend="numpy", throw=False)


def sleeps(x):
    time.sleep(x)
    return {"value": x}
