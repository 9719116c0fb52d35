"""What every backend shares: padded states, ghost geometry, and the bookkeeping of a march through time."""

from abc import ABC, abstractmethod
from enum import IntEnum
from typing import ClassVar

import attrs
import numpy as np

from fvkit.backends.halo import Plan, plan
from fvkit.model import aux_rows
from fvkit.problem import Problem
from fvkit.schemes.base import Parts, Scheme

#: A step is retried at most this often; each retry shortens it to the Courant number aimed at.
MAX_RETRIES = 30


class Outcome(IntEnum):
    """Why `Kernel.advance` returned."""

    REACHED = 0
    PAUSED = 1
    BAD_STATE = 2
    NO_STEP = 3
    LOST_HYPERBOLICITY = 4


@attrs.define(eq=False)
class March:
    """State and counters of a run: the accepted state ``now``, the trial state ``next``, and what was counted.

    ``left_in`` and ``right_out`` are the masses that entered and left through the ends. ``lost`` counts (face, step)
    pairs without hyperbolicity, the first of them at ``lost_face`` and ``lost_time``.
    """

    now: np.ndarray
    next: np.ndarray
    t: float
    dt: float
    left_in: np.ndarray
    right_out: np.ndarray
    stop_when_lost: bool = False
    steps: int = 0
    rejected: int = 0
    max_cfl: float = 0.0
    lost: int = 0
    lost_face: int = -1
    lost_time: float = np.nan


class Kernel(ABC):
    """Abstract backend: runs the stages of one scheme for one problem. Contract:

    1. States are padded arrays (num_eqn, halo + num_cells + halo), made by `padded`; a kernel owns none.
    2. `advance` takes accepted steps only: a step above the scheme's largest Courant number, or with a state that is
       not finite or has a negative mass, leaves ``march.now`` and ``march.t`` untouched.
    3. Ghost cells are filled at the start of a step; sources act on them as on every cell.
    """

    name: ClassVar[str]
    compile_seconds: float = 0.0

    def __init__(self, problem: Problem, scheme: Scheme, parts: Parts) -> None:
        self.problem, self.scheme, self.parts = problem, scheme, parts
        self.plan: Plan = plan(scheme.stages(parts))
        self.halo, self.cells = self.plan.halo, problem.grid.num_cells
        if self.cells < self.halo:
            raise ValueError(f"`num_cells` must be >= {self.halo} for this scheme, got {self.cells}")
        self.mass_rows = list(problem.model.mass_rows())
        self.closed = problem.boundary[0].reads == "opposite"
        self.ghosts = (self._side(left=True), self._side(left=False))
        self.aux = self._padded_aux()

    def padded(self, q: np.ndarray) -> np.ndarray:
        """Return a copy of q (num_eqn, num_cells) with room for ghost cells."""
        result = np.zeros((q.shape[0], self.cells + 2 * self.halo))
        self.inside(result)[:] = q
        return result

    def inside(self, padded: np.ndarray) -> np.ndarray:
        """View of the cells of the grid."""
        return padded[:, self.halo:self.halo + self.cells]

    def _side(self, left: bool) -> tuple[range, range]:
        """Ghost cells of one side, and for each the cell that it looks at."""
        halo, n = self.halo, self.cells
        ghosts = range(halo) if left else range(halo + n, n + 2 * halo)
        reads = self.problem.boundary[0 if left else 1].reads
        if reads == "opposite":
            return ghosts, range(n, n + halo) if left else range(halo, 2 * halo)
        if reads == "mirror":
            return ghosts, range(2 * halo - 1, halo - 1, -1) if left else range(halo + n - 1, n - 1, -1)
        edge = halo if left else halo + n - 1
        return ghosts, range(edge, edge + 1)

    def _padded_aux(self) -> np.ndarray:
        rows = aux_rows(self.problem.model, self.problem.aux_averages)
        result = self.padded(np.array(rows).reshape(len(rows), self.cells))
        for ghosts, seen in self.ghosts:
            result[:, ghosts] = result[:, seen]
        return result

    def ghost_values(self, t: float) -> tuple[tuple[float, ...], ...]:
        """What the boundary conditions of both sides give to their ``ghost`` at time t."""
        return tuple(side.values(self.problem.model, t) for side in self.problem.boundary)

    @property
    def steady_boundary(self) -> bool:
        """Whether `ghost_values` is the same at all times."""
        return all(side.steady for side in self.problem.boundary)

    @abstractmethod
    def advance(self, march: March, target: float, max_steps: int) -> Outcome:
        """Take accepted steps until ``march.t == target``, exactly, or at most ``max_steps`` of them."""
