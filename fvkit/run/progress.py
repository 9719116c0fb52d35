"""Progress bars of runs and sweeps on stderr: tqdm if installed, else one line of text."""

import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from time import perf_counter
from typing import Any

from fvkit.validation import shown

#: Units of a wall time, s, from the longest on, each for times from its size on.
UNITS = ((3.156e7, "years"), (86400.0, "days"), (3600.0, "h"), (60.0, "min"), (1.0, "s"))

Update = Callable[[float, int], None]
Progress = bool | Callable[[float], None]


def checked(progress: Any) -> Progress:
    """Return the argument ``progress`` of runs and sweeps, or raise TypeError."""
    if not (isinstance(progress, bool) or callable(progress)):
        raise TypeError(f"`progress` must be True, False or a function of the share done, got {shown(progress)}")
    return progress


@contextmanager
def reporter(progress: Progress, start: float, end: float) -> Iterator[Update]:
    """Yield a function of (t, steps) that shows the progress of a run, at most about ten times a second."""
    if progress is False:
        yield lambda t, steps: None
        return
    with _shown(progress, end - start, "t", "{n:.4g}/{total:.4g} s") as show:
        began, before = perf_counter(), (start, 0)
        last = began

        def report(t: float, steps: int) -> None:
            nonlocal last, before
            now = perf_counter()
            if now - last > 0.1 or t >= end:
                last, taken = now, steps - before[1]
                dt = f", dt {(t - before[0]) / taken:.3g} s" if taken else ""
                before = (t, steps)
                left = f", about {duration((now - began) * (end - t) / (t - start))} left" if start < t < end else ""
                show(t - start, f"{steps} steps{dt}", left)

        yield report


@contextmanager
def counter(progress: Progress, total: int, unit: str) -> Iterator[Callable[[int], None]]:
    """Yield a function of the number of finished members that shows the progress of a sweep."""
    if progress is False:
        yield lambda done: None
        return
    with _shown(progress, total, unit, "{n_fmt}/{total_fmt}") as show:
        yield lambda done: show(done, "", "")


@contextmanager
def _shown(progress: Progress, total: float, label: str, amount: str) -> Iterator[Callable[[float, str, str], None]]:
    """Yield a function of (amount done, text, time left) that updates the progress bar, the line or the user's function.

    The bar of tqdm estimates the time left itself.
    """
    if callable(progress):
        yield lambda done, words, left: progress(done / total if total > 0.0 else 1.0)
        return
    bar = _bar(total, label, amount)
    if bar is None:
        yield lambda done, words, left: _line(done / total if total > 0.0 else 1.0, words + left)
        print(file=sys.stderr)
        return
    with bar:
        def show(done: float, words: str, left: str) -> None:
            bar.set_postfix_str(words, refresh=False)
            bar.update(done - bar.n)

        yield show


def _bar(total: float, label: str, amount: str) -> Any:
    """Return a progress bar of tqdm, for a terminal or a notebook; None if tqdm is not installed."""
    try:
        from tqdm.auto import tqdm
    except ImportError:
        return None
    shape = "{desc} {percentage:3.0f}% |{bar}| " + amount + " [{elapsed}<{remaining}{postfix}]"
    return tqdm(total=total, desc=label, bar_format=shape, file=sys.stderr)


def _line(share: float, words: str) -> None:
    print(f"\r{'#' * int(40 * share):.<40} {100 * share:5.1f} % {words}", end="", file=sys.stderr, flush=True)


def duration(seconds: float) -> str:
    """Return a wall time in the unit that suits it: s, min, h, days or years."""
    size, unit = next((pair for pair in UNITS if seconds >= pair[0]), UNITS[-1])
    return f"{seconds / size:{'.2g' if seconds < 10.0 * size else '.0f'}} {unit}"
