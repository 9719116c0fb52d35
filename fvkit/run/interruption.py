"""Ctrl-C during a study of many runs: the study ends and its partial results are kept."""

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any

from fvkit.output.solution import Solution
from fvkit.output.status import Status


def uninterrupted(solution: Solution) -> Solution:
    """Return the given solution; raise KeyboardInterrupt if its run was interrupted by Ctrl-C."""
    if solution.status is Status.INTERRUPTED:
        raise KeyboardInterrupt
    return solution


@contextmanager
def keeping(result: Callable[[], Any]) -> Iterator[None]:
    """Context manager that stores the partial result of a study in attribute ``result`` of a KeyboardInterrupt."""
    try:
        yield
    except KeyboardInterrupt as error:
        error.result = result()  # type: ignore[attr-defined]  # read by the caller of the study
        raise
