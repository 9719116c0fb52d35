"""Drag laws: against an ODE solver, in their limits, with absent phases, and in the flow."""

from itertools import pairwise

import attrs
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.integrate import solve_ivp
from scipy.optimize import brentq

import fvkit as fv
import fvkit_granular as gr
from fvkit_granular.models.wet_dry import LEAST_DRY, velocity
from fvkit_granular.sources.drag import series_of_exp, series_of_log
from fvkit_granular.sources.slip_decay import drag_rate
from tests.cases import averages, l1, orders, solve

MODEL = gr.TwoPhase(gamma=0.4)


@attrs.frozen
class Power(gr.Drag):
    """D = d |w|^m, without its closed form."""

    d: float
    m: float

    def coefficient(self, model, phi, slip):
        return self.d * slip**self.m


@attrs.frozen
class Saturating(gr.Drag):
    d: float

    def coefficient(self, model, phi, slip):
        return self.d / (1.0 + slip)


@attrs.frozen
class Affine(gr.Drag):
    """As VelocityDrag, without its closed form."""

    d0: float
    d1: float

    def coefficient(self, model, phi, slip):
        return self.d0 + self.d1 * slip


@attrs.frozen
class Crowded(gr.Drag):
    """Depends on everything."""

    d: float

    def coefficient(self, model, phi, slip):
        return self.d * model.gamma * phi / (1.0 - phi + 1e-9) * np.sqrt(1e-3 + slip)


CLOSED = (gr.ConstantDrag(3.0), gr.VelocityDrag(0.0, 2.0), gr.VelocityDrag(0.5, 2.0), gr.PitmanLeDrag(0.7, 0.0),
          gr.PitmanLeDrag(0.4, 3.65), gr.PitmanLeDrag(2.0, 1.0))
GENERAL = (Power(2.0, 0.0), Power(2.0, 1.0), Power(2.0, 1.5), Power(0.7, 2.0), Saturating(4.0), Affine(0.5, 2.0), Crowded(3.0))
EVERY = CLOSED + GENERAL


def stepped(law, q, dt, model=MODEL):
    return np.array(law.step(model, tuple(np.asarray(q, dtype=float)), (), dt))


def rates(law, q, model=MODEL):
    return np.array(law.rate(model, tuple(np.asarray(q, dtype=float)), ()))


def slip(q):
    return velocity(q[2], q[3], LEAST_DRY) - velocity(q[0], q[1], LEAST_DRY)


def mixture(q, gamma=MODEL.gamma):
    return q[1] + gamma * q[3]


def remaining_by_ode(law, phi, start, time):
    """Share of the slip left, by an ODE for its logarithm in the logarithm of time."""
    def fall(log_time, depth):
        return law.coefficient(MODEL, phi, start * np.exp(-depth)) * np.exp(log_time)

    first = np.log(1e-4 * time[0])
    def deep(log_time, depth):
        return depth[0] - 60.0

    deep.terminal = True
    seen = solve_ivp(fall, (first, np.log(time[-1]) + 1e-9), [law.coefficient(MODEL, phi, start) * np.exp(first)],
                     method="LSODA", rtol=1e-12, atol=1e-15, t_eval=np.log(time), events=deep)
    depth = np.full(len(time), 60.0)
    depth[:len(seen.t)] = seen.y[0]
    return np.exp(-depth)


@pytest.mark.parametrize("law", EVERY, ids=str)
@pytest.mark.parametrize("phi", [0.3, 0.85])
def test_every_law_agrees_with_an_ode_solver_for_both_momenta(law, phi):
    q = MODEL.conserved_from(1.4, phi, 0.2, -1.1)
    t = np.linspace(0.0, 0.3, 7)
    seen = solve_ivp(lambda t, q: rates(law, q), (0.0, 0.3), q, method="DOP853", t_eval=t, rtol=1e-12, atol=1e-13)
    found = np.array([stepped(law, q, dt) for dt in t]).T
    np.testing.assert_allclose(found, seen.y, rtol=0.0, atol=1e-10 if law in CLOSED else 2e-7)


ALLOWED = {Power(1.0, 0.0): 1e-11, Power(1.0, 0.5): 1e-11, Power(1.0, 1.0): 1e-11, Power(1.0, 1.5): 1e-11, Power(1.0, 2.0): 1e-11,
           Power(1.0, 3.0): 1e-11, Saturating(1.0): 1e-8, Affine(1.0, 100.0): 5e-7, Affine(1e-6, 1.0): 5e-7}


