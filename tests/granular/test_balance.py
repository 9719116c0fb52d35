"""What must stay exactly: rest on any bottom, masses, mixture momentum, and the single-phase subset."""

import numpy as np
import pytest

import fvkit as fv
import fvkit_granular as gr
from tests.cases import GRANULAR, LIMITERS, SOLVERS, Stepper, name_of, rest_bottom, solve

SCHEMES = [fv.WavePropagation(riemann, order=1) for riemann in SOLVERS] + [
    fv.WavePropagation(riemann, limiter) for riemann in SOLVERS for limiter in LIMITERS]


def scheme_name(value):
    if isinstance(value, fv.WavePropagation):
        return f"{name_of(value.riemann)}-{name_of(value.limiter[0])}-{value.order}"
    return name_of(value)


def at_rest(model, phi=0.6, level=1.0, cells=40):
    def initial(x):
        return model.conserved_from(level - rest_bottom(x), phi)

    return fv.Problem(model, fv.Grid(0.0, 2.0, cells), initial, 1e3, {"b": rest_bottom})


def run(problem, scheme, steps):
    stepper = Stepper(problem, scheme, nonhyperbolic="ignore")
    for _ in range(steps):
        stepper.step()
    return stepper


@pytest.mark.parametrize("scheme", SCHEMES, ids=scheme_name)
@pytest.mark.parametrize("model", GRANULAR, ids=name_of)
def test_rest_over_a_hump_and_a_step_is_kept_for_a_thousand_steps(model, scheme):
    problem = at_rest(model)
    stepper = run(problem, scheme, 1000)
    seen = model.observables(stepper.q, problem.aux_averages)
    start = model.observables(problem.q0, problem.aux_averages)
    assert np.ptp(problem.aux_averages["b"]) > 0.35
    assert np.abs(seen["surface"] - start["surface"]).max() < 1e-13
    for name in set(seen) & {"v", "vs", "vf"}:
        assert np.abs(seen[name]).max() < 1e-12
    assert stepper.t > 5.0


@pytest.mark.parametrize("model", [gr.TwoPhase(), gr.Reduced()], ids=name_of)
@pytest.mark.parametrize("phi", [1e-8, 1e-3, 1.0 - 1e-3, 1.0 - 1e-8])
@pytest.mark.parametrize("riemann", SOLVERS, ids=name_of)
def test_rest_is_kept_where_one_phase_is_nearly_absent(model, phi, riemann):
    problem = at_rest(model, phi)
    stepper = run(problem, fv.WavePropagation(riemann), 200)
    np.testing.assert_allclose(stepper.q, problem.q0, atol=1e-13)


@pytest.mark.parametrize("model", GRANULAR, ids=name_of)
def test_rest_is_kept_on_a_random_bottom_between_walls(model):
    bottom = np.random.default_rng(3).uniform(0.0, 0.9, 40)
    problem = fv.Problem(
        model, fv.Grid(0.0, 1.0, 40), model.conserved_from(1.0 - bottom, 0.3), 1e3, {"b": bottom}, fv.Wall()
    )
    stepper = run(problem, fv.WavePropagation(fv.Roe()), 300)
    np.testing.assert_allclose(stepper.q, problem.q0, atol=1e-13)


@pytest.mark.parametrize("riemann", SOLVERS, ids=name_of)
def test_drag_leaves_rest_alone(riemann):
    model = gr.TwoPhase()
    problem = fv.Problem(model, fv.Grid(0.0, 2.0, 40), lambda x: model.conserved_from(1.0 - rest_bottom(x), 0.6), 1e3,
                         {"b": rest_bottom}, sources=gr.ConstantDrag(50.0))
    stepper = run(problem, fv.WavePropagation(riemann), 200)
    np.testing.assert_allclose(stepper.q, problem.q0, atol=1e-13)


@pytest.mark.parametrize("model", [gr.TwoPhase(), gr.Reduced()], ids=name_of)
def test_a_level_surface_over_a_varying_solid_fraction_is_no_rest(model):
    def initial(x):
        return model.conserved_from(1.0 - rest_bottom(x), np.where(x < 1.0, 0.7, 0.3))

    problem = fv.Problem(model, fv.Grid(0.0, 2.0, 40), initial, 1.0, {"b": rest_bottom})
    stepper = run(problem, fv.WavePropagation(fv.Roe()), 10)
    assert np.abs(model.observables(stepper.q)["v"]).max() > 0.05


@pytest.mark.parametrize("model", GRANULAR, ids=name_of)
def test_without_the_bottom_in_the_jump_rest_is_lost(model):
    """Negative control: the same surface over a bottom that the model is not told of."""
    problem = fv.Problem(model, fv.Grid(0.0, 2.0, 40), lambda x: model.conserved_from(1.0 - rest_bottom(x), 0.6), 1.0)
    assert np.abs(model.observables(run(problem, fv.WavePropagation(fv.Roe()), 10).q)["v"]).max() > 0.1


