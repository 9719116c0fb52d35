"""`solve`: time loop of a problem and a scheme, with outputs, checkpoints and observers."""

from collections.abc import Callable, Iterable
from typing import Any

import numpy as np

from fvkit import validation
from fvkit.output.configuration import effective
from fvkit.output.solution import Solution
from fvkit.output.status import Status
from fvkit.problem.problem import Problem
from fvkit.run.checkpoint import Checkpoint, Saver
from fvkit.run.control import LOOK, Control, Limits
from fvkit.run.failures import RunOutcome
from fvkit.run.progress import checked, reporter
from fvkit.run.recording import InMemory, Snapshots, Stream
from fvkit.run.step_bounds import Step
from fvkit.run.stepper import Stepper
from fvkit.run.stopping import Stop
from fvkit.schemes.scheme import Scheme


def solve(problem: Problem, scheme: Scheme | None = None, times: Iterable[float] | None = None, *, step: Step | None = None,
          limits: Limits | None = None, until: Stop | None = None, record: Stream | None = None,
          checkpoint: Checkpoint | None = None, observers: Iterable[Callable[[Stepper], None]] = (), backend: str = "auto",
          threads: int | str = 1, nonhyperbolic: str = "warn", progress: bool | Callable[[float], None] = False,
          throw: bool = True) -> Solution:
    """Solve a problem with a scheme and return the solution at the output times.

    Parameters
    ----------
    problem : the `Problem`.
    scheme : the `Scheme`; None for second-order wave propagation with the model's default Riemann solver.
    times : output times, s, ascending, after the initial time and up to ``t_end``; None for ``t_end`` alone.
    step : length of the time steps, such as ``fv.Step(dt_max=0.1)``; None for the Courant number of the scheme.
    limits : limits on steps and wall time, such as ``fv.Limits(seconds=60.0)``; None for 10,000,000 steps.
    until : stop rule that ends the run successfully before the end time, such as ``fv.StopAtRest(speed=0.01)``.
    record : ``fv.Stream("run.nc")`` writes each output to disk during the run; None keeps all outputs in memory. Not with
        ``checkpoint``.
    checkpoint : file and interval of checkpoints for `resume`, see `Checkpoint`.
    observers : functions called with the `Stepper` after every accepted step, in order.
    backend : ``"auto"``, ``"numba"`` or ``"numpy"``, see `Stepper`.
    threads : number of threads of a compiled run, or ``"all"`` for one per core; more than 1 only from 100,000 cells
        on a line on, with two axes for any number.
    nonhyperbolic : ``"warn"``, ``"raise"`` or ``"ignore"`` where characteristic speeds become complex.
    progress : True shows progress on stderr; or a function of the fraction of simulated time done, 0 to 1.
    throw : True raises if the run fails; False returns the partial solution with its status.

    Returns
    -------
    Solution
        Initial state and the states at ``times``, or up to the state at which ``until`` ended the run. With ``record`` the
        first and the last state alone; `load` reads all outputs from the file.

    Raises
    ------
    SolveError
        If the run fails and ``throw`` is true; its attribute ``solution`` is the partial solution. Ctrl-C raises the subclass
        `Interrupted`, which is also a KeyboardInterrupt.
    Exception
        Any exception of user code (a pointwise method, boundary values, an observer, a stop rule) and an OSError of the disk
        are re-raised with a note of time and step, and with the partial solution as ``solution``; if ``throw`` is false the
        run ends with ``Status.ERROR`` instead. A checkpoint is written first.
    ValueError, TypeError
        For invalid input, regardless of ``throw``.

    Examples
    --------
    >>> import fvkit as fv
    >>> import numpy as np
    >>> wave = lambda x: [np.sin(2.0 * np.pi * x)]
    >>> problem = fv.Problem(fv.Advection(1.0), fv.Grid(0.0, 1.0, 50), wave, 1.0, boundary=fv.Periodic())
    >>> solution = fv.solve(problem, fv.WavePropagation(fv.Roe()), times=[0.5, 1.0], backend="numpy")
    >>> solution.t.tolist(), solution.success
    ([0.0, 0.5, 1.0], True)
    """
    if checkpoint is not None and record is not None:
        raise ValueError("`checkpoint` and `record` cannot be combined, since a checkpoint contains the outputs so far: give one")
    if record is not None:
        validation.instance(record, "record", Stream, 'such as fv.Stream("run.nc")')
    stepper = Stepper(problem, scheme, backend, nonhyperbolic, threads, step)
    targets = _targets(problem, times)
    frames = InMemory(len(targets) + 1, problem.q0) if record is None else record.opened(problem, stepper.scheme)
    return run_to_end(stepper, targets, frames, Control(observers, limits, until), checkpoint, progress, throw)


