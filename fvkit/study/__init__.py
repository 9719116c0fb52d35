"""Studies: runs that are compared with each other."""

from fvkit.study.convergence import convergence
from fvkit.study.orders import Convergence, OrderError
from fvkit.study.report import Report, environment

__all__ = ["Convergence", "OrderError", "Report", "convergence", "environment"]
