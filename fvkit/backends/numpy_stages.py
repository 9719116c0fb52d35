"""Runs the stages of a plan on whole arrays."""

from typing import Any

import numpy as np

from fvkit.backends.plan import Plan
from fvkit.schemes.scheme import Parts

Field = tuple[Any, ...]


class Runner:
    """Runs the stages of a plan over chunks of cells. Entry 0 of a field is the place that ``lows`` says."""

    def __init__(self, parts: Parts, plan: Plan, lengths: set[int]) -> None:
        self.parts, self.plan = parts, plan
        self.lows = {"q": -plan.halo, "aux": -plan.halo}
        self._reads = {n: self._reading(n) for n in lengths}

    def run(self, fields: dict[str, Field], n: int, ratio: float, set_ends: Any = None) -> dict[str, Field]:
        """Add to the fields q and aux of n cells what all stages write; ``set_ends`` changes fields before the last ones."""
        for stage, reads in zip(self.plan.stages, self._reads[n], strict=True):
            if stage.writes == ("to_left",) and set_ends is not None:
                set_ends(fields)
            inputs = [cut(fields[field], part) for field, part in reads]
            asks: Any = True if stage.guard is None else stage.guard(self.parts, ratio, *inputs)
            if not np.any(asks):
                continue
            if stage.sparse:
                places = np.flatnonzero(asks)
                here_only = stage.compute(self.parts, ratio, *(cut(item, places) for item in inputs))
                written = _placed(here_only, tuple(fields[name] for name in stage.writes), places, len(asks))
            else:
                written = stage.compute(self.parts, ratio, *inputs)
            fields.update(zip(stage.writes, written, strict=True))
        return fields

    def _reading(self, n: int) -> list[list[tuple[str, slice]]]:
        """For each stage, the part of each field that it reads in a chunk of n cells."""
        result = []
        for stage, (low, high) in zip(self.plan.stages, self.plan.ranges, strict=True):
            result.append([(field, self.part(field, offset, low, high, n))
                           for field, first, last in stage.reads for offset in range(first, last + 1)])
            self.lows |= dict.fromkeys(stage.writes, low)
        return result

    def part(self, field: str, offset: int, low: int, high: int, n: int) -> slice:
        """What a stage covering the places low .. n + high - 1 sees of a field at an offset."""
        return slice(low + offset - self.lows[field], n + high + offset - self.lows[field])


def cut(value: Any, here: Any) -> Any:
    """The same part of every array in nested tuples; scalars stay what they are."""
    if type(value) is not tuple:
        return value[here] if type(value) is np.ndarray and value.ndim else value
    return tuple([(item[here] if item.ndim else item) if type(item) is np.ndarray
                  else cut(item, here) if type(item) is tuple else item for item in value])


def _placed(new: Any, old: Any, places: np.ndarray, count: int) -> Any:
    """The old arrays with new values at some places, in nested tuples; constants that stay remain constants."""
    if type(old) is tuple:
        return tuple([_placed(mine, other, places, count) for mine, other in zip(new, old, strict=True)])
    if new is old:
        return old
    result = np.array(old) if np.ndim(old) else np.full(count, old)
    result[places] = new
    return result
