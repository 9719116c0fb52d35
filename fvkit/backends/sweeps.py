"""A sweep along one axis of a grid with two: its stages, on all lines, and the ghost cells of its own two sides.

Corners are never read.
"""

from abc import ABC, abstractmethod
from typing import Any, ClassVar, NamedTuple

import numpy as np

from fvkit.backends.kernel import as_slice, ghosts_and_seen, imposed
from fvkit.backends.plan import Plan, plan
from fvkit.backends.python_loop import SweepOutcome
from fvkit.problem.grid import Side
from fvkit.problem.problem import Problem
from fvkit.problem.side import Section
from fvkit.schemes.scheme import Parts, Scheme
from fvkit.schemes.stages.driven import pulling_stages
from fvkit.schemes.wave_propagation import FACE

#: Where a sweep stands in a step: only the second reads the compression that the first finds; the last leaves a settled state.
FIRST, SECOND, LAST = range(3)


class Border(NamedTuple):
    """A section of a side, with its ghost cells and the cells that these copy, both along the axis.

    ``kept`` has the values of a steady condition; with ``quiet`` its ghost cells are 0 where the cells that they copy are.
    """

    section: Section
    ghosts: slice
    seen: slice
    numbers: np.ndarray
    kept: Any
    quiet: bool


class Sweep(ABC):
    """Abstract sweep along one axis. Contract:

    1. `run` makes the state after a time dt of transport along the axis, with the sources that act with it, of padded arrays
       (rows, ny + 2 halo, nx + 2 halo); ghost cells have been filled.
    2. A sweep that ``settles`` leaves the last state of a step as `Model.settle` does, and judges it; ``out`` may be ``q``.
    3. ``blocks`` are those that a backend computes, where it leaves out idle ones.
    4. `pull` writes the velocity of each phase along the axis, what pushes it there and the mass that bears it, of each cell.
    """

    settles: ClassVar[bool] = False
    compile_seconds: float = 0.0
    blocks: Any = None

    def __init__(self, problem: Problem, scheme: Scheme, parts: Parts, number: int, halo: int) -> None:
        self.scheme = scheme
        self.problem, self.parts, self.number, self.halo = problem, parts, number, halo
        self.direction, self.axis = problem.directions[number], problem.grid.axes[number]
        self.model = parts.model  # in which ends see the gravity of steep ground
        self.rows = list(self.direction.rows)
        self.aside = list(self.direction.across + self.direction.still)
        self.plan = widened(plan(scheme.stages(parts)), halo)
        self.pulling = widened(plan(pulling_stages(FACE)), halo) if parts.joint else None
        self.borders = tuple(tuple(self._border(section, Side(number, upper)) for section in given)
                             for upper, given in zip((False, True), problem.sides[number], strict=True))
        self.periodic = problem.sides[number][0][0].first.reads == "opposite"
        self.values: list[list[Any]] = []

    @abstractmethod
    def prepare(self, given: np.ndarray, threads: int) -> None:
        """Make what runs the stages, once it is known which of the ``given`` rows are not zero everywhere."""

    def idle(self, side: int) -> bool:
        """Whether it is known, without a look, that nothing has ever stood where the ghost cells of a side look."""
        return False

    def _border(self, section: Section, side: Side) -> Border:
        ghosts, seen = ghosts_and_seen(section.first.reads, side, self.halo, self.axis.num_cells)
        count = np.arange(1.0, self.halo + 1.0) if side.upper else np.arange(self.halo, 0, -1.0)
        kept = section.values(self.model, self.problem.t_start) if section.steady else None
        quiet = kept is not None and self._quiet(section, kept)
        return Border(section, as_slice(ghosts), as_slice(seen), count[:, None], kept, quiet)

    def _quiet(self, section: Section, values: Any) -> bool:
        """Whether ghost cells of a dry side are dry: those of a state of zeros are zeros."""
        end, zeros = section.first, (np.zeros(1),) * len(self.rows)
        if any(np.any(np.nan_to_num(through)) for through in imposed(end, self.model, values)):
            return False
        with np.errstate(all="ignore"):
            beyond = (*end.ghost(self.model, zeros, end.layer(values, np.ones(1))), *end.across(zeros[:len(self.aside)], 0.0))
        return not any(np.any(item) for item in beyond)

    def lines(self, padded: np.ndarray) -> np.ndarray:
        """View of a padded array as (rows, cells along the axis and ghost cells, lines)."""
        turned_round = np.moveaxis(padded, 2 - self.number, 1)
        return turned_round[:, :, self.halo:turned_round.shape[2] - self.halo]

    def fill(self, q: np.ndarray, t: float) -> None:
        """Fill the ghost cells of both sides of a padded state."""
        whole, model = self.lines(q), self.model
        carriers = [self.rows[phase.masses[-1]] for phase in model.phases]
        self.values = []
        for side, borders in enumerate(self.borders):
            self.values.append([])
            idle = self.idle(side)
            for section, ghosts, seen, numbers, kept, quiet in borders:
                values = section.values(model, t) if kept is None else kept
                self.values[-1].append(values)
                end, lanes = section.first, section.lanes
                if quiet and (idle or not whole[:, seen, lanes].any()):
                    if not idle:
                        whole[:, ghosts, lanes] = 0.0
                    continue
                state = tuple(whole[row, seen, lanes] for row in self.rows)
                for row, item in zip(self.rows, end.ghost(model, state, end.layer(values, numbers)), strict=True):
                    whole[row, ghosts, lanes] = item
                momenta = tuple(whole[row, seen, lanes] for row in self.aside)
                if model.phases:
                    pairs = [(whole[row, seen, lanes], whole[row, ghosts, lanes]) for row in carriers]
                    momenta = tuple(np.where(old == new, w, w * (new / np.where(old > 0.0, old, 1.0)))
                                    for w, (old, new) in zip(momenta, pairs, strict=True))
                for row, item in zip(self.aside, end.across(momenta, t), strict=True):
                    whole[row, ghosts, lanes] = item

    def fill_given(self, padded: np.ndarray, rows: slice, of_the_model: bool) -> None:
        """Fill the ghost cells of given rows: those of the model by the conditions, others with the cells that they copy."""
        whole = self.lines(padded)[rows]
        for side in self.borders:
            for section, ghosts, seen, _, _, _ in side:
                if not of_the_model:
                    whole[:, ghosts, section.lanes] = whole[:, seen, section.lanes]
                    continue
                outside, inside = (np.arange(whole.shape[1])[here] for here in (ghosts, seen))
                inside = np.broadcast_to(inside, outside.shape)
                distance = np.abs(outside - inside) * self.axis.dx
                for lane, end in zip(range(section.lanes.start, section.lanes.stop), section.ends, strict=True):
                    whole[:, outside, lane] = end.ghost_aux(self.model, whole[:, inside, lane], distance)

    def fluxes(self) -> list[tuple[int, slice, Any]]:
        """Mass fluxes that conditions impose, for each section: side, cells along it and the flux of each mass."""
        found = []
        for side, (borders, given) in enumerate(zip(self.borders, self.values, strict=True)):
            for border, values in zip(borders, given, strict=True):
                through = imposed(border.section.first, self.model, values)
                if through:
                    found.append((side, border.section.lanes, through))
        return found

    @abstractmethod
    def run(self, q: np.ndarray, out: np.ndarray, aux: np.ndarray, dt: float, place: int, other: np.ndarray) -> SweepOutcome:
        """Write the state after a sweep into the cells of ``out``; with the ``place`` `LAST` a settled one, see `settles`.

        The compression at the faces of the `FIRST` stands in the last row of ``other``, the given rows of the other axis.
        """

    @abstractmethod
    def pull(self, q: np.ndarray, out: np.ndarray, aux: np.ndarray) -> None:
        """Write velocity, push and bearing mass of every phase, three rows each, into the cells of ``out``."""


def widened(found: Plan, halo: int) -> Plan:
    """Return a plan with the halo that all sweeps share."""
    return Plan(found.stages, found.ranges, halo)
