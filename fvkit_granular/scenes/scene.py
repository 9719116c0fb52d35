"""`Scene`: the physical set-up of a flow, without numerics, and its reference solution."""

import warnings
from collections.abc import Callable, Mapping
from functools import cached_property, partial
from typing import Any

import attrs
import numpy as np

from fvkit import Grid, Model, Outflow, Problem, validation
from fvkit.problem.cell_averages import check_arguments
from fvkit.problem.grid import NAMES
from fvkit.problem.problem import boundary_pair, source_list
from fvkit.problem.side import four_sides
from fvkit_granular.csv_table import missing
from fvkit_granular.models.quantities import conserved, over_ground, whole_flow
from fvkit_granular.models.shallow_flow import SLOPES, ShallowFlow
from fvkit_granular.models.slope import needs_steep, within_reach
from fvkit_granular.models.two_phase import TwoPhase
from fvkit_granular.scenes.mountain import GAPS, Corners, Ground, ReleasedFlow, check_release, corners, ground, no_flow, outlet
from fvkit_granular.scenes.profile import Profile
from fvkit_granular.scenes.reference import FunctionReference, Reference
from fvkit_granular.scenes.shaped_flow import ShapedFlow
from fvkit_granular.scenes.shapes import Step
from fvkit_granular.scenes.watch import Watch
from fvkit_granular.sources.plausible import caution
from fvkit_granular.terrain.hydrograph import series_of
from fvkit_granular.terrain.terrain import Terrain


def two_states(left: Mapping[str, float], right: Mapping[str, float], at: float = 0.0) -> ShapedFlow:
    """Return the flow of two uniform states with a jump at x = ``at``, m."""
    return ShapedFlow(**{name: Step(at, left[name], right[name]) if left[name] != right[name] else left[name] for name in left})


def ascending(value: Any) -> tuple[float, ...]:
    """Return output times as a tuple, checked."""
    times = validation.series(value, "times", "[0.5, 1.0]")
    if times[0] <= 0.0 or (np.diff(times) <= 0.0).any():
        raise ValueError("`times` must be a list of positive times that ascend, or None for the end alone, got "
                         f"{validation.shown(value)}")
    return tuple(times.tolist())


def _reference(value: Any) -> Any:
    return value if isinstance(value, Reference) else validation.function(value, "reference", "of the scene, or a gr.Reference")


def _interval(value: Any, name: str) -> Any:
    """Return (lower, upper), two numbers, or two corners with two axes, checked."""
    if isinstance(value, Corners):
        return value
    given = value.tolist() if isinstance(value, np.ndarray) else value
    if not isinstance(given, (tuple, list)) or len(given) != 2 or not any(isinstance(end, (tuple, list)) for end in given):
        return validation.interval(value, name)
    if not all(isinstance(end, (tuple, list)) and len(end) == len(NAMES) for end in given):
        raise TypeError(f"`{name}` must be a pair (lower, upper), or corners ((x0, y0), (x1, y1)) for two axes, got "
                        f"{validation.shown(value)}")
    along = zip(NAMES, zip(*given, strict=True), strict=True)
    return tuple(zip(*(validation.interval(ends, f"{name}` along `{axis}") for axis, ends in along), strict=True))


#: Plausible gravity, m/s^2: from that of small bodies to that of a centrifuge.
WEAKEST, STRONGEST = 0.01, 500.0

#: Cells on which the slopes of a scene without a terrain are computed, by the number of axes.
DECIDING = {1: 400, 2: 100}


