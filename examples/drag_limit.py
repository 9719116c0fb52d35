"""Drag turns the two-phase flow into the reduced model: a dam break with a phi jump, for growing drag.

Usage: python examples/drag_limit.py [FOLDER]     (writes drag_limit.png there; default: the current folder)
"""

import sys
from pathlib import Path

import attrs
import numpy as np

import fvkit as fv
import fvkit_granular as gr
from fvkit.plot import COLORS, new_axes


def main(folder: Path, cells: int = 400) -> None:
    scene = gr.scene("dam-break-phi")
    x = fv.Grid(*scene.interval, cells).centers
    limit = gr.exact.reduced_riemann((3.0, 0.7, 0.0), (2.0, 0.4, 0.0), g=scene.g, gamma=scene.gamma).at(x, scene.t_end)
    figure, (depth, slip) = new_axes(1, 2)
    depth.plot(x, limit["h"], color="0.7", linewidth=4.0, label="reduced, exact")
    for color, drag in zip(COLORS, (0.0, 1.0, 10.0, 100.0, 1000.0), strict=False):
        problem = attrs.evolve(scene, sources=gr.ConstantDrag(drag)).problem(gr.TwoPhase, cells)
        seen = fv.solve(problem, fv.WavePropagation(fv.Roe())).observables()
        away = np.abs(seen["h"] - limit["h"]).sum() * problem.grid.dx
        largest = np.abs(seen["vs"] - seen["vf"]).max()
        print(f"D = {drag:6g} 1/s: largest slip {largest:8.2e} m/s, L1 distance of h from the reduced model {away:.2e}")
        depth.plot(x, seen["h"], color=color, label=f"D = {drag:g}")
        slip.plot(x, seen["vs"] - seen["vf"], color=color)
    depth.set(xlabel="x, m", ylabel="h, m")
    slip.set(xlabel="x, m", ylabel="vs - vf, m/s")
    depth.legend(fontsize="small")
    folder.mkdir(parents=True, exist_ok=True)
    figure.savefig(folder / "drag_limit.png", dpi=130)


if __name__ == "__main__":
    main(Path(sys.argv[1] if len(sys.argv) > 1 else "."))
