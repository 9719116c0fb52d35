"""Errors and observed orders against exact, semi-exact and pseudo-spectral references."""

from functools import cache
from itertools import pairwise

import numpy as np
import pytest

import fvkit as fv
import fvkit_granular as gr
from fvkit_granular.exact import rarefaction_fans, two_phase_riemann
from tests.cases import (
    SOLVERS,
    averages,
    l1,
    name_of,
    orders,
    pseudo_spectral,
    simple_wave,
    slip_over_bottom,
    slip_over_bottom_conserved,
    solve,
    spectral_averages,
    stoker,
)

G = 9.81
R1 = ((3.0, 0.7, -1.4, 0.3), (2.0, 0.4, -0.9, -0.1))


def conserved_from_exact(model, solution, t):
    def state(x):
        seen = solution.at(x, t)
        return model.conserved_from(seen["h"], seen["phi"], seen["vs"], seen["vf"])

    return state


def halves(model, left, right):
    def initial(x):
        return model.conserved_from(*(np.where(x < 0.0, a, b) for a, b in zip(left, right, strict=True)))

    return initial


@cache
def simple_wave_errors(riemann, order):
    model, errors = gr.TwoPhase(), []

    def state(x, t):
        h = simple_wave(x, t)
        v = 2.0 * (np.sqrt(G * h) - np.sqrt(G))
        return model.conserved_from(h, 0.6, v, v)

    for cells in (100, 200, 400, 800):
        grid = fv.Grid(0.0, 10.0, cells)
        solution = solve(
            fv.Problem(model, grid, lambda x: state(x, 0.0), 0.6), fv.WavePropagation(riemann, order=order)
        )
        errors.append(l1(grid, solution.observables()["h"] - averages(lambda x: simple_wave(x, 0.6), grid)))
    return errors


@pytest.mark.parametrize("riemann", SOLVERS, ids=name_of)
def test_the_smooth_simple_wave_is_second_order_with_every_solver(riemann):
    measured = orders(simple_wave_errors(riemann, 2))
    assert measured[0] > 1.85
    assert measured[1:].min() > 1.9


def test_the_smooth_simple_wave_has_its_known_errors_with_roe():
    np.testing.assert_allclose(simple_wave_errors(fv.Roe(), 2), [5.1e-4, 1.37e-4, 3.4e-5, 8.5e-6], rtol=0.1)


def test_the_smooth_simple_wave_is_first_order_at_order_one():
    errors = simple_wave_errors(fv.Roe(), 1)
    np.testing.assert_allclose(errors, [6.48e-3, 3.34e-3, 1.69e-3, 8.48e-4], rtol=0.1)
    assert 0.9 < orders(errors).min() <= orders(errors).max() < 1.05


@cache
def slip_reference():
    return pseudo_spectral(0.15)


def test_the_pseudo_spectral_reference_is_converged():
    fine, coarse = slip_reference(), pseudo_spectral(0.15, 64)
    grid = fv.Grid(0.0, 1.0, 40)
    np.testing.assert_allclose(spectral_averages(coarse, grid), spectral_averages(fine, grid), atol=1e-10)


def test_the_reference_of_the_scene_is_that_solution():
    grid, reference = fv.Grid(0.0, 1.0, 40), gr.scene("slip-over-bottom").known_reference()
    assert reference.kind == "self-converged"
    wanted = spectral_averages(slip_reference(), grid)
    np.testing.assert_allclose(reference.averages(gr.TwoPhase(), grid, 0.15), wanted, atol=1e-12)
    flow = gr.exact.periodic_flow(lambda x: {"h": 1.0 + 0.1 * np.sin(2 * np.pi * x), "phi": 0.5, "vs": 0.0, "vf": 0.0}, np.zeros_like,
                                  0.1, modes=24)
    assert 1e-15 < flow.accuracy < 1e-3
    finer = gr.exact.periodic_flow(lambda x: {"h": 1.0 + 0.1 * np.sin(2 * np.pi * x), "phi": 0.5, "vs": 0.0, "vf": 0.0}, np.zeros_like, 0.1)
    x = np.linspace(0.0, 1.0, 7)
    assert np.abs(flow.at(x, 0.1)["h"] - finer.at(x, 0.1)["h"]).max() < flow.accuracy
    with pytest.raises(ValueError, match="`t` must be that of the flow"):
        flow.at(x, 0.2)


