"""The full sizes: ``python -m tests.robust.full kills|many|growth|long|large|soak [--size N] [--backend B]``."""

import argparse
import datetime
import os
import platform
import sys
import tempfile
import time
import warnings

import numpy as np

import fvkit as fv
from fvkit.backends.compiled.numba_kernel import available
from tests.robust import kills, long_runs, many
from tests.robust.cases import resident

SIZES = {"kills": 50, "many": 1000, "growth": 300, "long": 1_000_000, "large": 10_000_000, "soak": 10_000}


def run_kills(size, backend, folder):
    killed, ended, early = kills.kill_runs(size, folder, backend)
    yield f"{killed} kills of runs, {early} of them before the first checkpoint: {ended} runs ended, all bit-identical"
    for suffix in ("npz", "nc"):
        yield f"{kills.kill_writers(size, f'{folder}/file.{suffix}')} kills of a writer of .{suffix}: one whole file every time"


def run_many(size, backend, folder):
    for way, differing in many.many_runs(size, backend).items():
        yield f"{size} random runs, {way}: {differing} differ from the run alone"


def run_growth(size, backend, folder):
    traced, whole = many.growth(size, backend=backend)
    yield f"{size} runs after 200: traced memory grew by {traced / 1e3:.1f} kB, the process by {whole / 1e3:.0f} kB"


def run_long(size, backend, folder):
    for name, problem in (("ring", long_runs.waves(1000, fv.Periodic())), ("basin", long_runs.waves(1000, fv.Wall())),
                          ("rest", long_runs.rest(1000))):
        started = time.perf_counter()
        change, speed, sound = long_runs.long_run(problem, size, backend)
        yield (f"{name}, 1000 cells, {size} steps: mass changed by {change:.1e}, largest speed {speed:.1e} m/s, "
               f"{'finite, no negative depth' if sound else 'NOT SOUND'}, {time.perf_counter() - started:.0f} s")


def run_large(size, backend, folder):
    needed, free = 6 * 32 * size, os.sysconf("SC_AVPHYS_PAGES") * os.sysconf("SC_PAGE_SIZE")
    if needed > free:
        yield f"skipped: {size} cells need about {needed / 1e9:.1f} GB, {free / 1e9:.1f} GB are free"
        return
    state, traced, peak = long_runs.large_run(size, backend=backend)
    yield (f"{size} cells, 3 steps: a state is {state / 1e6:.0f} MB, the stepper took {traced / state:.2f} of it, the process "
           f"{peak / 1e6:.0f} MB ({peak / state:.2f} states)")


def run_soak(size, backend, folder):
    before, started = resident(), time.perf_counter()
    result, own, worker = long_runs.soak(size, folder)
    yield (f"{int(result.finished.sum())} of {size} members finished in {time.perf_counter() - started:.0f} s on 2 workers; the "
           f"process grew by {own / 1e6:.1f} MB from {before / 1e6:.0f} MB, a worker by {worker / 1e6:.2f} MB")


def versions():
    """Date and versions, for the documents."""
    found = [f"Python {platform.python_version()}", f"NumPy {np.__version__}", f"fvkit {fv.__version__}"]
    if available():
        import numba

        found.append(f"numba {numba.__version__}")
    return f"{datetime.datetime.now(datetime.UTC).date()}: {', '.join(found)}, {platform.system()}"


def main(arguments=None):
    parser = argparse.ArgumentParser(prog="python -m tests.robust.full", description=__doc__)
    parser.add_argument("what", choices=SIZES)
    parser.add_argument("--size", type=int, help=f"default {SIZES}")
    parser.add_argument("--backend", choices=("numpy", "numba"), help="default: numba for long and large, numpy for the others")
    options = parser.parse_args(arguments)
    compiled = options.what in ("long", "large") and available()
    warnings.simplefilter("ignore", RuntimeWarning)
    print(versions(), flush=True)
    with tempfile.TemporaryDirectory() as folder:
        work = globals()[f"run_{options.what}"]
        for line in work(options.size or SIZES[options.what], options.backend or ("numba" if compiled else "numpy"), folder):
            print(line, flush=True)
    return 0


if __name__ == "__main__":
    sys.exit(main())
