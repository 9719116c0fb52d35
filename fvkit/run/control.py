"""Observers, limits and stop rule of a run."""

import warnings
from collections.abc import Callable, Iterable
from typing import Any

import attrs
import numpy as np

from fvkit import validation
from fvkit.output.status import Status
from fvkit.pointwise.part import Part
from fvkit.run.progress import duration
from fvkit.run.stepper import Stepper
from fvkit.run.stopping import Stop

#: Share of the end time that the steps allowed must reach, at the rate so far, for a run to go on without a warning.
SHORT = 0.5

#: Wall time of the stepping, s, after which this is looked at, once.
LOOK = 5.0


@attrs.frozen
class Limits(Part):
    """Limits of a run: steps and wall time. A run that exceeds a limit fails.

    Parameters
    ----------
    steps : largest number of accepted steps, counted from the start of the run (`Status.MAX_STEPS`).
    seconds : wall time of the stepping, s, kept to about 0.1 s (`Status.OVER_BUDGET`); None for no limit.

    Examples
    --------
    >>> import fvkit as fv
    >>> fv.Limits(steps=1000, seconds=60.0)
    Limits(steps=1000, seconds=60.0)
    """

    steps: int = validation.integer(10_000_000, at_least=0)
    seconds: float | None = validation.optional_number(above=0.0)

    def used_up(self, steps: int, seconds: float) -> bool:
        """Whether a number of steps, or a wall time in seconds, reaches a limit."""
        return steps >= self.steps or seconds > (np.inf if self.seconds is None else self.seconds)


def _callbacks(observers: Any) -> tuple[Callable[[Stepper], None], ...]:
    given = tuple(observers) if isinstance(observers, Iterable) and not isinstance(observers, str) else (observers,)
    return tuple(validation.function(observer, "observers", "of the stepper, or a list of them") for observer in given)


@attrs.frozen
class Control:
    """Observers, limits and stop rule of a run; fields as for `solve`."""

    observers: Any = attrs.field(default=(), converter=_callbacks)
    limits: Limits = attrs.field(default=None, converter=lambda value: Limits() if value is None else validation.instance(
        value, "limits", Limits, "such as fv.Limits(steps=1000)"))
    until: Stop | None = validation.field(validation.instance, None, optional=True, kind=Stop,
                                          hint="such as fv.StopAtRest(speed=0.01)")

    def limit(self, stepper: Stepper) -> int:
        """Return the number of steps to take before the next return to Python; raise `SolveError` at a limit of the run."""
        if self.limits.used_up(stepper.steps, stepper.seconds):
            stepper.fail(Status.MAX_STEPS if stepper.steps >= self.limits.steps else Status.OVER_BUDGET)
        if self.observers:
            return 1
        most = min(stepper.batch, self.limits.steps - stepper.steps)
        return most if self.until is None else min(most, self.until.every - stepper.steps % self.until.every)

    def warn_of_limit(self, stepper: Stepper, end: float) -> None:
        """Warn where a run without limits of its own, at its rate so far, takes all steps long before the time ``end``."""
        problem, done = stepper.problem, stepper.t - stepper.problem.t_start
        if self.limits != Limits() or self.until is not None or done <= 0.0:
            return
        share = self.limits.steps / stepper.steps * done / (end - problem.t_start)
        if share < SHORT:
            time, steps = (size * (end - stepper.t) / done for size in (stepper.seconds, stepper.steps))
            warnings.warn(f"after {stepper.steps} steps the run is at t = {stepper.t:.4g} of {end:.4g}: at this rate it needs "
                          f"about {duration(time)} and {steps:.2g} steps more, and its limit is {self.limits.steps} "
                          "steps: take a smaller `t_end`, fewer cells or limits=fv.Limits(steps=...)",
                          RuntimeWarning, stacklevel=validation.users_line())

    def ends(self, stepper: Stepper) -> bool:
        """Whether the stop rule ``until`` ends the run at the current step."""
        until = self.until
        return until is not None and stepper.steps > 0 and stepper.steps % until.every == 0 \
            and until.reached(stepper.problem, stepper.t, stepper.q)
