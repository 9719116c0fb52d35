"""Convergence and sweeps of runs on grids with two axes."""

from importlib.util import find_spec

import numpy as np
import pytest

import fvkit as fv
import fvkit_granular as gr
from tests.plane.scenes import pool


def wave(x, y, t):
    """A sine that travels with the velocity (1, 0.5)."""
    return np.sin(2.0 * np.pi * (x - t) + 2.0 * np.pi * (y - 0.5 * t))[None]


def travelling(n, rows=None):
    grid = fv.Grid((0.0, 0.0), (1.0, 2.0), (n, 2 * n if rows is None else rows))
    return fv.Problem(fv.Advection((1.0, 0.5)), grid, lambda x, y: wave(x, y, 0.0), 0.2, boundary=fv.Periodic())


@pytest.mark.parametrize("norm", ["l1", "l2", "max"])
def test_the_order_is_seen_and_norms_are_integrals(norm):
    scheme = fv.WavePropagation(fv.Roe(), order=1)
    found = fv.convergence(travelling, scheme, (16, 32), wave, norm=norm, backend="numpy")
    solution = fv.solve(travelling(32), scheme, backend="numpy")
    x, y = (axis.centers for axis in solution.grid.axes)
    factor = np.sinc(1.0 / 32) * np.sinc(1.0 / 32)  # averages of the sine over the cells, exactly
    difference = np.abs(solution.q[-1, 0] - factor * wave(x[None, :], y[:, None], 0.2)[0])
    wanted = {"l1": difference.mean() * 2.0, "l2": np.sqrt((difference**2).mean() * 2.0), "max": difference.max()}[norm]
    assert found.errors[1, 0] == pytest.approx(wanted, rel=1e-8)
    assert found.total_orders[-1] == pytest.approx(1.0, abs=0.2)


def test_the_default_scheme_is_of_second_order_without_a_reference():
    found = fv.convergence(travelling, fv.WavePropagation(fv.Roe(), limiter=fv.NoLimiter()), (8, 16, 32), expect=1.8, backend="numpy")
    solutions = [fv.solve(travelling(n), fv.WavePropagation(fv.Roe(), limiter=fv.NoLimiter()), backend="numpy") for n in (16, 32)]
    fine = solutions[1].q[-1, 0]
    onto = 0.25 * (fine[::2, ::2] + fine[1::2, ::2] + fine[::2, 1::2] + fine[1::2, 1::2])
    assert found.errors[1, 0] == pytest.approx(np.abs(solutions[0].q[-1, 0] - onto).mean() * 2.0, rel=1e-12)


def test_components_have_the_names_of_the_plane():
    found = fv.convergence(lambda n: pool(cells=(n, n), t_end=0.05), cells=(4, 8, 16), backend="numpy")
    assert found.names == ("h", "h v_x", "h v_y")
    assert found.errors.shape == (2, 3)
    assert "h v_y" in str(found)


@pytest.mark.parametrize(("problem_of", "words"), [
    (lambda n: travelling(2 * n), r"`problem_of\(4\)` must have 4 cells along x, got 8"),
    (lambda n: travelling(n, n + 1), r"`cells` must grow by a whole factor along every axis without a reference, got 5 cells and")])
def test_grids_that_do_not_fit_are_refused(problem_of, words):
    with pytest.raises(ValueError, match=words):
        fv.convergence(problem_of, cells=(4, 8, 16), backend="numpy")


def level(height, cells=5):
    """A member of a sweep: a pool with more or less water in it."""
    problem = fv.Problem(gr.ShallowWater(), fv.Grid((0.0, 0.0), (1.0, 2.0), (cells, 5)), lambda x, y: [height + x, 0.0 * x, y], 0.01)
    return fv.solve(problem, backend="numpy")


@pytest.mark.parametrize("cells", [4, 5])
def test_a_sweep_keeps_maps(cells):
    result = fv.sweep(level, {"height": [1.0, 2.0], "cells": [cells] * 2}, workers=1, keep=["h", "speed", "max.h", "steps"])
    assert result.success
    one = level(2.0, cells)
    assert np.array_equal(result.outputs["h"][1], one.q[-1, 0])
    assert np.array_equal(result.outputs["speed"][1], one.observables()["speed"])
    assert result.outputs["max.h"][1] == one.q[-1, 0].max()
    assert np.array_equal(result.outputs["y"][0], one.grid.axes[1].centers)
    if find_spec("xarray"):
        data = result.to_xarray()
        assert data["h"].dims == ("member", "y", "x")
        assert np.array_equal(data["x"], one.grid.axes[0].centers)
        assert np.array_equal(data["h"][1], one.q[-1, 0])


def test_a_front_needs_one_axis():
    result = fv.sweep(level, {"height": [1.0]}, workers=1, keep="front.h")
    assert result.status.tolist() == ["error"]
    assert "front.h needs a grid with one axis, got one with two" in result.message[0]
