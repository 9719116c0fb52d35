"""Checkpoints: everything that a run needs to go on, in a file that a kill at any moment leaves whole."""

import json
import time as clock
from pathlib import Path
from typing import TYPE_CHECKING, Any

import attrs

from fvkit import _validate
from fvkit.archive import write_archive
from fvkit.configuration import describe, effective
from fvkit.recording import Frames
from fvkit.solution import Status
from fvkit.stopping import Stop

if TYPE_CHECKING:
    from fvkit.stepper import Stepper

#: What the first entry of a file says it is.
FORMAT = "fvkit checkpoint 2"


def _path(value: Any) -> Path:
    path = _validate.file(value, "path")
    if path.suffix != ".npz":
        raise ValueError(f"`path` of a checkpoint must end in .npz, got {path.name!r}")
    return path


def _seconds(value: Any) -> float | None:
    return None if value is None else _validate.real(value, "seconds", at_least=0.0)


@attrs.frozen
class Checkpoint:
    """When and where a run leaves what it needs to go on, see `fvkit.resume`.

    It is written between two steps, at the first pause after it is due (a pause about every 0.1 s), and at the end of the run,
    also one that fails or is stopped. It replaces the one before in one move: a kill while writing leaves that one. It does
    not change the steps of the run by a bit.

    Parameters
    ----------
    path : file, ends in .npz; its folder must exist.
    seconds : wall time between two, s, >= 0; None for none.
    interval : simulated time between two, s; None for none.
    """

    path: Path = attrs.field(converter=_path)
    seconds: float | None = attrs.field(default=60.0, converter=_seconds)
    interval: float | None = _validate.optional_number(above=0.0)

    def __attrs_post_init__(self) -> None:
        if self.path.is_dir():
            raise ValueError(f"`path` of a checkpoint must be a file, got the folder {str(self.path)!r}")
        if not self.path.resolve().parent.is_dir():
            raise ValueError(f"`path` of a checkpoint must be in a folder that exists, got {str(self.path)!r}")


class Saver:
    """Writes the checkpoints of one run."""

    def __init__(self, checkpoint: Checkpoint, stepper: "Stepper", frames: Frames, targets: list[float],
                 stop: Stop | None) -> None:
        self.checkpoint, self._stop = checkpoint, stop
        self._stepper, self._frames, self._targets = stepper, frames, targets
        self._wall, self._t = clock.perf_counter(), stepper.t
        self._last: tuple[float, int] | None = None

    def begin(self) -> None:
        """Replace the file of another run at once: a kill before the first checkpoint must not leave that to be resumed."""
        if self.checkpoint.path.exists():
            self.write()

    def hint(self) -> str:
        """Where the run can go on."""
        path = str(self.checkpoint.path)
        if self._last is None:
            return f"no checkpoint was written: {path} is as it was" if self.checkpoint.path.exists() else \
                f"no checkpoint was written to {path}"
        t, steps = self._last
        if steps == self._stepper.steps:
            return f"fv.resume({path!r}) goes on from here"
        return f"the last checkpoint is of t = {t:.8g}, step {steps}: fv.resume({path!r}) goes on from there"

    def tick(self) -> None:
        """Write a checkpoint if one is due."""
        seconds, interval = self.checkpoint.seconds, self.checkpoint.interval
        if ((seconds is not None and clock.perf_counter() - self._wall >= seconds)
                or (interval is not None and self._stepper.t - self._t >= interval)):
            self.write()

    def write(self) -> None:
        """Write a checkpoint."""
        stepper, frames = self._stepper, self._frames
        problem = stepper.problem
        plan = {"seconds": self.checkpoint.seconds, "interval": self.checkpoint.interval, "nonhyperbolic": stepper.nonhyperbolic,
                "threads": stepper.threads, "length": describe(stepper.length), "stop": describe(self._stop)}
        kept = effective(problem, stepper.scheme, stepper.stats(), Status.INTERRUPTED, "to be continued with fv.resume")
        write_archive(self.checkpoint.path, {
            "format": FORMAT, "t": frames.t, "q": frames.q, "times": self._targets, **stepper.snapshot(),
            **{f"aux_{name}": values for name, values in problem.aux_averages.items()},
            **({} if problem.background is None else {"background": problem.background_averages}),
            "plan": json.dumps(plan), "configuration": json.dumps(kept, allow_nan=False)})
        self._wall, self._t = clock.perf_counter(), stepper.t
        self._last = stepper.t, stepper.steps
