"""What a scheme keeps of a steady flow over a bump, and what it resolves of a wave of a micrometre on it.

Usage: python examples/moving_equilibria.py     (prints the table of docs/moving_equilibria.md)
"""

import numpy as np

import fvkit as fv
import fvkit_granular as gr
from fvkit_granular.moving_scenes import STEADY, profile

MODEL, CELLS, EPS = gr.TwoPhase(), 100, 1e-6


def end(flow, grid, q, bottom):
    """State after 1 s; the entropy fix would take a transcritical flow for a transonic rarefaction."""
    scheme = fv.WavePropagation(fv.Roe(), entropy_fix=flow.crest is None)
    return fv.solve(fv.Problem(MODEL, grid, q, 1.0, {"b": bottom}), scheme).q[-1]


def raised(grid, q, eps):
    """The state with a wave of height eps one fifth of the way along."""
    middle, width = grid.lower + 0.2 * (grid.upper - grid.lower), 0.05 * (grid.upper - grid.lower)
    wave = np.where(np.abs(grid.centers - middle) < width, np.cos(0.5 * np.pi * (grid.centers - middle) / width) ** 2, 0.0)
    at = MODEL.observables(q)
    return MODEL.conserved_from(at["h"] + eps * wave, at["phi"], at["vs"], at["vf"])


def depth(q):
    return np.abs(q[0] + q[2]).max()


def main():
    print(f"{'N = 100, t = 1 s':20s}  from values  from averages  discrete   wave on averages  wave on discrete")
    for name in STEADY:
        flow = profile(name)
        grid = fv.Grid(*flow.interval, CELLS)
        values, averages, discrete = (MODEL.conserved_from(**flow.at(grid.centers)), flow.averages(MODEL, grid),
                                      flow.discrete(MODEL, grid))
        starts = ((values, flow.bottom(grid.centers)), (averages, flow.bottom), (discrete, flow.bottom))
        drifts = [depth(end(flow, grid, q, b) - q) for q, b in starts]
        linear = (end(flow, grid, raised(grid, discrete, 1e-4), flow.bottom)
                  - end(flow, grid, raised(grid, discrete, -1e-4), flow.bottom)) / 2e-4
        errors = [depth((end(flow, grid, raised(grid, q, EPS), flow.bottom) - q) / EPS - linear) for q in (averages, discrete)]
        print(f"{name:20s}  {drifts[0]:11.1e}  {drifts[1]:13.1e}  {drifts[2]:8.0e}  {errors[0]:17.1e}  {errors[1]:16.1e}")


if __name__ == "__main__":
    main()
