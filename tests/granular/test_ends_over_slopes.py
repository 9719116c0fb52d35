"""Ends over ground that goes on: a lake keeps its level, a river its depth, and what is given enters."""
import warnings
from functools import partial

import numpy as np
import pytest

import fvkit as fv
import fvkit_granular as gr
from fvkit.problem.slopes import end_slope, end_step
from fvkit.schemes.riemann import default_riemann

#: These tests are about the equations for mild slopes, whatever the ground.
mild_scene = partial(gr.Scene, slope="mild")

MODELS = [gr.TwoPhase, gr.ShallowWater, gr.Reduced, gr.PitmanLe, gr.TwoLayer]
GROUNDS = {"falls": lambda x: -0.05 * x, "rises": lambda x: 0.05 * x, "steep": lambda x: -0.3 * x,
           "hill": lambda x: -0.02 * (x - 5.0) ** 2, "rough": lambda x: 0.3 * np.sin(7.0 * x)}
SLOPE, MANNING = 0.05, 0.03


def lake(model, ground, level=0.4, cells=20):
    """State and bottom of a lake, its layers level too; dry where the ground is higher."""
    b = ground(fv.Grid(0.0, 10.0, cells).centers)
    h = np.maximum(level - b, 0.0)
    if model is gr.TwoLayer:
        lower = np.maximum(level - 0.25 - b, 0.0)
        return np.stack([lower, 0.0 * h, h - lower, 0.0 * h]), b
    return model().conserved_from(h, 0.4), b


def at_rest(model, ground, boundary, lines=False, backend="numpy"):
    q, b = lake(model, ground)
    problem = fv.Problem(model(), fv.Grid(0.0, 10.0, q.shape[1]), q, 1.0, {"b": b}, boundary(q))
    riemann = fv.HLL() if model is gr.PitmanLe else default_riemann(model())
    scheme = fv.MethodOfLines(riemann) if lines else fv.WavePropagation(riemann)
    return np.abs(fv.solve(problem, scheme, backend=backend).q[-1] - q).max()


REST = {"outflow": lambda q: fv.Outflow(), "inflow": lambda q: (fv.Inflow(q[:, 0]), fv.Inflow(q[:, -1])),
        "stage": lambda q: gr.FixedLevel(0.4, phi=0.4), "no flood": lambda q: gr.Hydrograph(0.0, 0.0, 0.4)}


@pytest.mark.parametrize("lines", [False, True], ids=["wave", "lines"])
@pytest.mark.parametrize("ground", GROUNDS)
@pytest.mark.parametrize("end", REST)
@pytest.mark.parametrize("model", MODELS, ids=lambda kind: kind.__name__)
def test_a_lake_is_at_rest_at_every_end_over_any_ground(model, end, ground, lines):
    if model is gr.TwoLayer and end in ("stage", "no flood"):
        pytest.skip("a lake of one mixture does not hold layers")
    assert at_rest(model, GROUNDS[ground], REST[end], lines) < 1e-13


@pytest.mark.parametrize("end", REST)
def test_compiled_ends_keep_a_lake_as_well(end):
    pytest.importorskip("numba")
    assert at_rest(gr.TwoPhase, GROUNDS["falls"], REST[end], backend="numba") < 1e-13


def test_the_rate_of_change_of_a_lake_is_zero():
    q, b = lake(gr.ShallowWater, GROUNDS["falls"])
    problem = fv.Problem(gr.ShallowWater(), fv.Grid(0.0, 10.0, 20), q, 1.0, {"b": b}, (gr.FixedLevel(0.4), fv.Outflow()))
    assert np.abs(fv.rhs(problem)(0.0, q)).max() < 1e-13


def river(law, h, v, boundary, slope=SLOPE, t_end=30.0, left_falls=False):
    """A uniform flow down a plane: to the right, or its mirror image."""
    sign = -1.0 if left_falls else 1.0
    scene = mild_scene((-50.0, 50.0), t_end, lambda x: {"h": h + 0.0 * x, "phi": 0.4, "vs": sign * v, "vf": sign * v},
                     bottom=lambda x: -sign * slope * x, sources=law, boundary=boundary[::-1] if left_falls else boundary)
    return scene.problem(gr.ShallowWater, 50)


