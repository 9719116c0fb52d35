"""Registry of models and Riemann solvers by name."""

from fvkit import HLL, Model, RiemannSolver, Roe, Rusanov
from fvkit.pointwise.part import by_name
from fvkit_granular.models.pitman_le import PitmanLe
from fvkit_granular.models.reduced import Reduced
from fvkit_granular.models.relaxation import Relaxation
from fvkit_granular.models.shallow_water import ShallowWater
from fvkit_granular.models.two_layer import TwoLayer
from fvkit_granular.models.two_phase import TwoPhase

MODELS: dict[str, type[Model]] = by_name((TwoPhase, Reduced, ShallowWater, PitmanLe, TwoLayer))

#: Default models of a comparison: the full model, its strong-drag limit, and shallow water.
COMPARED: dict[str, type[Model]] = by_name((TwoPhase, Reduced, ShallowWater))

RIEMANN: dict[str, type[RiemannSolver]] = by_name((Relaxation, Roe, HLL, Rusanov))
