"""In-cell shocks: internal shocks converge to the path, everything else stays as it is; what hangs on the path."""

import json

import numpy as np
import pytest

import fvkit as fv
import fvkit_granular as gr
from fvkit_granular.exact import path_sensitivity, rarefaction_fans, two_phase_riemann
from tests.cases import PSystem, name_of, rest_bottom, solve

R1 = (3.0, 0.7, -1.4, 0.3), (2.0, 0.4, -0.9, -0.1)
R2 = (3.0, 0.7, 0.0, 0.0), (2.0, 0.4, 0.0, 0.0)
R3 = (1.0, 0.7, 0.0, 0.0), (1.0, 0.3, 0.0, 0.0)
SIGNS = np.array([1.0, -1.0, 1.0, -1.0])[:, None]
BOTH = pytest.mark.parametrize("riemann", [fv.Roe(), gr.Relaxation()], ids=name_of)


def marking(riemann, **settings):
    return fv.WavePropagation(riemann, in_cell_shocks=True, **settings)


def two_sides(left, right, cells=200, half=5.0, t_end=0.5, **settings):
    """Problem with a jump at 0."""
    model = gr.TwoPhase()
    sides = [model.conserved_from(*state)[:, None] for state in (left, right)]
    return fv.Problem(model, fv.Grid(-half, half, cells), lambda x: np.where(x < 0.0, *sides), t_end, **settings)


def vector(state):
    return np.array([state.hs, state.hs * state.vs, state.hf, state.hf * state.vf])


def plateau_error(solution, exact):
    """Largest error of the median of a component of q over the middle half of the three plateaus."""
    errors, x, t = [], solution.grid.centers, solution.t[-1]
    for before, after, state in zip(exact.waves, exact.waves[1:], exact.states[1:4], strict=False):
        low, high = before.tail * t, after.head * t
        inside = np.abs(x - 0.5 * (low + high)) < 0.25 * (high - low)
        errors.append(np.abs(np.median(solution.q[-1][:, inside], axis=1) - vector(state)).max())
    return max(errors)


def after(problem, scheme, steps, backend="numpy"):
    stepper = fv.Stepper(problem, scheme, backend=backend)
    for _ in range(steps):
        stepper.step()
    return stepper


# ---------------------------------------------------------------------- what it is for

@pytest.mark.parametrize(("riemann", "bound", "without"), [(fv.Roe(), 3e-4, 3e-3), (gr.Relaxation(), 6e-4, 5e-3)], ids=name_of)
def test_plateaus_converge_with_the_option_and_not_without(riemann, bound, without):
    problem, exact = two_sides(*R2, cells=1000), two_phase_riemann(*R2)
    assert plateau_error(solve(problem, marking(riemann)), exact) <= bound
    assert plateau_error(solve(problem, fv.WavePropagation(riemann)), exact) > without


@BOTH
def test_with_slip_all_three_plateaus_converge(riemann):
    problem, exact = two_sides(*R1, cells=500), two_phase_riemann(*R1)
    assert plateau_error(solve(problem, marking(riemann)), exact) <= 4e-4
    assert plateau_error(solve(problem, fv.WavePropagation(riemann)), exact) > 2e-3


@pytest.mark.parametrize("order", [1, 2])
def test_one_internal_shock_between_two_constants_is_exact(order):
    shock = two_phase_riemann(*R2).waves[1]
    assert shock.kind == "S"
    sides = [(s.h, s.phi, s.vs, s.vf) for s in (shock.left, shock.right)]
    problem = two_sides(*sides, cells=80, half=1.0, t_end=1.0)
    solution = solve(problem, marking(fv.Roe(), order=order))
    place = shock.shock * 1.0
    share = np.clip((problem.grid.edges[1:] - place) / problem.grid.dx, 0.0, 1.0)
    wanted = vector(shock.left)[:, None] * (1.0 - share) + vector(shock.right)[:, None] * share
    assert np.abs(solution.q[-1] - wanted).max() < 1e-8
    plain = solve(problem, fv.WavePropagation(fv.Roe(), order=order))
    assert np.abs(plain.q[-1] - wanted).max() > 1e-2


def test_a_marked_shock_of_the_first_model_equation_is_exact_too():
    problem = fv.Problem(fv.Burgers(), fv.Grid(0.0, 1.0, 40), lambda x: np.where(x < 0.3, 2.0, 1.0)[None], 0.33)
    solution = solve(problem, marking(fv.HLL()))
    share = np.clip((problem.grid.edges[1:] - 0.795) / problem.grid.dx, 0.0, 1.0)
    assert np.abs(solution.q[-1][0] - (2.0 - share)).max() < 1e-12
    assert np.abs(solve(problem, fv.WavePropagation(fv.HLL())).q[-1][0] - (2.0 - share)).max() > 1e-2


