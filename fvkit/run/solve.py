"""`solve` and `rhs`: where problem and scheme meet."""

from collections.abc import Callable, Iterable
from typing import Any

import attrs
import numpy as np

from fvkit import validation
from fvkit.output.configuration import effective
from fvkit.output.solution import Solution
from fvkit.output.status import Status
from fvkit.problem.problem import Problem
from fvkit.run.checkpoint import Checkpoint, Saver
from fvkit.run.failures import Fate
from fvkit.run.limits import Limits
from fvkit.run.progress import checked, reporter
from fvkit.run.recording import InMemory, Snapshots, Stream
from fvkit.run.step_length import Step
from fvkit.run.stepper import Stepper
from fvkit.run.stopping import Stop
from fvkit.schemes.scheme import Scheme


def solve(problem: Problem, scheme: Scheme | None = None, times: Iterable[float] | None = None, *, step: Step | None = None,
          limits: Limits | None = None, until: Stop | None = None, record: Stream | None = None,
          checkpoint: Checkpoint | None = None, observers: Iterable[Callable[[Stepper], None]] = (), backend: str = "auto",
          threads: int | str = 1, nonhyperbolic: str = "warn", progress: bool | Callable[[float], None] = False,
          throw: bool = True) -> Solution:
    """Solve a problem with a scheme.

    Parameters
    ----------
    problem : what is solved.
    scheme : how; None for second-order wave propagation with the model's default Riemann solver.
    times : output times, s, ascending, after the start and not after ``t_end``; None for the end alone.
    step : length of the time steps, such as ``fv.Step(dt_max=0.1)``; None for what the Courant number allows.
    limits : what the run may use up, such as ``fv.Limits(seconds=60.0)``; None for 10,000,000 steps.
    until : when to end before the end time, as a success, such as ``fv.StopAtRest(speed=0.01)``.
    record : ``fv.Stream("run.nc")`` writes every output to disk as soon as it is there; None keeps all in memory. Not with
        ``checkpoint``.
    checkpoint : where and how often the run leaves what `resume` needs to continue it, see `Checkpoint`.
    observers : functions called with the `Stepper` after every accepted step, in order.
    backend : ``"auto"``, ``"numba"`` or ``"numpy"``, see `Stepper`.
    threads : threads of a compiled run, or ``"all"`` for as many as there are cores; more than 1 only from 100,000 cells on.
    nonhyperbolic : ``"warn"``, ``"raise"`` or ``"ignore"`` where characteristic speeds turn complex.
    progress : True shows progress on stderr; or a function that receives the share of simulated time done, 0 to 1.
    throw : whether a run that fails raises; else the partial solution is returned with its status.

    Returns
    -------
    Solution
        Start, then ``times``, up to the state where ``until`` ended the run, if it did; with ``record`` start and end
        alone, and `load` reads all from the file.

    Raises
    ------
    SolveError
        If the run fails and ``throw`` is true; it carries the partial solution. After Ctrl-C it is an `Interrupted`,
        which is a KeyboardInterrupt as well.
    Exception
        Whatever a function of yours raises (a pointwise method, a boundary's values, an observer, a stop rule), and the
        OSError of a disk, as it is, with a note that says at which time and step, and with the partial solution as
        ``solution``; with ``throw`` false the run ends as ``Status.ERROR`` instead. A checkpoint is written first.
    ValueError, TypeError
        For bad input, whatever ``throw`` is.
    """
    if checkpoint is not None and record is not None:
        raise ValueError("`checkpoint` and `record` do not go together: a checkpoint holds the outputs so far, give one of them")
    if record is not None:
        validation.instance(record, "record", Stream, 'such as fv.Stream("run.nc")')
    stepper = Stepper(problem, scheme, backend, nonhyperbolic, threads, step)
    targets = _targets(problem, times)
    frames = InMemory(len(targets) + 1, problem.q0) if record is None else record.opened(problem, stepper.scheme)
    return run_to_end(stepper, targets, frames, Control(observers, limits, until), checkpoint, progress, throw)


def _callbacks(observers: Any) -> tuple[Callable[[Stepper], None], ...]:
    given = tuple(observers) if isinstance(observers, Iterable) and not isinstance(observers, str) else (observers,)
    return tuple(validation.function(observer, "observers", "of the stepper, or a list of them") for observer in given)


