"""Hydrograph, Stage and UniformSlope: what enters is what the table says, levels are kept, uniform flow leaves unhindered."""
from functools import partial

import numpy as np
import pytest
from scipy.integrate import trapezoid

import fvkit as fv
import fvkit_granular as gr
from fvkit.schemes.riemann import default_riemann

#: These tests are about the equations for mild slopes, whatever the ground.
mild_scene = partial(gr.Scene, slope="mild")

MODELS = [gr.TwoPhase, gr.ShallowWater, gr.Reduced, gr.PitmanLe, gr.TwoLayer]
BACKENDS = ["numpy", "numba"]
FLOOD = gr.Hydrograph(times=[0.0, 4.0, 10.0], discharge=[0.0, 1.5, 0.5], phi=[0.2, 0.5, 0.5])


def channel(boundary, t_end=8.0, slope=0.01, **flow):
    state = {"h": 0.4, "phi": 0.3} | flow
    return mild_scene((0.0, 50.0), t_end, lambda x: {name: value + 0.0 * x for name, value in state.items()},
                    bottom=lambda x: -slope * x, boundary=boundary, sources=gr.Manning(0.03))


def schemes(model):
    riemann = fv.HLL() if model is gr.PitmanLe else default_riemann(model())
    return {"wave": fv.WavePropagation(riemann), "lines": fv.MethodOfLines(riemann, integrator=fv.ARK4())}


@pytest.mark.parametrize("method", ["wave", "lines"])
@pytest.mark.parametrize("model", MODELS, ids=lambda kind: kind.__name__)
def test_the_volume_of_a_flood_enters_to_the_last_drop(model, method, backend):
    problem = channel((FLOOD, fv.Wall())).problem(model, 40)
    solution = fv.solve(problem, schemes(model)[method], backend=backend, nonhyperbolic="ignore")
    h = problem.model.depth(solution.q[-1])
    entered = (h - problem.model.depth(problem.q0)).sum() * problem.grid.dx
    assert entered == pytest.approx(0.5 * 1.5 * 4.0 + 4.0 * 0.5 * (1.5 + (1.5 - 4.0 / 6.0)), rel=1e-12)
    assert max(map(abs, solution.stats.mass_drift.values())) < 1e-13


def test_the_solid_of_a_flood_is_the_integral_of_its_share(backend):
    problem = channel((FLOOD, fv.Wall())).problem(gr.TwoPhase, 40)
    scheme = fv.MethodOfLines(gr.Relaxation(), integrator=fv.ARK4())
    solution = fv.solve(problem, scheme, backend=backend)
    t = np.linspace(0.0, 8.0, 80_001)
    discharge, phi = np.array([FLOOD.at(time) for time in t]).T
    expected = trapezoid(discharge * phi, t)
    entered = (solution.q[-1][0] - problem.q0[0]).sum() * problem.grid.dx
    assert entered == pytest.approx(expected, rel=1e-8)


def test_a_flood_runs_out_onto_dry_ground(backend):
    scene = channel((FLOOD, gr.UniformSlope()), h=0.0)
    problem = scene.problem(gr.TwoPhase(dry=1e-6), 60)
    solution = fv.solve(problem, backend=backend)
    entered = (solution.q[-1][0] + solution.q[-1][2]).sum() * problem.grid.dx
    assert entered == pytest.approx(3.0 + 4.0 * 0.5 * (1.5 + (1.5 - 4.0 / 6.0)), rel=1e-12)
    assert solution.observables()["h"][-1] == 0.0


@pytest.mark.parametrize("side", [0, 1])
def test_both_ends_take_a_flood_alike(side, backend):
    ends = [fv.Wall(), fv.Wall()]
    ends[side] = FLOOD
    solution = fv.solve(channel(tuple(ends), slope=0.0).problem(gr.TwoPhase, 30), backend=backend)
    other = fv.solve(channel(tuple(ends[::-1]), slope=0.0).problem(gr.TwoPhase, 30), backend=backend)
    mirrored = other.q[-1][:, ::-1] * np.array([1.0, -1.0, 1.0, -1.0])[:, None]
    np.testing.assert_allclose(solution.q[-1], mirrored, atol=1e-12)


