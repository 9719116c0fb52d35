"""How long the next run of a series will take."""

from collections.abc import Sequence
from math import log


def predicted(cells: int, done: Sequence[tuple[int, float]]) -> float:
    """Return the seconds of a run with ``cells`` cells, to judge by coarser runs.

    Cost grows with N^2, on coarse grids, where each step costs the same, with N: the growth between the two finest runs
    counts, held within 1 and 2; where there is but one run, N.

    Parameters
    ----------
    done : (cells, seconds) of coarser runs, any number of them.
    """
    known = sorted(done)
    if not known:
        return 0.0
    power, (finest, seconds) = 1.0, known[-1]
    if len(known) > 1:
        before, less = known[-2]
        power = min(max(log(seconds / less) / log(finest / before), 1.0), 2.0)
    return seconds * (cells / finest) ** power
