"""Resampling of rasters: averages over larger cells, and holes that are filled."""

from typing import Any

import numpy as np

from fvkit.problem.grid import Axis, Grid

# Parts of SciPy are imported where they are used: that takes longer than the import of the package.

#: Fraction of the area of a larger cell that must have data for an average.
KNOWN = 0.5

#: Share of a cell that lengths may differ by rounding.
ROUNDING = 1e-9


def larger(grid: Grid, cell: float) -> Grid:
    """Return the grid of square cells from the same lower corner; incomplete cells at the upper edges are left out."""
    counts = [int((axis.upper - axis.lower) / cell + ROUNDING) for axis in grid.axes]
    if min(counts) < 1:
        size = " x ".join(f"{axis.upper - axis.lower:.6g}" for axis in grid.axes)
        raise ValueError(f"`cell` must be at most the size of the terrain, {size} m, got {cell:g}")
    lower = [axis.lower for axis in grid.axes]
    upper = [low + count * cell for low, count in zip(lower, counts, strict=True)]
    return Grid(tuple(lower), tuple(upper), tuple(counts))


def coarse_averages(values: np.ndarray, fine: Grid, coarse: Grid) -> np.ndarray:
    """Return averages by area over the cells of a coarser grid, (ny, nx); NaN is left out, and stays where it has over half."""
    across, up = (overlaps(*pair) for pair in zip(fine.axes, coarse.axes, strict=True))
    known = ~np.isnan(values)
    weight = (up @ known.astype(float)) @ across.T
    total = (up @ np.where(known, values, 0.0)) @ across.T
    return np.where(weight >= KNOWN * coarse.cell_volume, total / np.maximum(weight, 1e-300), np.nan)


def divides(fine: Axis, coarse: Axis, tolerance: float) -> bool:
    """Return whether an axis comes from another one by a window, and by larger cells from an edge of it on."""
    start = (coarse.lower - fine.lower) / fine.dx
    within = start > -tolerance and coarse.upper < fine.upper + tolerance * fine.dx
    return within and abs(start - round(start)) < tolerance and fine.dx < (1.0 + tolerance) * coarse.dx


def overlaps(fine: Axis, coarse: Axis) -> Any:
    """Return the lengths that cells of two axes share, m, as a sparse array (coarse cells, fine cells)."""
    from scipy import sparse

    edges = np.union1d(fine.edges, coarse.edges)
    middle = 0.5 * (edges[1:] + edges[:-1])
    rows, columns = (np.searchsorted(axis.edges, middle, side="right") - 1 for axis in (coarse, fine))
    inside = (rows >= 0) & (rows < coarse.num_cells) & (columns >= 0) & (columns < fine.num_cells)
    entries = np.diff(edges)[inside], (rows[inside], columns[inside])
    return sparse.csr_array(entries, shape=(coarse.num_cells, fine.num_cells))


def holes(missing: np.ndarray) -> np.ndarray:
    """Return the mask (ny, nx) of cells without data that cells with data enclose: that no way over sides leads to the edge."""
    from scipy import ndimage

    labels, _ = ndimage.label(missing)
    outer = np.unique(np.concatenate([labels[0], labels[-1], labels[:, 0], labels[:, -1]]))
    return missing & ~np.isin(labels, outer)


def filled(values: np.ndarray, where: np.ndarray) -> np.ndarray:
    """Return values (ny, nx) with the enclosed cells ``where`` filled: each is the mean of its four neighbours (Laplace)."""
    from scipy import sparse
    from scipy.sparse.linalg import spsolve

    if not where.any():
        return values
    number = np.full(where.shape, -1)
    number[where] = np.arange(np.count_nonzero(where))
    rows, columns = np.nonzero(where)
    known, links = np.zeros(len(rows)), []
    for down, right in ((-1, 0), (1, 0), (0, -1), (0, 1)):
        beside = number[rows + down, columns + right]
        links.append(beside)
        known += np.where(beside < 0, values[rows + down, columns + right], 0.0)
    unknown = np.concatenate(links)
    own, there = np.tile(np.arange(len(rows)), 4)[unknown >= 0], unknown[unknown >= 0]
    matrix = 4.0 * sparse.eye_array(len(rows)) - sparse.csr_array((np.ones(len(own)), (own, there)), shape=(len(rows),) * 2)
    result = values.copy()
    result[where] = spsolve(matrix.tocsc(), known)
    return result
