"""`Terrain`: an elevation raster as cells of a grid, with its cells without data and its coordinate reference system."""

import warnings
from functools import partial
from typing import Any

import attrs
import numpy as np

from fvkit import validation
from fvkit.problem.grid import Grid
from fvkit_granular import csv_table
from fvkit_granular.terrain import crs as systems
from fvkit_granular.terrain import relief, resample

#: Share of a cell by which two grids may differ and still be the same.
SAME = 1e-3

#: How arrays of cells are compared: NaN equals NaN.
SAME_CELLS = attrs.cmp_using(eq=partial(np.array_equal, equal_nan=True))


def _two_axes(value: Any, name: str) -> Grid:
    grid: Grid = validation.instance(value, name, Grid, "such as fv.Grid((0.0, 0.0), (100.0, 50.0), (20, 10))")
    if len(grid.axes) != 2:
        raise ValueError(f"`{name}` must have two axes, x and y, got {grid}: give pairs (x, y)")
    return grid


def _heights(value: Any, name: str) -> np.ndarray:
    heights = validation.floats(np.ma.filled(value, np.nan) if isinstance(value, np.ma.MaskedArray) else value, name)
    heights.flags.writeable = False
    return heights


def _mask(value: Any, name: str) -> np.ndarray:
    given = np.asarray(value)
    if given.dtype != bool:
        raise TypeError(f"`{name}` must be an array of True and False, got {validation.shown(value)}")
    return given


