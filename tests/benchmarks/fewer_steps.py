"""Cell updates to an error of 1 % and 0.1 %, by Courant number and limiter: `python -m tests.benchmarks.fewer_steps [--cells N ...]`.

An update is one cell in one step. The error is the L1 error of h at the end over the L1 change of h since the start: of what moved, how much is wrong. Steps and
errors depend on no machine; numbers between grids are interpolated in log-log. `-`: not reached on the finest grid, `<`: reached on the coarsest.
Full model, order 2, the five scenes of examples/work_precision.py, with the reference that each has (perturbed-rest: MP5 on 6400 cells,
self-converged). The table of docs/work_precision.md has the rows of Roe and Relaxation.
"""

from functools import cache

import numpy as np

import fvkit as fv
import fvkit_granular as gr
from tests.benchmarks.chapter import asked

NAMES = ("simple-wave", "slip-over-bottom", "riemann", "dam-break-phi", "perturbed-rest")
RIEMANN = {"Roe": fv.Roe(), "Relaxation": gr.Relaxation(), "HLL": fv.HLL(), "Rusanov": fv.Rusanov()}
CHOICES = {"MC, 0.9": (fv.MC(), 0.9), "MC, 0.97": (fv.MC(), 0.97), "ThirdOrder, 0.9": (fv.ThirdOrder(), 0.9), "ThirdOrder, 0.97": (fv.ThirdOrder(), 0.97)}
TARGETS = (1e-2, 1e-3)

#: Cells of the run that is the reference of a scene without one.
FINE = 6400


def reference(scene, problem):
    """Return the reference of a scene as cell averages at its end: its own, or a finer run, self-converged."""
    known = scene.known_reference()
    return fine(scene.name).reshape(4, problem.grid.size, -1).mean(axis=-1) if known is None else known.averages(
        problem.model, problem.grid, scene.t_end)


@cache
def fine(name):
    return fv.solve(gr.scene(name).problem(gr.TwoPhase, FINE), fv.MethodOfLines(fv.Roe())).q[-1]


def curve(scene, scheme, cells):
    """Return the updates and the relative errors of each number of cells."""
    updates, errors = [], []
    for n in cells:
        problem = scene.problem(gr.TwoPhase, n)
        solution = fv.solve(problem, scheme)
        start, end, exact = (problem.model.observables(q)["h"] for q in (solution.q[0], solution.q[-1], reference(scene, problem)))
        errors.append(np.abs(end - exact).sum() / np.abs(exact - start).sum())
        updates.append(n * solution.stats.steps)
    return np.array(updates, float), np.array(errors)


def needed(updates, errors, target):
    """Return the updates at which the error falls to ``target``, as it is printed."""
    if errors[0] <= target:
        return f"<{_two_digits(updates[0])}"
    if errors.min() > target:
        return "-"
    last = int(np.argmax(errors <= target))
    between = slice(last - 1, last + 1)
    return _two_digits(np.exp(np.interp(-np.log(target), -np.log(errors[between]), np.log(updates[between]))))


def _two_digits(number):
    return f"{float(f'{number:.2g}'):,.0f}"


def main():
    given = asked(__doc__, cells=[25, 50, 100, 200, 400, 800, 1600])
    found = {(name, label): [curve(gr.scene(name), fv.WavePropagation(riemann, limiter, cfl=cfl), given.cells) for limiter, cfl in CHOICES.values()]
             for name in NAMES for label, riemann in RIEMANN.items()}
    for target in TARGETS:
        print(f"\n| to {target:.1%} | {' | '.join(CHOICES)} |\n|---|{'---|' * len(CHOICES)}")
        for (name, label), curves in found.items():
            print(f"| {name}, {label} | {' | '.join(needed(*one, target) for one in curves)} |")


if __name__ == "__main__":
    main()