def test_backends_agree_on_a_flood_with_rejected_steps():
    pytest.importorskip("numba")
    problem = channel((FLOOD, gr.UniformSlope()), h=1e-3).problem(gr.TwoPhase, 40)
    ends = [fv.solve(problem, backend=name) for name in BACKENDS]
    assert ends[0].stats.rejected > 0
    assert ends[0].stats.steps == ends[1].stats.steps
    np.testing.assert_allclose(ends[0].q[-1], ends[1].q[-1], atol=1e-11)


def test_no_inflow_keeps_water_at_rest_over_a_slope(backend):
    scene = mild_scene((0.0, 10.0), 2.0, lambda x: {"h": 1.0 - 0.05 * x, "phi": 0.4}, bottom=lambda x: 0.05 * x,
                     boundary=(gr.Hydrograph(0.0, 0.0, 0.4), fv.Outflow()))
    problem = scene.problem(gr.TwoPhase, 30)
    np.testing.assert_allclose(fv.solve(problem, backend=backend).q[-1], problem.q0, atol=1e-13)


def test_a_given_depth_lets_a_flow_in_that_is_faster_than_its_waves(backend):
    state = {"h": 0.5, "phi": 0.3, "vs": 6.0, "vf": 6.0}
    scene = mild_scene((0.0, 10.0), 3.0, lambda x: {name: value + 0.0 * x for name, value in state.items()},
                     boundary=(gr.Hydrograph(0.0, 3.0, 0.3, depth=0.5), fv.Outflow()))
    problem = scene.problem(gr.TwoPhase, 20)
    np.testing.assert_allclose(fv.solve(problem, backend=backend).q[-1], problem.q0, atol=1e-12)


@pytest.mark.parametrize("slope", [0.0, 0.05])
@pytest.mark.parametrize("h", [0.0, 0.2])
def test_a_given_depth_that_the_flow_inside_lacks_pushes_no_jet(h, slope, backend):
    """1 m^2/s at a stage of 2 m has 0.5 m/s; onto dry or shallow ground it goes over its critical depth, not under 2 m of water."""
    def run(depth):
        scene = mild_scene((0.0, 50.0), 6.0, lambda x: {"h": h + 0.0 * x, "phi": 0.3}, bottom=lambda x: -slope * x,
                           boundary=(gr.Hydrograph(0.0, 1.0, 0.3, depth=depth), fv.Outflow()), sources=gr.Manning(0.03))
        return fv.solve(scene.problem(gr.TwoPhase, 25), backend=backend)

    staged, free = run(2.0), run(None)
    np.testing.assert_array_equal(staged.q[-1], free.q[-1])
    assert staged.observables()["v"].max() < 4.0


@pytest.mark.parametrize("model", [gr.TwoPhase, gr.ShallowWater, gr.Reduced], ids=lambda kind: kind.__name__)
def test_a_stage_keeps_a_lake_of_its_level_and_lets_a_higher_one_off(model, backend):
    def lake(level):
        return mild_scene((0.0, 10.0), 150.0, lambda x: {"h": level - 0.05 * x, "phi": 0.4}, bottom=lambda x: 0.05 * x,
                        boundary=(fv.Wall(), gr.FixedLevel(1.0, phi=0.4)), sources=gr.Manning(0.2)).problem(model, 30)

    at_rest = lake(1.0)
    np.testing.assert_allclose(fv.solve(at_rest, backend=backend).q[-1], at_rest.q0, atol=1e-12)
    surface = fv.solve(lake(1.3), backend=backend).observables()["surface"]
    assert surface == pytest.approx(1.0, abs=0.01)