# ---------------------------------------------------------------------- what it leaves alone

def smooth_problems(cells):
    fans = rarefaction_fans((3.0, 0.7, -1.0, -0.8), (0.8, 0.15, 0.15, 0.8))
    model = gr.TwoPhase()

    def flow(x):
        return model.conserved_from(*(fans.at(x, 0.25)[name] for name in ("h", "phi", "vs", "vf")))

    return (gr.scene("simple-wave").problem(gr.TwoPhase, cells),
            fv.Problem(model, fv.Grid(-10.0, 12.0, cells), flow, 1.0, t_start=0.25))


@pytest.mark.parametrize(("riemann", "backend", "cells"), [
    (fv.Roe(), "numpy", 50), (fv.Roe(), "numpy", 200), (gr.Relaxation(), "numpy", 50), (gr.Relaxation(), "numpy", 200),
    (fv.Roe(), "numba", 800)], ids=name_of)
def test_smooth_waves_are_the_same_to_the_last_bit(riemann, backend, cells):
    if backend == "numba":
        pytest.importorskip("numba")
    for problem in smooth_problems(cells):
        ends = [fv.solve(problem, scheme, backend=backend).q[-1] for scheme in (marking(riemann), fv.WavePropagation(riemann))]
        assert np.array_equal(*ends)


@BOTH
def test_rest_over_hump_and_step_stays(riemann):
    model = gr.TwoPhase()
    problem = fv.Problem(model, fv.Grid(0.0, 2.0, 200), lambda x: model.conserved_from(1.0 - rest_bottom(x), 0.6), 0.5,
                         aux={"b": rest_bottom})
    ends = [solve(problem, scheme).q for scheme in (marking(riemann), fv.WavePropagation(riemann))]
    assert np.array_equal(*ends)
    assert np.abs(ends[0][-1] - ends[0][0]).max() < 1e-13


@pytest.mark.parametrize("name", ["pile", "submerged-pile", "dry-dam-break", "mixture-on-dry"])
def test_piles_and_dry_ground_are_left_alone(name):
    problem = gr.scene(name).problem(gr.TwoPhase, 60)
    ends = [solve(problem, scheme).q[-1] for scheme in (marking(gr.Relaxation()), fv.WavePropagation(gr.Relaxation()))]
    assert np.array_equal(*ends)


def test_without_the_option_no_stage_is_there_for_it():
    problem = two_sides(*R2)
    names = [[stage.compute.__module__ for stage in scheme.stages(scheme.parts(problem.model, ()))]
             for scheme in (fv.WavePropagation(fv.Roe()), marking(fv.Roe()))]
    assert "fvkit.schemes.stages.in_cell_shocks" not in names[0]
    assert names[1].count("fvkit.schemes.stages.in_cell_shocks") == len(names[1]) - len(names[0])


# ---------------------------------------------------------------------- what it keeps

@BOTH
@pytest.mark.parametrize("order", [1, 2])
def test_masses_and_mixture_momentum_are_kept(riemann, order):
    problem = two_sides(*R1, cells=150, t_end=5.0, boundary=fv.Periodic())
    scheme = marking(riemann, order=order)
    end, plain = (after(problem, chosen, 120).q for chosen in (scheme, fv.WavePropagation(riemann, order=order)))
    assert np.abs(end - plain).max() > 1e-3
    for weights in ((1, 0, 0, 0), (0, 0, 1, 0), (0, 1, 0, problem.model.gamma)):
        totals = [float((np.array(weights) @ q).sum()) for q in (end, problem.q0)]
        assert totals[0] == pytest.approx(totals[1], abs=1e-11)


@pytest.mark.parametrize("boundary", [fv.Outflow(), fv.Wall()], ids=name_of)
@BOTH
def test_fronts_that_leave_or_meet_a_wall_lose_no_mass(riemann, boundary):
    problem = two_sides(*R2, cells=60, half=0.4, t_end=0.5, boundary=boundary)
    stats = solve(problem, marking(riemann)).stats
    assert max(map(abs, stats.mass_drift.values())) < 1e-13


