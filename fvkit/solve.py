"""`solve`, `Stepper` and `rhs`: where problem and scheme meet."""

import time as clock
import warnings
from collections.abc import Callable, Iterable
from typing import Any

import numpy as np

from fvkit import _validate, contract
from fvkit.backends import NumpyKernel
from fvkit.problem import Problem
from fvkit.progress import reporter
from fvkit.riemann import HLL, Roe
from fvkit.schemes import Parts, Scheme, WavePropagation
from fvkit.solution import Solution, SolveError, Stats, Status

BACKENDS = ("auto", "numpy")

#: A step is retried at most this often; each retry shortens it to the Courant number aimed at.
_MAX_RETRIES = 30


class Stepper:
    """One problem under one scheme, one step at a time: what `solve` runs.

    Parameters
    ----------
    problem : the problem.
    scheme : the scheme; None for second-order wave propagation with Roe, or HLL where the model defines no
        Roe decomposition.
    backend : ``"auto"`` or ``"numpy"``.
    nonhyperbolic : what to do when characteristic speeds turn complex: ``"warn"`` once, ``"raise"`` or ``"ignore"``.

    Attributes
    ----------
    t : float
        Current time, s.
    q : numpy.ndarray
        (num_eqn, num_cells) current cell averages; a view, read-only.

    Raises
    ------
    ValueError
        If scheme and model cannot work together, naming both.
    """

    def __init__(self, problem: Problem, scheme: Scheme | None = None, backend: str = "auto",
                 nonhyperbolic: str = "warn") -> None:
        _validate.instance(problem, "problem", Problem)
        _validate.choice(backend, "backend", BACKENDS)
        self._policy = _validate.choice(nonhyperbolic, "nonhyperbolic", ("warn", "raise", "ignore"))
        self.problem = problem
        self.scheme = default_scheme(problem) if scheme is None else _validate.instance(scheme, "scheme", Scheme)
        self._parts = self.scheme.parts(problem.model, problem.sources)
        check_parts(problem, self._parts)
        self._kernel = NumpyKernel(problem, self.scheme, self._parts)
        self.t = problem.t_start
        self._now, self._next = self._kernel.padded(problem.q0), self._kernel.padded(problem.q0)
        self._split = self._kernel.padded(problem.q0) if problem.sources else self._now
        self._masses = list(problem.model.mass_rows())
        self._initial_mass = problem.q0[self._masses].sum(axis=1) * problem.grid.dx
        self._left_in, self._right_out = np.zeros(len(self._masses)), np.zeros(len(self._masses))
        self.steps = self.rejected = self._nonhyperbolic = 0
        self.seconds = self.max_cfl = 0.0
        self._dt = self._first_dt()

    @property
    def q(self) -> np.ndarray:
        """Current cell averages, (num_eqn, num_cells), read-only."""
        view = self._kernel.inside(self._now).view()
        view.flags.writeable = False
        return view

    @property
    def dt(self) -> float:
        """The step that the Courant number allows next, s; infinite where nothing moves."""
        return self._dt

    def _first_dt(self) -> float:
        with np.errstate(all="ignore"):
            bounds = self.problem.model.wave_speeds(tuple(self.problem.q0))
        return self._step_for(max(float(np.max(np.abs(bound))) for bound in bounds))

    def _step_for(self, speed: float) -> float:
        return self.scheme.cfl * self.problem.grid.dx / speed if speed > 0.0 else np.inf

    def step(self, dt: float | None = None) -> float:
        """Advance by one accepted step of at most ``dt`` and return its length.

        Raises
        ------
        SolveError
            If no acceptable step exists; the state stays the last accepted one.
        """
        limit = np.inf if dt is None else _validate.real(dt, "dt", above=0.0)
        wanted = min(limit, self._dt, self.problem.t_end - self.t if dt is None else np.inf)
        if not wanted > 0.0:
            raise ValueError(f"the end time t_end = {self.problem.t_end:g} is reached; give a `dt` to step on")
        return self._step(wanted)

    def advance(self, t: float) -> None:
        """Step to exactly time ``t``."""
        target = _validate.real(t, "t", at_least=self.t)
        while self.t < target:
            self._step_towards(target)

    def _step_towards(self, target: float) -> None:
        remaining = target - self.t
        last = self._dt >= remaining * (1.0 - 1e-12)
        if self._step(remaining if last else self._dt) == remaining:
            self.t = target

    def _step(self, dt: float) -> float:
        started = clock.perf_counter()
        try:
            with np.errstate(all="ignore"):
                return self._attempts(dt)
        finally:
            self.seconds += clock.perf_counter() - started

    def _attempts(self, dt: float) -> float:
        dx = self.problem.grid.dx
        for _ in range(_MAX_RETRIES):
            if self.t + dt == self.t and dt < self.problem.t_end - self.t:
                break
            report = self._trial(dt)
            cfl = report.max_speed * dt / dx
            if cfl <= self.scheme.cfl_max:
                self._check(self._next)
                self._accept(dt, cfl, report)
                return dt
            if not np.isfinite(cfl):
                self._fail(Status.NON_FINITE, *self._worst(self._next))
            self.rejected += 1
            dt = self._dt = dt * self.scheme.cfl / cfl
        self._fail(Status.DT_TOO_SMALL, -1, self._now)
        raise AssertionError("unreachable")

    def _trial(self, dt: float) -> Any:
        """Write the state after dt into _next; _now stays what it is."""
        splitting, sources = self.scheme.splitting, self.problem.sources
        start = self._now
        if sources and splitting.before > 0.0:
            for source in sources:
                self._kernel.act(source.step, start, self._split, splitting.before * dt)
                start = self._split
        report = self._kernel.transport(start, self._next, self.t, dt)
        if splitting.after > 0.0:
            for source in reversed(sources):
                self._kernel.act(source.step, self._next, self._next, splitting.after * dt)
        return report

    def _accept(self, dt: float, cfl: float, report: Any) -> None:
        if report.nonhyperbolic:
            self._lost(report.first_nonhyperbolic)
        self._now, self._next = self._next, self._now
        self._split = self._split if self.problem.sources else self._now
        self.t += dt
        self.steps += 1
        self.max_cfl = max(self.max_cfl, cfl)
        self._nonhyperbolic += report.nonhyperbolic
        self._left_in += dt * report.left_flux
        self._right_out += dt * report.right_flux
        self._dt = self._step_for(report.max_speed)

    def _check(self, padded: np.ndarray) -> None:
        """Fail unless the trial state is finite, has no negative mass and is admissible."""
        q = self._kernel.inside(padded)
        if not np.isfinite(q.sum()):
            self._fail(Status.NON_FINITE, *self._worst(padded))
        for row in self._masses:
            if q[row].min() < 0.0:
                self._fail(Status.NEGATIVE_DEPTH, int(np.argmin(q[row])), padded)
        if self.problem.model.defines("admissible"):
            allowed = np.broadcast_to(self.problem.model.admissible(tuple(q)), q.shape[1:])
            if not allowed.all():
                self._fail(Status.INADMISSIBLE, int(np.argmin(allowed)), padded)

    def _worst(self, padded: np.ndarray) -> tuple[int, np.ndarray]:
        bad = ~np.isfinite(self._kernel.inside(padded)).all(axis=0)
        return (int(np.argmax(bad)) if bad.any() else -1), padded

    def _lost(self, face: int) -> None:
        """Act on lost hyperbolicity, at its first occurrence."""
        if self._policy == "raise":
            self._fail(Status.NONHYPERBOLIC, min(face, self.problem.grid.num_cells - 1), self._now)
        if self._policy == "warn" and not self._nonhyperbolic:
            warnings.warn(f"characteristic speeds are complex from t = {self.t:.6g} on, first at "
                          f"x = {self.problem.grid.edges[face]:.6g}: the problem is ill-posed there and does not converge. "
                          "stats.nonhyperbolic_faces counts; nonhyperbolic='raise' stops, 'ignore' is silent.",
                          RuntimeWarning, stacklevel=2)

    def _fail(self, status: Status, cell: int, padded: np.ndarray) -> None:
        x = float(self.problem.grid.centers[cell]) if cell >= 0 else np.nan
        state = self._kernel.inside(padded)[:, max(cell, 0)].copy()
        raise SolveError(status, self.t, cell, x, state, self.steps, self.problem.model.conserved)

    def stats(self) -> Stats:
        """Statistics of the run so far."""
        names = [self.problem.model.conserved[row] for row in self._masses]
        now = self.q[self._masses].sum(axis=1) * self.problem.grid.dx
        change = now - self._initial_mass + self._right_out - self._left_in
        whole = self._initial_mass.sum()
        scale = [mass if mass > 0.0 else whole if whole > 0.0 else 1.0 for mass in self._initial_mass]
        return Stats(self.steps, self.rejected, self.problem.grid.num_cells * (self.steps + self.rejected), self.seconds,
                     self._kernel.compile_seconds, self.max_cfl, self._kernel.name, 0, self._nonhyperbolic,
                     {name: float(c / s) for name, c, s in zip(names, change, scale, strict=True)})


