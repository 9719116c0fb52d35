"""Flow down slopes and over steps of the bottom: what finished, and was wrong without a word, in the first version."""

import warnings
from functools import partial

import attrs
import numpy as np
import pytest
from scipy.optimize import brentq

import fvkit as fv
import fvkit_granular as gr
from fvkit.backends.compiled.numba_kernel import available
from tests.benchmarks.steady_flow import BEFORE_STEP, STEP_DISCHARGE, over_a_step, river

#: These tests are about the equations for mild slopes, whatever the ground.
mild_scene = partial(gr.Scene, slope="mild")

G = 9.81
#: Long runs are compiled where that is possible; tests/backends compares both.
FAST = "numba" if available() else "numpy"
SOLVERS = [gr.Relaxation(), fv.Roe(), fv.HLL(), fv.Rusanov()]
MODELS = [gr.ShallowWater, gr.Reduced, gr.TwoPhase]


def kind_of(part):
    return part.__name__ if isinstance(part, type) else type(part).__name__


def scheme(riemann, order=2, **settings):
    return fv.WavePropagation(riemann, order=order, **settings)


# ---------------------------------------------------------------------- a block of water on a dry plane

def block_error(riemann, order, slope, cells, model=gr.ShallowWater, backend="auto"):
    """L1 error of h over the 240 m^2 of 3 m x 80 m after 6 s, against two fans in the accelerated frame, and the largest speed."""
    t, c = 6.0, np.sqrt(3.0 * G)
    fall = 0.5 * G * slope * t * t
    scene = mild_scene((-100.0, 400.0 + fall), t, lambda x: {"h": np.where((x > 40.0) & (x < 120.0), 3.0, 0.0), "phi": 0.5},
                     bottom=lambda x: -slope * x)
    problem = scene.problem(model, cells)
    solution = fv.solve(problem, scheme(riemann, order), nonhyperbolic="ignore", backend=backend)
    edges = np.linspace(-100.0, 400.0 + fall, 16 * cells + 1)
    y = 0.5 * (edges[1:] + edges[:-1]) - fall
    right, left = (y - 120.0) / t, (40.0 - y) / t
    depth = np.full_like(y, 3.0)
    for side in (right, left):
        depth = np.minimum(depth, np.where(side > -c, np.clip(2.0 * c - side, 0.0, None) ** 2 / (9.0 * G), 3.0))
    seen = solution.observables()
    error = np.abs(seen["h"] - depth.reshape(cells, 16).mean(axis=1)).sum() * problem.grid.dx / 240.0
    return error, seen["v"][seen["h"] > 0.01].max() / (2.0 * c + G * slope * t), solution


@pytest.mark.parametrize("order", [1, 2])
@pytest.mark.parametrize("slope", [0.05, 0.2, 1.0])
@pytest.mark.parametrize("riemann", SOLVERS, ids=kind_of)
def test_a_block_slides_down_a_dry_slope_as_it_should(riemann, slope, order):
    coarse, _, _ = block_error(riemann, order, slope, 400)
    fine, fastest, _ = block_error(riemann, order, slope, 800)
    assert fine < (0.08 if order == 1 else 0.027)
    assert np.log2(coarse / fine) > (0.55 if order == 1 else 0.65)
    assert fastest < 1.04


def test_both_backends_agree_on_a_block_on_a_dry_slope():
    pytest.importorskip("numba", reason="the compiled backend needs the extra `fast`")
    for riemann in (fv.HLL(), fv.Rusanov()):
        one, other = (block_error(riemann, 2, 0.2, 400, backend=backend)[2].q[-1] for backend in ("numpy", "numba"))
        assert np.abs(one - other).max() < 1e-11 * np.abs(one).max()


# ---------------------------------------------------------------------- uniform flow

@attrs.frozen
class Sloping(fv.BoundaryCondition):
    """A state over a bottom that goes on falling."""

    state: tuple[float, ...] = ()
    slope: float = 0.0

    def values(self, model, t):
        return self.state

    def ghost(self, model, q, values):
        return values

    def ghost_aux(self, model, aux, distance):
        return aux - self.slope * distance


@attrs.frozen
class Viscous(gr.BasalFriction):
    """A law of a user's own."""

    k: float = 1.0

    def resistance(self, model, load, h, speed):
        return self.k * speed / h


