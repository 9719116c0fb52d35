"""Steps on a grid with two axes: sweeps along lines, x and y in turns, and what stands around them.

A step is sources, a sweep along each axis, sources, and settling. Steps come in pairs of equal length, xy and yx, which makes
them second order together. Sweeps fill the ghost cells of their own two sides; corners are never read.
"""

from abc import ABC, abstractmethod
from math import isfinite
from typing import Any, ClassVar, NamedTuple

import numpy as np

from fvkit.backends.kernel import ghosts_and_seen, imposed
from fvkit.backends.layout import padded_rows
from fvkit.backends.march import March, step_length
from fvkit.backends.plan import Plan, plan
from fvkit.backends.python_loop import Lost, StepwiseKernel, Trial
from fvkit.problem import fields
from fvkit.problem.model import aux_rows
from fvkit.problem.problem import Problem
from fvkit.problem.side import Section
from fvkit.problem.turned import stepped
from fvkit.schemes.scheme import Parts, Scheme
from fvkit.schemes.stages.driven import pulling_stages
from fvkit.schemes.wave_propagation import FACE

#: Where a sweep stands in a step: only the second sees what the faces of the first squeeze; the last leaves a settled state.
FIRST, SECOND, LAST = range(3)


class Report(NamedTuple):
    """What a sweep reports.

    Attributes
    ----------
    speed : largest speed at any face, NaN if any is.
    flux : (2, masses) mass fluxes through both sides, summed over the cells along them.
    bad : whether a state of the last sweep of a step may not be accepted, where the sweep `settles`.
    lost, lost_cell : faces that lost hyperbolicity, and the number of the cell behind the first of them.
    """

    speed: float
    flux: np.ndarray
    lost: Lost = Lost()
    lost_cell: int = -1
    bad: bool = False


