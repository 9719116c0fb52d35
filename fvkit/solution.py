"""`Solution`, its status and statistics."""

from enum import Enum
from html import escape
from pathlib import Path
from typing import TYPE_CHECKING, Any

import attrs
import numpy as np

from fvkit import _validate
from fvkit.errors import Portable
from fvkit.grid import Grid
from fvkit.model import Model

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from xarray import Dataset


class Status(Enum):
    """How a run ended; the value is the sentence."""

    FINISHED = "the end time was reached"
    MAX_STEPS = "the number of steps reached max_steps before the end time"
    STOPPED = "the run was stopped by its rule"
    OVER_BUDGET = "the stepping took longer than the given `seconds`"
    DT_TOO_SMALL = "the time step became too small: the speeds grow without bound"
    DT_TOO_LARGE = "the given `dt` is longer than the Courant number of the scheme allows: give a shorter one, or `dt_max`"
    NON_FINITE = "a state became infinite or not a number"
    WRONG_SPEED = "a wave speed is infinite or not a number, or 0 where the state moves: `wave_speeds` of the model is wrong"
    NEGATIVE_DEPTH = "a mass became negative"
    INADMISSIBLE = "a state left what the model allows"
    INTERRUPTED = "the run was interrupted"
    ERROR = "an exception ended the run"
    NONHYPERBOLIC = "the characteristic speeds became complex, and nonhyperbolic='raise' was asked for"


@attrs.frozen
class Stats:
    """Statistics of a run.

    Parameters
    ----------
    steps, rejected : accepted and rejected steps.
    cell_updates : cells x (accepted + rejected steps).
    seconds, compile_seconds : wall time of the stepping, and of compilation.
    max_cfl : largest Courant number of an accepted step.
    backend : the one that ran.
    repaired_cells : cells whose negative mass was set to zero (never in silence).
    nonhyperbolic_faces : (face, step) pairs whose Roe mean has complex speeds.
    nonhyperbolic_films : those of them on both sides of which the flow is shallower than 5 cm.
    deepest_nonhyperbolic : depth of the deepest of them, m, to a micrometre; 0 for models that name no depth.
    mass_drift : {mass: relative change that neither boundary fluxes nor sources explain}; relative to all mass where that
        component starts at zero.
    entered_by_sources : {mass: what sources such as rain brought, less what they took}, integrated over the grid.
    """

    steps: int
    rejected: int
    cell_updates: int
    seconds: float
    compile_seconds: float
    max_cfl: float
    backend: str
    repaired_cells: int
    nonhyperbolic_faces: int
    mass_drift: dict[str, float]
    nonhyperbolic_films: int = 0
    deepest_nonhyperbolic: float = 0.0
    entered_by_sources: dict[str, float] = attrs.field(factory=dict)

    @property
    def ns_per_cell_step(self) -> float:
        """Wall time per cell and step, nanoseconds."""
        return 1e9 * self.seconds / self.cell_updates if self.cell_updates else 0.0


