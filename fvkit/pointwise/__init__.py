"""Pointwise code: the language in which models, solvers, limiters and sources are written once for both backends."""

from fvkit.pointwise.functions import (
    CHUNK,
    TINY,
    add,
    combine,
    dot,
    known,
    largest_share,
    least,
    maximum,
    minimum,
    multiply,
    scale,
    subtract,
    weighted,
    where,
)
from fvkit.pointwise.rare import rarely

__all__ = ["CHUNK", "TINY", "add", "combine", "dot", "known", "largest_share", "least", "maximum", "minimum", "multiply",
           "rarely", "scale", "subtract", "weighted", "where"]
