"""Closed-form decay of the slip against an ODE solver."""

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import fvkit_granular.exact as exact
from fvkit_granular.sources.slip_decay import decayed_slip, drag_rate, velocities_from_slip

LAWS = {"constant": (3.0, 0.0, 1.0), "linear": (0.0, 2.0, 1.0), "square root": (0.0, 1.5, 0.5),
        "cubic": (0.0, 0.7, 3.0), "affine": (0.5, 2.0, 1.0), "affine square": (0.5, 2.0, 2.0)}


def test_printed_value():
    state = exact.uniform_drag((1.0, 0.7, 0.8, -0.5), 0.5, 2.0, gamma=0.5)
    assert state.slip(0.0) == pytest.approx(-1.3, abs=1e-15)
    assert state.slip(0.4) == pytest.approx(-0.148905071, abs=1e-9)


@pytest.mark.parametrize("law", LAWS)
@pytest.mark.parametrize("slip", [-1.3, 0.4])
def test_against_an_ode_solver(law, slip):
    """Both momentum equations, uniform in x, as they stand in the model."""
    d0, d1, m = LAWS[law]
    gamma, hs, hf = 0.4, 0.7, 0.3

    def rate(t, q):
        vs, vf = q[0] / hs, q[1] / hf
        force = (d0 + d1 * abs(vf - vs) ** m) * (hs + hf) * (vf - vs)
        return gamma * force, -force

    t = np.linspace(0, 0.4, 9)
    start = 0.2, 0.2 + slip
    q = hs * start[0], hf * start[1]
    reference = solve_ivp(rate, (0, 0.4), q, method="DOP853", t_eval=t, rtol=1e-13, atol=1e-14)
    found = exact.uniform_drag((1.0, 0.7, *start), d0, d1, m, gamma).at(t)
    np.testing.assert_allclose(found["vs"], reference.y[0] / hs, rtol=0, atol=1e-11)
    np.testing.assert_allclose(found["vf"], reference.y[1] / hf, rtol=0, atol=1e-11)
    np.testing.assert_allclose(hs * found["vs"] + gamma * hf * found["vf"], q[0] + gamma * q[1], atol=1e-14)
    np.testing.assert_allclose(found["phi"], 0.7)


def test_limits_are_finite():
    assert decayed_slip(0.0, 1.0, 0.0, 2.0, 0.5) == 0.0
    assert decayed_slip(0.7, 1.0, 0.0, 0.0, 1.0) == 0.7
    assert decayed_slip(0.7, 1e9, 1e9, 1e9, 1.0) == 0.0
    assert decayed_slip(0.7, 0.0, 2.0, 3.0, 1.0) == 0.7
    assert drag_rate(0.6, 0.4, 0.5) == pytest.approx((0.6 + 0.2) / 0.24)


def test_velocities_keep_momentum_and_give_slip():
    rng = np.random.default_rng(1)
    hs, hf = rng.uniform(0.1, 2, (2, 50))
    vs, vf, w = rng.uniform(-3, 3, (3, 50))
    a, b = velocities_from_slip(hs, hf, vs, vf, w, 0.3)
    np.testing.assert_allclose(b - a, w, atol=1e-14)
    np.testing.assert_allclose(hs * a + 0.3 * hf * b, hs * vs + 0.3 * hf * vf, atol=1e-14)


@pytest.mark.parametrize(("arguments", "message"), [
    ((-1.0,), "`d0` must be"), ((1.0, -1.0), "`d1` must be"), ((1.0, 1.0, 0.0), "`m` must be"),
    ((1.0, 0.0, 1.0, 2.0), "`gamma` must be"),
])
def test_refusals(arguments, message):
    with pytest.raises(ValueError, match=message):
        exact.uniform_drag((1.0, 0.5, 0.0, 1.0), *arguments)
    with pytest.raises(ValueError, match="dry state: `state`"):
        exact.uniform_drag((1.0, 1.0, 0.0, 1.0), 1.0)
    with pytest.raises(ValueError, match="`t` must be"):
        exact.uniform_drag((1.0, 0.5, 0.0, 1.0), 1.0).slip([-1.0, 1.0])