@attrs.frozen(eq=False, repr=False)
class Solution:
    """States at the output times, with all that is needed to read them.

    Parameters
    ----------
    t : (k,) times, s, the start first.
    q : (k, num_eqn, num_cells) cell averages. A failed run ends with the last accepted state.
    aux : {name: (num_cells,)}.
    grid, model : where and what.
    status : `Status`; ``success``: it reached its end, or where ``stop`` told it to.
    stats : `Stats`.
    message : one sentence: how the run ended, and where if it failed.
    configuration : plain data: model, scheme, boundary, sources, grid and times with all defaults, backend, versions,
        status, statistics, citation. `fvkit.configuration.build` makes its parts again.
    """

    t: np.ndarray
    q: np.ndarray
    aux: dict[str, np.ndarray]
    grid: Grid
    model: Model
    status: Status
    stats: Stats
    message: str = ""
    configuration: dict[str, Any] = attrs.field(factory=dict)

    @property
    def success(self) -> bool:
        """Whether the run reached its end, or the point where ``stop`` told it to stop."""
        return self.status in (Status.FINISHED, Status.STOPPED)

    def observables(self, i: int = -1) -> dict[str, np.ndarray]:
        """What a person looks at, {name: (num_cells,)}, at output ``i``."""
        return self.model.observables(self.q[i], self.aux)

    def hyperbolicity_margin(self, i: int = -1) -> np.ndarray:
        """How far the speeds are from turning complex at output ``i``, (num_cells,): negative where they are."""
        return self.model.hyperbolicity_margin(self.q[i])

    def hyperbolicity_map(self) -> np.ndarray:
        """`hyperbolicity_margin` of every output, (k, num_cells): where and when the problem is ill-posed."""
        return np.array([self.model.hyperbolicity_margin(q) for q in self.q])

    def save(self, path: str | Path) -> Path:
        """Write everything to a file that `fvkit.load` reads bit for bit; an existing file survives any failure.

        Parameters
        ----------
        path : ``.npz`` needs nothing more; ``.nc`` is netCDF after CF-1.11 with a variable for every component and
            observable, for any reader of netCDF, and needs the extra ``io``.

        Returns
        -------
        pathlib.Path
            ``path``.

        Raises
        ------
        ValueError
            For another ending.
        ImportError
            For ``.nc`` without the extra.
        """
        from fvkit.storage import save

        return save(self, path)

    def to_xarray(self) -> "Dataset":
        """Return an ``xarray.Dataset``: components, observables and aux values with units over time and x.

        Names are those of the model, made valid ("hs vs" is hs_vs, with the attribute original_name); the attribute
        configuration is the whole configuration as JSON.

        Raises
        ------
        ImportError
            Without the extra ``io``.
        """
        from fvkit.netcdf import dataset

        return dataset(self)

    def plot(self, ax: "Axes | None" = None, i: int = -1, kind: str = "state") -> "Axes":
        """Draw the solution at output ``i``; returns the axes. Kinds are ``"state"`` (all observables), ``"profile"`` (what
        lies on the bottom), ``"speeds"``, ``"margin"``; see also `fvkit.pictures.space_time`."""
        from fvkit.pictures import KINDS

        return KINDS[_validate.choice(kind, "kind", KINDS)](self, ax, i)

    def animate(self, path: str | Path, kind: str = "state", fps: int = 12, ax: "Axes | None" = None) -> Path:
        """Write a film of all outputs, .gif or (with ffmpeg) .mp4; see `fvkit.pictures.animate`."""
        from fvkit.pictures import animate

        return animate(self, path, kind, fps, ax)

    def __repr__(self) -> str:
        grid, stats = self.grid, self.stats
        return (f"<Solution of {self.model}, {grid.num_cells} cells on [{grid.lower:g}, {grid.upper:g}] m, "
                f"{len(self.t)} outputs, t = {self.t[0]:g} .. {self.t[-1]:g} s: "
                f"{self.status.name}, {stats.steps} steps ({stats.rejected} rejected), "
                f"{stats.backend}, {stats.seconds:.3g} s>")

    def _repr_html_(self) -> str:
        """What a notebook shows: how the run ended, and its statistics."""
        stats = self.stats
        rows = {"model": type(self.model).__name__, "cells": self.grid.num_cells, "t": f"{self.t[-1]:.6g}",
                "outputs": len(self.t), "status": self.message or self.status.value, "backend": stats.backend,
                "steps": f"{stats.steps} ({stats.rejected} rejected)", "stepping": f"{stats.seconds:.3g} s",
                "mass drift": ", ".join(f"{name} {drift:.1e}" for name, drift in stats.mass_drift.items())}
        return "<table>" + "".join(f"<tr><th>{escape(name)}</th><td>{escape(str(value))}</td></tr>"
                                   for name, value in rows.items()) + "</table>"


class SolveError(Portable, RuntimeError):
    """A run that failed, with the partial solution.

    Parameters
    ----------
    status : `Status`.
    time, cell, x : when, s, and where; the cell is -1 where no cell is to blame.
    state : the offending state of that cell, (num_eqn,).
    step : number of the step that failed.
    names : of the components of the state.
    solution : the partial `Solution`; None when a `Stepper` was driven by hand.
    """

    def __init__(self, status: Status, time: float, cell: int, x: float, state: np.ndarray, step: int,
                 names: tuple[str, ...]) -> None:
        self.status, self.time, self.cell, self.x, self.state, self.step = status, time, cell, x, state, step
        self.solution: Any = None
        values = ", ".join(f"{name} = {value:.6g}" for name, value in zip(names, state, strict=True))
        at = f" in cell {cell} (x = {x:.6g}): {values}" if cell >= 0 else ""
        super().__init__(f"{status.value}, at t = {time:.8g}, step {step}{at}")


class Interrupted(SolveError, KeyboardInterrupt):
    """A run that the user stopped (Ctrl-C): a `SolveError` with the partial solution, and a KeyboardInterrupt."""
