"""The fluid momentum of Pitman and Le: the new product, its path, its speeds, and what every model must pass."""

import numpy as np
import pytest

import fvkit as fv
import fvkit_granular as gr
from fvkit.pointwise.part import public_name
from fvkit_granular.models import two_masses
from tests.cases import l1, name_of, orders, pitman_le_forces, rest_bottom, solve
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
)

DENSITIES = (0.05, 0.5, 0.98)
SOLVERS = serving(gr.PitmanLe())


def matrix_of_the_equations(q, gamma):
    """The quasi-linear matrix (4, 4, n): that of TwoPhase, and -(1-phi) vf times the gradient of hs vs - hs vf."""
    hs, ms, hf, mf = q
    vs, vf, o = ms / hs, mf / hf, 0.0 * hs
    k = mf / (hs + hf)
    return np.array([[o, o + 1, o, o],
                     [G * hs + G * (1 - gamma) / 2 * hf - vs**2, 2 * vs, G * (1 + gamma) / 2 * hs, o], [o, o, o, o + 1],
                     [G * hf + k * vf, -k, G * hf - vf**2 - k * hs * vf / hf, 2 * vf + k * hs / hf]])


def test_its_name_and_the_solvers_that_serve_it():
    assert public_name(gr.PitmanLe()) == "pitman-le"
    assert {type(solver) for solver in SOLVERS} == {fv.HLL, fv.Rusanov, gr.Relaxation}
    with pytest.raises(ValueError, match=r"Roe cannot serve PitmanLe.*HLL.*Relaxation.*Rusanov"):
        fv.Roe().check(gr.PitmanLe())


@pytest.mark.parametrize("gamma", DENSITIES)
def test_the_jump_is_the_integral_along_its_path(gamma, monkeypatch):
    """The segment in hs, hf, k = (1 - phi) vf and S = hs (vs - vf), which determine the state."""
    monkeypatch.setattr(two_masses, "kinetic_head", lambda *face: 0.0)  # the head over a step, beyond the path
    left, right = random_faces(1)
    rng = np.random.default_rng(2)
    bl, br = rng.uniform(0.0, 0.1, (2, left.shape[1]))

    def coordinates(hs, vs, hf, vf):
        return np.array([hs, hf, hf * vf / (hs + hf), hs * (vs - vf)])

    start, end = coordinates(*left), coordinates(*right)

    def path(s):
        hs, hf, k, slip = start + s * (end - start)
        vf = k * (hs + hf) / hf
        return np.array(conserved((hs, vf + slip / hs, hf, vf)))

    expected = integral_along(path, lambda q: matrix_of_the_equations(q.real, gamma), nodes=60)
    expected[1] += G * 0.5 * (left[0] + right[0]) * (br - bl)
    expected[3] += G * 0.5 * (left[2] + right[2]) * (br - bl)
    found = np.array(gr.PitmanLe(G, gamma).jump(tuple(conserved(left)), tuple(conserved(right)), (bl,), (br,)))
    assert np.abs(found - expected).max() < 1e-11 * np.abs(expected).max()


def test_the_jump_is_that_of_two_phase_plus_the_product_and_equal_where_both_velocities_are():
    left, right = random_faces(3)
    zero = np.zeros(left.shape[1])
    face = (tuple(conserved(left)), tuple(conserved(right)), (zero,), (zero,))
    k = [hf * vf / (hs + hf) for hs, _, hf, vf in (left, right)]
    slip = [hs * (vs - vf) for hs, vs, _, vf in (left, right)]
    expected = np.array(gr.TwoPhase().jump(*face))
    expected[3] -= 0.5 * (k[0] + k[1]) * (slip[1] - slip[0])
    np.testing.assert_allclose(np.array(gr.PitmanLe().jump(*face)), expected, atol=1e-12)
    left[1], right[1] = left[3], right[3]
    face = (tuple(conserved(left)), tuple(conserved(right)), (zero,), (zero,))
    np.testing.assert_allclose(gr.PitmanLe().jump(*face), gr.TwoPhase().jump(*face), atol=1e-12)


