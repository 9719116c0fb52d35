"""How many random scenes may lose their time step, and why."""

import attrs


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
