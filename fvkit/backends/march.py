"""State of a run between and within steps: counters and clocks, and how a call of a kernel ended."""

from enum import IntEnum
from typing import Any

import numpy as np

from fvkit.backends.step_length import MAX_RETRIES

#: Depth below which a face is one of a film, not of the flow, m; and what one metre is in the units of counts.
FILM, MICRO = 0.05, 1e6


class Outcome(IntEnum):
    """Why `Kernel.advance` returned."""

    REACHED = 0
    PAUSED = 1
    BAD_STATE = 2
    NO_STEP = 3
    LOST_HYPERBOLICITY = 4


class _Number:
    """A field of `March` that lives in one of its arrays, where compiled code finds it."""

    def __init__(self, array: str, index: int, kind: type) -> None:
        self.array, self.index, self.kind = array, index, kind

    def __get__(self, march: Any, owner: type) -> Any:
        return self.kind(getattr(march, self.array)[self.index])

    def __set__(self, march: Any, value: Any) -> None:
        getattr(march, self.array)[self.index] = value


class March:
    """State and counters of a run: the accepted state ``now``, the trial state ``next``, and what was counted.

    Everything is kept in arrays that compiled code changes in place, so that an interruption at any moment leaves the
    last accepted step. ``masses`` holds what passed the lower and the upper end of each axis, along it, and what sources brought,
    a row each, see `Kernel.book_rows`. ``lost`` counts (face, step) pairs without hyperbolicity, the first of them at
    ``lost_face`` and ``lost_time``, ``films`` those of them in films, and ``deepest`` is the depth of the deepest, in whole
    micrometres.
    """

    t = _Number("real", 0, float)
    dt = _Number("real", 1, float)
    max_cfl = _Number("real", 2, float)
    lost_time = _Number("real", 3, float)
    steps = _Number("count", 0, int)
    rejected = _Number("count", 1, int)
    lost = _Number("count", 2, int)
    lost_face = _Number("count", 3, int)
    films = _Number("count", 5, int)
    deepest = _Number("count", 6, int)

    def __init__(self, buffers: tuple[np.ndarray, np.ndarray], t: float, dt: float, masses: tuple[int, int],
                 stop_when_lost: bool = False, bounds: tuple[float, float] = (0.0, np.inf)) -> None:
        self._buffers = buffers
        self.books = np.array([t, dt, 0.0, np.nan]), np.array([0, 0, 0, -1, 0, 0, 0]), np.zeros(masses)
        self.stop_when_lost, self.bounds = stop_when_lost, bounds

    def bounded(self, dt: float) -> float:
        """A step length within ``bounds``, which are equal where it is fixed."""
        least, most = self.bounds
        return max(least, min(most, dt))

    @property
    def retries(self) -> int:
        """How often a step is tried: once where its length is fixed."""
        return 1 if self.bounds[0] > 0.0 else MAX_RETRIES

    @property
    def real(self) -> np.ndarray:
        """t, dt, max_cfl, lost_time."""
        return self.books[0]

    @property
    def count(self) -> np.ndarray:
        """steps, rejected, lost, lost_face, the number of times that ``now`` and ``next`` changed places, films, deepest."""
        return self.books[1]

    @property
    def masses(self) -> np.ndarray:
        """What passed the ends, and what sources brought, (rows, masses)."""
        return self.books[2]

    @property
    def now(self) -> np.ndarray:
        """The last accepted state, padded."""
        return self._buffers[self.count[4] % 2]

    @property
    def next(self) -> np.ndarray:
        """The trial state, padded."""
        return self._buffers[1 - self.count[4] % 2]

    def accept(self, t: float, dt: float, cfl: float, rejected: int, passed: np.ndarray) -> None:
        """Make the trial state the accepted one, at time t; dt is the next step, ``passed`` the additions to ``masses``.

        It happens in one assignment, so that Ctrl-C finds a step whole or not at all.
        """
        real, count = self.real.copy(), self.count.copy()
        real[:3] = t, dt, max(real[2], cfl)
        count += [1, rejected, 0, 0, 1, 0, 0]
        self.books = real, count, self.masses + passed

    def refuse(self, dt: float, rejected: int) -> None:
        """Record rejected steps, and the length of the next one."""
        self.rejected += rejected
        if rejected:
            self.dt = dt