def test_a_stage_fills_a_dry_basin_with_what_it_holds(backend):
    scene = mild_scene((0.0, 10.0), 60.0, lambda x: {"h": 0.0 * x, "phi": 0.0}, boundary=(gr.FixedLevel(0.5, phi=0.2), fv.Wall()),
                     sources=gr.Manning(0.2))
    solution = fv.solve(scene.problem(gr.TwoPhase(dry=1e-6), 30), backend=backend)
    seen = solution.observables()
    np.testing.assert_allclose(seen["h"], 0.5, atol=0.02)
    np.testing.assert_allclose(seen["phi"], 0.2, atol=0.02)


@pytest.mark.parametrize("slope", [None, 0.02], ids=["of the bottom", "given"])
def test_uniform_flow_leaves_unhindered_on_a_slope(slope, backend):
    # Manning: slope = n^2 v^2 / h^(4/3)
    h, n, fall = 0.5, 0.03, 0.02
    v = np.sqrt(fall) * h ** (2.0 / 3.0) / n
    scene = mild_scene((0.0, 40.0), 20.0, lambda x: {"h": h + 0.0 * x, "phi": 0.0, "vf": v}, bottom=lambda x: -fall * x,
                     sources=gr.Manning(n), boundary=(gr.UniformSlope(-fall), gr.UniformSlope(slope)))
    problem = scene.problem(gr.ShallowWater, 40)
    change = fv.solve(problem, backend=backend).q[-1] / problem.q0 - 1.0
    assert np.abs(change).max() < 5e-3  # splitting, alike in every cell
    assert np.ptp(change, axis=1).max() < 1e-12
    held_back = fv.solve(mild_scene(scene.interval, scene.t_end, scene.initial, scene.bottom, sources=scene.sources)
                         .problem(gr.ShallowWater, 40), backend=backend)
    assert np.ptp(held_back.q[-1] / problem.q0, axis=1).max() > 0.01


@pytest.mark.parametrize(("arguments", "words"), [
    (([0.0, 0.0], [1.0, 1.0], 0.3), "must ascend"), (([0.0, 1.0], [1.0, 2.0, 3.0], 0.3), "one entry for each of the 2 times"),
    (([0.0, 1.0], [1.0, -2.0], 0.3), "fv.Outflow or gr.FixedLevel"), (([0.0, 1.0], [1.0, 2.0], 1.3), r"`phi` .* in \[0, 1\]"),
    (([0.0, np.nan], [1.0, 2.0], 0.3), "finite"), (("soon", 1.0, 0.3), "numbers"),
])
def test_a_table_that_cannot_be_is_refused(arguments, words):
    with pytest.raises((ValueError, TypeError), match=words):
        gr.Hydrograph(*arguments)


@pytest.mark.parametrize("end", [FLOOD, gr.FixedLevel(1.0), gr.UniformSlope(0.1)], ids=lambda end: type(end).__name__)
def test_a_model_without_depth_is_refused(end):
    with pytest.raises(ValueError, match=f"{type(end).__name__} needs a model .*gr.TwoPhase, got Advection"):
        fv.Problem(fv.Advection(1.0), fv.Grid(0.0, 1.0, 10), np.ones((1, 10)), 1.0, boundary=end)


def test_a_run_with_these_ends_resumes_bit_for_bit(tmp_path, backend):
    problem = channel((FLOOD, gr.UniformSlope())).problem(gr.TwoPhase, 30)
    whole = fv.solve(problem, backend=backend)
    part = fv.solve(problem, backend=backend, checkpoint=fv.Checkpoint(tmp_path / "run.npz"), limits=fv.Limits(steps=20), throw=False)
    assert not part.success
    again = fv.resume(tmp_path / "run.npz")
    assert again.stats.steps == whole.stats.steps
    np.testing.assert_array_equal(again.q[-1], whole.q[-1])
