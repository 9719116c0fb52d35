"""Observers: time series and maps recorded at every step of a run, for ``observers`` of `fvkit.solve`."""

from abc import ABC, abstractmethod
from collections.abc import Mapping
from typing import Any

import attrs
import numpy as np

from fvkit import validation
from fvkit.problem.directions import observables
from fvkit.problem.problem import Problem
from fvkit.run.step_bounds import intervals
from fvkit.run.stepper import Stepper


@attrs.define(eq=False)
class Observer(ABC):
    """Abstract observer, called after every accepted step of a run. Contract:

    1. ``begin(problem)`` is called when a run starts; it clears the record.
    2. ``see(problem, t, q)`` is called with the initial time and state q (num_eqn, *grid.shape), then after each accepted step;
       q is a view that the next step overwrites.
    3. ``record()`` returns the record so far, {name: array}. ``recall(problem, record)`` restores such a record, after
       ``begin``, or raises ValueError. Checkpoints contain the record, so an observer of the same class and fields continues
       its record in a run continued by `fvkit.resume`. Without ``record`` it starts at the checkpoint, and `fvkit.resume` warns.

    A run with observers returns to Python after every step, which costs about ten microseconds per step (measured) and the
    time of the observers themselves.

    Examples
    --------
    >>> import fvkit as fv
    >>> import fvkit_granular as gr
    >>> class Volume(fv.Observer):
    ...     def begin(self, problem):
    ...         self.volumes = []
    ...
    ...     def see(self, problem, t, q):
    ...         self.volumes.append(problem.grid.dx * q[0].sum())
    >>> volume = Volume()
    >>> solution = fv.solve(gr.scene("dam-break").problem(gr.ShallowWater, 100), observers=volume, backend="numpy")
    >>> len(volume.volumes) == solution.stats.steps + 1
    True
    """

    _stepper: Stepper | None = attrs.field(default=None, init=False, repr=False)
    _steps: int = attrs.field(default=0, init=False, repr=False)

    def __call__(self, stepper: Stepper) -> None:
        """Record a step: call ``begin`` for a new run, then ``see``."""
        problem = stepper.problem
        if stepper is not self._stepper:
            self._stepper = stepper
            self.begin(problem)
            if stepper.steps == 1:
                self.see(problem, problem.t_start, problem.q0)
        self.see(problem, stepper.t, stepper.q)
        self._steps = stepper.steps

    def stored(self, stepper: Stepper) -> dict[str, np.ndarray] | None:
        """Return the arrays that a checkpoint stores for this observer; None before ``begin`` and without a record."""
        record = self.record() if self._stepper is stepper else None
        return None if record is None else {**record, "steps": np.array(float(self._steps))}

    def restore(self, stepper: Stepper, notes: Mapping[str, np.ndarray]) -> None:
        """Restore the arrays of `stored` in a continued run; ValueError if the arrays do not fit this observer."""
        problem = stepper.problem
        self._stepper, self._steps = stepper, stepper.steps
        self.begin(problem)
        self.recall(problem, {name: values for name, values in notes.items() if name != "steps"})
        if notes["steps"] < stepper.steps:  # an exception prevented the record of the last step
            self.see(problem, stepper.t, stepper.q)

    @abstractmethod
    def begin(self, problem: Problem) -> None:
        """Start a new run."""

    @abstractmethod
    def see(self, problem: Problem, t: float, q: np.ndarray) -> None:
        """Record the state q (num_eqn, *grid.shape) at time ``t``."""

    def record(self) -> dict[str, np.ndarray] | None:
        """Return the record, {name: array of floats}; None if checkpoints store no record."""
        return None

    def recall(self, problem: Problem, record: Mapping[str, np.ndarray]) -> None:
        """Restore a record, {name: array of floats}."""
        raise NotImplementedError(f"{type(self).__name__} defines `record`, so it must define `recall`")


@attrs.define(eq=False)
class SeriesObserver(Observer, ABC):
    """Abstract observer of time series: ``see`` calls `add` with named values, numbers or rows of one length."""

    _series: dict[str, np.ndarray] = attrs.field(factory=dict, init=False, repr=False)  # longer than `_count` rows; time is ""
    _count: int = attrs.field(default=0, init=False, repr=False)

    def begin(self, problem: Problem) -> None:
        self._series, self._count = {}, 0

    def add(self, t: float, values: Mapping[str, Any]) -> None:
        """Append a time and one value for each name, in arrays that grow by doubling."""
        for name, value in {"": t, **values}.items():
            kept = self._series.get(name)
            if kept is None or len(kept) == self._count:
                longer = np.empty((max(64, 2 * self._count), *np.shape(value)))
                if kept is not None:
                    longer[:self._count] = kept
                kept = self._series[name] = longer
            kept[self._count] = value
        self._count += 1

    def column(self, name: str) -> np.ndarray:
        """Return the values of a name so far, (k, ...)."""
        return self._series[name][:self._count] if name in self._series else np.empty(0)

    def record(self) -> dict[str, np.ndarray]:
        return {name: self.column(name) for name in self._series}

    def recall(self, problem: Problem, record: Mapping[str, np.ndarray]) -> None:
        count, shape = len(record[""]), self._shape()
        if any(values.shape != (count, *shape) for name, values in record.items() if name):
            raise ValueError(f"columns of a {type(self).__name__} have the shape {(count, *shape)}, a row for each of its times")
        self._series, self._count = dict(record), count

    def _shape(self) -> tuple[int, ...]:
        """Return the shape of the values of a name at one time."""
        return ()

    @property
    def t(self) -> np.ndarray:
        """Times, (k,), s."""
        return self.column("")