def normal(h, slope=SLOPE):
    """The speed at which Manning's friction balances a slope."""
    return np.sqrt(slope) * h ** (2.0 / 3.0) / MANNING


FLOWS = {"subcritical": (gr.Manning(MANNING), 1.0, normal(1.0, 0.002), 0.002), "fast": (gr.Manning(MANNING), 0.3, normal(0.3), SLOPE),
         "Voellmy": (gr.Voellmy(0.02, 400.0), 0.5, np.sqrt((SLOPE - 0.02) * 400.0 * 0.5), SLOPE),
         "creeping grains": (gr.CoulombFriction(SLOPE), 0.5, 1.0, SLOPE), "grains": (gr.CoulombFriction(SLOPE), 0.5, 6.0, SLOPE)}


@pytest.mark.parametrize("left_falls", [False, True], ids=["right", "left"])
@pytest.mark.parametrize("leaves", ["uniform", "outflow", "stage"])
@pytest.mark.parametrize("name", FLOWS)
def test_uniform_flow_stays_uniform_from_end_to_end(name, leaves, left_falls):
    law, h, v, slope = FLOWS[name]
    end = {"uniform": gr.UniformSlope(), "outflow": fv.Outflow(), "stage": gr.FixedLevel(h - 50.0 * slope, phi=0.4)}[leaves]
    problem = river(law, h, v, (gr.Hydrograph(0.0, h * v, 0.4, depth=h), end), slope, left_falls=left_falls)
    np.testing.assert_allclose(fv.solve(problem, backend="numpy").q[-1], problem.q0, rtol=1e-11)


def test_compiled_ends_keep_uniform_flow(backend):
    law, h, v, slope = FLOWS["subcritical"]
    problem = river(law, h, v, (gr.Hydrograph(0.0, h * v, 0.4), fv.Outflow()), slope)
    np.testing.assert_allclose(fv.solve(problem, backend=backend).q[-1], problem.q0, rtol=1e-12)


def test_uniform_flow_leaves_a_fifth_order_scheme_uniform():
    law, h, v, slope = FLOWS["fast"]
    problem = river(law, h, v, (gr.UniformSlope(-slope), fv.Outflow()), slope, t_end=5.0)
    solution = fv.solve(problem, fv.MethodOfLines(gr.Relaxation(), integrator=fv.ARK4()), backend="numpy")
    assert np.ptp(solution.q[-1][0][25:]) < 1e-7 * h


def test_a_river_that_starts_too_deep_leaves_at_its_own_depth():
    slope, q = 1e-3, 2.0
    h = (q * MANNING / np.sqrt(slope)) ** 0.6
    scene = mild_scene((0.0, 5000.0), 20_000.0, lambda x: {"h": 1.5 * h + 0.0 * x, "phi": 0.0, "vf": q / h, "vs": q / h},
                     bottom=lambda x: -slope * x, boundary=(gr.Hydrograph(0.0, q, 0.0), fv.Outflow()), sources=gr.Manning(MANNING))
    np.testing.assert_allclose(fv.solve(scene.problem(gr.ShallowWater, 50), backend="numpy").q[-1][0], h, rtol=1e-3)


@pytest.mark.parametrize("dx", [5.0, 40.0])
@pytest.mark.parametrize("law", [(), gr.CoulombFriction(0.3), gr.Voellmy(0.2, 1000.0), gr.Manning(0.05)], ids=lambda law: type(law).__name__)
@pytest.mark.parametrize("model", [gr.ShallowWater, gr.TwoPhase], ids=lambda kind: kind.__name__)
def test_a_fast_inflow_onto_a_dry_slope_enters_whole(model, law, dx):
    kind = model(dry=1e-6)
    state = kind.conserved_from(1.0, 0.5, 8.0, 8.0)
    problem = fv.Problem(kind, fv.Grid(0.0, 1000.0, round(1000.0 / dx)), lambda x: kind.conserved_from(0.0 * x, 0.5), 10.0,
                         {"b": lambda x: -0.3 * x}, (fv.Inflow(state), fv.Outflow()), law)
    solution = fv.solve(problem, backend="numpy", nonhyperbolic="ignore")
    assert kind.depth(solution.q[-1]).sum() * dx == pytest.approx(80.0, rel=1e-9)


