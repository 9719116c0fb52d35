"""`solve`, `Stepper` and `rhs`: where problem and scheme meet."""

import time as clock
import warnings
from collections.abc import Callable, Iterable, Mapping
from pathlib import Path

import numpy as np

from fvkit import _validate, contract
from fvkit.backends import BACKENDS, CHUNK, Kernel, March, Outcome, array_kernel, make_kernel
from fvkit.checkpoint import Checkpoint, Saver
from fvkit.configuration import effective
from fvkit.problem import Problem
from fvkit.progress import checked, reporter
from fvkit.recording import Frames, Memory, Stream
from fvkit.schemes import Parts, Scheme, WavePropagation
from fvkit.solution import Interrupted, Solution, SolveError, Stats, Status

#: More steps than any run takes.
UNLIMITED = 2**62


class Stepper:
    """One problem under one scheme, one step at a time: what `solve` runs.

    Parameters
    ----------
    problem : the problem.
    scheme : the scheme; None for second-order wave propagation with the model's default Riemann solver.
    backend : ``"auto"``, ``"numba"`` (compiled) or ``"numpy"``; auto compiles where numba is installed, unless the
        environment variable FVKIT_BACKEND names another.
    nonhyperbolic : what to do when characteristic speeds turn complex: ``"warn"`` once, ``"raise"`` or ``"ignore"``.
    threads : threads of a compiled run; more than 1 only from 100,000 cells on, bit-identical to one.

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
                 nonhyperbolic: str = "warn", threads: int = 1) -> None:
        _validate.choice(backend, "backend", BACKENDS)
        self.nonhyperbolic = _validate.choice(nonhyperbolic, "nonhyperbolic", ("warn", "raise", "ignore"))
        self.problem, self.threads = problem, _validate.whole(threads, "threads", at_least=1)
        self.scheme, parts = assemble(problem, scheme)
        self._kernel: Kernel = make_kernel(backend, problem, self.scheme, parts, self.threads)
        self._march = March(self._kernel.padded(problem.q0), problem.t_start, self._first_dt(), len(self._kernel.mass_rows),
                            stop_when_lost=self.nonhyperbolic == "raise")
        self._seconds = 0.0

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
        """Current cell averages, (num_eqn, num_cells), read-only."""
        view = self._kernel.inside(self._march.now).view()
        view.flags.writeable = False
        return view

    @property
    def dt(self) -> float:
        """The step that the Courant number allows next, s; infinite where nothing moves."""
        return self._march.dt

    def _first_dt(self) -> float:
        """From the speeds of the initial cells, so that the first step is as good as the others."""
        q0, speed = self.problem.q0, 0.0
        with np.errstate(all="ignore"):
            for first in range(0, q0.shape[1], CHUNK):
                bounds = self.problem.model.wave_speeds(tuple(q0[:, first:first + CHUNK]))
                speed = max(speed, *(float(np.max(np.abs(bound))) for bound in bounds))
        return self.scheme.cfl * self.problem.grid.dx / speed if speed > 0.0 else np.inf

    def step(self, dt: float | None = None) -> float:
        """Advance by one accepted step of at most ``dt`` and return its length.

        Raises
        ------
        SolveError
            If no acceptable step exists; the state stays the last accepted one.
        """
        before = self.t
        if dt is not None:
            self._march.dt = min(self._march.dt, _validate.real(dt, "dt", above=0.0))
            self.run(np.inf, max_steps=1)
        elif before < self.problem.t_end:
            self.run(self.problem.t_end, max_steps=1)
        else:
            raise ValueError(f"the end time t_end = {self.problem.t_end:g} is reached; give a `dt` to step on")
        return self.t - before

    def advance(self, t: float) -> None:
        """Step to exactly time ``t``."""
        target = _validate.real(t, "t", at_least=self.t)
        while self.t < target:
            self.run(target, max_steps=UNLIMITED)

    @property
    def batch(self) -> int:
        """Steps that take about 0.1 s: after so many a run comes back to Python, for progress and Ctrl-C."""
        return max(1, int(0.1 * self.steps / self._seconds)) if self._seconds > 0.0 and self.steps else 1

    def interrupted(self) -> Interrupted:
        """The error of a run that the user stops now."""
        state = self.q[:, 0].copy()
        return Interrupted(Status.INTERRUPTED, self.t, -1, np.nan, state, self.steps, self.problem.model.conserved)

    def run(self, target: float, max_steps: int) -> None:
        """Take accepted steps towards ``target``, at most ``max_steps`` of them; raise `SolveError` where none exists."""
        march = self._march
        known = march.lost
        started = clock.perf_counter()
        with np.errstate(all="ignore"):
            outcome = self._kernel.advance(march, target, max_steps)
        self._seconds += clock.perf_counter() - started
        if march.lost and not known and self.nonhyperbolic == "warn":
            self._warn_lost()
        if outcome is Outcome.BAD_STATE:
            self._fail(*self._diagnosis())
        if outcome is Outcome.NO_STEP:
            self._fail(Status.DT_TOO_SMALL)
        if outcome is Outcome.LOST_HYPERBOLICITY:
            self._fail(Status.NONHYPERBOLIC, min(march.lost_face, self.problem.grid.num_cells - 1), march.now)

    def _diagnosis(self) -> tuple[Status, int, np.ndarray]:
        """What is wrong with the trial state, and in which cell."""
        trial, model = self._march.next, self.problem.model
        q = self._kernel.inside(trial)
        finite = np.isfinite(q).all(axis=0)
        if not finite.all():
            return Status.NON_FINITE, int(np.argmin(finite)), trial
        lowest = [(q[row].min(), int(np.argmin(q[row]))) for row in self._kernel.mass_rows]
        if lowest and min(lowest)[0] < 0.0:
            return Status.NEGATIVE_DEPTH, min(lowest)[1], trial
        if model.defines("admissible"):
            allowed = np.broadcast_to(model.admissible(tuple(q)), q.shape[1:])
            if not allowed.all():
                return Status.INADMISSIBLE, int(np.argmin(allowed)), trial
        return Status.NON_FINITE, -1, trial

    def _warn_lost(self) -> None:
        march = self._march
        warnings.warn(f"characteristic speeds are complex from t = {march.lost_time:.6g} on, first at "
                      f"x = {self.problem.grid.edges[march.lost_face]:.6g}: the problem is ill-posed there and does not "
                      "converge. stats.nonhyperbolic_faces counts; nonhyperbolic='raise' stops, 'ignore' is silent.",
                      RuntimeWarning, stacklevel=3)

    def _fail(self, status: Status, cell: int = -1, padded: np.ndarray | None = None) -> None:
        x = float(self.problem.grid.centers[cell]) if cell >= 0 else np.nan
        state = self._kernel.inside(self._march.now if padded is None else padded)[:, max(cell, 0)].copy()
        raise SolveError(status, self.t, cell, x, state, self.steps, self.problem.model.conserved)

    def snapshot(self) -> dict[str, np.ndarray]:
        """Copies of all that a run changes: with them `restore` puts another stepper of the same problem and scheme here."""
        march = self._march
        return {"now": self.q.copy(), "real": march.real.copy(), "count": march.count.copy(), "masses": march.masses.copy(),
                "clock": np.array(self._seconds)}

    def restore(self, snapshot: Mapping[str, np.ndarray]) -> None:
        """Go to a `snapshot`: what follows is what followed there, bit for bit on the same backend."""
        march = self._march
        for array, name in ((march.real, "real"), (march.count, "count"), (march.masses, "masses")):
            array[:] = snapshot[name]
        self._kernel.inside(march.now)[:] = snapshot["now"]
        self._seconds = float(snapshot["clock"])

    def stats(self) -> Stats:
        """Statistics of the run so far."""
        march, kernel, grid = self._march, self._kernel, self.problem.grid
        names = [self.problem.model.conserved[row] for row in kernel.mass_rows]
        start = self.problem.q0[kernel.mass_rows].sum(axis=1) * grid.dx
        entered = (march.masses[0] - march.masses[1])[:len(names)]
        change = self.q[kernel.mass_rows].sum(axis=1) * grid.dx - start - entered
        scale = [mass or start.sum() or 1.0 for mass in start]
        return Stats(march.steps, march.rejected, grid.num_cells * (march.steps + march.rejected), self._seconds,
                     kernel.compile_seconds, march.max_cfl, kernel.name, 0, march.lost,
                     {name: float(c / s) for name, c, s in zip(names, change, scale, strict=True)})


def assemble(problem: Problem, scheme: Scheme | None) -> tuple[Scheme, Parts]:
    """Return the scheme, the default where None, and its parts, checked against the problem."""
    _validate.instance(problem, "problem", Problem)
    chosen = default_scheme(problem) if scheme is None else _validate.instance(scheme, "scheme", Scheme)
    parts = chosen.parts(problem.model, problem.sources)._replace(dx=problem.grid.dx)
    check_parts(problem, parts)
    return chosen, parts if problem.background is None else chosen.around(parts)


def default_scheme(problem: Problem) -> Scheme:
    """Second-order wave propagation with the model's default Riemann solver."""
    return WavePropagation(problem.model.default_riemann())