@pytest.mark.parametrize("law", ALLOWED, ids=str)
@pytest.mark.parametrize("start", [0.03, 1.0, 40.0])
def test_laws_without_closed_form_are_accurate_from_no_drag_to_endless_drag(law, start):
    time = np.geomspace(1e-6, 1e12, 55) / law.coefficient(MODEL, 0.5, start)
    found = law.remaining(MODEL, 0.5, np.full(55, start), time)
    error = np.abs(found - remaining_by_ode(law, 0.5, start, time))
    assert error.max() < ALLOWED[law]
    assert error[time * law.coefficient(MODEL, 0.5, start) < 1.0].max() < 1e-9
    assert (np.diff(found) <= ALLOWED[law]).all()
    assert found.min() >= 0.0
    assert found.max() <= 1.0


@pytest.mark.parametrize("law", CLOSED, ids=str)
def test_two_steps_are_one_where_there_is_a_closed_form(law):
    q = MODEL.conserved_from(np.array([1e-3, 1.0, 5.0]), np.array([0.1, 0.5, 0.95]), 0.2, np.array([-1.0, 3.0, 0.3]))
    np.testing.assert_allclose(stepped(law, stepped(law, q, 0.07), 0.4), stepped(law, q, 0.47), rtol=0.0, atol=1e-14)


@pytest.mark.parametrize("law", [gr.VelocityDrag(0.3, 2.0), gr.PitmanLeDrag(0.7, 3.0), Affine(0.3, 2.0), Crowded(3.0)], ids=str)
def test_the_rate_is_the_derivative_of_the_step(law):
    q, dt = MODEL.conserved_from(np.array([0.1, 1.0]), np.array([0.2, 0.7]), 0.4, np.array([1.0, -0.3])), 1e-6
    forward, twice = (stepped(law, q, dt) - q) / dt, (stepped(law, q, 2.0 * dt) - q) / (2.0 * dt)
    np.testing.assert_allclose(2.0 * forward - twice, rates(law, q), rtol=1e-6, atol=1e-8)


@pytest.mark.parametrize("law", EVERY, ids=str)
def test_no_time_and_no_drag_leave_the_state_bit_for_bit(law):
    q = MODEL.conserved_from(np.array([1e-300, 1e-3, 1.0]), np.array([0.3, 1.0, 0.7]), 0.4, np.array([1.0, 2.0, -0.3]))
    np.testing.assert_array_equal(stepped(law, q, 0.0), q)
    if law in CLOSED[:3] + GENERAL:
        none = attrs.evolve(law, **{name: 0.0 for name in law.parameter_names() if name.startswith(("d", "D"))})
        np.testing.assert_array_equal(stepped(none, q, 10.0), q)
        np.testing.assert_array_equal(rates(none, q), 0.0 * q)


@pytest.mark.parametrize("law", [gr.ConstantDrag(1e12), gr.VelocityDrag(1e12, 0.0), gr.VelocityDrag(0.0, 1e12),
                                 gr.PitmanLeDrag(1e-12, 2.0), Power(1e12, 0.0), Power(1e12, 1.0), Saturating(1e12)], ids=str)
def test_endless_drag_takes_all_slip_and_no_momentum(law):
    rng = np.random.default_rng(3)
    q = MODEL.conserved_from(rng.uniform(0.01, 5.0, 50), rng.uniform(0.01, 0.99, 50), *rng.uniform(-9.0, 9.0, (2, 50)))
    after = stepped(law, q, 0.01)
    np.testing.assert_array_less(np.abs(slip(after)), 1e-9)
    np.testing.assert_allclose(mixture(after), mixture(q), rtol=0.0, atol=1e-14 * np.abs(q[[1, 3]]).max())


depths = st.one_of(st.sampled_from([0.0, 1e-300, 1e-160, 1e-30, 1e-8]), st.floats(1e-300, 1e3))
speeds = st.one_of(st.just(0.0), st.floats(-1e3, 1e3, allow_subnormal=False))


@given(st.sampled_from(EVERY), st.floats(0.0, 1e12), depths, depths, speeds, speeds, st.sampled_from([0.0, 1e-9, 1e-3, 1.0, 1e5]),
       st.floats(1e-3, 0.999))