@pytest.mark.parametrize("order", [1, 2])
@pytest.mark.parametrize("riemann", SOLVERS, ids=name_of)
def test_rough_data_on_a_flat_ring_keep_masses_and_mixture_momentum(riemann, order):
    model, rng = gr.TwoPhase(gamma=0.4), np.random.default_rng(4)
    q = model.conserved_from(rng.uniform(0.8, 1.2, 80), rng.uniform(0.3, 0.7, 80), *rng.uniform(0.2, 0.8, (2, 80)))
    stepper = run(fv.Problem(model, fv.Grid(0.0, 1.0, 80), q, 1e3, boundary=fv.Periodic()),
                  fv.WavePropagation(riemann, order=order), 100)
    hs, ms, hf, mf = stepper.q.sum(axis=1)
    hs0, ms0, hf0, mf0 = q.sum(axis=1)
    assert hs == pytest.approx(hs0, rel=1e-13)
    assert hf == pytest.approx(hf0, rel=1e-13)
    assert ms + 0.4 * mf == pytest.approx(ms0 + 0.4 * mf0, rel=1e-13)
    assert max(map(abs, stepper.stats().mass_drift.values())) < 1e-13
    assert np.abs(stepper.q - q).max() > 0.01


@pytest.mark.parametrize("order", [1, 2])
@pytest.mark.parametrize("riemann", SOLVERS, ids=name_of)
def test_drag_and_rough_data_keep_masses_and_mixture_momentum(riemann, order):
    model, rng = gr.TwoPhase(), np.random.default_rng(5)
    q = model.conserved_from(rng.uniform(0.8, 1.2, 60), rng.uniform(0.3, 0.7, 60), *rng.uniform(0.2, 0.8, (2, 60)))
    problem = fv.Problem(model, fv.Grid(0.0, 1.0, 60), q, 1e3, boundary=fv.Periodic(), sources=gr.ConstantDrag(3.0))
    hs, ms, hf, mf = run(problem, fv.WavePropagation(riemann, order=order), 100).q.sum(axis=1)
    hs0, ms0, hf0, mf0 = q.sum(axis=1)
    assert (hs, hf) == pytest.approx((hs0, hf0), rel=1e-13)
    assert ms + 0.5 * mf == pytest.approx(ms0 + 0.5 * mf0, rel=1e-13)


@pytest.mark.parametrize("order", [1, 2])
@pytest.mark.parametrize("riemann", SOLVERS, ids=name_of)
@pytest.mark.parametrize("model", [gr.Reduced(), gr.ShallowWater()], ids=name_of)
def test_rough_data_on_a_flat_ring_keep_every_component_of_a_conservation_law(model, riemann, order):
    rng = np.random.default_rng(6)
    q = model.conserved_from(rng.uniform(0.8, 1.2, 80), rng.uniform(0.3, 0.7, 80), 0.5, 0.5)
    stepper = run(fv.Problem(model, fv.Grid(0.0, 1.0, 80), q, 1e3, boundary=fv.Periodic()),
                  fv.WavePropagation(riemann, order=order), 100)
    np.testing.assert_allclose(stepper.q.sum(axis=1), q.sum(axis=1), rtol=1e-13)


@pytest.mark.parametrize("riemann", SOLVERS, ids=name_of)
def test_over_a_bottom_masses_are_kept_and_momentum_is_not(riemann):
    model, rng = gr.TwoPhase(), np.random.default_rng(7)
    q = model.conserved_from(rng.uniform(0.8, 1.2, 50), 0.5, 0.4, 0.3)
    problem = fv.Problem(model, fv.Grid(0.0, 1.0, 50), q, 1e3, {"b": lambda x: 0.3 * x * (1.0 - x)}, fv.Wall())
    stepper = run(problem, fv.WavePropagation(riemann), 100)
    np.testing.assert_allclose(stepper.q[[0, 2]].sum(axis=1), q[[0, 2]].sum(axis=1), rtol=1e-13)
    assert abs(stepper.q[1].sum() / q[1].sum() - 1.0) > 1e-3


@pytest.mark.parametrize("order", [1, 2])
@pytest.mark.parametrize("riemann", SOLVERS, ids=name_of)
def test_a_dam_break_of_uniform_mixture_stays_uniform_with_equal_velocities(riemann, order):
    model = gr.TwoPhase()

    def initial(x):
        return model.conserved_from(np.where(x < 0.0, 2.0, 1.0), 0.6)

    solution = solve(
        fv.Problem(model, fv.Grid(-5.0, 5.0, 200), initial, 0.5), fv.WavePropagation(riemann, order=order)
    )
    seen = solution.observables()
    assert np.abs(seen["phi"] - 0.6).max() < 1e-13
    assert np.abs(seen["vs"] - seen["vf"]).max() < 1e-12
    assert seen["v"].max() > 1.2


@pytest.mark.parametrize("riemann", SOLVERS, ids=name_of)
def test_a_uniform_flow_on_a_flat_bottom_stays_uniform(riemann):
    model = gr.TwoPhase()
    q = np.repeat(model.conserved_from(1.3, 0.4, 0.7, -0.2)[:, None], 30, axis=1)
    stepper = run(fv.Problem(model, fv.Grid(0.0, 1.0, 30), q, 1e3), fv.WavePropagation(riemann), 100)
    np.testing.assert_array_equal(stepper.q, q)
