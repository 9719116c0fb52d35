"""Riemann solvers: how the jump at a face becomes waves."""

from fvkit.riemann.base import RiemannSolver
from fvkit.riemann.hll import HLL
from fvkit.riemann.roe import Roe
from fvkit.riemann.rusanov import Rusanov

__all__ = ["HLL", "RiemannSolver", "Roe", "Rusanov"]
