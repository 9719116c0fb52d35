"""`Keep`: outputs of a sweep, by name."""

from collections.abc import Callable, Iterable
from typing import Any

import attrs
import numpy as np

from fvkit import validation
from fvkit.output.solution import Solution
from fvkit.problem.grid import NAMES

#: Share of its largest value at the start above which an observable counts as arrived.
ARRIVED = 1e-3


def _front(solution: Solution, name: str, values: np.ndarray) -> float:
    """Right edge of the last cell where the observable exceeds `ARRIVED` of its first maximum; NaN where there is none."""
    there = np.flatnonzero(np.abs(values) > ARRIVED * np.abs(solution.observables(0)[name]).max())
    return float(solution.grid.edges[there[-1] + 1]) if there.size else np.nan


#: What an observable at the end is reduced to.
REDUCTIONS: dict[str, Callable[[Solution, str, np.ndarray], float]] = {
    "max": lambda solution, name, values: float(np.max(values)),
    "min": lambda solution, name, values: float(np.min(values)),
    "mean": lambda solution, name, values: float(np.mean(values)),
    "front": _front,
}

#: Argument name in messages.
OUTPUTS = "names` of outputs to `keep"

#: Statistics of a run that may be kept.
STATS = ("steps", "rejected", "seconds", "max_cfl", "nonhyperbolic_faces")


def _known(names: Iterable[str]) -> tuple[str, ...]:
    given = (names,) if isinstance(names, str) else tuple(validation.listed(
        names, OUTPUTS, "['max.h', 'steps']"))
    for name in given:
        if not isinstance(name, str):
            raise TypeError(f"`{OUTPUTS}` must be texts, got {validation.shown(name)}")
        if "." in name:
            validation.choice(name.split(".")[0], f"{OUTPUTS}`: the reduction of `{name}", REDUCTIONS)
    return given


@attrs.frozen
class Keep:
    """Outputs of a sweep: a function of a solution that returns named numbers and arrays of its last output.

    Parameters
    ----------
    names : ``"h"`` or any other observable: its cell values, with the cell centres as ``x``, on a grid with two
        axes (ny, nx) values with ``x`` and ``y``; ``"max.h"``, ``"min.h"``,
        ``"mean.h"`` over the cells; ``"front.h"``: the right edge of the last cell where abs(h) exceeds 1/1000 of its
        maximum at the start, one axis alone; ``"steps"`` and other statistics. Empty: every observable.

    Raises
    ------
    ValueError
        For an unknown name, with the list and the nearest match; for observables at the call, since they depend on the model.

    Examples
    --------
    >>> import fvkit as fv
    >>> fv.Keep(["max.h", "steps"])
    Keep(names=('max.h', 'steps'))
    """

    names: tuple[str, ...] = attrs.field(default=(), converter=_known)

    def check(self, observables: Iterable[str], axes: int = 1) -> None:
        """Raise where a name is not among these observables and the statistics, or has no meaning with so many axes."""
        known = (*observables, *STATS)
        for name in self.names:
            reduction, _, observable = name.rpartition(".")
            validation.choice(observable, f"output {name}", known)
            if reduction == "front" and axes > 1:
                raise ValueError(f"{name} needs a grid with one axis, got one with two: keep {observable}, max.{observable} or "
                                 f"mean.{observable}")

    def __call__(self, solution: Solution) -> dict[str, Any]:
        seen: dict[str, np.ndarray] = solution.observables()
        self.check(seen, len(solution.grid.axes))
        result: dict[str, Any] = {}
        for name in self.names or seen:
            reduction, _, observable = name.rpartition(".")
            if name in STATS:
                result[name] = getattr(solution.stats, name)
                continue
            values = seen[observable]
            if reduction:
                result[name] = REDUCTIONS[reduction](solution, observable, values)
            else:
                result |= {name: values, **{axis: one.centers for axis, one in zip(NAMES, solution.grid.axes, strict=False)}}
        return result
