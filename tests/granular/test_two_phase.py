"""The two-phase model: its matrix, its quartic, its Roe linearisation, down to phases that are nearly absent."""

import attrs
import numpy as np
import pytest
from hypothesis import assume, example, given, settings
from hypothesis import strategies as st

import fvkit as fv
import fvkit_granular as gr
from fvkit_granular.models import two_masses
from tests.cases import random_states

G = 9.81
COUNT = 10_000
DENSITIES = (0.05, 0.3, 0.5, 0.8, 0.98)


def faces(seed):
    """States left and right of random faces, and bottoms."""
    count = COUNT // len(DENSITIES)
    rng = np.random.default_rng(seed + 1000)
    return (
        random_states(count, seed),
        random_states(count, seed + 1),
        rng.uniform(0, 0.1, count),  # lower than any depth: higher steps are clipped
        rng.uniform(0, 0.1, count),
    )


def jump_of_the_paper(ql, qr, bl, br, g, gamma):
    """f(qr) - f(ql) + nonconservative products on the segment of the depths - bottom, from the equations."""

    def flux(q):
        hs, ms, hf, mf = q
        return np.array(
            [ms, ms**2 / hs + g / 2 * hs**2 + g * (1 - gamma) / 2 * hs * hf, mf, mf**2 / hf + g / 2 * hf**2]
        )

    hs, hf = (ql[0] + qr[0]) / 2, (ql[2] + qr[2]) / 2
    products = np.array([0 * hs, gamma * g * hs * (qr[2] - ql[2]), 0 * hs, g * hf * (qr[0] - ql[0])])
    bottom = np.array([0 * hs, -g * hs * (br - bl), 0 * hs, -g * hf * (br - bl)])
    return flux(qr) - flux(ql) + products - bottom


def matrix_of_the_paper(hs, vs, hf, vf, g, gamma):
    """The quasi-linear matrix (n, 4, 4), written out from the equations."""
    o, e = np.zeros_like(hs), np.ones_like(hs)
    rows = [[o, e, o, o], [-vs**2 + g * hs + g * (1 - gamma) / 2 * hf, 2 * vs, g * (1 + gamma) / 2 * hs, o],
            [o, o, o, e], [g * hf, o, -vf**2 + g * hf, 2 * vf]]
    return np.moveaxis(np.array(rows), -1, 0)


def roe_matrix(ql, qr, g, gamma):
    def mean(h1, m1, h2, m2):
        return (np.sqrt(h1) * m1 / h1 + np.sqrt(h2) * m2 / h2) / (np.sqrt(h1) + np.sqrt(h2))

    return matrix_of_the_paper((ql[0] + qr[0]) / 2, mean(ql[0], ql[1], qr[0], qr[1]),
                               (ql[2] + qr[2]) / 2, mean(ql[2], ql[3], qr[2], qr[3]), g, gamma)


def times(matrices, vectors):
    """(n, 4, 4) times (4, n)."""
    return np.einsum("nij,jn->in", matrices, vectors)


def decomposed(model, ql, qr, bl, br):
    """Jump, waves and speeds of faces, without warnings about branches that `where` throws away."""
    with np.errstate(divide="ignore", invalid="ignore"):
        jump = model.jump(tuple(ql), tuple(qr), (bl,), (br,))
        waves, speeds = model.decompose(tuple(ql), tuple(qr), (bl,), (br,), jump)
    return np.array(jump), np.array(waves), np.array(speeds)


@pytest.mark.parametrize("gamma", DENSITIES)
def test_the_jump_is_flux_difference_plus_products_minus_bottom(gamma, monkeypatch):
    monkeypatch.setattr(two_masses, "kinetic_head", lambda *face: 0.0)  # the head over a step, beyond the path
    ql, qr, bl, br = faces(1)
    expected = jump_of_the_paper(ql, qr, bl, br, G, gamma)
    found = np.array(gr.TwoPhase(G, gamma).jump(tuple(ql), tuple(qr), (bl,), (br,)))
    scale = 1.0 + np.abs(expected).max(axis=0)
    assert (np.abs(found - expected) / scale).max() < 1e-12


