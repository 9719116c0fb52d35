"""AvaFrame's Kot as a lake with islands, steep equations, 30 s: `python -m tests.benchmarks.lake FOLDER`, which holds avaKot.asc (see kot).

The table of docs/validation/terrain.md.
"""

import sys
from pathlib import Path

import numpy as np

import fvkit as fv
import fvkit_granular as gr


def main(folder):
    terrain = gr.read_terrain(Path(folder) / "avaKot.asc")
    b = np.where(np.isnan(terrain.bottom), np.nanmax(terrain.bottom) + 100.0, terrain.bottom)
    for share in (0.3, 0.6):
        level = np.nanquantile(terrain.bottom, share)
        h = np.maximum(level - b, 0.0)
        for model in (gr.ShallowWater(slope="steep"), gr.TwoPhase(slope="steep")):
            q = np.zeros((3 * len(model.phases), *b.shape))
            q[::3] = model.conserved_from(h, 0.4)[::2]
            solution = fv.solve(fv.Problem(model, terrain.grid, q, 30.0, aux={"b": b}, boundary=fv.Wall()))
            moved = np.abs(np.delete(solution.q[-1], np.s_[::3], axis=0)).max()
            raised = np.abs(solution.q[-1][::3].sum(axis=0) - h).max()
            fastest = max(values.max() for name, values in solution.observables().items() if name.startswith("speed"))
            print(f"{type(model).__name__}, {h.max():.0f} m: momentum {moved:.0e} m2/s, depth {raised:.0e} m, speed {fastest:.0e} m/s")


if __name__ == "__main__":
    main(sys.argv[1])