def test_a_step_keeps_masses_and_momentum_and_only_lowers_the_slip(law, strength, hs, hf, vs, vf, dt, gamma):
    if not isinstance(law, gr.PitmanLeDrag):
        law = attrs.evolve(law, **{name: strength for name in law.parameter_names() if name.startswith(("d", "D"))})
    model, q = gr.TwoPhase(gamma=gamma), np.array([hs, hs * vs, hf, hf * vf])
    with np.errstate(over="raise", invalid="raise", divide="raise"):
        after = stepped(law, q[:, None], dt, model)[:, 0]
        rate = rates(law, q[:, None], model)[:, 0]
    assert np.isfinite(after).all()
    assert np.isfinite(rate).all()
    assert (after[0], after[2]) == (q[0], q[2])
    assert abs(mixture(after, gamma) - mixture(q, gamma)) <= 1e-14 * (abs(q[1]) + abs(q[3])) + 1e-322
    if hs == 0.0 or hf == 0.0:
        np.testing.assert_array_equal(after, q)
        np.testing.assert_array_equal(rate, 0.0)
    else:  # the velocities themselves: below 1e-30 m those that the model sees are damped, each by its depth
        old, new = (state[3] / state[2] - state[1] / state[0] for state in (q, after))
        rounding = 1e-15 * (abs(vs) + abs(vf)) + 1e-300 + 1e-323 / min(hs, hf)  # the last: of momenta that are subnormal
        assert -4.0 * rounding <= new * np.sign(old) <= abs(old) + 4.0 * rounding


def test_momentum_of_an_absent_phase_does_not_move():
    q = np.array([[0.0, 0.0, 1.0], [0.3, 0.2, 1.0], [1.0, 0.0, 0.0], [0.5, 0.1, 0.2]])
    for law in EVERY:
        np.testing.assert_array_equal(stepped(law, q, 1.0), q)
        np.testing.assert_array_equal(rates(law, q), 0.0 * q)


@pytest.mark.parametrize("law", EVERY, ids=repr)
def test_what_comes_where_a_phase_was_absent_does_not_hang_on_a_trace_of_it(law):
    """A trace of 1e-20 m before a step, of any velocity, changes the momenta after it no more than its share of the mass."""
    after, bearing = (0.3, 0.2, 0.4, 0.1), (0.2, 0.3)
    absent = law.driven(MODEL, (0.2, 0.1, 0.0, 0.0), after, bearing, (0.0,), 0.1)
    for velocity_before in (-50.0, 0.0, 3.0):
        trace = law.driven(MODEL, (0.2, 0.1, 1e-20, 1e-20 * velocity_before), after, bearing, (0.0,), 0.1)
        np.testing.assert_allclose(trace, absent, rtol=1e-12)


def test_the_rate_of_decay_needs_no_square_of_a_depth():
    assert drag_rate(6e-301, 4e-301, 0.5) == pytest.approx(0.8 / 0.24)
    assert 1e149 < drag_rate(0.0, 1.0, 0.5) < 1e151


def test_pitman_le_drag_carries_a_lone_grain_at_its_settling_velocity_and_stays_finite_in_a_packed_bed():
    law, model = gr.PitmanLeDrag(0.3, 4.0), gr.TwoPhase(gamma=0.4)
    phi = 1e-9
    weight = (1.0 - model.gamma) * model.g * phi
    assert model.gamma * law.coefficient(model, phi, 0.3) * 0.3 == pytest.approx(weight, rel=1e-6)
    assert law.coefficient(model, 0.0, 1.0) == 0.0
    assert law.coefficient(model, 0.5, 1.0) == pytest.approx(9.81 * 0.5**-3 * 0.5 * 1.5 / 0.3, rel=1e-14)
    assert np.isfinite(law.coefficient(model, 1.0, 1.0))
    assert gr.PitmanLeDrag(0.3, 0.0).coefficient(model, 1.0, 1.0) < 1e-14


def test_a_law_that_is_not_a_number_does_not_pass_for_one():
    @attrs.frozen
    class Broken(gr.Drag):
        def coefficient(self, model, phi, slip):
            return np.sqrt(-1.0 - slip)

    with np.errstate(invalid="ignore"):
        assert np.isnan(stepped(Broken(), MODEL.conserved_from(1.0, 0.5, 0.0, 1.0)[:, None], 0.1)[1]).all()


def test_a_law_below_zero_counts_as_none():
    q = MODEL.conserved_from(1.0, 0.5, 0.0, 1.0)[:, None]
    np.testing.assert_array_equal(stepped(Power(-3.0, 1.0), q, 1.0), q)
    np.testing.assert_array_equal(rates(Power(-3.0, 1.0), q), 0.0 * q)


