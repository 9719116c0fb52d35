"""Exact and self-converged references in the plane: basins, dam breaks, jumps, heaps, a vortex of two phases; equal results of
backends, threads and idle blocks."""

import attrs
import numpy as np
import pytest
from numpy.testing import assert_array_equal
from scipy.optimize import brentq

import fvkit as fv
import fvkit_granular as gr
from fvkit_granular.exact.shallow_water import shallow_water_riemann
from tests.plane.problems import CLOSED, rough, square, state

pytest.importorskip("numba")
G = 9.81

#: Points along each side of a cell in averages of discontinuous data.
POINTS = 8


def centred(n, length=10.0):
    return fv.Grid((-0.5 * length, -0.5 * length), (0.5 * length, 0.5 * length), (n, n))


def averages(grid, values):
    """Cell averages of a function (x, y) that may jump, by points."""
    nodes = [np.linspace(axis.lower, axis.upper, axis.num_cells * POINTS, endpoint=False) + 0.5 * axis.dx / POINTS
             for axis in grid.axes]
    ny, nx = grid.shape
    return values(*np.meshgrid(*nodes)).reshape(ny, POINTS, nx, POINTS).mean(axis=(1, 3))


def centres(grid):
    return np.meshgrid(*(axis.centers for axis in grid.axes))


def still(h):
    return np.array([h, 0.0 * h, 0.0 * h])


def run(problem, scheme=None, **options):
    return fv.solve(problem, scheme, backend="numba", nonhyperbolic="ignore", **options)


def apart(found, exact):
    """Error in L1, relative to the exact values."""
    return np.abs(found - exact).sum() / np.abs(exact).sum()


# Basins: the paraboloid and the rotating plane of Thacker, J. Fluid Mech. 107 (1981) 499-508.


def basin(motion, n):
    """A basin for one period, after which the flow is where it began."""
    solved = gr.exact.ThackerBowl(motion)

    def flow(x, y):
        h, v_x, v_y = solved.at(x, y, 0.0).values()
        return [h, h * v_x, h * v_y]

    return fv.Problem(gr.ShallowWater(), centred(n, 4.0), flow, solved.period, aux={"b": solved.bottom})


@pytest.mark.parametrize("motion", ["paraboloid", "rotating"])
def test_basins_return_after_a_period_and_errors_fall_with_the_cells(motion):
    """Between first and second order: shores are of first order."""
    errors = []
    for n in (100, 200):
        problem = basin(motion, n)
        solution = run(problem)
        errors.append(apart(solution.q[-1][0], problem.q0[0]))
        assert abs(solution.stats.mass_drift["h"]) < 1e-13
    assert errors[1] < errors[0] / 2.0


# A circular dam break, against a fine grid along the radius: self-converged, not exact.


