"""Cautions for coefficients that are allowed, but look like an inverse or another unit."""

import warnings
from typing import Any

import numpy as np

from fvkit import validation


def caution(source: Any, name: str, least: float, most: float, mistake: str) -> None:
    """Warn where a number, or cell averages, of a source or another part lie outside of least..most, of the likely ``mistake``
    and its fix; a function of x is not looked at.
    """
    value = getattr(source, name)
    caution_values([] if callable(value) else value, f"`{name}` of {type(source).__name__}", least, most, mistake)


def caution_values(values: Any, called: str, least: float, most: float, mistake: str) -> None:
    """Warn where a number, or an array, that a message calls ``called`` lies outside of least..most; else see `caution`."""
    strange = [item for item in np.ravel(values) if not least <= item <= most]
    if strange:
        warnings.warn(f"{called} is {strange[0]:g}, and plausible from {least:g} to {most:g}: {mistake}", UserWarning,
                      stacklevel=validation.users_line())
