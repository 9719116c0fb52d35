"""Time of a step on a grid with two axes, as ratios within one run.

    python tests/benchmarks/two_axes.py [--cells 1000] [--blocks 5]

Prints ns per cell and step of second order, one thread, all wet; the ratio to two steps on a line of 10,000 cells; what two threads
gain; and the share of the time of a grid of twice the cells along each axis that takes the same with 1 % of it wet. Runs alternate;
each number is the least of its blocks.
"""

import argparse
import time
from collections.abc import Callable

import numpy as np

import fvkit as fv
import fvkit_granular as gr
from fvkit.problem.directions import in_plane


def plane(model, n, wet=1.0):
    """A problem of n x n cells, of which a share stands under water."""
    grid = fv.Grid((0.0, 0.0), (10.0, 10.0), (n, n))
    x, y = np.meshgrid(*(axis.centers for axis in grid.axes))
    h = 1.0 + 0.3 * np.exp(-((x - 5.0)**2 + (y - 5.0)**2))
    if wet < 1.0:
        h = np.where(np.hypot(x - 5.0, y - 5.0) < 10.0 * np.sqrt(wet / np.pi), h, 0.0)
    q = in_plane(model, model.conserved_from(h, 0.6, 0.3, 0.1), model.conserved_from(h, 0.6, 0.1, 0.2))
    return fv.Problem(model, grid, q, 1e9, aux={"b": 0.1 * np.sin(x) * np.cos(y)}, boundary=fv.Wall())


def line(model, n=10_000):
    """The same along x."""
    x = fv.Grid(0.0, 10.0, n).centers
    q = model.conserved_from(1.0 + 0.3 * np.exp(-(x - 5.0)**2), 0.6, 0.3, 0.1)
    return fv.Problem(model, fv.Grid(0.0, 10.0, n), q, 1e9, aux={"b": 0.1 * np.sin(x)}, boundary=fv.Wall())


def stepping(problem, riemann, steps, threads=1) -> Callable[[], float]:
    """A function that takes steps and returns ns per cell and step."""
    stepper = fv.Stepper(problem, fv.WavePropagation(riemann), backend="numba", threads=threads, nonhyperbolic="ignore")
    stepper.run(1e9, 2)

    def block() -> float:
        started = time.perf_counter()
        stepper.run(1e9, steps)
        return 1e9 * (time.perf_counter() - started) / steps / problem.grid.size

    return block


def alternated(runs: dict[str, Callable[[], float]], blocks: int) -> dict[str, float]:
    """The least of several blocks of each, taken in turns."""
    found = dict.fromkeys(runs, np.inf)
    for _ in range(blocks):
        for name, block in runs.items():
            found[name] = min(found[name], block())
    return found


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--cells", type=int, default=1000, help="cells along each axis")
    parser.add_argument("--blocks", type=int, default=5, help="alternated blocks of each run")
    given = parser.parse_args()
    water, phases = gr.ShallowWater(dry=1e-8), gr.TwoPhase(dry=1e-8)
    print("| model and solver | ns per cell and step | over two steps on a line | one thread over two |\n|---|---|---|---|")
    for model, riemann in ((water, fv.Roe()), (water, gr.Relaxation()), (phases, fv.Roe()), (phases, gr.Relaxation())):
        problem = plane(model, given.cells)
        found = alternated({"plane": stepping(problem, riemann, 4), "line": stepping(line(model), riemann, 300),
                            "threads": stepping(problem, riemann, 4, threads=2)}, given.blocks)
        print(f"| {type(model).__name__}, {type(riemann).__name__} | {found['plane']:.0f} | {found['plane'] / found['line'] / 2:.2f} | "
              f"{found['plane'] / found['threads']:.2f} |", flush=True)
    found = alternated({name: stepping(plane(water, 2 * given.cells, share), fv.Roe(), 4)
                        for name, share in (("all", 1.0), ("some", 0.01))}, given.blocks)
    print(f"\n{2 * given.cells} x {2 * given.cells} cells of ShallowWater, Roe, 1 % wet: {100 * found['some'] / found['all']:.1f} % of "
          "the time of all wet")


if __name__ == "__main__":
    main()