@pytest.mark.parametrize("gamma", DENSITIES)
def test_matrix_speeds_and_eigenvectors(gamma):
    q = conserved(random_faces(4)[0])
    model = gr.PitmanLe(G, gamma)
    matrices = model.matrix(q)
    np.testing.assert_allclose(matrices, matrix_of_the_equations(q, gamma), atol=1e-12)
    speeds, vectors = model.eigenvalues(q), model.eigenvectors(q)
    assert (np.diff(speeds.real, axis=0) >= -1e-12).all()
    clear = np.abs(model.hyperbolicity_margin(q)) > 1e-3
    size = np.abs(vectors).max(axis=(0, 1)) * np.abs(matrices).max(axis=(0, 1))
    residual = np.abs(np.einsum("ijn,jkn->ikn", matrices, vectors) - speeds * vectors).max(axis=(0, 1)) / size
    assert residual[clear].max() < 1e-10
    unit = tuple(np.random.default_rng(5).uniform(-1.0, 1.0, q.shape))
    zero = np.zeros(q.shape[1])
    product = np.array(model.matrix_product(tuple(q), tuple(q), (zero,), (zero,), unit))
    np.testing.assert_allclose(product, np.einsum("ijn,jn->in", matrices, unit), atol=1e-12)


def any_states(seed, count, fastest):
    """States whose solid fraction is down to 1e-6 away from 0 or 1 in half of the cases."""
    rng = np.random.default_rng(seed)
    h, small = rng.uniform(0.05, 3.0, count), 0.99 * 10.0 ** rng.uniform(-6.0, 0.0, count)
    phi = np.select([rng.random(count) < 0.25, rng.random(count) < 0.33], [small, 1.0 - small], rng.uniform(0.01, 0.99, count))
    vs, vf = rng.uniform(-fastest, fastest, (2, count))
    return conserved((phi * h, vs, (1.0 - phi) * h, vf))


@pytest.mark.parametrize("fastest", [1.0, 5.0, 20.0])
@pytest.mark.parametrize("gamma", DENSITIES)
def test_speeds_lie_within_the_bounds(gamma, fastest):
    q, model = any_states(6, 20_000, fastest), gr.PitmanLe(G, gamma)
    speeds, (low, high) = model.eigenvalues(q), model.wave_speeds(tuple(q))
    assert (speeds.real >= low - 1e-6).all()
    assert (speeds.real <= high + 1e-6).all()


@pytest.mark.parametrize("gamma", DENSITIES)
def test_real_speeds_lie_within_the_bounds_however_fast_the_flow(gamma):
    q, model = any_states(7, 20_000, 100.0), gr.PitmanLe(G, gamma)
    speeds, (low, high) = model.eigenvalues(q), model.wave_speeds(tuple(q))
    real = np.abs(speeds.imag).max(axis=0) == 0.0
    assert (speeds.real >= low - 1e-6)[:, real].all()
    assert (speeds.real <= high + 1e-6)[:, real].all()


@pytest.mark.parametrize("gamma", DENSITIES)
def test_faces_are_counted_exactly_where_a_pair_is_complex(gamma):
    q, model = any_states(8, 20_000, 5.0), gr.PitmanLe(G, gamma)
    margin, discriminant = model.hyperbolicity_margin(q), np.asarray(model.hyperbolic_discriminant(tuple(q), tuple(q)))
    clear = np.abs(margin) > 1e-6
    np.testing.assert_array_equal((discriminant < 0.0)[clear], (margin < 0.0)[clear])
    assert 100 < (margin < 0.0).sum() < 15_000


