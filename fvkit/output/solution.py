"""`Solution`: output states of a run, with status, statistics, files and plots."""

from html import escape
from pathlib import Path
from typing import TYPE_CHECKING, Any

import attrs

from fvkit.output.results import Results
from fvkit.validation import instance

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from xarray import Dataset

    from fvkit.output.films import Film


@attrs.frozen(eq=False, repr=False)
class Solution(Results):
    """Solution of a problem: states at the output times, with grid, model, status, statistics and configuration.

    Parameters
    ----------
    t : (k,) output times, s, starting with the initial time.
    q : (k, num_eqn, *grid.shape) cell averages. The last state of a failed run is the last accepted one.
    aux : cell averages of the aux functions, {name: grid.shape}.
    grid, model : grid and model of the problem.
    status : `Status` at the end of the run.
    stats : `Stats` of the run.
    message : one sentence: the status, with time and position of a failure.
    configuration : JSON data: model, scheme, boundary, sources, grid and times with all defaults, backend, versions,
        status, statistics, citation. `fvkit.output.configuration.build` restores its objects.

    Examples
    --------
    >>> import fvkit as fv
    >>> import fvkit_granular as gr
    >>> solution = fv.solve(gr.scene("dam-break").problem(gr.ShallowWater, 100), backend="numpy")
    >>> solution.q.shape, solution.status.name, list(solution.observables())
    ((2, 2, 100), 'FINISHED', ['h', 'v', 'surface'])
    """

    def save(self, path: str | Path) -> Path:
        """Save the solution to a file that `fvkit.load` reads bit for bit; an existing file is kept if writing fails.

        Parameters
        ----------
        path : ``.npz`` needs NumPy alone; ``.nc`` is netCDF after CF-1.11 with a variable for every component and
            observable, and needs the extra ``io``.

        Returns
        -------
        pathlib.Path
            ``path``.

        Raises
        ------
        ValueError
            For another file extension.
        ImportError
            For ``.nc`` without the extra.
        """
        from fvkit.output.save import save

        return save(self, path)

    def to_xarray(self) -> "Dataset":
        """Return an ``xarray.Dataset``: components, observables and aux values with units over time and x; with two
        axes over time, y and x.

        Variables have the model's names, made valid ("hs vs" becomes hs_vs, with the attribute original_name); the attribute
        configuration contains the configuration as JSON.

        Raises
        ------
        ImportError
            Without the extra ``io``.
        """
        from fvkit.output.netcdf import dataset

        return dataset(self)

    def plot(self, ax: "Axes | None" = None, i: int = -1, kind: str | None = None, **options: Any) -> "Axes":
        """Plot the solution at output ``i`` and return the axes.

        Parameters
        ----------
        ax : axes to draw on; None for new ones.
        i : number of the output.
        kind : ``"state"`` (all observables, the default), ``"profile"`` (layers above the bottom), ``"depth"`` (layers from 0),
            ``"speeds"`` or ``"margin"``;
            see also `fvkit.output.plots.space_time`. With two axes ``"map"`` (colours of an observable and contours of the
            bottom, the default), ``"vectors"`` (a map with arrows of the velocity) or ``"cut"`` (the layers along a line).
        options : ``enlarge``, the factor of depths above the bottom in ``"profile"`` and ``"cut"``, by default 1, and more where
            the relief would hide the flow; and with two axes ``name``, the observable of all kinds, the first by default, the
            layers for ``"cut"``; ``vector`` that of the arrows, such as ``"vf"``; ``line`` the ends ((x0, y0), (x1, y1)) of
            the cut, m, by default along x through the middle.

        Raises
        ------
        ValueError
            For a kind that does not serve the grid or the model; the message has those that do.
        TypeError
            For ``ax`` that are no axes, such as the name of a file.

        Notes
        -----
        ``solution.plot().figure.savefig("state.pdf")`` writes a picture.
        """
        from matplotlib.axes import Axes

        from fvkit.output.plots import drawing

        if ax is not None:
            instance(ax, "ax", Axes, "of matplotlib; solution.plot().figure.savefig(\"x.pdf\") writes a picture")
        return drawing(self, kind)(self, ax, i, **options)

    def animate(self, path: str | Path, kind: str | None = None, fps: int = 12, ax: "Axes | None" = None,
                **options: Any) -> "Film":
        """Write an animation of all outputs, .gif or (with ffmpeg) .mp4, which notebooks play; kind and options as for `plot`,
        see `fvkit.output.films.animate`."""
        from fvkit.output.films import animate

        return animate(self, path, kind, fps, ax, **options)

    def __repr__(self) -> str:
        grid, stats = self.grid, self.stats
        place = " x ".join(f"[{axis.lower:g}, {axis.upper:g}]" for axis in grid.axes)
        return (f"<Solution of {self.model}, {grid.described} cells on {place} m, "
                f"{len(self.t)} outputs, t = {self.t[0]:g} .. {self.t[-1]:g} s: "
                f"{self.status.name}, {stats.steps} steps ({stats.rejected} rejected), "
                f"{stats.backend}, {stats.seconds:.3g} s>")

    def _repr_html_(self) -> str:
        """Return an HTML table for notebooks: status and statistics of the run."""
        stats = self.stats
        rows = {"model": type(self.model).__name__, "cells": self.grid.described, "t": f"{self.t[-1]:.6g}",
                "outputs": len(self.t), "status": self.message or self.status.value, "backend": stats.backend,
                "steps": f"{stats.steps} ({stats.rejected} rejected)", "stepping": f"{stats.seconds:.3g} s",
                "mass drift": ", ".join(f"{name} {drift:.1e}" for name, drift in stats.mass_drift.items()) or "no masses"}
        return "<table>" + "".join(f"<tr><th>{escape(name)}</th><td>{escape(str(value))}</td></tr>"
                                   for name, value in rows.items()) + "</table>"
