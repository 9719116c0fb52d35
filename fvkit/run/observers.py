"""Observers: what is noted during a run, without keeping its states. They go into ``observers`` of `fvkit.solve`."""

from abc import ABC, abstractmethod
from collections.abc import Mapping
from typing import Any

import attrs
import numpy as np

from fvkit import validation
from fvkit.problem.problem import Problem
from fvkit.run.step_length import intervals
from fvkit.run.stepper import Stepper


@attrs.define(eq=False)
class Observer(ABC):
    """Abstract observer that takes notes of one run. Contract:

    1. ``begin(problem)`` is called when a run starts; it forgets the run before.
    2. ``see(problem, t, q)`` is called with the start, t and q (num_eqn, n), and then after each accepted step; q is a view
       that the next step changes.
    3. ``record()`` returns the notes so far, {name: array}, and ``recall(problem, record)`` takes such notes back, after
       ``begin``, or raises ValueError. A checkpoint keeps them, so that an observer of the same class and fields goes on with a
       run that `fvkit.resume` continues. Without them the run is seen from there on, which `fvkit.resume` says.

    A run with observers comes back to Python after every step: about ten microseconds each (measured), beside their own work.
    """

    _stepper: Stepper | None = attrs.field(default=None, init=False, repr=False)
    _steps: int = attrs.field(default=0, init=False, repr=False)

    def __call__(self, stepper: Stepper) -> None:
        """Take the notes of a step."""
        problem = stepper.problem
        if stepper is not self._stepper:
            self._stepper = stepper
            self.begin(problem)
            if stepper.steps == 1:
                self.see(problem, problem.t_start, problem.q0)
        self.see(problem, stepper.t, stepper.q)
        self._steps = stepper.steps

    def notes(self, stepper: Stepper) -> dict[str, np.ndarray] | None:
        """What a checkpoint of a run keeps of this observer; None where it has not begun, or keeps no record."""
        record = self.record() if self._stepper is stepper else None
        return None if record is None else {**record, "steps": np.array(float(self._steps))}

    def go_on(self, stepper: Stepper, notes: Mapping[str, np.ndarray]) -> None:
        """Take `notes` back, where a run goes on; ValueError where they are not those of such an observer."""
        problem = stepper.problem
        self._stepper, self._steps = stepper, stepper.steps
        self.begin(problem)
        self.recall(problem, {name: values for name, values in notes.items() if name != "steps"})
        if notes["steps"] < stepper.steps:  # an exception came between the step and its notes
            self.see(problem, stepper.t, stepper.q)

    @abstractmethod
    def begin(self, problem: Problem) -> None:
        """Start a new run."""

    @abstractmethod
    def see(self, problem: Problem, t: float, q: np.ndarray) -> None:
        """Take notes of the state at a time."""

    def record(self) -> dict[str, np.ndarray] | None:
        """Return all notes as arrays of floats; None keeps no record."""
        return None

    def recall(self, problem: Problem, record: Mapping[str, np.ndarray]) -> None:
        """Take the notes of a `record` back."""
        raise NotImplementedError(f"{type(self).__name__} defines `record`, so it must define `recall`")


@attrs.define
class _Series:
    """Values that come one after the other, in arrays that grow by doubling."""

    _values: dict[str, np.ndarray] = attrs.field(factory=dict)
    _count: int = 0

    def add(self, values: dict[str, Any]) -> None:
        """Add one value of each name."""
        for name, value in values.items():
            kept = self._values.get(name)
            if kept is None or len(kept) == self._count:
                longer = np.empty((max(64, 2 * self._count), *np.shape(value)))
                if kept is not None:
                    longer[:self._count] = kept
                kept = self._values[name] = longer
            kept[self._count] = value
        self._count += 1

    def __getitem__(self, name: str) -> np.ndarray:
        return self._values[name][:self._count] if name in self._values else np.empty(0)

    def arrays(self) -> dict[str, np.ndarray]:
        """The values of all names."""
        return {name: self[name] for name in self._values}


def _positions(value: Any) -> np.ndarray:
    return np.array(validation.row(value, "x"))


