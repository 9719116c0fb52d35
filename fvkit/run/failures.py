"""Outcome of a run: its status, the first exception, and where it happened."""

from collections.abc import Iterator
from contextlib import contextmanager, suppress

import attrs

from fvkit.output.solution import Solution
from fvkit.output.status import SolveError, Status
from fvkit.run.stepper import Stepper


@attrs.define
class RunOutcome:
    """Outcome of a run: its status and the first exception, None without.

    The message of an exception says what the run was ``doing``; ``notes`` follow it, such as how to continue a failed run.
    """

    stepper: Stepper
    doing: str = "starting"
    status: Status = Status.FINISHED
    failure: Exception | None = None
    notes: list[str] = attrs.field(factory=list)

    @contextmanager
    def watch(self, doing: str) -> Iterator[None]:
        """Context manager that catches and records exceptions; the first one sets status and failure of the run."""
        self.doing = doing
        try:
            yield
        except SolveError as error:
            self._fail(error, error.status)
        except KeyboardInterrupt:
            self._fail(self.stepper.interrupted(), Status.INTERRUPTED)
        except Exception as error:  # user code may raise anything: results are kept, and `solve` raises it at the end
            self.notes.append(f"raised while {self.doing}, at t = {self.stepper.t:.8g}, step {self.stepper.steps}")
            self._fail(error, Status.ERROR)

    def _fail(self, error: Exception, status: Status) -> None:
        if self.failure is None:
            self.failure, self.status = error, status
        elif self.failure is not error:
            self.notes.append(f"then {type(error).__name__}: {error}")

    @property
    def message(self) -> str:
        """Final message of the run, one sentence."""
        if self.failure is None:
            return self.status.value
        first = str(self.failure) if isinstance(self.failure, SolveError) else f"{type(self.failure).__name__}: {self.failure}"
        return "; ".join([first, *self.notes])

    def attach(self, solution: Solution) -> None:
        """Attach the context and the partial solution to the exception."""
        error = self.failure
        if isinstance(error, SolveError):
            error.args = (self.message,)
        elif error is not None:
            with suppress(AttributeError):  # some exceptions do not accept notes
                error.add_note("; ".join(self.notes))
        with suppress(AttributeError):  # an exception may be immutable
            error.solution = solution  # type: ignore[union-attr]  # attribute added to any exception