@pytest.mark.parametrize("scheme", [fv.WavePropagation(gr.Relaxation()), fv.WavePropagation(fv.HLL(), order=1), fv.MethodOfLines(fv.HLL())],
                         ids=["order 2", "order 1", "lines"])
@pytest.mark.parametrize("model", [gr.ShallowWater, gr.TwoPhase], ids=lambda kind: kind.__name__)
@pytest.mark.parametrize("dx", [5.0, 40.0])
def test_a_fast_inflow_that_grows_with_time_enters_whole(model, dx, scheme, backend):
    """Its discharge is linear in time, so that the middle of each step gives the integral."""
    kind = model(dry=1e-6)
    problem = fv.Problem(kind, fv.Grid(0.0, 200.0 * dx, 200), lambda x: kind.conserved_from(0.0 * x, 0.5), 10.0,
                         {"b": lambda x: -0.3 * x},
                         (fv.Inflow(lambda t: kind.conserved_from(1.0 + t / 20.0, 0.5, 8.0, 8.0)), fv.Outflow()))
    solution = fv.solve(problem, scheme, backend=backend, nonhyperbolic="ignore")
    assert kind.depth(solution.q[-1]).sum() * dx == pytest.approx(100.0, rel=1e-9)


def test_an_inflow_that_begins_late_is_an_open_end_until_then(backend):
    """Before it begins its state is dry: nothing holds back the water inside, which flows out as to dry ground."""
    model = gr.ShallowWater()

    def left(state):
        problem = fv.Problem(model, fv.Grid(0.0, 100.0, 50), lambda x: model.conserved_from(1.0 + 0.0 * x, 0.0), 5.0,
                             {"b": lambda x: 0.1 * x}, (state, fv.Wall()))
        return fv.solve(problem, backend=backend).q[-1][0].sum() * 2.0
    assert left(fv.Inflow([0.0, 0.0])) == pytest.approx(left(fv.Inflow(lambda t: [0.0, 0.0])), rel=1e-3)
    assert left(fv.Inflow([0.0, 0.0])) == pytest.approx(left(fv.Outflow()), rel=0.05)


def test_a_given_flow_enters_whole_as_well(backend):
    problem = river(gr.Manning(MANNING), 0.3, normal(0.3), (gr.GivenFlow(0.3, 0.4, normal(0.3), normal(0.3)), fv.Outflow()))
    np.testing.assert_allclose(fv.solve(problem, backend=backend).q[-1], problem.q0, rtol=1e-11)


def bump(x):
    return np.maximum(0.0, 0.2 - 0.05 * (x - 10.0) ** 2)


def over_the_bump(discharge, stage, level, t_end=150.0):
    model = gr.ShallowWater()
    return fv.Problem(model, fv.Grid(0.0, 25.0, 100), lambda x: model.conserved_from(level - bump(x), 0.0), t_end, {"b": bump},
                      (gr.Hydrograph(0.0, discharge, 0.0), gr.FixedLevel(stage)))


def test_a_flow_faster_than_its_waves_does_not_feel_a_stage_unless_a_jump_runs_in():
    fast = fv.solve(over_the_bump(1.53, 0.66, 0.66), backend="numpy").q[-1][0]
    assert np.ptp(fast[-20:]) < 2e-3
    assert fast[-1] == pytest.approx(0.4057, abs=2e-3)
    drowned = fv.solve(over_the_bump(1.53, 1.5, 0.66), backend="numpy").q[-1][0]
    assert drowned[-1] == pytest.approx(1.5, abs=0.01)