def test_a_flow_that_steepens_is_refused_by_the_pseudo_spectral_reference():
    with pytest.raises(ValueError, match="not resolved by 24 modes"):
        gr.exact.periodic_flow(lambda x: {"h": 1.0 + 0.5 * np.sin(2 * np.pi * x), "phi": 0.5, "vs": 0.0, "vf": 0.0}, np.zeros_like, 0.3,
                               modes=24)


@cache
def slip_errors(riemann, cross_term=True):
    errors = []
    for cells in (40, 80, 160, 320):
        grid = fv.Grid(0.0, 1.0, cells)
        problem = fv.Problem(
            gr.TwoPhase(),
            grid,
            slip_over_bottom_conserved,
            0.15,
            {"b": lambda x: slip_over_bottom(x)[4]},
            fv.Periodic(),
        )
        solution = solve(problem, fv.WavePropagation(riemann, cross_term=cross_term))
        errors.append(l1(grid, solution.q[-1] - spectral_averages(slip_reference(), grid)))
    return errors


def test_slip_over_a_smooth_bottom_has_its_known_errors_with_roe():
    np.testing.assert_allclose(slip_errors(fv.Roe()), [1.6e-3, 4.4e-4, 1.07e-4, 2.47e-5], rtol=0.15)


@pytest.mark.parametrize("riemann", SOLVERS, ids=name_of)
def test_slip_over_a_smooth_bottom_is_second_order_with_every_solver(riemann):
    assert orders(slip_errors(riemann))[1:].min() > 1.85


@pytest.mark.parametrize("riemann", SOLVERS, ids=name_of)
def test_without_the_cross_term_slip_over_a_bottom_is_first_order(riemann):
    measured = orders(slip_errors(riemann, cross_term=False))
    assert 0.8 < measured[-1] < 1.25


@pytest.mark.parametrize(
    ("model", "phi"), [(gr.ShallowWater(), 0.6), (gr.Reduced(), None)], ids=lambda v: name_of(v) or ""
)
def test_the_cross_terms_of_the_single_velocity_models_give_second_order_over_a_bottom(model, phi):
    def initial(x):
        fraction = 0.5 + 0.2 * np.sin(2.0 * np.pi * x) if phi is None else phi
        v = 0.3 + 0.1 * np.cos(2.0 * np.pi * x)
        return model.conserved_from(1.0 + 0.1 * np.sin(2.0 * np.pi * x), fraction, v, v)

    def refine(cross_term):
        states = []
        for cells in (80, 160, 320, 640):
            problem = fv.Problem(model, fv.Grid(0.0, 1.0, cells), initial, 0.15,
                                 {"b": lambda x: 0.1 * np.sin(2.0 * np.pi * x + 0.5)}, fv.Periodic())
            states.append(solve(problem, fv.WavePropagation(fv.Roe(), cross_term=cross_term)).q[-1])
        return orders([np.abs(a - 0.5 * (b[:, ::2] + b[:, 1::2])).mean() for a, b in pairwise(states)])

    assert refine(True).min() > 1.8
    assert refine(False)[-1] < 1.4


STEEP = {
    "shallow water": (gr.ShallowWater, 1.0, ()), "reduced": (gr.Reduced, 0.5, gr.Voellmy(0.1, 300.0)),
    "curvature": (gr.ShallowWater, 1.0, gr.Curvature()), "curvature, Manning": (gr.ShallowWater, 1.0, (gr.Curvature(), gr.Manning(0.06))),
    "two phases": (gr.TwoPhase, 0.5, (gr.ConstantDrag(3.0), gr.Curvature(), gr.CoulombFriction(0.1))),
    "Pitman and Le": (gr.PitmanLe, 0.5, gr.ConstantDrag(3.0)), "two layers": (gr.TwoLayer, 0.5, gr.Manning(0.03)),
}


@pytest.mark.parametrize("riemann", [fv.HLL(), gr.Relaxation()], ids=name_of)
@pytest.mark.parametrize(("kind", "phi", "sources"), STEEP.values(), ids=STEEP)
def test_steep_ground_that_bends_keeps_second_order(kind, phi, sources, riemann):
    """Slopes up to 37 degrees: gravity in the matrix changes along x, and the centripetal force within a step."""
    def bottom(x):
        return 1.2 * np.sin(0.2 * np.pi * x)

    model, found = kind(slope="steep"), []

    def start(x):
        solid = phi + 0.1 * (phi < 1.0) * np.sin(0.2 * np.pi * x)
        return model.conserved_from(3.0 + 0.15 * np.cos(0.2 * np.pi * x) - bottom(x), solid, 1.5 + 0.0 * x, 1.5 + 0.0 * x)

    for cells in (100, 200, 400):
        problem = fv.Problem(model, fv.Grid(0.0, 10.0, cells), start, 0.5, aux={"b": bottom}, boundary=fv.Periodic(), sources=sources)
        found.append(solve(problem, fv.WavePropagation(riemann, fv.NoLimiter())).q[-1])
    coarse, fine = (np.abs(a - 0.5 * (b[:, ::2] + b[:, 1::2])).mean(axis=1) for a, b in pairwise(found))
    assert (np.log2(coarse / fine) > 1.8).all()


