"""Built-in scenes that set models apart: smooth slip over a bottom, Pitman and Le's fluid momentum, two layers of water.

A scene has no model: the descriptions of the two-layer ones name `TwoLayer`, with phi
the share of the lower layer, vs its velocity, and vf that of the upper one.
"""

from collections.abc import Callable
from typing import Any

import numpy as np

from fvkit import Periodic
from fvkit_granular.scenes.reference import FunctionReference, still
from fvkit_granular.scenes.scene import Scene, two_states
from fvkit_granular.scenes.shapes import Step


def slip_over_bottom() -> Scene:
    """E10: smooth periodic flow with slip over a bottom, where every term of the full model acts."""
    def flow(x: np.ndarray) -> dict[str, Any]:
        k = 2.0 * np.pi * x
        hs, hf = 0.6 + 0.05 * np.sin(k), 0.4 + 0.03 * np.cos(k)
        return {"h": hs + hf, "phi": hs / (hs + hf), "vs": 0.3 + 0.1 * np.cos(k), "vf": -0.2 + 0.1 * np.sin(k)}

    def bottom(x: np.ndarray) -> np.ndarray:
        return 0.1 * np.sin(2.0 * np.pi * x + 0.5)

    def reference(scene: Scene) -> FunctionReference:
        from fvkit_granular import exact

        solved = exact.periodic_flow(flow, bottom, scene.t_end, scene.interval, scene.g, scene.gamma)
        return FunctionReference("self-converged", f"Fourier pseudo-spectral, {solved.coefficients.shape[1]} modes, within "
                                 f"{solved.accuracy:.0e} of the solution with two thirds of them", at=solved.at)

    return Scene((0.0, 1.0), t_end=0.15, initial=flow, bottom=bottom, boundary=Periodic(), reference=reference,
                 name="slip-over-bottom", description="smooth periodic flow with slip over a sine bottom: "
                 "shows the order of a scheme where nonconservative products and bottom act")


def pitman_le() -> Scene:
    """A dam break with slip and a jump of phi, where the fluid momentum equations of the two models differ."""
    return Scene((-5.0, 5.0), t_end=0.5, name="pitman-le",
                 initial=two_states({"h": 2.0, "phi": 0.6, "vs": 0.0, "vf": 1.5}, {"h": 1.5, "phi": 0.3, "vs": 0.5, "vf": -0.3}),
                 description="dam break with slip on both sides and a jump of phi: the fluid momentum of "
                 "PitmanLe and of TwoPhase differ; they agree where phi is uniform and vs = vf")


def internal_jump() -> Scene:
    """T4: a jump of the interface alone, carried by a uniform current."""
    left, right = layers(0.5, 0.5, 2.5, 2.5), layers(0.55, 0.45, 2.5, 2.5)
    return Scene((-1.0, 3.0), t_end=0.8, g=10.0, gamma=0.98, initial=two_states(left, right), name="internal-jump",
                 description="for TwoLayer: jump of the interface below a level surface in a current of 2.5 m/s (Abgrall and "
                 "Karni; states seen in a public test case, g = 10 from memory, interval and time our own)")


def internal_dam_break() -> Scene:
    """T5: lock exchange of two layers under a level surface."""
    return Scene((-5.0, 5.0), t_end=float(np.sqrt(10.0)), g=1.0, gamma=0.7, name="internal-dam-break",
                 initial=two_states(layers(1.8, 0.2), layers(0.2, 1.8)),
                 description="for TwoLayer: lower layer 0.2 m | 1.8 m under a level surface, from rest, g = 1 (Berthon et al.; "
                 "seen in a public test case)")


def two_layer_rest(perturbed: bool = False) -> Scene:
    """T6: two layers at rest over a bump; where ``perturbed`` the upper one is 0.05 m thicker on 0.38 < x < 0.42."""
    def flow(x: np.ndarray) -> dict[str, Any]:
        thicker = np.where(np.abs(x - 0.4) < 0.02, 0.05, 0.0) if perturbed else 0.0
        return layers(0.1 + thicker, 0.5 - _bump(x))

    return Scene((0.0, 1.0), t_end=10.0, g=1.0, gamma=0.9, initial=flow, bottom=_bump, boundary=Periodic(), name="two-layer-rest",
                 reference=None if perturbed else still(flow),
                 description="for TwoLayer: 0.1 m on a level interface at 0.5 m over a bump of 0.4 m, "
                 f"{'upper layer 0.05 m thicker on 0.38 < x < 0.42' if perturbed else 'at rest'}, g = 1 (seen in a "
                 "public test case)")


def two_layer_step() -> Scene:
    """T7: dam break of both layers at a step of the bottom."""
    return Scene((0.0, 20.0), t_end=1.0, gamma=0.9, initial=two_states(layers(2.0, 2.0), layers(1.5, 1.0), 10.0),
                 bottom=Step(10.0, 0.0, 0.5), name="two-layer-step",
                 description="for TwoLayer: interface 2 m | 1.5 m, surface 4 m | 3 m, bottom 0 | 0.5 m, from rest (levels seen "
                 "in a public test case, interval and time chosen here)")


def layers(above: Any, below: Any, v_above: float = 0.0, v_below: float = 0.0) -> dict[str, Any]:
    """Return h, phi, vs, vf of an upper and a lower layer, depths in m, velocities in m/s."""
    return {"h": above + below, "phi": below / (above + below), "vs": v_below, "vf": v_above}


def _bump(x: np.ndarray) -> np.ndarray:
    return np.where(np.abs(x - 0.5) <= 0.1, 0.2 * (np.cos(10.0 * np.pi * (x - 0.5)) + 1.0), 0.0)


MODEL_SCENES: dict[str, Callable[[], Scene]] = {
    "slip-over-bottom": slip_over_bottom,
    "pitman-le": pitman_le, "internal-jump": internal_jump, "internal-dam-break": internal_dam_break,
    "two-layer-rest": two_layer_rest, "two-layer-step": two_layer_step,
}
