"""Steep ground: what slides, holds and rests on it, at any azimuth, in one dimension and in two."""

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import fvkit as fv
import fvkit_granular as gr
from fvkit.problem.directions import in_plane
from fvkit.problem.relief import Slopes
from tests.plane.problems import state

G = 9.81
MODELS = (gr.ShallowWater, gr.Reduced, gr.TwoPhase)


def made(kind, **options):
    """A model of dry grains in air."""
    return kind(slope="steep", **options) if kind is gr.ShallowWater else kind(gamma=5e-4, slope="steep", **options)


def load_share(model):
    """The share of its weight that a dry layer has on the bed."""
    return 1.0 - getattr(model, "gamma", 0.0)


def slab(model, degrees, azimuth, nu, velocity=(0.0, 0.0), t_end=0.5, cells=5, **options):
    """Velocity along x and y of a uniform layer on a plane that falls towards the azimuth."""
    fall = np.tan(np.radians(degrees)) * np.array([np.cos(np.radians(azimuth)), np.sin(np.radians(azimuth))])

    def initial(x, y):
        one = np.ones(np.broadcast(x, y).shape)
        return in_plane(model, *(model.conserved_from(one, one, v * one, v * one) for v in velocity))

    problem = fv.Problem(model, fv.Grid((0.0, 0.0), (50.0, 50.0), (cells, cells)), initial, t_end,
                         aux={"b": lambda x, y: -fall[0] * x - fall[1] * y}, boundary=gr.UniformSlope(),
                         sources=gr.CoulombFriction(nu))
    seen = fv.solve(problem, **options).observables()
    name = "v" if "v_x" in seen else "vs"
    return seen[f"{name}_x"], seen[f"{name}_y"]


@pytest.mark.parametrize("kind", MODELS)
@pytest.mark.parametrize("degrees", [5.0, 20.0, 45.0, 60.0])
def test_a_slab_on_a_line(kind, degrees, backend):
    model, slope, nu = made(kind), np.tan(np.radians(degrees)), 0.05
    problem = fv.Problem(model, fv.Grid(0.0, 100.0, 20), lambda x: model.conserved_from(1.0 + 0.0 * x, 1.0), 1.0,
                         aux={"b": lambda x: -slope * x}, boundary=gr.UniformSlope(), sources=gr.CoulombFriction(nu))
    seen = fv.solve(problem, backend=backend).observables()
    c, s = np.cos(np.radians(degrees)), np.sin(np.radians(degrees))
    np.testing.assert_allclose(seen["v" if "v" in seen else "vs"], G * c * (s - load_share(model) * nu * c), rtol=1e-10)


@pytest.mark.parametrize("kind", MODELS)
@pytest.mark.parametrize("azimuth", [0.0, 30.0, 135.0, 260.0])
def test_a_slab_at_every_azimuth(kind, azimuth):
    model, nu = made(kind), 0.3
    for degrees in (30.0, 60.0):
        vx, vy = slab(model, degrees, azimuth, nu, backend="numpy")
        c, s, a = np.cos(np.radians(degrees)), np.sin(np.radians(degrees)), np.radians(azimuth)
        v = 0.5 * G * c * (s - load_share(model) * nu * c)
        np.testing.assert_allclose(vx, v * np.cos(a), rtol=1e-10, atol=1e-10 * v)
        np.testing.assert_allclose(vy, v * np.sin(a), rtol=1e-10, atol=1e-10 * v)


@pytest.mark.parametrize("degrees", [17.0, 40.0, 56.0])
def test_it_holds_below_its_angle_and_slides_above(degrees):
    for azimuth in (0.0, 20.0, 225.0):
        tangent = np.tan(np.radians(degrees))
        vx, vy = slab(gr.ShallowWater(slope="steep"), degrees, azimuth, 1.01 * tangent, backend="numpy")
        assert not vx.any()
        assert not vy.any()
        vx, vy = slab(gr.ShallowWater(slope="steep"), degrees, azimuth, 0.99 * tangent, backend="numpy")
        assert np.hypot(vx, vy).min() > 0.005


