"""Exact solutions of the full model by rarefaction fans."""

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import fvkit_granular.exact as exact

G, GAMMA = 9.81, 0.5
LEFT, WIDTHS = (3.0, 0.7, -1.0, -0.8), (0.8, 0.15, 0.15, 0.8)
EDGES = [(-6.378486, -5.578486), (-1.740286, -1.590286), (1.112392, 1.262392), (4.761596, 5.561596)]


def matrix(hs, hf, vs, vf):
    return np.array([
        [0.0, 1.0, 0.0, 0.0],
        [-vs * vs + G * hs + G * (1 - GAMMA) / 2 * hf, 2 * vs, G * (1 + GAMMA) / 2 * hs, 0.0],
        [0.0, 0.0, 0.0, 1.0],
        [G * hf, 0.0, -vf * vf + G * hf, 2 * vf],
    ])


def eigenpair(q, k):
    hs, ms, hf, mf = q
    values, vectors = np.linalg.eig(matrix(hs, hf, ms / hs, mf / hf))
    at = np.argsort(values.real)[k]
    return values[at].real, vectors[:, at].real / vectors[0, at].real


def rows(o):
    hs, hf = o["h"] * o["phi"], o["h"] * (1 - o["phi"])
    return np.array([hs, hs * o["vs"], hf, hf * o["vf"]])


def test_printed_fans_and_right_state():
    solution = exact.rarefaction_fans(LEFT, WIDTHS)
    assert solution.kind == "exact"
    assert [wave.family for wave in solution.waves] == [1, 2, 3, 4]
    np.testing.assert_allclose([(w.head, w.tail) for w in solution.waves], EDGES, rtol=0, atol=1e-6)
    hs, hf, vs, vf = solution.right
    np.testing.assert_allclose((hs, hs * vs, hf, hf * vf), (2.048851, -0.102424, 0.955106, 0.538361), rtol=0, atol=1e-6)


def test_every_point_moves_with_its_own_speed_to_1e_10():
    """Against eigenvalues of NumPy, and against an integration in the speed with eigenvectors of NumPy."""
    solution = exact.rarefaction_fans(LEFT, WIDTHS)
    for wave, start in zip(solution.waves, solution.states[:-1], strict=True):
        k = wave.family - 1
        xi = np.linspace(wave.head, wave.tail, 7)
        found = rows(solution.at(xi[1:-1], 1.0))
        for speed, q in zip(xi[1:-1], found.T, strict=True):
            assert eigenpair(q, k)[0] == pytest.approx(speed, abs=1e-11)

        def rate(speed, q, k=k):
            r = eigenpair(q, k)[1]
            d = 1e-5
            slope = (eigenpair(q + d * r, k)[0] - eigenpair(q - d * r, k)[0]) / (2 * d)
            return r / slope

        q0 = np.array([start.hs, start.hs * start.vs, start.hf, start.hf * start.vf])
        reference = solve_ivp(rate, (xi[0], xi[-1]), q0, method="DOP853", t_eval=xi, rtol=1e-11, atol=1e-12).y
        np.testing.assert_allclose(found, reference[:, 1:-1], rtol=0, atol=1e-9)


def test_fan_is_a_weak_solution():
    """A finer check that needs no eigenvalue: A dq/dxi = xi dq/dxi inside each fan."""
    solution = exact.rarefaction_fans(LEFT, WIDTHS)
    for wave in solution.waves:
        d = 1e-3 * (wave.tail - wave.head)
        xi = np.linspace(wave.head, wave.tail, 9)[1:-1]
        q = [rows(solution.at(xi + j * d, 1.0)) for j in (-2, -1, 0, 1, 2)]
        dq = (q[0] - 8 * q[1] + 8 * q[3] - q[4]) / (12 * d)
        for i, speed in enumerate(xi):
            hs, ms, hf, mf = q[2][:, i]
            residual = matrix(hs, hf, ms / hs, mf / hf) @ dq[:, i] - speed * dq[:, i]
            assert np.abs(residual).max() < 1e-6


def test_fan_agrees_with_the_riemann_solver():
    fans = exact.rarefaction_fans(LEFT, WIDTHS)
    state = fans.right
    solved = exact.two_phase_riemann(LEFT, (state.h, state.phi, state.vs, state.vf))
    assert [wave.kind for wave in solved.waves] == ["R", "R", "R", "R"]
    x = np.linspace(-8, 8, 2001)
    for name, values in fans.at(x, 1.0).items():
        np.testing.assert_allclose(solved.at(x, 1.0)[name], values, rtol=0, atol=1e-10)


def test_zero_width_is_no_fan():
    solution = exact.rarefaction_fans(LEFT, (0.5, 0, 0, 0))
    assert [wave.family for wave in solution.waves] == [1]
    assert solution.at(10.0, 1.0)["h"] == pytest.approx(solution.right.h, abs=1e-14)
    assert exact.rarefaction_fans(LEFT, (0, 0, 0, 0)).right == solution.left


@pytest.mark.parametrize(("left", "widths", "message"), [
    (LEFT, (0.8, 3.0, 0.15, 0.8), "loses genuine nonlinearity"),
    (LEFT, (30.0, 0, 0, 0), "a phase runs out"),
    ((1.0, 0.6, 1.9, 0.0), (0, 0, 5.0, 0), "loses"),
    ((1.0, 0.6, 4.0, 0.0), (0, 0, 1.0, 0), "not hyperbolic"),
    (LEFT, (0.8, -0.1, 0.15, 0.8), "must be >= 0"),
    (LEFT, (0.8, 0.1, 0.15), "4 numbers"),
])
def test_refusals_name_their_cause(left, widths, message):
    with pytest.raises(ValueError, match=message):
        exact.rarefaction_fans(left, widths)
