"""Schemes: how a problem is solved."""

from fvkit.schemes.base import Parts, Read, Scheme, Stage
from fvkit.schemes.method_of_lines import MethodOfLines
from fvkit.schemes.wave_propagation import WavePropagation

__all__ = ["MethodOfLines", "Parts", "Read", "Scheme", "Stage", "WavePropagation"]
