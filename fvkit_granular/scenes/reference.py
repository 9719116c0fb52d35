"""Reference solutions of scenes: a function of space and time, or a run on a finer grid."""

import inspect
from abc import ABC, abstractmethod
from collections.abc import Callable, Mapping
from typing import Any

import attrs
import numpy as np

from fvkit import Grid, validation
from fvkit.output.solution import Solution
from fvkit.problem.cell_averages import cell_averages
from fvkit.problem.directions import component_names
from fvkit.studies.fine_grid_reference import averaged
from fvkit_granular.models.quantities import Flow, conserved, conserved_from

#: The only kinds of reference.
KINDS = ("exact", "semi-exact", "self-converged")


@attrs.frozen(eq=False)
class Reference(ABC):
    """Abstract reference solution. Contract:

    1. ``kind`` is ``"exact"``, ``"semi-exact"`` (depends on a path) or ``"self-converged"``; ``detail`` is one sentence.
    2. ``averages(model, grid, t)`` returns cell averages (rows, *grid.shape) of the flow in the variables of ``model``.
    3. ``path_sensitivity()`` returns the sensitivity to the path across shocks, with a line of ``text``; None if there is none.

    Parameters
    ----------
    kind : one of ``KINDS``.
    detail : one sentence: which solution, how accurate.

    Examples
    --------
    >>> import attrs
    >>> import numpy as np
    >>> import fvkit as fv
    >>> import fvkit_granular as gr
    >>> @attrs.frozen
    ... class StillWater(gr.Reference):
    ...     def averages(self, model, grid, t):
    ...         return np.stack([np.ones(grid.shape), np.zeros(grid.shape)])
    >>> StillWater("exact", "1 m of water at rest").averages(gr.ShallowWater(), fv.Grid(0.0, 1.0, 3), 0.0)
    array([[1., 1., 1.],
           [0., 0., 0.]])
    """

    kind: str = validation.field(validation.choice, known=KINDS)
    detail: str = validation.words("")

    @abstractmethod
    def averages(self, model: Any, grid: Grid, t: float) -> np.ndarray:
        """Return the reference as cell averages of the conserved quantities of ``model``."""

    def path_sensitivity(self) -> dict[str, Any] | None:
        """Return the result of `fvkit_granular.exact.path_sensitivity`, None for flows without internal shocks."""
        return None


@attrs.frozen(eq=False)
class FunctionReference(Reference):
    """Reference solution given as a function.

    Parameters
    ----------
    kind : one of ``KINDS``.
    detail : one sentence: which solution, how accurate.
    at : (x, t) -> {h, phi, vs, vf}; with two axes (x, y, t) -> {h, phi, vs_x, vs_y, vf_x, vf_y}.
    bottom : x, or x and y -> b, m, under a flow that gives ``surface`` for h.
    sensitivity : function for ``path_sensitivity``, called when it is needed.

    Examples
    --------
    >>> import fvkit_granular as gr
    >>> import numpy as np
    >>> reference = gr.FunctionReference("exact", "rest", at=lambda x, t: {"h": 1.0 + 0.0 * x, "phi": 0.5, "vs": 0.0, "vf": 0.0})
    >>> reference.kind
    'exact'
    """

    at: Callable[..., Mapping[str, Any]] = validation.field(
        validation.function, hint="(x, t) -> {h, phi, vs, vf}", kw_only=True, repr=False)
    bottom: Callable[..., Any] | None = validation.field(
        validation.function, None, optional=True, hint="x -> b", kw_only=True, repr=False)
    sensitivity: Callable[[], dict[str, Any] | None] | None = validation.field(
        validation.function, None, optional=True, hint="without arguments", kw_only=True, repr=False)

    def path_sensitivity(self) -> dict[str, Any] | None:
        return None if self.sensitivity is None else self.sensitivity()

    def check_axes(self, axes: tuple[str, ...]) -> None:
        """Raise TypeError where ``at`` cannot be called with the places of so many axes and a time."""
        try:
            inspect.signature(self.at).bind(*axes, "t")
        except ValueError:  # what has no signature
            return
        except TypeError as error:
            raise TypeError(f"`at` of the reference must be a function of {', '.join(axes)} and t for this scene, got one that "
                            f"takes other arguments ({error})") from None

    def averages(self, model: Any, grid: Grid, t: float) -> np.ndarray:
        values = conserved(model, lambda *places: self.at(*places, t), self.bottom)
        return cell_averages(values, grid, len(component_names(model, grid)), "reference")


@attrs.frozen(eq=False)
class SelfConverged(Reference):
    """Self-converged reference: the full model on a fine grid, averaged onto the cells of the coarse one.

    Parameters
    ----------
    kind : ``"self-converged"``.
    detail : one sentence: which scheme, how many cells.
    solution : a solution whose observables include h, phi, vs, vf.

    Examples
    --------
    >>> import fvkit as fv, fvkit_granular as gr
    >>> fine = fv.solve(gr.scene("dam-break").problem(gr.TwoPhase, 400), backend="numpy")
    >>> reference = gr.SelfConverged("self-converged", "Relaxation, MC, 400 cells", solution=fine)
    >>> reference.averages(gr.TwoPhase(), fv.Grid(-5.0, 5.0, 100), 0.5).shape
    (4, 100)
    """

    solution: Solution = validation.field(
        validation.instance, kind=Solution, hint="such as fv.solve returns it", kw_only=True, repr=False)

    def averages(self, model: Any, grid: Grid, t: float) -> np.ndarray:
        seen = self.solution.observables(int(np.argmin(np.abs(self.solution.t - t))))
        return averaged(conserved_from(model, seen, len(grid.axes)), self.solution.grid, grid)


def still(flow: Flow, bottom: Callable[..., Any] | None = None) -> FunctionReference:
    """Return the reference of a flow at rest, a function of x, or of x and y, over ``bottom`` if it gives ``surface`` for h."""
    return FunctionReference("exact", "the initial state at all times", at=lambda *places: flow(*places[:-1]), bottom=bottom)


def one_velocity(seen: Mapping[str, Any], phi: Any) -> dict[str, Any]:
    """Return the primitive variables of a depth h and a single velocity: v, or v_x and v_y with two axes."""
    return {"h": seen["h"], "phi": phi} | {f"{phase}{name[1:]}": value for name, value in seen.items() if name[0] == "v"
                                           for phase in ("vs", "vf")}
