"""Active blocks: those with mass, or that mass may reach in a step. The others are left out, with the same bits.

A dry cell whose neighbours along a sweep are dry keeps every bit, at first and at second order, with friction and drag. So a step
changes nothing further than one cell from what is wet, and a block that is further away is idle. Blocks never become idle again:
what has drained leaves films.
"""

from collections.abc import Sequence
from itertools import pairwise
from typing import Any

import numpy as np

#: Cells of a block along each axis, a multiple of the lines of a tile.
SIDE = 16

#: Rows and columns of the cells around a block, counted from its first.
RING = np.argwhere(np.pad(np.zeros((SIDE, SIDE), dtype=bool), 1, constant_values=True)).T - 1


class ActiveBlocks:
    """The blocks of a grid (ny, nx) that a step computes: ``every`` one, since something may happen anywhere, or some.

    ``halo`` is the width of the ghost cells of padded states, ``wetted`` the numbers of the cells that sources bring mass to.
    """

    def __init__(self, shape: tuple[int, ...], halo: int, every: bool, wetted: Sequence[Any] = ()) -> None:
        self.shape, self.halo, self.every = shape, halo, every
        self.blocks = np.full([-(-n // SIDE) for n in shape], every)
        for cells in wetted if not every else ():
            for j, i in zip(*np.unravel_index(cells, shape), strict=True):
                self.blocks[max(j - 1, 0) // SIDE:(j + 1) // SIDE + 1, max(i - 1, 0) // SIDE:(i + 1) // SIDE + 1] = True
        self.version = 0
        self.known = False

    def forget(self) -> None:
        """Test every block again after the state was replaced."""
        self.known = False

    def look(self, q: np.ndarray) -> None:
        """Make active the blocks within one cell of which a padded state is other than 0."""
        if self.every:
            return
        found = self.blocks.copy()
        if self.known:  # in what is idle nothing stands
            near = np.argwhere(~self.blocks & _widened(self.blocks))
            j, i = (np.clip(SIDE * block[:, None] + cells, 0, n - 1)
                    for block, cells, n in zip(near.T, RING, self.shape, strict=True))
            found[*near.T] = q[:, j + self.halo, i + self.halo].view(np.int64).any(axis=(0, 2))
        else:
            for j, i in np.argwhere(~self.blocks).tolist():
                found[j, i] = self._around(q, j, i).any()
        self.known = True
        self._add(found)

    def _around(self, q: np.ndarray, j: int, i: int) -> np.ndarray:
        """The bits of a block and of one cell of the grid around it: also -0.0 is something."""
        first, left = (self.halo + max(SIDE * k - 1, 0) for k in (j, i))
        stop, right = (self.halo + min(SIDE * (k + 1) + 1, n) for k, n in zip((j, i), self.shape, strict=True))
        return q[:, first:stop, left:right].view(np.int64)

    def touch(self, axis: int, side: int, lines: np.ndarray) -> None:
        """Make active the blocks at a side of an axis where ``lines`` (cells along the side) marks an inflow."""
        if self.every or not lines.any():
            return
        padded = np.zeros(SIDE * self.blocks.shape[axis], dtype=bool)
        padded[:len(lines)] = lines
        found, edge = self.blocks.copy(), -side
        along = padded.reshape(-1, SIDE).any(axis=1)
        if axis == 0:
            found[:, edge] |= along
        else:
            found[edge] |= along
        self._add(found)

    def _add(self, found: np.ndarray) -> None:
        if (found & ~self.blocks).any() or not self.version:
            self.blocks |= found
            self.version += 1

    def jobs(self, axis: int, lanes: int, longest: int) -> np.ndarray:
        """Return the pieces of lines along an axis, at most ``longest`` cells long and ``lanes`` lines wide, in active blocks.

        Each is a row: the first line, counted with ghost cells, number of lines, first cell and number of cells. Those of the
        same lines follow each other in the order of their cells.
        """
        lines, cells = (self.shape[0], self.shape[1]) if axis == 0 else (self.shape[1], self.shape[0])
        blocks = self.blocks if axis == 0 else self.blocks.T
        steps = np.diff(np.pad(blocks, ((0, 0), (1, 1))).astype(int))
        starts, stops = (SIDE * np.argwhere(steps == step) for step in (1, -1))
        pieces = []
        for (line, start), stop in zip(starts.tolist(), np.minimum(stops[:, 1], cells).tolist(), strict=True):
            count = -(-(stop - start) // longest)
            pieces += [(line, *cut) for cut in pairwise([start + (stop - start) * k // count for k in range(count + 1)])]
        line, low, high = np.array(pieces, dtype=np.int64).reshape(-1, 3).T[:, :, None]
        first = line + np.arange(0, SIDE, lanes)
        found = np.stack(np.broadcast_arrays(first + self.halo, np.minimum(lanes, lines - first), low, high - low), axis=-1)
        found = found[first < lines]
        return np.ascontiguousarray(found[np.lexsort((found[:, 2], found[:, 0]))])

    def reaches(self, axis: int, side: int) -> bool:
        """Whether a block at a side of an axis may be active."""
        blocks = self.blocks if axis == 1 else self.blocks.T
        return not self.known or bool(blocks[-side].any())


def _widened(blocks: np.ndarray) -> np.ndarray:
    """Blocks and their neighbours."""
    result = np.pad(blocks, 1)
    result = result[:-2] | result[1:-1] | result[2:]
    return result[:, :-2] | result[:, 1:-1] | result[:, 2:]