def check_parts(problem: Problem, parts: Parts) -> None:
    """Check the pointwise contract of solver and limiters on the problem's own initial state."""
    model, kind = problem.model, type(problem.model)
    q, aux, count = problem.sample()
    face = (model, q, tuple(row[::-1] for row in q), aux, tuple(row[::-1] for row in aux), q)
    if parts.riemann.compilable:
        contract.read(type(parts.riemann), ("solve",), kind)
    waves = contract.rehearse_waves(parts.riemann, "solve", face, len(q), count)
    if parts.reconstruction is None and len(parts.limiters) not in (1, waves):
        raise ValueError(f"`limiter` must be one limiter or one per wave family: {type(parts.riemann).__name__} with "
                         f"{kind.__name__} has {waves}, got {len(parts.limiters)}")
    if parts.reconstruction is not None:
        contract.read(type(parts.reconstruction), ("right",))
        cells = tuple(np.linspace(1.0, 2.0 + k % 3, count) for k in range(5))
        contract.rehearse_value(parts.reconstruction, "right", cells, count)
    for limiter in parts.limiters:
        contract.read(type(limiter), ("phi",))
        contract.rehearse_value(limiter, "phi", (np.linspace(-1.0, 3.0, count), np.full(count, 0.5)), count)


def solve(problem: Problem, scheme: Scheme | None = None, times: Iterable[float] | None = None, *, backend: str = "auto",
          progress: bool | Callable[[float], None] = False, throw: bool = True, max_steps: int = 10_000_000,
          observers: Iterable[Callable[[Stepper], None]] = (), nonhyperbolic: str = "warn",
          threads: int = 1, seconds: float | None = None, checkpoint: Checkpoint | None = None,
          stream: str | Path | None = None) -> Solution:
    """Solve a problem with a scheme.

    Parameters
    ----------
    problem : what is solved.
    scheme : how; None for second-order wave propagation with the model's default Riemann solver.
    times : output times, s, ascending, after the start and not after ``t_end``; None for the end alone.
    backend : ``"auto"``, ``"numba"`` or ``"numpy"``, see `Stepper`.
    progress : True shows progress on stderr; or a function that receives the share of simulated time done, 0 to 1.
    throw : whether a run that fails raises; else the partial solution is returned with its status.
    max_steps : largest number of accepted steps.
    observers : functions called with the `Stepper` after every accepted step, in order.
    nonhyperbolic : ``"warn"``, ``"raise"`` or ``"ignore"`` where characteristic speeds turn complex.
    threads : threads of a compiled run; more than 1 only from 100,000 cells on.
    seconds : wall time of the stepping, s, after which a run stops as failed (`Status.OVER_BUDGET`), to about 0.1 s.
    checkpoint : where and how often the run leaves what `resume` needs to continue it, see `Checkpoint`.
    stream : name of a netCDF file (.nc, extra ``io``) that gets every output as soon as it is there, under the name
        NAME.part.nc until the run ends, well or not; a run that is killed leaves that, readable. Not with ``checkpoint``.

    Returns
    -------
    Solution
        Start, then ``times``; with ``stream`` start and end alone, and `load` reads all from the file.

    Raises
    ------
    SolveError
        If the run fails and ``throw`` is true; it carries the partial solution. After Ctrl-C it is an `Interrupted`,
        which is a KeyboardInterrupt as well.
    ValueError, TypeError
        For bad input, whatever ``throw`` is.
    """
    if checkpoint is not None and stream is not None:
        raise ValueError("`checkpoint` and `stream` do not go together: a checkpoint holds the outputs so far, give one of them")
    stepper = Stepper(problem, scheme, backend, nonhyperbolic, threads)
    targets = _targets(problem, times)
    frames = Memory(len(targets) + 1, problem.q0) if stream is None else Stream(stream, problem, stepper.scheme)
    return run_to_end(stepper, targets, frames, checkpoint, progress, throw, max_steps, observers, seconds)