class Border(NamedTuple):
    """A section of a side, with the ghost cells there and the cells that these look at, both along the axis.

    ``kept`` holds the values of a steady condition, ``quiet`` says that its ghost cells are 0 where the cells they look at are.
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
        self.model = self.direction.model
        self.rows = list(self.direction.rows)
        self.aside = list(self.direction.across + self.direction.still)
        self.plan = widened(plan(scheme.stages(parts)), halo)
        self.pulling = widened(plan(pulling_stages(FACE)), halo) if parts.joint else None
        self.borders = tuple(tuple(self._border(section, side == 0) for section in given)
                             for side, given in enumerate(problem.sides[number]))
        self.periodic = problem.sides[number][0][0].first.reads == "opposite"
        self.values: list[list[Any]] = []

    @abstractmethod
    def prepare(self, given: np.ndarray, threads: int) -> None:
        """Make what runs the stages, once it is known which of the ``given`` rows are not zero everywhere."""

    def idle(self, side: int) -> bool:
        """Whether it is known, without a look, that nothing has ever stood where the ghost cells of a side look."""
        return False

    def _border(self, section: Section, left: bool) -> Border:
        ghosts, seen = ghosts_and_seen(section.first.reads, left, self.halo, self.axis.num_cells)
        count = np.arange(self.halo, 0, -1.0) if left else np.arange(1.0, self.halo + 1.0)
        kept = section.values(self.model, self.problem.t_start) if section.steady else None
        quiet = kept is not None and self._quiet(section, kept)
        return Border(section, _slice(ghosts), _slice(seen), count[:, None], kept, quiet)

    def _quiet(self, section: Section, values: Any) -> bool:
        """Whether nothing comes in where nothing stands: of a state of zeros the ghost cells are zeros."""
        end, zeros = section.first, (np.zeros(1),) * len(self.rows)
        if any(np.any(through) for through in imposed(end, self.model, values)):
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
        """Fill the ghost cells of given rows: those of the model as the conditions say, others as the cells they look at."""
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
        """What conditions let through, for each section where they do: side, cells along it and the flux of each mass."""
        found = []
        for side, (borders, given) in enumerate(zip(self.borders, self.values, strict=True)):
            for border, values in zip(borders, given, strict=True):
                through = imposed(border.section.first, self.model, values)
                if through:
                    found.append((side, border.section.lanes, through))
        return found

    @abstractmethod
    def run(self, q: np.ndarray, out: np.ndarray, aux: np.ndarray, dt: float, place: int, other: np.ndarray) -> Report:
        """Write the state after a sweep into the cells of ``out``; with the ``place`` `LAST` a settled one, see `settles`.

        What the faces of the `FIRST` squeeze stands in the last row of ``other``, the given rows of the other axis.
        """

    @abstractmethod
    def pull(self, q: np.ndarray, out: np.ndarray, aux: np.ndarray) -> None:
        """Write velocity, push and bearing mass of every phase, three rows each, into the cells of ``out``."""


#: Numbers of lines and columns of cells in padded arrays.
Places = tuple[np.ndarray, np.ndarray]


class PlaneKernel(StepwiseKernel):
    """A kernel of a grid with two axes: a subclass says who runs the sweeps."""

    sweep_kind: type[Sweep]

    def __init__(self, problem: Problem, scheme: Scheme, parts: tuple[Parts, ...], threads: int = 1) -> None:
        self.problem, self.scheme, self.parts = problem, scheme, parts[0]
        self.mass_rows = list(problem.mass_rows)
        self.joint = bool(self.parts.joint)
        plans = [plan(scheme.stages(one)) for one in parts]
        self.halo = max(one.halo for one in plans)
        if min(problem.grid.shape) < self.halo:
            raise ValueError(f"`num_cells` must be >= {self.halo} along each axis for this scheme, got {problem.grid.num_cells}: "
                             "what varies along one axis alone is a problem on fv.Grid(lower, upper, num_cells)")
        self.sweeps = [self.sweep_kind(problem, scheme, one, k, self.halo) for k, one in enumerate(parts)]
        self._lay_out(problem)
        places = [source.acts_in() for source in self.parts.beside]
        self._few = all(cells is not None for cells in places)
        self._places = [None if cells is None else self._places_of(cells) for cells in places]
        for sweep, given in zip(self.sweeps, self.given, strict=True):
            sweep.prepare(given, threads)
        self.compile_seconds = sum(sweep.compile_seconds for sweep in self.sweeps)

    def _lay_out(self, problem: Problem) -> None:
        """Lay out the given functions, the fields of sources and, for each axis, what acts across it."""
        own, model = len(problem.model.aux), problem.model
        more = sum(field.size for field in problem.fields)
        self._known = own + more
        pulls = 3 * self.parts.across if self.joint else 0
        squeeze = int(self.parts.across > 0)
        first = self._empty(own + more + pulls + squeeze)
        for row, values in zip(first, aux_rows(model, problem.aux_averages), strict=False):
            self.inside(row[None])[0] = values
        for sweep in self.sweeps:
            sweep.fill_given(first, slice(0, own), of_the_model=True)
        self.given = [first, self._empty(len(first)) if pulls else first]
        self.given[1][:] = first
        if problem.fields:
            self.set_fields(problem.t_start)

    def set_fields(self, t: float) -> None:
        own = len(self.problem.model.aux)
        rows = fields.averages(self.problem.fields, t).reshape(-1, *self.problem.grid.shape)
        here = slice(own, own + len(rows))
        for sweep, given in zip(self.sweeps, self.given, strict=True):
            self.inside(given[here])[:] = rows
            sweep.fill_given(given, here, of_the_model=False)

    def padded(self, q: np.ndarray) -> np.ndarray:
        result = self._empty(len(q))
        self.inside(result)[:] = q
        return result

    def _empty(self, rows: int) -> np.ndarray:
        """Return zeros for cells and ghost cells."""
        ny, nx = self.problem.grid.shape
        return padded_rows(rows, (ny + 2 * self.halo, nx + 2 * self.halo), self.halo)

    def inside(self, padded: np.ndarray) -> np.ndarray:
        halo = self.halo
        return padded[:, halo:padded.shape[1] - halo, halo:padded.shape[2] - halo]

    @property
    def steady_boundary(self) -> bool:
        return self.problem.steady_boundary

    @property
    def book_rows(self) -> int:
        return 4 + max(1, len(self.parts.beside))

    @property
    def dx(self) -> float:
        return self.problem.grid.axes[0].dx

    def length(self, march: March, dt: float, target: float) -> tuple[float, bool]:
        fixed = march.bounds[0] > 0.0
        return step_length(march.t, dt, target, pair=march.steps % 2 == 0 and not fixed)

    def following(self, march: March, dt: float, longest: float) -> float:
        return longest if march.steps % 2 else dt

    def trial(self, march: March, dt: float) -> Trial:
        kept: list[tuple[Places | None, np.ndarray]] = []
        try:
            return self._tried(march, dt, kept)
        finally:  # also where Ctrl-C ends it: the accepted state is what a run saves
            for where, values in kept[::-1]:
                self._put(march.now, where, values)

    def _tried(self, march: March, dt: float, kept: list[tuple[Places | None, np.ndarray]]) -> Trial:
        """Try a step, and note in ``kept`` the cells of the accepted state that sources change in place."""
        splitting, middle = self.scheme.splitting, march.t + 0.5 * dt
        first, second = self.sweeps if march.steps % 2 == 0 else self.sweeps[::-1]
        brought = np.zeros((self.book_rows - 4, max(len(self.mass_rows), 1)))
        if not self.steady_fields:
            self.set_fields(middle)
        start = march.now
        if self.parts.beside and splitting.before > 0.0:
            if not self._few:
                self.inside(march.next)[:] = self.inside(start)
                start = march.next
            for source, where, gain in zip(self.parts.beside, self._places, brought, strict=False):
                if self._few:
                    kept.append((where, self._cells(start, where)))
                self._act(source, start, splitting.before * dt, gain, where)
        first.fill(start, middle)
        self._look_round(start)
        if self.joint:
            self._look_across(start, middle, first)
        if self.parts.across:
            self._clear(self.given[first.number][-1])
        one = first.run(start, march.next, self.given[first.number], dt, FIRST, self.given[second.number])
        if isfinite(one.speed) and one.speed * dt / first.axis.dx > self.scheme.cfl_max:
            # The step is too long, and its state may have negative masses: the second sweep must not see it.
            return Trial(one.speed * self.dx / first.axis.dx, False, np.zeros((4, brought.shape[1])), brought, Lost(), -1)
        second.fill(march.next, middle)
        if self.parts.across:
            squeezed = self.given[second.number]
            second.fill_given(squeezed, slice(len(squeezed) - 1, len(squeezed)), of_the_model=False)
        self._look_round(march.next, second)
        later = list(zip(self.parts.beside, self._places, brought, strict=False))[::-1] if splitting.after > 0.0 else []
        few = second.settles and self._few
        other = second.run(march.next, march.next, self.given[second.number], dt, LAST if few else SECOND,
                           self.given[first.number])
        acted = [where for source, where, gain in later if self._act(source, march.next, splitting.after * dt, gain, where)]
        good = not (few and other.bad)
        for where in acted if few else [None]:
            self._settle(march.next, where)
            good = good and self._good(march.next, where)
        scales = [self.dx / sweep.axis.dx for sweep in (first, second)]
        widths = [self.volume / sweep.axis.dx for sweep in (first, second)]
        speed = max(one.speed * scales[0], other.speed * scales[1])
        if not isfinite(one.speed + other.speed):
            speed = float("nan")
        through = [one.flux * widths[0], other.flux * widths[1]]
        flux = np.concatenate(through if first.number == 0 else through[::-1])
        lost = Lost(one.lost.faces + other.lost.faces, one.lost.films + other.lost.films,
                    max(one.lost.deepest, other.lost.deepest))
        return Trial(speed, good, flux, brought, lost, max(one.lost_cell, other.lost_cell))

    def _look_round(self, q: np.ndarray, sweep: Sweep | None = None) -> None:
        """Find where something stands, before a step (None) or in the ghost cells of a sweep; a kernel may leave out the rest."""

    def _clear(self, row: np.ndarray) -> None:
        """Set to 0 a padded row that sweeps write."""
        row[:] = 0.0

    def _look_across(self, q: np.ndarray, t: float, filled: Sweep) -> None:
        """Write the velocity of each phase across every axis, what pushes it there and the mass that bears it.

        The ghost cells of the sweep ``filled`` hold those of time t already.
        """
        for sweep, other in zip(self.sweeps, self.sweeps[::-1], strict=True):
            given = self.given[other.number]
            target = given[len(given) - 1 - 3 * self.parts.across:len(given) - 1]
            if sweep is not filled:
                sweep.fill(q, t)
            sweep.pull(q, target, self.given[sweep.number])
            other.fill_given(target, slice(0, len(target)), of_the_model=False)

    def _places_of(self, cells: np.ndarray) -> Places:
        """Return where cells stand in padded arrays, from their numbers in arrays of cells."""
        rows, columns = np.unravel_index(cells, self.problem.grid.shape)
        return rows + self.halo, columns + self.halo

    def _cells(self, padded: np.ndarray, where: Places | None) -> np.ndarray:
        """Return the values of cells, (rows, cells), a copy; a view of all of them, (rows, ny, nx), for None."""
        return self.inside(padded) if where is None else padded[:, *where]

    def _put(self, padded: np.ndarray, where: Places | None, values: Any) -> None:
        """Write the values of cells."""
        target = self.inside(padded) if where is None else padded
        for row, component in zip(target, values, strict=True):
            row[... if where is None else where] = component

    def _act(self, source: Any, q: np.ndarray, dt: float, brought: np.ndarray, where: Places | None) -> bool:
        """Let a source act on its cells for dt, add what it makes of each mass to ``brought``; tell whether it did anything."""
        inside, sweep = self._cells(q, where), self.sweeps[0]
        if where is not None and not source.wets and not inside.any():
            return False
        plane = source.turns and self.parts.across
        places = [*sweep.rows, *sweep.direction.across] if plane else list(range(len(inside)))
        aux = tuple(self._cells(self.given[0][:self._known], where))
        before = tuple(inside[row] for row in places)
        if plane:
            after = stepped(source, sweep.model, before, lambda state: source.step(self.parts.model, state, aux, dt))
        else:
            after = source.step(self.parts.model, before, aux, dt)
        for k, row in enumerate(map(places.index, self.mass_rows)):
            if after[row] is not before[row]:
                brought[k] += np.add.reduce(after[row] - before[row], axis=None)
        self._put(q, where, [after[places.index(row)] for row in range(len(inside))])
        return True

    def _settle(self, q: np.ndarray, where: Places | None) -> None:
        """Let what is too thin to move lose its momenta."""
        if not self.problem.model.defines("settle"):
            return
        inside = self._cells(q, where)
        for sweep in self.sweeps:
            for row, component in zip(sweep.rows, sweep.model.settle(tuple(inside[row] for row in sweep.rows)), strict=True):
                inside[row] = component
        if where is not None:
            self._put(q, where, inside)

    def _good(self, padded: np.ndarray, where: Places | None) -> bool:
        """Whether a state is finite, without negative masses, and admissible."""
        q = self._cells(padded, where)
        if not isfinite(np.add.reduce(q, None)) or any(q[row].min(initial=0.0) < 0.0 for row in self.mass_rows):
            return False
        return all(bool(np.all(sweep.model.admissible(tuple(q[row] for row in sweep.rows))))
                   for sweep in self.sweeps if sweep.model.defines("admissible"))


def widened(found: Plan, halo: int) -> Plan:
    """Return a plan with the halo that all sweeps share."""
    return Plan(found.stages, found.ranges, halo)


def _slice(cells: range) -> slice:
    return slice(cells.start, cells.stop if cells.stop >= 0 else None, cells.step)
