"""`LineInflow`: flow that comes in through a line on a terrain with a velocity, as `fvkit_granular.read_hydrograph` makes it."""

from typing import ClassVar

import attrs

from fvkit.pointwise import scale
from fvkit.problem.directions import plane_places
from fvkit.problem.fields import number
from fvkit_granular.sources.rain import Rain


@attrs.frozen
class LineInflow(Rain):
    """Rain that brings the momentum of its mass, the same velocity of all phases; two axes alone.

    Parameters
    ----------
    intensity, phi : depth per time, m/s, >= 0, and solid fraction, see `Rain`.
    speed_x, speed_y : velocity on the map, m/s.
    """

    turns: ClassVar[bool] = False

    speed_x: float = number(0.0)
    speed_y: float = number(0.0)

    def step(self, model, q, aux, dt):
        places, result = plane_places(model), list(q)
        masses = iter(model.poured(tuple([q[place] for place in places]), *self.fallen(dt)))
        for rows, momentum in model.phases:
            for row in rows:
                result[places[row]] = next(masses)
            gain = result[places[rows[-1]]] - q[places[rows[-1]]]
            for place, speed in enumerate((self.speed_x, self.speed_y), places[momentum]):
                result[place] = q[place] + gain * speed
        return tuple(result)

    def rate(self, model, q, aux):
        return self.step(model, scale(0.0, q), aux, 1.0)
