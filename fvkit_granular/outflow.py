"""`Stage` and `UniformSlope`: how a flow leaves where the channel goes on."""

from collections.abc import Mapping

import attrs
import numpy as np

from fvkit import BoundaryCondition, Grid, Model, _validate, where
from fvkit_granular.inflow import of_flow


@attrs.frozen
class Stage(BoundaryCondition):
    """A lake or sea of given level beyond the end: the depth of the ghost cells is the level less the bottom there.

    The flow passes in or out as the difference of levels has it; a flow that leaves faster than its waves does not feel it.

    Parameters
    ----------
    level : height of the free surface, m, over the same datum as the bottom.
    phi : solid fraction of what flows in, in [0, 1]: 0, clear water, by default. What flows out has its own.
    """

    level: float = attrs.field(converter=_validate.within())  # type: ignore[misc]
    phi: float = _validate.number(0.0, at_least=0.0, at_most=1.0)
    bottom: float = attrs.field(default=0.0, init=False, repr=False)
    inward: float = attrs.field(default=1.0, init=False, repr=False)

    def placed(self, left: bool, model: Model, grid: Grid, aux: Mapping[str, np.ndarray]) -> "Stage":
        result = attrs.evolve(self)
        object.__setattr__(result, "bottom", float(aux["b"][0 if left else -1]) if "b" in aux else 0.0)
        object.__setattr__(result, "inward", 1.0 if left else -1.0)
        return result

    def values(self, model: Model, t: float) -> tuple[float, ...]:
        depth = max(self.level - self.bottom, 0.0)
        masses, momenta = of_flow(model, self, depth, self.phi)
        return (depth, *masses, *momenta)

    def ghost(self, model, q, values):
        h = model.depth(q)
        wet = h > model.dry
        flow, mass = 0.0, 0.0
        for masses, momentum in model.phases:
            flow, mass = flow + q[momentum], mass + q[masses[-1]]
        speed = where(wet, flow / where(wet, mass, 1.0), 0.0)
        leaves = wet & (self.inward * flow <= 0.0)
        scale, rows, result = values[0] / where(wet, h, 1.0), len(q), q[:0]
        for k in range(rows):
            result = result + (where(leaves, scale * q[k], values[1 + k] + speed * values[1 + rows + k]),)
        return result


@attrs.frozen
class UniformSlope(BoundaryCondition):
    """The channel goes on at a slope, and the flow with it: uniform flow leaves unhindered where friction balances the slope.

    The ghost cells have the state of the last cell, over a bottom that goes on falling. Water at rest is no equilibrium of this
    end (it would flow off): `fvkit.Outflow` keeps it.

    Parameters
    ----------
    slope : fall of the bottom per metre beyond the end, outwards, positive where it falls; None for that of the last two cells.
    """

    slope: float | None = _validate.optional_number()

    def placed(self, left: bool, model: Model, grid: Grid, aux: Mapping[str, np.ndarray]) -> "UniformSlope":
        if "b" not in model.aux:
            raise ValueError(f"UniformSlope needs a model with a bottom `b`, such as gr.TwoPhase, got {type(model).__name__}")
        if self.slope is not None:
            return self
        if grid.num_cells < 2:
            raise ValueError("UniformSlope needs two cells to see the slope of the bottom: give `slope`")
        near, next_to_it = (aux["b"][0], aux["b"][1]) if left else (aux["b"][-1], aux["b"][-2])
        return attrs.evolve(self, slope=float(next_to_it - near) / grid.dx)

    def ghost_aux(self, model: Model, aux: np.ndarray, distance: np.ndarray) -> np.ndarray:
        result = np.array(aux)
        result[model.aux.index("b")] -= (self.slope or 0.0) * distance
        return result

    def ghost(self, model, q, values):
        return q