def uniform_drift(law, riemann, order, slope, froude, fall, model=gr.ShallowWater, steps=200, cells=20, cfl=0.9):
    """Largest change of depth or velocity, relative, of uniform flow whose bottom falls by ``fall`` depths per cell."""
    h, made = 0.5, model()
    v, dx = froude * np.sqrt(G * h), fall * h / slope
    phi = 1.0 if model is gr.TwoPhase else 0.4
    load = G * {gr.ShallowWater: 1.0, gr.Reduced: 1.0 - 0.5 / 0.7, gr.TwoPhase: 0.5}[model]
    friction = {"manning": gr.Manning(h ** (2 / 3) * np.sqrt(slope) / v), "viscous": Viscous(G * slope * h / v),
                "voellmy": gr.Voellmy(0.5 * slope * G / load, v * v / (h * slope * 0.5)),
                "coulomb": gr.CoulombFriction(slope * G / load)}[law]
    q = made.conserved_from(np.full(cells, h), phi, v, v)
    state, b = tuple(float(row[0]) for row in q), -slope * dx * (np.arange(cells) + 0.5)
    problem = fv.Problem(made, fv.Grid(0.0, cells * dx, cells), q, 1e9, {"b": b}, (Sloping(state, -slope), Sloping(state, slope)), friction)
    seen = fv.solve(problem, scheme(riemann, order, cfl=cfl), limits=fv.Limits(steps=steps), throw=False, nonhyperbolic="ignore").observables()
    return max(np.abs(seen["h"] / h - 1.0).max(), np.abs(seen["v"] / v - 1.0).max())


@pytest.mark.parametrize("order", [1, 2])
@pytest.mark.parametrize("riemann", SOLVERS, ids=kind_of)
@pytest.mark.parametrize("law", ["manning", "viscous", "voellmy", "coulomb"])
def test_uniform_flow_is_kept_whatever_the_grid(law, riemann, order):
    froudes = {"manning": (0.2, 1.2), "viscous": (0.2, 0.5), "voellmy": (0.6, 1.8), "coulomb": (0.3, 1.2)}[law]
    drift = max(uniform_drift(law, riemann, order, slope, froude, fall)
                for slope, froude, fall in ((0.001, froudes[0], 0.1), (0.1, froudes[0], 50.0), (1.0, froudes[1], 2.0)))
    assert drift < (1e-12 if law == "coulomb" else 1e-13)


@pytest.mark.parametrize("model", MODELS[1:], ids=kind_of)
@pytest.mark.parametrize("law", ["manning", "voellmy", "coulomb"])
def test_uniform_flow_is_kept_in_every_model_and_at_any_courant_number(law, model):
    for riemann, cfl in ((gr.Relaxation(), 0.9), (fv.HLL(), 0.1)):
        assert uniform_drift(law, riemann, 2, 0.1, 0.8, 1.0, model, cfl=cfl) < (1e-12 if law == "coulomb" else 1e-13)


@pytest.mark.parametrize("riemann", SOLVERS, ids=kind_of)
def test_a_layer_that_starts_to_slide_feels_all_of_its_friction(riemann):
    for slope, nu in ((np.tan(np.radians(22.0)), np.tan(np.radians(21.0))), (0.1, 0.0999)):
        b = -slope * 10.0 * (np.arange(40) + 0.5)
        problem = fv.Problem(gr.ShallowWater(), fv.Grid(0.0, 400.0, 40), np.stack([np.ones(40), np.zeros(40)]), 5.0, {"b": b},
                             gr.UniformSlope(), gr.CoulombFriction(nu))
        v = fv.solve(problem, scheme(riemann)).observables()["v"]
        np.testing.assert_allclose(v[15:25], G * (slope - nu) * 5.0, rtol=1e-11)


@pytest.mark.parametrize(("law", "rate"), [(gr.Manning(0.05), lambda v: G * 0.05 - G * 0.0025 * v * v), (Viscous(0.3), lambda v: G * 0.05 - 0.3 * v),
                                           (gr.Voellmy(0.02, 200.0), lambda v: G * 0.03 - G / 200.0 * v * v)], ids=["manning", "own", "voellmy"])