@pytest.mark.parametrize(("order", "solid_depth", "bounds"), [(2, 0.0087, [0.0326, 0.0081, 0.0258]),
                                                               (1, 0.0384, [0.1356, 0.0358, 0.1042])])
def test_the_riemann_problem_with_four_different_waves_has_its_known_errors(order, solid_depth, bounds):
    model, grid = gr.TwoPhase(), fv.Grid(-5.0, 5.0, 1000)
    exact = averages(conserved_from_exact(model, two_phase_riemann(*R1), 0.5), grid)
    solution = solve(fv.Problem(model, grid, halves(model, *R1), 0.5), fv.WavePropagation(fv.Roe(), order=order))
    found = np.abs(solution.q[-1] - exact).sum(axis=1) * grid.dx
    assert found[0] == pytest.approx(solid_depth, rel=0.08)
    np.testing.assert_array_less(found[1:], 1.08 * np.array(bounds))


@pytest.mark.parametrize("riemann", SOLVERS, ids=name_of)
def test_the_outer_plateaus_of_that_riemann_problem_are_right_with_every_solver(riemann):
    model, grid = gr.TwoPhase(), fv.Grid(-5.0, 5.0, 400)
    last = solve(fv.Problem(model, grid, halves(model, *R1), 0.5), fv.WavePropagation(riemann)).q[-1]
    behind_the_fan = np.abs(grid.centers + 1.2) < 0.3
    np.testing.assert_allclose(last[0, behind_the_fan], 1.511736, rtol=0.01)
    np.testing.assert_allclose(last[2, behind_the_fan], 0.748424, rtol=0.02)
    between = (grid.centers > 0.1) & (grid.centers < 0.7)
    np.testing.assert_allclose(last[0, between], 1.193917, rtol=0.02)
    np.testing.assert_allclose(last[2, between], 1.213290, rtol=0.02)


def test_fans_in_all_four_fields_converge_with_their_known_errors():
    model = gr.TwoPhase()
    fans = rarefaction_fans((3.0, 0.7, -1.0, -0.8), (0.8, 0.15, 0.15, 0.8))
    np.testing.assert_allclose(fans.right.hs, 2.048851, atol=2e-6)
    errors = []
    for cells in (100, 200, 400, 800):
        grid = fv.Grid(-8.0, 8.0, cells)
        problem = fv.Problem(model, grid, conserved_from_exact(model, fans, 0.25), 1.0, t_start=0.25)
        exact = averages(conserved_from_exact(model, fans, 1.0), grid)
        errors.append(l1(grid, solve(problem, fv.WavePropagation(fv.Roe())).q[-1] - exact))
    np.testing.assert_allclose(errors, [0.295, 0.115, 0.0458, 0.0179], rtol=0.1)
    assert orders(errors).min() > 1.25


@pytest.mark.parametrize(("eps", "high", "low"), [(0.2, 0.097748, -0.010185), (0.01, 0.005026, -0.000521)])
def test_a_pulse_over_a_hump_leaves_the_known_surface(eps, high, low):
    model, grid = gr.TwoPhase(g=1.0), fv.Grid(-1.0, 1.0, 3200)

    def bottom(x):
        return np.where(np.abs(x - 0.5) < 0.1, 0.25 * (np.cos(10.0 * np.pi * (x - 0.5)) + 1.0), 0.0)

    def initial(x):
        return model.conserved_from(1.0 - bottom(x) + eps * ((x > 0.1) & (x < 0.2)), 0.6)

    solution = solve(fv.Problem(model, grid, initial, 0.7, {"b": bottom}), fv.WavePropagation(fv.Roe()))
    seen = solution.observables()
    surface = seen["surface"][grid.centers > 0.0] - 1.0
    assert surface.max() == pytest.approx(high, rel=0.01)
    assert surface.min() == pytest.approx(low, rel=0.01)
    assert np.abs(seen["phi"] - 0.6).max() < 1e-12