@pytest.mark.parametrize("gamma", DENSITIES)
def test_the_mass_rows_of_the_jump_are_the_differences_of_the_momenta_exactly(gamma):
    ql, qr, bl, br = faces(2)
    jump = gr.TwoPhase(G, gamma).jump(tuple(ql), tuple(qr), (bl,), (br,))
    np.testing.assert_array_equal(jump[0], qr[1] - ql[1])
    np.testing.assert_array_equal(jump[2], qr[3] - ql[3])


@pytest.mark.parametrize("gamma", DENSITIES)
def test_on_a_flat_bottom_the_mixture_momentum_jumps_by_its_own_flux(gamma):
    def mixture_flux(q):
        hs, ms, hf, mf = q
        return ms**2 / hs + gamma * mf**2 / hf + G / 2 * (hs**2 + gamma * hf**2) + G * (1 + gamma) / 2 * hs * hf

    ql, qr, b, _ = faces(3)
    jump = gr.TwoPhase(G, gamma).jump(tuple(ql), tuple(qr), (b,), (b,))
    size = 1.0 + np.abs(mixture_flux(ql)) + np.abs(mixture_flux(qr))
    assert (np.abs(jump[1] + gamma * jump[3] - (mixture_flux(qr) - mixture_flux(ql))) / size).max() < 1e-12


@pytest.mark.parametrize("gamma", DENSITIES)
def test_the_roe_matrix_times_the_jump_of_states_is_the_jump_of_fluxes(gamma):
    ql, qr, b, _ = faces(4)
    model = gr.TwoPhase(G, gamma)
    jump = jump_of_the_paper(ql, qr, b, b, G, gamma)
    size = 1.0 + np.abs(jump).max(axis=0)
    assert (np.abs(times(roe_matrix(ql, qr, G, gamma), qr - ql) - jump) / size).max() < 1e-12
    product = np.array(model.matrix_product(tuple(ql), tuple(qr), (b,), (b,), tuple(qr - ql)))
    assert (np.abs(product - jump) / size).max() < 1e-12


@pytest.mark.parametrize("gamma", DENSITIES)
def test_every_wave_is_an_eigenvector_of_the_roe_matrix_with_its_speed(gamma):
    ql, qr, bl, br = faces(5)
    _, waves, speeds = decomposed(gr.TwoPhase(G, gamma), ql, qr, bl, br)
    matrices = roe_matrix(ql, qr, G, gamma)
    a = np.sqrt(G * 0.5 * (ql[0] + qr[0] + ql[2] + qr[2]))
    real_and_distinct = speeds[2] - speeds[1] > 1e-3 * a
    assert real_and_distinct.mean() > 0.25
    size = np.linalg.norm(matrices, axis=(1, 2)) * np.linalg.norm(waves, axis=1).max(axis=0)
    for wave, speed in zip(waves, speeds, strict=True):
        residual = np.linalg.norm(times(matrices, wave) - speed * wave, axis=0) / size
        assert residual[real_and_distinct].max() < 1e-10


@pytest.mark.parametrize("gamma", DENSITIES)
def test_the_waves_add_up_to_the_jump_wherever_the_speeds_are(gamma, monkeypatch):
    monkeypatch.setattr(two_masses, "kinetic_head", lambda *face: 0.0)  # the head over a step, beyond the path
    ql, qr, bl, br = faces(6)
    _, waves, speeds = decomposed(gr.TwoPhase(G, gamma), ql, qr, bl, br)
    expected = jump_of_the_paper(ql, qr, bl, br, G, gamma)
    size = 1.0 + np.abs(expected).max(axis=0) + np.abs(waves).max(axis=(0, 1))
    assert (np.abs(waves.sum(axis=0) - expected) / size).max() < 1e-12
    assert (np.diff(speeds, axis=0) >= 0.0).all()


