"""fvkit_granular: two-phase (solid and fluid) shallow granular flows, for fvkit."""

from fvkit_granular.reduced import Reduced
from fvkit_granular.shallow_water import ShallowWater
from fvkit_granular.two_phase import TwoPhase

__all__ = ["Reduced", "ShallowWater", "TwoPhase"]
