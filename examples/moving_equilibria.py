"""What schemes keep of a steady flow over a bump
==============================================

Drifts from the steady flow, and what is resolved of a wave of a micrometre on it.

Usage: python examples/moving_equilibria.py     (prints the tables of docs/moving_equilibria.md)
"""

import numpy as np

import fvkit as fv
import fvkit_granular as gr
from fvkit_granular.scenes.library.steady_flow import STEADY, profile

MODEL, CELLS, EPS = gr.TwoPhase(), 100, 1e-6

#: Schemes that are run from exact averages, without and with the flow as background.
SCHEMES = {"Roe, MC": fv.WavePropagation(fv.Roe()), "HLL, MC": fv.WavePropagation(fv.HLL()),
           "Relaxation, MC": fv.WavePropagation(gr.Relaxation()), "Roe, MP5": fv.MethodOfLines(fv.Roe())}


def plain(flow):
    """Roe's scheme; without a background the entropy fix takes a transcritical flow for a transonic rarefaction."""
    return fv.WavePropagation(fv.Roe(), entropy_fix=flow.crest is None)


def end(scheme, grid, q, bottom, background=None):
    """State after 1 s."""
    return fv.solve(fv.Problem(MODEL, grid, q, 1.0, {"b": bottom}, background=background), scheme).q[-1]


def raised(grid, q, eps):
    """The state with a wave of height eps one fifth of the way along."""
    middle, width = grid.lower + 0.2 * (grid.upper - grid.lower), 0.05 * (grid.upper - grid.lower)
    wave = np.where(np.abs(grid.centers - middle) < width, np.cos(0.5 * np.pi * (grid.centers - middle) / width) ** 2, 0.0)
    at = MODEL.observables(q)
    return MODEL.conserved_from(at["h"] + eps * wave, at["phi"], at["vs"], at["vf"])


def depth(q):
    return np.abs(q[0] + q[2]).max()


def missed(scheme, grid, q, bottom, background, on=None):
    """Error of the response to a wave of EPS on q, over EPS, against the linear response on the flow ``on``."""
    base = q if on is None else on
    linear = (end(scheme, grid, raised(grid, base, 1e-4), bottom, background)
              - end(scheme, grid, raised(grid, base, -1e-4), bottom, background)) / 2e-4
    return depth((end(scheme, grid, raised(grid, q, EPS), bottom, background) - q) / EPS - linear)


def without_background():
    print(f"{'no background, Roe':20s}  from values  from averages  discrete   wave on averages  wave on discrete")
    for name in STEADY:
        flow = profile(name)
        grid, scheme = fv.Grid(*flow.interval, CELLS), plain(flow)
        values, averages, discrete = (MODEL.conserved_from(**flow.at(grid.centers)), flow.averages(MODEL, grid),
                                      flow.discrete(MODEL, grid))
        starts = ((values, flow.bottom(grid.centers)), (averages, flow.bottom), (discrete, flow.bottom))
        drifts = [depth(end(scheme, grid, q, b) - q) for q, b in starts]
        errors = [missed(scheme, grid, q, flow.bottom, None, discrete) for q in (averages, discrete)]
        print(f"{name:20s}  {drifts[0]:11.1e}  {drifts[1]:13.1e}  {drifts[2]:8.0e}  {errors[0]:17.1e}  {errors[1]:16.1e}")


def with_background():
    print(f"\n{'drift / wave':20s}  " + "  ".join(f"{name:>32s}" for name in SCHEMES))
    for name in STEADY:
        flow = profile(name)
        grid = fv.Grid(*flow.interval, CELLS)
        averages = flow.averages(MODEL, grid)
        texts = []
        for scheme in SCHEMES.values():
            alone = depth(end(scheme, grid, averages, flow.bottom) - averages)
            kept = depth(end(scheme, grid, averages, flow.bottom, averages) - averages)
            texts.append(f"{alone:8.0e} -> {kept:6.0e} / {missed(scheme, grid, averages, flow.bottom, averages):8.1e}")
        print(f"{name:20s}  " + "  ".join(f"{text:>32s}" for text in texts))


if __name__ == "__main__":
    without_background()
    with_background()
