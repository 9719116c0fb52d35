"""Who runs the members: a given executor, or processes that are replaced when one of them dies."""

import multiprocessing
import os
import pickle
import signal
import sys
import threading
from collections import deque
from collections.abc import Iterator, Sequence
from concurrent.futures import BrokenExecutor, CancelledError, Executor, Future, ProcessPoolExecutor
from contextlib import contextmanager
from queue import SimpleQueue
from typing import Any

from fvkit import validation
from fvkit.sweeps.member import LOST, MemberResult, MemberTask

Batch = list[tuple[int, dict[str, Any]]]

#: Wall time that a batch should take, s: long against the executor's overhead, short against a sweep.
BATCH_SECONDS = 0.25

#: Pools of processes that may break before any member finishes.
POOLS = 3

#: Batches per worker that are submitted ahead.
AHEAD = 3


class WorkerPool:
    """Members by batches on an executor; a context manager.

    Parameters
    ----------
    work : the function and what is kept.
    executor : anything with ``submit``; None for processes of our own.
    workers : processes; with an executor, how many it runs at once, None if unknown: then all is submitted at once.
    batch : members per task; None: as many as take about 0.25 s, one where all is submitted at once.
    retries : how often a member is run again whose executor, not its function, failed.
    """

    def __init__(self, work: MemberTask, executor: Executor | None, workers: int | None, batch: int | None, retries: int) -> None:
        self.work, self.batch, self.retries = work, batch, retries
        self._own = executor is None
        self.workers = workers or validation.cores() if self._own else workers
        self._executor = executor
        self._seconds, self._finished, self._pools = 0.0, 0, 0
        if self._own and self.workers != 1:
            _check_importable(work)

    def __enter__(self) -> "WorkerPool":
        return self

    def __exit__(self, kind: type[BaseException] | None, *error: object) -> None:
        if self._own and self._executor is not None:
            end_processes(self._executor, at_once=kind is not None)

    def run(self, members: Sequence[tuple[int, dict[str, Any]]]) -> Iterator[list[MemberResult]]:
        """Yield outcomes as they come; every member is in exactly one of them."""
        if self._own and self.workers == 1:
            for member in members:
                yield [self.work.run(*member)]
            return
        suspects: list[tuple[tuple[int, dict[str, Any]], BaseException]] = []
        waiting, running = deque(members), dict[Any, list[tuple[int, dict[str, Any]]]]()
        done = SimpleQueue[Any]()
        try:
            while waiting or running:
                while waiting and (self.workers is None or len(running) < AHEAD * self.workers):
                    batch = [waiting.popleft() for _ in range(self._size(len(waiting)))]
                    future = self._submit(batch)
                    running[future] = batch
                    future.add_done_callback(done.put)
                future = done.get()
                batch, error = running.pop(future), _error(future)
                if error is None:
                    yield self._note(future.result())
                else:
                    suspects += [(member, error) for member in batch]
                    self._check_alive(error)
        finally:
            for future in running:
                future.cancel()
        for member, error in suspects:
            yield [self._again(member, error)]

    def _size(self, left: int) -> int:
        """Members of the next batch."""
        if self.batch is not None:
            return min(self.batch, left)
        if self.workers is None or not self._finished:
            return 1
        wanted = BATCH_SECONDS * self._finished / max(self._seconds, 1e-9)
        return max(1, min(int(wanted), left // (AHEAD * self.workers)))

    def _note(self, outcomes: list[MemberResult]) -> list[MemberResult]:
        self._seconds += sum(outcome.seconds for outcome in outcomes)
        self._finished += len(outcomes)
        return outcomes

    def _again(self, member: tuple[int, dict[str, Any]], error: BaseException) -> MemberResult:
        """Run a member alone, so that one that kills its worker takes no other with it."""
        for _ in range(self.retries):
            future = self._submit([member])
            missed = _error(future)
            if missed is None:
                return self._note(future.result())[0]
            error = missed
            self._check_alive(error)
        return MemberResult(member[0], LOST, f"{type(error).__name__}: {error}", 0.0, {})

    def _submit(self, batch: Batch) -> Future:
        try:
            if self._executor is None:
                self._executor = self._processes()
            with ctrl_c_held():
                return self._executor.submit(self.work, batch)
        except BrokenExecutor as error:
            if self._own and self._executor is not None:
                self._executor.shutdown(wait=False)
                self._executor = self._processes()
                with ctrl_c_held():
                    return self._executor.submit(self.work, batch)
            failed: Future = Future()
            failed.set_exception(error)
            return failed

    def _processes(self) -> ProcessPoolExecutor:
        self._pools += 1
        return ProcessPoolExecutor(self.workers, mp_context=multiprocessing.get_context("spawn"), initializer=begin_worker)

    def _check_alive(self, error: BaseException) -> None:
        """Stop where the user stopped a member, and where processes die before they do anything: all others would."""
        if isinstance(error, KeyboardInterrupt):
            raise error
        if self._pools >= POOLS and not self._finished and isinstance(error, BrokenExecutor):
            raise RuntimeError("the processes of the sweep died before any member finished. A script needs `if __name__ == "
                               "\"__main__\":` around its call of fv.sweep; workers=1 runs in this process and shows other "
                               "reasons") from error


def begin_worker() -> None:
    """Leave Ctrl-C, which reaches every process of a terminal, to the one that started this one; end when that ends this one
    (a forked process has inherited what that does on SIGTERM) or is killed."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    signal.signal(signal.SIGTERM, signal.SIG_DFL)
    threading.Thread(target=_end_with_parent, name="fvkit-parent", daemon=True).start()


@contextmanager
def ctrl_c_held() -> Iterator[None]:
    """Hold Ctrl-C back: processes that start meanwhile inherit that, so that none dies of it with a traceback in its imports."""
    if not hasattr(signal, "pthread_sigmask"):
        yield
        return
    before = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})
    try:
        yield
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, before)


def end_processes(executor: Executor, at_once: bool) -> None:
    """End the processes of an executor: ``at_once``, or when they have done what they are at."""
    for process in dict(getattr(executor, "_processes", None) or {}).values() if at_once else ():
        process.terminate()
    executor.shutdown(wait=True, cancel_futures=True)


def _end_with_parent() -> None:
    """End this process when the one that started it ends; otherwise it would wait for work without end."""
    parent = multiprocessing.parent_process()
    if parent is not None:
        parent.join()
        os._exit(1)


def _error(future: Future) -> BaseException | None:
    """Why there is no result; None if there is one."""
    try:
        return future.exception()
    except CancelledError as error:
        return error


def _check_importable(work: MemberTask) -> None:
    """Processes import the function by its name: refuse what has none, before anything runs."""
    advice = "define it at the top level of a module or script, or give a thread pool as `executor`, or workers=1"
    main = sys.modules["__main__"]
    function = work.function
    if getattr(function, "__module__", None) == "__main__" and not getattr(main, "__file__", None):
        raise ValueError(f"`function` {function!r} was defined interactively, where other processes cannot import it: {advice}")
    try:
        pickle.dumps(work)
    except (pickle.PicklingError, AttributeError, TypeError) as error:
        raise ValueError(f"`function` or `keep` cannot be sent to other processes ({error}): {advice}") from None
