"""A known steady flow as background: every scheme keeps it to rounding and resolves small waves on it."""

import numpy as np
import pytest

import fvkit as fv
import fvkit_granular as gr
from fvkit.schemes.background import Deviation
from fvkit_granular.scenes.library.steady_flow import STEADY, profile, smooth_bump
from tests.cases import name_of, random_states, solve

MODEL = gr.TwoPhase()

SCHEMES = (fv.WavePropagation(fv.Roe(), order=1), fv.WavePropagation(fv.Roe()), fv.WavePropagation(fv.HLL()),
           fv.WavePropagation(fv.Rusanov()), fv.WavePropagation(gr.Relaxation()),
           fv.WavePropagation(fv.Roe(), in_cell_shocks=True), fv.MethodOfLines(fv.Roe()),
           fv.MethodOfLines(fv.HLL(), fv.WENO5(), fv.DP5()), fv.MethodOfLines(gr.Relaxation(), fv.MUSCL(), fv.SSPRK3()))


def run(name, scheme, eps=0.0, background=True, cells=100, backend="numpy", t=1.0):
    """State at t of a steady flow with a wave of height eps on it, and the averages of the flow."""
    flow = profile(name)
    grid = fv.Grid(*flow.interval, cells)
    averages = flow.averages(MODEL, grid)
    centre, length = 0.3 * grid.upper, 0.1 * grid.upper
    wave = np.where(np.abs(grid.centers - centre) < length, np.cos(0.5 * np.pi * (grid.centers - centre) / length) ** 2, 0.0)
    start = averages * (1.0 + eps * wave)
    problem = fv.Problem(MODEL, grid, start, t, {"b": flow.bottom}, background=averages if background else None)
    return fv.solve(problem, scheme, backend=backend), averages


@pytest.mark.parametrize("scheme", SCHEMES, ids=lambda s: f"{name_of(s)}-{name_of(s.riemann)}")
@pytest.mark.parametrize("name", tuple(STEADY))
def test_every_scheme_keeps_a_steady_flow_to_rounding(name, scheme):
    solution, averages = run(name, scheme, t=0.5)
    assert np.abs(solution.q[-1] - averages).max() < 1e-13 * np.abs(averages).max()
    assert max(map(abs, solution.stats.mass_drift.values())) < 1e-13


@pytest.mark.parametrize("scheme", [SCHEMES[1], SCHEMES[4], SCHEMES[6]], ids=lambda s: f"{name_of(s)}-{name_of(s.riemann)}")
@pytest.mark.parametrize("name", ["moving-slip", "transcritical-bump"])
def test_a_wave_of_a_millionth_is_resolved(name, scheme):
    eps = 1e-6

    def response(background, size):
        solution, averages = run(name, scheme, size, background, t=0.5)
        return (solution.q[-1] - averages) / size

    linear = response(True, 10.0 * eps)
    assert np.abs(linear).max() > 0.1
    assert np.abs(response(True, eps) - linear).max() < 1e-4 * np.abs(linear).max()
    assert np.abs(response(False, eps) - linear).max() > 0.2 * np.abs(linear).max()


@pytest.mark.parametrize("scheme", [SCHEMES[2], SCHEMES[4], SCHEMES[6], fv.MethodOfLines(fv.HLL(), fv.MUSCL(), fv.SSPRK3())],
                         ids=lambda s: f"{name_of(s)}-{name_of(s.riemann)}")
def test_both_backends_agree_on_waves_on_a_background(scheme):
    pytest.importorskip("numba")
    arrays, compiled = (run("moving-slip", scheme, 1e-2, backend=backend, t=0.2)[0].q[-1] for backend in ("numpy", "numba"))
    np.testing.assert_allclose(compiled, arrays, rtol=0, atol=1e-12)


@pytest.mark.parametrize("scheme", [SCHEMES[1], SCHEMES[6]], ids=lambda s: name_of(s))
def test_a_background_given_as_a_function_serves_as_well(scheme):
    flow = profile("moving-slip")
    grid = fv.Grid(*flow.interval, 80)

    def state(x):
        return MODEL.conserved_from(**flow.at(x))

    problem = fv.Problem(MODEL, grid, state, 0.3, {"b": smooth_bump}, background=state)
    assert np.abs(solve(problem, scheme).q[-1] - problem.q0).max() < 1e-13


def test_far_from_its_background_a_scheme_is_as_accurate_as_without():
    flow = profile("moving-slip")
    grid = fv.Grid(*flow.interval, 200)

    def start(x):
        at = flow.at(x)
        return MODEL.conserved_from(**{**at, "h": at["h"] + 0.3 * np.exp(-((x - 3.0) ** 2))})

    def end(cells, background):
        grid = fv.Grid(*flow.interval, cells)
        given = flow.averages(MODEL, grid) if background else None
        return solve(fv.Problem(MODEL, grid, start, 0.6, {"b": smooth_bump}, background=given), fv.WavePropagation(fv.Roe())).q[-1]

    fine = end(1600, background=False).reshape(4, grid.num_cells, -1).mean(axis=2)
    errors = [np.abs(end(200, background) - fine).mean() for background in (False, True)]
    assert errors[1] < 1.1 * errors[0]


def test_a_model_seen_from_a_flow_sees_nothing_there_and_splits_as_before():
    seen, q = Deviation(MODEL), tuple(random_states(50, seed=1))
    other = tuple(row[::-1] for row in q)
    bl, br = np.linspace(0.0, 0.3, 50), np.linspace(0.2, 0.1, 50)
    at, nowhere = ((bl, *q), (br, *other)), np.zeros(50)
    for value in (*seen.jump(q, other, *at), *seen.balanced_difference(q, other, *at)):
        np.testing.assert_array_equal(value, nowhere)
    jump = MODEL.jump(q, other, (bl,), (br,))
    (waves, speeds), (own, own_speeds) = (model.decompose(q, other, *aux, jump) for model, aux in
                                          ((seen, at), (MODEL, ((bl,), (br,)))))
    np.testing.assert_array_equal(np.array(waves), np.array(own))
    np.testing.assert_array_equal(np.array(speeds), np.array(own_speeds))


@pytest.mark.parametrize(("background", "message"), [(np.ones((4, 7)), "background"), (np.full((4, 20), np.nan), "background"),
                                                     (-np.ones((4, 20)), "`background` must have hs >= 0"),
                                                     (lambda x: np.ones(3), "background")])
def test_a_wrong_background_is_named(background, message):
    with pytest.raises(ValueError, match=message):
        fv.Problem(MODEL, fv.Grid(0.0, 1.0, 20), np.ones((4, 20)), 1.0, background=background)