@pytest.mark.parametrize("degrees", [30.0, 45.0, 60.0])
def test_across_the_slope_friction_acts_along_the_bed(degrees):
    """A point that is launched across a plane: an ODE of the three-dimensional velocity."""
    slope, c, nu, end = np.tan(np.radians(degrees)), np.cos(np.radians(degrees)), 0.8, 0.3

    def rate(t, v):
        size = np.sqrt(v @ v + (slope * v[0]) ** 2)
        return G * c * np.array([c * slope - nu * v[0] / size, -nu * v[1] / size])

    exact = solve_ivp(rate, (0.0, end), (0.0, 3.0), rtol=1e-10, atol=1e-12).y[:, -1]
    found = []
    for dt in (0.02, 0.01):
        velocity = slab(gr.ShallowWater(slope="steep"), degrees, 0.0, nu, (0.0, 3.0), end, step=fv.Step(dt=dt), backend="numpy")
        found.append(np.array([values.mean() for values in velocity]))
    errors = [np.abs(velocity - exact).max() for velocity in found]
    assert errors[0] > 3.5 * errors[1]
    np.testing.assert_allclose((4.0 * found[1] - found[0]) / 3.0, exact, atol=1e-4)  # of second order, and towards the exact one


@pytest.mark.parametrize("kind", MODELS)
def test_a_lake_with_islands_rests_over_steep_ground(kind, backend):
    model = kind(slope="steep")
    grid = fv.Grid((0.0, 0.0), (20.0, 16.0), (20, 16))

    def bottom(x, y):
        return 3.0 * np.sin(x) * np.cos(0.7 * y) + 0.1 * x

    b = bottom(*np.meshgrid(grid.axes[0].centers, grid.axes[1].centers))
    h = np.maximum(1.0 - b, 0.0)
    q = in_plane(model, *(model.conserved_from(h, 0.4),) * 2)
    problem = fv.Problem(model, grid, q, 2.0, aux={"b": b}, boundary=fv.Wall(),
                         sources=() if kind is gr.ShallowWater else gr.CoulombFriction(0.3))
    seen = fv.solve(problem, backend=backend).observables()
    assert max(np.abs(seen[name][seen["h"] > 1e-6]).max() for name in seen if name.startswith("speed")) < 1e-12


def test_a_level_bottom_leaves_every_bit(backend):
    for kind in MODELS:
        results = []
        for slope in ("mild", "steep"):
            model = kind(slope=slope)
            problem = fv.Problem(model, fv.Grid(0.0, 1.0, 50),
                                 lambda x, model=model: model.conserved_from(np.where(x < 0.5, 2.0, 1.0), 0.5, 1.0, 1.0), 0.05,
                                 sources=gr.CoulombFriction(0.4))
            results.append(fv.solve(problem, backend=backend).q[-1])
        np.testing.assert_array_equal(*results)


def test_an_eastern_slope_is_a_northern_one_turned(backend):
    """A heap on a curved hillside along x, and the same along y: equal to the splitting error at most, here one sweep."""
    model, runs = gr.TwoPhase(slope="steep"), []
    for turned in (False, True):
        def places(x, y, turned=turned):
            return (y, x) if turned else (x, y)

        def initial(x, y, places=places):
            u, _ = places(x, y)
            h = np.exp(-(((u - 3.0) / 1.5) ** 2)) + 0.0 * (x + y)
            return in_plane(model, *(model.conserved_from(h, 0.6),) * 2)

        problem = fv.Problem(model, fv.Grid((0.0, 0.0), (12.0, 12.0), (24, 24)), initial, 0.5,
                             aux={"b": lambda x, y, places=places: 6.0 * np.exp(-places(x, y)[0] / 4.0) + 0.0 * (x + y)},
                             sources=(gr.CoulombFriction(0.3), gr.ConstantDrag(2.0)))
        runs.append(fv.solve(problem, backend=backend, nonhyperbolic="ignore").observables())
    for name in ("h", "phi", "speed_s"):
        np.testing.assert_allclose(runs[0][name], runs[1][name].T, rtol=1e-11, atol=1e-11)