@pytest.mark.parametrize("gamma", DENSITIES)
def test_where_the_inner_pair_is_complex_the_outer_waves_stay_eigenvectors_and_the_pair_travels_together(gamma):
    ql, qr, bl, br = faces(7)
    model = gr.TwoPhase(G, gamma)
    _, waves, speeds = decomposed(model, ql, qr, bl, br)
    lost = model.hyperbolic_discriminant(tuple(ql), tuple(qr)) < 0.0
    assert 5 <= lost.sum() <= 0.9 * lost.size
    np.testing.assert_array_equal(speeds[1][lost], speeds[2][lost])
    matrices = roe_matrix(ql, qr, G, gamma)
    exact = np.sort_complex(np.linalg.eigvals(matrices[lost]))
    np.testing.assert_allclose(speeds[1][lost], exact[:, 1:3].real.mean(axis=1), atol=1e-7)
    size = np.linalg.norm(matrices, axis=(1, 2)) * np.linalg.norm(waves, axis=1).max(axis=0)
    for k in (0, 3):
        residual = np.linalg.norm(times(matrices, waves[k]) - speeds[k] * waves[k], axis=0) / size
        assert residual[lost].max() < 1e-10


def near_limits(seed, count):
    """Random primitive states whose solid fraction is down to 1e-8 away from 0 or 1 in half of the cases."""
    rng = np.random.default_rng(seed)
    h, vs, vf = rng.uniform(0.05, 3.0, count), rng.uniform(-6.0, 6.0, count), rng.uniform(-6.0, 6.0, count)
    small = 10.0 ** rng.uniform(-8.0, 0.0, count)
    pick = rng.integers(0, 4, count)
    phi = np.select([pick == 0, pick == 1], [0.999 * small, 1.0 - 0.999 * small], rng.uniform(0.01, 0.99, count))
    return phi * h, vs, (1.0 - phi) * h, vf


def conserved(hs, vs, hf, vf):
    return np.array([hs, hs * vs, hf, hf * vf])


def guaranteed(hs, vs, hf, vf, gamma):
    """Where the sufficient conditions make the system hyperbolic: slip below 2 a beta or above 2 a."""
    a = np.sqrt(G * (hs + hf))
    slip, beta = np.abs(vs - vf), np.sqrt(hf / (hs + hf) * (1 - gamma) / 2)
    return (slip < 2 * a * beta) | (slip > 2 * a)


def mixed(hs, hf):
    """Where each phase is at least a tenth of the whole."""
    return np.minimum(hs, hf) > 0.1 * (hs + hf)


def speed_errors(gamma, primitive):
    """Distance of numpy's eigenvalues from the model's over a, whether they are real, whether they are well apart."""
    numpy = np.linalg.eigvals(matrix_of_the_paper(*primitive, G, gamma)).T
    found, a = gr.TwoPhase(G, gamma).eigenvalues(conserved(*primitive)), np.sqrt(G * (primitive[0] + primitive[2]))
    distance = np.abs(numpy[:, None] - found[None]).min(axis=1).max(axis=0) / a
    apart = np.min(np.abs(numpy[:, None] - numpy[None]) + 1e9 * np.eye(4)[:, :, None], axis=(0, 1)) > 1e-4 * a
    return distance, np.abs(numpy.imag).max(axis=0) == 0.0, apart


@pytest.mark.parametrize("gamma", DENSITIES)
def test_where_hyperbolicity_is_guaranteed_the_speeds_are_the_eigenvalues_down_to_phases_of_one_in_a_hundred_million(
    gamma,
):
    primitive = near_limits(8, COUNT)
    distance, real, apart = speed_errors(gamma, primitive)
    safe = guaranteed(*primitive, gamma) & apart
    assert safe.mean() > 0.2
    assert real[safe].all()
    assert distance[safe].max() < 1e-9


@pytest.mark.parametrize("gamma", DENSITIES)
def test_with_a_tenth_of_each_phase_the_speeds_are_the_eigenvalues_at_any_slip(gamma):
    primitive = near_limits(8, COUNT)
    distance, real, apart = speed_errors(gamma, primitive)
    both = mixed(primitive[0], primitive[2]) & apart
    assert distance[both & real].max() < 1e-9
    assert distance[both & ~real].max() < 1e-6
    assert (both & ~real).sum() > 100


