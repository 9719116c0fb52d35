"""Known limits: runs that are expected to fail, with the reason and the size of the failure."""

from typing import Any

import attrs


@attrs.frozen
class Limit:
    """A check, by the beginning of its name, that is known to fail on some runs, why, and by how much.

    Every run that matches ``where``, {field of a run: value or tuple of values}, must fail the check.
    """

    where: dict[str, Any]
    check: str
    cause: str
    size: str

    def matches(self, row: dict[str, Any]) -> bool:
        """Whether the limit is about a run."""
        return all(row[key] in (value if isinstance(value, tuple) else (value,)) for key, value in self.where.items())


LIMITS: tuple[Limit, ...] = (
    Limit({"scene": "submerged-pile", "model": "two-phase", "riemann": ("hll", "rusanov"), "order": 2}, "velocity of the solid",
          "their viscosity acts on the level water above a heap: the balanced difference neglects that the bed holds the "
          "grains; at order 2 the water then drags the solid out of rest", "up to 0.02 m/s; Relaxation and Roe keep it exactly"),
)