def run_to_end(stepper: Stepper, targets: list[float], frames: Snapshots, control: Control, checkpoint: Checkpoint | None,
               progress: bool | Callable[[float], None], throw: bool) -> Solution:
    """Advance a stepper to the remaining output times ``targets``; ``frames`` contains the earlier outputs; else as `solve`."""
    problem, throw = stepper.problem, validation.flag(throw, "throw")
    if checkpoint is not None:
        validation.instance(checkpoint, "checkpoint", Checkpoint, "such as fv.Checkpoint('run.npz')")
    if control.until is not None:
        control.until.check(problem)
    saver = None if checkpoint is None else Saver(checkpoint, stepper, frames, targets, control)
    outcome = RunOutcome(stepper)

    def kept() -> dict[str, Any]:
        return effective(problem, stepper.scheme, stepper.stats(), outcome.status, _sentence(outcome, control))

    try:
        if not len(frames.t):
            frames.add(problem.t_start, problem.q0)
        with reporter(checked(progress), problem.t_start, targets[-1] if targets else problem.t_start) as report:
            _march(outcome, targets, frames, control, report, saver)
        if saver is not None:
            with outcome.watch("writing the last checkpoint"):
                saver.write()
            outcome.notes.append(saver.hint())
        if outcome.status is Status.ERROR:
            frames.abandon()
        with outcome.watch("writing the last output"):
            if stepper.t > frames.t[-1]:
                frames.add(stepper.t, stepper.q)
        with outcome.watch("finishing the file of outputs"):
            frames.finish(kept())
    except BaseException:
        frames.abandon()
        raise
    if stepper.only_films_lost:
        stepper.warn_lost()
    solution = Solution(frames.t, frames.q, problem.aux_averages, problem.grid, problem.model, outcome.status, stepper.stats(),
                        _sentence(outcome, control), kept())
    if outcome.failure is not None:
        outcome.attach(solution)
        if throw:
            raise outcome.failure from outcome.failure.__cause__
    return solution


def _sentence(outcome: RunOutcome, control: Control) -> str:
    """Return the final message of a run."""
    stepper = outcome.stepper
    if outcome.status is Status.FINISHED and stepper.t < stepper.problem.t_end:
        return f"the last of the output times was reached, t = {stepper.t:.8g} of t_end = {stepper.problem.t_end:.8g}"
    if outcome.status is not Status.STOPPED:
        return outcome.message
    return f"{outcome.message}, {control.until}, at t = {stepper.t:.8g}, step {stepper.steps}"


def _march(outcome: RunOutcome, targets: list[float], frames: Snapshots, control: Control, report: Callable[[float, int], None],
           saver: Saver | None) -> None:
    """Advance to the remaining output times; ``outcome`` records the outcome."""
    stepper = outcome.stepper
    looked = stepper.seconds > LOOK
    with outcome.watch("writing the first checkpoint"):
        if saver is not None:
            saver.begin()
        for target in targets[len(frames.t) - 1:]:
            while stepper.t < target:
                outcome.doing = f"evaluating {control.until}"
                if control.ends(stepper):
                    outcome.status = Status.STOPPED
                    return
                outcome.doing = "stepping on"
                stepper.run(target, control.limit(stepper))
                for observer in control.observers:
                    outcome.doing = f"calling the observer {observer!r}"
                    observer(stepper)
                outcome.doing = "showing progress"
                report(stepper.t, stepper.steps)
                if not looked and stepper.seconds > LOOK:
                    looked = True
                    control.warn_of_limit(stepper, targets[-1])
                if saver is not None:
                    outcome.doing = "writing a checkpoint"
                    saver.tick()
            outcome.doing = "writing an output"
            frames.add(stepper.t, stepper.q)


def _targets(problem: Problem, times: Iterable[float] | None) -> list[float]:
    if times is None:
        return [problem.t_end]
    targets = validation.series(times, "times", "[0.5, 1.0]")
    if targets[0] < problem.t_start or targets[-1] > problem.t_end or (np.diff(targets) <= 0.0).any():
        raise ValueError(f"`times` must ascend within [{problem.t_start:g}, {problem.t_end:g}], got {targets.tolist()}")
    return [float(target) for target in targets if target > problem.t_start]
