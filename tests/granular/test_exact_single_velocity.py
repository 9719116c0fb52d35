"""Exact solutions with one velocity: shallow water, reduced model, simple wave, steady flow, basin."""

import numpy as np
import pytest

import fvkit_granular.exact as exact

G = 9.81


def flux(h, v, g=G):
    return np.array([h * v, h * v * v + 0.5 * g * h * h])


# --- shallow water ---------------------------------------------------------------------------------------


@pytest.mark.parametrize(("left", "right", "star", "edges"), [
    ((2, 0), (1, 0), (1.453840892, 1.305833753), (-4.429447, -2.470696, 4.183127922)),
    ((10, 0), (0.5, 0), (3.100852444, 8.778338626), (-9.904544, 3.262964, 10.465927)),
    ((0.005, 0), (0.001, 0), (0.00253935717, 0.12727972), (-np.sqrt(G * 0.005), -0.030552768, 0.20996340)),
])
def test_dam_breaks_on_a_wet_bed(left, right, star, edges):
    solution = exact.shallow_water_riemann(left, right)
    np.testing.assert_allclose(solution.star, star, rtol=2e-8)
    fan, shock = solution.waves
    assert (fan.kind, shock.kind) == ("R", "S")
    np.testing.assert_allclose((fan.head, fan.tail, shock.head), edges, rtol=0, atol=1e-6)
    # Rankine-Hugoniot, written here
    jump = flux(*solution.star) - flux(*solution.right)
    mass = np.array([solution.star.h - right[0], solution.star.h * solution.star.v - right[0] * right[1]])
    np.testing.assert_allclose(jump, shock.head * mass, rtol=0, atol=1e-11)
    # inside the fan
    h, v = solution(0.5 * (fan.head + fan.tail))
    assert v - np.sqrt(G * h) == pytest.approx(0.5 * (fan.head + fan.tail), abs=1e-12)
    assert v + 2 * np.sqrt(G * h) == pytest.approx(left[1] + 2 * np.sqrt(G * left[0]), abs=1e-12)


def test_swashes_speed_of_the_contact_depth():
    """The benchmark's c_m = sqrt(g h*), as seen in public code."""
    star = exact.shallow_water_riemann((0.005, 0), (0.001, 0)).star
    assert np.sqrt(G * star.h) == pytest.approx(0.1578324867, abs=1e-10)


def test_two_shocks_and_mirror():
    solution = exact.shallow_water_riemann((1, 2), (1, -2))
    assert [wave.kind for wave in solution.waves] == ["S", "S"]
    assert solution.star.v == pytest.approx(0, abs=1e-14)
    xi = np.linspace(-9, 9, 37)
    a, b = exact.shallow_water_riemann((2, 0.3), (1, -0.2)), exact.shallow_water_riemann((1, 0.2), (2, -0.3))
    np.testing.assert_allclose(a(xi)[0], b(-xi)[0], rtol=0, atol=1e-13)
    np.testing.assert_allclose(a(xi)[1], -b(-xi)[1], rtol=0, atol=1e-13)


def test_ritter_on_either_side():
    x, t = np.linspace(-4, 4, 81), 0.4
    c = np.sqrt(G * 1.0)
    ritter = np.where(x / t < -c, 1.0, np.where(x / t < 2 * c, (2 * c - x / t) ** 2 / (9 * G), 0.0))
    right_dry = exact.shallow_water_riemann((1, 0), (0, 0)).at(x, t)
    left_dry = exact.shallow_water_riemann((0, 0), (1, 0)).at(-x, t)
    np.testing.assert_allclose(right_dry["h"], ritter, rtol=0, atol=1e-14)
    np.testing.assert_allclose(left_dry["h"], ritter, rtol=0, atol=1e-14)
    np.testing.assert_allclose(left_dry["v"], -right_dry["v"], rtol=0, atol=1e-13)
    assert np.all(right_dry["v"][right_dry["h"] == 0] == 0)


def test_vacuum_in_the_middle_and_all_dry():
    solution = exact.shallow_water_riemann((1, -8), (1, 8))
    h, v = solution(np.array([-20.0, -5.0, 0.0, 5.0, 20.0]))
    assert h[2] == v[2] == 0
    assert h[0] == h[4] == 1
    assert 0 < h[1] == pytest.approx(h[3])
    assert exact.shallow_water_riemann((0, 3), (0, 0)).at([0.0, 1.0], 1.0)["h"] == pytest.approx(0)


def test_at_time_zero_and_dry_input():
    solution = exact.shallow_water_riemann((2, 0), (1, 0))
    np.testing.assert_allclose(solution.at([4.9, 5.1], 0.0, x0=5.0)["h"], [2, 1])
    with pytest.raises(ValueError, match="depth h >= 0"):
        exact.shallow_water_riemann((-1, 0), (1, 0))
    with pytest.raises(ValueError, match="2 numbers"):
        exact.shallow_water_riemann((1, 0, 0), (1, 0))
    with pytest.raises(TypeError, match=r"`left` must hold \(h, v\), 2 numbers, but is 2\.0"):
        exact.shallow_water_riemann(2.0, 1.0)


