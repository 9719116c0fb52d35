"""fvkit: a pluggable finite-volume framework for hyperbolic systems in one and two dimensions.

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

from fvkit.output.citation import VERSION
from fvkit.output.load import load
from fvkit.output.save import save
from fvkit.output.solution import Solution
from fvkit.output.status import Interrupted, SolveError, Stats, Status
from fvkit.pointwise import maximum, minimum, rarely, where
from fvkit.pointwise.contract import PointwiseError
from fvkit.problem.boundary import BoundaryCondition, Periodic, Wall
from fvkit.problem.grid import Grid
from fvkit.problem.model import Model, Phase
from fvkit.problem.open_ends import Inflow, Outflow
from fvkit.problem.problem import Problem
from fvkit.problem.side import Along
from fvkit.problem.sources import Forcing, Source
from fvkit.problem.teaching_models import Acoustics, Advection, Burgers
from fvkit.run.checkpoint import Checkpoint
from fvkit.run.control import Limits
from fvkit.run.cross_section import CrossSection
from fvkit.run.observers import Extremes, Gauge, Observer
from fvkit.run.recording import Stream
from fvkit.run.resume import resume
from fvkit.run.rhs import rhs
from fvkit.run.solve import solve
from fvkit.run.step_bounds import Step
from fvkit.run.stepper import Stepper
from fvkit.run.stopping import Stop, StopAtRest
from fvkit.schemes.integrators import ARK4, DP5, SSPRK3, SSPRK104, Integrator
from fvkit.schemes.limiters import MC, Limiter, Minmod, NoLimiter, Superbee, ThirdOrder, VanLeer
from fvkit.schemes.method_of_lines import MethodOfLines
from fvkit.schemes.reconstruction import MP5, MUSCL, WENO5, Reconstruction
from fvkit.schemes.riemann import HLL, PyClawRiemann, RiemannSolver, Roe, Rusanov
from fvkit.schemes.scheme import Scheme
from fvkit.schemes.splitting import Godunov, Splitting, Strang
from fvkit.schemes.wave_propagation import WavePropagation
from fvkit.studies.compare import compare
from fvkit.studies.convergence import convergence
from fvkit.studies.orders import Convergence, OrderError
from fvkit.sweeps import Keep, Samples, SweepResult, sweep

__version__ = VERSION

__all__ = [
    "ARK4", "DP5", "HLL", "MC", "MP5", "MUSCL", "SSPRK3", "SSPRK104", "WENO5", "Acoustics", "Advection", "Along",
    "BoundaryCondition", "Burgers", "Checkpoint", "Convergence", "CrossSection", "Extremes", "Forcing", "Gauge", "Godunov",
    "Grid", "Inflow", "Integrator", "Interrupted", "Keep", "Limiter", "Limits", "MethodOfLines", "Minmod", "Model",
    "NoLimiter", "Observer", "OrderError", "Outflow", "Periodic", "Phase", "PointwiseError", "Problem", "PyClawRiemann",
    "Reconstruction", "RiemannSolver", "Roe", "Rusanov", "Samples", "Scheme", "Solution", "SolveError", "Source", "Splitting",
    "Stats", "Status", "Step", "Stepper", "Stop", "StopAtRest", "Strang", "Stream", "Superbee", "SweepResult", "ThirdOrder",
    "VanLeer", "Wall", "WavePropagation", "compare", "convergence", "load", "maximum", "minimum", "rarely", "resume", "rhs",
    "save", "solve", "sweep", "where",
]


def __getattr__(name: str) -> Any:
    """`fvkit.testing` on first use: it needs pytest, which a run does not."""
    if name == "testing":
        return import_module("fvkit.testing")
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
