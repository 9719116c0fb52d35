"""Sweeps over lines of several pieces, in place and on several threads; the memory that they need."""

import tracemalloc

import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal

import fvkit as fv
import fvkit_granular as gr
from fvkit.backends.layout import LINE, PAGE, padded_rows
from tests.plane.problems import CLOSED, rough, square, state


def stepper(model, riemann, grid, backend="numba", threads=1, sources=()):
    q, b = rough(model, grid, speed=0.3)
    problem = fv.Problem(model, grid, q, 1e9, aux={"b": 0.05 * b}, boundary=CLOSED, sources=sources)
    return fv.Stepper(problem, fv.WavePropagation(riemann), backend=backend, threads=threads, nonhyperbolic="ignore")


@pytest.mark.parametrize("cells", [(20, 150), (1300, 18)], ids=["along y", "along x"])
@pytest.mark.parametrize("sources", [(), (gr.Manning(0.02),)], ids=["free", "Manning"])
def test_lines_of_several_pieces_agree_with_numpy_and_between_threads(cells, sources):
    grid = fv.Grid((0.0, 0.0), (float(cells[0]), float(cells[1])), cells)
    found = []
    for backend, threads in (("numba", 1), ("numba", 2), ("numpy", 1)):
        one = stepper(gr.ShallowWater(), fv.Roe(), grid, backend, threads, sources)
        one.run(1e9, 6)
        found.append(one.q.copy())
    assert_array_equal(found[0], found[1])
    assert_allclose(found[0], found[2], rtol=0.0, atol=1e-12 * np.abs(found[2]).max())


@pytest.mark.parametrize(("model", "riemann"), [(gr.ShallowWater(), fv.Roe()), (gr.TwoPhase(), gr.Relaxation())])
def test_memory_beyond_the_state_is_at_most_two_states_and_a_few_megabytes(model, riemann):
    def made(n):
        grid = square(n)
        problem = fv.Problem(model, grid, state(model, np.ones(grid.shape), 0.5, (1.0, 0.5), (0.2, 0.1)), 1e9,
                             aux={"b": np.broadcast_to(0.1 * np.sin(np.arange(n)), grid.shape)}, boundary=CLOSED)
        tracemalloc.start()
        one = fv.Stepper(problem, fv.WavePropagation(riemann), backend="numba", nonhyperbolic="ignore")
        one.run(1e9, 2)
        held = tracemalloc.get_traced_memory()[0]
        tracemalloc.stop()
        return held, problem.q0.nbytes

    made(20)  # compiles
    held, own = made(600)
    assert held - own <= 2.2 * own + 4e6


@pytest.mark.parametrize("shape", [(5, 7), (20, 508), (7, 512), (5, 516)])
@pytest.mark.parametrize("halo", [1, 2, 3])
def test_cells_of_every_line_begin_at_a_cache_line_and_lines_are_no_pages_apart(shape, halo):
    rows = padded_rows(2, shape, halo)
    assert rows.shape == (2, *shape)
    assert not rows.any()
    assert (rows[:, :, halo:].ctypes.data // 8) % LINE == 0
    assert rows.strides[1] % (8 * LINE) == 0
    assert rows.strides[1] % (8 * PAGE)
    assert rows.strides[0] == shape[0] * rows.strides[1]
