"""Numbers of sources that vary over the grid: cell averages, a function of x, or a function of x and t.

Their cell averages are rows behind the aux values of a run. A source sees its field as one number per cell, at a face the
mean of both sides; the model sees its own aux values alone.
"""

import inspect
from collections.abc import Callable, Sequence
from typing import Any

import attrs
import numpy as np

from fvkit import validation
from fvkit.pointwise.part import Wrapper, seen_as
from fvkit.problem.cell_averages import cell_averages
from fvkit.problem.grid import Grid
from fvkit.problem.questions import aux_places


def number(default: Any = attrs.NOTHING, *, alias: str | None = None, hint: str = "", **bounds: float) -> Any:
    """Declare a numeric field of a source that may vary over the grid, validated against the bounds of `fvkit.validation.real`.

    It takes a number, cell averages (num_cells,), a function of x, or a function of (x, t); on a grid with two axes averages
    (ny, nx), or a function of (x, y) or (x, y, t). Of a function of time with a method ``averages(t)`` that is used instead.
    What a function returns is validated when a `fvkit.Problem` averages it.
    """
    def convert(value: Any, field: Any) -> Any:
        if callable(value) and not isinstance(value, type):
            return value
        if validation.is_single(value):
            return validation.real(value, field.alias, hint=hint or "or cell averages, a function of x, or of (x, t)", **bounds)
        averages = validation.array(value if _is_map(value) else validation.series(value, field.alias, "[0.4, 0.5]"), field.alias)
        for cell in (int(np.argmin(averages)), int(np.argmax(averages))):
            validation.real(averages.flat[cell], f"{field.alias}[{cell}]", hint=hint, **bounds)
        return tuple(map(tuple, averages.tolist())) if averages.ndim == 2 else tuple(averages.tolist())

    return attrs.field(default=default, alias=alias, converter=attrs.Converter(convert, takes_field=True), repr=validation.shown)


def _is_map(value: Any) -> bool:
    """Whether a value is rows of cells: an array or nested lists, not empty."""
    if hasattr(value, "ndim"):
        return bool(value.ndim == 2 and value.size)
    return isinstance(value, (list, tuple)) and len(value) > 0 and all(isinstance(row, (list, tuple)) and row for row in value)


def is_number(value: Any) -> bool:
    """Whether the value of a numeric field is one number, or left open (None)."""
    return value is None or isinstance(value, (float, int, np.number))


def cells_with(value: Any) -> np.ndarray | None:
    """Return the numbers of the cells where a field is not 0: of cell averages, or ``value.cells``; None for another kind."""
    if callable(value) or is_number(value):
        return getattr(value, "cells", None)
    return np.flatnonzero(np.asarray(value))


def takes_time(function: Callable[..., Any], axes: int = 1) -> bool:
    """Whether a function takes t after its places: one more argument without a default."""
    try:
        given = inspect.signature(function).parameters.values()
    except (TypeError, ValueError):  # a ufunc of NumPy, say
        return False
    asked = sum(one.default is one.empty and one.kind in (one.POSITIONAL_ONLY, one.POSITIONAL_OR_KEYWORD) for one in given)
    return asked == axes + 1


