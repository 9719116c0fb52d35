"""Memory of a run whose outputs go to disk: 1000 outputs of 100,000 cells, 8 GB. Run by hand, in a folder with room for it."""

import resource
import sys
from pathlib import Path

import numpy as np

import fvkit as fv
import fvkit_granular as gr


def peak() -> float:
    """Largest memory of this process so far, MB."""
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024


def main(outputs: int = 1000, cells: int = 100_000) -> None:
    scheme = fv.WavePropagation(gr.Relaxation(), order=1)
    problem = gr.scene("dam-break-phi").problem(gr.TwoPhase, cells)
    fv.solve(problem, scheme, limits=fv.Limits(steps=3), throw=False)
    fv.solve(gr.scene("dam-break-phi").problem(gr.TwoPhase, 1000), scheme, [0.1], record=fv.Stream("stream_memory.nc"))
    before, dt = peak(), fv.Stepper(problem, scheme).dt
    fv.solve(problem, scheme, 0.9 * dt * np.arange(1, outputs + 1), record=fv.Stream("stream_memory.nc"))
    size = Path("stream_memory.nc").stat().st_size / 1e6
    Path("stream_memory.nc").unlink()
    print(f"{outputs} outputs of {cells} cells: {size:.0f} MB on disk, largest memory {before:.0f} MB before, {peak():.0f} MB after")


if __name__ == "__main__":
    main(*map(int, sys.argv[1:]))
