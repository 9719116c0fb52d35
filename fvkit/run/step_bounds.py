"""Length of time steps: user-defined bounds, and the number of elapsed time intervals."""

from math import floor

import attrs
import numpy as np

from fvkit.pointwise.part import Part
from fvkit.validation import optional_number

#: Tolerance relative to the length of an interval, since times are sums of many steps and have round-off.
ROUNDING = 1e-6


def intervals(start: float, t: float, length: float) -> int:
    """Return the number of complete intervals from ``start`` to ``t``, with a tolerance for round-off."""
    return floor((t - start) / length + ROUNDING)


@attrs.frozen
class Step(Part):
    """Length of time steps, s; each bound is positive, or None for the step of the Courant number.

    Parameters
    ----------
    dt : fixed length of all steps except those shortened to end at an output time. A step above the largest Courant number
        ends the run (`Status.DT_TOO_LARGE`). Excludes the other two bounds.
    dt_max : upper bound of all steps; needed where a flow at rest is set in motion later, such as by an inflow.
    dt_initial : upper bound of the first step.

    Raises
    ------
    ValueError
        If ``dt`` is given with another bound, or a bound is not positive.

    Examples
    --------
    >>> import fvkit as fv
    >>> problem = fv.Problem(fv.Advection(1.0), fv.Grid(0.0, 1.0, 50), lambda x: [0.0 * x + 1.0], 1.0, boundary=fv.Periodic())
    >>> fv.solve(problem, step=fv.Step(dt=0.01), backend="numpy").stats.steps
    100
    """

    dt: float | None = optional_number(above=0.0)
    dt_max: float | None = optional_number(above=0.0)
    dt_initial: float | None = optional_number(above=0.0)

    def __attrs_post_init__(self) -> None:
        if self.dt is not None and (self.dt_max, self.dt_initial) != (None, None):
            raise ValueError("`dt` fixes every step: give it without `dt_max` and `dt_initial`")

    @property
    def bounds(self) -> tuple[float, float]:
        """Smallest and largest length of a step, s; equal for a fixed step."""
        return self.dt or 0.0, self.dt or self.dt_max or np.inf
