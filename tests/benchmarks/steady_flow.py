"""Subcritical flow of 4.42 m2/s over a bump, from 2 m of water: `python -m tests.benchmarks.steady_flow` prints, for each solver at orders 1 and 2, the
change of the depth in the last of 24,000 steps, 396 s, and the largest error of the discharge. The table of docs/solvers/index.md."""

import numpy as np

import fvkit as fv
import fvkit_granular as gr


def settled(scheme, steps=24_000):
    """Return the change of the depth in the last step, m, and the largest error of the discharge, m2/s."""
    def bump(x):
        return np.where(abs(x - 10.0) < 2.0, 0.2 - 0.05 * (x - 10.0) ** 2, 0.0)

    ends = gr.Hydrograph((0.0,), (4.42,), (0.0,)), gr.FixedLevel(2.0)
    problem = fv.Problem(gr.ShallowWater(), fv.Grid(0.0, 25.0, 200), lambda x: [2.0 - bump(x), 4.42 + 0.0 * x], 400.0,
                         aux={"b": bump}, boundary=ends)
    stepper = fv.Stepper(problem, scheme)
    for _ in range(steps - 1):
        stepper.step(0.0165)
    before = stepper.q[0].copy()
    stepper.step(0.0165)
    return np.abs(stepper.q[0] - before).max(), np.abs(stepper.q[1] - 4.42).max()


if __name__ == "__main__":
    for riemann in (fv.Roe(), fv.HLL(), fv.Rusanov(), gr.Relaxation()):
        found = [settled(fv.WavePropagation(riemann, order=order)) for order in (1, 2)]
        print("|", type(riemann).__name__, *(f"| {change:.0e} m, {discharge:.0e} m²/s" for change, discharge in found), "|")