def test_equal_velocities_have_their_speeds_in_closed_form():
    h, phi, v, gamma = 1.3, 0.35, 0.7, 0.4
    a, inner = np.sqrt(G * h), np.sqrt((phi * v / 2) ** 2 + G * h * (1 - phi) * (1 - gamma) / 2)
    model = gr.PitmanLe(G, gamma)
    found = model.eigenvalues(model.conserved_from(h, phi, v, v)[:, None])[:, 0]
    np.testing.assert_allclose(found, [v - a, v + phi * v / 2 - inner, v + phi * v / 2 + inner, v + a], rtol=1e-12)


def test_the_cross_term_is_the_commutator_of_the_derivatives_of_the_matrix():
    """A'(G) dq - A'(dq) G - S'(G) db, with the matrix of the equations and central differences."""
    model, (q, _) = gr.PitmanLe(), random_faces(9, count=200)
    q = conserved(q)
    rng = np.random.default_rng(10)
    slope, db, eps = rng.uniform(-1.0, 1.0, q.shape), rng.uniform(-1.0, 1.0, q.shape[1]), 1e-5
    ql, qr = q - 0.5 * eps * slope, q + 0.5 * eps * slope

    def bottom(state):
        zero = 0.0 * state[0]
        return np.array([zero, -G * state[0], zero, -G * state[2]])

    g = np.einsum("ijn,jn->in", matrix_of_the_equations(q, 0.5), slope) - bottom(q) * db

    def derivative(direction):
        return (matrix_of_the_equations(q + 1e-30j * direction, 0.5)).imag / 1e-30

    expected = (np.einsum("ijn,jn->in", derivative(g), slope) - np.einsum("ijn,jn->in", derivative(slope), g)
                - bottom(g) * db)
    found = np.array([np.broadcast_to(row, q.shape[1:])
                      for row in model.cross(tuple(ql), tuple(qr), (0.0 * db,), (eps * db,))]) / eps**2
    # flux parts of the matrix have a symmetric second derivative and drop out, so the two agree
    np.testing.assert_allclose(found, expected, atol=1e-4 * np.abs(expected).max())


def test_the_waves_add_up_for_any_data():
    check_the_waves_add_up(gr.PitmanLe())


@pytest.mark.parametrize("scheme", schemes(gr.PitmanLe()), ids=lambda s: f"{name_of(s.riemann)}-{s.order}")
def test_rest_over_a_hump_and_a_step_is_kept(scheme):
    model = gr.PitmanLe()
    problem = fv.Problem(model, fv.Grid(0.0, 2.0, 40), lambda x: model.conserved_from(1.0 - rest_bottom(x), 0.6), 1e3,
                         {"b": rest_bottom})
    np.testing.assert_allclose(steps(problem, scheme, 300).q, problem.q0, atol=1e-13)


@pytest.mark.parametrize("scheme", schemes(gr.PitmanLe()), ids=lambda s: f"{name_of(s.riemann)}-{s.order}")
@pytest.mark.parametrize("phi", [0.0, 0.6, 1.0])
def test_an_island_is_at_rest(scheme, phi):
    model, grid = gr.PitmanLe(), fv.Grid(0.0, 2.0, 80)
    x = grid.centers
    b = 1.3 * np.exp(-(((x - 0.5) / 0.15) ** 2)) + np.where(np.abs(x - 1.4) < 0.2, 1.3, 0.0)
    q = model.conserved_from(np.maximum(0.9 - b, 0.0), phi)
    np.testing.assert_allclose(steps(fv.Problem(model, grid, q, 1e3, {"b": b}), scheme, 200).q, q, atol=1e-13)


def test_masses_are_kept():
    check_masses_are_kept(gr.PitmanLe())


@pytest.mark.parametrize("solver", SOLVERS, ids=name_of)
def test_slip_over_a_smooth_bottom_is_second_order_with_every_solver(solver):
    errors = order_errors(gr.PitmanLe(), solver, pitman_le_forces)
    assert orders(errors)[-1] > 1.9
    assert errors[-1] < 4.5e-5


