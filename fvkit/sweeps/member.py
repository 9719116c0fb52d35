"""Members of a sweep: what a worker runs, and the outcome of each."""

from collections.abc import Callable, Mapping, Sequence
from time import perf_counter
from typing import Any, NamedTuple

import attrs
import numpy as np

from fvkit import validation
from fvkit.output.solution import Solution
from fvkit.output.status import SolveError
from fvkit.run.interruption import uninterrupted
from fvkit.sweeps.outputs import Keep

#: How a member may end, besides the names of `fvkit.Status`: the function raised, the executor never gave an answer, or the
#: sweep was stopped before it ended.
FINISHED, ERROR, LOST, STOPPED = "finished", "error", "lost", "interrupted"

Function = Callable[..., Any]


class MemberResult(NamedTuple):
    """How one member ended, and what it returned: {output: array}, empty where it did not finish."""

    member: int
    status: str
    message: str
    seconds: float
    outputs: dict[str, np.ndarray]


@attrs.frozen
class MemberTask:
    """The function of a sweep and what is kept of its solutions: all that a worker needs."""

    function: Function
    keep: Callable[[Solution], Mapping[str, Any]] = attrs.field(factory=Keep)

    def __call__(self, members: Sequence[tuple[int, Mapping[str, Any]]]) -> list[MemberResult]:
        """Run members (number, parameters) one after the other."""
        return [self.run(number, sample) for number, sample in members]

    def run(self, member: int, sample: Mapping[str, Any]) -> MemberResult:
        """Run one member; whatever it raises becomes its status and message."""
        started = perf_counter()
        outputs: dict[str, np.ndarray] = {}
        try:
            returned = self.function(**sample)
            status, message = FINISHED, ""
            if isinstance(returned, Solution):
                uninterrupted(returned)
                status, message = returned.status.name.lower(), returned.message
                returned = self.keep(returned) if returned.success else {}
            outputs = _numbers(returned)
        except KeyboardInterrupt:
            raise
        except SolveError as error:
            status, message = error.status.name.lower(), str(error)
        except Exception as error:  # a member may raise anything: the others go on
            status, message = ERROR, "; ".join([f"{type(error).__name__}: {error}", *getattr(error, "__notes__", ())])
        return MemberResult(member, status, message, perf_counter() - started, outputs)


def _numbers(returned: Any) -> dict[str, np.ndarray]:
    if not isinstance(returned, Mapping):
        raise TypeError(f"the function of a sweep must return a mapping of numbers and arrays, or a Solution; got {returned!r}")
    result = {}
    for name, value in returned.items():
        array = np.asarray(value)
        if array.dtype.kind not in "biufc":
            raise TypeError(f"output `{name}` must be a number or an array of numbers, got {validation.shown(value)}")
        result[str(name)] = array
    return result
