"""`Problem`: model, grid, initial state, boundaries, sources and times, without numerics."""

from collections.abc import Callable, Mapping
from typing import Any

import attrs
import numpy as np

from fvkit import validation
from fvkit.pointwise import contract
from fvkit.problem import answers, questions
from fvkit.problem.boundary import BoundaryCondition
from fvkit.problem.cell_averages import cell_averages
from fvkit.problem.directions import Direction, component_names, directions, mass_places
from fvkit.problem.fields import Field, varying_over, with_numbers
from fvkit.problem.grid import Grid, Side
from fvkit.problem.model import Model, aux_rows
from fvkit.problem.open_ends import Outflow
from fvkit.problem.relief import Slopes
from fvkit.problem.side import Along, Section, four_sides, sections
from fvkit.problem.sources import Source

#: Floats per cell and component that a problem takes at least: nodes of a quadrature, values there, and averages.
FLOATS = 12


#: Sides of a grid.
SIDES = ("left", "right")


def boundary_pair(boundary: Any) -> tuple[BoundaryCondition, BoundaryCondition]:
    """Return the conditions (left, right) of one, two, or a mapping of sides, checked."""
    if isinstance(boundary, Along):
        raise TypeError("`boundary` must be a condition such as fv.Outflow() for each end, got Along, which is a part of a side "
                        "and needs a grid with two axes")
    if isinstance(boundary, Mapping):
        for name in boundary:
            validation.choice(name, "boundary", SIDES)
        boundary = tuple(boundary.get(name, Outflow()) for name in SIDES)
    sides = boundary if isinstance(boundary, (tuple, list)) else (boundary, boundary)
    if len(sides) != 2:
        raise ValueError(f"`boundary` must be one condition or a pair (left, right), got {len(sides)}")
    left, right = (validation.instance(side, "boundary", BoundaryCondition, "such as fv.Outflow()") for side in sides)
    if (left.reads == "opposite") != (right.reads == "opposite"):
        raise ValueError(f"`boundary`: a periodic boundary needs both sides, got {type(left).__name__} and "
                         f"{type(right).__name__}")
    if left.reads == "opposite" and left != right:
        raise ValueError(f"`boundary`: a periodic boundary is the same on both sides, got {left} and {right}")
    return left, right


def source_list(sources: Any) -> tuple[Source, ...]:
    """Return the sources of one or several, checked."""
    given = tuple(sources) if isinstance(sources, (tuple, list)) else (sources,)
    return tuple(validation.instance(source, "sources", Source, "such as gr.ConstantDrag(D=1.0)") for source in given)


