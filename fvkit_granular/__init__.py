"""fvkit_granular: two-phase (solid and fluid) shallow granular flows, for fvkit."""

from importlib import import_module
from typing import TYPE_CHECKING, Any

from fvkit_granular import scenes
from fvkit_granular.boundaries import FixedLevel, GivenFlow, Hydrograph, UniformSlope
from fvkit_granular.models.pitman_le import PitmanLe
from fvkit_granular.models.reduced import Reduced
from fvkit_granular.models.relaxation import Relaxation
from fvkit_granular.models.shallow_water import ShallowWater
from fvkit_granular.models.slope import SteepSlopeWarning
from fvkit_granular.models.two_layer import TwoLayer
from fvkit_granular.models.two_phase import TwoPhase
from fvkit_granular.observers.front import Front
from fvkit_granular.observers.hazard import HazardMaps
from fvkit_granular.observers.run_out import RunOut
from fvkit_granular.scenes import shapes
from fvkit_granular.scenes.library.catalogue import scene, scene_names
from fvkit_granular.scenes.profile import Profile
from fvkit_granular.scenes.reference import FunctionReference, Reference, SelfConverged
from fvkit_granular.scenes.scene import Scene
from fvkit_granular.scenes.shaped_flow import ShapedFlow
from fvkit_granular.scenes.toml.read import load_scene
from fvkit_granular.scenes.toml.write import scene_text
from fvkit_granular.scenes.watch import Watch
from fvkit_granular.sources.curvature import Curvature
from fvkit_granular.sources.drag import Drag
from fvkit_granular.sources.drag_laws import ConstantDrag, PitmanLeDrag, VelocityDrag
from fvkit_granular.sources.friction import BasalFriction
from fvkit_granular.sources.friction_laws import CoulombFriction, Manning, Voellmy
from fvkit_granular.sources.rain import Drain, Rain
from fvkit_granular.studies.advise import Advice, advise
from fvkit_granular.studies.advise_terrain import TerrainAdvice
from fvkit_granular.studies.compare import compare
from fvkit_granular.studies.mass_balance import MassBalance, mass_balance
from fvkit_granular.studies.scene_run import SceneRun
from fvkit_granular.terrain.hydrograph import read_hydrograph
from fvkit_granular.terrain.outline import OutlineScore, compare_outline
from fvkit_granular.terrain.parameter import read_parameter
from fvkit_granular.terrain.path import read_path
from fvkit_granular.terrain.rasters import read_terrain, write_raster
from fvkit_granular.terrain.release import Release, read_release
from fvkit_granular.terrain.terrain import Terrain

if TYPE_CHECKING:
    from fvkit_granular import exact, plots
    from fvkit_granular.exact.moving_equilibrium import MovingEquilibrium, steady
    from fvkit_granular.terrain.maps import draw_map

__all__ = [
    "Advice", "BasalFriction", "ConstantDrag", "CoulombFriction", "Curvature", "Drag", "Drain", "FixedLevel", "Front",
    "FunctionReference", "GivenFlow", "HazardMaps", "Hydrograph", "Manning", "MassBalance", "MovingEquilibrium", "OutlineScore",
    "PitmanLe", "PitmanLeDrag", "Profile", "Rain", "Reduced", "Reference", "Relaxation", "Release", "RunOut", "Scene",
    "SceneRun", "SelfConverged", "ShallowWater", "ShapedFlow", "SteepSlopeWarning", "Terrain", "TerrainAdvice", "TwoLayer",
    "TwoPhase", "UniformSlope", "VelocityDrag", "Voellmy", "Watch", "advise", "compare", "compare_outline", "draw_map", "exact",
    "load_scene", "mass_balance", "plots", "read_hydrograph", "read_parameter", "read_path", "read_release", "read_terrain",
    "scene", "scene_names", "scene_text", "scenes", "shapes", "steady", "write_raster",
]


def __getattr__(name: str) -> Any:
    """Import `exact` and scipy, or `plots`, `draw_map` and matplotlib, when they are first used."""
    if name in ("MovingEquilibrium", "steady"):
        return getattr(import_module("fvkit_granular.exact.moving_equilibrium"), name)
    if name == "draw_map":
        return import_module("fvkit_granular.terrain.maps").draw_map
    if name in ("exact", "plots"):
        return import_module(f"fvkit_granular.{name}")
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
