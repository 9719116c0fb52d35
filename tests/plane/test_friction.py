"""Friction and drag in the plane: vectors, any azimuth, rest below the angle, uniform flow."""

import numpy as np
import pytest
from numpy.testing import assert_allclose
from scipy.integrate import solve_ivp

import fvkit as fv
import fvkit_granular as gr
from fvkit.problem.directions import in_plane
from fvkit.problem.turned import driven_in_plane, turned
from tests.plane.problems import square, state

G = 9.81
AZIMUTHS = np.radians([0.0, 17.0, 45.0, 90.0])


def sheet(azimuth, slope, source, t_end, dt, velocity=0.0, across=0.0, n=8, model=None):
    """A sheet of 1 m on a plane that falls along an azimuth, and its velocity along and across the fall line at the end."""
    model = model or gr.ShallowWater()
    c, s = np.cos(azimuth), np.sin(azimuth)
    vx, vy = velocity * c - across * s, velocity * s + across * c
    grid = square(n, 20.0)
    q = state(model, np.ones(grid.shape), 0.6, (vx, vx), (vy, vy))
    problem = fv.Problem(model, grid, q, t_end, aux={"b": lambda x, y: -slope * (c * x + s * y)}, boundary=gr.UniformSlope(),
                         sources=source)
    q = fv.solve(problem, step=None if dt is None else fv.Step(dt=dt)).q[-1]
    return (q[1] * c + q[2] * s) / q[0], (q[2] * c - q[1] * s) / q[0], q


@pytest.mark.parametrize("azimuth", AZIMUTHS)
@pytest.mark.parametrize("share", [1.0 - 1e-3, 1.0 + 1e-3, 1.05, 1.4])
def test_a_sheet_yields_at_its_angle_whatever_the_azimuth_and_starts_exactly(azimuth, share):
    nu = 0.4
    along, across, q = sheet(azimuth, share * nu, gr.CoulombFriction(nu), 0.4, 0.04)
    if share < 1.0:
        assert not q[1:].any()
    assert_allclose(along, max(share - 1.0, 0.0) * nu * G * 0.4, atol=1e-13)
    assert_allclose(across, 0.0, atol=1e-13)


@pytest.mark.parametrize("azimuth", AZIMUTHS)
def test_what_slides_down_its_fall_line_stops_where_it_must(azimuth):
    along, _, q = sheet(azimuth, 0.3, gr.CoulombFriction(0.5), 1.2, 0.05, velocity=2.0)
    assert not q[1:].any()
    along, _, _ = sheet(azimuth, 0.3, gr.CoulombFriction(0.5), 0.5, 0.05, velocity=2.0)
    assert_allclose(along, 2.0 - 0.2 * G * 0.5, atol=1e-13)


@pytest.mark.parametrize("slope", [0.3, 0.6])
@pytest.mark.parametrize("azimuth", AZIMUTHS[1:3])
def test_what_is_launched_across_a_slope_turns_down_to_second_order(slope, azimuth):
    def law(_, v):
        return [G * slope - 0.5 * G * v[0] / np.hypot(*v), -0.5 * G * v[1] / np.hypot(*v)]

    exact = solve_ivp(law, (0.0, 0.4), [0.0, 3.0], rtol=1e-11, atol=1e-12).y[:, -1]
    errors = [max(np.abs(found - wanted).max() for found, wanted in
                  zip(sheet(azimuth, slope, gr.CoulombFriction(0.5), 0.4, dt, across=3.0)[:2], exact, strict=True))
              for dt in (0.02, 0.01)]
    assert errors[0] < 1e-3
    assert np.log2(errors[0] / errors[1]) > 1.9


@pytest.mark.parametrize("azimuth", AZIMUTHS)
@pytest.mark.parametrize(("slope", "law", "speed"), [
    (0.01, gr.Manning(0.03), np.sqrt(0.01) / 0.03), (0.1, gr.Manning(0.03), np.sqrt(0.1) / 0.03),
    (0.3, gr.CoulombFriction(0.3), 2.0), (0.3, gr.Voellmy(0.1, 400.0), np.sqrt(0.2 * 400.0))])
def test_uniform_flow_is_kept_along_any_azimuth(azimuth, slope, law, speed):
    along, across, q = sheet(azimuth, slope, law, 2.0, None, velocity=speed, n=12)
    assert_allclose(q[0], 1.0, atol=1e-13)
    assert_allclose(along, speed, atol=2e-13 * speed)
    assert_allclose(across, 0.0, atol=2e-13 * speed)


def test_a_two_phase_sheet_with_friction_and_drag_slides_alike_at_any_azimuth():
    sources = (gr.ConstantDrag(2.0), gr.CoulombFriction(0.3))
    found = [sheet(azimuth, 0.5, sources, 0.5, 0.02, model=gr.TwoPhase())[2] for azimuth in AZIMUTHS]
    for q in found[1:]:
        for k in (1, 4):
            assert_allclose(np.hypot(q[k], q[k + 1]), found[0][k], rtol=1e-12)


def test_momenta_at_rest_at_a_heap_stay_zero_below_the_angle_and_masses_to_the_bit():
    grid = square(16, 8.0)
    h = np.maximum(1.0 - 0.3 * np.hypot(*(place - 4.0 for place in np.meshgrid(*(axis.centers for axis in grid.axes)))), 0.0)
    model = gr.ShallowWater()
    problem = fv.Problem(model, grid, state(model, h, 1.0), 1e9, sources=gr.CoulombFriction(0.32))
    stepper = fv.Stepper(problem, step=fv.Step(dt=0.01))
    stepper.run(1e9, 50)
    assert_allclose(stepper.q, problem.q0, atol=0.0)


@pytest.mark.parametrize("drag", [gr.ConstantDrag(3.0), gr.VelocityDrag(2.0, 3.0)])
def test_drag_acts_along_the_slip_and_keeps_both_momenta(drag):
    model, rng = gr.TwoPhase(dry=1e-8), np.random.default_rng(4)
    vs, vf = rng.uniform(-2.0, 2.0, (2, 2, 20))
    q = in_plane(model, model.conserved_from(1.0, 0.4, vs[0], vf[0]), model.conserved_from(1.0, 0.4, vs[1], vf[1]))
    before = (q[0], q[1], q[3], q[4], q[2], q[5])
    after = turned(drag, model, before, before, before, lambda _, state: drag.step(model, state, (0.0,), 0.3))
    for k in (1, 4):
        other = {1: 3, 4: 5}[k]
        assert_allclose(after[k] + model.gamma * after[other], before[k] + model.gamma * before[other], atol=1e-14)
    slip = [np.array([a / 0.6 - b / 0.4 for a, b in ((s[3], s[1]), (s[5], s[4]))]) for s in (before, after)]
    assert_allclose(slip[0][0] * slip[1][1], slip[0][1] * slip[1][0], atol=1e-13)


def test_a_state_without_momenta_across_is_not_turned():
    model, law = gr.ShallowWater(dry=1e-8), gr.Manning(0.03)
    rng = np.random.default_rng(5)
    h, m, change = rng.uniform(0.1, 2.0, 50), rng.uniform(-2.0, 2.0, 50), rng.uniform(-1.0, 1.0, 50)
    first = law.driven(model, (h, m), (h, m + change), (h,), (0.0,), 0.1)
    found = driven_in_plane(law, model, (h, m, 0.0 * m), (h, m + change, 0.0 * m), (h,), (0.0,), 0.1)
    assert_allclose(found[1], first[1], rtol=1e-14)
    assert not found[2].any()