def _positions(value: Any) -> np.ndarray:
    """Return positions x, (k,), or pairs (x, y), (k, 2)."""
    found = np.array(validation.row(value, "x"))
    return found.reshape(-1, 2) if np.ndim(value) == 2 and np.shape(value)[1] == 2 else found


@attrs.define(eq=False)
class Gauge(SeriesObserver):
    """Gauge: time series of all observables at given positions, as averages of the cells that contain them.

    Parameters
    ----------
    x : one or several positions, m, within the grid; with two axes a list of pairs (x, y).
    dt : time between two entries, s: an entry is the first step at or after each multiple of ``dt`` from the start (to a
        millionth of ``dt``); steps are not shortened for it. None records every accepted step.

    Attributes
    ----------
    t : numpy.ndarray
        (k,) times, s, starting with the initial time.
    values : dict
        {observable: (k, number of positions)}.

    Raises
    ------
    ValueError
        When the run starts, for a position outside the grid, or numbers x on a grid with two axes.

    Examples
    --------
    >>> import fvkit as fv
    >>> import fvkit_granular as gr
    >>> gauge = fv.Gauge([-1.0, 1.0])
    >>> solution = fv.solve(gr.scene("dam-break").problem(gr.ShallowWater, 100), observers=gauge, backend="numpy")
    >>> len(gauge.t) == solution.stats.steps + 1, gauge.values["h"][0].round(12).tolist()
    (True, [2.0, 1.0])
    """

    x: np.ndarray = attrs.field(converter=lambda value: _positions(value))
    dt: float | None = validation.optional_number(above=0.0)
    _cells: Any = attrs.field(default=None, init=False, repr=False)
    _next: int = attrs.field(default=0, init=False, repr=False)

    def begin(self, problem: Problem) -> None:
        super().begin(problem)
        self._cells, self._next = problem.grid.cells_at(self.x, "`x` of a Gauge"), 0

    def see(self, problem: Problem, t: float, q: np.ndarray) -> None:
        if self.dt is not None:
            passed = intervals(problem.t_start, t, self.dt)
            if passed < self._next:
                return
            self._next = passed + 1
        aux = {name: values.reshape(-1)[self._cells] for name, values in problem.aux_averages.items()}
        self.add(t, observables(problem.model, problem.grid, q.reshape(len(q), -1)[:, self._cells], aux))

    def recall(self, problem: Problem, record: Mapping[str, np.ndarray]) -> None:
        super().recall(problem, record)
        if self.dt is not None and len(self.t):
            self._next = intervals(problem.t_start, float(self.t[-1]), self.dt) + 1

    def _shape(self) -> tuple[int, ...]:
        return (len(self.x),)

    @property
    def values(self) -> dict[str, np.ndarray]:
        """Entries, {observable: (k, number of positions)}."""
        return {name: values for name, values in self.record().items() if name}


#: Maps of `Extremes`.
_MAPS = ("largest", "smallest", "when")


@attrs.define(eq=False)
class Extremes(Observer):
    """Maps of the largest and smallest value of every observable in each cell, and of the time of the largest value.

    Attributes
    ----------
    largest, smallest : dict
        {observable: grid.shape}: (num_cells,), with two axes maps (ny, nx).
    when : dict
        {observable: grid.shape}, time at which the largest value was first reached, s.

    Examples
    --------
    >>> import fvkit as fv
    >>> import fvkit_granular as gr
    >>> extremes = fv.Extremes()
    >>> solution = fv.solve(gr.scene("dam-break").problem(gr.ShallowWater, 100), observers=extremes, backend="numpy")
    >>> round(float(extremes.largest["h"].max()), 12), extremes.magnitude("v").shape
    (2.0, (100,))
    """

    largest: dict[str, np.ndarray] = attrs.field(factory=dict, init=False, repr=False)
    smallest: dict[str, np.ndarray] = attrs.field(factory=dict, init=False, repr=False)
    when: dict[str, np.ndarray] = attrs.field(factory=dict, init=False, repr=False)

    def begin(self, problem: Problem) -> None:
        self.largest, self.smallest, self.when = {}, {}, {}

    def see(self, problem: Problem, t: float, q: np.ndarray) -> None:
        for name, values in observables(problem.model, problem.grid, q, problem.aux_averages).items():
            if name not in self.largest:
                self.largest[name], self.smallest[name] = np.array(values), np.array(values)
                self.when[name] = np.full(values.shape, t)
                continue
            self.when[name][values > self.largest[name]] = t
            np.maximum(self.largest[name], values, out=self.largest[name])
            np.minimum(self.smallest[name], values, out=self.smallest[name])

    def record(self) -> dict[str, np.ndarray]:
        return {f"{which} {name}": values for which in _MAPS for name, values in getattr(self, which).items()}

    def recall(self, problem: Problem, record: Mapping[str, np.ndarray]) -> None:
        for key, values in record.items():
            which, name = key.split(" ", 1)
            if which not in _MAPS or values.shape != problem.grid.shape:
                raise ValueError(f"Extremes have maps of {problem.grid.described} cells, {', '.join(_MAPS)}, got {key!r}")
            getattr(self, which)[name] = values

    def magnitude(self, name: str) -> np.ndarray:
        """Return the largest absolute value of an observable in each cell, grid.shape, such as the largest speed."""
        return np.maximum(np.abs(self.largest[name]), np.abs(self.smallest[name]))
