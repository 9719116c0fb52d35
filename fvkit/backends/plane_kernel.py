"""Steps on a grid with two axes: sources, a sweep along each axis, sources, and settling.

Steps come in pairs of equal length, xy and yx, which makes them second order together.
"""

from math import isfinite
from typing import Any

import numpy as np

from fvkit.backends.layout import padded_rows
from fvkit.backends.march import March
from fvkit.backends.numpy_stages import accepted, settle
from fvkit.backends.plan import plan
from fvkit.backends.python_loop import LostFaces, StepwiseKernel, SweepOutcome, Trial, together
from fvkit.backends.step_length import step_length
from fvkit.backends.sweeps import FIRST, LAST, SECOND, Sweep
from fvkit.problem import fields
from fvkit.problem.model import aux_rows
from fvkit.problem.problem import Problem
from fvkit.problem.sources import brought
from fvkit.problem.turned import stepped
from fvkit.schemes.scheme import Parts, Scheme

#: Numbers of lines and columns of cells in padded arrays.
Places = tuple[np.ndarray, ...]

#: Places, None for all cells, and what stood there.
Kept = list[tuple[Places | None, np.ndarray]]


class PlaneKernel(StepwiseKernel):
    """A kernel of a grid with two axes: a subclass runs the sweeps."""

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
        self._models = [(sweep.model, sweep.rows) for sweep in self.sweeps]
        self._lay_out(problem)
        places = [source.acts_in() for source in self.parts.beside]
        self._few = all(cells is not None for cells in places)
        self._places = [None if cells is None else tuple(k + self.halo for k in np.unravel_index(cells, problem.grid.shape))
                        for cells in places]
        for sweep, given in zip(self.sweeps, self.given, strict=True):
            sweep.prepare(given, threads)
        self.compile_seconds = sum(sweep.compile_seconds for sweep in self.sweeps)

    def _lay_out(self, problem: Problem) -> None:
        """Lay out the given functions, the fields of sources and, for each axis, what acts across it."""
        own, model = len(problem.model.aux), problem.model
        more = sum(field.size for field in problem.fields)
        self._known = own + more
        pulls = 3 * self.parts.across if self.joint else 0
        compression = int(self.parts.across > 0)
        first = self.padded(np.zeros((own + more + pulls + compression, *problem.grid.shape)))
        for row, values in zip(first, aux_rows(model, problem.aux_averages), strict=False):
            self.inside(row[None])[0] = values
        for sweep in self.sweeps:
            sweep.fill_given(first, slice(0, own), of_the_model=True)
        self.given = [first, self.padded(self.inside(first)) if pulls else first]
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
        ny, nx = q.shape[1:]
        result = padded_rows(len(q), (ny + 2 * self.halo, nx + 2 * self.halo), self.halo)
        self.inside(result)[:] = q
        return result

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
        kept: Kept = []
        try:
            return self._trial_step(march, dt, kept)
        finally:  # also after Ctrl-C: a run saves the accepted state
            for where, values in kept[::-1]:
                self._put(march.now, where, values)

    def _trial_step(self, march: March, dt: float, kept: Kept) -> Trial:
        """Try a step, and note in ``kept`` the cells of the accepted state that sources change in place."""
        splitting, pair = self.scheme.splitting, self.sweeps if march.steps % 2 == 0 else self.sweeps[::-1]
        gained = np.zeros((self.book_rows - 4, max(len(self.mass_rows), 1)))
        if not self.steady_fields:
            self.set_fields(march.t + 0.5 * dt)
        start = self._acted_before(march, splitting.before * dt, gained, kept)
        reports = self._swept(start, march.next, march.t + 0.5 * dt, dt, pair)
        if len(reports) == 1:
            speed = reports[0].speed * self.dx / pair[0].axis.dx
            return Trial(speed, False, np.zeros((4, gained.shape[1])), gained, LostFaces(), -1)
        speed = max(report.speed * (self.dx / sweep.axis.dx) for report, sweep in zip(reports, pair, strict=True))
        if not isfinite(sum(report.speed for report in reports)):
            speed = float("nan")
        good = self._acted_after(march.next, splitting.after * dt, gained, pair[1].settles and self._few, reports[1].bad)
        flux = [report.flux * (self.volume / sweep.axis.dx) for report, sweep in zip(reports, pair, strict=True)]
        return Trial(speed, good, np.concatenate(flux if pair[0].number == 0 else flux[::-1]), gained,
                     together(report.lost for report in reports), max(report.lost_cell for report in reports))

    def _acted_before(self, march: March, dt: float, gained: np.ndarray, kept: Kept) -> np.ndarray:
        """Return the state after a time dt of the sources before the transport."""
        if not (self.parts.beside and dt > 0.0):
            return march.now
        if not self._few:
            self.inside(march.next)[:] = self.inside(march.now)
        start = march.now if self._few else march.next
        for source, where, gain in zip(self.parts.beside, self._places, gained, strict=False):
            if self._few:
                kept.append((where, self._cells(start, where)))
            self._act(source, start, dt, gain, where)
        return start

    def _swept(self, start: np.ndarray, out: np.ndarray, t: float, dt: float, pair: list[Sweep]) -> list[SweepOutcome]:
        """Write into ``out`` the state after both sweeps, with boundaries of time t; return what they report.

        After a sweep for which the step is too long, whose state may have negative masses, there is no second one.
        """
        first, second = pair
        first.fill(start, t)
        self._find_active(start)
        if self.joint:
            self._fill_joint_rows(start, t, first)
        if self.parts.across:
            self._clear(self.given[first.number][-1])
        one = first.run(start, out, self.given[first.number], dt, FIRST, self.given[second.number])
        if isfinite(one.speed) and one.speed * dt / first.axis.dx > self.scheme.cfl_max:
            return [one]
        second.fill(out, t)
        if self.parts.across:
            compression = self.given[second.number]
            second.fill_given(compression, slice(len(compression) - 1, len(compression)), of_the_model=False)
        self._find_active(out, second)
        place = LAST if second.settles and self._few else SECOND
        return [one, second.run(out, out, self.given[second.number], dt, place, self.given[first.number])]

    def _acted_after(self, q: np.ndarray, dt: float, gained: np.ndarray, settled: bool, bad: bool) -> bool:
        """Let the sources after the transport act on q for dt, and settle it; return whether it may be accepted.

        A state that the last sweep has ``settled`` is looked at only where sources have acted since.
        """
        later = list(zip(self.parts.beside, self._places, gained, strict=False))[::-1] if dt > 0.0 else []
        acted = [where for source, where, gain in later if self._act(source, q, dt, gain, where)]
        good = not (settled and bad)
        for where in acted if settled else [None]:
            cells = self._cells(q, where)
            settle(cells, self._models)
            if where is not None and self.problem.model.defines("settle"):
                self._put(q, where, cells)
            good = good and accepted(cells, self.mass_rows, self._models)
        return good

    def _find_active(self, q: np.ndarray, sweep: Sweep | None = None) -> None:
        """Find the cells with mass, before a step (None) or in the ghost cells of a sweep; a kernel may leave out the others."""

    def _clear(self, row: np.ndarray) -> None:
        """Set to 0 a padded row that sweeps write."""
        row[:] = 0.0

    def _fill_joint_rows(self, q: np.ndarray, t: float, filled: Sweep) -> None:
        """Write the velocity of each phase across every axis, its push there and the mass that takes it.

        The ghost cells of the sweep ``filled`` hold those of time t already.
        """
        for sweep, other in zip(self.sweeps, self.sweeps[::-1], strict=True):
            given = self.given[other.number]
            target = given[len(given) - 1 - 3 * self.parts.across:len(given) - 1]
            if sweep is not filled:
                sweep.fill(q, t)
            sweep.pull(q, target, self.given[sweep.number])
            other.fill_given(target, slice(0, len(target)), of_the_model=False)

    def _cells(self, padded: np.ndarray, where: Places | None) -> np.ndarray:
        """Return the values of cells, (rows, cells), a copy; a view of all of them, (rows, ny, nx), for None."""
        return self.inside(padded) if where is None else padded[:, where[0], where[1]]

    def _put(self, padded: np.ndarray, where: Places | None, values: Any) -> None:
        """Write the values of cells."""
        target = self.inside(padded) if where is None else padded
        for row, component in zip(target, values, strict=True):
            row[... if where is None else where] = component

    def _act(self, source: Any, q: np.ndarray, dt: float, gained: np.ndarray, where: Places | None) -> bool:
        """Apply a source to its cells for dt, add the change of each mass to ``gained``; return whether anything changed."""
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
        for k, gain in brought(list(map(places.index, self.mass_rows)), before, after):
            gained[k] += np.add.reduce(gain, axis=None)
        self._put(q, where, [after[places.index(row)] for row in range(len(inside))])
        return True
