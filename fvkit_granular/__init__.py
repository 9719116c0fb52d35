"""fvkit_granular: two-phase (solid and fluid) shallow granular flows, for fvkit."""

from typing import TYPE_CHECKING, Any

from fvkit_granular import scenes, shapes
from fvkit_granular.advise import Advice, advise
from fvkit_granular.columns import Profile
from fvkit_granular.compare import compare
from fvkit_granular.drag import ConstantDrag, Drag, PitmanLeDrag, VelocityDrag
from fvkit_granular.friction import BasalFriction, CoulombFriction, Manning, Voellmy
from fvkit_granular.front import Front
from fvkit_granular.given_flow import GivenFlow
from fvkit_granular.inflow import Hydrograph
from fvkit_granular.outflow import Stage, UniformSlope
from fvkit_granular.pitman_le import PitmanLe
from fvkit_granular.rain import Rain
from fvkit_granular.reduced import Reduced
from fvkit_granular.relaxation import Relaxation
from fvkit_granular.scene import FunctionReference, Reference, Scene, SelfConverged
from fvkit_granular.scene_file import load_scene
from fvkit_granular.scene_run import SceneRun
from fvkit_granular.scene_text import scene_text
from fvkit_granular.scenes import scene, scene_names
from fvkit_granular.shallow_water import ShallowWater
from fvkit_granular.shaped_flow import ShapedFlow
from fvkit_granular.slope import SteepSlopeWarning
from fvkit_granular.steady import MovingEquilibrium, steady
from fvkit_granular.two_layer import TwoLayer
from fvkit_granular.two_phase import TwoPhase

if TYPE_CHECKING:
    from fvkit_granular import exact, pictures

__all__ = [
    "Advice", "BasalFriction", "ConstantDrag", "CoulombFriction", "Drag", "Front", "FunctionReference", "GivenFlow", "Hydrograph",
    "Manning", "MovingEquilibrium", "PitmanLe", "PitmanLeDrag", "Profile", "Rain", "Reduced", "Reference", "Relaxation", "Scene",
    "SceneRun", "SelfConverged", "ShallowWater", "ShapedFlow", "Stage", "SteepSlopeWarning", "TwoLayer", "TwoPhase",
    "UniformSlope", "VelocityDrag", "Voellmy", "advise", "compare", "exact", "load_scene", "pictures", "scene", "scene_names",
    "scene_text", "scenes", "shapes", "steady",
]


def __getattr__(name: str) -> Any:
    """Import `exact` and scipy, or `pictures` and matplotlib, when they are first asked for."""
    if name in ("exact", "pictures"):
        from importlib import import_module

        return import_module(f"fvkit_granular.{name}")
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
