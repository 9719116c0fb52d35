"""`RunOut`: farthest position of a flow along a path line, for ``observers`` of `fvkit.solve`."""

from typing import Any

import attrs
import numpy as np

from fvkit import Problem
from fvkit.run.cross_section import cells_along, polyline
from fvkit.run.observers import SeriesObserver
from fvkit.validation import number


@attrs.define(eq=False)
class RunOut(SeriesObserver):
    """Run-out: the farthest place along a path line, such as a thalweg, where the flow is deeper than a threshold, over time.

    Only cells on the line count, so the line must follow the flow. A place is the middle of the line within its cell, accurate
    to about half a cell. Grids with two axes; with one see `Front`.

    Parameters
    ----------
    path : points (x, y), m, at least two, in the direction of the flow, within the grid; see `read_path`.
    threshold : depth, m, from which on the flow counts.

    Attributes
    ----------
    length : float
        Length of the line on the map, m.
    t : numpy.ndarray
        (k,) times, s, starting with the initial time.
    distance : numpy.ndarray
        (k,) distance along the line from its first point, on the map, m; NaN where no cell is deep enough.
    farthest : float
        Largest distance at any time, m; NaN where there was none.

    Raises
    ------
    ValueError
        When the run starts, for a line outside the grid, a grid with one axis, or a model without a depth.

    Examples
    --------
    >>> import fvkit as fv
    >>> import fvkit_granular as gr
    >>> dam = lambda x, y: {"h": 1.0 * (x < 5.0), "phi": 0.5}
    >>> scene = gr.Scene(((0.0, 0.0), (20.0, 4.0)), 1.0, dam, boundary=fv.Wall())
    >>> run_out = gr.RunOut([(0.0, 2.0), (20.0, 2.0)], threshold=0.05)
    >>> solution = fv.solve(scene.problem(gr.ShallowWater, (40, 8)), backend="numpy", observers=run_out)
    >>> float(run_out.distance[0]), bool(8.0 < run_out.farthest < 12.0)
    (4.75, True)
    """

    path: np.ndarray = attrs.field(converter=lambda value: polyline(value, "path"))
    threshold: float = number(0.1, above=0.0)
    _places: Any = attrs.field(default=None, init=False, repr=False)

    def begin(self, problem: Problem) -> None:
        super().begin(problem)
        if len(problem.grid.axes) != 2:
            raise ValueError("a RunOut follows a line across a grid with two axes, got a grid with one: take gr.Front")
        if not callable(getattr(problem.model, "depth", None)):
            raise ValueError(f"a RunOut needs a model with a depth, {type(problem.model).__name__} defines no `depth(q)`")
        cells, normals = cells_along(self.path, problem.grid, "`path` of a RunOut")
        lengths = np.hypot(*normals)
        self._places = cells, np.cumsum(lengths) - 0.5 * lengths

    def see(self, problem: Problem, t: float, q: np.ndarray) -> None:
        cells, places = self._places
        model: Any = problem.model
        here = q.reshape(len(q), -1)[:, cells]
        deep = model.depth(tuple(here[row] for row in problem.directions[0].rows)) >= self.threshold
        self.add(t, {"distance": float(places[deep][-1]) if deep.any() else np.nan})

    @property
    def length(self) -> float:
        """Length of the line on the map, m."""
        return float(np.hypot(*np.diff(self.path, axis=0).T).sum())

    @property
    def distance(self) -> np.ndarray:
        """Farthest distance along the line at each time, (k,), m."""
        return self.column("distance")

    @property
    def farthest(self) -> float:
        """Largest distance at any time, m."""
        return float(np.nanmax(self.distance)) if np.isfinite(self.distance).any() else np.nan

    @property
    def reaches_end(self) -> bool:
        """Whether the flow came to the last cell of the line, and so may have gone farther."""
        return self._places is not None and self.farthest >= self._places[1][-1]

    def __str__(self) -> str:
        if np.isnan(self.farthest):
            return f"run-out: the flow was never deeper than {self.threshold:g} m on the path"
        when = float(self.t[np.nanargmax(self.distance)])
        end = self.distance[-1]
        last = "nothing on it at the end" if np.isnan(end) else f"{end:.6g} m at the end"
        return (f"run-out along the path: {self.farthest:.6g} m of its {self.length:.6g} m, first at {when:.4g} s; {last} "
                f"(deeper than {self.threshold:g} m)")