def test_slopes_of_a_plane_a_cliff_and_a_crest():
    grid = fv.Grid((0.0, 0.0), (6.0, 4.0), (6, 4))
    x, y = np.meshgrid(grid.axes[0].centers, grid.axes[1].centers)
    along_x, along_y = Slopes(0.3 * x - 0.7 * y, grid).at(0.0)
    np.testing.assert_allclose(along_x, 0.3, atol=1e-14)
    np.testing.assert_allclose(along_y, -0.7, atol=1e-14)
    cliff, _ = Slopes(np.where(x < 3.0, 0.0, 20.0), grid).at(0.0)
    assert not cliff.any()
    crest, _ = Slopes(-np.abs(x - 3.5), grid).at(0.0)
    assert crest[0].tolist() == [1.0, 1.0, 1.0, 0.0, -1.0, -1.0]


def test_a_word_that_is_neither():
    with pytest.raises(ValueError, match="`slope` must be one of mild, steep"):
        gr.TwoPhase(slope="step")


def test_what_does_not_see_the_slopes_is_refused():
    model = gr.ShallowWater(slope="steep")
    options = {"model": model, "grid": fv.Grid(0.0, 10.0, 20), "initial": lambda x: model.conserved_from(1.0 + 0.0 * x), "t_end": 0.1,
               "aux": {"b": lambda x: -0.5 * x}}
    with pytest.raises(ValueError, match="MethodOfLines has the equations for mild slopes only"):
        fv.solve(fv.Problem(**options), fv.MethodOfLines(fv.HLL()))
    with pytest.raises(ValueError, match="`background` needs slope"):
        fv.solve(fv.Problem(**options, background=options["initial"]))
    with pytest.raises(ValueError, match="rates of sources on the map"):
        fv.rhs(fv.Problem(**options, sources=gr.Manning(0.03)))
    assert np.isfinite(fv.rhs(fv.Problem(**options))(0.0, fv.Problem(**options).q0)).all()


class RoundValley:
    """A round valley, radius 60 m, with straight flanks of 40 degrees: a point that slides across it, and a thin layer."""

    radius, angle = 60.0, np.radians(40.0)
    start = -radius * np.sin(angle)

    def bottom(self, x):
        inside = np.minimum(np.abs(x), -self.start)
        return self.radius - np.sqrt(self.radius**2 - inside**2) + np.maximum(np.abs(x) + self.start, 0.0) * np.tan(self.angle)

    def point(self, nu, curved):
        """Run-out and largest speed along x of a point that starts at rest at the upper end of the round part."""
        def rate(t, y):
            x, v = y
            inside = abs(x) < -self.start
            root = np.sqrt(self.radius**2 - x * x) if inside else 1.0
            s, bend = (x / root, self.radius**2 / root**3) if inside else (np.sign(x) * np.tan(self.angle), 0.0)
            c = 1.0 / np.sqrt(1.0 + s * s)
            load = G + curved * bend * v * v
            return [v, -c * c * s * load - nu * load * c * v / np.sqrt(v * v * (1.0 + s * s) + 1e-30)]

        def rests(t, y):
            return y[1] - 1e-3 if t > 1.0 else 1.0

        rests.terminal = True
        path = solve_ivp(rate, (0.0, 30.0), (self.start, 0.01), rtol=1e-9, atol=1e-10, events=rests, max_step=0.01).y
        return path[0, -1] - self.start, path[1].max()


@pytest.mark.parametrize("curved", [True, False])
def test_a_block_in_a_round_valley(curved, backend):
    valley, nu, track = RoundValley(), 0.25, []
    model, grid = gr.ShallowWater(slope="steep"), fv.Grid(-45.0, 15.0, 300)
    sources = (gr.Curvature(),) * curved + (gr.CoulombFriction(nu),)
    problem = fv.Problem(model, grid, lambda x: model.conserved_from(np.where(np.abs(x - valley.start) < 1.0, 0.01, 0.0)), 12.0,
                         aux={"b": valley.bottom}, sources=sources)
    fv.solve(problem, backend=backend, observers=lambda stepper: track.append(
        [(stepper.q[0] * grid.centers).sum() / stepper.q[0].sum(), stepper.q[1].sum() / stepper.q[0].sum()]))
    track = np.array(track)
    reach, fastest = valley.point(nu, curved)
    assert track[-1, 0] - valley.start == pytest.approx(reach, abs=0.8)  # a layer spreads; 44.2 m with curvature in friction alone
    assert track[:, 1].max() == pytest.approx(fastest, rel=0.015)
    assert valley.point(nu, True)[1] > 1.05 * valley.point(nu, False)[1]