def test_a_subcritical_flow_has_the_stage_at_its_end():
    h = fv.solve(over_the_bump(4.42, 2.0, 2.0), backend="numpy").q[-1][0]
    assert h[-1] == pytest.approx(2.0, abs=5e-4)


@pytest.mark.parametrize("level", [([1.0, 1.0, 1.5], [0.0, 10.0, 110.0]), (lambda t: 1.0 + 0.005 * max(t - 10.0, 0.0), (0.0,))],
                         ids=["table", "function"])
def test_a_basin_follows_a_level_that_rises(level, backend):
    scene = mild_scene((0.0, 10.0), 90.0, lambda x: {"h": 1.0 + 0.05 * x, "phi": 0.0}, bottom=lambda x: -0.05 * x,
                     boundary=(fv.Wall(), gr.FixedLevel(level[0], times=level[1])), sources=gr.Manning(0.1))
    solution = fv.solve(scene.problem(gr.ShallowWater, 20), backend=backend, times=[10.0, 90.0])
    np.testing.assert_allclose(solution.observables(-2)["surface"], 1.0, atol=1e-12)
    surface = solution.observables()["surface"]
    # The basin sways, since the level starts to rise all at once: 1.40097 in the last 0.5 m and 1.4125 in the first, on 1280 cells.
    assert surface[-1] == pytest.approx(1.40097, abs=5e-4)
    assert surface[0] == pytest.approx(1.4125, abs=3e-3)


@pytest.mark.parametrize("side", [1.0, -1.0], ids=["left", "right"])
@pytest.mark.parametrize("kind", [gr.ShallowWater, gr.Reduced, gr.TwoPhase])
def test_a_level_against_time_holds_at_the_end_itself(kind, side):
    """A small wave runs in from a lake that rises and falls: exact to the square of its height, w(t - x/c)."""
    model, sound, errors = kind(), np.sqrt(9.81), []

    def rise(t):
        return 1e-5 * np.sin(np.pi * np.clip(t, 0.0, 1.5) / 1.5) ** 4

    for cells in (50, 100, 200):
        grid = fv.Grid(0.0, 10.0, cells)
        lake = gr.FixedLevel(lambda t: 1.0 + rise(t), phi=0.4)
        problem = fv.Problem(model, grid, lambda x: model.conserved_from(1.0 + 0.0 * x, 0.4), 2.0,
                             boundary=(lake, fv.Wall()) if side > 0.0 else (fv.Wall(), lake))
        found = fv.solve(problem, fv.WavePropagation(gr.Relaxation()), backend="numpy", step=fv.Step(dt_max=3.0 / cells)).observables()
        away = grid.centers if side > 0.0 else 10.0 - grid.centers
        errors.append(np.abs(found["h"] - 1.0 - rise(2.0 - away / sound)).mean() / 1e-5)
    assert errors[-1] < 2e-3
    assert np.log2(errors[-2] / errors[-1]) > 1.8


def test_a_hydrograph_takes_a_depth_against_time(tmp_path, backend):
    times, discharge, depth = [0.0, 4.0], [2.0, 3.0], [0.4, 0.5]
    path = tmp_path / "flood.csv"
    path.write_text("t [s], discharge [m2/s], phi [-], depth [m]\n0, 2, 0.3, 0.4\n4, 3, 0.3, 0.5\n")
    flood = gr.Hydrograph.read(path)
    assert flood == gr.Hydrograph(times, discharge, [0.3, 0.3], depth)
    model = gr.TwoPhase()
    def given(t):
        h, q = np.interp(t, times, depth), np.interp(t, times, discharge)
        return model.conserved_from(h, 0.3, q / h, q / h)
    scene = mild_scene((0.0, 20.0), 4.0, lambda x: {"h": 0.4 + 0.0 * x, "phi": 0.3, "vs": 5.0, "vf": 5.0}, boundary=(flood, fv.Outflow()))
    ends = [fv.solve(fv.Problem(model, fv.Grid(0.0, 20.0, 40), scene.problem(model, 40).q0, 4.0, boundary=(end, fv.Outflow())),
                     backend=backend) for end in (flood, fv.Inflow(given))]
    np.testing.assert_allclose(ends[0].q[-1], ends[1].q[-1], rtol=1e-9)
    assert ends[0].q[-1][0].max() > 0.3 * 0.45


