"""Backends: who runs the stages of a scheme."""

from fvkit.backends.halo import Plan, plan
from fvkit.backends.numpy_kernel import NumpyKernel, Transport

__all__ = ["NumpyKernel", "Plan", "Transport", "plan"]
