"""Progress of a run: silent by default, tqdm's bar where it is installed, one plain line where not."""

import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from time import perf_counter

Report = Callable[[float, int], None]


@contextmanager
def reporter(progress: bool | Callable[[float], None], start: float, end: float) -> Iterator[Report]:
    """Yield a function of (t, steps) that shows how far a run has come, at most about ten times a second."""
    if progress is False:
        yield lambda t, steps: None
        return
    shown = progress if callable(progress) else _line
    last = perf_counter()

    def report(t: float, steps: int) -> None:
        nonlocal last
        now = perf_counter()
        if now - last > 0.1 or t >= end:
            last = now
            shown((t - start) / (end - start) if end > start else 1.0)

    yield report
    if shown is _line:
        print(file=sys.stderr)


def _line(share: float) -> None:
    print(f"\r{'#' * int(40 * share):.<40} {100 * share:5.1f} %", end="", file=sys.stderr, flush=True)
