"""fvkit: a pluggable finite-volume framework for one-dimensional hyperbolic systems.

>>> import fvkit as fv
>>> import numpy as np
>>> problem = fv.Problem(fv.Burgers(), fv.Grid(0.0, 1.0, 100), lambda x: np.sin(2 * np.pi * x)[None], t_end=0.1,
...                      boundary=fv.Periodic())
>>> solution = fv.solve(problem, fv.WavePropagation(fv.Roe()))
>>> solution.success
True
"""

from importlib import import_module
from typing import Any

from fvkit.boundary import BoundaryCondition, Inflow, Outflow, Periodic, Wall
from fvkit.checkpoint import Checkpoint
from fvkit.contract import PointwiseError
from fvkit.grid import Grid
from fvkit.integrators import ARK4, DP5, SSPRK3, SSPRK104, Integrator
from fvkit.limiters import MC, Limiter, Minmod, NoLimiter, Superbee, ThirdOrder, VanLeer
from fvkit.model import Model
from fvkit.models import Acoustics, Advection, Burgers
from fvkit.observers import Extremes, Gauge, Observer
from fvkit.pointwise import maximum, minimum, where
from fvkit.problem import Problem
from fvkit.reconstruction import MP5, MUSCL, WENO5, Reconstruction
from fvkit.resume import resume
from fvkit.riemann import HLL, PyClawRiemann, RiemannSolver, Roe, Rusanov
from fvkit.schemes import MethodOfLines, Scheme, WavePropagation
from fvkit.solution import Interrupted, Solution, SolveError, Stats, Status
from fvkit.solve import rhs, solve
from fvkit.sources import Forcing, Godunov, Source, Splitting, Strang
from fvkit.stepper import Stepper
from fvkit.stopping import Stop, StopAtRest
from fvkit.storage import load
from fvkit.study.convergence import convergence
from fvkit.study.orders import Convergence, OrderError
from fvkit.sweeps import Keep, Samples, SweepResult, sweep

__version__ = "0.1.0"

__all__ = [
    "ARK4",
    "DP5",
    "HLL",
    "MC",
    "MP5",
    "MUSCL",
    "SSPRK3",
    "SSPRK104",
    "WENO5",
    "Acoustics",
    "Advection",
    "BoundaryCondition",
    "Burgers",
    "Checkpoint",
    "Convergence",
    "Extremes",
    "Forcing",
    "Gauge",
    "Godunov",
    "Grid",
    "Inflow",
    "Integrator",
    "Interrupted",
    "Keep",
    "Limiter",
    "MethodOfLines",
    "Minmod",
    "Model",
    "NoLimiter",
    "Observer",
    "OrderError",
    "Outflow",
    "Periodic",
    "PointwiseError",
    "Problem",
    "PyClawRiemann",
    "Reconstruction",
    "RiemannSolver",
    "Roe",
    "Rusanov",
    "Samples",
    "Scheme",
    "Solution",
    "SolveError",
    "Source",
    "Splitting",
    "Stats",
    "Status",
    "Stepper",
    "Stop",
    "StopAtRest",
    "Strang",
    "Superbee",
    "SweepResult",
    "ThirdOrder",
    "VanLeer",
    "Wall",
    "WavePropagation",
    "convergence",
    "load",
    "maximum",
    "minimum",
    "resume",
    "rhs",
    "solve",
    "sweep",
    "where",
]


def __getattr__(name: str) -> Any:
    """`fvkit.testing` on first use: it needs pytest, which a run does not."""
    if name == "testing":
        return import_module("fvkit.testing")
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
