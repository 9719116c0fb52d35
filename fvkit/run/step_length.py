"""Time that is measured out: the length of steps that a user asks for, and whole intervals that have passed."""

from math import floor

import attrs
import numpy as np

from fvkit.pointwise.part import Part
from fvkit.validation import optional_number

#: Share of an interval by which rounding may miss its end: times are sums of many steps.
ROUNDING = 1e-6


def intervals(start: float, t: float, length: float) -> int:
    """Return how many whole intervals there are from ``start`` to ``t``; one whose end is missed by rounding is whole."""
    return floor((t - start) / length + ROUNDING)


@attrs.frozen
class Step(Part):
    """Length of time steps, s; each bound positive, or None for what the Courant number allows.

    Parameters
    ----------
    dt : every step is this long, but for those that are shortened to end at an output time; a step that the Courant
        number does not allow ends the run (`Status.DT_TOO_LARGE`). Alone.
    dt_max : no step is longer. It also keeps a run that starts at rest from stepping over what happens later.
    dt_initial : the first step is no longer.

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
        """The smallest and the largest length of a step; equal where it is fixed."""
        return self.dt or 0.0, self.dt or self.dt_max or np.inf
