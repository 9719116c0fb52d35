"""Steady flow over a bottom: `python -m tests.benchmarks.steady_flow` prints, for each solver at orders 1 and 2,

* subcritical flow of 4.42 m2/s over a bump, from 2 m of water: the change of the depth in the last of 24,000 steps, 396 s, and the largest error of the
  discharge;
* rivers of a mixture with Manning friction over a bump: how far any component of q still ranges within 100 s after 1900 s;
* SWASHES 7.1.1, a dam break over a step of one face: the error of the discharge, order 2.

The tables of docs/solvers.
"""

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


def river(model, scheme):
    """Return the largest range of any component of q between 1900 and 2000 s, m or m2/s, of 3 m2/s over a bump with friction."""
    state = model.conserved_from(2.0, 0.4, 1.5, 1.5)
    sources = (gr.Manning(0.03), *((gr.ConstantDrag(1.0),) if len(model.phases) > 1 else ()))
    problem = fv.Problem(model, fv.Grid(0.0, 800.0, 160), lambda x: [0.0 * x + value for value in state], 2000.0,
                         {"b": lambda x: 0.3 * np.exp(-((x - 400.0) / 80.0) ** 2) - 0.002 * x},
                         (gr.Hydrograph([0.0], [3.0], [0.4]), fv.Outflow()), sources)
    return np.ptp(fv.solve(problem, scheme, times=np.linspace(1900.0, 2000.0, 11)).q[1:], axis=0).max()


def over_a_step(model, scheme, cells=400):
    """Return the observables of SWASHES 7.1.1 after 1 s: 4 m | 1 m of water over a step of 1 m at one face, x from -10 to 10 m."""
    scene = gr.Scene((-10.0, 10.0), 1.0, lambda x: {"h": np.where(x < 0, 4.0, 1.0), "phi": 0.5},
                     bottom=lambda x: np.where(x < 0, 0.0, 1.0), slope="mild")
    return fv.solve(scene.problem(model, cells), scheme).observables()


#: Discharge over the step of `over_a_step`, m2/s, exact by Bernoulli's theorem, and the cell before it, where that is seen.
STEP_DISCHARGE, BEFORE_STEP = 4.678, 194


if __name__ == "__main__":
    for riemann in (fv.Roe(), fv.HLL(), fv.Rusanov(), gr.Relaxation()):
        name, schemes = type(riemann).__name__, [fv.WavePropagation(riemann, order=order) for order in (1, 2)]
        print("|", name, *(f"| {change:.0e} m, {discharge:.0e} m²/s" for change, discharge in map(settled, schemes)), "|")
        ranges = [river(model, scheme) for model in (gr.ShallowWater(), gr.Reduced(), gr.TwoPhase()) for scheme in schemes]
        seen = over_a_step(gr.TwoPhase, schemes[1])
        error = 100.0 * (seen["h"][BEFORE_STEP] * seen["v"][BEFORE_STEP] / STEP_DISCHARGE - 1.0)
        print("|", name, *(f"| {value:.0e}" for value in ranges), f"| {error:+.1f} % |")
