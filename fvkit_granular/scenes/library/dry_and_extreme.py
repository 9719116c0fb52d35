"""Hard scenes: dry ground, emerged terrain, absent phases, stiff drag, lost hyperbolicity, fast and tiny flows."""

from collections.abc import Callable
from functools import partial
from typing import Any

import numpy as np

from fvkit import Periodic, Wall
from fvkit_granular.scenes.reference import FunctionReference, one_velocity, still
from fvkit_granular.scenes.scene import Scene, two_states
from fvkit_granular.scenes.shaped_flow import ShapedFlow
from fvkit_granular.scenes.shapes import Block
from fvkit_granular.sources.drag_laws import ConstantDrag

#: Solid fraction where it is uniform.
PHI = 0.6

#: (h, phi) left and right of 0, from rest.
ABSENT = {
    "absent-solid": ((1.0, 0.6), (1.0, 0.0)), "absent-fluid": ((1.0, 0.6), (1.0, 1.0)), "pure-phases": ((2.0, 1.0), (1.0, 0.0)),
    "mixture-on-dry": ((3.0, 0.7), (0.0, 0.0)), "solid-on-dry": ((0.0, 0.0), (2.0, 1.0)),
    "fluid-on-dry": ((2.0, 0.0), (0.0, 0.0)), "mixture-on-nothing": ((3.0, 0.7), (1e-300, 0.3)),
}


#: Riemann problems of shallow water with uniform phi: depths, speeds, half of the interval, end time and description.
DAM_BREAKS: dict[str, tuple[tuple[float, float], tuple[float, float], float, float, str]] = {
    "dry-dam-break": ((1.0, 0.0), (0.0, 0.0), 5.0, 0.5,
                      "Ritter's dam break of 1 m onto dry ground, uniform phi = 0.6 (classical)"),
    "double-rarefaction": ((1.0, 1.0), (-8.0, 8.0), 5.0, 0.3,
                           "two streams part at 8 m/s and leave dry ground between them"),
    "transonic": ((10.0, 0.5), (0.0, 0.0), 8.0, 0.5, "dam break 10 m | 0.5 m whose fan passes the sonic point (classical)"),  # E3
    "expansion-shock": ((2.0, 1.0), (np.sqrt(3.0 * 9.81) / 2.0, np.sqrt(3.0 * 9.81)), 5.0, 0.5, "a jump from 2 m to 1 m with "
                        "equal fluxes on both sides, which opens into a fan"),
    "froude-50": ((1.0, 1.0), (50.0 * np.sqrt(9.81), 0.8 * (50.0 * np.sqrt(9.81))), 20.0, 0.05,
                  "two streams at Froude numbers 50 and 40 collide"),
    "tiny-depth": ((1.0, 1e-300), (0.0, 0.0), 5.0, 0.5, "dam break of 1 m onto a film of 1e-300 m"),
}


def dam_break(name: str) -> Scene:
    """One of ``DAM_BREAKS`` and its exact solution."""
    depths, speeds, half, t_end, description = DAM_BREAKS[name]
    left, right = ({"h": depth, "phi": PHI, "vs": speed, "vf": speed} for depth, speed in zip(depths, speeds, strict=True))
    return Scene((-half, half), t_end, two_states(left, right), name=name, description=description,
                 reference=partial(one_phase_riemann, depths, speeds, PHI))


def one_phase_riemann(depths: tuple[float, float], speeds: tuple[float, float], phi: float, scene: Scene) -> FunctionReference:
    """Return the exact solution of a Riemann problem with uniform phi and one velocity; films below 1e-200 m count as dry."""
    from fvkit_granular import exact

    left, right = ((depth if depth > 1e-200 else 0.0, speed) for depth, speed in zip(depths, speeds, strict=True))
    solved = exact.shallow_water_riemann(left, right, g=scene.g)

    return FunctionReference("exact", "Riemann solution of shallow water: exact where phi is uniform and vs = vf",
                             at=lambda x, t: one_velocity(solved.at(x, t), phi))


