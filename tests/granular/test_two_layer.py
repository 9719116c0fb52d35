"""Two-layer shallow water: its matrix, its speeds, its rest, internal jumps, and what every model must pass."""

import numpy as np
import pytest
from scipy.optimize import root

import fvkit as fv
import fvkit_granular as gr
from fvkit.pointwise.part import public_name
from fvkit_granular.models import two_masses
from fvkit_granular.scenes.library.model_differences import two_layer_rest
from tests.cases import name_of, orders, rest_bottom, solve, two_layer_forces
from tests.granular.checks import (
    G,
    check_both_backends_agree,
    check_masses_are_kept,
    check_masses_stay_positive,
    check_the_waves_add_up,
    conserved,
    integral_along,
    order_errors,
    random_faces,
    schemes,
    serving,
    steps,
    two_layers,
)

DENSITIES = (0.3, 0.7, 0.98)
SOLVERS = serving(gr.TwoLayer())


def matrix_of_the_equations(q, gamma, g=G):
    """The quasi-linear matrix (4, 4, n); complex q allowed."""
    hs, ms, hf, mf = q
    vs, vf, o = ms / hs, mf / hf, 0.0 * hs
    return np.array([[o, o + 1, o, o], [g * hs - vs**2, 2 * vs, g * gamma * hs, o], [o, o, o, o + 1],
                     [g * hf, o, g * hf - vf**2, 2 * vf]])


def test_its_name_and_the_solvers_that_serve_it():
    assert public_name(gr.TwoLayer()) == "two-layer"
    assert {type(solver) for solver in SOLVERS} == {fv.Roe, fv.HLL, fv.Rusanov, gr.Relaxation}


@pytest.mark.parametrize("gamma", DENSITIES)
def test_the_jump_is_the_integral_along_the_segment_of_depths_and_velocities(gamma, monkeypatch):
    monkeypatch.setattr(two_masses, "kinetic_head", lambda *face: 0.0)  # the head over a step, beyond the path
    left, right = random_faces(1)
    rng = np.random.default_rng(2)
    bl, br = rng.uniform(0.0, 0.1, (2, left.shape[1]))

    def path(s):
        return np.array(conserved(left + s * (right - left)))

    expected = integral_along(path, lambda q: matrix_of_the_equations(q.real, gamma))
    expected[1] += G * 0.5 * (left[0] + right[0]) * (br - bl)
    expected[3] += G * 0.5 * (left[2] + right[2]) * (br - bl)
    found = np.array(gr.TwoLayer(G, gamma).jump(tuple(conserved(left)), tuple(conserved(right)), (bl,), (br,)))
    assert np.abs(found - expected).max() < 1e-12 * np.abs(expected).max()


@pytest.mark.parametrize("gamma", DENSITIES)
def test_the_jump_is_the_flux_difference_plus_the_product(gamma):
    left, right = random_faces(2)
    model, zero = gr.TwoLayer(G, gamma), np.zeros(left.shape[1])
    ql, qr = conserved(left), conserved(right)
    expected = np.array(model.flux(tuple(qr))) - np.array(model.flux(tuple(ql)))
    expected[1] += gamma * G * 0.5 * (ql[0] + qr[0]) * (qr[2] - ql[2])
    expected[3] += G * 0.5 * (ql[2] + qr[2]) * (qr[0] - ql[0])
    found = np.array(model.jump(tuple(ql), tuple(qr), (zero,), (zero,)))
    assert np.abs(found - expected).max() < 1e-13 * np.abs(expected).max()
    total = [m**2 / h for h, m in ((ql[0], ql[1]), (ql[2], ql[3]), (qr[0], qr[1]), (qr[2], qr[3]))]
    pressure = [G / 2 * (q[0] ** 2 + gamma * q[2] ** 2) + gamma * G * q[0] * q[2] for q in (ql, qr)]
    mixture = total[2] + gamma * total[3] + pressure[1] - (total[0] + gamma * total[1] + pressure[0])
    assert np.abs(found[1] + gamma * found[3] - mixture).max() < 1e-12 * np.abs(mixture).max()


