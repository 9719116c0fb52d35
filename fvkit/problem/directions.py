"""Directions of a grid: what a model sees of the state in a sweep along one axis, and what only rides along.

Along an axis every model sees its own one-dimensional system. On a grid with two axes the state has a row more for each momentum:
(masses, momentum x, momentum y) of every phase. In a sweep along x the momentum along y is a passenger of its phase's own mass
flux, in a sweep along y that along x: a permutation of rows, not of data.
"""

from collections.abc import Mapping
from typing import Any, NamedTuple

import numpy as np

from fvkit.problem.grid import NAMES, Grid
from fvkit.problem.model import Model

#: Names of both sides of each axis.
SIDES = (("west", "east"), ("south", "north"))


class Direction(NamedTuple):
    """What a sweep along one axis sees.

    Attributes
    ----------
    number : of the axis, 0 for x.
    model : the equations along that axis, see `fvkit.Model.along`.
    rows : rows of the state that the model sees, in its own order.
    across : rows of the momenta across, one for each phase; () where the model has none.
    still : rows of components across that a sweep leaves as they are.
    names : of all rows of the state.
    """

    number: int
    model: Model
    rows: tuple[int, ...]
    across: tuple[int, ...] = ()
    still: tuple[int, ...] = ()
    names: tuple[str, ...] = ()


def directions(model: Model, grid: Grid) -> tuple[Direction, ...]:
    """Return the direction of every axis of a grid; ValueError, with the reason, for a model that serves one axis alone."""
    if len(grid.axes) == 1:
        return (Direction(0, model, tuple(range(len(model.conserved))), names=model.conserved),)
    if model.dimensions < len(grid.axes):
        raise ValueError(f"{type(model).__name__} serves one axis alone, got a grid with {len(grid.axes)}: "
                         "take a model such as gr.TwoPhase, or fv.Grid(lower, upper, num_cells)")
    if not _says_what_turns(model):
        raise ValueError(f"{type(model).__name__} has {len(model.conserved)} components and does not say which are those of a "
                         "vector: set `vectors`, such as ((1, 2),) with rows for both momenta, or () for none, or "
                         "define `along(axis)`")
    split, places = _split(model), plane_places(model)
    result = []
    for number in range(len(grid.axes)):
        rows = [place + number * (k in split) for k, place in enumerate(places)]
        for vector in model.vectors:
            if len(vector) == 2 and number == 1:
                rows[vector[0]], rows[vector[1]] = rows[vector[1]], rows[vector[0]]
        others = {k: places[k] + 1 - number for k in split}
        across = tuple(others[phase.momentum] for phase in model.phases)
        result.append(Direction(number, model.along(number), tuple(rows), across,
                                () if model.phases else tuple(others.values()), component_names(model, grid)))
    return tuple(result)


def component_names(model: Model, grid: Grid) -> tuple[str, ...]:
    """Return the names of the rows of the state on a grid: with two axes "h v_x" and "h v_y" for the momentum "h v"."""
    if len(grid.axes) == 1:
        return model.conserved
    split = _split(model)
    return tuple(name for k, own in enumerate(model.conserved)
                 for name in ([f"{own}_{axis}" for axis in NAMES] if k in split else [own]))


def _says_what_turns(model: Model) -> bool:
    """Whether a model of several components says which of them turn with the axis: else a sweep along y would push along x."""
    own = [kind for kind in type(model).__mro__ if kind is not Model and issubclass(kind, Model)]
    return len(model.conserved) == 1 or bool(model.phases) or any({"vectors", "along"} & set(vars(kind)) for kind in own)


def _split(model: Model) -> set[int]:
    """Rows of a model that are one component of a vector, which has two rows in two dimensions."""
    return {phase.momentum for phase in model.phases} | {vector[0] for vector in model.vectors if len(vector) == 1}


def plane_places(model: Model) -> list[int]:
    """Return the row of the state with two axes for each row of a model: of a momentum that along x, that along y is the next."""
    split, places = _split(model), []
    for k in range(len(model.conserved)):
        places.append(k + sum(row < k for row in split))
    return places


def mass_places(model: Model, grid: Grid) -> tuple[int, ...]:
    """Rows of the state on a grid that are masses."""
    return model.mass_rows() if len(grid.axes) == 1 else tuple(plane_places(model)[row] for row in model.mass_rows())


def observables(model: Model, grid: Grid, q: np.ndarray, aux: Any = None) -> dict[str, np.ndarray]:
    """Return the observables of a state on a grid, {name: array of cells}.

    With two axes a vector v has v_x, v_y and its size, "speed" (of vs "speed_s"); scalars are those of the model.
    """
    if len(grid.axes) == 1:
        return model.observables(q, aux)
    first, second = (_seen(one, q, aux) for one in directions(model, grid))
    turning, result = vectors(model), {}
    for name, values in first.items():
        if name not in turning:
            result[name] = values
            continue
        result |= {f"{name}_{axis}": item for axis, item in zip(NAMES, (values, second[name]), strict=True)}
        result[speed_name(name)] = np.hypot(values, second[name])
    return result


def _seen(direction: Direction, q: np.ndarray, aux: Any) -> dict[str, np.ndarray]:
    """Return the observables of a sweep along one axis; those that are rows of the state are views of ``q``, as on one axis."""
    own = q[list(direction.rows)]
    rows = list(zip(direction.rows, own, strict=True))
    return {name: next((q[row] for row, copied in rows if np.shares_memory(values, copied)), values)
            for name, values in direction.model.observables(own, aux).items()}


def quantities(model: Model, grid: Grid) -> Mapping[str, tuple[str, str]]:
    """Return unit and meaning of components, aux functions and observables on a grid, {name: (unit, meaning)}."""
    if len(grid.axes) == 1:
        return model.quantities
    seen, result = vectors(model), dict(model.quantities)
    for name in (*seen, *(model.conserved[row] for row in _split(model))):
        unit, meaning = model.quantities.get(name, ("", name))
        result |= {f"{name}_{axis}": (unit, f"{meaning} along {axis}") for axis in NAMES}
        if name in seen:
            result[speed_name(name)] = unit, f"size of the {meaning}"
    return result


def speed_name(name: str) -> str:
    """Return what the size of a vector is called: "speed" of v, "speed_s" of vs."""
    return "speed" + (f"_{name[1:]}" if len(name) > 1 else "")


def vectors(model: Model) -> tuple[str, ...]:
    """Return the observables that are components of vectors: those that turn round with the momenta."""
    q, split = np.full((len(model.conserved), 1), 1.5), sorted(_split(model))
    aux = {name: np.zeros(1) for name in model.aux}
    turned = q.copy()
    turned[split] *= -1.0
    ahead, back = model.observables(q, aux), model.observables(turned, aux)
    return tuple(name for name in ahead if not np.array_equal(ahead[name], back[name]))


def in_plane(model: Model, along_x: Any, along_y: Any) -> np.ndarray:
    """Return the state on a grid with two axes from those that the model has along each: masses, momenta along x, those along
    y.

    >>> import fvkit_granular as gr
    >>> water = gr.ShallowWater()
    >>> in_plane(water, water.conserved_from(2.0, vs=1.0, vf=1.0), water.conserved_from(2.0, vs=3.0, vf=3.0)).tolist()
    [2.0, 2.0, 6.0]
    """
    first, second, split = np.asarray(along_x, dtype=float), np.asarray(along_y, dtype=float), _split(model)
    return np.stack([row for k, own in enumerate(first) for row in ([own, second[k]] if k in split else [own])])