@attrs.frozen(eq=False)
class Scene:
    """Physical set-up of a flow, for any of the models, along a line or on a plane.

    Parameters
    ----------
    interval : (lower, upper), m; with two axes corners ((x0, y0), (x1, y1)), as `fvkit.Grid` takes them.
    t_end : end time, s, positive.
    initial : x (m,) -> {h, phi, vs, vf}, arrays or numbers; vs and vf are 0 where missing. With two axes a function of x and y,
        each (my, mx) -> {h, phi, vs_x, vs_y, vf_x, vf_y}. ``surface``, the level in m, may
        replace h: h = max(surface - bottom, 0), in partly dry cells over their mean bottom, so that a lake is at rest on every
        grid (its volume changes by O(dx^2), at shores only). Use it rather than max(level - b(x), 0).
    bottom : height b of the bottom, m: function of x, cell averages, or number; with two axes of x and y, or averages (ny, nx).
    boundary : one boundary condition, or (left, right); kept as the pair. With two axes one, (west, east, south, north), or a
        mapping of these names, as `fvkit.Problem` takes them; kept as the four.
    sources : a source or a sequence of them; kept as a tuple. Drag is left out for models with one velocity.
    g : gravity, m/s^2.
    gamma : density ratio fluid/solid in (0, 1).
    reference : `Reference`, or a function of the scene that returns one, called when it is needed; None if there is none.
    name, description : for lists and reports; the description gives the source of the case.
    times : output times of ``fvkit run``, s, ascending; None for the end alone.
    slope : equations of a model that is given as a class: "mild", "steep", or "auto" for the steep ones where the flow may reach
        ground steeper than 10 degrees, and with `Curvature`.
    terrain : `Terrain`, the ground, in place of ``interval`` and ``bottom``; runs use its cells.
    release : `Release` on that terrain, in place of ``initial``.
    phi : solid fraction of a release without one, in [0, 1].
    gaps : cells of the terrain without data: "outlet", through which the flow leaves, or "wall".
    watch : records of ``fvkit run`` at every step, `Watch`.

    Examples
    --------
    >>> import numpy as np
    >>> import fvkit as fv, fvkit_granular as gr
    >>> grid = fv.Grid((0.0, 0.0), (60.0, 20.0), (30, 10))
    >>> terrain = gr.Terrain(grid, 30.0 - 0.5 * np.broadcast_to(grid.axes[0].centers, grid.shape))
    >>> square = {"type": "Polygon", "coordinates": [[[4, 4], [14, 4], [14, 16], [4, 16], [4, 4]]]}
    >>> scene = gr.Scene(terrain=terrain, release=gr.read_release(square, terrain, thickness=1.0), t_end=2.0, phi=0.6,
    ...                  sources=gr.CoulombFriction(0.3))
    >>> solution = fv.solve(scene.problem(gr.Reduced), backend="numpy")
    >>> solution.model.slope, f"{solution.observables()['speed'].max():.0f} m/s"
    ('steep', '12 m/s')
    """

    interval: Any = validation.field(_interval, None, optional=True)
    t_end: Any = validation.field(validation.real, None, optional=True, above=0.0)
    initial: Any = validation.field(validation.function, None, optional=True, hint="x -> {h, phi, vs, vf}, or of x and y",
                                    repr=False)
    bottom: Any = attrs.field(default=0.0, repr=False)
    boundary: Any = attrs.field(factory=Outflow)
    sources: Any = attrs.field(default=(), converter=source_list)
    g: float = validation.number(9.81, above=0.0)
    gamma: float = validation.number(0.5, above=0.0, below=1.0, hint="density of the fluid over density of the solid")
    reference: Reference | Callable[["Scene"], Reference] | None = attrs.field(
        default=None, converter=attrs.converters.optional(_reference), repr=False)
    name: str = validation.words("")
    description: str = validation.words("")
    times: tuple[float, ...] | None = attrs.field(default=None, converter=attrs.converters.optional(ascending))
    slope: str = validation.field(validation.choice, "auto", kw_only=True, known=("auto", *SLOPES))
    terrain: Any = validation.field(validation.instance, None, optional=True, kw_only=True, kind=Terrain,
                                    hint="such as gr.read_terrain(\"dem.asc\")")
    release: Any = attrs.field(default=None, kw_only=True)
    phi: Any = validation.field(validation.real, None, optional=True, kw_only=True, at_least=0.0, at_most=1.0)
    gaps: str = validation.field(validation.choice, GAPS[0], kw_only=True, known=GAPS)
    watch: Watch = validation.field(validation.instance, Watch(), kw_only=True, kind=Watch, hint="gr.Watch(gauges=[...])")

    def __attrs_post_init__(self) -> None:
        if self.terrain is not None:
            self._lie_on_terrain()
        elif self.release is not None or self.phi is not None:
            raise ValueError("`release` and `phi` need a `terrain`: gr.Scene(terrain=gr.read_terrain(...), release=..., "
                             "t_end=...); a profile has interval and initial")
        _interval(self.interval, "interval")
        validation.real(self.t_end, "t_end", above=0.0)
        validation.function(self.initial, "initial", hint="x -> {h, phi, vs, vf}, or of x and y")
        object.__setattr__(self, "boundary", (boundary_pair if len(self.axes) == 1 else four_sides)(self.boundary))
        self._check_watch()
        check_arguments(self.initial, len(self.axes), "initial")
        if callable(self.bottom):
            check_arguments(self.bottom, len(self.axes), "bottom")
        if isinstance(self.reference, FunctionReference):
            self.reference.check_axes(self.axes)
        if isinstance(self.bottom, Profile):
            self.bottom.warn_of_units(self.interval if len(self.axes) == 1 else None)
        caution(self, "g", WEAKEST, STRONGEST, "in m/s^2 it is 9.81, where 981 is in cm/s^2")
        if self.release is not None:
            self.release.warn_of_units()
        for series in filter(None, map(series_of, self.sources)):
            series.warn_of_times(self.t_end)

    def _lie_on_terrain(self) -> None:
        """Take interval, bottom and initial flow from the terrain and the release."""
        where = corners(self.terrain)
        if not isinstance(self.interval, Corners) and self.interval not in (None, where):
            raise ValueError(f"`interval` must be left out with a `terrain`, whose corners are {where}, got {self.interval}: cut "
                             "it with `window` of gr.read_terrain")
        if not isinstance(self.bottom, Ground) and not (np.isscalar(self.bottom) and self.bottom == 0.0):
            raise ValueError("`bottom` must be left out with a `terrain`, which is the ground, got "
                             f"{validation.shown(self.bottom)}: change the heights, gr.Terrain(terrain.grid, heights)")
        if isinstance(self.initial, ReleasedFlow) or self.initial is no_flow:
            object.__setattr__(self, "initial", None)
        if self.release is not None:
            check_release(self.release, self.terrain)
            if self.initial is not None and not getattr(self.initial, "of_release", False):
                raise ValueError("`initial` and `release` exclude each other, got both: leave one out")
        elif self.phi is not None:
            raise ValueError(f"`phi` is the solid fraction of a `release`, got {self.phi:g} without one: `initial` gives its "
                             "own, gr.read_hydrograph has a column")
        elif self.initial is None and not self.sources:
            raise ValueError("a scene on a terrain must have a `release`, an `initial` flow, or `sources` such as gr.Rain")
        if self._bends and self.gaps == "wall" and self.terrain.missing.any():
            raise ValueError("`gaps` must be \"outlet\" with gr.Curvature, got \"wall\", whose cliffs would bend the flow beside "
                             "them: or fill the gaps, terrain.filled()")
        object.__setattr__(self, "interval", where)
        object.__setattr__(self, "bottom", ground(self.terrain, self.gaps))
        if self.initial is None:
            object.__setattr__(self, "initial", no_flow if self.release is None else ReleasedFlow(self.release, self.phi))

    def _check_watch(self) -> None:
        """Refuse what lies outside of the scene, or does not fit its terrain."""
        self.watch.check(self.ends)
        if self.terrain is not None:
            self.watch.check_on(self.terrain)
        elif self.watch.observed is not None:
            raise ValueError("`observed` is the outline of a flow on a terrain, and this scene has none: leave it out")

    @property
    def axes(self) -> tuple[str, ...]:
        """Names of its axes: ("x",), or ("x", "y")."""
        return NAMES[:np.ndim(self.interval)]

    @property
    def ends(self) -> tuple[tuple[float, float], ...]:
        """(lower, upper) of each axis, m."""
        return (self.interval,) if len(self.axes) == 1 else tuple(zip(*self.interval, strict=True))

    def grid(self, cells: Any = None) -> Grid:
        """Return the grid of a number of cells; with two axes of so many along x and nearly square ones, or of (nx, ny).

        None is the grid of the terrain, on which a scene with one runs.
        """
        if cells is None and self.terrain is not None:
            found: Grid = self.terrain.grid
            return found
        if len(self.axes) > 1 and not isinstance(cells, (tuple, list)):
            along = validation.whole(cells, "cells", at_least=1, hint="the number along x, or a pair (nx, ny)")
            (x0, x1), (y0, y1) = self.ends
            cells = along, max(1, round(along * (y1 - y0) / (x1 - x0)))
        elif len(self.axes) == 1 and isinstance(cells, (tuple, list)):
            raise TypeError(f"`num_cells` must be a number for a scene with one axis, got {validation.shown(cells)}")
        lower, upper = self.interval
        return Grid(lower, upper, tuple(cells) if isinstance(cells, list) else cells)

    @cached_property
    def equations(self) -> str:
        """The equations of a model that is given as a class, "mild" or "steep".

        Those of ``slope``; for "auto" the steep ones with a source that needs them, such as `Curvature`, and where the flow may
        reach ground steeper than 10 degrees, on the grid of the terrain, else on 400 cells, or 100 x 100.
        """
        if self.slope != "auto":
            return self.slope
        if self._bends:
            return "steep"
        fixed = np.shape(self.bottom)[::-1] if not callable(self.bottom) else ()
        grid = self.grid(None if self.terrain is not None else (fixed if len(fixed) > 1 else fixed[0]) if fixed else
                         DECIDING[len(self.axes)])
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # the problem of the run gives them
            problem = self._problem(TwoPhase(g=self.g, gamma=self.gamma), grid)
        return "steep" if needs_steep(within_reach(problem, self.g)) else "mild"

    @property
    def _bends(self) -> bool:
        """Whether a source needs the equations for steep ground."""
        return any(source.bends for source in self.sources)

    def model(self, model: Any) -> Model:
        """Return ``model`` if it is an instance; a class gets the scene's g and gamma, and its ``equations``."""
        if isinstance(model, type) and issubclass(model, Model):
            return self._made(model, {"slope": self.equations} if issubclass(model, ShallowFlow) else {})
        return validation.instance(model, "model", Model, "such as gr.TwoPhase, or gr.TwoPhase(g=9.81, gamma=0.5)")

    def _made(self, kind: type[Model], more: Mapping[str, Any]) -> Model:
        return kind(**{name: getattr(self, name) for name in kind.parameter_names() if name in ("g", "gamma")}, **more)

    def problem(self, model: Any, cells: Any = None) -> Problem:
        """Return the problem for ``model`` (instance, or class, see `model`) on ``cells`` cells, see `grid`.

        Warns (`SteepSlopeWarning`) where the flow may reach ground above 15 degrees with the equations for mild slopes, see
        `fvkit_granular.models.slope`.
        """
        grid = self.grid(cells)
        chosen = self._chosen(model, grid)
        if not callable(getattr(chosen, "conserved_from", None)):
            raise ValueError(f"`model` of a scene must make its state of h, phi, vs and vf, but {type(chosen).__name__} has no "
                             "`conserved_from`: take a model of fvkit_granular, or build a fvkit.Problem")
        if "b" not in chosen.aux and (callable(self.bottom) or np.any(np.asarray(self.bottom) != 0.0)):
            raise ValueError(f"`bottom` of the scene is not flat, but {type(chosen).__name__} has no `b` in its `aux`: take "
                             "another model, or bottom=0.0")
        if self.terrain is not None and grid != self.terrain.grid:
            raise ValueError(f"`cells` must be those of the terrain, {self.terrain.grid.described}, got {grid.described}: read "
                             "it with larger cells, `cell = 20.0` of [terrain] or gr.read_terrain(path, cell=20.0)")
        result = self._problem(chosen, grid)
        self._refuse_gaps(grid)
        return result

    def _chosen(self, model: Any, grid: Grid) -> Model:
        """Return `model`; a mistake of the scene is located on the cells of ``grid``, not on those that decide the equations."""
        try:
            return self.model(model)
        except (ValueError, TypeError):
            if isinstance(model, type) and issubclass(model, Model) and not self._bends:
                self._problem(self._made(model, {}), grid)
            raise

    @cached_property
    def _outlet(self) -> tuple[Any, ...]:
        """The drain of cells without data, made once: it holds a number for each cell."""
        return outlet(self.terrain, self.gaps)

    def _problem(self, model: Any, grid: Grid) -> Problem:
        """Return the problem of a model on a grid."""
        sources = tuple(source for source in self.sources if len(model.phases) > 1 or not source.between_phases)
        if self.terrain is not None:
            sources += self._outlet
        flow: Any = conserved(model, self.initial, self.height)
        if isinstance(self.initial, ReleasedFlow) and grid == self.release.terrain.grid:
            flow = flow(*np.meshgrid(*(axis.centers for axis in grid.axes)))  # the same in all of a cell
        return Problem(model, grid, flow, self.t_end,
                       aux={"b": self.bottom} if "b" in model.aux else {}, boundary=self.boundary, sources=sources)

    def _refuse_gaps(self, grid: Grid) -> None:
        b = self.height(*np.meshgrid(*(axis.centers for axis in grid.axes)))
        gaps = missing(b)
        if gaps.any():
            k = int(np.argmax(gaps))
            where = ", ".join(f"{name} = {place:.6g}" for name, place in zip(self.axes, grid.place(k), strict=True))
            raise ValueError(f"`bottom` is {b.flat[k]:.10g} at {where} m, which looks like a code for a missing value, not "
                             "like a height: fill the gap")

    def sampled(self, count: int) -> tuple[np.ndarray, ...]:
        """Return about ``count`` points of the scene, including its ends: x, or x and y."""
        each = count if len(self.axes) == 1 else round(count**0.5)
        return tuple(np.meshgrid(*(np.linspace(*ends, each) for ends in self.ends)))

    def flow(self, *places: np.ndarray) -> dict[str, Any]:
        """Return the initial {h, phi, vs, vf}, with two axes {h, phi, vs_x, vs_y, vf_x, vf_y}, at points x, or x and y, m, also
        where it is given by its surface."""
        return whole_flow(over_ground(self.initial(*places), places, self.height, partial(np.maximum, 0.0)), len(places))

    def height(self, *places: np.ndarray) -> np.ndarray:
        """Return the bottom at points x, or x and y, m; of cell averages that of the cell."""
        b = self.bottom(*places) if callable(self.bottom) else np.asarray(self.bottom, dtype=float)
        if np.ndim(b) and not callable(self.bottom):
            if np.ndim(b) != len(self.axes):
                raise ValueError(f"`bottom` must be cell averages {'(ny, nx)' if len(self.axes) > 1 else '(num_cells,)'}, got an "
                                 f"array of shape {np.shape(b)}")
            b = b[self.grid(b.shape[0] if b.ndim == 1 else b.shape[::-1]).index(*places)]
        return np.broadcast_to(b, np.shape(places[0]))

    def known_reference(self) -> Reference | None:
        """Return the reference, computed now if the scene has a function for it; None if there is none."""
        if self.reference is None or isinstance(self.reference, Reference):
            return self.reference
        return self.reference(self)
