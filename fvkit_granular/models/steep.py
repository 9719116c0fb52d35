"""Equations on steep ground: gravity, load and thickness on a bottom of slope s = |grad b|, cos^2 = 1/(1 + s^2).

A layer of vertical depth h whose surface is h + b is driven by g cos^2 grad(h + b), with g the gravity of the mild-slope
equations: so on a plane it slides with g sin in its own direction, and a lake stays level. All pressures have the same factor
(speeds of waves: sqrt(g cos^2 h)). Its weight on the bed is g cos per mass, its thickness h cos, and friction acts against the
velocity along the bed. Exact for a slab on any plane; across a slope, too.

A curved bottom turns the flow with the force (u . Hess(b) u) cos of the load: the source `Curvature` adds it to the push and
to the load, or to neither. Not contained: the pressure along the slope of a layer that varies quickly, which is g cos^4 there:
waves along a slope run too fast by 1/cos - 1, 15 % at 30 degrees.

Source: J. Xia, Q. Liang, Engineering Geology 234 (2018) 174-191, as remembered, without curvature; friction in the tangent plane
derived here.
"""

from typing import Any

from fvkit import maximum, minimum

#: Bounds of u . Hess(b) u over gravity: flow over a crest stays on the ground, and a kink is no wall.
LEAST, MOST = -0.9, 10.0


class OnBed:
    """A model as sources see it on a slope: depth and load normal to the bed, times the cosine of the slope.

    A curved bed adds its ``turning``, u . Hess(b) u of each phase, within `LEAST` and `MOST` times gravity, to that in the load.
    """

    def __init__(self, model: Any, cosine: Any, turning: tuple[Any, ...]) -> None:
        self._model, self._cosine = model, cosine
        self.turning = tuple([minimum(maximum(much, LEAST * model.g), MOST * model.g) for much in turning])

    def __getattr__(self, name: str) -> Any:
        return getattr(self._model, name)

    def depth(self, q):
        """Return the thickness normal to the bed, m."""
        return self._cosine * self._model.depth(q)

    def basal_load(self, q):
        """Return the load normal to the bed per mass, m/s^2, one value per phase."""
        loads = self._model.basal_load(q)
        if self.turning:
            loads = [load * (1.0 + much / self._model.g) for load, much in zip(loads, self.turning, strict=True)]
        return tuple([self._cosine * load for load in loads])
