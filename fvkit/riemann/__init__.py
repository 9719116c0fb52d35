"""Riemann solvers: how the jump at a face becomes waves."""

from fvkit.riemann.base import RiemannSolver
from fvkit.riemann.hll import HLL
from fvkit.riemann.pyclaw import PyClawRiemann
from fvkit.riemann.roe import Roe
from fvkit.riemann.rusanov import Rusanov

__all__ = ["HLL", "PyClawRiemann", "RiemannSolver", "Roe", "Rusanov"]