@pytest.mark.parametrize(("call", "error", "words"), [
    (lambda: gr.ConstantDrag(-0.5), ValueError, ["`D`", ">= 0", "-0.5"]),
    (lambda: gr.VelocityDrag(-1.0, 1.0), ValueError, ["`d0`", ">= 0", "-1.0"]),
    (lambda: gr.VelocityDrag(1.0, np.inf), ValueError, ["`d1`", "finite"]),
    (lambda: gr.VelocityDrag(1.0), TypeError, ["d1"]),
    (lambda: gr.PitmanLeDrag(0.0, 1.0), ValueError, ["`v_T`", "> 0", "m/s"]),
    (lambda: gr.PitmanLeDrag(1.0, -1.0), ValueError, ["`exponent`", ">= 0", "-1.0"]),
    (lambda: gr.PitmanLeDrag(1.0, "three"), TypeError, ["`exponent`", "'three'"]),
    (lambda: gr.Drag(), TypeError, ["coefficient"]),
    (lambda: fv.Problem(gr.Reduced(), fv.Grid(0, 1, 5), np.ones((3, 5)), 1.0, sources=Power(1.0, 1.0)), ValueError,
     ["Power", "Reduced", "one velocity"]),
])
def test_bad_input_is_refused_with_a_sentence(call, error, words):
    with pytest.raises(error) as raised:
        call()
    for word in words:
        assert word in str(raised.value)


def dam_break(sources, cells, **settings):
    scene = attrs.evolve(gr.scene("dam-break-phi"), sources=sources)
    return solve(scene.problem(gr.TwoPhase, cells), fv.WavePropagation(fv.Roe(), **settings))


@pytest.fixture(scope="module")
def without_drag():
    return dam_break((), 1000)


@pytest.mark.parametrize(("drag", "h1", "v1", "h2", "vs", "vf", "phi"), [
    (0.0, 2.37875, 1.18850, 2.45759, 1.60211, 0.58812, 0.54046), (1.0, 2.36133, 1.22394, 2.50333, 1.44580, 0.93386, 0.49892),
    (10.0, 2.35449, 1.23790, 2.56583, 1.27472, 1.20050, 0.43154), (100.0, 2.35430, 1.23829, 2.59424, 1.23859, 1.23846, 0.40009),
    (1e3, 2.35426, 1.23836, 2.59428, 1.23847, 1.23847, 0.40000), (1e4, 2.354235, 1.238423, 2.594241, 1.238423, 1.238423, 0.4),
    (1e5, 2.354235, 1.238423, 2.594241, 1.238423, 1.238423, 0.4),
    (1e12, 2.354235, 1.238423, 2.594241, 1.238423, 1.238423, 0.4)])
def test_drag_carries_the_dam_break_to_the_reduced_limit_at_no_cost_in_time_steps(drag, h1, v1, h2, vs, vf, phi, without_drag):
    solution = dam_break(gr.ConstantDrag(drag), 1000)
    seen, x = solution.observables(), solution.grid.centers
    found = [np.interp(-0.5, x, seen[name]) for name in ("h", "v")]
    found += [np.interp(1.0, x, seen[name]) for name in ("h", "vs", "vf", "phi")]
    assert found == pytest.approx([h1, v1, h2, vs, vf, phi], rel=1e-2 if drag < 1e4 else 1e-3)
    assert solution.stats.steps == pytest.approx(without_drag.stats.steps, rel=0.05)
    if drag >= 1e4:
        assert np.abs(seen["vs"] - seen["vf"]).max() < 50.0 / drag


@pytest.mark.parametrize("drag", [1e3, 1e5, 1e9])
def test_strong_drag_leaves_the_slip_that_the_gradient_of_phi_drives(drag):
    """w = g (1-gamma) (1-phi) h phi_x/(2 D rho), of Chapman and Enskog's expansion, and not less: splitting would leave none."""
    problem = fv.Problem(MODEL, fv.Grid(0.0, 10.0, 400), lambda x: MODEL.conserved_from(1.0, 0.5 + 0.2 * np.tanh(2.0 * (x - 5.0)), 0.0, 0.0),
                         0.4, boundary=fv.Wall(), sources=gr.ConstantDrag(drag))
    seen = solve(problem).observables()
    rho = seen["phi"] + MODEL.gamma * (1.0 - seen["phi"])
    slip = (MODEL.g * 0.5 * (1.0 - MODEL.gamma) * (1.0 - seen["phi"]) * seen["h"] * np.gradient(seen["phi"], problem.grid.dx)
            / (drag * rho))
    near = np.abs(problem.grid.centers - 5.0) < 0.5
    np.testing.assert_allclose((seen["vf"] - seen["vs"])[near], slip[near], rtol=0.02)


def test_the_least_drag_changes_next_to_nothing(without_drag):
    np.testing.assert_allclose(dam_break(gr.ConstantDrag(1e-3), 1000).q[-1], without_drag.q[-1], atol=0.02)


