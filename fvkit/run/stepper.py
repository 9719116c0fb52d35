"""`Stepper`: time stepping of one problem with one scheme, step by step."""

import time as clock
import warnings
from collections.abc import Mapping
from typing import NoReturn

import numpy as np

from fvkit import validation
from fvkit.backends import BACKENDS, March, Outcome, backend_for, make_kernel, threads_for
from fvkit.backends.march import FILM, MICRO
from fvkit.output.status import Interrupted, SolveError, Stats, Status
from fvkit.pointwise.part import unwrapped
from fvkit.problem.directions import SIDES
from fvkit.problem.problem import Problem
from fvkit.run.diagnosis import diagnosis, largest_speed, speeds, wrong_speed
from fvkit.run.step_bounds import Step
from fvkit.schemes.fitting import assemble
from fvkit.schemes.scheme import Scheme

#: Number of steps above that of any run.
UNLIMITED = 2**62

#: Parts of a run in each of which sources and conditions that vary in time are looked at while all is dry.
IDLE = 100

#: In statistics with one axis: its ends, and all sources together.
ENDS, SOURCES = ("left", "right"), "sources"

#: Relative change below which an update with zero wave speed counts as round-off.
NOTHING = 1e-9


class Stepper:
    """Time stepper of one problem with one scheme, step by step; `solve` is built on it.

    Parameters
    ----------
    problem : the problem.
    scheme : the scheme; None for second-order wave propagation with the model's default Riemann solver.
    backend : ``"auto"``, ``"numba"`` (compiled) or ``"numpy"``; auto compiles where numba is installed, unless the
        environment variable FVKIT_BACKEND names another.
    nonhyperbolic : reaction to complex characteristic speeds: ``"warn"`` once, ``"raise"`` or ``"ignore"``.
    threads : number of threads of a compiled run, or ``"all"``; more than 1 only from 100,000 cells on a line on,
        with two axes for any number; bit-identical to one.
    step : length of the time steps, None for the Courant number of the scheme, see `Step`.

    Attributes
    ----------
    t : float
        Current time, s.
    q : numpy.ndarray
        (num_eqn, *grid.shape) current cell averages; a view, read-only.

    Raises
    ------
    ValueError
        If scheme and model cannot work together, naming both.

    Examples
    --------
    >>> import fvkit as fv
    >>> import numpy as np
    >>> wave = lambda x: [np.sin(2.0 * np.pi * x)]
    >>> problem = fv.Problem(fv.Advection(1.0), fv.Grid(0.0, 1.0, 50), wave, 1.0, boundary=fv.Periodic())
    >>> stepper = fv.Stepper(problem, backend="numpy")
    >>> round(stepper.step(), 6)
    0.017857
    >>> stepper.advance(0.1)
    >>> stepper.t, stepper.steps
    (0.1, 6)
    """

    def __init__(self, problem: Problem, scheme: Scheme | None = None, backend: str = "auto",
                 nonhyperbolic: str = "warn", threads: int | str = 1, step: Step | None = None) -> None:
        validation.choice(backend, "backend", BACKENDS)
        self.nonhyperbolic = validation.choice(nonhyperbolic, "nonhyperbolic", ("warn", "raise", "ignore"))
        self.problem = problem
        if isinstance(scheme, Scheme):
            backend_for(scheme.riemann, backend)
        self.scheme, every = assemble(problem, scheme)
        self.threads = threads_for(threads, problem, self.scheme, backend)
        self._asked = tuple(parts.model for parts in every)
        self.length = Step() if step is None else validation.instance(step, "step", Step, "such as fv.Step(dt_max=0.1)")
        kernel = self._kernel = make_kernel(backend, problem, self.scheme, every, self.threads)
        first = min(self._first_dt(), self.length.dt_initial or np.inf)
        self._march = March((kernel.padded(problem.q0), kernel.padded(problem.q0)), problem.t_start, first, kernel.books,
                            stop_when_lost=self.nonhyperbolic == "raise", bounds=self.length.bounds)
        self._march.dt = self._march.bounded(first)
        self._breaks = problem.breaks
        self._seconds = 0.0

    def __repr__(self) -> str:
        return (f"<Stepper of {self.problem.model} with {self.scheme}, {self._kernel.name}: t = {self.t:g} of "
                f"{self.problem.t_end:g} s, {self.steps} steps>")

    @property
    def t(self) -> float:
        """Current time, s."""
        return self._march.t

    @property
    def steps(self) -> int:
        """Accepted steps so far."""
        return self._march.steps

    @property
    def seconds(self) -> float:
        """Wall time of the stepping so far, s."""
        return self._seconds

    @property
    def q(self) -> np.ndarray:
        """Current cell averages, of the shape of ``problem.q0``, read-only."""
        view = self._kernel.inside(self._march.now).view()
        view.flags.writeable = False
        return view

    @property
    def dt(self) -> float:
        """Length of the next step by the Courant number, s; infinite if all speeds are 0."""
        return self._march.dt

    def _first_dt(self) -> float:
        """Return the length of the first step, s, from the wave speeds of the initial state."""
        problem, steps = self.problem, []
        for model, direction, axis in zip(self._asked, problem.directions, problem.grid.axes, strict=True):
            speed = largest_speed(problem, model, direction)
            steps.append(self.scheme.cfl * axis.dx / speed if speed > 0.0 else np.inf)
        return min(steps)

    def step(self, dt: float | None = None) -> float:
        """Advance by one accepted step of at most ``dt`` and return its length, s.

        Raises
        ------
        SolveError
            If every trial step is rejected; the state remains the last accepted one.
        """
        before = self.t
        if dt is not None:
            self._march.dt = min(self._march.dt, validation.real(dt, "dt", above=0.0))
            self.run(np.inf, max_steps=1)
        elif before < self.problem.t_end:
            self.run(self.problem.t_end, max_steps=1)
        else:
            raise ValueError(f"the end time t_end = {self.problem.t_end:g} is reached; give a `dt` to step on")
        return self.t - before

    def advance(self, t: float) -> None:
        """Step to exactly time ``t``."""
        target = validation.real(t, "t", at_least=self.t)
        while self.t < target:
            self.run(target, max_steps=UNLIMITED)

    @property
    def batch(self) -> int:
        """Number of steps that take about 0.1 s: a run returns to Python so often, for progress and Ctrl-C."""
        return max(1, int(0.1 * self.steps / self._seconds)) if self._seconds > 0.0 and self.steps else 1

    def interrupted(self) -> Interrupted:
        """Return the exception of a run interrupted at the current step."""
        state = self.q.reshape(len(self.q), -1)[:, 0].copy()
        return Interrupted(Status.INTERRUPTED, self.t, -1, np.nan, state, self.steps, self.problem.conserved)

    def run(self, target: float, max_steps: int) -> None:
        """Take up to ``max_steps`` accepted steps towards time ``target``; raise `SolveError` if every trial step is rejected."""
        march = self._march
        look = self._next_look if np.isfinite(target) else np.inf  # else the caller requested the step
        target = min(target, next((t for t in self._breaks if t > march.t), np.inf), look)
        while max_steps > 1 and self._resting:
            self._take(target, 1)
            max_steps -= 1
            if march.t >= target:
                return
        self._take(target, max_steps)

    @property
    def _next_look(self) -> float:
        """Time to look again at sources and conditions that vary in time while all is dry and no speed has bounded a step."""
        problem, march = self.problem, self._march
        seen = problem.steady_boundary and all(field.steady or field.breaks() for field in problem.fields)  # steps end at breaks
        moves = march.max_cfl > 0.0 if march.steps else np.isfinite(march.dt)
        return np.inf if seen or moves else march.t + (problem.t_end - problem.t_start) / IDLE

    @property
    def _resting(self) -> bool:
        """Whether all wave speeds were 0 so far, in a problem without sources and post-processing that change the state."""
        return self._march.max_cfl == 0.0 and not self.problem.sources and not self.problem.model.defines("settle")

    def _take(self, target: float, max_steps: int) -> None:
        """Advance, and raise if the kernel failed."""
        march = self._march
        known = march.lost - march.films
        resting = self._resting
        books = tuple(book.copy() for book in march.books) if resting else ()
        started = clock.perf_counter()
        with np.errstate(all="ignore"):
            outcome = self._kernel.advance(march, target, max_steps)
        self._seconds += clock.perf_counter() - started
        if not known and march.lost > march.films:
            self.warn_lost()
        if outcome is Outcome.BAD_STATE:
            self.fail(*diagnosis(self.problem, self.q, self._kernel.inside(march.next)))
        if outcome is Outcome.NO_STEP:
            status = Status.DT_TOO_SMALL if self.length.dt is None else Status.DT_TOO_LARGE
            wrong = wrong_speed(self.problem, self.q)
            self.fail(*(wrong or (status, int(np.argmax(np.max(np.abs(speeds(self.problem, self.q)), axis=0))), self.q)))
        if resting and march.max_cfl == 0.0 and march.steps > books[1][0]:
            self._check_rest(books)
        if outcome is Outcome.LOST_HYPERBOLICITY:
            self.fail(Status.NONHYPERBOLIC, min(march.lost_face, self.problem.grid.size - 1))

    def _check_rest(self, books: tuple[np.ndarray, ...]) -> None:
        """Undo a step and raise if the state changed although all wave speeds are 0, so that `wave_speeds` is wrong."""
        march = self._march
        now, before = (self._kernel.inside(one).reshape(len(one), -1) for one in (march.now, march.next))
        moved = (np.abs(now - before) > NOTHING * np.abs(before).max(axis=1, keepdims=True)).any(axis=0)
        if moved.any():
            for book, kept in zip(march.books, books, strict=True):
                book[:] = kept
            self.fail(Status.WRONG_SPEED, int(np.argmax(moved)))

    def warn_lost(self) -> None:
        """Warn about complex wave speeds if ``nonhyperbolic`` is "warn"; called at the end of the run for thin films alone."""
        grid, march = self.problem.grid, self._march
        if not march.lost or self.nonhyperbolic != "warn":
            return
        place = grid.located(march.lost_face) if len(grid.axes) > 1 else f"x = {grid.edges[march.lost_face]:.6g}"
        deepest = march.deepest / MICRO
        if march.lost == march.films:
            where = (f", at {march.films} faces and steps, all in films: the deepest is {100.0 * deepest:.2g} cm deep, less than "
                     f"{100.0 * FILM:g} cm")
        else:
            where = f", so far {deepest:.3g} m deep" * (deepest > 0.0)
        warnings.warn(f"characteristic speeds are complex from t = {march.lost_time:.6g} on, first at "
                      f"{place}{where}: the problem is ill-posed there and does not converge. "
                      "stats.nonhyperbolic_faces counts such faces; nonhyperbolic='raise' stops the run, 'ignore' hides this.",
                      RuntimeWarning, stacklevel=3)

    @property
    def only_films_lost(self) -> bool:
        """Whether wave speeds became complex in thin films alone."""
        return 0 < self._march.lost == self._march.films

    def fail(self, status: Status, cell: int = -1, q: np.ndarray | None = None) -> NoReturn:
        """Raise `SolveError` with the time, the cell and the state of that cell, in q or else in the current state."""
        place = self.problem.grid.place(cell) if cell >= 0 else (np.nan,)
        whole = self.q if q is None else q
        state = whole.reshape(len(whole), -1)[:, max(cell, 0)].copy()
        raise SolveError(status, self.t, cell, place[0], state, self.steps, self.problem.conserved, place[1:])

    def snapshot(self) -> dict[str, np.ndarray]:
        """Return copies of the state and the counters, {name: array}, for `restore` of a stepper of the same problem."""
        march = self._march
        return {"now": self.q.copy(), "real": march.real.copy(), "count": march.count.copy(), "masses": march.masses.copy(),
                "clock": np.array(self._seconds)}

    def restore(self, snapshot: Mapping[str, np.ndarray]) -> None:
        """Restore a `snapshot`; the following steps are bit-identical on the same backend."""
        march = self._march
        for array, name in ((march.real, "real"), (march.count, "count"), (march.masses, "masses")):
            array[:] = snapshot[name]
        self._kernel.inside(march.now)[:] = snapshot["now"]
        self._kernel.restarted()
        self._seconds = float(snapshot["clock"])

    def stats(self) -> Stats:
        """Statistics of the run so far."""
        march, kernel, grid = self._march, self._kernel, self.problem.grid
        names = [self.problem.conserved[row] for row in kernel.mass_rows]
        cells = tuple(range(1, 1 + len(grid.axes)))
        start = self.problem.q0[kernel.mass_rows].sum(axis=cells) * grid.cell_volume
        sides, gained = np.split(march.masses[:, :len(names)], [2 * len(grid.axes)])
        entered = sides * np.resize([1.0, -1.0], len(sides))[:, None] + 0.0  # no -0
        through, brought = entered.sum(axis=0), gained.sum(axis=0)
        change = self.q[kernel.mass_rows].sum(axis=cells) * grid.cell_volume - start - through - brought
        scale = [mass or start.sum() or 1.0 for mass in start]
        return Stats(march.steps, march.rejected, grid.size * (march.steps + march.rejected), self._seconds,
                     kernel.compile_seconds, march.max_cfl, kernel.name, march.lost,
                     {name: float(c / s) for name, c, s in zip(names, change, scale, strict=True)}, march.films,
                     march.deepest / MICRO, dict(zip(names, brought.tolist(), strict=True)),
                     self._balance(names, entered, gained))

    def _balance(self, names: list[str], entered: np.ndarray, gained: np.ndarray) -> dict[str, dict[str, float]]:
        """What each side let in and each source brought of every mass."""
        axes = len(self.problem.grid.axes)
        sides = ENDS if axes == 1 else [side for pair in SIDES for side in pair]
        sources = [SOURCES] if axes == 1 else numbered([type(unwrapped(one)).__name__ for one in self._kernel.parts.beside])
        return {name: dict(zip(names, row.tolist(), strict=True))
                for name, row in zip((*sides, *sources), np.concatenate([entered, gained]), strict=False)} if names else {}


def numbered(names: list[str]) -> list[str]:
    """Return names of which the second of a kind is called "Rain 2", and so on."""
    return [name if names[:k].count(name) == 0 else f"{name} {names[:k].count(name) + 1}" for k, name in enumerate(names)]
