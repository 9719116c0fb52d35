"""Runs the stages of a plan on whole arrays; what a step asks of the state that it makes."""

from collections.abc import Sequence
from math import isfinite
from typing import Any

import numpy as np

from fvkit.backends.march import MICRO
from fvkit.backends.plan import Plan
from fvkit.pointwise import maximum
from fvkit.problem.answers import at_face
from fvkit.schemes.scheme import Parts

Field = tuple[Any, ...]


class Runner:
    """Runs the stages of a plan over chunks of cells. Entry 0 of a field is at the place ``lows``."""

    def __init__(self, parts: Parts, plan: Plan, lengths: set[int]) -> None:
        self.parts, self.plan = parts, plan
        self.lows = dict.fromkeys(("q", "aux", "across"), -plan.halo)
        self._reads = {n: self._reading(n) for n in lengths}

    def run(self, fields: dict[str, Field], n: int, ratio: float, set_ends: Any = None) -> dict[str, Field]:
        """Add to the fields q and aux of n cells what all stages write; ``set_ends`` changes `MASS_FLUX` once it is complete."""
        for stage, reads in zip(self.plan.stages, self._reads[n], strict=True):
            inputs = {name: cut(fields[field], at) if isinstance(at, slice) else tuple([cut(fields[field], one) for one in at])
                      for name, field, at in reads}
            asks: Any = True if stage.guard is None else stage.guard(self.parts, ratio, **inputs)
            if np.any(asks):
                if stage.sparse:
                    places = np.nonzero(asks)
                    only = stage.run(self.parts, ratio, {name: cut(item, places) for name, item in inputs.items()})
                    fields |= {name: _placed(new, fields[name], places, np.shape(asks)) for name, new in only.items()}
                else:
                    fields |= stage.run(self.parts, ratio, inputs)
            if stage is self.plan.last_mass_flux and set_ends is not None:
                set_ends(fields)
        return fields

    def _reading(self, n: int) -> list[list[tuple[str, str, slice | list[slice]]]]:
        """For each stage, its inputs by name, and the part of each field that it reads in a chunk of n cells."""
        result = []
        for stage, (low, high) in zip(self.plan.stages, self.plan.ranges, strict=True):
            inputs: list[tuple[str, str, slice | list[slice]]] = []
            for name, read in stage.reads.items():
                parts = [self.part(read.field, offset, low, high, n) for offset in read.offsets]
                inputs.append((name, read.field, parts[0] if read.last is None else parts))
            result.append(inputs)
            self.lows |= dict.fromkeys(stage.writes, low)
        return result

    def part(self, field: str, offset: int, low: int, high: int, n: int) -> slice:
        """The part of a field at an offset that a stage covering the places low .. n + high - 1 reads."""
        return slice(low + offset - self.lows[field], n + high + offset - self.lows[field])


def deepness(model: Any, ql: Any, qr: Any) -> Any:
    """Depth of a face that is lost: of its deeper side, in micrometres; None for a model without a depth."""
    return MICRO * maximum(model.depth(ql), model.depth(qr)) if callable(getattr(model, "depth", None)) else None


def lost_faces(model: Any, ql: Any, qr: Any, auxl: Any, auxr: Any) -> tuple[tuple[np.ndarray, ...], np.ndarray | None]:
    """Return the places of the faces whose Roe mean has complex speeds, and their depths, see `deepness`."""
    face, none = (ql, qr, auxl, auxr), (np.empty(0, dtype=int),) * np.ndim(ql[0])
    if not model.defines("hyperbolic_discriminant"):
        return none, None
    if model.defines("may_lose_hyperbolicity") and not at_face(model, "may_lose_hyperbolicity", *face).any():
        return none, None
    places = np.nonzero(at_face(model, "hyperbolic_discriminant", *face) < 0.0)
    depths = deepness(model, ql, qr) if len(places[0]) else None
    return places, None if depths is None else np.broadcast_to(depths, np.shape(ql[0]))[places]


def settle(q: np.ndarray, sees: Sequence[tuple[Any, Sequence[int]]]) -> None:
    """Let what is too thin to move lose its momenta, in a state (rows, ...); ``sees`` are models and the rows that each sees."""
    for model, rows in sees:
        if model.defines("settle"):
            for row, component in zip(rows, model.settle(tuple(q[row] for row in rows)), strict=True):
                q[row] = component


def accepted(q: np.ndarray, masses: Sequence[int], sees: Sequence[tuple[Any, Sequence[int]]]) -> bool:
    """Whether a state (rows, ...) is finite, without negative masses, and admissible; ``sees`` as in `settle`."""
    if not isfinite(np.add.reduce(q, None)) or any(np.minimum.reduce(q[row], None, initial=0.0) < 0.0 for row in masses):
        return False
    return all(bool(np.all(model.admissible(tuple(q[row] for row in rows))))
               for model, rows in sees if model.defines("admissible"))


def cut(value: Any, here: Any) -> Any:
    """The same part of every array in nested tuples; scalars are unchanged."""
    if not isinstance(value, tuple):
        return value[here] if type(value) is np.ndarray and value.ndim else value
    return tuple([(item[here] if item.ndim else item) if type(item) is np.ndarray
                  else cut(item, here) if isinstance(item, tuple) else item for item in value])


def _placed(new: Any, old: Any, places: tuple[np.ndarray, ...], shape: tuple[int, ...]) -> Any:
    """The old arrays with new values at some places, in nested tuples; constants that stay remain constants."""
    if isinstance(old, tuple):
        return tuple([_placed(mine, other, places, shape) for mine, other in zip(new, old, strict=True)])
    if new is old:
        return old
    result = np.array(old) if np.ndim(old) else np.full(shape, old)
    result[places] = new
    return result
