"""`solve` and `rhs`: where problem and scheme meet."""

from collections.abc import Callable, Iterable
from pathlib import Path
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
from fvkit.run.progress import checked, reporter
from fvkit.run.recording import Frames, Memory, Stream
from fvkit.run.step_length import StepLength
from fvkit.run.stepper import Stepper
from fvkit.run.stopping import Stop
from fvkit.schemes.scheme import Scheme


def solve(problem: Problem, scheme: Scheme | None = None, times: Iterable[float] | None = None, *, backend: str = "auto",
          progress: bool | Callable[[float], None] = False, throw: bool = True, max_steps: int = 10_000_000,
          observers: Iterable[Callable[[Stepper], None]] = (), nonhyperbolic: str = "warn",
          threads: int = 1, seconds: float | None = None, checkpoint: Checkpoint | None = None,
          stream: str | Path | None = None, stop: Stop | None = None, dt: float | None = None, dt_max: float | None = None,
          dt_initial: float | None = None) -> Solution:
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
    stop : when to end before the end time, as a success, such as ``fv.StopAtRest(speed=0.01)``.
    dt : length of every step, s, but for those that are shortened to end at an output time; a longer one than the Courant
        number allows ends the run as failed. None for the longest that the Courant number allows.
    dt_max, dt_initial : longest step, and longest first step, s; None for what the Courant number allows. Not with ``dt``.

    Returns
    -------
    Solution
        Start, then ``times``, up to the state where ``stop`` ended the run, if it did; with ``stream`` start and end alone,
        and `load` reads all from the file.

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
    if checkpoint is not None and stream is not None:
        raise ValueError("`checkpoint` and `stream` do not go together: a checkpoint holds the outputs so far, give one of them")
    stepper = Stepper(problem, scheme, backend, nonhyperbolic, threads, StepLength(dt_max, dt_initial, dt))
    targets = _targets(problem, times)
    stream = None if stream is None else validation.file(stream, "stream")
    frames = Memory(len(targets) + 1, problem.q0) if stream is None else Stream(stream, problem, stepper.scheme)
    orders = Orders(observers, max_steps, np.inf if seconds is None else validation.real(seconds, "seconds", above=0.0), stop)
    return run_to_end(stepper, targets, frames, orders, checkpoint, progress, throw)


def _callbacks(observers: Any) -> tuple[Callable[[Stepper], None], ...]:
    given = tuple(observers) if isinstance(observers, Iterable) and not isinstance(observers, str) else (observers,)
    return tuple(validation.function(observer, "observers", "of the stepper, or a list of them") for observer in given)


def _stop(value: Any) -> Stop | None:
    return None if value is None else validation.instance(value, "stop", Stop, "such as fv.StopAtRest(speed=0.01)")


@attrs.frozen
class Orders:
    """What is looked at during a run, and what may end it early; fields as for `solve`."""

    observers: Any = attrs.field(default=(), converter=_callbacks)
    max_steps: int = attrs.field(default=10_000_000, converter=lambda value: validation.whole(value, "max_steps", at_least=0))
    seconds: float = np.inf
    stop: Stop | None = attrs.field(default=None, converter=_stop)

    def limit(self, stepper: Stepper) -> int:
        """Return the number of steps until someone looks at the run; fail where it has used up what it may."""
        if stepper.steps >= self.max_steps:
            stepper.fail(Status.MAX_STEPS)
        if stepper.seconds > self.seconds:
            stepper.fail(Status.OVER_BUDGET)
        if self.observers:
            return 1
        most = min(stepper.batch, self.max_steps - stepper.steps)
        return most if self.stop is None else min(most, self.stop.every - stepper.steps % self.stop.every)

    def ends(self, stepper: Stepper) -> bool:
        """Whether ``stop`` ends the run here."""
        asked = self.stop is not None and stepper.steps > 0 and stepper.steps % self.stop.every == 0
        return asked and self.stop.reached(stepper.problem, stepper.t, stepper.q)  # type: ignore[union-attr]


def run_to_end(stepper: Stepper, targets: list[float], frames: Frames, orders: Orders, checkpoint: Checkpoint | None,
               progress: bool | Callable[[float], None], throw: bool) -> Solution:
    """Run a stepper through the output times that are ahead of it; arguments as for `solve`, ``frames`` those behind it."""
    problem, throw = stepper.problem, validation.flag(throw, "throw")
    if checkpoint is not None:
        validation.instance(checkpoint, "checkpoint", Checkpoint, "such as fv.Checkpoint('run.npz')")
    if orders.stop is not None:
        orders.stop.check(problem)
    saver = None if checkpoint is None else Saver(checkpoint, stepper, frames, targets, orders.stop, orders.observers)
    fate = Fate(stepper)

    def kept() -> dict[str, Any]:
        return effective(problem, stepper.scheme, stepper.stats(), fate.status, _sentence(fate, orders))

    try:
        if not len(frames.t):
            frames.add(problem.t_start, problem.q0)
        with reporter(checked(progress), problem.t_start, targets[-1] if targets else problem.t_start) as report:
            _march(fate, targets, frames, orders, report, saver)
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
                        _sentence(fate, orders), kept())
    if fate.failure is not None:
        fate.tell(solution)
        if throw:
            raise fate.failure from fate.failure.__cause__
    return solution


def _sentence(fate: Fate, orders: Orders) -> str:
    """How a run ended."""
    stepper = fate.stepper
    if fate.status is Status.FINISHED and stepper.t < stepper.problem.t_end:
        return f"the last of the output times was reached, t = {stepper.t:.8g} of t_end = {stepper.problem.t_end:.8g}"
    if fate.status is not Status.STOPPED:
        return fate.message
    return f"{fate.message}, {orders.stop}, at t = {stepper.t:.8g}, step {stepper.steps}"


def _march(fate: Fate, targets: list[float], frames: Frames, orders: Orders, report: Callable[[float, int], None],
           saver: Saver | None) -> None:
    """Step through the output times that are ahead; ``fate`` notes how the run ended."""
    stepper = fate.stepper
    with fate.watch("writing the first checkpoint"):
        if saver is not None:
            saver.begin()
        for target in targets[len(frames.t) - 1:]:
            while stepper.t < target:
                fate.doing = f"asking {orders.stop}"
                if orders.ends(stepper):
                    fate.status = Status.STOPPED
                    return
                fate.doing = "stepping on"
                stepper.run(target, orders.limit(stepper))
                for observer in orders.observers:
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


