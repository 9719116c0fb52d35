"""Limiters: their formulas, their bounds, and that each element minds its own business."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import fvkit as fv
from tests.cases import LIMITERS, name_of, solve

SWEBY = (fv.Minmod(), fv.Superbee(), fv.MC(), fv.VanLeer())
LIMITING = (*SWEBY, fv.ThirdOrder())

thetas = st.floats(-1e300, 1e300, allow_nan=False)
courant = st.floats(0.0, 1.0)


@pytest.mark.parametrize("limiter", LIMITERS, ids=name_of)
@given(nu=courant)
def test_phi_of_one_is_one(limiter, nu):
    assert limiter.phi(1.0, nu) == pytest.approx(1.0, abs=1e-15)


@pytest.mark.parametrize("limiter", SWEBY, ids=name_of)
@given(theta=thetas, nu=courant)
def test_the_limiter_stays_in_the_second_order_tvd_region_of_sweby(limiter, theta, nu):
    phi = limiter.phi(theta, nu)
    assert 0.0 <= phi <= max(0.0, min(2.0, 2.0 * theta)) * (1.0 + 1e-15)
    if theta > 0.0:
        assert phi >= min(1.0, theta) * (1.0 - 1e-15)
        assert phi <= max(min(1.0, 2.0 * theta), min(theta, 2.0)) * (1.0 + 1e-15)


@given(theta=thetas, nu=st.floats(0.01, 0.99))
def test_the_third_order_limiter_stays_in_the_tvd_region_that_depends_on_the_courant_number(theta, nu):
    phi = fv.ThirdOrder().phi(theta, nu)
    assert 0.0 <= phi <= max(0.0, min(2.0 / (1.0 - nu), 2.0 * theta / nu)) * (1.0 + 1e-12)


@pytest.mark.parametrize("limiter", SWEBY, ids=name_of)
@given(theta=st.floats(1e-6, 1e6))
def test_the_limiter_is_symmetric(limiter, theta):
    assert limiter.phi(theta, 0.5) / theta == pytest.approx(limiter.phi(1.0 / theta, 0.5), rel=1e-13)


@pytest.mark.parametrize(("limiter", "theta", "exact"), [
    (fv.Minmod(), -1.0, 0.0), (fv.Minmod(), 0.0, 0.0), (fv.Minmod(), 0.3, 0.3), (fv.Minmod(), 7.0, 1.0),
    (fv.Superbee(), -1.0, 0.0), (fv.Superbee(), 0.25, 0.5), (fv.Superbee(), 0.75, 1.0), (fv.Superbee(), 1.5, 1.5),
    (fv.Superbee(), 2.0, 2.0), (fv.Superbee(), 9.0, 2.0),
    (fv.MC(), -1.0, 0.0), (fv.MC(), 0.125, 0.25), (fv.MC(), 0.5, 0.75), (fv.MC(), 2.0, 1.5), (fv.MC(), 3.0, 2.0),
    (fv.MC(), 50.0, 2.0),
    (fv.VanLeer(), -2.0, 0.0), (fv.VanLeer(), 0.5, 2.0 / 3.0), (fv.VanLeer(), 3.0, 1.5),
    (fv.NoLimiter(), -5.0, 1.0), (fv.NoLimiter(), 5.0, 1.0),
    (fv.ThirdOrder(), -1.0, 0.0), (fv.ThirdOrder(), 0.5, 0.75), (fv.ThirdOrder(), 2.0, 1.5),
    (fv.ThirdOrder(), 0.1, 0.4), (fv.ThirdOrder(), 100.0, 4.0),
], ids=lambda v: name_of(v) or str(v))
def test_the_limiter_has_its_exact_value(limiter, theta, exact):
    assert limiter.phi(theta, 0.5) == pytest.approx(exact, abs=1e-15)


@pytest.mark.parametrize("limiter", LIMITING, ids=name_of)
@pytest.mark.parametrize("nu", [0.0, 1e-12, 0.5, 1.0])
def test_the_limiter_is_bounded_for_huge_ratios(limiter, nu):
    with np.errstate(over="ignore"):
        phi = limiter.phi(np.array([-1e307, 1e307, 1e300, 1e-300]), np.full(4, nu))
    assert np.isfinite(phi).all()
    assert phi.max() <= 2000.0


@pytest.mark.parametrize("limiter", LIMITERS, ids=name_of)
@settings(max_examples=30)
@given(theta=st.lists(st.floats(-10.0, 10.0), min_size=2, max_size=20), nu=courant)
def test_each_element_depends_on_its_own_ratio_only(limiter, theta, nu):
    together = limiter.phi(np.array(theta), np.full(len(theta), nu))
    assert np.shape(together) == (len(theta),)
    assert together.tolist() == [float(limiter.phi(np.array([t]), np.array([nu]))[0]) for t in theta]


def acoustic_pulse(limiter, order=2):
    def initial(x):
        return np.array([np.exp(-100.0 * (x - 0.5) ** 2), 0.0 * x])

    problem = fv.Problem(fv.Acoustics(), fv.Grid(0.0, 1.0, 50), initial, 0.2, boundary=fv.Periodic())
    return solve(problem, fv.WavePropagation(fv.Roe(), limiter, order)).q[-1]


def test_one_limiter_per_wave_family_equals_one_for_all():
    np.testing.assert_array_equal(acoustic_pulse((fv.MC(), fv.MC())), acoustic_pulse(fv.MC()))


def test_each_wave_family_has_its_own_limiter():
    mixed = acoustic_pulse((fv.Minmod(), fv.Superbee()))
    sharp, soft = acoustic_pulse(fv.Superbee()), acoustic_pulse(fv.Minmod())
    leftgoing, rightgoing = slice(5, 20), slice(30, 45)
    np.testing.assert_allclose(mixed[:, leftgoing], soft[:, leftgoing], atol=2e-4)
    np.testing.assert_allclose(mixed[:, rightgoing], sharp[:, rightgoing], atol=2e-4)
    assert np.abs(sharp - soft)[:, leftgoing].max() > 0.005


@pytest.mark.parametrize("count", [3, 4])
def test_a_wrong_number_of_limiters_is_refused_with_the_right_one(count):
    with pytest.raises(ValueError, match=f"Roe with Acoustics has 2, got {count}"):
        acoustic_pulse((fv.MC(),) * count)


def test_no_limiters_at_all_are_refused():
    with pytest.raises(ValueError, match=r"limiter"):
        acoustic_pulse(())


def test_a_limiter_is_accepted_and_unused_at_first_order():
    np.testing.assert_array_equal(acoustic_pulse(fv.Superbee(), order=1), acoustic_pulse(fv.NoLimiter(), order=1))
