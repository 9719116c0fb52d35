"""`resume`: continue a run from its checkpoint."""

import json
from collections.abc import Callable, Iterable, Iterator, Mapping
from pathlib import Path
from typing import Any

import attrs
import numpy as np

from fvkit import validation
from fvkit.backends import BACKENDS
from fvkit.files import Unreadable
from fvkit.output.configuration import CALLABLE, OBJECT, describe, model_and_grid, parsed, part
from fvkit.output.npz import CHECKPOINT, Archive, expect_format
from fvkit.output.solution import Solution
from fvkit.problem.problem import Problem
from fvkit.run.checkpoint import Checkpoint, restore_records
from fvkit.run.control import Control, Limits
from fvkit.run.recording import InMemory
from fvkit.run.solve import run_to_end
from fvkit.run.step_bounds import Step
from fvkit.run.stepper import Stepper
from fvkit.run.stopping import Stop
from fvkit.schemes.scheme import Scheme


def resume(path: str | Path, t_end: float | None = None, problem: Problem | None = None, scheme: Scheme | None = None, *,
           limits: Limits | None = None, checkpoint: Checkpoint | bool | None = True,
           observers: Iterable[Callable[[Stepper], None]] = (), backend: str | None = None,
           progress: bool | Callable[[float], None] = False, throw: bool = True) -> Solution:
    """Continue a run from its checkpoint, with the same results, bit for bit, as an uninterrupted run.

    Parameters
    ----------
    path : path of the `Checkpoint` file.
    t_end : new end time, s; None for the output times of the run. A later end time is one more output, so the result is
        that of a run whose ``times`` contain the old and the new end time. An earlier end time drops the later outputs.
    problem, scheme : problem and scheme of the run; None takes both from the file. Needed where the file cannot store an
        object, such as an inflow that is a function of time; both must then be those of the run in all that a file can store.
    backend : backend; None for that of the run, which is needed for bit-identical results.
    limits : as for `solve`, counted from the start of the run; None for the limits of the run, or for the default if the
        run ended at one of its limits.
    progress, throw : as for `solve`.
    observers : as for `solve`. An observer with the class and fields of an observer of the run continues its record, which
        the checkpoint contains; other `Observer` objects start here, with a warning.
    checkpoint : True continues the checkpoints of the run in the same file; None or False writes none.

    Returns
    -------
    Solution
        Solution from the start of the run, with its earlier outputs and statistics.

    Raises
    ------
    ValueError
        For an invalid file, for an object that a file cannot store, and for a ``problem`` or ``scheme`` that differs from
        that of the run; the message contains the file and the reason.
    SolveError
        As for `solve`.

    Examples
    --------
    >>> import fvkit as fv
    >>> import fvkit_granular as gr
    >>> from tempfile import TemporaryDirectory
    >>> problem = gr.scene("dam-break").problem(gr.ShallowWater, 50)
    >>> with TemporaryDirectory() as folder:
    ...     first = fv.solve(problem, checkpoint=fv.Checkpoint(f"{folder}/run.npz"), backend="numpy")
    ...     longer = fv.resume(f"{folder}/run.npz", t_end=2.0 * problem.t_end)
    >>> (longer.t / problem.t_end).tolist()
    [0.0, 1.0, 2.0]
    """
    if backend is not None:
        validation.choice(backend, "backend", BACKENDS)
    archive = Archive(path)
    expect_format(archive, CHECKPOINT)
    kept, plan = parsed(archive.text("configuration"), archive.path), parsed(archive.text("plan"), archive.path)
    q = archive.numbers("q", None)
    if not q.size:
        raise archive.refused("it holds no state")
    own = scheme is None and problem is None
    scheme = _part(archive, kept, "scheme", Scheme, "scheme") if scheme is None else _unchanged(scheme, "scheme", kept, archive)
    problem = _problem(archive, kept, q[0], scheme) if problem is None else _same(problem, kept, archive, q[0])
    t, times = archive.numbers("t", (len(q),)), archive.numbers("times", (None,)).tolist()
    snapshot = _snapshot(archive, problem)
    if t_end is not None:
        last = validation.real(t_end, "t_end", at_least=float(snapshot["real"][0]), hint="where the checkpoint is")
        times = [time for time in times if time < last] + [last]
        problem = attrs.evolve(problem, t_end=max(last, problem.t_end))
    frames = InMemory(max(len(times) + 1, len(t)) + 1, problem.q0)
    for time, state in zip(t, q, strict=True):
        frames.add(float(time), state)
    try:
        settings = plan["nonhyperbolic"], plan["threads"]
        again = Checkpoint(archive.path, plan["seconds"], plan["interval"])
        used = backend or validation.choice(kept.get("backend"), "backend", BACKENDS)
    except KeyError as error:
        raise archive.refused(f"its plan has no {error}") from None
    except (TypeError, ValueError) as error:
        raise archive.refused(f"its plan cannot be followed: {error}") from None
    length = part(plan, "length", Step, archive.path)
    stop = None if plan.get("stop") is None else part(plan, "stop", Stop, archive.path)
    kept_limits = part(plan, "limits", Limits, archive.path) if plan.get("limits") is not None else Limits()
    try:
        stepper = Stepper(problem, scheme, used, *settings, length)
    except (TypeError, ValueError) as error:
        if not own:
            raise
        raise archive.refused(f"its run cannot be made again: {error}") from None
    rows, found = len(stepper.snapshot()["masses"]), len(snapshot["masses"])
    if rows != found:
        raise archive.refused(f"its mass balance has {found} rows, and the sides and sources of the run have {rows}")
    stepper.restore(snapshot)
    if limits is None and not kept_limits.used_up(stepper.steps, stepper.seconds):
        limits = kept_limits
    chosen, control = again if checkpoint is True else checkpoint or None, Control(observers, limits, stop)
    restore_records(control.observers, stepper, archive, plan.get("observers", []))
    return run_to_end(stepper, times, frames, control, chosen, progress, throw)