def damped_internal_wave(law, cells):
    """L1 error in hs over the amplitude, at t = 0.5, of the wave that a small drag damps while it travels."""
    model, amplitude, k = gr.TwoPhase(), 1e-6, 2.0 * np.pi
    growth, mode = -1.6666667 + 5.9958777j, (1.0, -0.95427358 - 0.26525824j, -1.34239625 + 0.02794634j, 1.28842627 + 0.32941321j)

    def state(x, t):
        wave = np.exp(growth * t + 1j * k * x)
        return np.stack([base + amplitude * (part * wave).real for base, part in zip((0.6, 0.0, 0.4, 0.0), mode, strict=True)])

    grid = fv.Grid(0.0, 1.0, cells)
    problem = fv.Problem(model, grid, averages(lambda x: state(x, 0.0), grid), 0.5, boundary=fv.Periodic(), sources=law)
    last = solve(problem, fv.WavePropagation(fv.Roe(), limiter=fv.NoLimiter())).q[-1]
    return l1(grid, last[0] - averages(lambda x: state(x, 0.5), grid)[0]) / amplitude


@pytest.mark.parametrize("law", [gr.ConstantDrag(1.0), Power(1.0, 0.0)], ids=str)
def test_a_damped_internal_wave_is_second_order_in_strang_splitting(law):
    assert orders([damped_internal_wave(law, cells) for cells in (50, 100, 200)]).min() > 1.9


@pytest.mark.parametrize("law", [gr.VelocityDrag(0.5, 2.0), Saturating(4.0)], ids=str)
def test_drag_that_depends_on_the_slip_is_second_order_in_time(law):
    """Smooth flow with slip; the grids are compared with each other."""
    def initial(x):
        return MODEL.conserved_from(1.0, 0.5 + 0.1 * np.sin(2.0 * np.pi * x), 0.3 + 0.1 * np.cos(2.0 * np.pi * x), -0.4)

    states = []
    for cells in (80, 160, 320):
        problem = fv.Problem(MODEL, fv.Grid(0.0, 1.0, cells), initial, 0.15, boundary=fv.Periodic(), sources=law)
        states.append(solve(problem, fv.WavePropagation(fv.Roe(), limiter=fv.NoLimiter())).q[-1])
    coarse, fine = (np.abs(a - 0.5 * (b[:, ::2] + b[:, 1::2])).mean() for a, b in pairwise(states))
    assert np.log2(coarse / fine) > 1.9


@pytest.mark.parametrize("law", [gr.ConstantDrag(5.0), gr.VelocityDrag(1.0, 5.0), gr.PitmanLeDrag(0.5, 3.65), Power(5.0, 1.0),
                                 Saturating(1e3), Crowded(5.0)], ids=str)
def test_the_compiled_backend_agrees_with_numpy(law):
    pytest.importorskip("numba", reason="the compiled backend needs the extra `fast`")
    problem = attrs.evolve(gr.scene("dam-break-phi"), sources=law).problem(gr.TwoPhase, 150)
    compiled, plain = (fv.Stepper(problem, fv.WavePropagation(fv.HLL(), order=1), backend) for backend in ("numba", "numpy"))
    for _ in range(50):
        compiled.step()
        plain.step()
    assert compiled.t == pytest.approx(plain.t, rel=1e-12)
    np.testing.assert_allclose(compiled.q, plain.q, rtol=0.0, atol=1e-12 * np.abs(plain.q).max())


def test_the_series_near_zero_are_as_good_as_they_say():
    x = np.array([-1e-3, -4e-4, -1e-9, 1e-9, 3e-4, 1e-3])
    np.testing.assert_allclose(series_of_log(x), np.log1p(x) / x, rtol=5e-13)
    np.testing.assert_allclose(series_of_exp(x), np.expm1(x) / x, rtol=5e-13)


@pytest.mark.parametrize("law", [*CLOSED, *(Power(2.0, power) for power in (0.0, 0.5, 1.0, 2.0)), Saturating(3.0), Crowded(2.0)])
def test_implicit_steps_of_any_length_are_solved(law):
    """r (1 + time D(slip r)) = 1, against a bracketed root of its logarithm. Semi-exact."""
    phi, slip = 0.4, 1.5
    for time in 10.0 ** np.arange(-6.0, 13.0, 2.0):
        def miss(depth, time=time):
            return depth - np.log1p(time * law.bounded(MODEL, phi, slip * np.exp(-depth)))

        left = np.exp(-brentq(miss, 0.0, 60.0, xtol=1e-15, rtol=1e-14))
        found = float(np.squeeze(law.resisted(MODEL, phi, np.array([slip]), time)))
        assert found == pytest.approx(law.bounded(MODEL, phi, slip * left) * left, rel=1e-10, abs=0.0)
