"""Studies: runs that are compared with each other."""

from fvkit.study.report import Report, environment

__all__ = ["Report", "environment"]