def default_scheme(problem: Problem) -> Scheme:
    """Second-order wave propagation with Roe, or with HLL where the model defines no Roe decomposition."""
    return WavePropagation(Roe() if problem.model.defines("decompose") else HLL())


def check_parts(problem: Problem, parts: Parts) -> None:
    """Check the pointwise contract of solver and limiters on the problem's own initial state."""
    model, kind = problem.model, type(problem.model)
    q, aux, count = problem.sample()
    face = (model, q, tuple(row[::-1] for row in q), aux, tuple(row[::-1] for row in aux), q)
    contract.read(type(parts.riemann), ("solve",), kind)
    waves = contract.rehearse_waves(parts.riemann, "solve", face, len(q), count)
    if len(parts.limiters) not in (1, waves):
        raise ValueError(f"`limiter` must be one limiter or one per wave family: {type(parts.riemann).__name__} with "
                         f"{kind.__name__} has {waves}, got {len(parts.limiters)}")
    for limiter in parts.limiters:
        contract.read(type(limiter), ("phi",))
        contract.rehearse_value(limiter, "phi", (np.linspace(-1.0, 3.0, count), np.full(count, 0.5)), count)


def solve(problem: Problem, scheme: Scheme | None = None, times: Iterable[float] | None = None, *, backend: str = "auto",
          progress: bool | Callable[[float], None] = False, throw: bool = True, max_steps: int = 10_000_000,
          observers: Iterable[Callable[[Stepper], None]] = (), nonhyperbolic: str = "warn") -> Solution:
    """Solve a problem with a scheme.

    Parameters
    ----------
    problem : what is solved.
    scheme : how; None for second-order wave propagation with Roe (HLL where the model has no Roe decomposition).
    times : output times, s, ascending, after the start and not after ``t_end``; None for the end alone.
    backend : ``"auto"`` or ``"numpy"``.
    progress : True shows progress on stderr; or a function that receives the share of simulated time done, 0 to 1.
    throw : whether a run that fails raises; else the partial solution is returned with its status.
    max_steps : largest number of accepted steps.
    observers : functions called with the `Stepper` after every accepted step, in order.
    nonhyperbolic : ``"warn"``, ``"raise"`` or ``"ignore"`` where characteristic speeds turn complex.

    Returns
    -------
    Solution
        Start, then ``times``.

    Raises
    ------
    SolveError
        If the run fails and ``throw`` is true; it carries the partial solution.
    ValueError, TypeError
        For bad input, whatever ``throw`` is.
    """
    stepper = Stepper(problem, scheme, backend, nonhyperbolic)
    targets = _targets(problem, times)
    limit, callbacks = _validate.whole(max_steps, "max_steps", at_least=0), tuple(observers)
    t, states = [problem.t_start], [problem.q0.copy()]
    failure: SolveError | None = None
    with reporter(progress, problem.t_start, targets[-1]) as report:
        try:
            for target in targets:
                while stepper.t < target:
                    if stepper.steps >= limit:
                        stepper._fail(Status.MAX_STEPS, -1, stepper._now)
                    stepper._step_towards(target)
                    for observer in callbacks:
                        observer(stepper)
                    report(stepper.t, stepper.steps)
                t.append(stepper.t)
                states.append(stepper.q.copy())
        except SolveError as error:
            failure = error
            if stepper.t > t[-1]:
                t.append(stepper.t)
                states.append(stepper.q.copy())
    status = Status.FINISHED if failure is None else failure.status
    solution = Solution(np.array(t), np.array(states), problem.aux_averages, problem.grid, problem.model, status,
                        stepper.stats(), status.value if failure is None else str(failure))
    if failure is not None:
        failure.solution = solution
        if throw:
            raise failure
    return solution


