"""Built-in scenes with two axes: basins, vortices, circular dam breaks, islands, a column of grains.

Where phi is uniform and both phases move alike, solutions of shallow water hold for every model.
"""

from collections.abc import Callable
from functools import partial
from typing import Any

import numpy as np

from fvkit import Periodic, Wall
from fvkit_granular.scenes.library.dry_and_extreme import PHI
from fvkit_granular.scenes.library.friction import AIR
from fvkit_granular.scenes.reference import FunctionReference, one_velocity, still
from fvkit_granular.scenes.scene import Scene
from fvkit_granular.scenes.shaped_flow import ShapedFlow
from fvkit_granular.scenes.shapes import Block, Gaussian, PiecewiseLinear, Step
from fvkit_granular.sources.drag_laws import ConstantDrag
from fvkit_granular.sources.friction_laws import CoulombFriction


def _followed(solved: Any, half: float, t_end: float, detail: str, **settings: Any) -> Scene:
    """A scene that starts as a solution with one velocity, on a square around the origin, and is measured against it."""
    def at(x: np.ndarray, y: np.ndarray, t: float) -> dict[str, Any]:
        return one_velocity(solved.at(x, y, t), PHI)

    return Scene(((-half, -half), (half, half)), t_end, lambda x, y: at(x, y, 0.0), g=solved.g,
                 reference=FunctionReference(solved.kind, detail, at=at), **settings)


def thacker(motion: str) -> Scene:
    """A rotating plane surface, or an oscillating paraboloid, in a round parabolic basin, for one period."""
    from fvkit_granular import exact

    solved = exact.ThackerBowl(motion, h0=0.08)
    what = "rotating plane surface" if motion == "rotating" else "oscillating paraboloid"
    return _followed(solved, 2.0, solved.period, f"Thacker's {what}: exact for uniform phi and one velocity",
                     bottom=solved.bottom, name=f"thacker-{motion}",
                     description=f"{what} in a round parabolic basin, one period, a moving shore (Thacker 1981)")


def vortex(drift: float = 0.0) -> Scene:
    """A vortex of shallow water on a periodic square.

    Parameters
    ----------
    drift : velocity of all along both axes, m/s.
    """
    from fvkit_granular import exact

    solved = exact.Vortex(centre=(0.0, 0.0), drift=(drift, drift), period=(1.0, 1.0))
    stands = drift == 0.0
    how = "standing still" if stands else f"carried along the diagonal with {drift:g} m/s along each axis"
    return _followed(solved, 0.5, 0.5 if stands else 1.0, "vortex of shallow water: exact for uniform phi and one velocity",
                     boundary=Periodic(), name="vortex" if stands else "travelling-vortex",
                     description=f"vortex of 1 m/s and radius 0.1 m, {how}, periodic, uniform phi = 0.6 (derived here)")


def two_phase_vortex() -> Scene:
    """A steady vortex of two phases with slip over a bottom."""
    from fvkit_granular import exact

    solved = exact.TwoPhaseVortex()
    return Scene(((-6.0, -6.0), (6.0, 6.0)), 0.5, solved.at, bottom=solved.bottom, boundary=Periodic(), g=solved.g,
                 gamma=solved.gamma, name="two-phase-vortex",
                 reference=FunctionReference("exact", "the initial state at all times: each phase is in balance on its own",
                                             at=solved.at),
                 description="steady vortex of two phases with slip, over a hump of 5 cm, of the full model (derived here)")


def radial_dam_break(outside: float = 0.5) -> Scene:
    """A circular dam break; the depth ``outside`` of the dam in m."""
    from fvkit_granular import exact

    solved = exact.RadialDamBreak(outside=outside)
    dry = outside == 0.0
    return _followed(solved, 5.0, 0.2 if dry else 0.5, "shallow water along the radius, N = 1000 on that of the dam; "
                     "its own relative L1 error of h is below 1e-3", name="radial-dam-break" + "-dry" * dry,
                     description=f"circular dam break of 2 m, radius 2.5 m, {'onto dry ground' if dry else f'into {outside:g} m'}"
                     ", uniform phi = 0.6 (classical)")


def dam_break_round_island() -> Scene:
    """A dam of mixture that breaks into thin mud with a conical island."""
    cone = PiecewiseLinear([(0.0, 0.8), (3.2, 0.0)], over=(12.0, 5.0))
    flow = ShapedFlow(surface=Step(5.0, 2.0, 0.4), phi=Step(5.0, PHI, 0.1))
    return Scene(((0.0, 0.0), (20.0, 10.0)), 3.0, flow, bottom=cone,
                 boundary=Wall(), sources=ConstantDrag(5.0), name="dam-break-island", times=(0.5, 1.0, 1.5, 2.0, 2.5, 3.0),
                 description="2 m of mixture, phi = 0.6, break into 0.4 m of thin mud, phi = 0.1, around a conical island, drag "
                 "of 5 1/s")


def lake() -> Scene:
    """A lake at rest with two islands, a hill and a tower."""
    ground = Gaussian(0.0, 5.0, 1.3, over=(8.0, 5.0)) + Block(0.0, 1.5, 1.5, over=(16.0, 8.0))
    flow = ShapedFlow(surface=1.0, phi=PHI, bottom=None)
    return Scene(((0.0, 0.0), (20.0, 12.0)), 2.0, flow, bottom=ground, boundary=Wall(), name="lake-with-islands",
                 reference=still(flow, ground),
                 description="lake of 1 m around a hill and a tower that emerge (classical): stays at rest")


def circular_collapse() -> Scene:
    """A column of dry grains that collapses and comes to rest."""
    return Scene(((-3.0, -3.0), (3.0, 3.0)), 2.4, ShapedFlow(Block(0.0, 1.0, 1.0, over=(0.0, 0.0)), phi=1.0), gamma=AIR,
                 sources=CoulombFriction(0.5), name="circular-collapse", times=(0.4, 0.8, 1.2, 1.6, 2.0, 2.4),
                 description="column of dry grains, 1 m high and 1 m in radius, nu = 0.5, in air: collapses "
                 "and stops")


PLANE_SCENES: dict[str, Callable[..., Scene]] = {
    "thacker-rotating": partial(thacker, "rotating"), "thacker-paraboloid": partial(thacker, "paraboloid"), "vortex": vortex,
    "travelling-vortex": partial(vortex, 1.0), "two-phase-vortex": two_phase_vortex, "radial-dam-break": radial_dam_break,
    "radial-dam-break-dry": partial(radial_dam_break, 0.0), "dam-break-island": dam_break_round_island,
    "lake-with-islands": lake, "circular-collapse": circular_collapse,
}
