"""Cautions for coefficients that are allowed, but look like an inverse or another unit."""

import warnings
from typing import Any

import numpy as np


def caution(source: Any, name: str, least: float, most: float, mistake: str) -> None:
    """Warn where a number, or cell averages, of a source or another part lie outside of least..most, of the likely ``mistake``
    and its fix; a function of x is not looked at.
    """
    value = getattr(source, name)
    strange = np.array([] if callable(value) else [item for item in np.ravel(value) if not least <= item <= most])
    if strange.size:
        warnings.warn(f"`{name}` of {type(source).__name__} is {strange[0]:g}, and plausible from {least:g} to {most:g}: "
                      f"{mistake}", UserWarning, stacklevel=6)
