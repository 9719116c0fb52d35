"""`Stage` and `UniformSlope`: how a flow leaves where the channel goes on."""

from collections.abc import Mapping
from typing import Any

import attrs
import numpy as np

from fvkit import BoundaryCondition, Grid, Model, _validate, maximum, minimum, where
from fvkit.boundary import Continued, beyond
from fvkit_granular.beyond import falling_share, mean_speed
from fvkit_granular.inflow import at_time, check_tables, of_flow


def _level(value: Any) -> Any:
    return value if callable(value) and not isinstance(value, type) else _validate.row(value, "level")


#: A flow that is less than ``LOWER`` times as deep as a lake gives no velocity to what pours in, and all of it 1/``STILL`` of the
#: depth of the lake above that.
LOWER, STILL = 0.8, 7.0


@attrs.frozen
class Stage(Continued):
    """A lake or sea of given level at the end: the depth of the ghost cells is the level less the bottom there.

    The flow passes in or out as the difference of levels has it. One that leaves faster than its waves does not feel it, unless
    the lake is so much deeper that a jump runs in. A river that leaves or enters has the level at the face; into a flow less than
    0.8 times as deep as the lake, or onto dry ground, it pours out of rest, as a dam breaks.

    Parameters
    ----------
    level : height of the free surface, m, over the same datum as the bottom: a number, one for each of ``times``, linear between
        them, or a function of time, s.
    phi : solid fraction of what flows in, in [0, 1]: 0, clear water, by default. What flows out has its own.
    times : times of the levels, s, ascending; before the first and after the last they stay.
    slope : fall of the bottom per metre beyond the end, outwards, positive where it falls; None for that of the last two cells.
    """

    level: Any = attrs.field(converter=_level)
    phi: float = _validate.number(0.0, at_least=0.0, at_most=1.0)
    times: tuple[float, ...] = attrs.field(default=(0.0,), converter=lambda value: _validate.row(value, "times"))
    bottom: float = attrs.field(default=0.0, init=False, repr=False)
    inward: float = attrs.field(default=1.0, init=False, repr=False)

    def __attrs_post_init__(self) -> None:
        check_tables(self, self.times, level=(0.0,) if callable(self.level) else self.level)

    @property
    def steady(self) -> bool:
        return not callable(self.level) and len(self.level) == 1

    def breaks(self) -> tuple[float, ...]:
        return () if self.steady or callable(self.level) else self.times

    def placed(self, left: bool, model: Model, grid: Grid, aux: Mapping[str, np.ndarray]) -> "Stage":
        result = super().placed(left, model, grid, aux)
        object.__setattr__(result, "bottom", float(aux["b"][0 if left else -1]) if "b" in aux else 0.0)
        object.__setattr__(result, "inward", 1.0 if left else -1.0)
        return result

    def at(self, t: float) -> float:
        """Return the level at time t, s."""
        if callable(self.level):
            return _validate.real(self.level(t), f"level of a Stage at t = {t:g}")
        return at_time(t, self.times, self.level)

    def values(self, model: Model, t: float) -> tuple[float, ...]:
        masses, momenta = of_flow(model, self, 1.0, self.phi)
        slope, distance = self.ground or (0.0, 0.0)
        return (self.at(t) - self.bottom, slope, 0.5 * distance, *masses, *momenta, *self.ground)

    def ghost(self, model, q, values):
        level, slope, rows, distance = values[0], values[1], len(q), values[len(values) - 1]
        h, v = model.depth(q), mean_speed(model, q)
        wet, out = h > model.dry, -self.inward * v
        surface = level + falling_share(model, q, slope) * slope * (distance - values[2])
        depth = maximum(surface - slope * distance, 0.0)
        ratio = depth / where(wet, h, 1.0)
        # A river enters with its velocity. Into a much lower flow a lake pours out of rest: it has no other head than its level.
        enters = v * minimum(maximum(STILL * (h - LOWER * depth), 0.0), depth)
        # The speed at which waves run in: that of a jump where the lake is deeper.
        unfelt = wet & (out > np.sqrt(model.g * h * maximum(1.0, 0.5 * ratio * (ratio + 1.0))))
        flow = beyond(self, model, q, values)
        has = model.depth(flow)
        leaves, scale, result = wet & (out >= 0.0) & (has > 0.0), where(unfelt, 1.0, depth / where(has > 0.0, has, 1.0)), q[:0]
        for k in range(rows):
            result = result + (where(leaves, scale * flow[k], depth * values[3 + k] + enters * values[3 + rows + k]),)
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
