"""Exact, semi-exact and self-converged reference solutions, each with its kind and accuracy.

================================ ============================================= ============== =============== =================
function                         solves                                        kind           origin          accuracy
================================ ============================================= ============== =============== =================
`shallow_water_riemann`          dam breaks, wet and dry, vacuum               exact          Stoker, Ritter  rounding
`reduced_riemann`                Riemann problem of the reduced model          exact          derived here    rounding
`two_phase_riemann`              Riemann problem of the full model             semi-exact     derived here    1e-10, path given
`path_sensitivity`               spread of its internal shocks over paths      semi-exact     derived here    1e-10
`rarefaction_fans`               full model, fans in all four fields           exact          derived here    1e-10
`simple_wave`                    smooth wave until it breaks                   exact          characteristics 1e-12
`periodic_flow`                  smooth periodic flow, full model              self-converged pseudo-spectral measured, 1e-11
`steady_flow`, `bernoulli_depth` steady flow over a bottom                     exact          Bernoulli       rounding
`gr.steady`                      steady flow of two phases or layers, any slip exact          derived here    1e-12
`uniform_drag`                   decay of the slip in a uniform state          exact          derived here    rounding
`accelerated`                    sliding down a plane with Coulomb friction    as inside      derived here    as inside
`sliding_acceleration`           the acceleration of that motion               exact          derived here    rounding
`block_stop`                     a block that friction stops                   exact          derived here    rounding
`thacker_basin`                  rocking plane in a parabolic basin            exact          Thacker         rounding
`ThackerBowl`                    plane or paraboloid in a round basin          exact          Thacker         rounding
`Vortex`                         vortex of shallow water, also carried along   exact          derived here    rounding
`TwoPhaseVortex`                 vortex of two phases with slip over a bottom  exact          derived here    rounding
`RadialDamBreak`                 circular dam break, wet and dry               self-converged along the rad.  measured, 1e-3
================================ ============================================= ============== =============== =================

The last four are in the plane: their ``at`` takes x, y and t.

Single-velocity solutions are exact for the two-phase model too where phi is uniform and vs = vf: that set
is invariant. States are given as (h, phi, vs, vf), (h, phi, v) or (h, v); every result has ``kind`` and an
``at`` that returns a dict of observables.
"""

from fvkit_granular.exact.bernoulli import bernoulli_depth, critical_depth, steady_flow
from fvkit_granular.exact.drag import UniformDrag, uniform_drag
from fvkit_granular.exact.periodic_flow import PeriodicFlow, periodic_flow
from fvkit_granular.exact.radial import RadialDamBreak
from fvkit_granular.exact.reduced import ReducedRiemann, ReducedState, reduced_riemann
from fvkit_granular.exact.shallow_water import ShallowWaterRiemann, ShallowWaterState, shallow_water_riemann
from fvkit_granular.exact.simple_wave import SimpleWave, hump, simple_wave
from fvkit_granular.exact.sliding import Accelerated, accelerated, block_stop, sliding_acceleration
from fvkit_granular.exact.states import NoFourWaveSolution, TwoPhaseState, Wave
from fvkit_granular.exact.thacker import ThackerBasin, ThackerBowl, thacker_basin
from fvkit_granular.exact.two_phase.fans import RarefactionFans, rarefaction_fans
from fvkit_granular.exact.two_phase.path_sensitivity import path_sensitivity
from fvkit_granular.exact.two_phase.paths import PATHS
from fvkit_granular.exact.two_phase.riemann import TwoPhaseRiemann, TwoPhaseWave, two_phase_riemann
from fvkit_granular.exact.vortex import TwoPhaseVortex, Vortex

__all__ = [
    "PATHS", "Accelerated", "NoFourWaveSolution", "PeriodicFlow", "RadialDamBreak", "RarefactionFans", "ReducedRiemann",
    "ReducedState", "ShallowWaterRiemann", "ShallowWaterState", "SimpleWave", "ThackerBasin", "ThackerBowl",
    "TwoPhaseRiemann", "TwoPhaseState", "TwoPhaseVortex", "TwoPhaseWave", "UniformDrag", "Vortex", "Wave", "accelerated",
    "bernoulli_depth", "block_stop", "critical_depth", "hump", "path_sensitivity", "periodic_flow", "rarefaction_fans",
    "reduced_riemann", "shallow_water_riemann", "simple_wave", "sliding_acceleration", "steady_flow", "thacker_basin",
    "two_phase_riemann", "uniform_drag",
]
