"""`Curvature`: the centripetal force of a curved bottom, in the driving force and in the load of friction."""

from typing import Any, ClassVar

import attrs

from fvkit import Source
from fvkit.pointwise import scale


@attrs.frozen
class Curvature(Source):
    """Centripetal force of a curved bottom: u . Hess(b) u is added to gravity, in the driving force and in the load.

    With c the cosine of the slope and kappa = u . Hess(b) u, the velocity u of each phase changes by -c^2 kappa grad(b), and
    its load is (g + kappa) c: a flow presses on the bottom of a valley and is light on a crest. kappa is kept within -0.9 and
    10 g. The Hessian is that of slopes smoothed by the weights 1/4, 1/2, 1/4 along each axis, since those of a raster are
    noise, and is the median of five differences in a row, so that a cliff of one or two faces has no effect. A cliff askew to
    the grid spreads over three cells: beside it the Hessian is wrong, as is that of a ravine of two cells.

    Needs ``slope="steep"``. It acts with the transport, on cells and faces, as friction does.

    Notes
    -----
    Curvature in friction alone is less accurate than none, so there is no such option. A block in a round valley (radius 60 m,
    40 degrees, Coulomb 0.25) reaches 10.0 m/s; 9.4 m/s without it (tests/plane/test_steep.py).
    Energy: docs/validation/terrain.md.

    Source: the motion of a point on a surface, classical; derived here for layers.

    Examples
    --------
    >>> import fvkit as fv
    >>> import fvkit_granular as gr
    >>> gr.Curvature().check(gr.ShallowWater())
    Traceback (most recent call last):
    ValueError: Curvature needs the equations for steep ground: gr.ShallowWater(slope="steep")
    """

    bends: ClassVar[bool] = True
    separates: ClassVar[str] = ""

    def check(self, model: Any) -> None:
        if model.relief() is None:
            raise ValueError(f"Curvature needs the equations for steep ground: gr.{type(model).__name__}(slope=\"steep\")")
        super().check(model)

    def step(self, model, q, aux, dt):
        return q

    def driven(self, model, before, after, bearing, aux, dt):
        return after  # the force is added before sources act, see `fvkit.problem.relief`

    def rate(self, model, q, aux):
        return scale(0.0, q)
