"""High order for the granular models: order, rest, conservation, drag, dry ground, both backends."""

from functools import cache
from itertools import pairwise

import attrs
import numpy as np
import pytest

import fvkit as fv
import fvkit_granular as gr
from fvkit.backends.compiled.numba_kernel import available
from fvkit.pointwise.polynomial import polynomial
from fvkit.schemes.stages.cell_polynomial import romberg
from fvkit_granular.exact import hump, rarefaction_fans, simple_wave, two_phase_riemann
from fvkit_granular.models import reduced, shallow_water, two_masses
from tests.cases import (
    GRANULAR,
    SOLVERS,
    averages,
    l1,
    name_of,
    orders,
    pseudo_spectral,
    rest_bottom,
    slip_over_bottom,
    slip_over_bottom_conserved,
    solve,
    spectral_averages,
    two_phase_forces,
)
from tests.tools.random_draws import draw

EVERY = (*GRANULAR, gr.PitmanLe(), gr.TwoLayer())
RECONSTRUCTIONS = (fv.MP5(), fv.WENO5(), fv.MUSCL())
SMOOTH = fv.MethodOfLines(fv.Roe(), integrator=fv.DP5())


def class_of(value):
    return type(value).__name__


# ---------------------------------------------------------------------- order

@cache
def slip_reference():
    return pseudo_spectral(0.15)


def test_slip_over_a_bottom_is_fifth_order():
    errors = []
    for cells in (40, 80, 160):
        grid = fv.Grid(0.0, 1.0, cells)
        problem = fv.Problem(gr.TwoPhase(), grid, slip_over_bottom_conserved, 0.15, {"b": lambda x: slip_over_bottom(x)[4]},
                             fv.Periodic())
        errors.append(l1(grid, solve(problem, SMOOTH).q[-1] - spectral_averages(slip_reference(), grid)))
    np.testing.assert_allclose(errors, [2.0e-5, 6.8e-7, 2.2e-8], rtol=0.15)
    assert orders(errors).min() >= 4.8


@pytest.mark.parametrize(("integrator", "wanted"), [(fv.DP5(), [5.9e-5, 2.3e-6, 7.6e-8, 2.4e-9]),
                                                     (fv.SSPRK104(), [1.3e-4, 6.9e-6, 3.7e-7, 2.2e-8])], ids=class_of)
def test_the_simple_wave_has_its_known_errors(integrator, wanted):
    model, wave, errors = gr.TwoPhase(), simple_wave(hump(centre=4.0)), []

    def state(x, t):
        seen = wave.at(x, t)
        return model.conserved_from(seen["h"], 0.6, seen["v"], seen["v"])

    for cells in (100, 200, 400, 800):
        grid = fv.Grid(0.0, 10.0, cells)
        seen = fv.solve(fv.Problem(model, grid, lambda x: state(x, 0.0), 0.6),
                        fv.MethodOfLines(fv.Roe(), integrator=integrator)).observables()
        errors.append(l1(grid, seen["h"] - averages(lambda x: wave.at(x, 0.6)["h"], grid)))
        assert np.abs(seen["phi"] - 0.6).max() <= 2e-15
    np.testing.assert_allclose(errors, wanted, rtol=0.1)
    if isinstance(integrator, fv.DP5):
        assert orders(errors)[-1] >= 4.8


@pytest.mark.parametrize(("left", "right", "error", "excess"), [
    ((3.0, 0.7, -1.4, 0.3), (2.0, 0.4, -0.9, -0.1), 0.13, 0.03), ((3.0, 0.7, 0.0, 0.0), (2.0, 0.4, 0.0, 0.0), 0.16, 0.07)])
def test_riemann_problems_are_sharp_and_nearly_monotone(left, right, error, excess):
    model, grid, solved = gr.TwoPhase(), fv.Grid(-5.0, 5.0, 400), two_phase_riemann(left, right)

    def state(x, t):
        seen = solved.at(x, t)
        return model.conserved_from(*(seen[name] for name in ("h", "phi", "vs", "vf")))

    def start(x):
        return model.conserved_from(*(np.where(x < 0.0, a, b) for a, b in zip(left, right, strict=True)))

    q = solve(fv.Problem(model, grid, start, 0.5), fv.MethodOfLines(fv.Roe())).q[-1]
    exact = averages(lambda x: state(x, 0.5), grid)
    assert l1(grid, q - exact) <= error
    variation, wanted = (np.abs(np.diff(item, axis=1)).sum() for item in (q, exact))
    assert variation / wanted - 1.0 <= excess