def island(emerged: str = "hump") -> Scene:
    """A lake at rest around emerged ground: a ``"hump"`` in treads of 2 cm, so that on multiples of 100 cells none is wet in
    part, or a block, ``"step"``.
    """
    def treads(x: np.ndarray) -> np.ndarray:
        return 1.2 * np.exp(-(((np.floor(50.0 * x) / 50.0 - 0.99) / 0.25) ** 2))

    bottom = treads if emerged == "hump" else Block(1.0, 0.28, 1.3)
    flow = ShapedFlow(surface=1.0, phi=PHI, bottom=bottom)
    name = "island" if emerged == "hump" else "island-step"
    return Scene((0.0, 2.0), 2.0, flow, bottom=bottom, boundary=Wall(), name=name,
                 reference=still(flow, bottom),
                 description=f"lake of 1 m around an emerged {'hump' if emerged == 'hump' else 'block of 1.3 m'} (classical)")


def thacker() -> Scene:
    """E8: a plane surface that rocks in a parabolic basin, for two periods."""
    from fvkit_granular import exact

    solved = exact.thacker_basin()

    def at(x: np.ndarray, t: float) -> dict[str, Any]:
        return one_velocity(solved.at(x, t), PHI)

    return Scene((0.0, 4.0), 2.0 * solved.period, lambda x: at(x, 0.0), bottom=solved.bottom, boundary=Wall(), name="thacker",
                 reference=FunctionReference("exact", "Thacker's planar surface: exact for uniform phi and one velocity", at=at),
                 description="plane surface rocking in a parabolic basin, two periods, moving shores (Thacker; SWASHES 4.2.1, "
                 "amplitude from memory)")


def lost_hyperbolicity() -> Scene:
    """Slip inside the complex range on part of the domain."""
    def flow(x: np.ndarray) -> dict[str, Any]:
        ripples = 0.02 * np.sin(2.0 * np.pi * x) + 0.01 * np.sin(10.0 * np.pi * x)
        return {"h": 1.0, "phi": PHI + ripples, "vs": np.where(np.abs(x - 0.5) < 0.2, 4.0, 0.0), "vf": 0.0}

    return Scene((0.0, 1.0), 0.3, flow, boundary=Periodic(), name="lost-hyperbolicity",
                 description="slip of 4 m/s, where characteristic speeds are complex, on 40 % of a periodic domain: "
                 "the problem is ill-posed, the run must stay bounded")


def stiff_drag() -> Scene:
    """R2 with drag so strong that the phases move together."""
    def reference(scene: Scene) -> FunctionReference:
        from fvkit_granular import exact

        solved = exact.reduced_riemann((3.0, 0.7, 0.0), (2.0, 0.4, 0.0), g=scene.g, gamma=scene.gamma)
        return FunctionReference("exact", "Riemann solution of the reduced model, the limit of strong drag",
                                 at=lambda x, t: one_velocity(solved.at(x, t), solved.at(x, t)["phi"]))

    return Scene((-5.0, 5.0), 0.5, two_states({"h": 3.0, "phi": 0.7}, {"h": 2.0, "phi": 0.4}), sources=ConstantDrag(D=1e8),
                 reference=reference, name="stiff-drag",
                 description="dam break with a jump of phi and drag of 1e8 1/s: the reduced model's solution")


def absent(name: str) -> Scene:
    """A Riemann problem from rest in which a phase, or everything, is absent on one side; Ritter's where one side is dry."""
    (hl, phil), (hr, phir) = ABSENT[name]
    ritter = partial(one_phase_riemann, (hl, hr), (0.0, 0.0), phil if hl > hr else phir)
    return Scene((-5.0, 5.0), 0.3, two_states({"h": hl, "phi": phil}, {"h": hr, "phi": phir}), name=name,
                 reference=ritter if min(hl, hr) < 1e-200 else None,
                 description=f"(h, phi) = ({hl:g}, {phil:g}) | ({hr:g}, {phir:g}) from rest: absent phases")


HARD_SCENES: dict[str, Callable[[], Scene]] = {
    "island": island, "island-step": partial(island, "step"), "thacker": thacker,
    **{name: partial(dam_break, name) for name in DAM_BREAKS}, "lost-hyperbolicity": lost_hyperbolicity,
    "stiff-drag": stiff_drag, **{name: partial(absent, name) for name in ABSENT},
}