def run_to_end(stepper: Stepper, targets: list[float], frames: Frames, checkpoint: Checkpoint | None,
               progress: bool | Callable[[float], None], throw: bool, max_steps: int,
               observers: Iterable[Callable[[Stepper], None]], seconds: float | None = None) -> Solution:
    """Run a stepper through the output times that are ahead of it; arguments as for `solve`, ``frames`` those behind it."""
    problem = stepper.problem
    limit, callbacks = _validate.whole(max_steps, "max_steps", at_least=0), _callbacks(observers)
    budget = np.inf if seconds is None else _validate.real(seconds, "seconds", above=0.0)
    if checkpoint is not None:
        _validate.instance(checkpoint, "checkpoint", Checkpoint, "such as fv.Checkpoint('run.npz')")
    saver = None if checkpoint is None else Saver(checkpoint, stepper, frames, targets)
    failure: SolveError | None = None
    try:
        if not len(frames.t):
            frames.add(problem.t_start, problem.q0)
        with reporter(checked(progress), problem.t_start, targets[-1] if targets else problem.t_start) as report:
            try:
                for target in targets[len(frames.t) - 1:]:
                    while stepper.t < target:
                        if stepper.steps >= limit:
                            stepper._fail(Status.MAX_STEPS)
                        if stepper.seconds > budget:
                            stepper._fail(Status.OVER_BUDGET)
                        stepper.run(target, 1 if callbacks else min(stepper.batch, limit - stepper.steps))
                        for observer in callbacks:
                            observer(stepper)
                        report(stepper.t, stepper.steps)
                        if saver is not None:
                            saver.tick()
                    frames.add(stepper.t, stepper.q)
            except (SolveError, KeyboardInterrupt) as error:
                failure = error if isinstance(error, SolveError) else stepper.interrupted()
        if saver is not None:
            saver.write()
            if failure is not None:
                failure.args = (f"{failure}; fv.resume({str(saver.checkpoint.path)!r}) goes on from here",)
        if stepper.t > frames.t[-1]:
            frames.add(stepper.t, stepper.q)
        status, stats = Status.FINISHED if failure is None else failure.status, stepper.stats()
        message = status.value if failure is None else str(failure)
        kept = effective(problem, stepper.scheme, stats, status, message)
        frames.finish(kept)
    except BaseException:
        frames.abandon()
        raise
    solution = Solution(frames.t, frames.q, problem.aux_averages, problem.grid, problem.model, status, stats, message, kept)
    if failure is not None:
        failure.solution = solution
        if throw:
            raise failure from None
    return solution