def test_without_the_cross_term_it_is_first_order():
    assert orders(order_errors(gr.PitmanLe(), gr.Relaxation(), pitman_le_forces, cross_term=False))[-1] < 1.25


@pytest.mark.parametrize("scheme", schemes(gr.PitmanLe()), ids=lambda s: f"{name_of(s.riemann)}-{s.order}")
def test_with_uniform_phi_and_equal_velocities_it_is_two_phase(scheme):
    def run(model):
        problem = fv.Problem(model, fv.Grid(-5.0, 5.0, 100), lambda x: model.conserved_from(np.where(x < 0.0, 2.0, 1.0), 0.6), 0.5,
                             {"b": lambda x: 0.2 * np.exp(-((x - 2.0) ** 2))})
        return solve(problem, scheme).q[-1]

    np.testing.assert_allclose(run(gr.PitmanLe()), run(gr.TwoPhase()), atol=1e-13)


def test_it_differs_from_two_phase_in_its_scene_and_every_solver_says_the_same():
    scene = gr.scene("pitman-le")

    def run(model, solver, cells=400):
        return solve(scene.problem(model, cells), fv.WavePropagation(solver), nonhyperbolic="ignore")

    full = run(gr.TwoPhase, gr.Relaxation())
    runs = [run(gr.PitmanLe, solver) for solver in SOLVERS]
    difference = l1(full.grid, (runs[-1].q - full.q)[-1])
    assert difference > 0.3
    for other in runs[:-1]:
        assert l1(full.grid, (runs[-1].q - other.q)[-1]) < 0.25 * difference


def test_on_a_flat_bottom_smooth_flow_keeps_h_vf_and_two_phase_keeps_the_mixture_momentum():
    def initial(x):
        return gr.PitmanLe().conserved_from(1.0, 0.5 + 0.1 * np.sin(2.0 * np.pi * x), 0.3, 0.3 * np.cos(2.0 * np.pi * x))

    def drifts(model):
        problem = fv.Problem(model, fv.Grid(0.0, 1.0, 100), initial, 0.15, boundary=fv.Periodic())
        q = solve(problem, fv.WavePropagation(gr.Relaxation())).q[-1]
        whole, mixture = zip(*(((mf * (1.0 + hs / hf)).mean(), (ms + 0.5 * mf).mean()) for hs, ms, hf, mf in (problem.q0, q)),
                             strict=True)
        return abs(whole[1] - whole[0]), abs(mixture[1] - mixture[0])

    whole, mixture = drifts(gr.PitmanLe())
    assert whole < 1e-6
    assert mixture > 1e-4
    whole, mixture = drifts(gr.TwoPhase())
    assert whole > 1e-4
    assert mixture < 1e-14


@pytest.mark.parametrize("scheme", schemes(gr.PitmanLe()), ids=lambda s: f"{name_of(s.riemann)}-{s.order}")
def test_masses_stay_positive_at_vacuum_and_where_a_phase_is_absent(scheme):
    check_masses_stay_positive(gr.PitmanLe(), scheme)


@pytest.mark.parametrize("solver", [gr.Relaxation(), fv.HLL()], ids=name_of)
def test_compiled_equals_numpy(solver):
    check_both_backends_agree(gr.PitmanLe(), solver)


def test_strong_drag_brings_both_models_together():
    scene = gr.scene("pitman-le")

    def difference(*sources):
        states = []
        for model in (gr.PitmanLe, gr.TwoPhase):
            base = scene.problem(model, 100)
            problem = fv.Problem(base.model, base.grid, base.q0, scene.t_end, sources=sources)
            states.append(solve(problem, fv.WavePropagation(gr.Relaxation())).q[-1])
        return np.abs(states[0] - states[1]).mean()

    assert difference(gr.ConstantDrag(1e5)) < 0.02 * difference()
