"""References that a scene is measured against: a function of space and time, or a run on a finer grid."""

from abc import ABC, abstractmethod
from collections.abc import Callable, Mapping
from typing import Any

import attrs
import numpy as np

from fvkit import Grid, validation
from fvkit.output.solution import Solution
from fvkit.problem.cell_averages import cell_averages
from fvkit_granular.models.quantities import conserved

#: The only kinds of reference.
KINDS = ("exact", "semi-exact", "self-converged")


@attrs.frozen(eq=False)
class Reference(ABC):
    """Abstract reference solution. Contract:

    1. ``kind`` is ``"exact"``, ``"semi-exact"`` (depends on a path) or ``"self-converged"``; ``detail`` is one sentence.
    2. ``averages(model, grid, t)`` returns cell averages (num_eqn, num_cells) of what the flow is to ``model``.
    3. ``path_sensitivity()`` returns how much hangs on the path across shocks, with a line of ``text``; None if nothing.

    Parameters
    ----------
    kind : one of ``KINDS``.
    detail : one sentence: which solution, how accurate.
    """

    kind: str = validation.field(validation.choice, known=KINDS)
    detail: str = validation.words("")

    @abstractmethod
    def averages(self, model: Any, grid: Grid, t: float) -> np.ndarray:
        """Return the reference as cell averages of the conserved quantities of ``model``."""

    def path_sensitivity(self) -> dict[str, Any] | None:
        """Return what `fvkit_granular.exact.path_sensitivity` finds, None for flows without internal shocks."""
        return None


@attrs.frozen(eq=False)
class FunctionReference(Reference):
    """A reference given as a function.

    Parameters
    ----------
    kind : one of ``KINDS``.
    detail : one sentence: which solution, how accurate.
    at : (x, t) -> {h, phi, vs, vf}.
    bottom : x -> b, m, under a flow that gives ``surface`` for h.
    sensitivity : what ``path_sensitivity`` returns, computed when it is asked.
    """

    at: Callable[[np.ndarray, float], Mapping[str, Any]] = validation.field(
        validation.function, hint="(x, t) -> {h, phi, vs, vf}", kw_only=True, repr=False)
    bottom: Callable[[np.ndarray], Any] | None = validation.field(
        validation.function, None, optional=True, hint="x -> b", kw_only=True, repr=False)
    sensitivity: Callable[[], dict[str, Any] | None] | None = validation.field(
        validation.function, None, optional=True, hint="without arguments", kw_only=True, repr=False)

    def path_sensitivity(self) -> dict[str, Any] | None:
        return None if self.sensitivity is None else self.sensitivity()

    def averages(self, model: Any, grid: Grid, t: float) -> np.ndarray:
        values = conserved(model, lambda x: self.at(x, t), self.bottom)
        return cell_averages(values, grid, len(model.conserved), "reference")


@attrs.frozen(eq=False)
class SelfConverged(Reference):
    """The full model itself on a fine grid, averaged onto the cells of the coarse one.

    Parameters
    ----------
    kind : ``"self-converged"``.
    detail : one sentence: which scheme, how many cells.
    solution : a solution whose observables include h, phi, vs, vf.
    """

    solution: Solution = validation.field(
        validation.instance, kind=Solution, hint="such as fv.solve returns it", kw_only=True, repr=False)

    def averages(self, model: Any, grid: Grid, t: float) -> np.ndarray:
        fine = self.solution.grid
        seen = self.solution.observables(int(np.argmin(np.abs(self.solution.t - t))))
        q = model.conserved_from(*(seen[name] for name in ("h", "phi", "vs", "vf")))
        integrals = np.concatenate([np.zeros((len(q), 1)), np.cumsum(q, axis=1) * fine.dx], axis=1)
        return np.array([np.diff(np.interp(grid.edges, fine.edges, row)) / grid.dx for row in integrals])


def still(flow: Callable[[np.ndarray], Mapping[str, Any]], bottom: Callable[..., Any] | None = None) -> FunctionReference:
    """Return the reference of a flow x -> {h, phi, vs, vf} at rest, over ``bottom`` if it gives ``surface`` for h."""
    return FunctionReference("exact", "the initial state for ever", at=lambda x, t: flow(x), bottom=bottom)


def one_velocity(seen: Mapping[str, Any], phi: Any) -> dict[str, Any]:
    """Return {h, phi, vs, vf} of a depth h and a single velocity v."""
    return {"h": seen["h"], "phi": phi, "vs": seen["v"], "vf": seen["v"]}
