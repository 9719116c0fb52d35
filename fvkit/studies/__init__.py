"""Studies: runs that are compared with each other."""

from fvkit.studies.convergence import convergence
from fvkit.studies.orders import Convergence, OrderError
from fvkit.studies.report import Report, environment

__all__ = ["Convergence", "OrderError", "Report", "convergence", "environment"]
