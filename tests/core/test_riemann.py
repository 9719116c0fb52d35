"""Riemann solvers: the waves are the jump, whatever the signs of their speeds."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import fvkit as fv
import fvkit_granular as gr
from tests.cases import SOLVERS, PSystem, Stepper, Traffic, name_of, solve

MODELS = (fv.Advection(1.5), fv.Advection(-1.5), fv.Advection(0.0), fv.Burgers(), fv.Acoustics(2.0, 3.0), Traffic(),
          PSystem(), gr.ShallowWater(), gr.Reduced(), gr.TwoPhase())
PAIRS = [(model, riemann) for model in MODELS for riemann in SOLVERS
         if model.defines("decompose") or riemann.needs == ()]


def states(model, count, seed):
    """Random states and aux values left and right of ``count`` faces."""
    rng = np.random.default_rng(seed)
    result = []
    for _ in range(2):
        q = rng.uniform(-2.0, 2.0, (len(model.conserved), count))
        for row in (*model.mass_rows(), *((0,) if type(model) is PSystem else ())):
            q[row] = rng.uniform(0.05, 3.0, count)
        result.append(tuple(q))
    return (*result, *(tuple(rng.uniform(0.0, 1.0, (len(model.aux), count))) for _ in range(2)))


def split(model, riemann, face):
    """Waves, speeds and both fluctuations of faces, from the first stages of the scheme."""
    scheme = fv.WavePropagation(riemann, order=1, entropy_fix=False)
    parts = scheme.parts(model, ())
    problem, upwinding, splitting, *_ = scheme.stages(parts)
    found = problem.compute(parts, 0.1, *face)
    waves, speeds = found["waves"], found["speeds"]
    sides = upwinding.compute(parts, 0.1, speeds)["sides"]
    left, right = splitting.compute(parts, 0.1, *face[:2], found["jump"], waves, sides).values()
    physical = zip(left, right, model.flux(face[0]), model.flux(face[1]), strict=True)
    masses = model.mass_rows()  # these rows hold the flux itself
    both = [(one - below, above - one) if k in masses else (one, other) for k, (one, other, below, above) in enumerate(physical)]
    return waves, speeds, tuple(item[0] for item in both), tuple(item[1] for item in both)


@pytest.mark.parametrize(("model", "riemann"), PAIRS, ids=name_of)
def test_the_waves_add_up_to_the_jump(model, riemann):
    face = states(model, 500, 3)
    jump = np.array(np.broadcast_arrays(*model.jump(*face)))
    waves, _ = riemann.solve(model, *face, tuple(jump))
    size = (
        1.0
        + np.abs(jump).max(axis=0)
        + np.abs(np.array([np.broadcast_arrays(*wave) for wave in waves])).max(axis=(0, 1))
    )
    np.testing.assert_array_less(np.abs(np.sum([np.array(wave) for wave in waves], axis=0) - jump) / size, 1e-13)


@pytest.mark.parametrize(("model", "riemann"), PAIRS, ids=name_of)
def test_left_and_right_going_fluctuations_add_up_to_the_jump(model, riemann):
    face = states(model, 500, 4)
    jump = np.array(model.jump(*face))
    _, _, left, right = split(model, riemann, face)
    size = 1.0 + np.maximum(np.abs(jump), np.maximum(np.abs(left), np.abs(right)))
    np.testing.assert_array_less(np.abs(np.add(left, right) - jump) / size, 1e-13)


@pytest.mark.parametrize(("model", "riemann"), PAIRS, ids=name_of)
def test_equal_states_over_a_flat_bottom_send_nothing(model, riemann):
    q, _, aux, _ = states(model, 200, 5)
    waves, speeds, left, right = split(model, riemann, (q, q, aux, aux))
    assert not np.any(left)
    assert not np.any(right)
    assert not any(np.any(wave) for wave in waves)
    assert all(np.isfinite(s).all() for s in speeds)


@pytest.mark.parametrize(("model", "riemann"), PAIRS, ids=name_of)
def test_speeds_come_in_ascending_order(model, riemann):
    face = states(model, 300, 6)
    _, speeds = riemann.solve(model, *face, model.jump(*face))
    speeds = np.array(np.broadcast_arrays(*speeds))
    assert (np.diff(speeds, axis=0) >= 0.0).all()


@pytest.mark.parametrize("riemann", SOLVERS[1:], ids=name_of)
@pytest.mark.parametrize("model", MODELS, ids=name_of)
def test_the_waves_of_hll_and_rusanov_are_as_fast_as_the_fastest_of_both_sides_and_no_faster(model, riemann):
    face = states(model, 300, 7)
    _, speeds = riemann.solve(model, *face, model.jump(*face))
    bounds = [bound for q in face[:2] for bound in model.wave_speeds(q)]
    fastest = np.max([np.abs(np.broadcast_to(bound, 300)) for bound in bounds], axis=0)
    np.testing.assert_array_equal(np.max([np.abs(np.broadcast_to(s, 300)) for s in speeds], axis=0), fastest)


@pytest.mark.parametrize("speed", [2.0, -2.0])
@pytest.mark.parametrize("riemann", SOLVERS[:2], ids=name_of)
def test_a_wave_goes_where_its_speed_points(riemann, speed):
    _, _, left, right = split(fv.Advection(speed), riemann, ((np.array([1.0]),), (np.array([4.0]),), (), ()))
    jump = 3.0 * speed
    assert (float(left[0][0]), float(right[0][0])) == ((jump, 0.0) if speed < 0.0 else (0.0, jump))


def test_a_standing_f_wave_is_split_in_half():
    class Standing(fv.RiemannSolver):
        def solve(self, model, ql, qr, auxl, auxr, jump):
            return (jump,), (0.0 * ql[0],)

    _, _, left, right = split(
        fv.Burgers(), Standing(), ((np.array([1.0, -1.0, 2.0]),), (np.array([3.0, 5.0, -2.0]),), (), ())
    )
    np.testing.assert_array_equal(left[0], [2.0, 6.0, 0.0])
    np.testing.assert_array_equal(right[0], left[0])


@pytest.mark.parametrize(
    ("ql", "qr", "share"), [(1.0, 2.0, 0.0), (-2.0, -1.0, 1.0), (3.0, -1.0, 0.0), (1.0, -3.0, 1.0)]
)
def test_burgers_sends_its_jump_left_or_right_by_the_sign_of_the_shock_speed(ql, qr, share):
    jump = 0.5 * (qr * qr - ql * ql)
    _, _, left, right = split(fv.Burgers(), fv.Roe(), ((np.array([ql]),), (np.array([qr]),), (), ()))
    assert (float(left[0][0]), float(right[0][0])) == (share * jump, (1.0 - share) * jump)


def mirrored(model, q):
    signs = np.array(model.wall_signs())[:, None]
    return signs * q[:, ::-1]


@pytest.mark.parametrize("order", [1, 2])
@pytest.mark.parametrize("riemann", SOLVERS, ids=name_of)
@pytest.mark.parametrize("model", [gr.ShallowWater(), gr.Reduced(), gr.TwoPhase(), fv.Acoustics()], ids=name_of)
def test_a_mirror_symmetric_problem_stays_mirror_symmetric(model, riemann, order):
    rng = np.random.default_rng(8)
    half = rng.uniform(0.5, 1.5, (len(model.conserved), 12))
    q = np.concatenate([half, mirrored(model, half)], axis=1)
    stepper = Stepper(fv.Problem(model, fv.Grid(-1.0, 1.0, 24), q, 10.0), fv.WavePropagation(riemann, order=order),
                         nonhyperbolic="ignore")
    for _ in range(8):
        stepper.step()
    np.testing.assert_allclose(stepper.q, mirrored(model, stepper.q), atol=2e-13)


@pytest.mark.parametrize("riemann", SOLVERS, ids=name_of)
def test_two_streams_that_meet_head_on_stay_exactly_symmetric_at_the_standing_face(riemann):
    q = np.array([[2.0] * 6, [1.0] * 3 + [-1.0] * 3])
    stepper = Stepper(
        fv.Problem(gr.ShallowWater(), fv.Grid(-1.0, 1.0, 6), q, 10.0), fv.WavePropagation(riemann, order=1)
    )
    stepper.step()
    np.testing.assert_array_equal(stepper.q, mirrored(gr.ShallowWater(), stepper.q))


@pytest.mark.parametrize("order", [1, 2])
def test_standing_f_waves_of_burgers_keep_the_mirror_symmetry_exactly(order):
    u = np.array([-0.75, 0.5, 2.0, 0.25, 1.5])
    q = np.concatenate([u, -u[::-1]])[None]
    scheme = fv.WavePropagation(fv.Roe(), order=order, entropy_fix=False)
    stepper = Stepper(fv.Problem(fv.Burgers(), fv.Grid(-1.0, 1.0, 10), q, 10.0), scheme)
    for _ in range(5):
        stepper.step()
        np.testing.assert_array_equal(stepper.q[0], -stepper.q[0, ::-1])


@settings(max_examples=60)
@given(left=st.floats(-1e3, 1e3), right=st.floats(-1e3, 1e3))
def test_hll_of_burgers_needs_no_gap_between_its_bounds(left, right):
    _, _, minus, plus = split(fv.Burgers(), fv.HLL(), ((np.array([left]),), (np.array([right]),), (), ()))
    jump = 0.5 * (right * right - left * left)
    assert np.isfinite(minus[0]).all()
    assert float(minus[0][0] + plus[0][0]) == pytest.approx(jump, abs=1e-9)
    if left > 0.0 and right > 0.0:
        assert float(minus[0][0]) == pytest.approx(0.0, abs=1e-9)


def test_roe_names_what_a_model_lacks_before_anything_runs():
    with pytest.raises(ValueError, match=r"Roe cannot serve PSystem"):
        fv.Roe().check(PSystem())


def test_the_entropy_fix_leaves_a_standing_shock_alone():
    q = np.array([[1.0] * 10 + [-1.0] * 10])
    stepper = Stepper(fv.Problem(fv.Burgers(), fv.Grid(-1.0, 1.0, 20), q, 1.0), fv.WavePropagation(fv.Roe()))
    stepper.advance(1.0)
    np.testing.assert_array_equal(stepper.q, q)


def test_the_entropy_fix_opens_a_standing_expansion_and_its_absence_keeps_it():
    q = np.array([[-1.0] * 50 + [1.0] * 50])
    problem = fv.Problem(fv.Burgers(), fv.Grid(-1.0, 1.0, 100), q, 0.5)
    opened = solve(problem, fv.WavePropagation(fv.Roe())).q[-1, 0]
    kept = solve(problem, fv.WavePropagation(fv.Roe(), entropy_fix=False)).q[-1, 0]
    exact = np.clip(problem.grid.centers / 0.5, -1.0, 1.0)
    assert np.abs(opened - exact).mean() < 0.02
    np.testing.assert_array_equal(kept, q[0])


@pytest.mark.parametrize("gap", [1e-15, 1e-12, 1e-9, 1e-6, 1e-4])
def test_the_waves_of_hll_stay_those_of_the_jump_where_its_bounds_all_but_coincide(gap):
    ql, qr = (np.array([1.5]),), (np.array([1.5 * (1.0 + gap)]),)
    model = fv.Burgers()
    jump = model.jump(ql, qr, (), ())
    waves, _ = fv.HLL().solve(model, ql, qr, (), (), jump)
    np.testing.assert_allclose(waves, [[0.5 * jump[0]]] * 2, rtol=1e-12)


@pytest.mark.parametrize(("solver", "ql", "qr", "first", "speeds"), [
    (fv.HLL(), -1.0, 3.0, -2.0, (-1.0, 3.0)), (fv.HLL(), -1.0, 1.0, -1.0, (-1.0, 1.0)), (fv.HLL(), 1.0, 3.0, 1.0, (1.0, 3.0)),
    (fv.Rusanov(), -1.0, 3.0, -4.0, (-3.0, 3.0)), (fv.Rusanov(), 2.0, 1.0, 0.25, (-2.0, 2.0)), (fv.Rusanov(), -3.0, -1.0, -5.0, (-3.0, 3.0))])
def test_hll_and_rusanov_have_their_values_for_burgers(solver, ql, qr, first, speeds):
    """By hand: s1 (s2 D - J)/(s2 - s1) and (J - s D)/2, with D = qr - ql, J = (qr^2 - ql^2)/2 and speeds ql, qr."""
    jump = (0.5 * (qr * qr - ql * ql),)
    waves, found = solver.solve(fv.Burgers(), (ql,), (qr,), (), (), jump)
    assert found == speeds
    assert [wave[0] for wave in waves] == pytest.approx([first, jump[0] - first], rel=1e-15)
