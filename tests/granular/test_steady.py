"""Moving equilibria: exact profiles against invariants and Bernoulli, and what the scheme keeps to rounding."""

import numpy as np
import pytest

import fvkit as fv
import fvkit_granular as gr
from fvkit_granular import exact
from fvkit_granular.scenes.library.steady_flow import FLOWS, STEADY, parabolic_bump, profile, smooth_bump
from tests.cases import solve

NAMES = tuple(STEADY)

#: Drift of the depth in 1 s from exact point values, N = 100: what second order leaves.
PLAIN = dict(zip(NAMES, (1.1e-7, 6.2e-6, 1.9e-6, 2.1e-5, 7.9e-5), strict=True))


def roe(name, order=2, limiter=None):
    """The entropy fix takes a transcritical flow for a transonic rarefaction."""
    return fv.WavePropagation(fv.Roe(), limiter=limiter or fv.MC(), order=order, entropy_fix=name != "transcritical-bump")


def drift(flow, grid, q, scheme, bottom=None, model=None):
    problem = fv.Problem(model or gr.TwoPhase(), grid, q, 1.0, {"b": flow.bottom if bottom is None else bottom})
    change = solve(problem, scheme).q[-1] - q
    return float(np.abs(change[0] + change[2]).max())


def test_the_crest_of_the_known_case():
    at = profile("moving-equilibrium").at(5.0)
    hs, hf = at["phi"] * at["h"], (1.0 - at["phi"]) * at["h"]
    assert (hs, hf, at["vs"], at["vf"]) == pytest.approx((0.47584345, 0.32307002, 0.37827567, 0.24762434), abs=1e-8)


@pytest.mark.parametrize("name", NAMES)
def test_discharges_and_the_head_of_the_fluid_are_uniform(name):
    flow = profile(name)
    x = np.linspace(*flow.interval, 1001)
    at, b = flow.at(x), flow.bottom(x)
    assert np.ptp(b) > 0.19
    assert np.ptp(at["h"]) > 0.09
    for discharge in (at["phi"] * at["h"] * at["vs"], (1.0 - at["phi"]) * at["h"] * at["vf"]):
        assert np.ptp(discharge) < 1e-14 * np.abs(discharge).max() + 1e-15
    head = 0.5 * at["vf"] ** 2 + 9.81 * (at["h"] + b)
    assert np.ptp(head) < 1e-12 * head.max()


@pytest.mark.parametrize("model", [gr.TwoPhase(gamma=0.3), gr.TwoLayer(gamma=0.8)], ids=["two-phase", "two-layer"])
def test_the_flow_satisfies_the_equations_of_its_model(model):
    flow = gr.steady(smooth_bump, {"h": 1.0, "phi": 0.5, "vs": 0.15, "vf": -0.05}, (0.0, 10.0), model=model)
    x, d = np.linspace(3.3, 6.7, 40), 1e-3

    def q(points):
        return model.conserved_from(**flow.at(points))

    def slope(of):
        return (8.0 * (of(x + d) - of(x - d)) - (of(x + 2 * d) - of(x - 2 * d))) / (12.0 * d)

    left = np.einsum("ijn,jn->in", model.matrix(q(x)), slope(q))
    push = -model.g * slope(smooth_bump)
    state = q(x)
    assert np.abs(push).max() > 1.0
    np.testing.assert_allclose(left, np.array([0.0 * x, state[0] * push, 0.0 * x, state[2] * push]), atol=1e-8)


def test_one_velocity_is_bernoullis_flow():
    x = np.linspace(0.0, 25.0, 501)
    found = profile("subcritical-bump").at(x)
    assert np.abs(found["h"] - exact.steady_flow(parabolic_bump(x), 4.42, 2.0)).max() < 1e-12
    found = profile("transcritical-bump").at(x)
    error = np.abs(found["h"] - exact.steady_flow(parabolic_bump(x), 1.53, regime="transcritical"))
    assert error[x != 10.0].max() < 1e-11
    assert error.max() < 1e-6, "the square root of rounding at the crest"
    assert max(np.ptp(found["phi"]), np.abs(found["vs"] - found["vf"]).max()) < 1e-13