@attrs.frozen(eq=False)
class Field:
    """A field ``name`` of a source that varies over the grid; ``position`` is that of the source among those of the problem.

    It has as many rows as ``components``, None for one number per cell.
    """

    source: Any
    position: int
    name: str
    components: int | None
    grid: Grid
    _kept: Any = attrs.field(init=False, default=None, repr=False)

    @property
    def given(self) -> Any:
        """What the user gave."""
        return getattr(self.source, self.name)

    @property
    def alias(self) -> str:
        """What the user calls it."""
        kind: Any = type(self.source)
        return next(field.alias for field in attrs.fields(kind) if field.name == self.name)

    @property
    def steady(self) -> bool:
        """Whether it is the same at all times."""
        return not (callable(self.given) and takes_time(self.given, len(self.grid.axes)))

    @property
    def size(self) -> int:
        """The number of its rows."""
        return self.components or 1

    def breaks(self) -> tuple[float, ...]:
        """Times, s, at which it has a kink or a jump, as ``breaks`` of what was given says: steps end there."""
        return tuple(self.given.breaks()) if hasattr(self.given, "breaks") else ()

    def at(self, t: float) -> np.ndarray:
        """Return its cell averages at time t, (size, num_cells); ValueError, with cell and x, for one that the source refuses."""
        if self._kept is not None:
            return np.asarray(self._kept)
        label, given, cells = f"{self.alias} of {type(self.source).__name__}", self.given, self.grid.shape
        shape = cells if self.components is None else (self.components, *cells)
        if hasattr(given, "averages"):
            given = given.averages(t)
        elif callable(given):
            self._check_places(given)
            function = given if self.steady else lambda *places: self.given(*places, t)
            given = cell_averages(function, self.grid, self.components, label)
        values = validation.array(given, label, shape).reshape(self.size, *cells)
        if self.components is None:
            self._check(values[0])
        if self.steady:
            object.__setattr__(self, "_kept", values)
        return values

    def _check_places(self, given: Callable[..., Any]) -> None:
        """Refuse a function of x and t on a grid with two axes, which would be taken for one of x and y."""
        names = list(getattr(getattr(given, "__code__", None), "co_varnames", ()))[:2]
        if len(self.grid.axes) > 1 and self.steady and names[1:] == ["t"]:
            raise ValueError(f"`{self.alias}` of {type(self.source).__name__} must be a function of (x, y), or of (x, y, t), on "
                             "a grid with two axes, got one of (x, t)")

    def _check(self, values: np.ndarray) -> None:
        """Let the source itself judge the least and the largest value."""
        for cell in (int(np.argmin(values)), int(np.argmax(values))):
            try:
                attrs.evolve(self.source, **{self.alias: float(values.flat[cell])})
            except (TypeError, ValueError) as error:
                raise ValueError(f"{error}; it is that of {type(self.source).__name__} in cell {cell} at "
                                 f"{self.grid.located(cell)}") from None


def varying_over(grid: Grid, sources: Sequence[Any], components: int, t: float) -> tuple[Field, ...]:
    """Return the fields of sources that vary over a grid, validated at time t; ``components`` are those of the state."""
    found = tuple(Field(source, position, name, components if every else None, grid)
                  for position, source in enumerate(sources) for name, every in source.varying())
    for field in found:
        field.at(t)
    return found


def averages(found: Sequence[Any], t: float) -> np.ndarray:
    """Return the rows of all fields at time t, (rows, num_cells)."""
    return np.concatenate([field.at(t) for field in found])


def with_numbers(source: Any, found: Sequence[Any], t: float) -> Any:
    """Return a source with the numbers of its fields in the first cell: what its pointwise methods can be rehearsed on."""
    own = [field for field in found if field.source is source]
    first = {field.name: _values(field.at(t).reshape(field.size, -1)[:, 0].tolist(), field.components) for field in own}
    return seen_as(source, first)


def on_grid(sources: Sequence[Any], found: Sequence[Any], own: int) -> tuple[Any, ...]:
    """Return sources that look for their fields behind the ``own`` aux values of the model, and else see these alone."""
    places: dict[int, list[tuple[str, int, int | None]]] = {k: [] for k in range(len(sources))}
    row = own
    for field in found:
        if field.source is not None:  # those of the model look for themselves
            places[field.position].append((field.name, row, field.components))
        row += field.size
    return tuple(OnGrid(source, tuple(places[k]), own) for k, source in enumerate(sources))


def _values(rows: Any, components: int | None) -> Any:
    return rows[0] if components is None else tuple(rows)


@attrs.frozen(repr=False)
class OnGrid(Wrapper):
    """A source that finds its fields behind the ``own`` aux values of the model.

    ``places`` holds the name of each, its first row, and its number of rows, None for one number.
    """

    places: tuple[tuple[str, int, int | None], ...]
    own: int

    def __getattr__(self, name: str) -> Any:
        method = Wrapper.__getattr__(self, name)
        at = aux_places(self.part.questions).get(name) if callable(method) else None
        if at is None:
            return method

        def answer(*arguments: Any) -> Any:
            aux = arguments[at[0]]
            values = {field: _values(aux[row:row + (count or 1)], count) for field, row, count in self.places}
            given = [item[:self.own] if k == at[0] else item for k, item in enumerate(arguments)]
            return getattr(seen_as(self.part, values), name)(*given)

        return answer
