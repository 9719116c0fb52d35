"""Runs of pytest on a copy of the tree: each in a forked process that has the libraries loaded already, not the packages under test."""

import contextlib
import importlib
import multiprocessing
import os
import shutil
import signal
import sys
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

#: What a test run would spend its first seconds on.
LIBRARIES = ("numpy", "scipy.integrate", "scipy.optimize", "matplotlib.figure", "hypothesis", "xarray", "h5netcdf", "numba")

#: Seconds after which a run counts as stopped.
PATIENCE = 300.0

#: Seconds of the processor that a test may take; longer ones have no part in this. More where it compiles, which is the point there.
LONGEST, LONGEST_COMPILED = 1.5, 6.0

#: What the names of tests say that compile: they only run where compiling is the point.
COMPILE = ("numba", "compiled", "backends_agree")

#: Exit codes of pytest: all passed, some failed; ours where the interpreter came down, and where it had to be stopped.
PASSED, FAILED, FELL, STOPPED = 0, 1, -1, -2

#: Of every run. The libraries are loaded before pytest could rewrite the assertions of hypothesis, which none of our tests needs.
OPTIONS = ("-q", "-p", "no:cacheprovider", "-p", "no:xdist", "-p", "no:benchmark", "-W", "ignore::pytest.PytestAssertRewriteWarning")


class Durations:
    """A pytest plugin that notes the processor seconds of each test and what failed.

    Without ``known`` seconds a test that takes too long is cut short and has none; with them such tests are left out, and the
    quickest run first.
    """

    def __init__(self, known: dict[str, float] | None) -> None:
        self.known = known
        self.seconds: dict[str, float] = {}
        self.failed: list[str] = []

    def pytest_collection_modifyitems(self, items: list[pytest.Item]) -> None:
        if self.known is None:  # a compilation is not cut short in mid-air: it would leave the compiler in pieces
            items[:] = [item for item in items if compiles(item) or not any(word in item.nodeid for word in COMPILE)]
        else:
            items[:] = sorted((item for item in items if item.nodeid in self.known), key=lambda item: self.known[item.nodeid])

    @pytest.hookimpl(hookwrapper=True)
    def pytest_runtest_call(self, item: pytest.Item) -> Iterator[None]:
        if self.known is not None:
            yield
            return
        cut = []
        signal.signal(signal.SIGPROF, lambda *_: cut.append(True) or pytest.skip("too long"))
        start = time.process_time()
        if not compiles(item):
            signal.setitimer(signal.ITIMER_PROF, LONGEST)
        result = yield
        signal.setitimer(signal.ITIMER_PROF, 0.0)
        took = time.process_time() - start
        if cut:
            result.force_exception(pytest.skip.Exception("too long"))  # also where a library made another error of it
        elif result.excinfo is None and took <= LONGEST_COMPILED:
            self.seconds[item.nodeid] = took

    def pytest_runtest_logreport(self, report: pytest.TestReport) -> None:
        if report.failed:
            self.failed.append(report.nodeid)


def compiles(item: pytest.Item) -> bool:
    """Whether a test is about compiled kernels; all others run on NumPy."""
    return item.nodeid.startswith("tests/backends/")


def copy_of(top: Path, target: Path) -> None:
    """Copy what the tests need: nothing is changed in the tree itself."""
    for folder in ("fvkit", "fvkit_granular", "tests"):
        shutil.copytree(top / folder, target / folder, ignore=shutil.ignore_patterns("__pycache__"))
    for file in ("pyproject.toml", "README.md"):
        shutil.copy(top / file, target / file)


def _child(root: Path, files: tuple[str, ...], known: dict[str, float] | None, pipe: Any) -> None:
    os.setsid()
    os.chdir(root)
    sys.path[:] = [str(root), *(item for item in sys.path if item not in ("", str(Path.cwd())))]
    for name in [name for name in sys.modules if name.split(".")[0] in ("tests", "fvkit", "fvkit_granular")]:
        del sys.modules[name]
    hypothesis = importlib.import_module("hypothesis")
    hypothesis.settings.register_profile("mutation", derandomize=True, database=None, deadline=None)
    hypothesis.settings.load_profile("mutation")
    with open(os.devnull, "w") as nowhere, contextlib.redirect_stdout(nowhere), contextlib.redirect_stderr(nowhere):
        plugin = Durations(known)
        code = pytest.main([*files, *OPTIONS, *(["-x"] if known is not None else [])], plugins=[plugin])
        imported = sys.modules.get("fvkit")
    inside = imported is None or str(getattr(imported, "__file__", root)).startswith(str(root))
    pipe.send((int(code), plugin.seconds, plugin.failed, inside))


def run(root: Path, files: tuple[str, ...], known: dict[str, float] | None = None, patience: float = PATIENCE,
        ) -> tuple[int, dict[str, float], list[str]]:
    """Run tests, with ``known`` seconds until the first fails; return the exit code of pytest or ours, the seconds of each test, and the tests that failed."""
    context = multiprocessing.get_context("fork")
    here, there = context.Pipe(duplex=False)
    process = context.Process(target=_child, args=(root, files, known, there))
    process.start()
    there.close()
    try:
        if not here.poll(patience):
            return STOPPED, {}, []
        code, seconds, failed, inside = here.recv()
    except EOFError:
        return FELL, {}, []
    finally:
        with contextlib.suppress(ProcessLookupError):
            os.killpg(process.pid or 0, 9)
        process.join()
    if not inside:
        raise RuntimeError(f"the tests imported a fvkit outside of {root}: run from the top of a checkout")
    return code, seconds, failed


@contextlib.contextmanager
def prepared(scratch: Path) -> Iterator[None]:
    """Load the libraries, and keep compiled kernels and byte code out of the way."""
    os.environ.update(FVKIT_CACHE=str(scratch / "kernels"), PYTHONDONTWRITEBYTECODE="1", PYTHONPATH=str(scratch / "tree"), MPLBACKEND="Agg")
    sys.dont_write_bytecode = True
    for name in LIBRARIES:
        importlib.import_module(name)
    yield
