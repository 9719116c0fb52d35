"""Built-in scenes, each with its reference and its provenance.

Examples
--------
>>> import fvkit_granular as gr
>>> scene = gr.scene("riemann")
>>> scene.interval, scene.t_end, scene.known_reference().kind
((-5.0, 5.0), 0.5, 'semi-exact')
"""

from functools import partial
from typing import Any

import numpy as np

from fvkit_granular.scenes.reference import FunctionReference, one_velocity, still
from fvkit_granular.scenes.scene import Scene, two_states
from fvkit_granular.scenes.shaped_flow import ShapedFlow
from fvkit_granular.scenes.shapes import Step, Steps


def _riemann_problem(left: dict[str, float], right: dict[str, float], **settings: Any) -> Scene:
    """Two states with a jump at 0, and the semi-exact solution of the full model."""
    def reference(scene: Scene) -> FunctionReference:
        from fvkit_granular import exact

        first, last = ([state[name] for name in ("h", "phi", "vs", "vf")] for state in (left, right))
        solved = exact.two_phase_riemann(first, last, g=scene.g, gamma=scene.gamma)
        return FunctionReference("semi-exact", "four-wave solution for the segment path in (hs, hf), states to 1e-6; internal "
                                 "shocks depend on the path, and schemes miss their speed by 0.8 to 3.5 % without in_cell_shocks",
                                 at=solved.at, sensitivity=partial(exact.path_sensitivity, first, last, scene.g, scene.gamma))

    return Scene((-5.0, 5.0), initial=two_states(left, right), reference=reference, **settings)


def riemann() -> Scene:
    """R1: the Riemann problem with slip on both sides."""
    return _riemann_problem({"h": 3.0, "phi": 0.7, "vs": -1.4, "vf": 0.3}, {"h": 2.0, "phi": 0.4, "vs": -0.9, "vf": -0.1},
                            t_end=0.5, name="riemann",
                            description="Riemann problem: rarefaction, shock, composite wave, shock (states from memory, "
                            "not confirmed as those of the 2008 paper)")


def dam_break_phi() -> Scene:
    """R2: a dam break with a jump of phi, from rest."""
    return _riemann_problem({"h": 3.0, "phi": 0.7, "vs": 0.0, "vf": 0.0}, {"h": 2.0, "phi": 0.4, "vs": 0.0, "vf": 0.0},
                            t_end=0.5, name="dam-break-phi",
                            description="dam break from rest with different solid fractions; phases "
                            "separate behind the internal shock")


def phi_jump() -> Scene:
    """R3: a jump of phi alone, from rest, at constant depth."""
    return _riemann_problem({"h": 1.0, "phi": 0.7, "vs": 0.0, "vf": 0.0}, {"h": 1.0, "phi": 0.3, "vs": 0.0, "vf": 0.0},
                            t_end=1.0, name="phi-jump",
                            description="constant depth, jump of the solid fraction, at rest: driven by inner "
                            "waves alone, nothing moves in a single-phase model")


def dam_break() -> Scene:
    """E2: Stoker's dam break with uniform phi."""
    def reference(scene: Scene) -> FunctionReference:
        from fvkit_granular import exact

        solved = exact.shallow_water_riemann((2.0, 0.0), (1.0, 0.0), g=scene.g)
        return FunctionReference("exact", "Stoker's dam break: exact for all models where phi is uniform and vs = vf",
                                 at=lambda x, t: one_velocity(solved.at(x, t), 0.6))

    return Scene((-5.0, 5.0), t_end=0.5, initial=ShapedFlow(Step(0.0, 2.0, 1.0), phi=0.6), reference=reference,
                 name="dam-break", description="Stoker's dam break 2 m | 1 m with uniform phi = 0.6 (classical)")


def simple_wave() -> Scene:
    """E4: a smooth simple wave, the order test."""
    def reference(scene: Scene) -> FunctionReference:
        from fvkit_granular import exact

        solved = exact.simple_wave(exact.hump(centre=4.0), g=scene.g)
        return FunctionReference("exact", "simple wave by characteristics, smooth until it breaks at t = 2.044 s",
                                 at=lambda x, t: one_velocity(solved.at(x, t), 0.6))

    def initial(x: np.ndarray) -> dict[str, Any]:
        from fvkit_granular import exact

        return one_velocity(exact.simple_wave(exact.hump(centre=4.0)).at(x, 0.0), 0.6)

    return Scene((0.0, 10.0), t_end=0.6, initial=initial, reference=reference, name="simple-wave",
                 description="smooth right-going wave with uniform phi = 0.6: shows the order of a scheme")


def rest() -> Scene:
    """E1: a lake at rest over a smooth bump and over steps."""
    flow = ShapedFlow(surface=1.0, phi=0.6, bottom=rest_bottom)
    return Scene((0.0, 2.0), t_end=0.5, initial=flow, bottom=rest_bottom, reference=still(flow, rest_bottom), name="rest",
                 description="lake at rest over a smooth bump (x = 1.5) and two 0.4 m steps (x = 0.7, 1.3), "
                 "phi = 0.6 (classical)")


def rest_bottom(x: np.ndarray) -> np.ndarray:
    """A step of 0.4 m on |x - 1| < 0.3 and a cosine bump of 0.5 m on |x - 1.5| < 0.1."""
    return np.where(np.abs(x - 1.0) < 0.3, 0.4, 0.0) + bump(x, 1.5)


def bump(x: np.ndarray, centre: float) -> np.ndarray:
    """Return the bump 0.25 (cos(10 pi (x - centre)) + 1) on |x - centre| < 0.1."""
    return np.where(np.abs(x - centre) < 0.1, 0.25 * (np.cos(10.0 * np.pi * (x - centre)) + 1.0), 0.0)


def perturbed_rest(eps: float = 0.01) -> Scene:
    """T1: a small wave over a bump, LeVeque's test; its height ``eps``, m, is that of the surface on 0.1 < x < 0.2."""
    bottom = partial(bump, centre=0.5)
    flow = ShapedFlow(surface=Steps([0.1, 0.2], [1.0, 1.0 + eps, 1.0]), phi=0.6, bottom=bottom)
    return Scene((-1.0, 1.0), t_end=0.7, initial=flow, bottom=bottom, g=1.0, name="perturbed-rest",
                 description=f"surface raised by {eps:g} m on 0.1 < x < 0.2 over a bump, g = 1, phi = 0.6 (LeVeque 1998; "
                 "eps = 0.01 seen in a public test case, eps = 0.2 from memory); the answer equals the single-phase one")
