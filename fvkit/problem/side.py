"""Sides of a grid with two axes: a boundary condition for every cell along them."""

import warnings
from collections.abc import Mapping
from itertools import pairwise
from typing import Any

import attrs
import numpy as np

from fvkit import validation
from fvkit.pointwise.part import Part
from fvkit.problem.boundary import BoundaryCondition, Wall
from fvkit.problem.directions import SIDES, Direction
from fvkit.problem.grid import Axis, Grid, Side
from fvkit.problem.open_ends import Outflow

#: Other names of sides, and what they are called here.
LIKE = {"left": "west", "right": "east", "bottom": "south", "top": "north"}


def _condition(value: Any, name: str) -> Any:
    if value is None or isinstance(value, Along):
        return value or Wall()
    return validation.instance(value, name, BoundaryCondition, "such as fv.Wall()")


@attrs.frozen
class Along(Part):
    """Boundary condition on a part of a side of a grid with two axes, such as an inflow through a gap.

    Parameters
    ----------
    lower, upper : range along the side, m; cells with centres in it have ``condition``.
    condition : boundary condition there.
    otherwise : that of the other cells of the side, a condition or another `Along`; None for a `Wall`.

    Examples
    --------
    >>> import fvkit as fv
    >>> gate = fv.Along(4.0, 6.0, fv.Outflow())
    >>> gate.at(5.0), gate.at(1.0)
    (Outflow(slope=None), Wall())
    """

    # Annotated Any, not float: only plain Python reads them.
    lower: Any = validation.number()
    upper: Any = validation.number()
    condition: Any = validation.field(_condition)
    otherwise: Any = validation.field(_condition, None)

    def __attrs_post_init__(self) -> None:
        if not self.lower < self.upper:
            raise ValueError(f"`lower` of Along must be < `upper`, got {self.lower:g} and {self.upper:g}: exchange them?")
        if any(getattr(one, "reads", "") == "opposite" for one in (self.condition, self.otherwise)):
            raise ValueError("Periodic closes a whole axis: give it for both sides, not for a part of one")

    def at(self, place: float) -> BoundaryCondition:
        """Return the condition of a cell whose centre lies at ``place``, m, along the side."""
        chosen: Any = self.condition if self.lower <= place <= self.upper else self.otherwise
        return chosen.at(place) if isinstance(chosen, Along) else chosen


@attrs.frozen(eq=False)
class Section:
    """Neighbouring cells of a side, its ``lanes``, that share a condition, as it is placed at each of its ``ends``."""

    lanes: slice
    ends: tuple[BoundaryCondition, ...]

    @property
    def first(self) -> BoundaryCondition:
        """The condition at the first of the cells."""
        return self.ends[0]

    @property
    def steady(self) -> bool:
        """Whether `values` are the same at all times."""
        return all(end.steady for end in self.ends)

    def values(self, model: Any, t: float) -> tuple[np.ndarray, ...]:
        """Return what the conditions give to ``ghost`` at time t: one array of cells per value."""
        return tuple(np.array(column) for column in zip(*(end.values(model, t) for end in self.ends), strict=True))


def four_sides(boundary: Any) -> tuple[Any, ...]:
    """Return the conditions (west, east, south, north) of one, four, or a mapping of sides, checked."""
    names = [name for pair in SIDES for name in pair]
    if isinstance(boundary, Mapping):
        for name in boundary:
            if name in LIKE:
                raise ValueError(f"`boundary` must be one of {', '.join(names)} on a grid with two axes, got {name!r}: "
                                 f"write {LIKE[name]!r}")
            validation.choice(name, "boundary", names)
        boundary = tuple(boundary.get(name, Outflow()) for name in names)
    given: Any = boundary if isinstance(boundary, (tuple, list)) else (boundary,) * len(names)
    if len(given) != len(names):
        raise ValueError(f"`boundary` must be one condition, four ({', '.join(names)}), or a mapping of these names for a grid "
                         f"with two axes, got {len(given)}")
    for name, side in zip(names, given, strict=True):
        if not isinstance(side, Along):
            validation.instance(side, f"boundary[{name!r}]", BoundaryCondition, "such as fv.Wall(), or fv.Along(..)")
    for pair, low, high in zip(SIDES, given[::2], given[1::2], strict=True):
        if "opposite" in (getattr(low, "reads", ""), getattr(high, "reads", "")) and low != high:
            raise ValueError(f"`boundary`: a periodic boundary is the same on both sides, {pair[0]} and {pair[1]}, got {low} and "
                             f"{high}")
    return tuple(given)


def sections(given: Any, side: Side, direction: Direction, grid: Grid, aux: Mapping[str, np.ndarray]) -> tuple[Section, ...]:
    """Return the sections of one side: the condition of every cell along it, placed on the ground there."""
    along, other = grid.axes[direction.number], grid.axes[1 - direction.number]
    _check_met(given, other, SIDES[side.axis][int(side.upper)])
    chosen = [given.at(place) if isinstance(given, Along) else given for place in other.centers.tolist()]
    rows = {name: np.moveaxis(values, 1 - direction.number, 0) for name, values in aux.items()}
    found: list[Section] = []
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        ends = [_placed(one, side, direction, along, {name: values[:, lane] for name, values in rows.items()})
                for lane, one in enumerate(chosen)]
    for said in caught[:1]:
        warnings.warn(f"{said.message} (first of {len(caught)} cells of a side)", said.category, stacklevel=2)
    cuts = [0, *(k for k in range(1, len(chosen)) if chosen[k] is not chosen[k - 1]), len(chosen)]
    for start, stop in pairwise(cuts):
        found.append(Section(slice(start, stop), tuple(ends[start:stop])))
    return tuple(found)


def _check_met(given: Any, axis: Axis, side: str) -> None:
    """Refuse an `Along` that covers no cell of its side."""
    while isinstance(given, Along):
        if not ((axis.centers >= given.lower) & (axis.centers <= given.upper)).any():
            raise ValueError(f"`boundary[{side!r}]`: Along({given.lower:g}, {given.upper:g}) must cover the centre of a cell, "
                             f"got none on the side from {axis.lower:g} to {axis.upper:g} m with cells of {axis.dx:.4g} m")
        given = given.otherwise


def _placed(end: BoundaryCondition, side: Side, direction: Direction, axis: Axis, aux: Mapping[str, np.ndarray]) -> Any:
    placed = validation.instance(end.placed(side, direction.model, axis, aux), "placed()", BoundaryCondition)
    return placed.turned(direction)
