"""The reduced model and shallow water: Roe linearisations, the contact, and conversions of all three models."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import fvkit as fv
import fvkit_granular as gr
from fvkit_granular.models import reduced, shallow_water
from tests.cases import GRANULAR, SOLVERS, averages, l1, name_of, solve

G = 9.81
SINGLE = (gr.Reduced(gamma=0.4), gr.ShallowWater())
CONTACT = ((1.0, 0.7, 0.3, 0.3), (1.1435437498, 0.3, 0.3, 0.3))


def faces(model, seed, count=2000):
    rng = np.random.default_rng(seed)
    return [
        model.conserved_from(
            rng.uniform(0.05, 3.0, count), rng.uniform(0.0, 1.0, count), *rng.uniform(-3, 3, (2, count))
        )
        for _ in range(2)
    ]


def decomposed(model, ql, qr, bl, br):
    face = (tuple(ql), tuple(qr), (bl,), (br,))
    jump = model.jump(*face)
    waves, speeds = model.decompose(*face, jump)
    return face, np.array(jump), np.array(waves), np.array(speeds)


def flux_of_the_equations(model, q):
    if isinstance(model, gr.ShallowWater):
        h, m = q
        return np.array([m, m**2 / h + G / 2 * h**2])
    h, mass, m = q
    return np.array([h * m / mass, m, m**2 / mass + G / 2 * mass * h])


@pytest.mark.parametrize("model", SINGLE, ids=name_of)
def test_the_jump_is_flux_difference_minus_the_bottom_at_mean_depth(model, monkeypatch):
    for module in (shallow_water, reduced):  # the head over a step, beyond the mean depth
        monkeypatch.setattr(module, "kinetic_head", lambda *face: 0.0)
    ql, qr = faces(model, 1)
    rng = np.random.default_rng(2)
    bl, br = rng.uniform(0, 0.05, (2, 2000))  # lower than any depth: higher steps are clipped
    expected = flux_of_the_equations(model, qr) - flux_of_the_equations(model, ql)
    expected[-1] += G * 0.5 * (ql[-2] + qr[-2]) * (br - bl)
    found = np.array(model.jump(tuple(ql), tuple(qr), (bl,), (br,)))
    np.testing.assert_allclose(found, expected, atol=1e-12 * np.abs(expected).max())


@pytest.mark.parametrize("model", SINGLE, ids=name_of)
def test_the_roe_matrix_times_the_jump_of_states_is_the_jump_of_fluxes(model):
    ql, qr = faces(model, 3)
    zero = np.zeros(2000)
    face, jump, _, _ = decomposed(model, ql, qr, zero, zero)
    product = np.array(model.matrix_product(*face, tuple(qr - ql)))
    np.testing.assert_allclose(product, jump, atol=1e-12 * np.abs(jump).max())


@pytest.mark.parametrize("model", SINGLE, ids=name_of)
def test_the_waves_are_eigenvectors_that_add_up_to_the_jump_on_any_bottom(model):
    ql, qr = faces(model, 4)
    bl, br = np.random.default_rng(5).uniform(0, 1, (2, 2000))
    face, jump, waves, speeds = decomposed(model, ql, qr, bl, br)
    size = np.abs(waves).max()
    np.testing.assert_allclose(waves.sum(axis=0), jump, atol=1e-12 * size)
    for wave, speed in zip(waves, speeds, strict=True):
        np.testing.assert_allclose(np.array(model.matrix_product(*face, tuple(wave))), speed * wave, atol=1e-11 * size)
    assert (np.diff(speeds, axis=0) > 0.0).all()


@pytest.mark.parametrize("model", SINGLE, ids=name_of)
def test_the_matrix_of_equal_states_is_the_derivative_of_the_flux(model):
    q, _ = faces(model, 6)
    zero = np.zeros(2000)
    for column in range(len(q)):
        shifted = q.astype(complex)
        shifted[column] += 1e-30j
        unit = tuple(np.full(2000, float(row == column)) for row in range(len(q)))
        derivative = np.array(model.flux(tuple(shifted))).imag / 1e-30
        found = np.array(model.matrix_product(tuple(q), tuple(q), (zero,), (zero,), unit))
        np.testing.assert_allclose(found, derivative, atol=1e-12 * (1 + np.abs(derivative).max()))


def test_the_contact_of_the_reduced_model_is_a_single_wave_at_a_face():
    model = gr.Reduced()
    ql, qr = (model.conserved_from(*side)[:, None] for side in CONTACT)
    _, jump, waves, speeds = decomposed(model, ql, qr, np.zeros(1), np.zeros(1))
    assert speeds[1] == pytest.approx(0.3, abs=1e-14)
    np.testing.assert_allclose(waves[1], jump, atol=1e-9)
    assert np.abs(waves[[0, 2]]).max() < 1e-9
    pressure = [0.5 * G * q[1] * q[0] for q in (ql, qr)]
    assert pressure[0] == pytest.approx(pressure[1], rel=1e-9)


@pytest.mark.parametrize("limiter", [fv.MC(), fv.Superbee()], ids=name_of)
def test_the_contact_of_the_reduced_model_travels_alone_and_at_its_velocity(limiter):
    model, grid = gr.Reduced(), fv.Grid(-1.0, 1.0, 100)

    def state(x):
        left = x < 0.0
        return model.conserved_from(*(np.where(left, a, b) for a, b in zip(*CONTACT, strict=True)))

    problem = fv.Problem(model, grid, state, 1.0)
    solution = solve(problem, fv.WavePropagation(fv.Roe(), limiter))
    seen = solution.observables()
    np.testing.assert_allclose(seen["v"], 0.3, atol=5e-4)
    h, mass, _ = solution.q[-1]
    far = np.abs(grid.centers - 0.3) > 0.3
    np.testing.assert_allclose((h * mass)[far], 0.85, atol=1e-3)
    exact = averages(lambda x: state(x - 0.3), grid)
    assert l1(grid, solution.q[-1] - exact) < 0.02


def test_the_full_model_splits_the_contact_of_the_reduced_one():
    model, grid = gr.TwoPhase(), fv.Grid(-1.0, 1.0, 100)

    def state(x):
        return model.conserved_from(*(np.where(x < 0.0, a, b) for a, b in zip(*CONTACT, strict=True)))

    seen = solve(fv.Problem(model, grid, state, 0.2)).observables()
    assert np.abs(seen["vs"] - seen["vf"]).max() > 0.3


def test_shallow_water_is_the_reduced_model_at_uniform_density():
    def initial(model):
        return lambda x: model.conserved_from(np.where(x < 0.0, 2.0, 1.0), 0.6, 0.3 * np.sin(x), 0.3 * np.sin(x))

    results = []
    for model in (gr.Reduced(), gr.ShallowWater(), gr.TwoPhase()):
        problem = fv.Problem(model, fv.Grid(-2.0, 2.0, 100), initial(model), 0.2, {"b": lambda x: 0.1 * np.cos(x)})
        seen = solve(problem, fv.WavePropagation(fv.Roe())).observables()
        results.append((seen["h"], seen["v"]))
    np.testing.assert_allclose(results[0], results[1], atol=0.03)
    np.testing.assert_allclose(results[2], results[1], atol=0.03)
    assert l1(fv.Grid(-2.0, 2.0, 100), np.array(results[0]) - results[1]) < 0.02


depth = st.one_of(st.just(0.0), st.floats(1e-8, 10.0))
fraction = st.one_of(st.just(0.0), st.just(1.0), st.floats(1e-8, 1.0 - 1e-8))
velocity = st.floats(-20.0, 20.0)


@settings(max_examples=80)
@given(h=depth, phi=fraction, vs=velocity, vf=velocity)
def test_two_phase_conversion_round_trip_with_absent_phases(h, phi, vs, vf):
    seen = gr.TwoPhase().observables(gr.TwoPhase().conserved_from(h, phi, vs, vf))
    assert seen["h"] == pytest.approx(h, rel=1e-15)
    assert seen["phi"] == pytest.approx(phi if h > 0.0 else 0.0, rel=1e-14)
    assert seen["vs"] == pytest.approx(vs if h * phi > 0.0 else 0.0, rel=1e-12, abs=1e-15)
    assert seen["vf"] == pytest.approx(vf if h * (1.0 - phi) > 0.0 else 0.0, rel=1e-12, abs=1e-15)
    assert all(np.isfinite(value).all() for value in seen.values())


@settings(max_examples=80)
@given(h=depth, phi=fraction, vs=velocity, vf=velocity)
def test_the_reduced_model_keeps_depth_fraction_and_momentum(h, phi, vs, vf):
    model = gr.Reduced(gamma=0.4)
    seen = model.observables(model.conserved_from(h, phi, vs, vf))
    vs, vf = (vs if phi > 0.0 else 0.0), (vf if phi < 1.0 else 0.0)
    rho = phi + 0.4 * (1.0 - phi)
    assert seen["h"] == pytest.approx(h, rel=1e-15)
    assert seen["phi"] == pytest.approx(phi if h > 0.0 else 0.0, abs=1e-14)
    assert seen["v"] == pytest.approx((phi * vs + 0.4 * (1.0 - phi) * vf) / rho if h > 0.0 else 0.0, abs=1e-12)


@settings(max_examples=80)
@given(h=depth, phi=fraction, vs=velocity, vf=velocity)
def test_shallow_water_keeps_depth_and_volume_flux(h, phi, vs, vf):
    model = gr.ShallowWater()
    seen = model.observables(model.conserved_from(h, phi, vs, vf))
    vs, vf = (vs if phi > 0.0 else 0.0), (vf if phi < 1.0 else 0.0)
    assert seen["h"] == pytest.approx(h, rel=1e-15)
    assert seen["v"] == pytest.approx(phi * vs + (1.0 - phi) * vf if h > 0.0 else 0.0, abs=1e-12)
    assert "phi" not in seen


@pytest.mark.parametrize("model", GRANULAR, ids=name_of)
def test_scalars_and_arrays_broadcast(model):
    rows = len(model.conserved)
    assert model.conserved_from(1.0, 0.5, 0.1, 0.2).shape == (rows,)
    assert model.conserved_from(np.ones(7), 0.5, 0.1, np.zeros(7)).shape == (rows, 7)
    assert model.conserved_from(1.0, [0.2, 0.4]).shape == (rows, 2)
    np.testing.assert_array_equal(model.conserved_from(np.ones(3), 0.5)[:, 1], model.conserved_from(1.0, 0.5))
    with pytest.raises(ValueError, match=r"shape"):
        model.conserved_from(np.ones(3), np.ones(2))


@pytest.mark.parametrize("model", GRANULAR, ids=name_of)
def test_the_velocity_of_an_absent_phase_is_ignored_even_where_it_is_no_number(model):
    np.testing.assert_array_equal(model.conserved_from(1.0, 1.0, 0.3, np.nan), model.conserved_from(1.0, 1.0, 0.3, 7.0))
    np.testing.assert_array_equal(model.conserved_from(1.0, 0.0, np.inf, 0.3), model.conserved_from(1.0, 0.0, 0.0, 0.3))
    assert not model.conserved_from(0.0, 0.5, np.nan, np.nan).any()


def test_films_of_rounding_size_keep_a_solid_fraction_within_its_bounds():
    model = gr.Reduced(gamma=0.4, dry=1e-8)
    phi = model.observables(np.array([[1e-20, 1e-20, 1.0], [0.0, 1.1e-20, 0.0], [0.0, 0.0, 0.0]]))["phi"]
    assert phi[:2].tolist() == [0.0, 1.0]
    assert phi[2] < 0.0  # a wrong state of a flow shows


@pytest.mark.parametrize("model", GRANULAR, ids=name_of)
def test_observables_of_states_and_of_a_solution_contain_the_surface(model):
    bottom = np.array([0.1, 0.2, 0.3])
    seen = model.observables(model.conserved_from(np.array([1.0, 2.0, 0.0]), 0.5), {"b": bottom})
    np.testing.assert_allclose(seen["surface"], [1.1, 2.2, 0.3], rtol=1e-15)
    assert set(seen) >= {"h", "v", "surface"}
    without = model.observables(model.conserved_from(np.array([1.0, 2.0, 0.0]), 0.5))
    np.testing.assert_allclose(without["surface"], [1.0, 2.0, 0.0])


@pytest.mark.parametrize("riemann", SOLVERS, ids=name_of)
@pytest.mark.parametrize("model", GRANULAR, ids=name_of)
def test_the_balanced_difference_vanishes_at_rest_and_is_the_difference_on_a_flat_bottom(model, riemann):
    rng = np.random.default_rng(7)
    bl, br = rng.uniform(0, 1, (2, 100))
    ql, qr = model.conserved_from(2.0 - bl, 0.37), model.conserved_from(2.0 - br, 0.37)
    face = (tuple(ql), tuple(qr), (bl,), (br,))
    np.testing.assert_allclose(np.array(model.balanced_difference(*face)), 0.0, atol=5e-16)
    np.testing.assert_allclose(np.array(model.jump(*face)), 0.0, atol=1e-14)
    waves, _ = riemann.solve(model, *face, model.jump(*face))
    assert max(np.abs(np.array(wave)).max() for wave in waves) < 2e-14
    flat = (tuple(ql), tuple(qr), (bl,), (bl,))
    np.testing.assert_array_equal(np.array(model.balanced_difference(*flat)), qr - ql)