@pytest.mark.parametrize("kind", [gr.ShallowWater, gr.TwoPhase])
def test_curvature_along_a_turned_valley(kind):
    """A cylinder along the diagonal: as along an axis, to the error of the grid."""
    model, speeds = kind(slope="steep"), []
    for turned in (False, True):
        def across(x, y, turned=turned):
            return (x + y) / np.sqrt(2.0) if turned else x

        h = 0.2
        problem = fv.Problem(model, fv.Grid((-20.0, -20.0), (20.0, 20.0), (40, 40)),
                             lambda x, y, model=model, h=h: in_plane(model, *(model.conserved_from(h + 0.0 * (x + y), 0.5),) * 2), 1.0,
                             aux={"b": lambda x, y, across=across: 0.02 * across(x, y) ** 2}, boundary=gr.UniformSlope(),
                             sources=(gr.Curvature(), gr.CoulombFriction(0.1)))
        seen = fv.solve(problem, backend="numpy", nonhyperbolic="ignore").observables()
        speed = seen["speed" if "speed" in seen else "speed_s"]
        u = across(*np.meshgrid(*(axis.centers for axis in problem.grid.axes)))
        x, y = np.meshgrid(*(axis.centers for axis in problem.grid.axes))
        middle = (np.abs(x) < 10.0) & (np.abs(y) < 10.0)
        speeds.append(np.interp(7.0, *zip(*sorted(zip(u[middle], speed[middle], strict=True)), strict=True)))
    assert speeds[1] == pytest.approx(speeds[0], rel=0.01)


def test_curvature_needs_steep_ground():
    with pytest.raises(ValueError, match="Curvature needs the equations for steep ground"):
        fv.Problem(gr.ShallowWater(), fv.Grid(0.0, 1.0, 5), lambda x: [1.0 + x, 0.0 * x], 0.1, sources=gr.Curvature())


def test_second_derivatives_of_a_paraboloid():
    grid = fv.Grid((0.0, 0.0), (10.0, 8.0), (20, 16))
    x, y = np.meshgrid(grid.axes[0].centers, grid.axes[1].centers)
    rows = Slopes(0.5 * x * x + 0.3 * x * y - 0.2 * y * y, grid, True).at(0.0)
    inner = (slice(3, -3), slice(3, -3))
    for row, value in zip(rows[2:], (1.0, 0.3, -0.4), strict=True):
        np.testing.assert_allclose(row[inner], value, atol=1e-12)


#: Cliffs of 100 m: how far a place is beyond each.
CLIFFS = {"tower": lambda x, y: np.minimum(20.0 - np.abs(x - 100.0), 20.0 - np.abs(y - 100.0)),
          "round": lambda x, y: 30.0 - np.hypot(x - 100.0, y - 100.0),
          "wall": lambda x, y: 2.6 - np.abs(x - 102.0), "askew": lambda x, y: 0.9 * (x - 90.0) + 0.3 * (y - 80.0),
          "diagonal": lambda x, y: x - y, "at the edge": lambda x, y: 5.0 - x}


@pytest.mark.parametrize("cliff", CLIFFS)
def test_a_cliff_does_not_bend_the_ground_beside_it(cliff):
    grid = fv.Grid((0.0, 0.0), (200.0, 150.0), (40, 30))
    x, y = np.meshgrid(*(axis.centers for axis in grid.axes))
    rows = Slopes(-0.3 * x + 0.1 * y + 100.0 * (CLIFFS[cliff](x, y) > 0.0), grid, True).at(0.0)
    np.testing.assert_allclose(rows[2:], 0.0, atol=1e-12)


def test_a_kink_bends_by_the_whole_of_its_turn():
    grid = fv.Grid(0.0, 100.0, 50)
    rows = Slopes(np.maximum(0.4 * (47.0 - grid.centers), -0.1 * (grid.centers - 47.0)), grid, True).at(0.0)
    assert rows[1].sum() * grid.dx == pytest.approx(0.3, rel=1e-12)
    assert (rows[1] >= -1e-12).all()


