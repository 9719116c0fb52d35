"""Studies: convergence orders, comparisons of schemes and work-precision."""

from fvkit.studies.convergence import convergence
from fvkit.studies.orders import Convergence, OrderError
from fvkit.studies.report import Report, environment

__all__ = ["Convergence", "OrderError", "Report", "convergence", "environment"]
