"""Built-in scenes with friction at the bed; `fvkit_granular.scenes` lists them with the others."""

from collections.abc import Callable
from typing import Any

import numpy as np

from fvkit import Periodic
from fvkit_granular.models.quantities import Flow
from fvkit_granular.scenes.reference import FunctionReference, one_velocity, still
from fvkit_granular.scenes.scene import Scene
from fvkit_granular.scenes.shaped_flow import ShapedFlow
from fvkit_granular.scenes.shapes import Block, Plane, Step
from fvkit_granular.sources.drag_laws import ConstantDrag, PitmanLeDrag
from fvkit_granular.sources.friction_laws import CoulombFriction

#: Density of air over that of grains: dry piles carry their full weight in every model, to 0.05 %.
AIR = 5e-4


def _resting(flow: Flow, **settings: Any) -> Scene:
    """A scene that stays as it starts."""
    return Scene(initial=flow, reference=still(flow), **settings)


def pile() -> Scene:
    """A dry pile below its angle of friction."""
    return _resting(lambda x: {"h": np.maximum(0.0, 1.0 - 0.4 * np.abs(x)), "phi": 1.0}, interval=(-4.0, 4.0), t_end=1.0,
                    gamma=AIR, sources=CoulombFriction(0.5), name="pile",
                    description="dry pile of slope 0.4 on a level bed, nu = 0.5, in air: stays at rest")


def toe() -> Scene:
    """A pile on a slope with a dry toe below it."""
    return _resting(lambda x: {"h": np.maximum(0.0, 1.0 - 0.25 * np.abs(x)), "phi": 1.0}, interval=(-6.0, 6.0), t_end=1.0,
                    bottom=Plane(0.3), gamma=AIR, sources=CoulombFriction(0.6), name="toe",
                    description="dry pile h = 1 - |x|/4 on a bed of slope 0.3, nu = 0.6, in air: its "
                    "surface is 0.55 steep at most, so it rests, its thin downslope end too")


def sliding_dam_break() -> Scene:
    """A dam break that slides down a rough plane."""
    slope, nu, v0, phi = 0.6, 0.5, 1.0, 0.6

    def reference(scene: Scene) -> FunctionReference:
        from fvkit_granular import exact

        flat = exact.reduced_riemann((2.0, phi, 0.0), (1.0, phi, 0.0), g=scene.g, gamma=scene.gamma)
        buoyancy = scene.gamma / (phi + scene.gamma * (1.0 - phi))
        solved = exact.accelerated(flat, exact.sliding_acceleration(slope, nu, scene.g, buoyancy), v0)

        return FunctionReference("exact", "Stoker's dam break in an accelerated frame: exact for the reduced model, and for "
                                 "two phases where drag binds them; shallow water lacks buoyancy and slides more slowly; "
                                 "the ends of the interval are open, which is no flow on a slope, and send waves 2.6 m inwards",
                                 at=lambda x, t: one_velocity(solved.at(x, t), phi))

    return Scene((-15.0, 15.0), t_end=0.5, initial=ShapedFlow(Step(0.0, 2.0, 1.0), phi=phi, vs=v0, vf=v0),
                 bottom=Plane(-slope), sources=(CoulombFriction(nu), ConstantDrag(1e9)), reference=reference,
                 name="sliding-dam-break",
                 description="dam break 2 m | 1 m, phi = 0.6, that slides at 1 m/s at first down a plane of slope 0.6, nu = "
                 "0.5, phases bound by drag (after Mangeney, Heinrich and Roche 2000)")


def column_collapse() -> Scene:
    """A column of dry grains that collapses and comes to rest."""
    return Scene((-4.0, 4.0), t_end=3.0, initial=ShapedFlow(Block(0.0, 0.5, 1.0), phi=1.0), gamma=AIR,
                 sources=CoulombFriction(0.5), name="column-collapse",
                 description="column of dry grains, 1 m high and wide, on a level bed, nu = 0.5, in air: "
                 "comes to rest, exactly, with no slope above nu")


def block_stop() -> Scene:
    """A layer that slides on a level bed until friction stops it."""
    v0, nu = 2.0, 0.5

    def reference(scene: Scene) -> FunctionReference:
        from fvkit_granular import exact

        return FunctionReference("exact", "v = max(2 - nu g t, 0), exactly 0 from 0.408 s on; two phases and the reduced model, "
                                 "with the buoyancy of air, stop 0.2 ms later",
                                 at=lambda x, t: one_velocity({"h": 1.0, "v": exact.block_stop(v0, nu, t, scene.g)}, 1.0))

    return Scene((0.0, 1.0), t_end=0.5, initial=ShapedFlow(1.0, phi=1.0, vs=v0), boundary=Periodic(), gamma=AIR,
                 sources=CoulombFriction(nu), reference=reference, name="block-stop",
                 description="layer of dry grains that slides at 2 m/s on a level bed, nu = 0.5, in air (classical): stops at "
                 "0.408 s")


def submerged_pile() -> Scene:
    """A heap of grains under level water."""
    return _resting(lambda x: {"h": 1.0, "phi": 0.2 * (1.0 + np.exp(-x * x))}, interval=(-4.0, 4.0), t_end=1.0,
                    sources=CoulombFriction(0.3), name="submerged-pile",
                    description="bed of grains with a heap, hs = 0.2 + 0.2 exp(-x^2), under level water 1 m deep, nu = 0.3: "
                    "rests, since |hs_x| <= 2 nu hs/h everywhere")


def debris_slope() -> Scene:
    """S1: a debris flow released on a slope."""
    def bottom(x: np.ndarray) -> np.ndarray:
        return np.clip(2.5 - 0.25 * x, 0.0, 2.5)

    return Scene((-5.0, 25.0), t_end=2.0, bottom=bottom,
                 initial=lambda x: {"h": np.where(x < 2.0, 4.0 - bottom(x), 0.01), "phi": 0.5},
                 sources=(CoulombFriction(0.53170943), PitmanLeDrag(2.0, 0.0)), name="debris-slope",
                 description="debris flow released on a slope of 1:4, phi = 0.5, bed friction 28 degrees, Pitman-Le drag "
                 "(states and constants as in the public code fvshock, its test 41; interval and end time are ours); "
                 "qualitative, no reference")


FRICTION_SCENES: dict[str, Callable[[], Scene]] = {
    "pile": pile, "toe": toe, "sliding-dam-break": sliding_dam_break, "column-collapse": column_collapse,
    "block-stop": block_stop, "submerged-pile": submerged_pile, "debris-slope": debris_slope,
}
