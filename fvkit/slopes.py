"""Slopes that a grid resolves: cliffs and walls, one face high, are none."""

import numpy as np


def resolved_steps(values: np.ndarray) -> np.ndarray:
    """Return, for each cell but the first and the last, the smaller of its differences to both neighbours, (n - 2,); 0 where
    these have different signs.

    A slope over several cells is the same step again and again; a cliff is a step at one face, and 0 here.
    """
    before, after = np.diff(values)[:-1], np.diff(values)[1:]
    return np.where(before * after > 0.0, np.sign(before) * np.minimum(np.abs(before), np.abs(after)), 0.0)
