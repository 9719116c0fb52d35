"""`sweep`: run a function once per sample."""

from collections.abc import Callable, Iterable, Mapping
from concurrent.futures import Executor
from pathlib import Path
from time import perf_counter
from typing import Any

from fvkit import validation
from fvkit.output.solution import Solution
from fvkit.run.interruption import keeping
from fvkit.run.progress import checked, counter
from fvkit.sweeps.folder import ResultFolder
from fvkit.sweeps.member import STOPPED, Function, MemberResult, MemberTask
from fvkit.sweeps.outputs import Keep
from fvkit.sweeps.result import SweepResult
from fvkit.sweeps.samples import Samples
from fvkit.sweeps.workers import WorkerPool


def sweep(function: Function, parameters: Samples | Mapping[str, Iterable[Any]], executor: Executor | None = None, *,
          workers: int | None = None, keep: Callable[[Solution], Mapping[str, Any]] | Iterable[str] | None = None,
          folder: str | Path | None = None, retries: int = 2, batch: int | None = None,
          progress: bool | Callable[[float], None] = False) -> SweepResult:
    """Run ``function(**sample)`` for every sample, on several processes or any executor.

    Parameters
    ----------
    function : takes the parameters by name; returns {output: number or array}, or a `Solution`. Processes import it:
        define it at the top level of a module, and guard a script's call by ``if __name__ == "__main__":``.
        `fvkit_granular.SceneRun` makes one of a scene.
    parameters : `Samples`, or {parameter: one value per member}.
    executor : any `concurrent.futures.Executor`: threads, ``Client(...).get_executor()`` of Dask (extra ``cluster``), that
        of mpi4py.futures, joblib's loky; it is not closed. Default: new processes ("spawn").
    workers : number of processes, default one per processor; 1 runs in this process. With an executor: the number of members
        that it runs at once, if known; then members are sent in batches.
    keep : outputs of a solution: names as in `Keep`, or a function. Default: every observable at the end.
    folder : folder in which every finished member is stored at once; the same sweep with the same folder runs only the
        missing ones.
    retries : number of times that a member is run again, alone, after a failure of the executor, such as a dead worker.
    batch : members per task. Default: as many as take about 0.25 s.
    progress : True shows progress on stderr; or a function of the fraction of finished members, 0 to 1.

    Returns
    -------
    SweepResult
        A failed member is a row with its status and message; the sweep continues.

    Raises
    ------
    ValueError, TypeError
        For bad input; also where ``folder`` holds another sweep, or the function cannot be sent to processes.
    RuntimeError
        If processes die before any member finished.
    KeyboardInterrupt
        After Ctrl-C, which does not wait for members under way; its attribute ``result`` is the SweepResult so far, in which
        these have the status ``"interrupted"``.

    Notes
    -----
    ``folder`` identifies the function by its name, not by its code: after a change of the code give another folder.

    Examples
    --------
    >>> import fvkit as fv
    >>> def square(x):
    ...     return {"y": x * x}
    >>> result = fv.sweep(square, {"x": [1.0, 2.0, 3.0]}, workers=1)
    >>> result.success, result.outputs["y"].tolist()
    (True, [1.0, 4.0, 9.0])
    """
    folder = None if folder is None else validation.file(folder, "folder")
    samples = parameters if isinstance(parameters, Samples) else \
        Samples.given(validation.mapping(parameters, "parameters", "{'gamma': [0.3, 0.5]}"))
    validation.function(function, "function", "of the parameters")
    work = MemberTask(function, keep if callable(keep) else Keep(() if keep is None else keep))
    if executor is not None and not callable(getattr(executor, "submit", None)):
        raise TypeError(f"`executor` must be a concurrent.futures.Executor, got {validation.shown(executor)}; Dask's is "
                        "Client(...).get_executor()")
    pool = WorkerPool(work, executor, None if workers is None else validation.whole(workers, "workers", at_least=1),
                None if batch is None else validation.whole(batch, "batch", at_least=1),
                validation.whole(retries, "retries", at_least=0))
    started = perf_counter()
    store = None if folder is None else ResultFolder.open(folder, work, samples)
    known: dict[int, MemberResult] = {} if store is None else {outcome.member: outcome for outcome in store.read(len(samples))}
    missing = [(member, samples[member]) for member in range(len(samples)) if member not in known]

    def result() -> SweepResult:
        outcomes = [known.get(member) or MemberResult(member, STOPPED, "the sweep was stopped before it ended", 0.0, {})
                    for member in range(len(samples))]
        return SweepResult.of(samples, outcomes, perf_counter() - started)

    with keeping(result), counter(checked(progress), len(samples), "members") as report, pool:
        report(len(known))
        for outcomes in pool.run(missing):
            for outcome in outcomes:
                known[outcome.member] = outcome
                if store is not None:
                    store.write(outcome)
            report(len(known))
    return result()
