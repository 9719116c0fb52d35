"""fvkit_granular: two-phase (solid and fluid) shallow granular flows, for fvkit."""

from fvkit_granular import exact, scenes
from fvkit_granular.compare import compare
from fvkit_granular.drag import ConstantDrag
from fvkit_granular.reduced import Reduced
from fvkit_granular.scene import FunctionReference, Reference, Scene, SelfConverged
from fvkit_granular.scenes import scene, scene_names
from fvkit_granular.shallow_water import ShallowWater
from fvkit_granular.two_phase import TwoPhase

__all__ = [
    "ConstantDrag", "FunctionReference", "Reduced", "Reference", "Scene", "SelfConverged", "ShallowWater", "TwoPhase", "compare",
    "exact", "scene", "scene_names", "scenes",
]
