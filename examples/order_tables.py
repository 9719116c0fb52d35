"""Observed orders on smooth flow
==============================

The tables of docs/high_order.md.

Usage: python examples/order_tables.py [FOLDER] [--full]     (--full: the finest grids, and drag of 1e3 and 1e4 1/s)
"""

import sys
from functools import partial

import attrs
import numpy as np

import fvkit as fv
import fvkit_granular as gr
from fvkit_granular.scenes.reference import FunctionReference

FULL = "--full" in sys.argv
CELLS = (20, 40, 80, 160) if FULL else (20, 40, 80)


def show(title, problem_of, scheme, cells, reference):
    table = fv.convergence(problem_of, scheme, cells, reference)
    errors = " ".join(f"{total:.1e}" for total in table.totals)
    print(f"{title:44s} N = {', '.join(map(str, cells)):18s} {errors}   order {table.total_orders[-1]:.2f}", flush=True)


def with_drag(drag, together):
    """The scene slip-over-bottom with constant drag, from vs = vf where ``together``, and its reference."""
    scene = gr.scene("slip-over-bottom")

    def start(x):
        at = scene.initial(x)
        return {**at, "vf": at["vs"]} if together else at

    solved = gr.exact.periodic_flow(start, scene.bottom, scene.t_end, drag=drag)
    reference = FunctionReference("self-converged", "Fourier pseudo-spectral", at=solved.at)
    return attrs.evolve(scene, initial=start, sources=gr.ConstantDrag(drag), reference=reference)


def main():
    high = fv.MethodOfLines(fv.Roe(), integrator=fv.DP5())
    slip, wave = gr.scene("slip-over-bottom"), gr.scene("simple-wave")
    for scene, cells in ((slip, CELLS), (wave, (100, 200, 400, 800) if FULL else (50, 100, 200))):
        of, reference = partial(scene.problem, gr.TwoPhase), scene.known_reference()
        for name, scheme in (("MP5, DP5", high), ("MP5, SSPRK104", fv.MethodOfLines(fv.Roe())),
                             ("WENO5, SSPRK104", fv.MethodOfLines(fv.Roe(), fv.WENO5())),
                             ("MUSCL, SSPRK3", fv.MethodOfLines(fv.Roe(), fv.MUSCL(), fv.SSPRK3())),
                             ("wave propagation, MC", fv.WavePropagation(fv.Roe()))):
            show(f"{scene.name}: {name}", of, scheme, cells, reference)
    for drag, together in ((1.0, False), (100.0, False), *(((1e3, True), (1e4, True)) if FULL else ())):
        scene = with_drag(drag, together)
        for name, integrator in (("ARK4", fv.ARK4()), ("DP5, Strang", fv.DP5())):
            show(f"drag {drag:g} 1/s: MP5, {name}", partial(scene.problem, gr.TwoPhase),
                 fv.MethodOfLines(fv.Roe(), integrator=integrator), CELLS, scene.known_reference())


if __name__ == "__main__":
    np.seterr(all="ignore")
    main()