@pytest.mark.parametrize("gamma", DENSITIES)
def test_the_roe_matrix_maps_the_jump_of_states_to_the_jump_and_waves_are_its_eigenvectors(gamma):
    left, right = random_faces(3, fastest=0.5)
    model, zero = gr.TwoLayer(G, gamma), np.zeros(left.shape[1])
    ql, qr = conserved(left), conserved(right)
    face = (tuple(ql), tuple(qr), (zero,), (zero,))
    jump = np.array(model.jump(*face))
    assert np.abs(np.array(model.matrix_product(*face, tuple(qr - ql))) - jump).max() < 1e-13 * np.abs(jump).max()
    waves, speeds = model.decompose(*face, tuple(jump))
    apart = (speeds[2] - speeds[1]) > 1e-2
    assert apart.mean() > 0.5
    for wave, speed in zip(waves, speeds, strict=True):
        residual = np.array(model.matrix_product(*face, wave)) - speed * np.array(wave)
        assert np.abs(residual[:, apart]).max() < 1e-10 * np.abs(jump).max()


@pytest.mark.parametrize("gamma", DENSITIES)
def test_matrix_and_eigenvectors(gamma):
    q = conserved(random_faces(4, fastest=0.5)[0])
    model = gr.TwoLayer(G, gamma)
    matrices = model.matrix(q)
    np.testing.assert_allclose(matrices, matrix_of_the_equations(q, gamma), atol=1e-13)
    speeds, vectors = model.eigenvalues(q), model.eigenvectors(q)
    clear = np.abs(model.hyperbolicity_margin(q)) > 1e-4
    residual = np.abs(np.einsum("ijn,jkn->ikn", matrices, vectors) - speeds * vectors)[..., clear].max()
    assert residual < 1e-10 * np.abs(vectors).max()


@pytest.mark.parametrize("ratio", [0.3, 0.5, 0.7, 0.95])
def test_speeds_are_the_eigenvalues_on_the_random_set_of_the_literature(ratio):
    """h in [1, 2], upper u in [0, .3], lower in [-.3, 0], g 9.8 (the ranges of a public Roe-accuracy test)."""
    rng = np.random.default_rng(8)
    q = conserved((rng.uniform(1.0, 2.0, 10_000), rng.uniform(-0.3, 0.0, 10_000), rng.uniform(1.0, 2.0, 10_000),
                   rng.uniform(0.0, 0.3, 10_000)))
    expected = np.sort_complex(np.linalg.eigvals(np.moveaxis(matrix_of_the_equations(q, ratio, 9.8), -1, 0))).T
    assert np.abs(gr.TwoLayer(9.8, ratio).eigenvalues(q) - expected).max() < 1e-12


@pytest.mark.parametrize("gamma", [0.05, *DENSITIES])
def test_loss_of_hyperbolicity_is_flagged_where_numpy_finds_complex_speeds_and_never_in_the_safe_range(gamma):
    rng = np.random.default_rng(9)
    hs, hf = 10.0 ** rng.uniform(-3.0, 0.5, (2, 5000))
    vs, vf = rng.uniform(-6.0, 6.0, (2, 5000))
    q, model = conserved((hs, vs, hf, vf)), gr.TwoLayer(G, gamma)
    numpy = np.linalg.eigvals(np.moveaxis(model.matrix(q), -1, 0)).T
    margin, discriminant = model.hyperbolicity_margin(q), np.asarray(model.hyperbolic_discriminant(tuple(q), tuple(q)))
    clear = np.abs(margin) > 1e-6
    lost = np.abs(numpy.imag).max(axis=0) > 1e-6
    assert 50 < lost.sum() < 4950
    np.testing.assert_array_equal(margin[clear] < 0.0, lost[clear])
    np.testing.assert_array_equal((discriminant < 0.0)[clear], lost[clear])
    assert np.asarray(model.may_lose_hyperbolicity(tuple(q), tuple(q)))[lost].all()
    low, high = model.wave_speeds(tuple(q))
    assert (numpy.real >= low - 1e-9).all()
    assert (numpy.real <= high + 1e-9).all()


def test_equal_velocities_have_their_speeds_in_closed_form():
    g, gamma, hs, hf, v = 9.81, 0.7, 0.8, 0.5, 0.3
    split = np.sqrt((hs - hf) ** 2 + 4.0 * gamma * hs * hf)
    outer, inner = np.sqrt(g / 2 * (hs + hf + split)), np.sqrt(g / 2 * (hs + hf - split))
    found = gr.TwoLayer(g, gamma).eigenvalues(conserved((hs, v, hf, v))[:, None])[:, 0]
    np.testing.assert_allclose(found, [v - outer, v - inner, v + inner, v + outer], rtol=1e-13)


