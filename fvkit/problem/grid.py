"""`Grid` and its `Axis`: intervals and rectangles cut into equal cells."""

from math import prod
from typing import Any, NamedTuple

import attrs
import numpy as np

from fvkit.validation import field, integer, number, per_axis, real, whole

#: Names of the axes of a grid.
NAMES = ("x", "y")


class Side(NamedTuple):
    """A side of a grid: the lower or the upper end of an axis."""

    axis: int
    upper: bool

    @property
    def outwards(self) -> float:
        """1 where the axis leads out of the grid, else -1."""
        return 1.0 if self.upper else -1.0

    def inwards(self, values: np.ndarray) -> np.ndarray:
        """Return the values of the cells along the axis (..., n), from this side on."""
        return values[..., ::-1] if self.upper else values


@attrs.frozen
class Axis:
    """A direction of a grid: ``num_cells`` >= 1 equal cells on [lower, upper], m."""

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
    def digits(self) -> int:
        """Digits that a centre of a cell needs in words, at least 6: on maps coordinates are large beside cells."""
        return max(6, int(np.ceil(np.log10(max(abs(self.lower), abs(self.upper)) / self.dx))) + 2)

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
    """A uniform grid: equal cells on an interval, or equal rectangles on a rectangle.

    Parameters
    ----------
    lower, upper : ends of the interval, m, lower < upper; with two axes pairs (x, y).
    num_cells : number of cells, at least 1; with two axes a pair (nx, ny).

    Attributes
    ----------
    axes : tuple of Axis
        The directions of the grid, x first.

    Raises
    ------
    ValueError, TypeError
        If an end is not finite, an interval is empty or reversed, a number of cells is not whole, or so large that cells
        cannot be told apart, or one argument is a pair and another is not.

    Examples
    --------
    >>> import fvkit as fv
    >>> grid = fv.Grid(0.0, 10.0, 50)
    >>> grid.shape, grid.cell_volume, float(grid.centers[0])
    ((50,), 0.2, 0.1)
    >>> fv.Grid((0.0, 0.0), (10.0, 4.0), (50, 10)).shape
    (10, 50)
    """

    lower: Any = field(per_axis, each=real, hint="a number in m")
    upper: Any = field(per_axis, each=real, hint="a number in m")
    num_cells: Any = field(per_axis, each=whole, at_least=1, hint="the number of cells")
    axes: tuple[Axis, ...] = attrs.field(init=False, repr=False, eq=False)

    def __attrs_post_init__(self) -> None:
        given = (self.lower, self.upper, self.num_cells)
        pairs = [isinstance(item, tuple) for item in given]
        if any(pairs) != all(pairs):
            raise TypeError("`lower`, `upper` and `num_cells` must be three numbers, or three pairs (x, y) for two axes, got "
                             f"Grid({self.lower}, {self.upper}, {self.num_cells})")
        axes = zip(*given, strict=True) if all(pairs) else (given,)
        object.__setattr__(self, "axes", tuple(Axis(*one) for one in axes))

    @property
    def shape(self) -> tuple[int, ...]:
        """Shape of an array of cells: the number of cells of each axis, the last axis first."""
        return tuple(axis.num_cells for axis in self.axes[::-1])

    @property
    def size(self) -> int:
        """Number of all cells."""
        return prod(self.shape)

    @property
    def cell_volume(self) -> float:
        """Length of a cell, m; with two axes its area, m^2."""
        return prod(axis.dx for axis in self.axes)

    def place(self, cell: int) -> tuple[float, ...]:
        """Return the centre of a cell, m, from its number in arrays of cells: x, or x and y."""
        here = np.unravel_index(cell, self.shape)[::-1]
        return tuple(float(axis.centers[k]) for axis, k in zip(self.axes, here, strict=True))

    def cells_at(self, places: Any, name: str) -> np.ndarray:
        """Return the numbers of the cells that contain places, (k,), in arrays of cells; ValueError, with ``name``, outside.

        Parameters
        ----------
        places : (k,) values of x, m; with two axes (k, 2) pairs (x, y).
        name : what to call them in messages.
        """
        given = np.asarray(places, dtype=float)
        if given.shape[1:] != (len(self.axes),)[:len(self.axes) - 1]:
            wanted = "numbers x, for a grid with one axis" if len(self.axes) == 1 else "pairs (x, y), for a grid with two axes"
            raise ValueError(f"{name} must be a list of {wanted}, got an array of shape {given.shape}")
        columns = given.reshape(len(given), len(self.axes)).T
        for axis, values in zip(self.axes, columns, strict=True):
            outside = values[(values < axis.lower) | (values > axis.upper)]
            if len(outside):
                raise ValueError(f"{name} must be within [{axis.lower:g}, {axis.upper:g}], got {outside[0]:g}")
        return np.ravel_multi_index(self.index(*columns), self.shape)

    def index(self, *places: Any) -> tuple[np.ndarray, ...]:
        """Return the indices, in arrays of cells, of the cells that contain places x, or x and y; outside, of the nearest."""
        return tuple(np.clip(np.searchsorted(axis.edges, x, side="right") - 1, 0, axis.num_cells - 1)
                     for axis, x in zip(self.axes, places, strict=True))[::-1]

    @property
    def described(self) -> str:
        """How many cells it has, in words, such as "100 x 40"."""
        return " x ".join(str(axis.num_cells) for axis in self.axes)

    def located(self, cell: int) -> str:
        """Return the place of a cell in words, such as "x = 2.5, y = 1", with as many digits as distinguish cells."""
        return ", ".join(f"{name} = {value:.{axis.digits}g}"
                         for name, axis, value in zip(NAMES, self.axes, self.place(cell), strict=False))

    @property
    def _only(self) -> Axis:
        if len(self.axes) > 1:
            raise AttributeError("a grid with two axes has `dx`, `edges` and `centers` of each: grid.axes[0].dx")
        return self.axes[0]

    @property
    def dx(self) -> float:
        """Width of a cell, m; of a grid with one axis."""
        return self._only.dx

    @property
    def edges(self) -> np.ndarray:
        """Cell edges, (num_cells + 1,); of a grid with one axis."""
        return self._only.edges

    @property
    def centers(self) -> np.ndarray:
        """Cell centres, (num_cells,); of a grid with one axis."""
        return self._only.centers
