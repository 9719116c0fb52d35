"""Polygons on cells: exact shares of areas, and rings that cross."""

from itertools import pairwise
from typing import Any

import numpy as np

from fvkit.problem.grid import Grid

#: A polygon: its outer ring and its holes, each (n, 2) points x, y, m, the last one not the first again.
Polygon = list[np.ndarray]


def ring(points: Any, where: str) -> np.ndarray:
    """Return a ring (n, 2) without its closing point, or raise ValueError naming ``where``."""
    try:
        given = np.array([[float(point[0]), float(point[1])] for point in points])
    except (TypeError, ValueError, IndexError, KeyError, OverflowError):
        raise ValueError(f"{where}: a ring must be a list of points (x, y) of two numbers") from None
    if not np.isfinite(given).all():
        raise ValueError(f"{where}: coordinates must be finite, got {given[~np.isfinite(given).all(axis=1)][0].tolist()}")
    if len(given) and (given[0] == given[-1]).all():
        given = given[:-1]
    if len(np.unique(given, axis=0)) < 3:
        raise ValueError(f"{where}: a ring must enclose an area, got {len(given)} points, of which three must differ")
    return given


def signed_area(points: np.ndarray) -> float:
    """Return the area in a ring, m^2, > 0 counter-clockwise."""
    x, y = (points - points[0]).T
    return float(0.5 * np.sum(x * np.roll(y, -1) - np.roll(x, -1) * y))


def area(polygon: Polygon) -> float:
    """Return the area of a polygon without its holes, m^2."""
    outer, *inner = (abs(signed_area(points)) for points in polygon)
    return outer - sum(inner)


def crossing(polygon: Polygon) -> tuple[float, float] | None:
    """Return a corner x, y of a side that crosses another one, of the same ring or not, or None; sides may touch."""
    start = np.concatenate(polygon)
    end = np.concatenate([np.roll(points, -1, axis=0) for points in polygon])
    for k in range(len(start) - 1):
        a, b, c, d = start[k], end[k], start[k + 1:], end[k + 1:]
        if ((_side(a, b, c) * _side(a, b, d) < 0.0) & (_side(c, d, a) * _side(c, d, b) < 0.0)).any():
            return float(a[0]), float(a[1])
    return None


def _side(a: np.ndarray, b: np.ndarray, c: np.ndarray) -> np.ndarray:
    """Return on which side of the line from a to b the point c lies: 1 left, -1 right, 0 on it."""
    way, there = b - a, c - a
    return np.sign(way[..., 0] * there[..., 1] - way[..., 1] * there[..., 0])


def shares(polygon: Polygon, grid: Grid) -> np.ndarray:
    """Return the share of each cell that a polygon covers, (ny, nx), 0 to 1: exact to rounding; parts outside are ignored.

    A side contributes, with the sign of its rise, all cells to its left in its rows, and the part to its left of its own cell;
    the sum over a ring is the enclosed area (Green's theorem, as fonts are drawn without sampling).
    """
    total = np.zeros(grid.shape)
    for number, points in enumerate(polygon):
        sign = np.sign(signed_area(points)) * (1.0 if number == 0 else -1.0)
        total += sign * _enclosed(points, grid)
    return total


def _enclosed(points: np.ndarray, grid: Grid) -> np.ndarray:
    x, y = grid.axes
    rows, columns = grid.shape
    places = (points - [x.lower, y.lower]) / [x.dx, y.dx]
    own, left = np.zeros((rows, columns + 1)), np.zeros((rows, columns + 1))
    for a, b in pairwise(np.concatenate([places, places[:1]])):
        cuts = a + np.unique(np.concatenate([[0.0, 1.0], _crossings(a[0], b[0]), _crossings(a[1], b[1])]))[:, None] * (b - a)
        cuts[-1] = b
        rise, middle = np.diff(cuts[:, 1]), 0.5 * (cuts[1:] + cuts[:-1])
        column, row = np.floor(middle).astype(int).T
        kept = (row >= 0) & (row < rows) & (column >= 0)
        row, column, rise, across = row[kept], np.minimum(column[kept], columns), rise[kept], middle[kept, 0]
        np.add.at(left, (row, column), rise)
        np.add.at(own, (row, column), rise * (across - column))
    before = np.cumsum(left[:, ::-1], axis=1)[:, ::-1] - left
    return (own + before)[:, :columns]


def _crossings(start: float, end: float) -> np.ndarray:
    """Return where between 0 and 1 a way from ``start`` to ``end`` passes whole numbers."""
    low, high = sorted((start, end))
    lines = np.arange(np.floor(low) + 1.0, np.ceil(high))
    return (lines - start) / (end - start) if len(lines) else lines
