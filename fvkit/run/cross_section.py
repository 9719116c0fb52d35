"""`CrossSection`: discharge and volume through a line across a flow, or at a place, for ``observers`` of `fvkit.solve`."""

from itertools import pairwise
from typing import Any

import attrs
import numpy as np

from fvkit import validation
from fvkit.problem.answers import mass_flux
from fvkit.problem.grid import Grid
from fvkit.problem.problem import Problem
from fvkit.run.observers import SeriesObserver


def polyline(value: Any, name: str, hint: str = "") -> np.ndarray:
    """Return a polyline, (k, 2), of at least two points; ``hint`` ends what a message allows."""
    points = validation.array(value, name)
    if points.ndim != 2 or points.shape[1] != 2 or len(points) < 2:
        raise ValueError(f"`{name}` must be a list of at least two points (x, y){hint}, got {validation.shown(value)}")
    if (np.hypot(*np.diff(points, axis=0).T) == 0.0).any():
        raise ValueError(f"`{name}` must not have the same point twice in a row, got one that has")
    return points


@attrs.define(eq=False)
class CrossSection(SeriesObserver):
    """Cross-section: discharge of every mass through a line, and the volume that has passed; with one axis at a place x.

    The discharge is the sum of h v . n over the pieces of the line within each cell, of cell averages: accurate to about a cell.
    It is positive for flow from left to right as seen along the line from its first to its last point. With one axis it
    is h v of the cell that contains x, per metre of width and positive along x.

    Parameters
    ----------
    line : points (x, y), m, at least two, within the grid; with one axis a number x.

    Attributes
    ----------
    t : numpy.ndarray
        (k,) times, s, starting with the initial time.
    discharge : dict
        {mass: (k,)}, m^3/s, such as those of "hs" and "hf" of two phases; with one axis m^2/s.
    volume : dict
        {mass: (k,)}, m^3, that has passed by each time, by the trapezoidal rule; with one axis m^2.

    Raises
    ------
    ValueError
        When the run starts, for a line outside the grid, or of the other number of axes, or a model without masses.

    Examples
    --------
    >>> import fvkit as fv
    >>> import fvkit_granular as gr
    >>> grid = fv.Grid((0.0, 0.0), (10.0, 4.0), (20, 8))
    >>> river = fv.Problem(gr.ShallowWater(), grid, lambda x, y: [0.0 * x + 1.0, 0.0 * x + 2.0, 0.0 * x], 0.5)
    >>> line = fv.CrossSection([(5.0, 4.0), (5.0, 0.0)])  # downwards: its left is in the east
    >>> solution = fv.solve(river, backend="numpy", observers=line)
    >>> print(f"{line.discharge['h'][-1]:.6f} {line.volume['h'][-1]:.6f}")
    -8.000000 -4.000000
    """

    line: Any = attrs.field(converter=lambda value: validation.real(value, "line") if validation.is_single(value) else
                            polyline(value, "line", ", with one axis a place x"))
    _pieces: Any = attrs.field(default=None, init=False, repr=False)
    _names: tuple[str, ...] = attrs.field(default=(), init=False, repr=False)

    def begin(self, problem: Problem) -> None:
        super().begin(problem)
        if isinstance(self.line, float) != (len(problem.grid.axes) == 1):
            raise ValueError("a CrossSection is a number x on a grid with one axis, a line of points (x, y) on one with two, got "
                             f"{validation.shown(self.line)} on a grid with {len(problem.grid.axes)}")
        if not problem.model.phases:
            raise ValueError(f"a CrossSection counts masses, but {type(problem.model).__name__} has no `phases`")
        called = "`line` of a CrossSection"
        self._pieces = (problem.grid.cells_at([self.line], called), np.ones((1, 1))) if isinstance(self.line, float) else \
            cells_along(self.line, problem.grid, called)
        self._names = tuple(problem.conserved[row] for row in problem.mass_rows)

    def see(self, problem: Problem, t: float, q: np.ndarray) -> None:
        cells, normals = self._pieces
        here = q.reshape(len(q), -1)[:, cells]
        through = np.zeros(len(self._names))
        for direction, normal in zip(problem.directions, normals, strict=True):
            flux = mass_flux(direction.model, tuple(here[list(direction.rows)]))
            through += [float(normal @ flux[row]) for row in direction.model.mass_rows()]
        self.add(t, dict(zip(self._names, through, strict=True)))

    @property
    def discharge(self) -> dict[str, np.ndarray]:
        """Discharge of every mass, {name: (k,)}, m^3/s."""
        return {name: self.column(name) for name in self._names}

    @property
    def volume(self) -> dict[str, np.ndarray]:
        """Volume of every mass that has passed, {name: (k,)}, m^3."""
        steps = np.diff(self.t)
        return {name: np.concatenate([[0.0], np.cumsum(0.5 * steps * (q[1:] + q[:-1]))]) for name, q in self.discharge.items()}


def cells_along(line: np.ndarray, grid: Grid, called: str) -> tuple[np.ndarray, np.ndarray]:
    """Return the cells that a line passes through, (k,), and the normal of its piece in each times its length, (2, k), m."""
    cells, normals = [], []
    for start, end in pairwise(line):
        way = end - start
        cuts = [np.array([0.0, 1.0])]
        for axis, first, step in zip(grid.axes, start, way, strict=True):
            if step != 0.0:
                shares = (axis.edges - first) / step
                cuts.append(shares[(shares > 0.0) & (shares < 1.0)])
        shares = np.unique(np.concatenate(cuts))
        middles = start + 0.5 * (shares[1:] + shares[:-1])[:, None] * way
        grid.cells_at([start, end], called)
        cells.append(grid.cells_at(middles, called))
        normals.append(np.array([[way[1]], [-way[0]]]) * np.diff(shares))
    return np.concatenate(cells), np.concatenate(normals, axis=1)