def test_fans_in_all_four_fields_have_their_known_error():
    model, grid, fans = gr.TwoPhase(), fv.Grid(-8.0, 8.0, 200), rarefaction_fans((3.0, 0.7, -1.0, -0.8), (0.8, 0.15, 0.15, 0.8))

    def state(x, t):
        seen = fans.at(x, t)
        return model.conserved_from(*(seen[name] for name in ("h", "phi", "vs", "vf")))

    q = solve(fv.Problem(model, grid, lambda x: state(x, 0.25), 1.0, t_start=0.25), fv.MethodOfLines(fv.Roe())).q[-1]
    assert l1(grid, q - averages(lambda x: state(x, 1.0), grid)) == pytest.approx(0.09, rel=0.05)


@pytest.mark.parametrize("model", [model for model in EVERY if model.defines("cell_integral")], ids=name_of)
def test_the_closed_integral_over_a_cell_is_that_of_the_jumps_to_seventh_order(model, monkeypatch):
    for module in (shallow_water, reduced, two_masses):  # the head over a step of the bottom is of third order, beyond the path
        monkeypatch.setattr(module, "kinetic_head", lambda *face: 0.0)
    gaps = []
    for size in (0.2, 0.1):
        rng = np.random.default_rng(2)
        base = tuple(model.conserved_from(1.0 + 0.0 * np.arange(30), 0.6, 0.4, -0.3))

        def wiggle(mean, rng=rng, size=size):
            left, right, bend = rng.uniform(-1.0, 1.0, (3, 30))
            middle = size * size * bend
            return polynomial(mean, mean + size * left + middle, mean - size * left + middle, size**3 * right)

        q, aux = tuple(map(wiggle, base)), (wiggle(np.zeros(30)),)
        ends = tuple(item.left for item in q), tuple(item.right for item in q)
        closed, built = model.cell_integral(*ends, q, aux), romberg(model, *ends, q, aux)
        gaps.append(max(np.abs(one - other).max() for one, other in zip(closed, built, strict=True)))
    assert gaps[1] < 1e-6
    assert gaps[1] < 1e-13 or np.log2(gaps[0] / gaps[1]) > 6.0


# ---------------------------------------------------------------------- what is kept

@pytest.mark.parametrize("model", [*GRANULAR, gr.PitmanLe()], ids=name_of)
@pytest.mark.parametrize("reconstruction", RECONSTRUCTIONS, ids=name_of)
def test_rest_is_kept_over_any_bottom(reconstruction, model):
    bottoms = (averages(rest_bottom, fv.Grid(0.0, 2.0, 40)), 0.6 * np.random.default_rng(5).random(40))
    for b in bottoms:
        problem = fv.Problem(model, fv.Grid(0.0, 2.0, 40), model.conserved_from(1.0 - b, 0.6), 0.5, {"b": b}, fv.Wall())
        for riemann in SOLVERS:
            if all(model.defines(need) for need in riemann.needs):
                end = solve(problem, fv.MethodOfLines(riemann, reconstruction)).q[-1]
                assert np.abs(end - problem.q0).max() <= 2e-14, riemann


@pytest.mark.parametrize("model", GRANULAR, ids=name_of)
@pytest.mark.parametrize("name", ["island", "island-step"])
def test_a_lake_around_an_island_stays_at_rest(name, model):
    problem = gr.scene(name).problem(model, 100)
    solution = solve(problem, fv.MethodOfLines(fv.Roe()), times=[0.5])
    seen = solution.observables()
    assert np.abs(seen["h"] - model.observables(problem.q0)["h"]).max() <= 1e-14
    deep = seen["h"] > 1e-6
    assert max(np.abs(seen[key][deep]).max() for key in ("v", "vs", "vf") if key in seen) <= 1e-12


@pytest.mark.parametrize("riemann", [fv.Roe(), fv.HLL()], ids=name_of)
def test_rough_data_keep_masses_and_mixture_momentum(riemann):
    model, rng = gr.TwoPhase(), np.random.default_rng(4)
    q = model.conserved_from(rng.uniform(0.8, 1.2, 200), rng.uniform(0.3, 0.7, 200), *rng.uniform(0.2, 0.8, (2, 200)))
    hs, ms, hf, mf = solve(fv.Problem(model, fv.Grid(0.0, 1.0, 200), q, 0.2, boundary=fv.Periodic()),
                           fv.MethodOfLines(riemann)).q[-1].sum(axis=1)
    start = q.sum(axis=1)
    assert (hs, hf) == pytest.approx((start[0], start[2]), rel=1e-14)
    assert ms + 0.5 * mf == pytest.approx(start[1] + 0.5 * start[3], rel=1e-14)


# ---------------------------------------------------------------------- drag

@attrs.frozen
class Saturating(gr.Drag):
    """A law without a closed form."""

    d: float

    def coefficient(self, model, phi, slip):
        return self.d / (1.0 + slip)


