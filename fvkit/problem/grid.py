"""`Grid` and its `Axis`: intervals cut into equal cells."""

from math import prod

import attrs
import numpy as np

from fvkit.validation import integer, number


@attrs.frozen
class Axis:
    """A direction of a grid: ``num_cells`` equal cells on [lower, upper].

    Parameters
    ----------
    lower, upper : ends of the interval, m, lower < upper.
    num_cells : number of cells, at least 1.

    Raises
    ------
    ValueError, TypeError
        If an end is not finite, the interval is empty or reversed, ``num_cells`` is not a whole number, or so large that
        cells cannot be told apart.
    """

    lower: float = number()
    upper: float = number()
    num_cells: int = integer(at_least=1, hint="the number of cells")

    def __attrs_post_init__(self) -> None:
        if not self.lower < self.upper:
            raise ValueError(f"`lower` must be < `upper`, got {self.lower:g} and {self.upper:g}: exchange them?")
        if not np.isfinite(self.upper - self.lower):
            raise ValueError(f"`upper` - `lower` must be finite, got {self.lower:g} and {self.upper:g}")
        if not self.dx > np.spacing(max(abs(self.lower), abs(self.upper))):
            raise ValueError(f"`num_cells` must leave cells that differ in x, got {self.num_cells} on [{self.lower:g}, "
                             f"{self.upper:g}], {self.dx:.3g} m each, which is below rounding: take fewer cells")

    @property
    def dx(self) -> float:
        """Width of a cell, m."""
        return (self.upper - self.lower) / self.num_cells

    @property
    def edges(self) -> np.ndarray:
        """Cell edges, (num_cells + 1,)."""
        return np.linspace(self.lower, self.upper, self.num_cells + 1)

    @property
    def centers(self) -> np.ndarray:
        """Cell centres, (num_cells,)."""
        edges = self.edges
        return 0.5 * (edges[:-1] + edges[1:])


@attrs.frozen
class Grid:
    """A uniform grid of ``num_cells`` cells on [lower, upper].

    Parameters
    ----------
    lower, upper : ends of the interval, m, lower < upper.
    num_cells : number of cells, at least 1.

    Attributes
    ----------
    axes : tuple of Axis
        The directions of the grid.

    Raises
    ------
    ValueError, TypeError
        As `Axis`.

    Examples
    --------
    >>> import fvkit as fv
    >>> grid = fv.Grid(0.0, 10.0, 50)
    >>> grid.shape, grid.cell_volume, float(grid.centers[0])
    ((50,), 0.2, 0.1)
    """

    lower: float = number()
    upper: float = number()
    num_cells: int = integer(at_least=1, hint="the number of cells")
    axes: tuple[Axis, ...] = attrs.field(init=False, repr=False, eq=False)

    def __attrs_post_init__(self) -> None:
        object.__setattr__(self, "axes", (Axis(self.lower, self.upper, self.num_cells),))

    @property
    def shape(self) -> tuple[int, ...]:
        """Shape of an array of cells: the number of cells of each axis, the last axis first."""
        return tuple(axis.num_cells for axis in self.axes[::-1])

    @property
    def cell_volume(self) -> float:
        """Length of a cell, m."""
        return prod(axis.dx for axis in self.axes)

    @property
    def dx(self) -> float:
        """Width of a cell, m."""
        return self.axes[0].dx

    @property
    def edges(self) -> np.ndarray:
        """Cell edges, (num_cells + 1,)."""
        return self.axes[0].edges

    @property
    def centers(self) -> np.ndarray:
        """Cell centres, (num_cells,)."""
        return self.axes[0].centers