def test_one_velocity_passes_the_point_where_inner_waves_stand():
    """Uniform phi and vs = vf stay so there; any slip is choked."""
    flow = {"h": 1.0, "phi": 0.6, "vs": 0.9, "vf": 0.9}
    x = np.linspace(0.0, 10.0, 101)
    found = gr.steady(smooth_bump, flow, (0.0, 10.0)).at(x)
    assert found["vs"].max() > 1.05, "the inner waves move at 0.99 m/s relative to the flow"
    np.testing.assert_allclose(found["h"], exact.steady_flow(smooth_bump(x), 0.9, 1.0), rtol=1e-12)
    with pytest.raises(ValueError, match=r"the inner waves stand at b = 0\.13"):
        gr.steady(smooth_bump, {**flow, "vf": 0.8}, (0.0, 10.0))


def test_a_transcritical_flow_with_slip_is_critical_at_the_crest():
    flow = gr.steady(parabolic_bump, {"h": 1.0, "phi": 0.6, "vs": 1.53, "vf": 1.33}, (0.0, 25.0), transcritical=True)
    assert flow.crest == pytest.approx(10.0)
    assert (flow.ms, flow.mf) == pytest.approx((0.6 * 1.53, 0.4 * 1.33), rel=1e-15)

    def speeds(x):
        return gr.TwoPhase().eigenvalues(gr.TwoPhase().conserved_from(**flow.at(np.array([x]))))[:, 0].real

    assert speeds(9.0)[0] < -0.3
    assert abs(speeds(10.0)[0]) < 1e-5
    assert speeds(11.0)[0] > 0.3
    h = flow.at(np.array([9.999, 10.0, 10.001]))["h"]
    assert h[0] - h[1] == pytest.approx(h[1] - h[2], rel=1e-3), "smooth through the crest"
    grid = fv.Grid(0.0, 25.0, 100)
    assert drift(flow, grid, flow.discrete(gr.TwoPhase(), grid), roe("transcritical-bump")) < 1e-14


@pytest.mark.parametrize("order", [1, 2])
@pytest.mark.parametrize("name", NAMES)
def test_the_scheme_keeps_the_discrete_flow_to_rounding(name, order):
    flow = profile(name)
    grid = fv.Grid(*flow.interval, 100)
    q = flow.discrete(gr.TwoPhase(), grid)
    for limiter in (fv.MC(), fv.Superbee()) if order == 2 else (None,):
        assert drift(flow, grid, q, roe(name, order, limiter)) < 1e-14
    assert np.abs(q - flow.averages(gr.TwoPhase(), grid)).max() > 1e-7, "it is not the exact one"


@pytest.mark.parametrize("name", NAMES)
def test_from_exact_values_the_plain_scheme_drifts_at_second_order(name):
    flow = profile(name)
    found = []
    for cells in (100, 200):
        grid = fv.Grid(*flow.interval, cells)
        q = gr.TwoPhase().conserved_from(**flow.at(grid.centers))
        found.append(drift(flow, grid, q, roe(name), flow.bottom(grid.centers)))
    assert found[0] == pytest.approx(PLAIN[name], rel=0.05)
    assert found[0] / found[1] > 3.6


@pytest.mark.parametrize("name", NAMES)
def test_a_perturbation_of_a_micrometre_is_resolved(name):
    flow, model = profile(name), gr.TwoPhase()
    grid = fv.Grid(*flow.interval, 100)
    at = model.observables(flow.discrete(model, grid))
    middle, width = (2.0, 0.5) if grid.upper == 10.0 else (8.0, 1.2)
    wave = np.where(np.abs(grid.centers - middle) < width, np.cos(0.5 * np.pi * (grid.centers - middle) / width) ** 2, 0.0)

    def end(eps):
        q = model.conserved_from(at["h"] + eps * wave, at["phi"], at["vs"], at["vf"])
        return solve(fv.Problem(model, grid, q, 1.0, {"b": flow.bottom}), roe(name)).q[-1]

    linear = (end(1e-4) - end(-1e-4)) / 2e-4
    response = (end(1e-6) - end(0.0)) / 1e-6
    whole = (end(1e-6) - model.conserved_from(*(at[k] for k in ("h", "phi", "vs", "vf")))) / 1e-6
    assert np.abs(linear[0] + linear[2]).max() > 0.2
    assert np.abs((response - linear)[[0, 2]].sum(axis=0)).max() < 1e-5
    assert np.abs((whole - linear)[[0, 2]].sum(axis=0)).max() < 1e-5