def test_an_outflow_goes_on_level_where_the_ground_rises():
    """Water that sways in a valley whose sides go on rising: a river that came down them would never end."""
    def swayed(end):
        scene = mild_scene((-10.0, 10.0), 20.0, lambda x: {"h": np.maximum(1.0 - 0.05 * np.abs(x), 0.0), "phi": 0.4, "vs": 1.0, "vf": 1.0},
                         bottom=lambda x: 0.05 * np.abs(x), sources=gr.Manning(0.03), boundary=end)
        return fv.solve(scene.problem(gr.ShallowWater, 40), backend="numpy").q[-1]

    np.testing.assert_array_equal(swayed(fv.Outflow()), swayed(fv.Outflow(slope=0.0)))
    assert swayed(fv.Outflow(slope=-0.05))[0].sum() > 1.1 * swayed(fv.Outflow())[0].sum()


@pytest.mark.parametrize("slope", [-0.2, 0.2])
def test_a_block_runs_off_either_end_of_a_plane_and_leaves_it_dry(slope, backend):
    scene = mild_scene((-20.0, 20.0), 30.0, lambda x: {"h": np.where(np.abs(x) < 3.0, 1.0, 0.0), "phi": 0.4}, bottom=lambda x: slope * x,
                     sources=gr.Manning(0.03))
    solution = fv.solve(scene.problem(gr.TwoPhase, 40), backend=backend)
    assert gr.TwoPhase().depth(solution.q[-1]).max() < 0.01


@pytest.mark.parametrize("end", [fv.Outflow(), gr.UniformSlope()], ids=["outflow", "uniform"])
@pytest.mark.parametrize(("cell", "height"), [(-1, 0.05), (-1, 0.12), (-1, -0.2), (-2, 0.12), (-2, -0.12)])
def test_one_uneven_cell_near_its_end_does_not_pond_a_river(cell, height, end):
    """Subcritical, Froude number .54, falling by .1 m per cell. Far from the end the depth is the normal one; before it a rise or a
    fall of the ground by ``height`` takes at most itself and a tenth from or to the depth."""
    slope, n, q, dx = 0.01, 0.06, 2.0, 10.0
    h, x, model = (q * n / np.sqrt(slope)) ** 0.6, (np.arange(60) + 0.5) * dx, gr.ShallowWater()
    b = -slope * x
    b[cell] += height
    problem = fv.Problem(model, fv.Grid(0.0, 600.0, 60), np.stack([h + 0.0 * x, q + 0.0 * x]), 2000.0, {"b": b},
                         (gr.Hydrograph(0.0, q, 0.0), end), gr.Manning(n))
    depth = fv.solve(problem, fv.WavePropagation(fv.Roe()), backend="numpy").q[-1][0]
    assert np.abs(depth[:-10] / h - 1.0).max() < 0.01
    assert np.abs(depth - h).max() < abs(height) + 0.1 * h


def test_a_slope_is_given_or_seen_and_a_cliff_is_none():
    values = np.array([0.0, 1.0, 2.0, 3.0])
    assert (end_step(values), end_step(values[::-1])) == (1.0, -1.0)
    assert end_step(np.array([9.0, 0.2, 0.1, 0.0])) == pytest.approx(-0.2)
    assert end_step(np.array([0.0, -1.0, 5.0])) == end_step(np.array([0.0, 1.0])) == 0.0
    assert (end_slope(values), end_slope(values[::-1])) == (1.0, -1.0)
    assert end_slope(np.array([9.0, 0.4, 0.3, 0.2, 0.1, 0.0])) == pytest.approx(-0.1)
    law, h, v, slope = FLOWS["fast"]
    seen = river(law, h, v, (gr.Hydrograph(0.0, h * v, 0.4, depth=h), gr.UniformSlope()))
    given = river(law, h, v, (gr.Hydrograph(0.0, h * v, 0.4, depth=h, slope=-slope), gr.UniformSlope(slope)))
    level = river(law, h, v, (gr.Hydrograph(0.0, h * v, 0.4, depth=h, slope=0.0), gr.UniformSlope()))
    ends = [fv.solve(problem, backend="numpy").q[-1][0] for problem in (seen, given, level)]
    np.testing.assert_allclose(ends[0], ends[1], rtol=1e-12)
    assert ends[2][0] > 1.05 * ends[0][0]