@BOTH
@pytest.mark.parametrize("states", [R1, R2, R3], ids=["R1", "R2", "R3"])
def test_a_mirrored_flow_gives_the_mirrored_result(riemann, states):
    problem = two_sides(*states)
    mirrored = fv.Problem(problem.model, problem.grid, (SIGNS * problem.q0)[:, ::-1].copy(), problem.t_end)
    one, other = (solve(case, marking(riemann)).q[-1] for case in (problem, mirrored))
    assert np.abs(one - (SIGNS * other)[:, ::-1]).max() < 1e-12


@BOTH
@pytest.mark.parametrize("cells", [99, 100])
def test_shocks_that_collide_in_the_middle_stay_symmetric(riemann, cells):
    model = gr.TwoPhase()

    def flow(x):
        inner = np.abs(x) < 0.3
        return model.conserved_from(np.where(inner, 2.0, 3.0), np.where(inner, 0.4, 0.7), 0.0, 0.0)

    problem = fv.Problem(model, fv.Grid(-1.0, 1.0, cells), flow, 0.4)
    q = solve(problem, marking(riemann)).q[-1]
    assert np.abs(q - (SIGNS * q)[:, ::-1]).max() < 1e-11
    assert np.abs(q - solve(problem, fv.WavePropagation(riemann)).q[-1]).max() > 1e-3


def test_both_backends_agree_while_shocks_are_marked():
    pytest.importorskip("numba")
    problem = two_sides(*R1, cells=700)
    ends = [after(problem, marking(fv.Roe()), 200, backend).q for backend in ("numba", "numpy")]
    assert np.abs(ends[0] - ends[1]).max() < 1e-12 * np.abs(ends[1]).max()
    assert np.abs(ends[0] - after(problem, fv.WavePropagation(fv.Roe()), 200).q).max() > 1e-2


def test_the_rate_of_change_is_that_of_the_same_faces():
    problem = two_sides(*R2, cells=100)
    start = after(problem, marking(fv.Roe()), 20)
    rate = fv.rhs(problem, marking(fv.Roe()))(start.t, start.q.ravel())
    assert np.isfinite(rate).all()
    assert np.abs(rate.reshape(4, -1)[[0, 2]].sum(axis=1)).max() * problem.grid.dx < 1e-10


@pytest.mark.parametrize(("model", "riemann"), [(PSystem(), fv.HLL()), (gr.PitmanLe(), gr.Relaxation())], ids=name_of)
def test_a_model_without_decomposition_is_refused(model, riemann):
    with pytest.raises(ValueError, match=rf"in_cell_shocks=True.*{type(model).__name__}.*`decompose`.*in_cell_shocks=False"):
        marking(riemann).parts(model, ())


# ---------------------------------------------------------------------- what hangs on the path

@pytest.mark.parametrize(("states", "speeds", "percent"), [
    (R1, (-0.7658, -0.7623, -0.7938), 4.1), (R2, (-0.4524, -0.4512, -0.4800), 6.35), (R3, (-0.9081, -0.9073, -0.9293), 2.4)],
    ids=["R1", "R2", "R3"])
def test_path_sensitivity_is_the_spread_over_three_paths(states, speeds, percent):
    found = path_sensitivity(*states)
    shock = found["shocks"]["2"]
    assert list(shock["speeds"].values()) == pytest.approx(speeds, abs=6e-5)
    assert shock["spread"] == pytest.approx(max(speeds) - min(speeds), abs=1.2e-4)
    assert shock["percent"] == pytest.approx(percent, abs=0.06)
    assert f"2-shock at {speeds[0]:.4f} m/s" in found["text"]


def test_without_an_internal_shock_no_path_matters():
    assert path_sensitivity((2.0, 0.6, 0.0, 0.0), (1.0, 0.6, 0.0, 0.0)) is None


def test_reports_of_riemann_scenes_name_the_path_sensitivity():
    reports = {name: gr.compare(gr.scene(name), models=[gr.TwoPhase], riemann=[fv.Roe()], cells=(20,), repeats=1, backend="numpy")
               for name in ("dam-break-phi", "dam-break")}
    documents = {name: json.loads(report.to_json()) for name, report in reports.items()}
    assert documents["dam-break-phi"]["path_sensitivity"]["shocks"]["2"]["percent"] == pytest.approx(6.35, abs=0.06)
    assert documents["dam-break"]["path_sensitivity"] is None
    assert "Path sensitivity: internal 2-shock" in reports["dam-break-phi"].table()
    assert "Path sensitivity" not in reports["dam-break"].table()