def _snapshot(archive: Archive, problem: Problem) -> dict[str, np.ndarray]:
    """Return the arrays for `Stepper.restore` from a checkpoint, {name: array}."""
    result = {"now": archive.numbers("now", problem.q0.shape), "real": archive.numbers("real", (4,)),
              "count": archive.numbers("count", (7,), "i"), "clock": archive.numbers("clock", ()),
              "masses": archive.numbers("masses", (None, max(1, len(problem.model.mass_rows()))))}
    if not (np.isfinite(result["now"]).all() and np.isfinite(result["real"][0]) and result["real"][1] > 0.0):
        raise archive.refused("its state, time or step is no number")
    return result


def _part(archive: Archive, kept: Mapping[str, Any], name: str, kind: type, argument: str) -> Any:
    """Return an object restored from a checkpoint, or raise with the argument of `resume` that replaces it."""
    try:
        return part(kept, name, kind, archive.path)
    except Unreadable as error:
        raise Unreadable(archive.path, f"{str(error).split(': ', 1)[-1]}; or give `{argument}` to fvkit.resume") from None


def _problem(archive: Archive, kept: Mapping[str, Any], q0: np.ndarray, scheme: Scheme) -> Problem:
    """Return the `Problem` restored from a checkpoint."""
    if isinstance(kept.get("background"), Mapping) and type(scheme).background is not Scheme.background:
        raise archive.refused("background is a function whose values at faces the scheme uses, which no file can hold; give "
                              "`problem` to fvkit.resume")
    model, grid = model_and_grid(kept, archive.path)
    boundary, sources = (_part(archive, kept, name, tuple, "problem") for name in ("boundary", "sources"))
    background = archive.numbers("background", q0.shape) if kept.get("background") else None
    aux = {name: archive.numbers(f"aux_{name}", grid.shape) for name in model.aux}
    try:
        return Problem(model, grid, q0, kept["t_end"], aux, boundary, sources, kept["t_start"], background)
    except KeyError as error:
        raise archive.refused(f"its configuration has no {error}") from None
    except (TypeError, ValueError) as error:
        raise archive.refused(f"its problem cannot be made again: {error}") from None


def _same(problem: Problem, kept: Mapping[str, Any], archive: Archive, q0: np.ndarray) -> Problem:
    """Return the given problem, or raise ValueError where it differs from that of the run."""
    validation.instance(problem, "problem", Problem)
    if not np.array_equal(problem.q0, q0):
        raise ValueError(f"`problem` has another grid or initial state than the run of {archive.path}")
    for name, values in problem.aux_averages.items():
        if not np.array_equal(values, archive.numbers(f"aux_{name}", values.shape)):
            raise ValueError(f"`problem` has another {name!r} than the run of {archive.path}")
    for name in ("model", "boundary", "sources"):
        _unchanged(getattr(problem, name), name, kept, archive)
    return problem


def _unchanged(value: Any, name: str, kept: Mapping[str, Any], archive: Archive) -> Any:
    """Return a part of a run, or raise ValueError where it differs from that of the checkpoint in what a file can hold."""
    place, now, then = next(_differences(json.loads(json.dumps(describe(value))), kept.get(name), name), ("", None, None))
    if place:
        raise ValueError(f"{place} is {_named(now)}, but {_named(then)} in the run of {archive.path}: a run goes on with its own "
                         "physics and scheme. Give those, or begin a new run")
    return value


def _named(described: Any) -> str:
    """Return what a message says of a result of `describe`: of several parts their names."""
    if isinstance(described, list) and all(isinstance(item, Mapping) and "class" in item for item in described):
        return f"({', '.join(item['class'] for item in described)})"
    return validation.shown(described)


def _differences(now: Any, then: Any, place: str) -> Iterator[tuple[str, Any, Any]]:
    """Yield where two results of `describe` differ, and both values there; functions cannot be compared."""
    if isinstance(now, Mapping) and isinstance(then, Mapping) and now.keys() == then.keys():
        if not now.keys() & {CALLABLE, OBJECT}:
            for key in now:
                yield from _differences(now[key], then[key], f"{place}.{key}")
    elif isinstance(now, list) and isinstance(then, list) and len(now) == len(then):
        for k, pair in enumerate(zip(now, then, strict=True)):
            yield from _differences(*pair, f"{place}[{k}]")
    elif now != then:
        yield place, now, then