def transonic(cells, entropy_fix):
    """Largest step of the depth between the cells next to x = 0, as computed and as exact."""
    model, grid = gr.TwoPhase(), fv.Grid(-8.0, 8.0, cells)
    problem = fv.Problem(model, grid, halves(model, (10.0, 0.6), (0.5, 0.6)), 0.5)
    h = solve(problem, fv.WavePropagation(fv.Roe(), entropy_fix=entropy_fix)).observables()["h"]
    exact = averages(lambda x: stoker(x, 0.5, 10.0, 0.5)[0], grid)
    near = slice(cells // 2 - 4, cells // 2 + 4)
    return np.abs(np.diff(h[near])).max(), np.abs(np.diff(exact[near])).max(), l1(grid, h - exact)


@pytest.mark.parametrize("cells", [100, 200, 400])
def test_a_transonic_dam_break_has_no_step_at_the_sonic_point(cells):
    found, exact, _ = transonic(cells, entropy_fix=True)
    assert found <= 1.5 * exact


def test_without_the_entropy_fix_the_transonic_dam_break_has_one():
    found, exact, _ = transonic(400, entropy_fix=False)
    assert found > 1.5 * exact


def test_the_transonic_dam_break_converges_to_the_exact_one():
    errors = [transonic(cells, entropy_fix=True)[2] for cells in (100, 200, 400)]
    assert orders(errors).min() > 0.7


def standing_expansion(model, entropy_fix, cells=200):
    """Depth after t = 1 of h 2|1 with h v = sqrt(3 g) on both sides: the jump of the fluxes is zero."""
    left, right = (
        (2.0, 0.6, np.sqrt(3.0 * G) / 2.0, np.sqrt(3.0 * G) / 2.0),
        (1.0, 0.6, np.sqrt(3.0 * G), np.sqrt(3.0 * G)),
    )
    problem = fv.Problem(model, fv.Grid(-8.0, 8.0, cells), halves(model, left, right), 1.0)
    return solve(problem, fv.WavePropagation(fv.Roe(), entropy_fix=entropy_fix)).observables()["h"]


@pytest.mark.parametrize("model", [gr.TwoPhase(), gr.ShallowWater(), gr.Reduced()], ids=name_of)
def test_a_standing_expansion_shock_decays_with_the_entropy_fix_and_stays_without(model):
    def jump(entropy_fix):
        return np.abs(np.diff(standing_expansion(model, entropy_fix)[95:105])).max()

    assert jump(True) < 0.15
    assert jump(False) > 0.9


@pytest.mark.parametrize("riemann", [*SOLVERS, gr.Relaxation()], ids=name_of)
@pytest.mark.parametrize("model", [gr.TwoPhase(), gr.Reduced(), gr.ShallowWater()], ids=name_of)
def test_a_vacuum_that_opens_is_computed_with_every_solver(model, riemann):
    left, right = (1e-3, 0.6, -20.0, -20.0), (3.0, 0.6, 20.0, 20.0)
    problem = fv.Problem(model, fv.Grid(-5.0, 5.0, 200), halves(model, left, right), 0.2)
    solution = solve(problem, fv.WavePropagation(riemann), nonhyperbolic="ignore")
    assert (solution.q[:, list(model.mass_rows())] >= 0.0).all()
    assert solution.stats.steps < 130
    exact = gr.exact.shallow_water_riemann((1e-3, -20.0), (3.0, 20.0)).at(problem.grid.centers, 0.2)
    assert np.abs(solution.observables()["h"] - exact["h"]).mean() < 0.02


@pytest.mark.parametrize("riemann", SOLVERS, ids=name_of)
@pytest.mark.parametrize("model", [gr.TwoPhase(), gr.Reduced(), gr.ShallowWater()], ids=name_of)
def test_dry_cells_are_data_whatever_the_solver(model, riemann):
    problem = fv.Problem(model, fv.Grid(-5.0, 5.0, 50), halves(model, (1.0, 0.6), (0.0, 0.6)), 0.2)
    solution = solve(problem, fv.WavePropagation(riemann), nonhyperbolic="ignore")
    assert (solution.q[:, list(model.mass_rows())] >= 0.0).all()


@pytest.mark.parametrize("riemann", SOLVERS, ids=name_of)
@pytest.mark.parametrize("phi", [0.0, 1.0])
def test_an_absent_phase_is_accepted_as_data_whatever_the_solver(phi, riemann):
    model = gr.TwoPhase()
    problem = fv.Problem(model, fv.Grid(-5.0, 5.0, 50), halves(model, (2.0, phi), (1.0, 0.5)), 0.2)
    solution = solve(problem, fv.WavePropagation(riemann), nonhyperbolic="ignore")
    assert (solution.q[:, [0, 2]] >= 0.0).all()
