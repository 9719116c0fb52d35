"""`Solution`, its status and statistics."""

from html import escape
from pathlib import Path
from typing import TYPE_CHECKING, Any

import attrs
import numpy as np

from fvkit import validation
from fvkit.output.status import Stats, Status
from fvkit.problem.grid import Grid
from fvkit.problem.model import Model

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from xarray import Dataset


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
        status, statistics, citation. `fvkit.output.configuration.build` makes its parts again.
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
        from fvkit.output.save import save

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
        from fvkit.output.netcdf import dataset

        return dataset(self)

    def plot(self, ax: "Axes | None" = None, i: int = -1, kind: str = "state") -> "Axes":
        """Draw the solution at output ``i``; returns the axes. Kinds are ``"state"`` (all observables), ``"profile"`` (what
        lies on the bottom), ``"speeds"``, ``"margin"``; see also `fvkit.output.plots.space_time`."""
        from fvkit.output.plots import KINDS

        return KINDS[validation.choice(kind, "kind", KINDS)](self, ax, i)

    def animate(self, path: str | Path, kind: str = "state", fps: int = 12, ax: "Axes | None" = None) -> Path:
        """Write a film of all outputs, .gif or (with ffmpeg) .mp4; see `fvkit.output.plots.animate`."""
        from fvkit.output.plots import animate

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


