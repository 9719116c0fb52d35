"""Circular dam break, from a run along the radius on a fine grid: self-converged, not exact."""

from functools import lru_cache
from math import ceil
from typing import Any, ClassVar

import attrs
import numpy as np

from fvkit import Grid, Outflow, Problem, Source, Wall, WavePropagation, solve, validation
from fvkit.problem.fields import number
from fvkit_granular.exact.states import FloatArray
from fvkit_granular.models.quantities import ratio
from fvkit_granular.models.relaxation import Relaxation
from fvkit_granular.models.shallow_water import ShallowWater
from fvkit_granular.models.wet_dry import velocity


@attrs.frozen
class Spreading(Source):
    """Radial flow of one phase along a line of distances r, m: circles that grow, q_t = -v q/r; exact for constant v."""

    r: float = number(above=0.0)

    def step(self, model, q, aux, dt):
        share = np.exp(-dt * velocity(q[0], q[1], model.dry) / self.r)
        return q[0] * share, q[1] * share

    def rate(self, model, q, aux):
        pace = -velocity(q[0], q[1], model.dry) / self.r
        return pace * q[0], pace * q[1]


@attrs.frozen
class RadialDamBreak:
    """Circular dam break of shallow water, wet or dry outside: a run along the radius, self-converged.

    Parameters
    ----------
    inside, outside : depths at t = 0, m.
    radius : of the dam, m.
    g : gravity, m/s^2.
    cells : of the run, on the radius of the dam.
    """

    kind: ClassVar[str] = "self-converged"
    inside: float = validation.number(2.0, above=0.0)
    outside: float = validation.number(0.5, at_least=0.0)
    radius: float = validation.number(2.5, above=0.0)
    g: float = validation.number(9.81, above=0.0)
    cells: int = validation.integer(1000, at_least=4)

    def along(self, t: float) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Return distances from the middle, m, ascending, and the depth and the velocity outwards there at time ``t``, s."""
        return _run(self, validation.real(t, "t", at_least=0.0))

    def at(self, x: Any, y: Any, t: float) -> dict[str, FloatArray]:
        """Return ``h``, ``v_x``, ``v_y`` at the points x and y, m, of one shape, and the time ``t``, s."""
        distance = np.hypot(x, y)
        if not t > 0.0:
            still = np.zeros_like(distance)
            return {"h": np.where(distance < self.radius, self.inside, self.outside), "v_x": still, "v_y": still}
        r, h, v = self.along(t)
        pace = ratio(np.interp(distance, r, v), distance)
        return {"h": np.interp(distance, r, h), "v_x": pace * x, "v_y": pace * y}


@lru_cache(maxsize=8)
def _run(dam: RadialDamBreak, t: float) -> tuple[FloatArray, FloatArray, FloatArray]:
    """The run along the radius, as far as a front may come."""
    reach = ceil(1.0 + 2.5 * np.sqrt(dam.g * max(dam.inside, dam.outside)) * t / dam.radius)
    grid = Grid(0.0, reach * dam.radius, reach * dam.cells)

    def initial(r: np.ndarray) -> list[np.ndarray]:
        return [np.where(r < dam.radius, dam.inside, dam.outside), 0.0 * r]

    spreading: Any = Spreading
    problem = Problem(ShallowWater(g=dam.g), grid, initial, t, boundary=(Wall(), Outflow()), sources=spreading(lambda r: r))
    seen = solve(problem, WavePropagation(Relaxation()), backend="numpy").observables()
    return grid.centers, seen["h"], seen["v"]
