"""Arrays that begin at cache lines: vectors then never straddle two of them without need."""

import numpy as np

#: Numbers of 8 bytes in a cache line, and in pages of memory that caches keep in the same places.
LINE, PAGE = 8, 512


def aligned(size: int, first: int = 0) -> np.ndarray:
    """Return zeros of which entry ``first`` stands at the start of a cache line."""
    room = np.zeros(size + LINE)
    start = (-(room.ctypes.data // 8 + first)) % LINE
    return room[start:start + size]


def padded_rows(rows: int, shape: tuple[int, int], halo: int) -> np.ndarray:
    """Return zeros of shape (rows, *shape) of which every line of the memory has its first cell, behind ``halo`` ghost cells, at
    the start of a cache line. No two lines are a whole number of pages apart.
    """
    ny, nx = shape
    pitch = -(-nx // LINE) * LINE
    pitch += LINE * (pitch % PAGE == 0)
    return aligned(rows * ny * pitch, halo).reshape(rows, ny, pitch)[:, :, :nx]