def equal_velocities(x):
    hs, vs, hf, _, _ = slip_over_bottom(x)
    return np.array([hs, hs * vs, hf, hf * vs])


def spectral_drag(law, start, t):
    """Fourier coefficients of the smooth flow over a bottom with drag, by an implicit method."""
    def forces(dx, hs, ms, hf, mf, bx, g, gamma):
        solid, fluid = two_phase_forces(dx, hs, ms, hf, mf, bx, g, gamma)
        _, gain, _, loss = law.rate(gr.TwoPhase(g, gamma), (hs, ms, hf, mf), ())
        return solid + gain, fluid + loss

    return pseudo_spectral(t, 64, forces=forces, initial=start, method="Radau", rtol=1e-9, atol=1e-11)


@pytest.mark.parametrize(("law", "start", "wanted"), [
    (gr.ConstantDrag(1.0), slip_over_bottom_conserved, [2.0e-5, 7.0e-7]),
    (gr.ConstantDrag(100.0), slip_over_bottom_conserved, [2.5e-5, 1.3e-6]),
    (gr.ConstantDrag(1e3), equal_velocities, [1.7e-5, 6.3e-7]), (gr.ConstantDrag(1e4), equal_velocities, [1.7e-5, 6.1e-7]),
    (Saturating(100.0), slip_over_bottom_conserved, None)], ids=["1", "100", "1e3", "1e4", "own"])
def test_implicit_drag_keeps_the_order_however_stiff(law, start, wanted):
    reference, errors = spectral_drag(law, start, 0.15), []
    for cells in (40, 80):
        grid = fv.Grid(0.0, 1.0, cells)
        problem = fv.Problem(gr.TwoPhase(), grid, start, 0.15, {"b": lambda x: slip_over_bottom(x)[4]}, fv.Periodic(), law)
        errors.append(l1(grid, solve(problem, fv.MethodOfLines(fv.Roe(), integrator=fv.ARK4())).q[-1]
                         - spectral_averages(reference, grid)))
    if wanted is not None:
        np.testing.assert_allclose(errors, wanted, rtol=0.15)
    assert orders(errors)[0] > 4.0


# ---------------------------------------------------------------------- dry ground

@pytest.mark.parametrize("riemann", [fv.Roe(), fv.HLL(), gr.Relaxation()], ids=name_of)
def test_a_dam_break_on_dry_ground(riemann):
    scene = gr.scene("dry-dam-break")
    problem = scene.problem(gr.TwoPhase, 400)
    solution = solve(problem, fv.MethodOfLines(riemann), nonhyperbolic="ignore")
    exact = scene.known_reference().averages(problem.model, problem.grid, 0.5)
    assert problem.grid.dx * np.abs(solution.q[-1][[0, 2]].sum(axis=0) - exact[[0, 2]].sum(axis=0)).sum() <= 0.0142
    assert solution.q[:, [0, 2]].min() >= 0.0
    assert solution.stats.steps <= 60


@pytest.mark.parametrize("name", ["absent-solid", "pure-phases", "mixture-on-nothing", "solid-on-dry", "double-rarefaction"])
def test_hard_scenes_finish_without_negative_masses(name):
    problem = gr.scene(name).problem(gr.TwoPhase, 60)
    for riemann in (fv.Roe(), fv.HLL()):
        solution = solve(problem, fv.MethodOfLines(riemann), nonhyperbolic="ignore", limits=fv.Limits(steps=300))
        assert solution.q[:, [0, 2]].min() >= 0.0
        assert max(map(abs, solution.stats.mass_drift.values())) <= 1e-13


@pytest.mark.skipif(not available(), reason="too slow uncompiled")
@pytest.mark.parametrize("riemann", [fv.Roe(), fv.HLL(), gr.Relaxation()], ids=name_of)
def test_random_problems_near_dry_ground_neither_break_nor_collapse(riemann):
    for index in range(48):
        drawn, side, model = draw(3, index)[1], (np.arange(60) >= 30).astype(int), gr.TwoPhase()
        q = model.conserved_from(*(values[side] for values in drawn[:4]))
        problem = fv.Problem(model, fv.Grid(0.0, 1.0, 60), q, 100.0, {"b": drawn.step * side}, fv.Wall())
        stepper = fv.Stepper(problem, fv.MethodOfLines(riemann), "numba", nonhyperbolic="ignore")
        target = min(60.0 * stepper.step(), 100.0)
        if stepper.t < target:
            stepper.run(target, 300)
        assert stepper.t >= target, index
        assert stepper.q[[0, 2]].min() >= 0.0