@pytest.mark.parametrize("gamma", DENSITIES)
def test_with_little_of_one_phase_and_large_slip_the_speeds_are_the_eigenvalues(gamma):
    primitive = near_limits(8, COUNT)
    distance, real, apart = speed_errors(gamma, primitive)
    resonant = ~mixed(primitive[0], primitive[2]) & ~guaranteed(*primitive, gamma) & apart
    assert resonant.sum() > 500
    assert distance[resonant & real].max() < 1e-9
    assert distance[resonant & ~real].max() < 1e-6


@pytest.mark.parametrize("gamma", DENSITIES)
def test_near_defective_speeds_are_roots_of_the_quartic_to_rounding(gamma):
    """Two speeds that nearly coincide are known to the root of rounding only; the residual does not suffer."""
    hs, vs, hf, vf = near_limits(9, COUNT)
    found = gr.TwoPhase(G, gamma).eigenvalues(conserved(hs, vs, hf, vf))
    s, f = (found - vs) ** 2 - G * (hs + (1 - gamma) / 2 * hf), (found - vf) ** 2 - G * hf
    residual = s * f - G * G * (1 + gamma) / 2 * hs * hf
    size = (np.abs(vs - vf) + np.sqrt(G * (hs + hf))) ** 4
    safe = guaranteed(hs, vs, hf, vf, gamma) | mixed(hs, hf)
    assert (np.abs(residual) / size)[:, safe].max() < 1e-12


@pytest.mark.parametrize("gamma", DENSITIES)
def test_speeds_come_sorted_within_their_bounds_and_add_up_to_the_trace(gamma):
    hs, vs, hf, vf = near_limits(10, 2000)
    q = conserved(hs, vs, hf, vf)
    model = gr.TwoPhase(G, gamma)
    found, (low, high) = model.eigenvalues(q), model.wave_speeds(tuple(q))
    assert found.shape == (4, 2000)
    assert np.iscomplexobj(found)
    assert (np.diff(found.real, axis=0) >= -1e-12).all()
    assert (low - 1e-9 <= found[0].real).all()
    assert (found[3].real <= high + 1e-9).all()
    assert np.abs(found[[0, 3]].imag).max() == 0.0
    np.testing.assert_allclose(found.sum(axis=0).real, 2.0 * (vs + vf), atol=1e-8)


