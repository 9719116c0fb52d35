"""Checkpoints: atomic files from which `fvkit.resume` continues a run."""

import json
import time as clock
import warnings
from collections.abc import Iterable
from pathlib import Path
from typing import Any

import attrs
import numpy as np

from fvkit import validation
from fvkit.output.configuration import describe, effective, fields_of
from fvkit.output.npz import CHECKPOINT, Archive, write_archive
from fvkit.output.status import Status
from fvkit.run.control import Control
from fvkit.run.observers import Observer
from fvkit.run.recording import Snapshots
from fvkit.run.step_bounds import intervals
from fvkit.run.stepper import Stepper


def _path(value: Any) -> Path:
    path = validation.file(value, "path")
    if path.suffix != ".npz":
        raise ValueError(f"`path` of a checkpoint must end in .npz, got {path.name!r}")
    return path


@attrs.frozen
class Checkpoint:
    """Checkpoint settings: file and interval; `fvkit.resume` continues a run from the file.

    A checkpoint is written between two steps, at the first return to Python after it is due (about every 0.1 s), and at the
    end of the run, failed and stopped runs included. Each checkpoint replaces the previous one atomically, so killing the
    process while it writes leaves the previous one. Checkpoints do not change the results of a run.

    Parameters
    ----------
    path : path of the file, ends in .npz; its folder must exist.
    seconds : wall time between two checkpoints, s, >= 0; None for no such interval.
    interval : simulated time between two checkpoints, s; None for no such interval.

    Examples
    --------
    >>> import fvkit as fv
    >>> import fvkit_granular as gr
    >>> from tempfile import TemporaryDirectory
    >>> problem = gr.scene("dam-break").problem(gr.ShallowWater, 50)
    >>> with TemporaryDirectory() as folder:
    ...     checkpoint = fv.Checkpoint(f"{folder}/run.npz")
    ...     part = fv.solve(problem, limits=fv.Limits(steps=5), checkpoint=checkpoint, backend="numpy", throw=False)
    ...     whole = fv.resume(checkpoint.path, limits=fv.Limits())
    >>> part.stats.steps, whole.success
    (5, True)
    """

    path: Path = attrs.field(converter=_path)
    seconds: float | None = validation.field(validation.real, 60.0, optional=True, at_least=0.0)
    interval: float | None = validation.optional_number(above=0.0)

    def __attrs_post_init__(self) -> None:
        if self.path.is_dir():
            raise ValueError(f"`path` of a checkpoint must be a file, got the folder {str(self.path)!r}")
        if not self.path.resolve().parent.is_dir():
            raise ValueError(f"`path` of a checkpoint must be in a folder that exists, got {str(self.path)!r}")


class Saver:
    """Writer of the checkpoints of one run."""

    def __init__(self, checkpoint: Checkpoint, stepper: Stepper, frames: Snapshots, targets: list[float],
                 control: Control) -> None:
        self.checkpoint, self._limits, self._until = checkpoint, control.limits, control.until
        self._observers = [observer for observer in control.observers if isinstance(observer, Observer)]
        self._stepper, self._frames, self._targets = stepper, frames, targets
        self._wall, self._t = clock.perf_counter(), stepper.t
        self._last: tuple[float, int] | None = None

    def begin(self) -> None:
        """Overwrite an existing file at the start, so that the checkpoint of another run cannot be resumed by mistake."""
        if self.checkpoint.path.exists():
            self.write()

    def hint(self) -> str:
        """Return the part of a message that describes how to continue the run."""
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
                or (interval is not None and intervals(self._t, self._stepper.t, interval) >= 1)):
            self.write()

    def write(self) -> None:
        """Write a checkpoint."""
        stepper, frames = self._stepper, self._frames
        problem = stepper.problem
        watched = [(observer, notes) for observer in self._observers if (notes := observer.stored(stepper)) is not None]
        plan = {"seconds": self.checkpoint.seconds, "interval": self.checkpoint.interval, "nonhyperbolic": stepper.nonhyperbolic,
                "threads": stepper.threads, "length": describe(stepper.length), "stop": describe(self._until),
                "limits": describe(self._limits),
                "observers": [{**fields_of(observer), "notes": list(notes)} for observer, notes in watched]}
        kept = effective(problem, stepper.scheme, stepper.stats(), Status.INTERRUPTED, "to be continued with fv.resume")
        write_archive(self.checkpoint.path, {
            "format": CHECKPOINT, "t": frames.t, "q": frames.q, "times": self._targets, **stepper.snapshot(),
            **{f"aux_{name}": values for name, values in problem.aux_averages.items()},
            **({} if problem.background is None else {"background": problem.background_averages}),
            **{_entry(k, name): np.array(values, dtype=float) for k, (_, notes) in enumerate(watched)
               for name, values in notes.items()},
            "plan": json.dumps(plan), "configuration": json.dumps(kept, allow_nan=False)})
        self._wall, self._t = clock.perf_counter(), stepper.t
        self._last = stepper.t, stepper.steps


def _entry(number: int, name: str) -> str:
    """Return the name of an array of an observer's record in a checkpoint."""
    return f"observer_{number}_{name}"


def restore_records(observers: Iterable[Any], stepper: Stepper, archive: Archive, kept: Any) -> None:
    """Restore the records of observers, matched by class and fields with those ``kept`` in the plan of a checkpoint; warn about
    observers without a record and records without an observer.
    """
    if not (isinstance(kept, list) and all(isinstance(one, dict) and isinstance(one.get("notes"), list) for one in kept)):
        raise archive.refused("its plan does not name the observers whose records it has")
    waiting = [({key: value for key, value in one.items() if key != "notes"}, k, one["notes"]) for k, one in enumerate(kept)]
    said = False
    for observer in observers:
        if not isinstance(observer, Observer):
            continue
        wanted = json.loads(json.dumps(fields_of(observer)))
        found = next((one for one in waiting if one[0] == wanted), None)
        if found is not None:
            waiting.remove(found)
            _, k, names = found
            try:
                observer.restore(stepper, {name: archive.numbers(_entry(k, name), None) for name in names})
            except (KeyError, TypeError, ValueError) as error:
                raise archive.refused(f"the record of its {type(observer).__name__} cannot be used: {error}") from None
        elif stepper.steps:
            said, known = True, ", ".join(str(one["class"]) for one, _, _ in waiting) or "none"
            warnings.warn(f"{validation.shown(observer)} records the run from t = {stepper.t:.6g} on: {archive.path} has no "
                          f"record of an observer of its class with its fields (of others: {known})", RuntimeWarning,
                          stacklevel=3)
    if waiting and not said:
        lost = ", ".join(str(one["class"]) for one, _, _ in waiting)
        warnings.warn(f"{archive.path} has records of {lost}, and no observer continues them: give such observers, "
                      "with the same fields, as `observers`, or these records are lost", RuntimeWarning, stacklevel=3)
