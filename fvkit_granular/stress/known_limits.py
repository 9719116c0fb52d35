"""Known limits: what is expected to fail, why, and by how much. One place, short, each explained."""

from typing import Any

import attrs


@attrs.frozen
class Limit:
    """A check that is known to fail on some runs.

    Parameters
    ----------
    where : {field of a run: value or tuple of values}; every run that matches must fail the check.
    check : beginning of the name of the check.
    cause : why.
    size : by how much.
    """

    where: dict[str, Any]
    check: str
    cause: str
    size: str

    def matches(self, row: dict[str, Any]) -> bool:
        """Whether the limit is about a run."""
        return all(row[key] in (value if isinstance(value, tuple) else (value,)) for key, value in self.where.items())


@attrs.frozen
class Collapses:
    """How many random scenes may lose their time step: it has a name, `dt_too_small` or `max_steps`, and is counted.

    Parameters
    ----------
    share : largest share of the runs of a model with one solver and order, from `FEW` runs on.
    steps : largest 99 % quantile of steps over nominal steps.
    cause : why.
    """

    share: float
    steps: float
    cause: str


#: Runs below which neither share nor quantile say anything.
FEW = 2000

_OPEN = "an open end where the flow comes in over a rough or steep bottom repeats what it has accelerated"

#: Bounds of collapses, by model, or by model and solver where it differs; measured, and rounded up.
COLLAPSES: dict[str, Collapses] = {
    "two-phase": Collapses(2e-3, 4.5, f"{_OPEN}; without drag a film of one phase falls along emerged steps"),
    "two-phase rusanov": Collapses(6e-3, 5.0, _OPEN),
    "two-layer": Collapses(6e-3, 6.0, f"{_OPEN}; a film of one layer falls along emerged steps"),
    "two-layer rusanov": Collapses(0.015, 18.0, _OPEN),
    "reduced": Collapses(2e-3, 4.5, _OPEN),
    "reduced rusanov": Collapses(6e-3, 5.0, _OPEN),
    "shallow-water": Collapses(2e-3, 4.5, _OPEN),
    "shallow-water rusanov": Collapses(6e-3, 5.0, _OPEN),
    "pitman-le": Collapses(0.08, 20.0, "the model's product -(1-phi) vf (hs (vs - vf))_x is quadratic in vf and not divided by "
                           "the depth of the fluid it drives: at fronts, where hs falls to nothing, thin fluid is accelerated "
                           "without bound"),
}


def known_collapses(model: str, riemann: str) -> Collapses:
    """Return the bounds of a model and a solver."""
    return COLLAPSES.get(f"{model} {riemann}", COLLAPSES[model])


LIMITS: tuple[Limit, ...] = (
    Limit({"scene": "submerged-pile", "model": "two-phase", "riemann": ("hll", "rusanov"), "order": 2}, "velocity of the solid",
          "their viscosity acts on the level water above a heap: the balanced difference does not know that the bed holds the "
          "grains; at order 2 the water then drags the solid out of rest", "up to 0.02 m/s; Relaxation and Roe keep it exactly"),
)