@pytest.mark.parametrize(("outside", "t"), [(0.5, 0.5), (0.0, 0.2)])
def test_a_circular_dam_break_is_as_near_as_one_along_the_radius_and_round(outside, t):
    dam = gr.exact.RadialDamBreak(outside=outside)
    r, fine, _ = dam.along(t)
    _, finer, _ = attrs.evolve(dam, cells=2000).along(t)
    assert apart(r * finer.reshape(-1, 2).mean(axis=1), r * fine) < 1e-3
    errors = []
    for n in (100, 200):
        grid = centred(n)
        problem = fv.Problem(gr.ShallowWater(), grid, still(averages(grid, lambda x, y: dam.at(x, y, 0.0)["h"])), t)
        h = run(problem).q[-1][0]
        errors.append(apart(h, averages(grid, lambda x, y: dam.at(x, y, t)["h"])))
        place, coarse, _ = attrs.evolve(dam, cells=n // 4).along(t)
        assert errors[-1] < 2.0 * apart(place * coarse, place * np.interp(place, r, fine))
    assert errors[1] < 0.6 * errors[0]
    half, x = n // 2, grid.axes[0].centers[n // 2:]
    diagonal = np.interp(np.hypot(x, x[0]), np.sqrt(2.0) * x, h.diagonal()[half:])
    assert apart(diagonal, 0.5 * (h[half, half:] + h[half - 1, half:])) < 0.0028


@pytest.mark.parametrize("azimuth", np.radians([0.0, 30.0, 45.0]))
def test_stokers_dam_break_at_any_azimuth(azimuth):
    """Errors within 2.5 m, where nothing has come from the sides."""
    grid, exact = centred(200), shallow_water_riemann((2.0, 0.0), (1.0, 0.0))
    x, y = centres(grid)

    def depth(t):
        return averages(grid, lambda x, y: exact.at(np.cos(azimuth) * x + np.sin(azimuth) * y, t)["h"]) if t else averages(
            grid, lambda x, y: np.where(np.cos(azimuth) * x + np.sin(azimuth) * y < 0.0, 2.0, 1.0))

    inside = np.hypot(x, y) < 2.5
    h = run(fv.Problem(gr.ShallowWater(), grid, still(depth(0.0)), 0.5)).q[-1][0]
    assert apart(h[inside], depth(0.5)[inside]) < 0.0034


def test_an_oblique_jump_stands_at_its_angle():
    """A stream of Froude 2.74 against a wall that turns it by 8.93 degrees; angle and depth from the jump conditions."""
    froude, turn, n = 2.74, np.radians(8.93), 160

    def behind(angle):
        return 0.5 * (np.sqrt(1.0 + 8.0 * (froude * np.sin(angle))**2) - 1.0)

    angle = brentq(lambda angle: np.tan(angle - turn) * behind(angle) - np.tan(angle), turn + 0.05, 1.0)
    v = froude * np.sqrt(G)
    stream = fv.Inflow([1.0, v * np.cos(turn), -v * np.sin(turn)])
    grid = fv.Grid((0.0, 0.0), (10.0, 5.0), (n, n // 2))
    problem = fv.Problem(gr.ShallowWater(), grid, lambda x, y: [part + 0.0 * x for part in (1.0, v * np.cos(turn), -v * np.sin(turn))], 10.0,
                         boundary={"west": stream, "north": stream, "south": fv.Wall(), "east": fv.Outflow()})
    h = run(problem).q[-1][0]
    x, y = centres(grid)
    reach = ((h - 1.0) / (behind(angle) - 1.0)).sum(axis=0) * grid.axes[1].dx
    seen = (x[0] > 3.0) & (x[0] < 9.0)
    assert abs(np.degrees(np.arctan(np.polyfit(x[0][seen], reach[seen], 1)[0])) - np.degrees(angle - turn)) < 0.01
    assert abs(h[(x > 4.0) & (y > 0.5) & (y < 0.6 * np.tan(angle - turn) * x)].mean() - behind(angle)) < 1e-4


@pytest.mark.parametrize("froude", [2.0, 3.0])
def test_noise_on_a_jump_along_a_grid_line_does_not_grow(froude):
    """Nothing cures the carbuncle: at Froude 5 the noise has reached the size of the jump after as many cell times."""
    grid, noise, v = fv.Grid((0.0, 0.0), (80.0, 20.0), (80, 20)), 1e-6, froude * np.sqrt(G)
    behind = 0.5 * (np.sqrt(1.0 + 8.0 * froude**2) - 1.0)
    h = np.where(centres(grid)[0] < 40.0, 1.0, behind) * (1.0 + noise * np.random.default_rng(0).uniform(-1.0, 1.0, grid.shape))
    problem = fv.Problem(gr.ShallowWater(), grid, np.array([h, np.full(grid.shape, v), 0.0 * h]), 600.0 / (v + np.sqrt(G)),
                         boundary={"west": fv.Inflow([1.0, v, 0.0]), "east": fv.Inflow([behind, v, 0.0]),
                                   "south": fv.Periodic(), "north": fv.Periodic()})
    q = run(problem, fv.WavePropagation(gr.Relaxation())).q[-1]
    assert np.ptp(q[0], axis=0).max() < noise
    assert np.abs(q[2] / q[0]).max() < noise * np.sqrt(G)


# Heaps and columns with friction.


def test_heaps_travel_alike_at_any_azimuth():
    ways = []
    for azimuth in np.radians([0.0, 30.0, 45.0, 90.0]):
        c, s = np.cos(azimuth), np.sin(azimuth)

        def heap(x, y, c=c, s=s):
            h = np.maximum(1.0 - ((x + 3.0 * c)**2 + (y + 3.0 * s)**2) / 1.5**2, 0.0)
            return [h, 0.0 * x, 0.0 * x]

        problem = fv.Problem(gr.ShallowWater(), centred(150, 16.0), heap, 1.0, boundary=gr.UniformSlope(), sources=gr.CoulombFriction(0.4),
                             aux={"b": lambda x, y, c=c, s=s: -0.6 * (c * x + s * y)})
        h = run(problem).q[-1][0]
        way = [((h - problem.q0[0]) * place).sum() / h.sum() for place in centres(problem.grid)]
        ways.append((way[0] * c + way[1] * s, way[1] * c - way[0] * s))
    along, across = np.array(ways).T
    assert np.ptp(along) < 0.003 * along.mean()
    assert np.abs(across).max() < 0.003 * along.mean()


def test_a_column_comes_to_rest_and_stays():
    nu, n = 0.5, 100
    grid = centred(n, 8.0)
    problem = fv.Problem(gr.ShallowWater(), grid, still(averages(grid, lambda x, y: 1.0 * (np.hypot(x, y) < 1.0))), 6.0,
                         sources=gr.CoulombFriction(nu))
    solution = run(problem, times=[3.0, 6.0])
    q = solution.q[1]
    assert not q[1:].any()
    assert_array_equal(solution.q[2], q)
    for axis in (0, 1):
        assert np.abs(np.diff(q[0], axis=axis)).max() <= 1.1 * nu * grid.axes[0].dx


# A steady vortex of two phases with slip over a bottom: the pressure of each phase turns it round its centre.


def whirl(n):
    solved = gr.exact.TwoPhaseVortex()

    def values(x, y):
        h, phi, *moving = solved.at(x, y).values()
        vs_x, vs_y, vf_x, vf_y = moving
        return state(gr.TwoPhase(), h, phi, (vs_x, vf_x), (vs_y, vf_y))

    return fv.Problem(gr.TwoPhase(), centred(n, 12.0), values, 0.5, boundary=fv.Periodic(), aux={"b": solved.bottom})


@pytest.mark.parametrize("solver", [gr.Relaxation(), fv.Roe()])
def test_a_vortex_of_two_phases_with_slip_stands_to_second_order(solver):
    problems = [whirl(n) for n in (50, 100)]
    solutions = [run(problem, fv.WavePropagation(solver)) for problem in problems]
    assert not any(solution.stats.nonhyperbolic_faces for solution in solutions)
    errors = [np.abs(solution.q[-1] - problem.q0).mean() for problem, solution in zip(problems, solutions, strict=True)]
    assert np.log2(errors[0] / errors[1]) > 1.9


# The same numbers from both backends, with any number of threads, and with or without idle blocks.

PARTS = [(gr.ShallowWater(), gr.Relaxation(), 1, ()), (gr.ShallowWater(), fv.HLL(), 2, gr.Manning(0.03)),
         (gr.Reduced(), fv.Roe(), 2, gr.Voellmy(0.2, 400.0)),
         (gr.TwoPhase(), gr.Relaxation(), 2, (gr.CoulombFriction(0.4), gr.ConstantDrag(2.0)))]


@pytest.mark.parametrize(("model", "solver", "order", "sources"), PARTS)
def test_both_backends_agree_after_steps_over_a_hilly_bottom(model, solver, order, sources):
    """Sixty steps: where speeds have become complex rounding grows, by 1e5 in the next forty."""
    grid = square(13, m=11)
    x, y = centres(grid)
    h = np.maximum(1.5 - 0.3 * np.hypot(x - 5.0, y - 4.0), 0.0)
    q = state(model, h, 0.4 + 0.2 * np.sin(x + y), (0.5 * np.sin(y), 0.6 * np.sin(y)), (0.3 + 0.0 * x, 0.2 + 0.0 * x))
    problem = fv.Problem(model, grid, q, 1e9, aux={"b": 0.1 * np.sin(x) * np.cos(0.7 * y)},
                         boundary={**CLOSED, "east": fv.Along(2.0, 6.0, fv.Outflow())}, sources=sources)
    steppers = [fv.Stepper(problem, fv.WavePropagation(solver, order=order), backend=backend, nonhyperbolic="ignore")
                for backend in ("numpy", "numba")]
    for stepper in steppers:
        stepper.run(1e9, 60)
    assert np.abs(steppers[0].q - steppers[1].q).max() <= 1e-12 * np.abs(steppers[0].q).max()


def after(problem, steps, every=False, threads=1, order=2):
    stepper = fv.Stepper(problem, fv.WavePropagation(gr.Relaxation(), order=order), backend="numba", threads=threads, nonhyperbolic="ignore")
    if every:
        blocks = stepper._kernel.blocks
        blocks.every, blocks.blocks[:] = True, True
        blocks.version += 1
    stepper.run(1e9, steps)
    return stepper.q.tobytes(), stepper.t, stepper.stats().mass_drift


def test_a_state_from_elsewhere_is_not_left_out_as_idle():
    """A stepper whose blocks are known takes the state of another one, which is wet where its own was dry."""
    grid = square(130, length=100.0)
    x, y = centres(grid)

    def stepper(middle):
        q = state(gr.ShallowWater(), np.where(np.hypot(x - middle, y - middle) < 8.0, 1.0, 0.0), 1.0)
        return fv.Stepper(fv.Problem(gr.ShallowWater(dry=1e-8), grid, q, 1e9, boundary=CLOSED), backend="numba")

    here, there = stepper(20.0), stepper(80.0)
    for one in (here, there):
        one.run(1e9, 4)
    here.restore(there.snapshot())
    for one in (here, there):
        one.run(1e9, 20)
    assert_array_equal(here.q, there.q)


def test_two_threads_give_the_same_bits():
    model, grid = gr.ShallowWater(), square(350, m=300)
    q, b = rough(model, grid)
    problem = fv.Problem(model, grid, q, 1e9, aux={"b": b}, boundary=CLOSED)
    assert after(problem, 20) == after(problem, 20, threads=2)


@pytest.mark.parametrize(("model", "sources", "order"), [
    (gr.ShallowWater(dry=1e-8), (), 2), (gr.ShallowWater(dry=1e-8), gr.CoulombFriction(0.4), 2), (gr.ShallowWater(dry=1e-8), gr.Manning(0.03), 1),
    (gr.TwoPhase(dry=1e-8), (gr.CoulombFriction(0.4), gr.ConstantDrag(2.0)), 2)])
@pytest.mark.parametrize("boundary", [
    CLOSED, {**CLOSED, "north": fv.Along(60.0, 66.0, gr.Hydrograph([0.0, 5.0], [0.0, 0.5], [0.4]))},
    {**CLOSED, "west": gr.FixedLevel(0.5), "south": fv.Periodic(), "north": fv.Periodic()}])
def test_idle_blocks_make_no_difference_to_a_single_bit(model, sources, order, boundary):
    grid = square(130, length=100.0, m=101)
    x, y = centres(grid)
    h = np.maximum(5.0 - 0.5 * np.hypot(x - 30.0, y - 25.0), 0.0)
    problem = fv.Problem(model, grid, state(model, h, 0.6), 1e9, aux={"b": 0.02 * x + 0.2 * np.sin(x) * np.sin(0.02 * np.pi * y)}, boundary=boundary, sources=sources)
    assert after(problem, 150, order=order) == after(problem, 150, every=True, order=order)