def _targets(problem: Problem, times: Iterable[float] | None) -> list[float]:
    if times is None:
        return [problem.t_end]
    targets = _validate.array(list(times), "times")
    if targets.ndim != 1 or not targets.size:
        raise ValueError(f"`times` must be a non-empty sequence of numbers, got {times!r}")
    if targets[0] < problem.t_start or targets[-1] > problem.t_end or (np.diff(targets) <= 0.0).any():
        raise ValueError(f"`times` must ascend within [{problem.t_start:g}, {problem.t_end:g}], got {targets.tolist()}")
    return [float(target) for target in targets if target > problem.t_start] or [float(problem.t_start)]


def rhs(problem: Problem, scheme: Scheme | None = None) -> Callable[[float, np.ndarray], np.ndarray]:
    """Return f(t, q) = dq/dt of the semi-discrete scheme, for scipy and others.

    For wave propagation this is the limit dt -> 0 of the scheme, limited corrections included, with the rates of
    all sources added.

    Parameters
    ----------
    problem, scheme : as for `solve`.

    Returns
    -------
    callable
        (t, q) -> dq/dt, q of shape (num_eqn, num_cells) or flat; the result has the shape of q.
    """
    stepper = Stepper(problem, scheme)
    kernel, model, shape = stepper._kernel, problem.model, problem.q0.shape
    aux = tuple(problem.aux_averages[name] for name in model.aux)

    def rate(t: float, q: np.ndarray) -> np.ndarray:
        state = np.asarray(q, dtype=float).reshape(shape)
        result = kernel.rate(kernel.padded(state), t)
        for source in problem.sources:
            for row, component in zip(result, source.rate(model, tuple(state), aux), strict=True):
                row += component
        return result.reshape(np.shape(q))

    return rate