def test_the_waves_add_up_for_any_data():
    check_the_waves_add_up(gr.TwoLayer())


def test_conversion_and_observables_name_the_layers():
    model = gr.TwoLayer(gamma=0.9)
    seen = model.observables(model.conserved_from(2.0, 0.25, 1.0, -1.0)[:, None], {"b": np.array([0.5])})
    assert {name: float(value[0]) for name, value in seen.items()} == pytest.approx(
        {"h": 2.0, "phi": 0.25, "vs": 1.0, "vf": -1.0, "v": (0.5 - 0.9 * 1.5) / (0.5 + 0.9 * 1.5), "surface": 2.5, "interface": 1.0})


@pytest.mark.parametrize("scheme", schemes(gr.TwoLayer()), ids=lambda s: f"{name_of(s.riemann)}-{s.order}")
def test_level_layers_stay_at_rest_over_a_hump_and_a_step(scheme):
    model = gr.TwoLayer(gamma=0.9)
    problem = fv.Problem(model, fv.Grid(0.0, 2.0, 40), lambda x: two_layers(model, 0.3, 0.7 - rest_bottom(x)), 1e3,
                         {"b": rest_bottom})
    stepper = steps(problem, scheme, 300)
    np.testing.assert_allclose(stepper.q, problem.q0, atol=1e-13)


@pytest.mark.parametrize("scheme", schemes(gr.TwoLayer()), ids=lambda s: f"{name_of(s.riemann)}-{s.order}")
def test_an_island_through_one_layer_and_one_through_both_stay_at_rest(scheme):
    model, grid = gr.TwoLayer(gamma=0.9), fv.Grid(0.0, 2.0, 80)
    x = grid.centers
    b = 0.65 * np.exp(-(((x - 0.5) / 0.15) ** 2)) + np.where(np.abs(x - 1.4) < 0.2, 1.3, 0.0) + np.where(np.abs(x - 1.7) < 0.1, 0.6, 0.0)
    below = np.maximum(0.5 - b, 0.0)
    above = np.maximum(0.9 - b - below, 0.0)
    q = np.array([below, 0.0 * x, above, 0.0 * x])
    assert (below == 0.0).sum() > 10
    assert 5 < (above == 0.0).sum() < 20
    stepper = steps(fv.Problem(model, grid, q, 1e3, {"b": b}), scheme, 200)
    np.testing.assert_allclose(stepper.q, q, atol=1e-13)


def test_two_layers_over_a_bump_rest_for_ten_seconds():
    problem = two_layer_rest().problem(gr.TwoLayer, 100)
    for scheme in schemes(problem.model, orders=(2,)):
        np.testing.assert_allclose(solve(problem, scheme).q[-1], problem.q0, atol=1e-12)


def test_a_perturbed_upper_layer_sends_waves_and_stays_small():
    solution = solve(two_layer_rest(perturbed=True).problem(gr.TwoLayer, 100), fv.WavePropagation(fv.Roe()))
    seen = solution.observables()
    assert 1e-4 < np.abs(seen["surface"] - 0.6).max() < 0.05
    assert np.abs(seen["interface"] - 0.5).max() < 0.05


def test_uniform_solid_share_is_no_rest():
    model = gr.TwoLayer()
    problem = fv.Problem(model, fv.Grid(0.0, 2.0, 40), lambda x: model.conserved_from(1.0 - rest_bottom(x), 0.6), 1e3,
                         {"b": rest_bottom})
    assert np.abs(model.observables(steps(problem, fv.WavePropagation(fv.Roe()), 10).q)["vs"]).max() > 0.01


def test_masses_are_kept():
    check_masses_are_kept(gr.TwoLayer())


@pytest.mark.parametrize("solver", SOLVERS, ids=name_of)
def test_slip_over_a_smooth_bottom_is_second_order_with_every_solver(solver):
    errors = order_errors(gr.TwoLayer(), solver, two_layer_forces)
    assert orders(errors)[-1] > 1.9
    assert errors[-1] < 5.5e-5


def test_without_the_cross_term_it_is_first_order():
    assert orders(order_errors(gr.TwoLayer(), fv.Roe(), two_layer_forces, cross_term=False))[-1] < 1.25