def _callbacks(observers: Iterable[Callable[[Stepper], None]]) -> tuple[Callable[[Stepper], None], ...]:
    given = tuple(observers) if isinstance(observers, Iterable) else (observers,)
    for observer in given:
        if not callable(observer):
            raise TypeError(f"`observers` must be functions of the stepper, got {observer!r}")
    return given


def _targets(problem: Problem, times: Iterable[float] | None) -> list[float]:
    if times is None:
        return [problem.t_end]
    targets = _validate.array(times if isinstance(times, np.ndarray) or not isinstance(times, Iterable) else list(times), "times")
    if targets.ndim != 1 or not targets.size:
        raise ValueError(f"`times` must be a non-empty sequence of numbers, got {times!r}")
    if targets[0] < problem.t_start or targets[-1] > problem.t_end or (np.diff(targets) <= 0.0).any():
        raise ValueError(f"`times` must ascend within [{problem.t_start:g}, {problem.t_end:g}], got {targets.tolist()}")
    return [float(target) for target in targets if target > problem.t_start]


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
    chosen, parts = assemble(problem, scheme)
    kernel, model, shape = array_kernel(problem, chosen, parts), problem.model, problem.q0.shape
    aux = tuple(problem.aux_averages[name] for name in model.aux)

    def rate(t: float, q: np.ndarray) -> np.ndarray:
        state = np.asarray(q, dtype=float).reshape(shape)
        with np.errstate(all="ignore"):
            result = kernel.rate(kernel.padded(state), t)
            for source in problem.sources:
                for row, component in zip(result, source.rate(model, tuple(state), aux), strict=True):
                    row += component
        return result.reshape(np.shape(q))

    return rate
