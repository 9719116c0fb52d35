"""Registry of limiters, reconstructions, integrators and schemes by name: ``VanLeer`` is ``van-leer`` in reports and commands."""


from fvkit.pointwise.part import by_name
from fvkit.schemes.integrators import ARK4, DP5, SSPRK3, SSPRK104
from fvkit.schemes.limiters import MC, Minmod, NoLimiter, Superbee, ThirdOrder, VanLeer
from fvkit.schemes.method_of_lines import MethodOfLines
from fvkit.schemes.reconstruction import MP5, MUSCL, WENO5
from fvkit.schemes.wave_propagation import WavePropagation

LIMITERS = by_name((NoLimiter, Minmod, MC, Superbee, VanLeer, ThirdOrder))

RECONSTRUCTIONS = by_name((MP5, WENO5, MUSCL))

INTEGRATORS = by_name((SSPRK104, SSPRK3, DP5, ARK4))

METHODS = by_name((WavePropagation, MethodOfLines))
