"""Prediction of the run time on a finer grid from coarser runs."""

from collections.abc import Sequence
from math import log


def predicted(cells: int, done: Sequence[tuple[int, float]], axes: int = 1) -> float:
    """Return the predicted run time with ``cells`` cells along each axis, s, from coarser runs (cells, s); 0 without any.

    The time grows like N^(axes + 1) on fine grids and like N on coarse grids, where the cost of a step does not depend on N. The
    exponent is that between the two finest runs, limited to [1, axes + 1], or ``axes`` for a single run.
    """
    known = sorted(done)
    if not known:
        return 0.0
    power, (finest, seconds) = float(axes), known[-1]
    if len(known) > 1:
        before, less = known[-2]
        power = min(max(log(seconds / less) / log(finest / before), 1.0), axes + 1.0)
    return seconds * (cells / finest) ** power