def test_acceleration_to_the_terminal_speed_is_of_second_order(law, rate):
    from scipy.integrate import solve_ivp

    wanted = solve_ivp(lambda t, v: rate(v), (0.0, 4.0), [6.0], rtol=1e-12, atol=1e-14).y[0, -1]
    errors = []
    for cells in (40, 80, 160):
        b = -0.05 * 400.0 / cells * (np.arange(cells) + 0.5)
        problem = fv.Problem(gr.ShallowWater(), fv.Grid(0.0, 400.0, cells), np.stack([np.ones(cells), np.full(cells, 6.0)]), 4.0, {"b": b},
                             gr.UniformSlope(), law)
        errors.append(abs(fv.solve(problem).observables()["v"][cells // 2] - wanted))
    assert np.log2(errors[-2] / errors[-1]) > 1.6


@pytest.mark.parametrize("riemann", SOLVERS, ids=kind_of)
@pytest.mark.parametrize("source", [gr.Manning(1e8), gr.Voellmy(0.0, 1e-12)], ids=kind_of)
@pytest.mark.filterwarnings("ignore:.*and plausible from")
def test_roughness_without_bound_stops_water(source, riemann):
    scene = mild_scene((-5.0, 5.0), 1.0, lambda x: {"h": np.where(x < 0, 2.0, 1.0), "phi": 0.3}, sources=source, boundary=fv.Wall())
    solution = fv.solve(scene.problem(gr.TwoPhase, 50), scheme(riemann))
    assert np.abs(solution.q[-1] - solution.q[0])[[0, 2]].max() < 1e-3


# ---------------------------------------------------------------------- steps of the bottom

@pytest.mark.parametrize("model", MODELS, ids=kind_of)
@pytest.mark.parametrize("riemann", SOLVERS[:2], ids=kind_of)
def test_a_dam_break_over_a_step_has_its_discharge(riemann, model):
    """SWASHES 7.1.1: 4.678 m^2/s, exact by Bernoulli's theorem."""
    seen = over_a_step(model, scheme(riemann))
    assert seen["h"][BEFORE_STEP] * seen["v"][BEFORE_STEP] == pytest.approx(STEP_DISCHARGE, rel=1e-3)
    head = seen["v"] ** 2 / (2.0 * G) + seen["surface"]
    assert head[212] - head[188] == pytest.approx(0.0, abs=1e-3)


@pytest.mark.parametrize("drop", [0.5, 3.0, 10.0])
@pytest.mark.parametrize("riemann", SOLVERS, ids=kind_of)
def test_water_that_falls_gains_no_energy(riemann, drop):
    q = 2.0
    critical = (q * q / G) ** (1.0 / 3.0)
    available = 1.5 * critical + drop
    below = brentq(lambda h: h + q * q / (2.0 * G * h * h) - available, 1e-3, critical)

    def flow(x):
        h = np.where(x < 50.0, 1.2 * critical, below)
        return {"h": h, "phi": 0.5, "vs": q / h, "vf": q / h}

    scene = mild_scene((0.0, 100.0), 200.0, flow, bottom=lambda x: np.where(x < 50.0, drop, 0.0),
                     boundary=(gr.Hydrograph([0.0], [q], [0.5]), fv.Outflow()))
    for order in (1, 2):
        seen = fv.solve(scene.problem(gr.ShallowWater, 100), scheme(riemann, order), backend=FAST).observables()
        assert seen["v"][75] ** 2 / (2.0 * G) + seen["h"][75] < 1.005 * available


@pytest.mark.parametrize("model", MODELS, ids=kind_of)
@pytest.mark.parametrize("riemann", SOLVERS, ids=kind_of)
def test_rest_beside_emerged_steps_is_stable(riemann, model):
    x = np.arange(60) + 0.5
    cliff = np.where((x > 20.0) & (x < 30.0), 20.0, 0.0) - 0.1 * x + 10.0
    for b, level, t in ((cliff, 5.0, 200.0), (1.6 * np.random.default_rng(3).random(60), 1.0, 100.0)):
        made = model()
        q = made.conserved_from(np.maximum(level - b, 0.0), 0.5)
        problem = fv.Problem(made, fv.Grid(0.0, 60.0, 60), q, t, {"b": b}, fv.Wall())
        seen = fv.solve(problem, scheme(riemann), nonhyperbolic="ignore").observables()
        assert np.abs(seen["v"]).max() < 1e-13


@pytest.mark.parametrize("model", [gr.ShallowWater, gr.TwoPhase], ids=kind_of)
@pytest.mark.parametrize("riemann", SOLVERS, ids=kind_of)
def test_nothing_climbs_a_wall_that_it_has_not_the_energy_for(riemann, model):
    scene = mild_scene((0.0, 10.0), 1.5, lambda x: {"h": np.where(x < 5.0, 1.0, 0.0), "phi": 0.5}, bottom=lambda x: np.where(x > 8.0, 20.0, 0.0),
                     boundary=fv.Wall())
    seen = fv.solve(scene.problem(model, 100), scheme(riemann), nonhyperbolic="ignore").observables()
    assert seen["h"][80:].max() < 1e-6


# ---------------------------------------------------------------------- units, and phases that are all but absent

@pytest.mark.parametrize("model", [gr.ShallowWater, gr.TwoPhase], ids=kind_of)
@pytest.mark.parametrize("riemann", SOLVERS, ids=kind_of)
def test_results_depend_on_no_unit(riemann, model):
    def run(length):
        speed = np.sqrt(length)
        scene = mild_scene((0.0, 10.0 * length), 1.5 * speed, lambda x: {
            "h": length * np.where(x < 3.0 * length, 2.0, np.where(x < 8.0 * length, 0.5, 0.0)), "phi": 0.5,
            "vs": np.where(x < 2.0 * length, 0.4 * speed, 0.0), "vf": np.where(x < 2.0 * length, 0.4 * speed, 0.0)},
            bottom=lambda x: 0.3 * length * np.exp(-((x / length - 5.0) ** 2)), boundary=(fv.Wall(), fv.Outflow()))
        solution = fv.solve(scene.problem(model, 80), scheme(riemann), nonhyperbolic="ignore")
        units = [length * speed if "v" in name else length for name in solution.model.conserved]
        return solution.q[-1] / np.array(units)[:, None]

    np.testing.assert_array_equal(run(1024.0), run(1.0))


@pytest.mark.parametrize("phi", [0.0, 1e-8, 1e-4, 1.0])
@pytest.mark.parametrize("riemann", SOLVERS, ids=kind_of)
def test_one_phase_all_but_alone_is_second_order(riemann, phi):
    from fvkit.problem.cell_averages import cell_averages

    wave = gr.exact.simple_wave(gr.exact.hump(centre=4.0), g=G)

    def flow(x):
        seen = wave.at(x, 0.0)
        return {"h": seen["h"], "phi": phi, "vs": seen["v"], "vf": seen["v"]}

    errors = {}
    for model in (gr.ShallowWater, gr.TwoPhase):
        for cells in (100, 200):
            problem = mild_scene((0.0, 10.0), 0.6, flow).problem(model, cells)
            h = fv.solve(problem, scheme(riemann), nonhyperbolic="ignore").observables()["h"]
            errors[model, cells] = np.abs(h - cell_averages(lambda x: wave.at(x, 0.6)["h"], problem.grid, None, "h")).mean()
    assert errors[gr.TwoPhase, 200] < 1.2 * errors[gr.ShallowWater, 200]
    assert np.log2(errors[gr.TwoPhase, 100] / errors[gr.TwoPhase, 200]) > 1.9


# ---------------------------------------------------------------------- what helpers found after all of the above

@pytest.mark.parametrize("model", [gr.ShallowWater, gr.TwoPhase], ids=kind_of)
@pytest.mark.parametrize("riemann", SOLVERS, ids=kind_of)
def test_water_falls_off_a_cliff_whatever_stands_below(riemann, model):
    """The fan of a dam break onto dry ground: it is critical at the brink, q = 8/27 h sqrt(g h)."""
    cells, h, t = 120, 0.2, 12.0
    x, made = (np.arange(cells) + 0.5) * 60.0 / cells, model()
    for below in (0.1, 0.5, 1.0):
        q = made.conserved_from(np.where(x < 20.0, h, below), 0.5)
        problem = fv.Problem(made, fv.Grid(0.0, 60.0, cells), q, t, {"b": np.where(x < 20.0, 10.0, 0.0)}, fv.Wall())
        seen = fv.solve(problem, scheme(riemann), nonhyperbolic="ignore").observables()
        fallen = 20.0 * h - seen["h"][:cells // 3].sum() * 60.0 / cells
        assert fallen == pytest.approx(8.0 / 27.0 * h * np.sqrt(G * h) * t, rel=0.2)


@pytest.mark.parametrize("riemann", SOLVERS, ids=kind_of)
def test_rounding_does_not_grow_in_a_block_that_slides(riemann):
    x = (np.arange(400) + 0.5) / 2.0

    def state(disturbed):
        q = np.stack([np.where((x > 20.0) & (x < 60.0), 2.0 * (1.0 + disturbed * np.sin(x)), 0.0), 0.0 * x])
        problem = fv.Problem(gr.ShallowWater(), fv.Grid(0.0, 200.0, 400), q, 3.8, {"b": -0.4 * x}, fv.Outflow())
        return fv.solve(problem, scheme(riemann)).q[-1]

    assert np.abs(state(0.0) - state(1e-13)).max() < 1e-10


@pytest.mark.parametrize("riemann", [fv.Roe(), fv.HLL(), fv.Rusanov(), gr.Relaxation()], ids=lambda solver: type(solver).__name__)
def test_steady_flow_over_a_bump_settles_to_rounding_at_a_large_courant_number(riemann):
    """At order 2, Courant number .87, with limited slopes at the kinks of the bump: no limit cycle."""
    pytest.importorskip("numba")
    ends = gr.Hydrograph((0.0,), (4.42,), (0.0,)), gr.FixedLevel(2.0)
    x = fv.Grid(0.0, 25.0, 100).centers
    bump = np.maximum(0.2 - 0.05 * (x - 10.0) ** 2, 0.0)
    problem = fv.Problem(gr.ShallowWater(), fv.Grid(0.0, 25.0, 100), np.stack([2.0 - bump, np.full(100, 4.42)]), 1e4,
                         aux={"b": bump}, boundary=ends)
    stepper = fv.Stepper(problem, fv.WavePropagation(riemann), backend="numba")
    for _ in range(12_000):
        before = stepper.q.copy()
        stepper.step(0.033)
    assert np.abs(stepper.q[0] - before[0]).max() < 1e-13


@pytest.mark.parametrize("model", [gr.ShallowWater(g=G), gr.TwoPhase(g=G)], ids=kind_of)
@pytest.mark.parametrize(("slope", "bump", "friction"), [(0.3, 0.0, 0.0), (0.05, 0.0, 0.0), (0.0, 0.3, 0.0), (0.5, 0.0, 0.2)])
@pytest.mark.parametrize("riemann", [fv.Roe(), fv.HLL(), fv.Rusanov()], ids=kind_of)
def test_steady_flow_faster_than_its_waves_settles(riemann, slope, bump, friction, model):
    """Down a plane, over a bump, with Coulomb friction: no waves where the jump is balanced, so no limit cycle."""
    pytest.importorskip("numba")
    cells, dx = 160, 2.5
    state = model.conserved_from(1.0, 0.4, 6.0, 6.0)
    problem = fv.Problem(model, fv.Grid(0.0, cells * dx, cells), lambda x: [0.0 * x + value for value in state], 120.0,
                         {"b": lambda x: bump * np.exp(-((x - 200.0) / 20.0) ** 2) - slope * x}, (fv.Inflow(state), fv.Outflow()),
                         (gr.CoulombFriction(friction),) if friction and len(state) == 2 else ())
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", gr.SteepSlopeWarning)
        earlier, later = fv.solve(problem, fv.WavePropagation(riemann), times=[119.0, 120.0]).q[-2:]
    change = np.abs(later - earlier).max(axis=1) / np.maximum(np.abs(later).max(axis=1), 1e-300)
    assert change.max() < 1e-12


@pytest.mark.parametrize(("model", "order"), [(gr.Reduced(g=G), 1), (gr.Reduced(g=G), 2), (gr.TwoPhase(g=G), 2)], ids=["Reduced-1", "Reduced-2", "TwoPhase-2"])
@pytest.mark.parametrize("riemann", [fv.HLL(), fv.Rusanov()], ids=kind_of)
def test_rivers_of_mixtures_settle_over_a_bump(model, riemann, order):
    """Between the bounds of the speeds run contacts and inner waves: differenced centrally where the bottom explains the depths, they grew."""
    pytest.importorskip("numba")
    assert river(model, fv.WavePropagation(riemann, order=order)) < 1e-4