ENDS = {"outflow": fv.Outflow(), "hydrograph": (gr.Hydrograph((0.0,), (3.0,), (0.4,)), fv.Outflow()),
        "level": (fv.Wall(), gr.FixedLevel(-34.8, phi=0.3)), "given": (gr.GivenFlow(1.0, 0.4, 4.0, 4.0), fv.Outflow()),
        "fast": (gr.GivenFlow(1.0, 0.4, 2.9, 2.9), fv.Outflow()), "slope": gr.UniformSlope()}


def through_ends(model, end, backend):
    problem = fv.Problem(model, fv.Grid(0.0, 60.0, 40), lambda x: model.conserved_from(
        1.0 + 0.3 * np.exp(-((x - 30.0) / 6.0) ** 2), 0.4 + 0.1 * np.sin(x / 5.0), 2.4, 0.2), 2.0, aux={"b": lambda x: -0.6 * x},
        boundary=ENDS[end])
    return fv.solve(problem, backend=backend, nonhyperbolic="ignore")


@pytest.mark.parametrize("end", ENDS)
@pytest.mark.parametrize("kind", [gr.ShallowWater, gr.Reduced, gr.TwoPhase, gr.TwoLayer])
def test_a_plane_is_mild_ground_of_weaker_gravity_through_its_ends(kind, end):
    """Without friction. The faces of two phases with complex speeds are the same too."""
    steep, mild = (through_ends(model, end, "numpy") for model in (kind(slope="steep", dry=1e-8), kind(g=G / 1.36, dry=1e-8)))
    np.testing.assert_allclose(steep.q, mild.q, atol=1e-11)
    assert steep.stats.nonhyperbolic_faces == mild.stats.nonhyperbolic_faces
    assert (mild.stats.nonhyperbolic_faces > 0) == (len(kind.phases) > 1)


@pytest.mark.parametrize("side", ["west", "north"])
@pytest.mark.parametrize("end", ENDS)
def test_sides_of_a_plane_are_those_of_mild_ground_of_weaker_gravity(end, side, backend):
    """As the ends of a line, above: in sweeps along both axes, and in the count of faces with complex speeds."""
    low, high = ENDS[end] if isinstance(ENDS[end], tuple) else (ENDS[end],) * 2
    grid, sides = fv.Grid((0.0, 0.0), (60.0, 60.0), (20, 20)), dict.fromkeys(("west", "east", "south", "north"), fv.Wall())
    sides |= {"west": low, "east": high} if side == "west" else {"north": low, "south": high}
    runs = []
    for model in (gr.TwoPhase(slope="steep", dry=1e-8), gr.TwoPhase(g=G / 1.36, dry=1e-8)):
        def ahead(x, y):
            return x if side == "west" else 60.0 - y

        def flow(x, y, model=model):
            shift = ahead(x, y)
            h, v = 1.0 + 0.3 * np.exp(-((shift - 30.0) / 6.0) ** 2), np.array((1.0, 0.0) if side == "west" else (0.0, -1.0))
            return state(model, h, 0.4 + 0.1 * np.sin(shift / 5.0), *([2.4 * one, 0.2 * one] for one in v))

        problem = fv.Problem(model, grid, flow, 1.0, aux={"b": lambda x, y: -0.6 * ahead(x, y)}, boundary=sides)
        runs.append(fv.solve(problem, backend=backend, nonhyperbolic="ignore"))
    steep, mild = runs
    np.testing.assert_allclose(steep.q, mild.q, atol=1e-11)
    assert steep.stats.nonhyperbolic_faces == mild.stats.nonhyperbolic_faces > 0


def test_compiled_code_has_the_same_ends_on_steep_ground(backend):
    steep, mild = (through_ends(model, "fast", backend) for model in (gr.TwoPhase(slope="steep", dry=1e-8),
                                                                      gr.TwoPhase(g=G / 1.36, dry=1e-8)))
    np.testing.assert_allclose(steep.q, mild.q, atol=1e-11)
    assert steep.stats.nonhyperbolic_faces == mild.stats.nonhyperbolic_faces > 0
