"""`stress`: every hard scene with every model, solver, order and backend, each run judged by what must hold."""

from fvkit_granular.stress.report import StressReport
from fvkit_granular.stress.suite import stress

__all__ = ["StressReport", "stress"]