@pytest.mark.parametrize("riemann", [gr.Relaxation(), fv.Roe(), fv.HLL(), fv.Rusanov()], ids=lambda riemann: type(riemann).__name__)
def test_a_lake_at_an_end_has_no_more_head_than_its_level(riemann):
    """Onto dry ground it pours as a dam breaks, from either end; on a shore it comes to rest at its level."""
    def volume(interval, cells, start, boundary, inside):
        scene = mild_scene(interval, 4.0, lambda x: {"h": np.where(x < start, 5.0, 0.0), "phi": 0.0}, boundary=boundary)
        solution = fv.solve(scene.problem(gr.ShallowWater, cells), fv.WavePropagation(riemann), backend="numpy")
        assert solution.q[-1, 0].max() < 5.05
        return solution.q[-1, 0][inside].sum() * (interval[1] - interval[0]) / cells

    lake = volume((-100.0, 20.0), 480, 0.0, fv.Wall(), slice(400, None))
    for boundary in ((gr.FixedLevel(5.0), fv.Wall()), (fv.Wall(), gr.FixedLevel(5.0))):
        assert 0.8 * lake < volume((0.0, 20.0), 80, -1.0, boundary, slice(None)) < 1.1 * lake
    shore = mild_scene((0.0, 20.0), 40.0, lambda x: {"h": 0.0 * x, "phi": 0.0}, bottom=lambda x: x, boundary=(gr.FixedLevel(5.0), fv.Wall()))
    solution = fv.solve(shore.problem(gr.ShallowWater, 40), fv.WavePropagation(riemann), backend="numpy")
    assert solution.q[-1, 0].sum() * 0.5 == pytest.approx(12.5, rel=0.02)


FALLING = -0.02 * np.arange(50.0)
LAST = np.arange(50) == 49


@pytest.mark.parametrize("left", [False, True])
@pytest.mark.parametrize(("ground", "warns"), [
    (FALLING + 0.03 * LAST, False), (FALLING + 0.02 * LAST, False), (FALLING + 0.03 * np.cos(3.0 * np.arange(50)), False),
    (FALLING + 0.02 * np.maximum(np.arange(50) - 46.0, 0.0), True), (np.where(np.arange(50) > 46, FALLING[46], FALLING), True),
    (FALLING, False), (-FALLING, False), (0.0 * FALLING, False), (np.where(LAST, 20.0, FALLING), False),
    (0.01 * (49.5 - np.arange(50)) ** 2, False), (np.random.default_rng(0).uniform(-1.0, 1.0, 50), False), (FALLING[:5], False)],
    ids=["bump", "level", "rough", "rise", "step", "plane", "rises", "flat", "wall", "valley", "random", "short"])
def test_last_cells_that_hide_the_slope_of_their_reach_are_warned_of(ground, warns, left):
    model, count = gr.ShallowWater(), len(ground)
    q, ends = model.conserved_from(np.ones(count), 0.0), (fv.Outflow(), fv.Wall()) if left else (fv.Wall(), fv.Outflow())
    with warnings.catch_warnings(record=True) as seen:
        warnings.simplefilter("always")
        for end in (ends, tuple(fv.Outflow(slope=0.001) if isinstance(one, fv.Outflow) else one for one in ends)):
            fv.Problem(model, fv.Grid(0.0, 20.0 * count, count), q, 1.0, {"b": ground[::-1] if left else ground}, end)
    assert ["over the last 10 cells" in str(one.message) for one in seen] == [True] * warns
