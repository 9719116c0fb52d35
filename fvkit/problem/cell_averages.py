"""Cell averages of functions of x by Gauss-Legendre quadrature."""

from collections.abc import Callable
from typing import Any

import numpy as np

from fvkit import validation
from fvkit.problem.grid import Grid

#: Nodes in a cell: exact for polynomials of degree 9, so that averages never limit a scheme here.
NODES = 5

#: Where they lie, from the centre in cell lengths, and what they weigh.
POINTS, WEIGHTS = (0.5 * half for half in np.polynomial.legendre.leggauss(NODES))


def cell_averages(function: Callable[[np.ndarray], Any], grid: Grid, rows: int | None, name: str) -> np.ndarray:
    """Average ``function`` over every cell of ``grid``.

    No node lies on a cell edge, so a jump at an edge stays exactly sharp; a jump inside a cell is
    averaged to about 1/NODES of its height. ``function`` gets the nodes of the whole grid at once, cell by cell: `levelled`
    relies on that.

    Parameters
    ----------
    function : x (m,) -> (rows, m), or (m,) and scalars when ``rows`` is None.
    grid : the grid.
    rows : number of components that are expected, None for a scalar function.
    name : what to call the function in messages.

    Returns
    -------
    numpy.ndarray
        (rows, num_cells), or (num_cells,) when ``rows`` is None.

    Raises
    ------
    ValueError
        If the function returns another shape. Its own exceptions pass through.
    """
    x = (grid.centers[:, None] + grid.dx * POINTS).ravel()
    raw = function(x)
    if not isinstance(raw, (np.ndarray, list, tuple)):
        raw = validation.floats(raw, f"{name}(x)")
    wanted = (x.size,) if rows is None else (rows, x.size)
    given = _shape(raw)
    scalars = rows is None and given == ()
    if given != wanted and not scalars:
        raise ValueError(f"`{name}(x)` must return shape {wanted} for x of shape {x.shape}, got {given}"
                         + ("; broadcast constants with np.full_like(x, value)" if given[:1] == wanted[:1] else ""))
    values = np.broadcast_to(validation.floats(raw, f"{name}(x)"), wanted)
    return values.reshape(*wanted[:-1], grid.num_cells, NODES) @ WEIGHTS


def levelled(depth: np.ndarray) -> np.ndarray:
    """Return depths (m,) at the nodes of cells, level minus bottom, as they are in cells that are wet everywhere, and else
    max(mean depth, 0): the depth of that level over the mean bottom.

    The mean of max(level - bottom, 0) lies higher over the mean bottom than the level: a lake would not be at rest at its shore.
    """
    cells = depth.reshape(-1, NODES)
    return np.where((cells < 0.0).any(axis=1, keepdims=True), np.maximum(cells @ WEIGHTS, 0.0)[:, None], cells).ravel()


def _shape(raw: Any) -> tuple[int, ...]:
    """Shape of what a user's function returned; () where it is no array at all."""
    try:
        return np.shape(raw)
    except ValueError:  # rows of different lengths, usually a constant among arrays
        return (len(raw), -1)