def single_internal_shock(model, left, depth):
    """The right state of depth ``depth`` of the lower layer and the speed of a shock of the third field, J = s dq."""
    hs, vs, hf, vf = left
    ql = conserved(left)

    def mismatch(unknown):
        v_below, above, v_above, speed = unknown
        qr = conserved((depth, v_below, above, v_above))
        jump = model.jump(tuple(ql), tuple(qr), (0.0,), (0.0,))
        return np.array(jump) - speed * (qr - ql)

    start = [vs, hf + hs - depth, vf, model.eigenvalues(ql[:, None])[2, 0].real]
    v_below, above, v_above, speed = root(mismatch, start, tol=1e-14).x
    assert np.abs(mismatch((v_below, above, v_above, speed))).max() < 1e-12
    return conserved((depth, v_below, above, v_above)), speed


@pytest.mark.parametrize(("solver", "tolerance"), [(fv.Roe(), 2e-3), (gr.Relaxation(), 2e-2)], ids=name_of)
def test_a_single_internal_shock_moves_at_its_rankine_hugoniot_speed(solver, tolerance):
    model, grid = gr.TwoLayer(10.0, 0.9), fv.Grid(-1.0, 2.0, 300)
    ql = conserved((0.4, 0.5, 0.6, 0.5))
    qr, speed = single_internal_shock(model, (0.4, 0.5, 0.6, 0.5), 0.3)
    assert 0.6 < speed < 1.2
    problem = fv.Problem(model, grid, np.where(grid.centers < 0.0, ql[:, None], qr[:, None]), 1.0)
    hs = solve(problem, fv.WavePropagation(solver)).q[-1, 0]
    middle = 0.5 * (ql[0] + qr[0])
    k = np.flatnonzero((hs[:-1] >= middle) & (hs[1:] < middle))[-1]
    position = grid.centers[k] + grid.dx * (hs[k] - middle) / (hs[k] - hs[k + 1])
    assert position == pytest.approx(speed, abs=tolerance + grid.dx)
    face = (tuple(ql), tuple(qr), (0.0,), (0.0,))
    waves = np.array(model.decompose(*face, model.jump(*face))[0])
    assert np.abs(waves[[0, 1, 3]]).max() < 1e-10 * np.abs(waves[2]).max()


def test_the_moving_internal_jump_splits_into_two_internal_waves_of_the_current():
    """Its states differ by the interface alone: both internal waves go with the current, and the surface stays level."""
    problem = gr.scene("internal-jump").problem(gr.TwoLayer, 800)
    solution = solve(problem, fv.WavePropagation(fv.Roe()), nonhyperbolic="ignore")
    seen, x, t = solution.observables(), problem.grid.centers, solution.t[-1]
    assert np.abs(seen["surface"] - 1.0).max() < 2e-3
    slow, fast = (problem.model.eigenvalues(problem.q0[:, [k]])[1:3, 0].real for k in (0, -1))
    assert slow == pytest.approx(2.5 + np.array([-1, 1]) * np.sqrt(0.05), abs=4e-3)
    inside = np.abs(x - 2.5 * t) < 0.1
    star = seen["interface"][inside].mean()
    assert star == pytest.approx(0.475, abs=2e-3)
    for upper, lower, expected in ((0.5, star, slow[0]), (star, 0.45, fast[1])):
        crossing = x[np.flatnonzero(seen["interface"] < 0.5 * (upper + lower))[0]]
        assert crossing / t == pytest.approx(expected, abs=0.03)


@pytest.mark.parametrize("name", ["internal-dam-break", "two-layer-step"])
def test_the_other_two_layer_scenes_run_with_every_solver_and_converge(name):
    coarse = [solve(gr.scene(name).problem(gr.TwoLayer, 100), fv.WavePropagation(solver), nonhyperbolic="ignore").q[-1]
              for solver in SOLVERS]
    fine = solve(gr.scene(name).problem(gr.TwoLayer, 400), fv.WavePropagation(fv.Roe()), nonhyperbolic="ignore").q[-1]
    for q in coarse:
        assert np.abs(q - fine.reshape(4, 100, 4).mean(axis=2)).mean() < 0.03 * np.abs(fine).max()


@pytest.mark.parametrize("scheme", schemes(gr.TwoLayer()), ids=lambda s: f"{name_of(s.riemann)}-{s.order}")
def test_masses_stay_positive_at_vacuum_and_where_a_layer_is_absent(scheme):
    check_masses_stay_positive(gr.TwoLayer(), scheme)


@pytest.mark.parametrize("solver", [fv.Roe(), gr.Relaxation()], ids=name_of)
def test_compiled_equals_numpy(solver):
    check_both_backends_agree(gr.TwoLayer(), solver)
