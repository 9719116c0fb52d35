"""Slopes that a grid resolves: cliffs and walls, one face high, are none."""

import numpy as np

from fvkit.pointwise import least


def resolved_steps(values: np.ndarray) -> np.ndarray:
    """Return, for each cell but the first and the last along the last axis, the smaller of its differences to both neighbours,
    (..., n - 2); 0 where these have different signs.

    A slope over several cells is the same step again and again; a cliff is a step at one face, and 0 here.
    """
    before, after = np.diff(values)[..., :-1], np.diff(values)[..., 1:]
    return np.where(before * after > 0.0, np.sign(before) * np.minimum(np.abs(before), np.abs(after)), 0.0)


def end_step(values: np.ndarray) -> float:
    """Return how much lower the ground goes on beyond an end, per cell, from its cell averages, inwards: the first step, at most
    twice the next one, and 0 where these have different signs. Negative where it rises outwards.
    """
    near = values[:3]
    if len(near) < 3:
        return 0.0
    (step,) = least((near[1] - near[0],), (2.0 * (near[2] - near[1]),))
    return float(step)


def end_slope(values: np.ndarray) -> float:
    """Return how much the ground falls outwards at an end, per cell, from its cell averages inwards: the median of five steps."""
    return float(np.median(np.diff(values[:6])))
