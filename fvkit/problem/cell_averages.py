"""Cell averages of functions of x, or of x and y, by Gauss-Legendre quadrature."""

import inspect
from collections.abc import Callable
from typing import Any

import numpy as np

from fvkit import validation
from fvkit.problem.grid import NAMES, Grid

#: Nodes in a cell along an axis: exact for polynomials of degree 9, so that averages never limit a scheme here.
NODES = 5

#: Where they lie, from the centre in cell lengths, and what they weigh.
POINTS, WEIGHTS = (0.5 * half for half in np.polynomial.legendre.leggauss(NODES))

#: Nodes of a grid with two axes that a function gets at once, about.
AT_ONCE = 2_000_000


def cell_averages(function: Callable[..., Any], grid: Grid, rows: int | None, name: str) -> np.ndarray:
    """Return the averages of ``function`` over all cells of ``grid``, (rows, *grid.shape), or grid.shape when ``rows`` is None.

    No node lies on a cell edge, so a jump at an edge stays exactly sharp; a jump inside a cell is
    averaged to about 1/NODES of its height. With one axis ``function`` gets the nodes of the whole grid at once, cell by cell,
    with two those of some rows of cells: `levelled` relies on that.

    Of x (m,) it returns (rows, m), or (m,) and scalars when ``rows`` is None; with two axes of x and y, each (my, mx). Messages
    call it ``name``; its own exceptions pass through.
    """
    nodes = [(axis.centers[:, None] + axis.dx * POINTS).ravel() for axis in grid.axes]
    if len(nodes) == 1:
        values = _values(function, nodes, rows, name)
        return values.reshape(*values.shape[:-1], grid.num_cells, NODES) @ WEIGHTS
    x, y = nodes
    strip = NODES * max(1, AT_ONCE // (NODES * len(x)))
    parts = []
    for first in range(0, len(y), strip):
        here = y[first:first + strip]
        values = _values(function, [np.broadcast_to(x, (len(here), len(x))), np.broadcast_to(here[:, None], (len(here), len(x)))],
                         rows, name)
        cells = values.reshape(*values.shape[:-2], -1, NODES, len(x) // NODES, NODES)
        parts.append(np.einsum("...abcd,b,d->...ac", cells, WEIGHTS, WEIGHTS))
    return np.concatenate(parts, axis=-2)


def _values(function: Callable[..., Any], places: list[np.ndarray], rows: int | None, name: str) -> np.ndarray:
    """What a function returns at places, checked."""
    check_arguments(function, len(places), name)
    raw, shape, call = function(*places), places[0].shape, f"`{name}({', '.join(NAMES[:len(places)])})`"
    if not isinstance(raw, (np.ndarray, list, tuple)):
        raw = validation.floats(raw, call.strip("`"))
    wanted = shape if rows is None else (rows, *shape)
    given = _shape(raw)
    scalars = rows is None and given == ()
    if given != wanted and not scalars:
        places_of = " and ".join(NAMES[:len(places)])
        raise ValueError(f"{call} must return shape {wanted} for {places_of} of shape {shape}, got {given}"
                         + ("; broadcast constants with np.full_like(x, value)" if given[:1] == wanted[:1] else ""))
    return np.broadcast_to(validation.floats(raw, call.strip("`")), wanted)


def levelled(depth: np.ndarray) -> np.ndarray:
    """Return depths at the nodes of cells, level minus bottom, as they are in cells that are wet everywhere, and else
    max(mean depth, 0): the depth of that level over the mean bottom.

    The mean of max(level - bottom, 0) lies higher over the mean bottom than the level: a lake would not be at rest at its shore.
    """
    if depth.ndim == 1:
        cells = depth.reshape(-1, NODES)
        return np.where((cells < 0.0).any(axis=1, keepdims=True), np.maximum(cells @ WEIGHTS, 0.0)[:, None], cells).ravel()
    blocks = depth.reshape(depth.shape[0] // NODES, NODES, depth.shape[1] // NODES, NODES)
    mean = np.einsum("abcd,b,d->ac", blocks, WEIGHTS, WEIGHTS)[:, None, :, None]
    return np.where((blocks < 0.0).any(axis=(1, 3), keepdims=True), np.maximum(mean, 0.0), blocks).reshape(depth.shape)


def check_arguments(function: Callable[..., Any], count: int, name: str) -> None:
    """Raise TypeError where a function cannot be called with the places."""
    try:
        inspect.signature(function).bind(*NAMES[:count])
    except ValueError:  # a ufunc of NumPy, say, has no signature
        return
    except TypeError as error:
        wanted = "x" if count == 1 else "x and y on a grid with two axes"
        raise TypeError(f"`{name}` must be a function of {wanted}, got one that takes other arguments ({error})") from None


def _shape(raw: Any) -> tuple[int, ...]:
    """Shape of what a user's function returned; () where it is no array at all."""
    try:
        return np.shape(raw)
    except ValueError:  # rows of different lengths, usually a constant among arrays
        return (len(raw), -1)