# --- reduced model -----------------------------------------------------------------------------------------


@pytest.mark.parametrize(("left", "right", "h1", "h2", "v", "edges"), [
    ((3, 0.7, 0), (2, 0.4, 0), 2.354235, 2.594241, 1.238423, (-5.424942, -3.567308, 5.406505)),
    ((3, 0.7, -1.1), (2, 0.4, -0.557143), 2.227226, 2.454284, 0.401283, (-6.524942, -4.273018, 4.620783)),
])
def test_reduced_limits(left, right, h1, h2, v, edges):
    solution = exact.reduced_riemann(left, right)
    found = solution.star_left.h, solution.star_right.h, solution.star_left.v
    np.testing.assert_allclose(found, (h1, h2, v), rtol=0, atol=1e-6)
    fan, contact, shock = solution.waves
    np.testing.assert_allclose((fan.head, fan.tail, shock.head), edges, rtol=0, atol=1.1e-6)
    assert contact.kind == "C"
    assert contact.head == solution.star_right.v


def test_reduced_limit_at_constant_depth():
    solution = exact.reduced_riemann((1, 0.7, 0), (1, 0.3, 0))
    assert solution.star_left.h == pytest.approx(0.934070, abs=1e-6)
    assert solution.star_right.h == pytest.approx(1.068150, abs=1e-6)
    assert solution.star_left.v == pytest.approx(0.210020, abs=1e-6)


def test_reduced_jump_conditions_of_mass_solid_and_momentum():
    gamma = 0.3
    solution = exact.reduced_riemann((1, 0.7, 0.8), (1.2, 0.2, -1.5), gamma=gamma)

    def row(s):
        rho = s.phi + gamma * (1 - s.phi)
        q = np.array([s.h, rho * s.h, rho * s.h * s.v])
        return q, q * s.v + np.array([0, 0, 0.5 * G * rho * s.h**2])

    states = solution.left, solution.star_left, solution.star_right, solution.right
    assert [wave.kind for wave in solution.waves] == ["S", "C", "S"]
    for wave, a, b in zip(solution.waves, states, states[1:], strict=False):
        (qa, fa), (qb, fb) = row(a), row(b)
        np.testing.assert_allclose(fb - fa, wave.head * (qb - qa), rtol=0, atol=1e-12)


def test_contact_alone():
    solution = exact.reduced_riemann((1, 0.7, 0.3), (np.sqrt(0.85 / 0.65), 0.3, 0.3))
    o = solution.at([-1.0, 0.29, 0.31, 1.0], 1.0)
    np.testing.assert_allclose(o["v"], 0.3, atol=1e-14)
    np.testing.assert_allclose(o["phi"], [0.7, 0.7, 0.3, 0.3])
    np.testing.assert_allclose(o["h"], [1, 1, 1.1435437498, 1.1435437498], atol=1e-10)


def test_reduced_vacuum_and_dry_carry_phi():
    o = exact.reduced_riemann((1, 0.7, -8), (1, 0.3, 8)).at([-9.0, 0.0, 9.0], 1.0)
    assert o["h"][1] == 0
    np.testing.assert_allclose(o["phi"][[0, 2]], [0.7, 0.3])
    o = exact.reduced_riemann((1, 0.7, 0), (0, 0.3, 0)).at([1.0, 9.0], 1.0)
    np.testing.assert_allclose(o["phi"], [0.7, 0.3])
    assert o["h"][1] == 0


# --- simple wave -------------------------------------------------------------------------------------------


def test_simple_wave_breaking_time_and_formula():
    wave = exact.simple_wave()
    assert wave.breaking_time == pytest.approx(2.044, abs=5e-4)
    y = np.linspace(0, 10, 500)
    h = exact.hump()(y)
    x = y + 0.6 * (3 * np.sqrt(G * h) - 2 * np.sqrt(G))
    found = wave.at(x, 0.6)
    np.testing.assert_allclose(found["h"], h, rtol=0, atol=1e-13)
    np.testing.assert_allclose(found["v"], 2 * (np.sqrt(G * h) - np.sqrt(G)), rtol=0, atol=1e-12)
    np.testing.assert_allclose(wave.at(y, 0.0)["h"], h)


def test_simple_wave_satisfies_the_equations():
    wave, x, t, d = exact.simple_wave(), np.linspace(3, 7, 41), 0.6, 1e-4
    h, v = (wave.at(x, t)[name] for name in ("h", "v"))

    def derivative(of, step):
        return (of(step) - of(-step)) / (2 * step)

    for rate, slope in [
        (lambda s: wave.at(x, t + s)["h"], lambda s: np.multiply(*wave.at(x + s, t).values())),
        (lambda s: wave.at(x, t + s)["v"], lambda s: 0.5 * wave.at(x + s, t)["v"] ** 2 + G * wave.at(x + s, t)["h"]),
    ]:
        np.testing.assert_allclose(derivative(rate, d), -derivative(slope, d), rtol=0, atol=1e-5)
    assert h.max() > 1.09
    assert v.max() > 0.2


