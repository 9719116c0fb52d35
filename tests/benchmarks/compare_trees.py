"""Cost of a step of several checkouts, alternated: ns per cell and step, CPU time, the smallest of many blocks, and ratios.

    python tests/benchmarks/compare_trees.py OLD NEW [MORE ...] --blocks 15

Each checkout runs in a process of its own, with its own kernels; a block of one follows a block of the other, so that what else the
machine does meets all of them alike. Read the ratios, not the figures.
"""

import argparse
import json
import os
import subprocess
import sys
import time
import warnings

MODELS, SOLVERS = {"shallow-water": "ShallowWater", "two-phase": "TwoPhase"}, ("roe", "relaxation", "hll", "rusanov")


def work(tree):
    """Answer requests [model, solver, cells, friction, backend, steps] on standard input by the CPU time of so many steps."""
    sys.path.insert(0, tree)
    warnings.simplefilter("ignore")
    import numpy as np

    import fvkit as fv
    import fvkit_granular as gr

    def bottom(x):
        return 0.1 * np.cos(2.0 * np.pi * x)

    def stepper(model, solver, cells, friction, backend):
        kind = getattr(gr, MODELS[model])()
        riemann = {"roe": fv.Roe, "relaxation": gr.Relaxation, "hll": fv.HLL, "rusanov": fv.Rusanov}[solver]()
        problem = fv.Problem(kind, fv.Grid(0.0, 1.0, cells), lambda x: kind.conserved_from(
            1.0 + 0.4 * np.exp(-100.0 * (x - 0.4) ** 2) - bottom(x), 0.5 + 0.2 * np.sin(2.0 * np.pi * x), 0.1, -0.1), 1e9,
            aux={"b": bottom}, boundary=fv.Periodic(), sources=gr.Manning(0.03) if friction else ())
        result = fv.Stepper(problem, fv.WavePropagation(riemann), backend=backend)
        result.run(np.inf, 200 if backend == "numba" else 4)
        return result

    known = {}
    for line in sys.stdin:
        *case, steps = json.loads(line)
        one = known.setdefault(tuple(case), None) or stepper(*case)
        known[tuple(case)] = one
        start = time.process_time()
        one.run(np.inf, steps)
        print(time.process_time() - start, flush=True)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("trees", nargs="+", help="checkouts; ratios are to the first")
    parser.add_argument("--blocks", type=int, default=15)
    parser.add_argument("--cells", type=int, nargs="+", default=[1000, 100_000])
    parser.add_argument("--friction", nargs="+", default=["none", "Manning"], choices=["none", "Manning"])
    parser.add_argument("--backend", default="numba", choices=["numba", "numpy"])
    options = parser.parse_args()
    running = [subprocess.Popen([sys.executable, __file__, "--work", tree], stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True,
                                env={**os.environ, "PYTHONPATH": tree}) for tree in options.trees]

    def asked(process, *request):
        process.stdin.write(json.dumps(request) + "\n")
        process.stdin.flush()
        return float(process.stdout.readline())

    updates = 2_000_000 if options.backend == "numba" else 100_000
    for friction in [kind == "Manning" for kind in options.friction]:
        for model in MODELS:
            for solver in SOLVERS:
                for cells in options.cells:
                    case, steps = (model, solver, cells, friction, options.backend), max(4, updates // cells)
                    blocks = [[asked(process, *case, steps) for process in running] for _ in range(options.blocks)]
                    best = [1e9 * min(column) / steps / cells for column in zip(*blocks, strict=True)]
                    print(f"{model:14s}{solver:12s}{cells:8d}{' Manning' if friction else '        '}",
                          *(f"{ns:7.1f} ({ns / best[0]:.2f})" for ns in best), flush=True)
    for process in running:
        process.stdin.close()
        process.wait()


if __name__ == "__main__":
    if sys.argv[1:2] == ["--work"]:
        work(sys.argv[2])
    else:
        main()
