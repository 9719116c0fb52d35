"""`Scene`: physics without numerics, and the reference that it is measured against."""

from abc import ABC, abstractmethod
from collections.abc import Callable, Mapping
from typing import Any

import attrs
import numpy as np

from fvkit import Grid, Model, Outflow, Problem, Source, _validate
from fvkit.problem import boundary_pair, source_list
from fvkit.quadrature import cell_averages, levelled
from fvkit.solution import Solution
from fvkit_granular.columns import Profile, missing
from fvkit_granular.shaped_flow import ShapedFlow
from fvkit_granular.shapes import Step
from fvkit_granular.slope import warn_of_steep_ground
from fvkit_granular.states import over, over_ground, whole_flow

#: The only kinds of reference.
KINDS = ("exact", "semi-exact", "self-converged")

Flow = Callable[[np.ndarray], Mapping[str, Any]]


def conserved(model: Model, flow: Flow, ground: Callable[[np.ndarray], Any] | None = None) -> Callable[[np.ndarray], np.ndarray]:
    """Return x -> conserved values of ``model`` for a function x -> {h, phi, vs, vf}.

    Over ``ground``, x -> b, the flow may give ``surface``, its level, for h: cells that are dry in part then get the depth of the
    level over their mean bottom, and x must be the nodes of whole cells, see `fvkit.quadrature.levelled`.
    """
    def values(x: np.ndarray) -> np.ndarray:
        state = whole_flow(over_ground(flow(x), x, ground, levelled))
        return model.conserved_from(*(over(x, state[name], name)  # type: ignore[attr-defined]
                                      for name in ("h", "phi", "vs", "vf")))

    return values


def two_states(left: Mapping[str, float], right: Mapping[str, float], at: float = 0.0) -> ShapedFlow:
    """Return the flow of two uniform states with a jump at x = ``at``, m."""
    return ShapedFlow(**{name: Step(at, left[name], right[name]) if left[name] != right[name] else left[name] for name in left})


def _kind(value: Any) -> Any:
    return _validate.choice(value, "kind", KINDS)


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

    kind: str = attrs.field(converter=_kind)
    detail: str = _validate.words("")

    @abstractmethod
    def averages(self, model: Model, grid: Grid, t: float) -> np.ndarray:
        """Return the reference as cell averages of the conserved quantities of ``model``."""

    def path_sensitivity(self) -> dict[str, Any] | None:
        """Return what `fvkit_granular.exact.path_sensitivity` finds, None for flows without internal shocks."""
        return None


def _at(value: Any) -> Any:
    return _validate.function(value, "at", "(x, t) -> {h, phi, vs, vf}")


def _ground(value: Any) -> Any:
    return _validate.function(value, "bottom", "x -> b")


def _sensitivity(value: Any) -> Any:
    return _validate.function(value, "sensitivity", "without arguments")


def _solution(value: Any) -> Any:
    return _validate.instance(value, "solution", Solution, "such as fv.solve returns it")


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

    at: Callable[[np.ndarray, float], Mapping[str, Any]] = attrs.field(converter=_at, kw_only=True, repr=False)
    bottom: Callable[[np.ndarray], Any] | None = attrs.field(
        default=None, converter=attrs.converters.optional(_ground), kw_only=True, repr=False)
    sensitivity: Callable[[], dict[str, Any] | None] | None = attrs.field(
        default=None, converter=attrs.converters.optional(_sensitivity), kw_only=True, repr=False)

    def path_sensitivity(self) -> dict[str, Any] | None:
        return None if self.sensitivity is None else self.sensitivity()

    def averages(self, model: Model, grid: Grid, t: float) -> np.ndarray:
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

    solution: Solution = attrs.field(converter=_solution, kw_only=True, repr=False)

    def averages(self, model: Model, grid: Grid, t: float) -> np.ndarray:
        fine = self.solution.grid
        seen = self.solution.observables(int(np.argmin(np.abs(self.solution.t - t))))
        q = model.conserved_from(*(seen[name] for name in ("h", "phi", "vs", "vf")))  # type: ignore[attr-defined]
        integrals = np.concatenate([np.zeros((len(q), 1)), np.cumsum(q, axis=1) * fine.dx], axis=1)
        return np.array([np.diff(np.interp(grid.edges, fine.edges, row)) / grid.dx for row in integrals])


def _interval(value: Any) -> tuple[float, float]:
    return _validate.interval(value, "interval")


def ascending(value: Any) -> tuple[float, ...]:
    """Return output times as a tuple, checked."""
    times = _validate.series(value, "times", "[0.5, 1.0]")
    if times[0] <= 0.0 or (np.diff(times) <= 0.0).any():
        raise ValueError("`times` must be a list of positive times that ascend, or None for the end alone, got "
                         f"{_validate.shown(value)}")
    return tuple(times.tolist())


def _flow(value: Any) -> Any:
    return _validate.function(value, "initial", "x -> {h, phi, vs, vf}")


def _reference(value: Any) -> Any:
    return value if isinstance(value, Reference) else _validate.function(value, "reference", "of the scene, or a gr.Reference")


