"""`Raster`: the content of a raster file: values, place, missing cells, CRS."""

from pathlib import Path
from typing import NamedTuple

import numpy as np

from fvkit.problem.grid import Grid

#: Code for no data: ESRI's where a file names none, and that of the rasters written here.
NODATA = -9999.0

#: Codes for no data from this size on match all values as large, since texts and single precision round them.
HUGE = 1e30


class Raster(NamedTuple):
    """Values in the cells of a grid.

    Parameters
    ----------
    path : the file.
    grid : grid with two axes.
    values : (ny, nx), y ascending, NaN where there is no data.
    crs : coordinate reference system as a text, or None.
    """

    path: Path
    grid: Grid
    values: np.ndarray
    crs: str | None


def placed(corner: tuple[float, float], sizes: tuple[float, float], shape: tuple[int, ...]) -> Grid:
    """Return the grid of ``shape`` (ny, nx) cells of given sizes (dx, dy) with its lower corner at a place."""
    counts = shape[::-1]
    upper = tuple(low + size * count for low, size, count in zip(corner, sizes, counts, strict=True))
    return Grid(corner, upper, counts)


def without(values: np.ndarray, code: float) -> np.ndarray:
    """Return values with NaN where they are the code for no data."""
    equal = np.abs(values) >= HUGE if abs(code) >= HUGE else values == code
    return np.where(equal, np.nan, values)
