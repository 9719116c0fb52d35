"""Rain, infiltration and drains: mass that comes in through the surface and leaves through the bed.

    h_t + (h v)_x = r

Rain brings no momentum; what seeps away takes its own, so the velocity of the rest stays.
"""

from typing import Any, ClassVar

import attrs
import numpy as np

from fvkit import Source, maximum, minimum
from fvkit.pointwise import scale
from fvkit.problem.fields import cells_with, number
from fvkit.problem.sources import mass_rates, with_masses
from fvkit_granular.sources.plausible import caution

#: Largest plausible rain or infiltration, m/s, thousands of times the heaviest known: more is in mm/h.
HEAVIEST = 1.0

#: Said with a rate that is refused.
UNIT = "m/s over the ground: 36 mm/h = 1e-5 m/s"


@attrs.frozen
class Rain(Source):
    """Rain of given intensity, m/s over the ground; negative intensity is infiltration, limited by the existing water.

    Exact in a step. Rain wets dry ground, and counts as entered: `fvkit.Stats`. An ``intensity`` that is not 0 in a few cells
    alone is a point source: discharge, m^2/s, over the length of these cells.

    Parameters
    ----------
    intensity : depth of water and grains per time, m/s, of any sign; negative removes water only. More than 1 m/s warns,
        except as a function of x.
    phi : solid fraction of the rain, in [0, 1].

    Notes
    -----
    It is split from the transport. On ground that is dry everywhere no speed bounds the first step: Strang's splitting, the
    default, takes the step from the water that half of it brings; with ``fv.Godunov()`` give ``dt_initial``.
    While all is dry an intensity of (x, t) is sampled once in each hundredth of the run: for a shorter shower give ``dt_max``.

    Examples
    --------
    >>> import fvkit as fv
    >>> import fvkit_granular as gr
    >>> problem = fv.Problem(gr.ShallowWater(), fv.Grid(0.0, 10.0, 50), lambda x: [0.0 * x, 0.0 * x], 100.0, boundary=fv.Wall(),
    ...                      sources=gr.Rain(1e-3))
    >>> solution = fv.solve(problem, backend="numpy")
    >>> print(f"{solution.q[-1, 0].mean():.6f} m, {solution.stats.entered_by_sources['h']:.6f} m^2")
    0.100000 m, 1.000000 m^2
    """

    separates: ClassVar[str] = ""
    brings: ClassVar[str] = "phi"

    intensity: float = number(hint=UNIT)
    phi: float = number(0.0, at_least=0.0, at_most=1.0, hint="solid fraction of what falls: 60 % is 0.6")

    @property
    def noun(self) -> str:
        """What mass balances call it: a hydrograph, where a map varies in time, else rain."""
        return "hydrograph" if hasattr(self.intensity, "brought") else "rain"

    def acts_in(self) -> np.ndarray | None:
        return cells_with(self.intensity)

    def check(self, model: Any) -> None:
        if not callable(getattr(model, "poured", None)):
            raise ValueError(f"{type(self).__name__} needs the masses of a depth of water, but {type(model).__name__} has no "
                             "`poured(q, solid, fluid)`: define it, or leave the rain out of `sources`")
        caution(self, "intensity", -HEAVIEST, HEAVIEST, UNIT)
        super().check(model)

    def step(self, model, q, aux, dt):
        solid, fluid = self.fallen(dt)
        return with_masses(model, q, model.poured(q, solid, fluid))

    def fallen(self, time):
        """Return the depths of solid and fluid added within a time, m; a negative depth is the potential infiltration."""
        falls = maximum(self.intensity, 0.0)
        return time * (self.phi * falls), time * ((1.0 - self.phi) * falls + minimum(self.intensity, 0.0))

    def rate(self, model, q, aux):
        solid, fluid = self.fallen(1.0)
        dry = scale(0.0, q)
        return mass_rates(model, q, model.poured(dry, solid, maximum(fluid, 0.0)), model.poured(dry, 0.0, maximum(-fluid, 0.0)),
                          model.poured(q, 0.0, -1.0))


@attrs.frozen
class Drain(Source):
    """Drain: mass leaves the cells with its momentum at a rate, 1/s: outlets and gaps in the terrain.

    Exact in a step, q' = q exp(-rate dt); a rate of 1e9 1/s empties a cell at once. Outflow counts as negative inflow in
    `fvkit.Stats`.

    Parameters
    ----------
    rate : fraction of the mass that leaves per time, 1/s, >= 0; usually cell averages, 0 in cells without a drain.

    Examples
    --------
    >>> import numpy as np
    >>> import fvkit as fv
    >>> import fvkit_granular as gr
    >>> hole = np.zeros(50)
    >>> hole[40:] = 1e9
    >>> problem = fv.Problem(gr.ShallowWater(), fv.Grid(0.0, 10.0, 50), lambda x: [np.where(x < 2.0, 1.0, 0.0), 0.0 * x], 60.0,
    ...                      boundary=fv.Wall(), sources=gr.Drain(hole))
    >>> solution = fv.solve(problem, backend="numpy")
    >>> bool(solution.stats.entered_by_sources["h"] < -1.9), float(solution.q[-1, 0, 40:].max())
    (True, 0.0)
    """

    wets: ClassVar[bool] = False
    turns: ClassVar[bool] = False

    noun: ClassVar[str] = "drain"

    leaving: float = number(alias="rate", at_least=0.0, hint="1/s; 0 where nothing leaves")

    def acts_in(self) -> np.ndarray | None:
        return cells_with(self.leaving)

    def step(self, model, q, aux, dt):
        return scale(np.exp(-self.leaving * dt), q)

    def rate(self, model, q, aux):
        return scale(-self.leaving, q)
