"""`Limits`: largest number of steps and largest wall time of a run."""

import attrs
import numpy as np

from fvkit.pointwise.part import Part
from fvkit.validation import integer, optional_number


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

    steps: int = integer(10_000_000, at_least=0)
    seconds: float | None = optional_number(above=0.0)

    def used_up(self, steps: int, seconds: float) -> bool:
        """Whether so many steps, or so much wall time in seconds, reach a limit."""
        return steps >= self.steps or seconds > (np.inf if self.seconds is None else self.seconds)
