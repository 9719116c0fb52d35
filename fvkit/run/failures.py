"""`Fate`: how a run ends, whoever ended it: its scheme, its user, a function of the user's, the disk."""

from collections.abc import Iterator
from contextlib import contextmanager, suppress

import attrs

from fvkit.output.solution import Solution
from fvkit.output.status import SolveError, Status
from fvkit.run.stepper import Stepper


@attrs.define
class Fate:
    """The status of a run, and the first failure, if there is one.

    Parameters
    ----------
    stepper : of the run.
    doing : what goes on now, for the sentence about an exception.
    status, failure : how the run ended so far.
    words : more to say at the end: where a run that failed can be continued.
    """

    stepper: Stepper
    doing: str = "starting"
    status: Status = Status.FINISHED
    failure: Exception | None = None
    words: list[str] = attrs.field(factory=list)

    @contextmanager
    def watch(self, doing: str) -> Iterator[None]:
        """Note what ends the block; only the first failure of a run counts."""
        self.doing = doing
        try:
            yield
        except SolveError as error:
            self._fail(error, error.status)
        except KeyboardInterrupt:
            self._fail(self.stepper.interrupted(), Status.INTERRUPTED)
        except Exception as error:  # a user's function may raise anything: it is passed on, but nothing may be lost
            self.words.append(f"raised while {self.doing}, at t = {self.stepper.t:.8g}, step {self.stepper.steps}")
            self._fail(error, Status.ERROR)

    def _fail(self, error: Exception, status: Status) -> None:
        if self.failure is None:
            self.failure, self.status = error, status
        elif self.failure is not error:
            self.words.append(f"then {type(error).__name__}: {error}")

    @property
    def message(self) -> str:
        """One sentence: how the run ended."""
        if self.failure is None:
            return self.status.value
        first = str(self.failure) if isinstance(self.failure, SolveError) else f"{type(self.failure).__name__}: {self.failure}"
        return "; ".join([first, *self.words])

    def tell(self, solution: Solution) -> None:
        """Let the failure say what is known, and carry the partial solution."""
        error = self.failure
        if isinstance(error, SolveError):
            error.args = (self.message,)
        elif error is not None:
            with suppress(AttributeError):  # an exception that takes nothing is passed on all the same
                error.add_note("; ".join(self.words))
        with suppress(AttributeError):  # an exception may be frozen
            error.solution = solution  # type: ignore[union-attr]  # any exception may carry it
