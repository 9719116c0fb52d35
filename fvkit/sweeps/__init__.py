"""Sweeps: one function, many samples of its parameters, on any executor."""

from fvkit.sweeps.outputs import Keep
from fvkit.sweeps.result import SweepResult
from fvkit.sweeps.samples import Samples
from fvkit.sweeps.sweep import sweep

__all__ = ["Keep", "Samples", "SweepResult", "sweep"]
