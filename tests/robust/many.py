"""Many runs in one process, in threads and in processes: the same bits as each run alone, and no memory kept."""

import gc
import multiprocessing
import os
import tracemalloc
from concurrent.futures import ProcessPoolExecutor, ThreadPoolExecutor
from functools import partial

import numpy as np

from tests.robust.cases import forked, resident, shaken


def alone(number, backend):
    """The digest of a run in a process of its own, which has run nothing before."""
    reader, writer = os.pipe()
    child = forked(lambda: os.write(writer, shaken(number, backend).encode()) != 64)
    os.close(writer)
    with os.fdopen(reader) as file:
        digest = file.read()
    os.waitpid(child, 0)
    return digest


def many_runs(count, backend="numpy", threads=4, processes=2, seed=3):
    """Run ``count`` random settings alone, in random orders one after the other, in threads and in processes.

    Return {way: number of runs that differ from the run alone}.
    """
    expected = [alone(number, backend) for number in range(count)]
    assert all(len(digest) == 64 for digest in expected)
    run, rng = partial(shaken, backend=backend), np.random.default_rng(seed)

    def differing(results, order):
        return sum(digest != expected[number] for digest, number in zip(results, order, strict=True))

    found, order = {}, rng.permutation(count)
    found["one after the other"] = differing(map(run, order), order)
    order = rng.permutation(count)
    with ThreadPoolExecutor(threads) as pool:
        found[f"{threads} threads"] = differing(pool.map(run, order), order)
    order = rng.permutation(count)
    with ProcessPoolExecutor(processes, mp_context=multiprocessing.get_context("spawn")) as pool:
        found[f"{processes} processes"] = differing(pool.map(run, order, chunksize=10), order)
    return found


def growth(runs, warm=200, settings=40, backend="numpy"):
    """Bytes that Python's objects and the whole process have grown by after so many more small runs, the process untraced."""
    def repeat(count):
        for number in range(count):
            shaken(number % settings, backend)
        gc.collect()

    repeat(warm)
    before = resident()
    repeat(runs)
    whole = resident() - before
    tracemalloc.start()
    repeat(settings)  # what is allocated once for each setting, and what is allocated anew since objects are traced
    traced = tracemalloc.get_traced_memory()[0]
    repeat(runs)
    traced = tracemalloc.get_traced_memory()[0] - traced
    tracemalloc.stop()
    return traced, whole