@pytest.mark.parametrize("gamma", DENSITIES)
def test_complex_pairs_are_flagged_exactly_where_numpy_finds_them(gamma):
    hs, vs, hf, vf = near_limits(11, COUNT // len(DENSITIES))
    q = conserved(hs, vs, hf, vf)
    margin = gr.TwoPhase(G, gamma).hyperbolicity_margin(q)
    numpy = np.linalg.eigvals(matrix_of_the_paper(hs, vs, hf, vf, G, gamma))
    clear = np.abs(margin) > 1e-6
    assert clear.mean() > 0.7
    np.testing.assert_array_equal(margin[clear] < 0.0, (np.abs(numpy.imag).max(axis=1) > 1e-6)[clear])
    assert 20 < (margin[clear] < 0.0).sum() < clear.sum() - 20


@pytest.mark.parametrize("gamma", DENSITIES)
def test_a_face_between_equal_states_loses_hyperbolicity_where_the_state_has(gamma):
    hs, vs, hf, vf = near_limits(12, 2000)
    q = conserved(hs, vs, hf, vf)
    model = gr.TwoPhase(G, gamma)
    margin = model.hyperbolicity_margin(q)
    clear = np.abs(margin) > 1e-9
    np.testing.assert_array_equal((model.hyperbolic_discriminant(tuple(q), tuple(q)) < 0.0)[clear], (margin < 0.0)[clear])
    lost = margin < -1e-9
    assert np.asarray(model.may_lose_hyperbolicity(tuple(q), tuple(q)))[lost].all()


@pytest.mark.parametrize("gamma", DENSITIES)
def test_the_sufficient_conditions_for_hyperbolicity_never_meet_a_negative_margin(gamma):
    hs, vs, hf, vf = near_limits(13, 4000)
    h = hs + hf
    a, beta = np.sqrt(G * h), np.sqrt((hf / h) * (1 - gamma) / 2)
    slip = np.abs(vs - vf)
    sufficient = (slip <= 2 * a * beta * (1 - 1e-9)) | (slip >= 2 * a * (1 + 1e-9))
    margin = gr.TwoPhase(G, gamma).hyperbolicity_margin(conserved(hs, vs, hf, vf))
    assert margin[sufficient].min() > -1e-12


@pytest.mark.parametrize("gamma", DENSITIES)
def test_eigenvectors_are_eigenvectors(gamma):
    q = random_states(COUNT // len(DENSITIES), 14)
    model = gr.TwoPhase(G, gamma)
    speeds, vectors, matrices = model.eigenvalues(q), model.eigenvectors(q), np.moveaxis(model.matrix(q), -1, 0)
    assert vectors.shape == (4, 4, q.shape[1])
    np.testing.assert_allclose(
        matrices, matrix_of_the_paper(q[0], q[1] / q[0], q[2], q[3] / q[2], G, gamma), atol=1e-13
    )
    apart = (np.abs(model.hyperbolicity_margin(q)) > 1e-4) & mixed(q[0], q[2])
    for k in range(4):
        r = vectors[:, k]
        residual = np.linalg.norm(np.einsum("nij,jn->in", matrices, r) - speeds[k] * r, axis=0)
        size = np.linalg.norm(matrices, axis=(1, 2)) * np.linalg.norm(r, axis=0)
        assert (residual / size)[apart].max() < 1e-10


@pytest.mark.parametrize("gamma", DENSITIES)
def test_the_matrix_is_the_derivative_of_the_flux_plus_the_nonconservative_part(gamma):
    """Complex step: exact to rounding."""
    model, q = gr.TwoPhase(G, gamma), random_states(500, 15)
    expected = np.zeros((4, 4, 500))
    for column in range(4):
        shifted = q.astype(complex)
        shifted[column] += 1e-30j
        expected[:, column] = np.array(model.flux(tuple(shifted))).imag / 1e-30
    expected[1, 2] += gamma * G * q[0]
    expected[3, 0] += G * q[2]
    np.testing.assert_allclose(model.matrix(q), expected, rtol=1e-12, atol=1e-12)


@pytest.mark.parametrize("gamma", DENSITIES)
def test_the_closed_form_at_the_special_solid_fraction(gamma):
    phi = (1 + gamma) / (3 + gamma)
    rng = np.random.default_rng(16)
    h, vs, vf = rng.uniform(0.2, 2.0, 500), rng.uniform(-5.0, 5.0, 500), rng.uniform(-5.0, 5.0, 500)
    slip2, gh = (vs - vf) ** 2, G * h
    b, c = slip2 / 4 + gh * (1 - phi), gh * (slip2 * (1 - phi) + gh * phi**2)
    inner, outer = np.sqrt((b - np.sqrt(c)).astype(complex)), np.sqrt(b + np.sqrt(c))
    expected = (vs + vf) / 2 + np.array([-outer, -inner, inner, outer])
    found = gr.TwoPhase(G, gamma).eigenvalues(conserved(phi * h, vs, (1 - phi) * h, vf))
    far = np.abs(b - np.sqrt(c)) > 1e-3
    np.testing.assert_allclose(found[:, far], expected[:, far], atol=1e-9)
    beta = np.sqrt((1 - gamma) / (3 + gamma))
    np.testing.assert_array_equal(found[1].imag[far] != 0.0,
                                  ((np.sqrt(slip2) > 2 * beta * np.sqrt(gh)) & (np.sqrt(slip2) < 2 * np.sqrt(gh)))[far])


@pytest.mark.parametrize(
    ("slip", "real"),
    [
        (2.061871, True),
        (2.061873, False),
        (4.0, False),
        (6.159337, False),
        (6.159339, True),
        (1.980909, True),
        (0.0, True),
        (6.264184, True),
        (50.0, True),
    ],
)
def test_the_range_of_slip_without_real_speeds_of_the_worked_example(slip, real):
    model = gr.TwoPhase(G, 0.5)
    for sign in (1.0, -1.0):
        q = model.conserved_from(1.0, 0.6, sign * slip, 0.0)
        assert (model.hyperbolicity_margin(q[:, None])[0] > 0.0) == real
        assert (np.abs(model.eigenvalues(q[:, None]).imag).max() == 0.0) == real


def test_equal_velocities_have_the_external_and_internal_speeds_in_closed_form():
    h, phi, v, gamma = 1.3, 0.35, 0.7, 0.4
    model = gr.TwoPhase(G, gamma)
    a, beta = np.sqrt(G * h), np.sqrt((1 - phi) * (1 - gamma) / 2)
    q = model.conserved_from(h, phi, v, v)[:, None]
    np.testing.assert_allclose(model.eigenvalues(q)[:, 0], [v - a, v - a * beta, v + a * beta, v + a], rtol=1e-13)
    ratios = (model.eigenvectors(q)[2] / model.eigenvectors(q)[0])[:, 0]
    np.testing.assert_allclose(
        ratios, [(1 - phi) / phi, -2 / (1 + gamma), -2 / (1 + gamma), (1 - phi) / phi], rtol=1e-11
    )


def test_diagnostics_of_an_absent_phase_are_refused():
    model = gr.TwoPhase()
    for phi in (0.0, 1.0):
        for ask in (model.matrix, model.eigenvalues, model.eigenvectors):
            with pytest.raises(ValueError, match=r"both phases present"):
                ask(model.conserved_from(1.0, phi)[:, None])


tiny = st.floats(-8.0, -0.5).map(lambda power: 10.0**power)
fraction = st.one_of(tiny, tiny.map(lambda x: 1.0 - x), st.floats(0.05, 0.95))
depth = st.one_of(st.floats(0.05, 5.0), tiny)
velocity = st.floats(-30.0, 30.0)
state = st.tuples(depth, fraction, velocity, velocity)


@settings(max_examples=100)
@given(left=state, right=state, gamma=st.floats(0.02, 0.99), step=st.floats(-1.0, 1.0))
@example(left=(1.0, 1.0 - 1e-8, 0.0, 0.0), right=(1.0, 1.0 - 1e-8, 0.0, 0.0), gamma=0.5, step=0.1)
@example(left=(1.0, 1.0 - 1e-9, 0.2, 0.2), right=(0.9, 1.0 - 1e-9, 0.2, 0.2), gamma=0.5, step=0.0)
@example(left=(1.0, 1e-8, 0.0, 0.0), right=(1.0, 1.0 - 1e-8, 0.0, 0.0), gamma=0.5, step=0.0)
def test_waves_near_dry_and_near_a_single_phase_are_finite_and_add_up(left, right, gamma, step):
    model = gr.TwoPhase(G, gamma)
    ql, qr = model.conserved_from(*left)[:, None], model.conserved_from(*right)[:, None]
    jump, waves, speeds = decomposed(model, ql, qr, np.zeros(1), np.full(1, step))
    assert np.isfinite(waves).all()
    assert np.isfinite(speeds).all()
    size = np.abs(jump).max() + np.abs(waves).max()
    assert np.abs(waves.sum(axis=0) - jump).max() <= 1e-12 * size
    low = min(model.wave_speeds(tuple(q))[0][0] for q in (ql, qr))
    high = max(model.wave_speeds(tuple(q))[1][0] for q in (ql, qr))
    assert low - 10.0 <= speeds.min() <= speeds.max() <= high + 10.0
    np.testing.assert_array_equal(jump[[0, 2]], (qr - ql)[[1, 3]])


@settings(max_examples=100)
@given(left=state, right=state, gamma=st.floats(0.02, 0.99))
def test_the_momentum_of_every_wave_is_its_mass_times_its_speed(left, right, gamma):
    model = gr.TwoPhase(G, gamma)
    ql, qr = model.conserved_from(*left)[:, None], model.conserved_from(*right)[:, None]
    _, waves, speeds = decomposed(model, ql, qr, np.zeros(1), np.zeros(1))
    masses = (ql + qr)[[0, 2], 0]
    assume(masses.min() > 1e-4 * masses.sum())  # a phase that is all but absent moves with the other
    if model.hyperbolic_discriminant(tuple(ql), tuple(qr))[0] < 1e-6:
        waves, speeds = waves[[0, 3]], speeds[[0, 3]]
    size = np.abs(waves).max() * (1.0 + np.abs(speeds).max())
    condition = max(1.0, 1e-3 * np.abs(speeds).max() / np.diff(speeds, axis=0).min())  # eigenvectors of speeds that nearly coincide
    np.testing.assert_allclose(waves[:, 1], speeds * waves[:, 0], atol=1e-10 * size * condition)
    np.testing.assert_allclose(waves[:, 3], speeds * waves[:, 2], atol=1e-10 * size * condition)


@settings(max_examples=60)
@given(left=state, right=state)
def test_mirrored_faces_have_mirrored_waves(left, right):
    model, signs = gr.TwoPhase(), np.array([1.0, -1.0, 1.0, -1.0])[:, None]
    ql, qr = model.conserved_from(*left)[:, None], model.conserved_from(*right)[:, None]
    zero = np.zeros(1)
    _, _, speeds = decomposed(model, ql, qr, zero, zero)
    _, _, mirrored = decomposed(model, signs * qr, signs * ql, zero, zero)
    np.testing.assert_allclose(mirrored[::-1], -speeds, atol=1e-6 * (1.0 + np.abs(speeds).max()))


@pytest.mark.parametrize("model", [gr.TwoPhase(), gr.Reduced(), gr.ShallowWater()], ids=lambda m: type(m).__name__)
def test_on_a_flat_bottom_the_roe_waves_do_not_know_the_frame(model):
    """Seen from a moving frame every speed shifts by its velocity, and the depths that a wave carries, Z/s, stay."""
    rng = np.random.default_rng(17)
    h, phi, vs, vf = (
        rng.uniform(0.2, 2.0, (2, 300)),
        rng.uniform(0.1, 0.9, (2, 300)),
        *rng.uniform(-0.5, 0.5, (2, 2, 300)),
    )
    zero, shift = np.zeros(300), 1.7

    def look(frame):
        ql, qr = (model.conserved_from(h[i], phi[i], vs[i] + frame, vf[i] + frame) for i in (0, 1))
        _, waves, speeds = decomposed(model, ql, qr, zero, zero)
        return waves, speeds, qr - ql

    waves, speeds, _ = look(0.0)
    moved, faster, _ = look(shift)
    np.testing.assert_allclose(faster, speeds + shift, atol=1e-9)
    regular = (np.abs(speeds).min(axis=0) > 0.05) & (np.abs(faster).min(axis=0) > 0.05)
    rows = list(model.mass_rows())
    still = waves[:, rows] / speeds[:, None]
    carried = moved[:, rows] / faster[:, None]
    np.testing.assert_allclose(carried[..., regular], still[..., regular], atol=1e-8)


def test_conversion_and_observables_are_inverse():
    model = gr.TwoPhase()
    rng = np.random.default_rng(18)
    h, phi, vs, vf = rng.uniform(0.1, 2, 100), rng.uniform(0.05, 0.95, 100), *rng.uniform(-3, 3, (2, 100))
    seen = model.observables(model.conserved_from(h, phi, vs, vf), {"b": 0.5 * h})
    for name, value in dict(h=h, phi=phi, vs=vs, vf=vf, surface=1.5 * h).items():
        np.testing.assert_allclose(seen[name], value, rtol=1e-13)
    rho_s = phi + 0.5 * (1 - phi)
    np.testing.assert_allclose(seen["v"], (phi * vs + 0.5 * (1 - phi) * vf) / rho_s, rtol=1e-12)


def test_another_density_ratio_changes_the_parameters_only():
    assert attrs.asdict(gr.TwoPhase(gamma=0.3)) == {"slope": "mild", "g": 9.81, "gamma": 0.3, "dry": None}
    assert gr.TwoPhase(1.0, 0.3) == gr.TwoPhase(g=1.0, gamma=0.3)
    assert gr.TwoPhase.defines("cross")
    assert isinstance(gr.TwoPhase(), fv.Model)
