"""Ctrl-C during a study, which makes many runs: the study ends, and what was done is not lost."""

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any

from fvkit.output.solution import Solution
from fvkit.output.status import Status


def uninterrupted(solution: Solution) -> Solution:
    """Return the solution of a run that ended by itself; raise KeyboardInterrupt where the user ended it."""
    if solution.status is Status.INTERRUPTED:
        raise KeyboardInterrupt
    return solution


@contextmanager
def keeping(result: Callable[[], Any]) -> Iterator[None]:
    """Let the KeyboardInterrupt that ends a study carry what was done so far as its attribute ``result``, None for nothing."""
    try:
        yield
    except KeyboardInterrupt as error:
        error.result = result()  # type: ignore[attr-defined]  # for who asked for the study
        raise