@attrs.define(eq=False)
class Gauge(Observer):
    """Time series of all observables at some places: the averages of the cells that hold them.

    Parameters
    ----------
    x : one position or several, m, within the grid.
    dt : time between two entries, s: the first step at or after each multiple from the start (a millionth of ``dt`` is
        rounding) is noted, and no step is shortened for it; None notes every accepted step.

    Attributes
    ----------
    t : numpy.ndarray
        (k,) times, s, the start first.
    values : dict
        {observable: (k, number of positions)}.

    Raises
    ------
    ValueError
        When the run starts, for a position outside the grid.
    """

    x: np.ndarray = attrs.field(converter=_positions)
    dt: float | None = validation.optional_number(above=0.0)
    _series: _Series = attrs.field(factory=_Series, init=False, repr=False)
    _cells: Any = attrs.field(default=None, init=False, repr=False)
    _next: int = attrs.field(default=0, init=False, repr=False)

    def begin(self, problem: Problem) -> None:
        grid = problem.grid
        outside = self.x[(self.x < grid.lower) | (self.x > grid.upper)]
        if len(outside):
            raise ValueError(f"`x` of a Gauge must be within [{grid.lower:g}, {grid.upper:g}], got {outside[0]:g}")
        self._cells = np.clip(np.searchsorted(grid.edges, self.x, side="right") - 1, 0, grid.num_cells - 1)
        self._series, self._next = _Series(), 0

    def see(self, problem: Problem, t: float, q: np.ndarray) -> None:
        if self.dt is not None:
            passed = intervals(problem.t_start, t, self.dt)
            if passed < self._next:
                return
            self._next = passed + 1
        aux = {name: values[self._cells] for name, values in problem.aux_averages.items()}
        self._series.add({"": t, **problem.model.observables(q[:, self._cells], aux)})

    def record(self) -> dict[str, np.ndarray]:
        return self._series.arrays()

    def recall(self, problem: Problem, record: Mapping[str, np.ndarray]) -> None:
        count = len(record[""])
        if any(values.shape != (count, len(self.x)) for name, values in record.items() if name):
            raise ValueError(f"a Gauge of {len(self.x)} positions has as many columns for each of its {count} times")
        self._series = _Series(dict(record), count)
        if self.dt is not None and count:
            self._next = intervals(problem.t_start, float(record[""][-1]), self.dt) + 1

    @property
    def t(self) -> np.ndarray:
        """Times of the entries, (k,)."""
        return self._series[""]

    @property
    def values(self) -> dict[str, np.ndarray]:
        """Entries, {observable: (k, number of positions)}."""
        return {name: values for name, values in self._series.arrays().items() if name}


#: Maps of `Extremes`.
_MAPS = ("largest", "smallest", "when")


@attrs.define(eq=False)
class Extremes(Observer):
    """Maps of the largest and smallest value that every observable had in each cell, and when it was largest.

    Attributes
    ----------
    largest, smallest : dict
        {observable: (num_cells,)}.
    when : dict
        {observable: (num_cells,)}, time at which the largest was first there, s.
    """

    largest: dict[str, np.ndarray] = attrs.field(factory=dict, init=False, repr=False)
    smallest: dict[str, np.ndarray] = attrs.field(factory=dict, init=False, repr=False)
    when: dict[str, np.ndarray] = attrs.field(factory=dict, init=False, repr=False)

    def begin(self, problem: Problem) -> None:
        self.largest, self.smallest, self.when = {}, {}, {}

    def see(self, problem: Problem, t: float, q: np.ndarray) -> None:
        for name, values in problem.model.observables(q, problem.aux_averages).items():
            if name not in self.largest:
                self.largest[name], self.smallest[name] = np.array(values), np.array(values)
                self.when[name] = np.full(len(values), t)
                continue
            self.when[name][values > self.largest[name]] = t
            np.maximum(self.largest[name], values, out=self.largest[name])
            np.minimum(self.smallest[name], values, out=self.smallest[name])

    def record(self) -> dict[str, np.ndarray]:
        return {f"{which} {name}": values for which in _MAPS for name, values in getattr(self, which).items()}

    def recall(self, problem: Problem, record: Mapping[str, np.ndarray]) -> None:
        for key, values in record.items():
            which, name = key.split(" ", 1)
            if which not in _MAPS or values.shape != (problem.grid.num_cells,):
                raise ValueError(f"Extremes have maps of {problem.grid.num_cells} cells, {', '.join(_MAPS)}, got {key!r}")
            getattr(self, which)[name] = values

    def magnitude(self, name: str) -> np.ndarray:
        """Return the largest absolute value of an observable in each cell, (num_cells,): the top speed for a velocity."""
        return np.maximum(np.abs(self.largest[name]), np.abs(self.smallest[name]))