def test_discrete_flows_of_the_relatives():
    layers = gr.TwoLayer(gamma=0.8)
    flow = gr.steady(smooth_bump, {"h": 1.0, "phi": 0.5, "vs": 0.15, "vf": -0.05}, (0.0, 10.0), at=10.0, model=layers)
    grid = fv.Grid(0.0, 10.0, 50)
    assert drift(flow, grid, flow.discrete(layers, grid), roe("layers"), model=layers) < 1e-14
    bernoulli, water = profile("subcritical-bump"), gr.ShallowWater()
    grid = fv.Grid(0.0, 25.0, 50)
    q = bernoulli.discrete(water, grid)
    problem = fv.Problem(water, grid, q, 1.0, {"b": bernoulli.bottom})
    assert np.abs(solve(problem, roe("water")).q[-1] - q).max() < 1e-14
    with pytest.raises(ValueError, match="one momentum per mass, Reduced"):
        bernoulli.discrete(gr.Reduced(), grid)


def test_averages_are_those_of_every_model():
    flow = profile("moving-slip")
    grid = fv.Grid(0.0, 10.0, 40)
    full, water = flow.averages(gr.TwoPhase(), grid), flow.averages(gr.ShallowWater(), grid)
    np.testing.assert_allclose(full[0] + full[2], water[0], rtol=1e-14)
    np.testing.assert_allclose(full[1], 0.48, rtol=1e-14)
    np.testing.assert_allclose(full[3], -0.08, rtol=1e-14)
    fine = flow.averages(gr.TwoPhase(), fv.Grid(0.0, 10.0, 160)).reshape(4, 40, 4).mean(axis=2)
    np.testing.assert_allclose(full, fine, atol=1e-11)


def higher(x):
    return 4.0 * smooth_bump(x)


@pytest.mark.parametrize(("bottom", "inflow", "more", "words"), [
    (higher, FLOWS["moving-slip"], {}, r"choked flow: .* inner waves stand at b = .* \(first at x = .*rise by .* lower the crest"),
    (higher, {"h": 1.0, "phi": 0.6, "vs": 2.0, "vf": 2.0}, {}, "outer waves stand"),
    (smooth_bump, {"h": 1.0, "phi": 0.6, "vs": 3.0, "vf": 0.0}, {}, "loses hyperbolicity at b = 0, .*less slip"),
    (smooth_bump, {"h": 1.0, "phi": 1.0}, {}, "`phi` must be finite and > 0 and < 1"),
    (smooth_bump, {"h": 1.0}, {}, "`inflow` needs h and phi"),
    (smooth_bump, FLOWS["moving-slip"], {"at": 11.0}, "`at` must be .* <= 10"),
    (smooth_bump, {"h": 1.0, "phi": 0.6}, {"transcritical": True}, "no transcritical flow"),
    (lambda x: -smooth_bump(x), FLOWS["moving-slip"], {"transcritical": True}, "crest inside the interval"),
    (lambda x: smooth_bump(2.0 * x - 1.0) + smooth_bump(2.0 * x - 9.0), FLOWS["moving-slip"], {"transcritical": True}, "one crest"),
    (smooth_bump, FLOWS["moving-slip"], {"transcritical": True, "at": 5.0}, "must not be the crest"),
])
def test_where_there_is_no_such_flow_the_message_says_why(bottom, inflow, more, words):
    with pytest.raises(ValueError, match=words):
        gr.steady(bottom, inflow, (0.0, 10.0), **more)


def test_models_without_such_flows_are_refused():
    with pytest.raises(TypeError, match=r"TwoPhase or gr\.TwoLayer"):
        gr.steady(smooth_bump, FLOWS["moving-slip"], (0.0, 10.0), model=gr.ShallowWater())