def test_simple_wave_refusals():
    wave = exact.simple_wave()
    with pytest.raises(ValueError, match=r"breaking time 2\.044"):
        wave.at(1.0, 2.1)
    with pytest.raises(ValueError, match="finite depths above 0"):
        exact.simple_wave(lambda x: 0 * x)
    with pytest.raises(ValueError, match="stays wet"):
        exact.hump(amplitude=-1.0)
    with pytest.raises(ValueError, match="widen it"):
        exact.simple_wave(exact.hump(centre=15.0, amplitude=2.0)).at(15.0, 0.1)
    assert exact.simple_wave(lambda x: 1 + 0.1 * np.tanh(x - 5)).breaking_time == np.inf


# --- steady flow -------------------------------------------------------------------------------------------

X = np.linspace(0, 25, 2501)
BUMP = np.where(np.abs(X - 10) < 2, 0.2 - 0.05 * (X - 10) ** 2, 0.0)


def head(h, q):
    return q * q / (2 * G * h * h) + h + BUMP


def test_steady_crest_values():
    assert exact.steady_flow(BUMP, 4.42, 2.0)[1000] == pytest.approx(1.70734747, abs=1e-8)
    h = exact.steady_flow(BUMP, 1.53, regime="transcritical")
    np.testing.assert_allclose(h[[0, 1000, -1]], [1.0144468, 0.62025644, 0.40578095], rtol=0, atol=5e-8)
    assert exact.critical_depth(0.18) == pytest.approx(0.14892193, abs=1e-8)


@pytest.mark.parametrize(("q", "h_out", "regime"), [(4.42, 2.0, "subcritical"), (1.53, 0.3, "supercritical"),
                                                    (1.53, None, "transcritical")])
def test_head_is_constant(q, h_out, regime):
    h = exact.steady_flow(BUMP, q, h_out, regime)
    np.testing.assert_allclose(head(h, q), head(h, q)[0], rtol=0, atol=1e-12)


def test_hydraulic_jump():
    q = 0.18
    h = exact.steady_flow(BUMP, q, 0.33, "jump")
    assert h[1000] == pytest.approx(0.14892193, abs=2e-8)
    assert h[-1] == pytest.approx(0.33, abs=1e-14)
    at = int(np.argmax(np.diff(h)))
    assert 10 < X[at] < 12
    assert h[at] < exact.critical_depth(q) < h[at + 1]
    push = q * q / h + 0.5 * G * h * h
    assert push[at + 1] == pytest.approx(push[at], rel=1e-2)
    np.testing.assert_allclose(head(h, q)[: at + 1], head(h, q)[0], rtol=0, atol=1e-12)
    np.testing.assert_allclose(head(h, q)[at + 1 :], head(h, q)[-1], rtol=0, atol=1e-12)
    assert head(h, q)[-1] < head(h, q)[0]


@pytest.mark.parametrize(("arguments", "message"), [
    ((4.42, 1.4, "subcritical"), "choked flow"),
    ((4.42, 0.5, "subcritical"), "at least the critical depth"),
    ((0.18, 0.33, "supercritical"), "below the critical depth"),
    ((0.18, 0.6, "jump"), "drowned"),
    ((0.18, 0.2, "jump"), "swept out"),
    ((0.18, None, "jump"), "`h_out`"),
    ((0.18, 0.33, "laminar"), "`regime` must be one of"),
    ((-1.0, 0.33, "jump"), "`q` must be"),
])
def test_steady_refusals(arguments, message):
    with pytest.raises(ValueError, match=message):
        exact.steady_flow(BUMP, *arguments)


# --- basin -------------------------------------------------------------------------------------------------


def test_thacker_basin():
    basin = exact.thacker_basin()
    assert basin.period == pytest.approx(2.006067, abs=1e-6)
    x, t, d = np.linspace(1.2, 1.9, 15), 0.3, 1e-4

    def q(x, t):
        o = basin.at(x, t)
        return np.array([o["h"], o["h"] * o["v"]]), flux(o["h"], o["v"])

    rate = (q(x, t + d)[0] - q(x, t - d)[0]) / (2 * d)
    slope = (q(x + d, t)[1] - q(x - d, t)[1]) / (2 * d)
    fall = (basin.bottom(x + d) - basin.bottom(x - d)) / (2 * d)
    np.testing.assert_allclose(rate[0] + slope[0], 0, atol=1e-6)
    np.testing.assert_allclose(rate[1] + slope[1] + G * q(x, t)[0][0] * fall, 0, atol=1e-6)
    np.testing.assert_allclose(basin.at(x, basin.period)["h"], basin.at(x, 0.0)["h"], atol=1e-14)
    left, right = basin.shores(t)
    assert np.all(basin.at([left - 1e-6, right + 1e-6], t)["h"] == 0)