@attrs.frozen(repr=False)
class Terrain:
    """Terrain: elevation of the ground in the cells of a grid, a digital elevation model (DEM). `read_terrain` reads a file.

    Parameters
    ----------
    grid : grid with two axes, m; y ascends, as in all arrays of fvkit, so the first row is the south.
    bottom : (ny, nx) elevation of the ground, the average of each cell, m; NaN where there is no data.
    missing : (ny, nx) bool, cells without data; None for those where ``bottom`` is NaN. Their ``bottom`` becomes NaN: they have
        no height.
    crs : coordinate reference system as a text, such as WKT or "EPSG:31287", kept as it is; None where it is not known.
    name : what reports call it.

    Raises
    ------
    ValueError, TypeError
        If shapes differ, no cell has data, an elevation is infinite or not one on Earth, or the CRS counts in degrees or feet.

    Examples
    --------
    >>> import numpy as np
    >>> import fvkit as fv, fvkit_granular as gr
    >>> grid = fv.Grid((0.0, 0.0), (40.0, 20.0), (4, 2))
    >>> terrain = gr.Terrain(grid, [[9.0, 6.0, 3.0, 0.0], [9.0, 6.0, np.nan, 0.0]], name="ramp")
    >>> terrain
    Terrain('ramp': 4 x 2 cells of 10 m, 0 to 9 m, 1 without data)
    >>> print(terrain.slopes())
    steepest 16.7 degrees at x = 5, y = 5; 85.7% over 10, 0.0% over 30, 0.0% over 45 degrees
    >>> terrain.coarser(20.0).bottom
    array([[7.5, 1. ]])
    """

    grid: Any = validation.field(_two_axes)
    bottom: Any = validation.field(_heights, eq=SAME_CELLS)
    missing: Any = validation.field(_mask, None, optional=True, eq=SAME_CELLS)
    crs: Any = validation.field(validation.text, None, optional=True)
    name: str = validation.words("terrain")

    def __attrs_post_init__(self) -> None:
        shape = self.grid.shape
        validation.array(np.nan_to_num(self.bottom, posinf=np.inf, neginf=-np.inf), "bottom", shape)
        none = np.isnan(self.bottom)
        if self.missing is not None:
            if self.missing.shape != shape:
                raise ValueError(f"`missing` must have shape {shape}, got {self.missing.shape}")
            none = none | self.missing
            object.__setattr__(self, "bottom", _heights(np.where(none, np.nan, self.bottom), "bottom"))
        none.flags.writeable = False
        object.__setattr__(self, "missing", none)
        systems.in_metres(self.crs, f"terrain {self.name!r}")
        self._check_heights()

    def _check_heights(self) -> None:
        known = self.bottom[~self.missing]
        if not known.size:
            raise ValueError(f"terrain {self.name!r} must have a cell with data, got none in {self.grid.described}: look at its "
                             "no-data value, and whether a window lies where it has data")
        strange = csv_table.missing(known) | (known < csv_table.EARTH[0]) | (known > csv_table.EARTH[1])
        if strange.any():
            cell = int(np.flatnonzero(~self.missing)[np.argmax(strange)])
            raise ValueError(f"terrain {self.name!r} must have elevations in m, got {known[np.argmax(strange)]:.10g} at "
                             f"{self.grid.located(cell)}, which looks like a code for no data: give it as the no-data value")

    def warn_of_units(self) -> None:
        """Warn where elevations and sizes look like different units."""
        height = float(np.nanmax(self.bottom) - np.nanmin(self.bottom))
        length = max(axis.upper - axis.lower for axis in self.grid.axes)
        looks = csv_table.implausible(self.bottom[~self.missing], length)
        if looks:
            advice = ("coordinates may be in km or degrees, or elevations in cm or mm" if looks == "steep"
                      else "elevations may be in km")
            warnings.warn(f"terrain {self.name!r} rises by {height:.4g} m over {length:.4g} m: {advice}; both must be in m",
                          RuntimeWarning, stacklevel=3)

    @property
    def range(self) -> tuple[float, float]:
        """Lowest and highest elevation, m."""
        return float(np.nanmin(self.bottom)), float(np.nanmax(self.bottom))

    @property
    def gradient(self) -> tuple[np.ndarray, np.ndarray]:
        """Slope (b_x, b_y), each (ny, nx): central differences, one-sided beside cells without data, where it is 0."""
        return relief.gradient(self.bottom, self.grid)

    def window(self, lower: Any, upper: Any) -> "Terrain":
        """Return the cells whose centres lie in a rectangle.

        Parameters
        ----------
        lower, upper : corners (x0, y0) and (x1, y1), m, within the terrain.

        Raises
        ------
        ValueError
            If the rectangle is empty, contains no centre of a cell, or reaches beyond the terrain.
        """
        corners = np.stack([validation.array(lower, "lower", (2,)), validation.array(upper, "upper", (2,))], axis=1)
        slices, ends = [], []
        for axis, letter, (low, high) in zip(self.grid.axes, "xy", corners.tolist(), strict=True):
            start, stop = np.searchsorted(axis.centers, low), np.searchsorted(axis.centers, high, side="right")
            if low < axis.lower - axis.dx or high > axis.upper + axis.dx:
                raise ValueError(f"a window must lie within the terrain, {letter} from {axis.lower:.10g} to {axis.upper:.10g} m, "
                                 f"got {letter} from {low:.10g} to {high:.10g}")
            if start >= stop:
                raise ValueError(f"a window must contain the centre of a cell, got {letter} from {low:.10g} to {high:.10g} with "
                                 f"cells of {axis.dx:.4g} m: give ((x0, y0), (x1, y1)), x0 < x1, y0 < y1")
            slices.append(slice(start, stop))
            ends.append((float(axis.edges[start]), float(axis.edges[stop]), int(stop - start)))
        return self._on(Grid(*zip(*ends, strict=True)), self.bottom[slices[1], slices[0]])

    def coarser(self, cell: float) -> "Terrain":
        """Return the terrain on square cells of another size, each the average, by area, of the cells that it covers.

        Sizes that are no multiple are resampled in the same way. A larger cell has data where at least half of it has; what is
        less than a cell at the upper edges is left out.

        Parameters
        ----------
        cell : length of a side, m, at least that of the cells now.

        Raises
        ------
        ValueError
            If ``cell`` is smaller than the cells now, or larger than the terrain.
        """
        side, now = validation.real(cell, "cell", above=0.0), max(axis.dx for axis in self.grid.axes)
        if side < now * (1.0 - SAME):
            raise ValueError(f"`cell` must be at least that of the terrain, {now:.10g} m, got {side:g}: there is no finer "
                             "detail in it")
        if all(abs(axis.dx - side) <= resample.ROUNDING * side for axis in self.grid.axes):
            return self
        grid = resample.larger(self.grid, side)
        return self._on(grid, resample.coarse_averages(self.bottom, self.grid, grid))

    def filled(self) -> "Terrain":
        """Return the terrain with its holes filled: cells without data that cells with data enclose.

        Each filled cell is the mean of its four neighbours (Laplace's equation), so no new top or pit appears. Cells without data
        that reach the edge stay without.
        """
        return self._on(self.grid, resample.filled(self.bottom, resample.holes(self.missing)))

    def slopes(self) -> relief.Slopes:
        """Return how steep it is: ``steepest``, degrees, its ``place``, and shares of cells ``over`` 10, 30 and 45 degrees."""
        return relief.slopes(self.bottom, self.missing, self.grid)

    def depressions(self) -> relief.Depressions:
        """Return depressions: ``count``, ``volume``, m^3, ``deepest``, m. Water leaves at edges and into cells without data."""
        return relief.depressions(self.bottom, self.missing, self.grid)

    def cells(self, values: Any, name: str) -> np.ndarray:
        """Return values of the cells, (ny, nx), finite or not, as floats, or raise naming ``name``."""
        found = validation.floats(values, name)
        if found.shape != self.grid.shape:
            raise ValueError(f"`{name}` must have the shape of the terrain, {self.grid.shape}, got {found.shape}")
        return found

    def check_on_grid(self, grid: Grid, where: object) -> None:
        """Raise ValueError, naming ``where``, if another grid differs from the terrain's by more than a thousandth of a cell."""
        for letter, own, other in zip("xy", self.grid.axes, grid.axes, strict=True):
            for what, mine, given in (("number of cells", own.num_cells, other.num_cells), ("lower edge", own.lower, other.lower),
                                      ("upper edge", own.upper, other.upper)):
                if abs(mine - given) > SAME * own.dx:
                    raise ValueError(f"{where} must be on the grid of the terrain, or on that of the file from which `window` "
                                     f"and `cell` made it, got the {what} in {letter} {given:.10g} instead of {mine:.10g}: "
                                     "resample it, with `gdalwarp -te -ts` for example")

    def averages(self, values: np.ndarray, grid: Grid, where: object) -> np.ndarray:
        """Return values on the terrain's grid, or on one of which `window` and `coarser` make it, as averages over its cells."""
        if grid != self.grid and all(resample.divides(*pair, SAME) for pair in zip(grid.axes, self.grid.axes, strict=True)):
            return resample.coarse_averages(values, grid, self.grid)
        self.check_on_grid(grid, where)
        return values

    def describe(self) -> str:
        """Return a summary in lines: size, place and CRS, elevations, cells without data, slopes, depressions."""
        x, y = self.grid.axes
        inside = int(np.count_nonzero(resample.holes(self.missing)))
        return "\n".join([
            repr(self), f"x {x.lower:.10g} to {x.upper:.10g} m, y {y.lower:.10g} to {y.upper:.10g} m, {systems.named(self.crs)}",
            f"{self._without} ({self.missing.mean():.1%}), {inside} of them in holes",
            str(self.slopes()), str(self.depressions())])

    @property
    def _without(self) -> str:
        return f"{int(np.count_nonzero(self.missing))} without data"

    def __repr__(self) -> str:
        sizes = " x ".join(dict.fromkeys(f"{axis.dx:.5g}" for axis in self.grid.axes))
        return (f"Terrain({self.name!r}: {self.grid.described} cells of {sizes} m, {self.range[0]:.5g} to {self.range[1]:.5g} m, "
                f"{self._without})")

    def _on(self, grid: Grid, bottom: np.ndarray) -> "Terrain":
        return Terrain(grid, bottom, crs=self.crs, name=self.name)
