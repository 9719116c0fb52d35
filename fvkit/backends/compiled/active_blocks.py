"""Blocks of cells where something stands or may come to in a step: the others are left out, with the same bits.

A dry cell whose neighbours along a sweep are dry keeps every bit, at first and at second order, with friction and drag. So a step
changes nothing further than one cell from what is wet, and a block beside no wet one is idle. Blocks never become idle again:
what has drained leaves films.
"""

from itertools import pairwise

import numpy as np
from scipy.ndimage import binary_dilation

#: Cells of a block along each axis, a multiple of the lines of a tile.
SIDE = 32


class ActiveBlocks:
    """The blocks of a grid (ny, nx) that a step computes.

    Parameters
    ----------
    shape : (ny, nx) of the grid.
    halo : width of the ghost cells of padded states.
    every : whether all blocks are, since something may happen anywhere.
    """

    def __init__(self, shape: tuple[int, ...], halo: int, every: bool) -> None:
        self.shape, self.halo, self.every = shape, halo, every
        self.blocks = np.full([-(-n // SIDE) for n in shape], every)
        self._wet = self.blocks.copy()
        self.version = 0

    def look(self, q: np.ndarray) -> None:
        """Find the blocks where a padded state has become other than 0, and make these and their neighbours active."""
        if self.every:
            return
        if self.version:
            candidates = np.argwhere(self.blocks & ~self._wet)
            wetted = [(j, i) for j, i in candidates.tolist() if self._block(q, j, i).any()]
        else:
            wetted = [(j, i) for j, i in np.ndindex(*self.blocks.shape) if self._block(q, j, i).any()]
        if wetted or not self.version:
            self._wet[tuple(np.array(wetted, dtype=int).reshape(-1, 2).T)] = True
            self._add(binary_dilation(self._wet, np.ones((3, 3))))

    def _block(self, q: np.ndarray, j: int, i: int) -> np.ndarray:
        """The bits of a block of the grid: also -0.0 is something."""
        first, left = self.halo + SIDE * j, self.halo + SIDE * i
        stop, right = self.halo + min(SIDE * (j + 1), self.shape[0]), self.halo + min(SIDE * (i + 1), self.shape[1])
        return q[:, first:stop, left:right].view(np.int64)

    def touch(self, axis: int, side: int, lines: np.ndarray) -> None:
        """Make active the blocks at a side of an axis where ``lines`` (cells along the side) says that something comes in."""
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

        Each is a row: the first line, counted with ghost cells, number of lines, first cell and number of cells.
        """
        lines, cells = (self.shape[0], self.shape[1]) if axis == 0 else (self.shape[1], self.shape[0])
        result = []
        for k, row in enumerate(self.blocks if axis == 0 else self.blocks.T):
            edges = np.flatnonzero(np.diff(np.concatenate([[False], row, [False]]).astype(int)))
            first = np.arange(SIDE * k, min(SIDE * (k + 1), lines), lanes)
            for start, stop in zip(SIDE * edges[::2], np.minimum(SIDE * edges[1::2], cells), strict=True):
                pieces = -(-(stop - start) // longest)
                cuts = start + (stop - start) * np.arange(pieces + 1) // pieces
                for low, high in pairwise(cuts.tolist()):
                    result.append(np.column_stack([first + self.halo, np.minimum(lanes, lines - first),
                                                   np.full(len(first), low), np.full(len(first), high - low)]))
        return np.concatenate(result).astype(np.int64) if result else np.zeros((0, 4), dtype=np.int64)
