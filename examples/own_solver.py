"""Your own Riemann solver
=======================

A blend of Rusanov and HLL, for every model, compared on one scene.

Usage: python examples/own_solver.py [FOLDER]     (writes the report there; default: own_solver)
"""

import sys
from pathlib import Path

import attrs

import fvkit as fv
import fvkit_granular as gr
from fvkit.pointwise import combine, maximum, minimum, subtract


@attrs.frozen
class Blend(fv.RiemannSolver):
    """HLL with both bounds widened towards the larger one by ``share``: 0 is HLL, 1 is Rusanov."""

    share: float = 0.5

    def solve(self, model, ql, qr, auxl, auxr, jump):
        lowl, highl = model.wave_speeds(ql)
        lowr, highr = model.wave_speeds(qr)
        low, high = minimum(lowl, lowr), maximum(highl, highr)
        size = maximum(-low, high)
        s1 = low - self.share * (size + low)
        s2 = high + self.share * (size - high)
        difference = model.balanced_difference(ql, qr, auxl, auxr)
        first = combine(s1 * s2 / (s2 - s1), difference, -s1 / (s2 - s1), jump)
        return (first, subtract(jump, first)), (s1, s2)


def main(folder: Path) -> None:
    report = gr.compare(gr.scene("dam-break"), [gr.TwoPhase], [fv.HLL(), Blend(), fv.Rusanov()], cells=(100, 200, 400), repeats=1)
    print(report.table())
    report.save(folder)


if __name__ == "__main__":
    main(Path(sys.argv[1] if len(sys.argv) > 1 else "own_solver"))