@attrs.frozen(eq=False)
class Scene:
    """A flow to be computed, in physical terms, for any of the models.

    Parameters
    ----------
    interval : (lower, upper), m.
    t_end : end time, s, positive.
    initial : x (m,) -> {h, phi, vs, vf}, arrays or numbers; vs and vf are 0 where missing. ``surface``, the level in m, may
        stand for h: h = max(surface - bottom, 0), in cells that are dry in part over their mean bottom, so that a lake is at rest
        on every grid (a change of its volume by O(dx^2), at shores alone). Use it rather than max(level - b(x), 0).
    bottom : height b of the bottom, m: function of x, cell averages, or number.
    boundary : one boundary condition, or (left, right).
    sources : a source or a sequence of them. Drag is left out for models with one velocity.
    g : gravity, m/s^2.
    gamma : density ratio fluid/solid in (0, 1).
    reference : `Reference`, or a function of the scene that makes one when it is first needed; None if there is none.
    name, description : for lists and reports; the description tells where the case comes from.
    times : output times of ``fvkit run``, s, ascending; None for the end alone.
    """

    interval: tuple[float, float] = attrs.field(converter=_interval)
    t_end: float = attrs.field(converter=_validate.within(above=0.0))  # type: ignore[misc]
    initial: Flow = attrs.field(converter=_flow, repr=False)
    bottom: Any = attrs.field(default=0.0, repr=False)
    boundary: Any = attrs.field(factory=Outflow, validator=lambda scene, field, value: boundary_pair(value))
    sources: Any = attrs.field(default=(), validator=lambda scene, field, value: source_list(value))
    g: float = _validate.number(9.81, above=0.0)
    gamma: float = _validate.number(0.5, above=0.0, below=1.0, hint="density of the fluid over density of the solid")
    reference: Reference | Callable[["Scene"], Reference] | None = attrs.field(
        default=None, converter=attrs.converters.optional(_reference), repr=False)
    name: str = _validate.words("")
    description: str = _validate.words("")
    times: tuple[float, ...] | None = attrs.field(default=None, converter=attrs.converters.optional(ascending))

    def __attrs_post_init__(self) -> None:
        if isinstance(self.bottom, Profile):
            self.bottom.warn_of_units()

    def model(self, model: Any) -> Model:
        """Return ``model`` if it is an instance; a class gets the scene's g and gamma."""
        if isinstance(model, type) and issubclass(model, Model):
            return model(**{name: getattr(self, name) for name in model.parameter_names() if name in ("g", "gamma")})
        return _validate.instance(model, "model", Model, "such as gr.TwoPhase, or gr.TwoPhase(g=9.81, gamma=0.5)")

    def problem(self, model: Any, cells: int) -> Problem:
        """Return the problem for ``model`` (instance, or class that then gets g and gamma) on ``cells`` cells.

        Warns (`SteepSlopeWarning`) where the flow may reach ground steeper than 15 degrees, see `fvkit_granular.slope`.
        """
        chosen = self.model(model)
        if not callable(getattr(chosen, "conserved_from", None)):
            raise ValueError(f"`model` of a scene must make its state of h, phi, vs and vf, but {type(chosen).__name__} has no "
                             "`conserved_from`: take a model of fvkit_granular, or build a fvkit.Problem")
        if "b" not in chosen.aux and (callable(self.bottom) or np.any(np.asarray(self.bottom) != 0.0)):
            raise ValueError(f"`bottom` of the scene is not flat, but {type(chosen).__name__} has no `b` in its `aux`: take "
                             "another model, or bottom=0.0")
        grid = Grid(*self.interval, cells)
        sources = tuple(source for source in self.given_sources()
                        if not (isinstance(source, Source) and source.between_phases and len(chosen.phases) < 2))
        result = Problem(chosen, grid, conserved(chosen, self.initial, self.height), self.t_end,
                         aux={"b": self.bottom} if "b" in chosen.aux else {}, boundary=self.boundary, sources=sources)
        self._refuse_gaps(grid.centers)
        warn_of_steep_ground(result, self.g)
        return result

    def _refuse_gaps(self, x: np.ndarray) -> None:
        b = self.height(x)
        gaps = missing(b)
        if gaps.any():
            k = int(np.argmax(gaps))
            raise ValueError(f"`bottom` is {b[k]:.10g} at x = {x[k]:.6g} m, which looks like a code for a missing value, not "
                             "like a height: fill the gap")

    def flow(self, x: np.ndarray) -> dict[str, Any]:
        """Return the initial {h, phi, vs, vf} at points x (m,), also where it is given by its surface."""
        return whole_flow(over_ground(self.initial(x), x, self.height, lambda depth: np.maximum(depth, 0.0)))

    def height(self, x: np.ndarray) -> np.ndarray:
        """Return the bottom at points x (m,), m; of cell averages that of the cell."""
        b = self.bottom(x) if callable(self.bottom) else np.asarray(self.bottom, dtype=float)
        if np.ndim(b) and not callable(self.bottom):
            lower, upper = self.interval
            b = b[np.clip((x - lower) / (upper - lower) * b.size, 0, b.size - 1).astype(int)]
        return np.broadcast_to(b, np.shape(x))

    def given_sources(self) -> tuple[Any, ...]:
        """Return the sources, also where there is one or none."""
        return tuple(self.sources) if isinstance(self.sources, (tuple, list)) else (self.sources,)

    def sides(self) -> tuple[Any, Any]:
        """Return the boundary conditions (left, right)."""
        left, right = self.boundary if isinstance(self.boundary, (tuple, list)) else (self.boundary, self.boundary)
        return left, right

    def known_reference(self) -> Reference | None:
        """Return the reference, made now if the scene only knows how to make it; None if there is none."""
        if self.reference is None or isinstance(self.reference, Reference):
            return self.reference
        return self.reference(self)
