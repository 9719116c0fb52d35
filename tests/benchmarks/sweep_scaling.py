"""How a sweep scales: 1000 members of 400 cells on one process and on two, and what the sweep itself costs per member.

Not a test: it needs an idle machine. Usage: python tests/benchmarks/sweep_scaling.py [MEMBERS]
"""

import sys
import tempfile
from time import perf_counter

import fvkit as fv
import fvkit_granular as gr

RANGES = {"sources.v_T": (0.1, 10.0, "log"), "gamma": (0.3, 0.6), "sources.nu": (0.2, 0.8)}


def main():
    members = int(sys.argv[1]) if len(sys.argv) > 1 else 1000
    run, samples = gr.SceneRun("debris-slope", cells=400), fv.Samples.latin_hypercube(RANGES, members)
    run(**samples[0])
    alone = 0.0
    for workers in (1, 2):
        with tempfile.TemporaryDirectory() as folder:
            started = perf_counter()
            result = fv.sweep(run, samples, workers=workers, keep=["mean.h", "max.h"], folder=folder)
            elapsed = perf_counter() - started
        alone = alone or elapsed
        overhead = 1e3 * (workers * elapsed - result.seconds.sum()) / members
        print(f"{workers} process(es): {elapsed:.2f} s, {1e3 * result.seconds.mean():.1f} ms per member, "
              f"{overhead:.2f} ms of a process beside that, speed-up {alone / elapsed:.2f}, "
              f"{int(result.finished.sum())} of {members} finished", flush=True)


if __name__ == "__main__":
    main()