@attrs.frozen
class Control:
    """What is looked at during a run, and what may end it early; fields as for `solve`."""

    observers: Any = attrs.field(default=(), converter=_callbacks)
    limits: Limits = attrs.field(default=None, converter=lambda value: Limits() if value is None else validation.instance(
        value, "limits", Limits, "such as fv.Limits(steps=1000)"))
    until: Stop | None = attrs.field(default=None, converter=lambda value: None if value is None else validation.instance(
        value, "until", Stop, "such as fv.StopAtRest(speed=0.01)"))

    def limit(self, stepper: Stepper) -> int:
        """Return the number of steps until someone looks at the run; fail where it has used up what it may."""
        if self.limits.used_up(stepper.steps, stepper.seconds):
            stepper.fail(Status.MAX_STEPS if stepper.steps >= self.limits.steps else Status.OVER_BUDGET)
        if self.observers:
            return 1
        most = min(stepper.batch, self.limits.steps - stepper.steps)
        return most if self.until is None else min(most, self.until.every - stepper.steps % self.until.every)

    def ends(self, stepper: Stepper) -> bool:
        """Whether ``until`` ends the run here."""
        until = self.until
        return until is not None and stepper.steps > 0 and stepper.steps % until.every == 0 \
            and until.reached(stepper.problem, stepper.t, stepper.q)


def run_to_end(stepper: Stepper, targets: list[float], frames: Snapshots, control: Control, checkpoint: Checkpoint | None,
               progress: bool | Callable[[float], None], throw: bool) -> Solution:
    """Run a stepper through the output times that are ahead of it; arguments as for `solve`, ``frames`` those behind it."""
    problem, throw = stepper.problem, validation.flag(throw, "throw")
    if checkpoint is not None:
        validation.instance(checkpoint, "checkpoint", Checkpoint, "such as fv.Checkpoint('run.npz')")
    if control.until is not None:
        control.until.check(problem)
    saver = None if checkpoint is None else Saver(checkpoint, stepper, frames, targets, control)
    fate = Fate(stepper)

    def kept() -> dict[str, Any]:
        return effective(problem, stepper.scheme, stepper.stats(), fate.status, _sentence(fate, control))

    try:
        if not len(frames.t):
            frames.add(problem.t_start, problem.q0)
        with reporter(checked(progress), problem.t_start, targets[-1] if targets else problem.t_start) as report:
            _march(fate, targets, frames, control, report, saver)
        if saver is not None:
            with fate.watch("writing the last checkpoint"):
                saver.write()
            fate.words.append(saver.hint())
        if fate.status is Status.ERROR:
            frames.abandon()
        with fate.watch("writing the last output"):
            if stepper.t > frames.t[-1]:
                frames.add(stepper.t, stepper.q)
        with fate.watch("finishing the file of outputs"):
            frames.finish(kept())
    except BaseException:
        frames.abandon()
        raise
    if stepper.only_films_lost:
        stepper.warn_lost()
    solution = Solution(frames.t, frames.q, problem.aux_averages, problem.grid, problem.model, fate.status, stepper.stats(),
                        _sentence(fate, control), kept())
    if fate.failure is not None:
        fate.tell(solution)
        if throw:
            raise fate.failure from fate.failure.__cause__
    return solution


def _sentence(fate: Fate, control: Control) -> str:
    """How a run ended."""
    stepper = fate.stepper
    if fate.status is Status.FINISHED and stepper.t < stepper.problem.t_end:
        return f"the last of the output times was reached, t = {stepper.t:.8g} of t_end = {stepper.problem.t_end:.8g}"
    if fate.status is not Status.STOPPED:
        return fate.message
    return f"{fate.message}, {control.until}, at t = {stepper.t:.8g}, step {stepper.steps}"


def _march(fate: Fate, targets: list[float], frames: Snapshots, control: Control, report: Callable[[float, int], None],
           saver: Saver | None) -> None:
    """Step through the output times that are ahead; ``fate`` notes how the run ended."""
    stepper = fate.stepper
    with fate.watch("writing the first checkpoint"):
        if saver is not None:
            saver.begin()
        for target in targets[len(frames.t) - 1:]:
            while stepper.t < target:
                fate.doing = f"asking {control.until}"
                if control.ends(stepper):
                    fate.status = Status.STOPPED
                    return
                fate.doing = "stepping on"
                stepper.run(target, control.limit(stepper))
                for observer in control.observers:
                    fate.doing = f"calling the observer {observer!r}"
                    observer(stepper)
                fate.doing = "showing progress"
                report(stepper.t, stepper.steps)
                if saver is not None:
                    fate.doing = "writing a checkpoint"
                    saver.tick()
            fate.doing = "writing an output"
            frames.add(stepper.t, stepper.q)


def _targets(problem: Problem, times: Iterable[float] | None) -> list[float]:
    if times is None:
        return [problem.t_end]
    targets = validation.series(times, "times", "[0.5, 1.0]")
    if targets[0] < problem.t_start or targets[-1] > problem.t_end or (np.diff(targets) <= 0.0).any():
        raise ValueError(f"`times` must ascend within [{problem.t_start:g}, {problem.t_end:g}], got {targets.tolist()}")
    return [float(target) for target in targets if target > problem.t_start]