@attrs.frozen(eq=False)
class Problem:
    """Initial-boundary-value problem: a model on a grid with initial state, bottom, boundaries, sources and times.

    Building a problem checks it: the pointwise contract of model, boundaries and sources, shapes, finite values and
    non-negative masses.

    Parameters
    ----------
    model : the equations.
    grid : the cells.
    initial : function x (m,) -> (num_eqn, m) of conserved values, averaged over cells by quadrature; or an array
        (num_eqn, num_cells) of cell averages. On a grid with two axes a function of x and y, each (my, mx) -> (num_eqn, my, mx),
        or an array (num_eqn, ny, nx), with a row for the momentum along each axis: (masses, momentum x, momentum y) per phase.
    t_end : end time, s, after ``t_start``.
    aux : {name: function of x, (num_cells,) cell averages, or number}; names of ``model.aux``, 0 where missing.
    boundary : one condition, (left, right), or {"left": condition, "right": condition}, where a missing side is `Outflow`. With
        two axes the sides are (west, east, south, north), and each may be an `Along`.
    sources : a `Source` or a sequence of them.
    t_start : start time, s.
    background : a steady flow that schemes preserve to rounding, so that small waves on it are resolved: function of x as
        ``initial``, or (num_eqn, num_cells) cell averages; None for none. Rest needs none. One axis only.

    Attributes
    ----------
    q0 : numpy.ndarray
        (num_eqn, *grid.shape) initial cell averages.
    aux_averages : dict
        {name: grid.shape} cell averages of the aux functions.
    conserved : tuple
        Names of the rows of q.
    directions : tuple
        The equations of sweeps along each axis, `fvkit.problem.directions.Direction`.
    background_averages : numpy.ndarray or None
        (num_eqn, num_cells) cell averages of the background.
    ends : tuple
        (left, right), the boundary conditions bound to the ends of this grid; () with two axes.
    sides : tuple
        With two axes, for each the sections of its lower and upper side, `fvkit.problem.side.Section`; else ().
    fields : tuple
        The `fvkit.problem.fields.Field` of the sources that vary over the grid; first of all the slopes of a bottom with relief.

    Raises
    ------
    ValueError, TypeError
        With the argument, what was given and what is allowed.
    fvkit.pointwise.contract.PointwiseError
        If a method breaks the pointwise contract.

    Examples
    --------
    >>> import fvkit as fv
    >>> import numpy as np
    >>> wave = lambda x: [np.sin(2.0 * np.pi * x)]
    >>> problem = fv.Problem(fv.Burgers(), fv.Grid(0.0, 1.0, 4), wave, t_end=0.5, boundary=fv.Periodic())
    >>> problem.conserved, problem.q0.round(3).tolist()
    (('u',), [[0.637, 0.637, -0.637, -0.637]])
    """

    model: Model = attrs.field()
    grid: Grid = attrs.field()
    initial: Callable[[np.ndarray], Any] | Any = attrs.field(repr=False)
    t_end: float = validation.number()
    aux: Mapping[str, Any] = attrs.field(factory=dict, repr=False)
    boundary: Any = attrs.field(factory=Outflow)
    sources: Any = attrs.field(default=(), converter=source_list)
    t_start: float = validation.number(0.0)
    background: Callable[[np.ndarray], Any] | Any = attrs.field(default=None, repr=False)
    q0: np.ndarray = attrs.field(init=False, repr=False)
    aux_averages: dict[str, np.ndarray] = attrs.field(init=False, repr=False)
    background_averages: np.ndarray | None = attrs.field(init=False, repr=False)
    conserved: tuple[str, ...] = attrs.field(init=False, repr=False)
    directions: tuple[Direction, ...] = attrs.field(init=False, repr=False)
    ends: tuple[BoundaryCondition, ...] = attrs.field(init=False, repr=False)
    sides: tuple[tuple[tuple[Section, ...], tuple[Section, ...]], ...] = attrs.field(init=False, repr=False)
    fields: tuple[Field | Slopes, ...] = attrs.field(init=False, repr=False)

    def __attrs_post_init__(self) -> None:
        validation.instance(self.model, "model", Model)
        validation.instance(self.grid, "grid", Grid)
        if not self.t_end > self.t_start:
            raise ValueError(f"`t_end` must be > `t_start`, got {self.t_end!r} and {self.t_start!r}")
        if not self.model.conserved:
            raise ValueError(f"`conserved` of {type(self.model).__name__} must name the components of q")
        one = len(self.grid.axes) == 1
        self._set("boundary", boundary_pair(self.boundary) if one else four_sides(self.boundary))
        self._set("conserved", component_names(self.model, self.grid))
        validation.fits_memory(self.grid.size, FLOATS * (len(self.conserved) + len(self.model.aux)), "num_cells")
        self._set("directions", directions(self.model, self.grid))
        self._set("aux_averages", self._average_aux())
        self._set("q0", self._average(self.initial, "initial"))
        if self.background is not None and not one:
            raise ValueError("`background` serves a grid with one axis, got one with two: leave it out, rest needs none")
        self._set("background_averages", None if self.background is None else self._average(self.background, "background"))
        seen = self.q0 if one else self.q0[list(self.directions[0].rows)]
        self._set("model", validation.instance(self.model.resolved(seen), "model.resolved()", Model))
        self._set("directions", directions(self.model, self.grid))
        lower_upper = (False, True)
        self._set("ends", tuple(self._bound(end, Side(0, upper)) for end, upper in zip(self.boundary, lower_upper, strict=True))
                  if one else ())
        self._set("sides", () if one else tuple(tuple(
            sections(self.boundary[2 * along.number + upper], Side(along.number, upper), along, self.grid, self.aux_averages)
            for upper in lower_upper) for along in self.directions))
        ground = self.model.relief()
        bends = any(source.bends for source in self.sources)
        slopes = () if ground is None else (Slopes(self.aux_averages[ground], self.grid, bends),)
        self._set("fields", slopes + varying_over(self.grid, self.sources, len(self.conserved), self.t_start))
        self._check_contract()
        self.model.check_validity(self)

    def _bound(self, end: BoundaryCondition, side: Side) -> BoundaryCondition:
        placed = end.placed(side, self.model, self.grid, self.aux_averages)
        return validation.instance(placed, "placed()", BoundaryCondition)

    def _set(self, name: str, value: Any) -> None:
        object.__setattr__(self, name, value)

    def _average_aux(self) -> dict[str, np.ndarray]:
        validation.mapping(self.aux, "aux", "{'b': function}")
        for name in self.aux:
            if not self.model.aux:
                raise ValueError(f"`aux` must be empty, got {validation.shown(name)}: {type(self.model).__name__} has no `aux`")
            validation.choice(name, "aux", self.model.aux)
        shape = self.grid.shape
        result = {}
        for name in self.model.aux:
            value = self.aux.get(name, 0.0)
            if callable(value):
                value = cell_averages(value, self.grid, None, f"aux[{name!r}]")
            label = f"aux[{name!r}]"
            if validation.is_single(value):
                value = np.full(shape, validation.real(value, label, hint="a number, cell averages or a function of x"))
            result[name] = validation.array(value, label, shape)
        return result

    def _average(self, state: Any, name: str) -> np.ndarray:
        rows = len(self.conserved)
        given = cell_averages(state, self.grid, rows, name) if callable(state) else state
        q = validation.array(given, name, (rows, *self.grid.shape))
        for row in self.mass_rows:
            if (q[row] < 0.0).any():
                cell = int(np.argmin(q[row]))
                raise ValueError(f"`{name}` must have {self.conserved[row]} >= 0, got {q[row].flat[cell]:g} in cell "
                                 f"{cell} at {self.grid.located(cell)}")
        return q

    @property
    def seen(self) -> np.ndarray:
        """Initial cell averages of the rows of the model along the first axis, (rows, cells)."""
        rows = self.directions[0].rows
        whole = self.q0 if len(self.grid.axes) == 1 else self.q0[list(rows)]
        return whole.reshape(len(rows), -1)

    @property
    def mass_rows(self) -> tuple[int, ...]:
        """Rows of q that are masses."""
        return mass_places(self.model, self.grid)

    @property
    def given(self) -> tuple[np.ndarray, ...]:
        """Given functions of the equations, each of the shape of the grid: aux functions, then slopes of relief."""
        slopes = [row for field in self.fields if isinstance(field, Slopes) for row in field.at(self.t_start)]
        return (*aux_rows(self.model, self.aux_averages), *slopes)

    @property
    def steady_boundary(self) -> bool:
        """Whether the boundary conditions are the same at all times."""
        return all(end.steady for end in self.ends) and all(part.steady for axis in self.sides for side in axis for part in side)

    @property
    def breaks(self) -> list[float]:
        """Times, s, ascending, at which a step must end because of a boundary condition or a field."""
        ends = [*self.ends, *(part.first for axis in self.sides for side in axis for part in side)]
        return sorted({t for part in (*ends, *self.fields) for t in part.breaks()})

    def sample(self) -> tuple[tuple[np.ndarray, ...], tuple[np.ndarray, ...], int]:
        """A few cells of the initial state, spread over the grid, for checks of pointwise methods: q, aux, count."""
        return self._sample(self.directions[0].rows)

    def _sample(self, rows: Any) -> tuple[tuple[np.ndarray, ...], tuple[np.ndarray, ...], int]:
        count = len(self.conserved) + 3
        cells = np.linspace(0, self.grid.size - 1, count).astype(int)
        q = tuple(self.q0[row].reshape(-1)[cells] for row in rows)
        aux = tuple(row.reshape(-1)[cells] for row in aux_rows(self.model, self.aux_averages))
        for values in (*q, *aux):
            values.flags.writeable = False
        return q, aux, count

    def _check_contract(self) -> None:
        for direction in self.directions:
            self._check_model(direction)
        for source in self.sources:
            source.check(self.model)
            q, aux, _ = self.sample() if source.turns else self._sample(range(len(self.conserved)))
            given = questions.samples(self.directions[0].model, q, aux)
            try:
                found = questions.check_answers(with_numbers(source, self.fields, self.t_start), given)
            except IndexError as error:
                if not (self.sides and source.turns):
                    raise
                raise IndexError(f"{error}; on a grid with two axes {type(source).__name__} gets the {len(q)} components along "
                                 f"the velocity: give it `turns = False` for all {len(self.conserved)}") from error
            contract.agree(source, "step", found["step"], q, "must return the state for dt = 0")

    def _check_model(self, direction: Direction) -> None:
        model, (q, aux, _) = direction.model, self._sample(direction.rows)
        given = questions.samples(model, q, aux)
        questions.check_answers(model, given)
        if "flux" in model.takes_aux:
            _check_mass_flux(model, q, aux)
        first = [part.first for side in self.sides[direction.number] for part in side] if self.sides else []
        for side in (*self.ends, *first):
            questions.check_answers(side, {**given, "values": side.values(model, self.t_start)})


def _check_mass_flux(model: Model, q: Any, aux: Any) -> None:
    """Refuse a flux of a mass that depends on aux values: faces compute it from the state alone."""
    with np.errstate(all="ignore"):
        moving = tuple([row + 0.5 for row in q])
        here, elsewhere = (answers.flux(model, moving, tuple([factor * row + factor for row in aux])) for factor in (1.0, 3.0))
        for row in model.mass_rows():
            if not np.array_equal(here[row], elsewhere[row], equal_nan=True):
                raise ValueError(f"`flux` of {type(model).__name__}: the flux of the mass {model.conserved[row]} must depend on "
                                 "q alone, got one that changes with aux: conserve another, or leave `phases` out")