def test_far_from_a_shore_the_order_stays():
    """A smooth wave on the right, a dry shore on the left: fifth order until the signal of the shore arrives."""
    model, ends = gr.ShallowWater(), []

    def bottom(x):
        return 2.0 * np.exp(-((x / 0.8) ** 2))

    def initial(x):
        depth = np.maximum(1.0 - bottom(x), 0.0)
        return model.conserved_from(depth + 0.1 * np.exp(-(((x - 7.0) / 0.7) ** 2)), 1.0)

    for cells in (100, 200, 400):
        problem = fv.Problem(model, fv.Grid(0.0, 10.0, cells), initial, 0.4, {"b": bottom}, (fv.Wall(), fv.Outflow()))
        ends.append(solve(problem, SMOOTH).q[-1])
        assert ends[-1][0].min() >= 0.0
    gaps = []
    for coarse, fine in pairwise(ends):
        wave = slice(int(0.35 * coarse.shape[1]), int(0.95 * coarse.shape[1]))
        gaps.append(np.abs(coarse - 0.5 * (fine[:, ::2] + fine[:, 1::2]))[:, wave].mean())
    assert orders(gaps)[0] >= 4.5


# ---------------------------------------------------------------------- both backends

def wavy(model):
    return lambda x: model.conserved_from(1.0 + 0.2 * np.sin(2.0 * np.pi * x), 0.5 + 0.2 * np.cos(2.0 * np.pi * x), 0.3, 0.1)


CASES = [
    (gr.TwoPhase(), fv.MP5(), fv.SSPRK104(), fv.Roe(), fv.Wall(), gr.ConstantDrag(5.0)),
    (gr.TwoPhase(), fv.WENO5(), fv.ARK4(), fv.HLL(), fv.Periodic(), gr.ConstantDrag(50.0)),
    (gr.Reduced(), fv.MUSCL(), fv.SSPRK3(), gr.Relaxation(), "tide", ()),
    (gr.ShallowWater(), fv.MP5(), fv.SSPRK104(), fv.Rusanov(), "tide", ()),
    (gr.PitmanLe(), fv.WENO5(), fv.SSPRK3(), fv.HLL(), fv.Periodic(), ()), (gr.TwoLayer(), fv.MP5(), fv.DP5(), fv.HLL(), fv.Periodic(), ()),
]


def agree(problem, scheme, steps=50):
    both = [fv.Stepper(problem, scheme, backend, nonhyperbolic="ignore") for backend in ("numba", "numpy")]
    for stepper in both:
        for _ in range(steps):
            stepper.step()
    one, other = both
    assert one.t == pytest.approx(other.t, rel=1e-12)
    assert np.abs(one.q - other.q).max() <= 1e-12 * np.abs(other.q).max()


@pytest.mark.skipif(not available(), reason="needs the compiled backend")
@pytest.mark.parametrize("case", CASES, ids=lambda case: "-".join(class_of(item) for item in case[:3]))
def test_both_backends_agree(case):
    model, reconstruction, integrator, riemann, boundary, sources = case
    state = wavy(model)(np.array([0.0]))[:, 0]
    if boundary == "tide":
        boundary = (fv.Inflow(lambda t: state * (1.0 + 0.05 * np.sin(40.0 * t))), fv.Outflow())
    problem = fv.Problem(model, fv.Grid(0.0, 1.0, 100), wavy(model), 100.0, {"b": lambda x: 0.1 * np.sin(2.0 * np.pi * x)},
                         boundary, sources)
    agree(problem, fv.MethodOfLines(riemann, reconstruction, integrator))


def test_implicit_drag_slows_a_uniform_flow_as_its_exact_step_does():
    model, drag, t = gr.TwoPhase(), gr.ConstantDrag(2.0), 0.2
    q = np.repeat(model.conserved_from(*np.array([[1.2], [0.4], [1.0], [-0.5]])), 16, axis=1)
    problem = fv.Problem(model, fv.Grid(0.0, 1.0, 16), q, t, boundary=fv.Periodic(), sources=drag)
    exact = np.array(drag.step(model, tuple(q), (np.zeros(16),), t))
    assert abs(exact[1, 0] - q[1, 0]) > 0.05
    found = solve(problem, fv.MethodOfLines(fv.Rusanov(), integrator=fv.ARK4())).q[-1]
    np.testing.assert_allclose(found, exact, rtol=1e-6)  # the steps are of fourth order: 1e-7


@pytest.mark.skipif(not available(), reason="needs the compiled backend")
def test_both_backends_agree_on_dry_ground():
    agree(attrs.evolve(gr.scene("dry-dam-break").problem(gr.TwoPhase, 100), t_end=100.0), fv.MethodOfLines(fv.Roe()), 10)
