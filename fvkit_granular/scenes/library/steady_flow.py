"""Built-in scenes of steady flow over a bump, and a small wave on one; `fvkit_granular.scenes` lists them with the others.

All boundaries are zero-order extrapolation, which keeps a uniform flow on level ground, for every model.
"""

from collections.abc import Callable, Mapping
from functools import partial
from typing import TYPE_CHECKING, Any

import numpy as np

from fvkit.validation import choice
from fvkit_granular.scenes.reference import FunctionReference
from fvkit_granular.scenes.scene import Scene

if TYPE_CHECKING:
    from fvkit_granular.exact.moving_equilibrium import MovingEquilibrium

#: h, phi, vs, vf where the ground is level.
FLOWS: dict[str, dict[str, float]] = {
    "moving-equilibrium": {"h": 1.0, "phi": 0.6, "vs": 0.3, "vf": 0.2},
    "moving-slip": {"h": 1.0, "phi": 0.6, "vs": 0.8, "vf": -0.2},
    "moving-fast": {"h": 1.0, "phi": 0.6, "vs": 6.0, "vf": 5.5},
}

#: Names and descriptions of the steady scenes.
STEADY = {
    "moving-equilibrium": "steady flow over a bump of 0.2 m, h = 1, phi = 0.6, vs = 0.3, vf = 0.2 m/s at its foot, slower than "
                          "all waves (derived here)",
    "moving-slip": "steady flow over a bump of 0.2 m, h = 1, phi = 0.6, vs = 0.8, vf = -0.2 m/s at its foot: phases that pass "
                   "each other (derived here)",
    "moving-fast": "steady flow over a bump of 0.2 m, h = 1, phi = 0.6, vs = 6, vf = 5.5 m/s at its foot, faster than all waves "
                   "(derived here)",
    "subcritical-bump": "steady flow, discharge 4.42 m^2/s, outlet depth 2 m, over a parabolic bump, phi = 0.6 (classical)",
    "transcritical-bump": "steady flow, discharge 1.53 m^2/s, critical at the top of a parabolic bump, uniform phi = 0.6 "
                          "(classical); kept with entropy_fix=False only",
}


def smooth_bump(x: np.ndarray) -> np.ndarray:
    """Return 0.2 cos^2(pi (x - 5)/4) on |x - 5| < 2, m."""
    return np.where(np.abs(x - 5.0) < 2.0, 0.2 * np.cos(0.25 * np.pi * (x - 5.0)) ** 2, 0.0)


def parabolic_bump(x: np.ndarray) -> np.ndarray:
    """Return 0.2 - 0.05 (x - 10)^2 on |x - 10| < 2, m."""
    return np.where(np.abs(x - 10.0) < 2.0, 0.2 - 0.05 * (x - 10.0) ** 2, 0.0)


def profile(name: str) -> "MovingEquilibrium":
    """Return the steady flow of one of the scenes ``STEADY``."""
    from fvkit_granular.exact.moving_equilibrium import steady

    name = choice(name, "name", STEADY)
    if name == "subcritical-bump":
        return steady(parabolic_bump, {"h": 2.0, "phi": 0.6, "vs": 2.21, "vf": 2.21}, (0.0, 25.0), 25.0)
    if name == "transcritical-bump":
        return steady(parabolic_bump, {"h": 1.0, "phi": 0.6, "vs": 1.53, "vf": 1.53}, (0.0, 25.0), transcritical=True)
    return steady(smooth_bump, FLOWS[name], (0.0, 10.0))


def steady_scene(name: str) -> Scene:
    """E6, E7: a steady flow over a bump, one of ``STEADY``, which stays for ever."""
    flow = profile(name)
    return Scene(flow.interval, 1.0, flow.at, bottom=flow.bottom, name=name, description=STEADY[name],
                 reference=FunctionReference("exact", "the initial state at all times, a steady flow (3.8)", at=flow.at))


def perturbed_moving(eps: float = 1e-3) -> Scene:
    """A small wave on a steady flow with slip, the kind of test of the paper's Section 10.

    Heights ``eps`` of the wave of 1e-2 to 1e-6 m show what a scheme resolves.
    """
    slipping = profile("moving-slip")

    def flow(x: np.ndarray) -> Mapping[str, Any]:
        at, wave = slipping.at(x), np.where(np.abs(x - 2.0) < 0.5, np.cos(np.pi * (x - 2.0)) ** 2, 0.0)
        return {**at, "h": at["h"] + eps * wave}

    return Scene(slipping.interval, 1.0, flow, bottom=smooth_bump, name="perturbed-moving",
                 description=f"wave of {eps:g} m on the steady flow of moving-slip (the paper's tests of this "
                 "kind have other, unknown data)")


MOVING_SCENES: dict[str, Callable[[], Scene]] = {name: partial(steady_scene, name) for name in STEADY} | {
    "perturbed-moving": perturbed_moving,
}
