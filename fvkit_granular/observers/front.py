"""`Front`: observer of front positions (run-out) and of the deposit."""

from typing import Any

import attrs
import numpy as np

from fvkit import Problem
from fvkit.run.observers import SeriesObserver
from fvkit.validation import number


@attrs.define(eq=False)
class Front(SeriesObserver):
    """Front positions over time, the outermost points where the depth exceeds a threshold, and the deposit.

    The depth is interpolated linearly between the centre of the last cell above the threshold and the next one, so positions
    are accurate to about a cell. Grids with one axis alone.

    Parameters
    ----------
    threshold : depth h, m, positive; far above the model's ``dry`` and far below the depth of the flow.
    at_rest : speed, m/s, below which every phase of a cell counts as stopped.

    Attributes
    ----------
    t : numpy.ndarray
        (k,) times, s, starting with the initial time.
    left, right : numpy.ndarray
        (k,) positions, m; NaN where no cell is deeper than the threshold.
    deposit : numpy.ndarray
        (num_cells,) depth at the last step where all velocities are below ``at_rest``, 0 elsewhere, m.

    Examples
    --------
    >>> import fvkit as fv
    >>> import fvkit_granular as gr
    >>> front = gr.Front(threshold=0.01)
    >>> solution = fv.solve(gr.scene("dry-dam-break").problem(gr.ShallowWater, 100), observers=front, backend="numpy")
    >>> len(front.t) == solution.stats.steps + 1, bool(front.right[-1] > front.right[0])
    (True, True)
    """

    threshold: float = number(above=0.0)
    at_rest: float = number(1e-3, above=0.0)

    def begin(self, problem: Problem) -> None:
        super().begin(problem)
        if not callable(getattr(problem.model, "depth", None)):
            raise ValueError(f"Front needs a model with a depth, {type(problem.model).__name__} defines no `depth(q)`")
        if len(problem.grid.axes) > 1:
            raise ValueError("Front follows both ends of a flow along one axis, got a grid with two: take fv.Extremes, whose map "
                             "largest['h'] shows where the flow has been")

    def see(self, problem: Problem, t: float, q: np.ndarray) -> None:
        x, h = problem.grid.centers, self._depth(problem, q)
        deep = np.flatnonzero(h > self.threshold)
        left = right = np.nan
        if len(deep):
            left = self._crossing(x, h, int(deep[0]), -1, problem.grid.lower)
            right = self._crossing(x, h, int(deep[-1]), 1, problem.grid.upper)
        self.add(t, {"left": left, "right": right})

    def _depth(self, problem: Problem, q: np.ndarray) -> np.ndarray:
        model: Any = problem.model
        return np.asarray(model.depth(tuple(q)))

    def _crossing(self, x: np.ndarray, h: np.ndarray, last: int, way: int, end: float) -> float:
        """Return the position, m, where the depth falls to the threshold beyond cell ``last``; else the end of the grid."""
        beyond = last + way
        if not 0 <= beyond < len(x):
            return end
        return float(x[last] + (x[beyond] - x[last]) * (h[last] - self.threshold) / (h[last] - h[beyond]))

    @property
    def left(self) -> np.ndarray:
        """Left fronts, (k,)."""
        return self.column("left")

    @property
    def right(self) -> np.ndarray:
        """Right fronts, (k,)."""
        return self.column("right")

    @property
    def deposit(self) -> np.ndarray:
        """Depth of the deposit, (num_cells,), m: the depth where the flow has stopped, 0 elsewhere; empty before a run."""
        if self._stepper is None:
            return np.empty(0)
        problem, q = self._stepper.problem, self._stepper.q
        seen = problem.model.observables(q, problem.aux_averages)
        stopped = np.all([np.abs(seen[name]) < self.at_rest for name in ("vs", "vf", "v") if name in seen], axis=0)
        return np.where(stopped, self._depth(problem, q), 0.0)
