"""Compiled code computes the same to the last bit wherever a cell stands: in a vector or behind the last, at either end of a tile."""

import numpy as np
import pytest

import fvkit as fv
import fvkit_granular as gr
from fvkit.backends.compiled.loops import TILE

pytest.importorskip("numba")

CELLS = 2 * TILE + 83
SCHEMES = [(gr.PitmanLe(), fv.WavePropagation(gr.Relaxation())), (gr.TwoPhase(), fv.WavePropagation(fv.Roe())),
           (gr.ShallowWater(), fv.MethodOfLines(fv.Rusanov()))]


@pytest.mark.parametrize(("model", "scheme"), SCHEMES, ids=["pitman-le", "two-phase", "lines"])
def test_a_ring_that_is_turned_gives_the_same_state_turned(model, scheme):
    rng = np.random.default_rng(5)
    h, phi, vs, vf = (rng.uniform(low, high, CELLS) for low, high in ((0.5, 1.5), (0.2, 0.8), (-1.0, 1.0), (-1.0, 1.0)))
    h[:40] = 0.0
    q, b = model.conserved_from(h, phi, vs, vf), 0.1 * rng.random(CELLS)
    found = []
    for shift in (0, 171, TILE):
        problem = fv.Problem(model, fv.Grid(0.0, 1.0, CELLS), np.roll(q, shift, axis=1), 1.0, aux={"b": np.roll(b, shift)}, boundary=fv.Periodic())
        stepper = fv.Stepper(problem, scheme, backend="numba", nonhyperbolic="ignore")
        stepper.run(problem.t_end, 4)
        found.append(np.roll(stepper.q, -shift, axis=1))
    assert np.array_equal(found[1], found[0])
    assert np.array_equal(found[2], found[0])
