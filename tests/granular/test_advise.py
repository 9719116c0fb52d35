"""Advice: the numbers of a scene, what they predict against what runs give, and what is recommended."""

import time

import attrs
import numpy as np
import pytest

import fvkit as fv
import fvkit_granular as gr
from fvkit.cli import main
from fvkit_granular.cli.advise import model_errors
from fvkit_granular.studies.advise import decide
from fvkit_granular.studies.grid_error_estimate import resolution
from fvkit_granular.studies.model_error_indicators import indicators, lasting, sampled, spreading
from tests.cases import solve
from tests.tools import advice_validation
from tests.tools.advice_validation import KINDS, MEANT, Measured, decisions, quality, random_scene, report, validate


def scene(**changes):
    given = {"interval": (0.0, 10.0), "t_end": 0.4, "initial": lambda x: {"h": 1.0 + 0.1 * np.exp(-((x - 5.0) ** 2)), "phi": 0.5}}
    return gr.Scene(**(given | changes))


@pytest.mark.parametrize(("drag", "spread", "reduced"), [(0.0, 0.831, 1.1e-2), (1.0, 0.660, 9.0e-3), (10.0, 0.287, 3.9e-3),
                                                         (100.0, 0.094, 1.3e-3), (1e3, 0.030, 4.1e-4)])
def test_numbers_of_the_dam_break_with_drag(drag, spread, reduced):
    found = indicators(attrs.evolve(gr.scene("dam-break-phi"), sources=gr.ConstantDrag(drag)))
    assert found.damping == pytest.approx(0.5 * drag * (0.55 + 0.45 * 0.5) / (0.55 * 0.45))
    assert found.spread == pytest.approx(spread, rel=0.02)
    assert found.reduced == pytest.approx(reduced, rel=0.05)
    assert found.shallow == pytest.approx(1.9e-2, rel=0.02)


def test_limits_of_spread_and_of_slip():
    assert spreading(0.0, 0.7) == 0.7
    assert spreading(1e-4, 0.7) == pytest.approx(spreading(2e-3, 0.7), rel=1e-3)
    assert spreading(1e6, 0.7) == pytest.approx(np.sqrt(2.0 * 0.7 / 1e6), rel=1e-5)
    assert (lasting(0.0, 0.7), lasting(1e6, 0.7)) == pytest.approx((0.7, 1e-6))


def test_uniform_phi_without_slip_needs_no_phases_and_a_lasting_slip_harms_the_reduced_model_more():
    assert (indicators(scene()).reduced, indicators(scene()).shallow) == (0.0, 0.0)

    def slipping(x):
        return {"h": 1.0, "phi": 0.5, "vs": 0.0, "vf": 0.05 * np.exp(-((x - 5.0) ** 2))}

    free, bound = (indicators(scene(initial=slipping, sources=gr.ConstantDrag(drag))) for drag in (0.0, 1e3))
    assert free.reduced > 2.0 * free.shallow
    assert bound.shallow > 10.0 * bound.reduced
    errors, _ = model_errors(scene(initial=slipping), 100, "numpy")
    assert errors == pytest.approx((free.reduced, free.shallow), rel=0.5)


def test_a_periodic_scene_is_the_same_wherever_it_begins():
    def flow(shift):
        return lambda x: {"h": 1.0, "phi": 0.5 + 0.2 * np.exp(-10.0 * np.sin(0.1 * np.pi * (x - shift)) ** 2)}

    one, other = (indicators(scene(initial=flow(shift), boundary=fv.Periodic())) for shift in (5.0, 0.3))
    assert (one.reduced, one.shallow) == pytest.approx((other.reduced, other.shallow), rel=1e-6)


def test_predictions_are_near_what_runs_give():
    rows = [row for row in validate(12, seed=3, cells=100, backend="numpy") if row.kind in MEANT]
    assert [row.kind for row in rows] == list(MEANT) * 3
    for which in (0, 1):
        found = quality(rows, which)
        assert found["n"] >= 8
        assert found["spearman"] > 0.9
        assert found["within 3"] == 1.0
        assert found["within 2"] >= 0.8
    for tol in (1e-3, 3e-3, 1e-2):
        assert decisions(rows, tol)["misses"] == 0.0
    assert "in scope   shallow-water" in report(rows)


def test_random_scenes_are_the_same_for_the_same_seed():
    for kind in KINDS:
        one, same, other = (sampled(random_scene(kind, 1, index)) for index in (0, 0, 1))
        assert all(np.array_equal(one[name], same[name]) for name in one)
        assert not np.array_equal(one["h"], other["h"]) or not np.array_equal(one["phi"], other["phi"])


def test_decisions_are_counted():
    assert [decide(1e-4, 1e-3, tol) for tol in (1e-4, 1e-3, 1e-2)] == ["two-phase", "reduced", "shallow-water"]
    times = (1.0, 1.0, 1.0)
    rows = [Measured("dam", (1e-4, 1e-4), (2e-4, 3e-4), (2e-4, 3e-4), times),
            Measured("dam", (1e-4, 1e-4), (2e-4, 3e-3), (2e-4, 3e-3), times),
            Measured("dam", (1e-4, 1e-2), (2e-4, 1e-4), (2e-4, 1e-4), times),
            Measured("dam", (1e-2, 1e-2), (2e-2, 1e-2), (2e-2, 1e-2), times)]
    assert decisions(rows, 1e-3) == {"right": 0.5, "misses": 0.25, "rich": 0.25}


@pytest.mark.parametrize(("name", "tol", "model", "scheme"), [
    ("riemann", 1e-3, "two-phase", "WavePropagation(Roe, MC), order 2"),
    ("stiff-drag", 1e-3, "reduced", "WavePropagation(Roe, MC), order 2"),
    ("dam-break", 1e-9, "shallow-water", "WavePropagation(Roe, MC), order 2"),
    ("simple-wave", 1e-5, "shallow-water", "MethodOfLines(Roe, MP5)"),
    ("simple-wave", 1e-3, "shallow-water", "WavePropagation(Roe, MC), order 2"),
    ("moving-slip", 1e-5, "two-phase", "MethodOfLines(Roe, MP5)"),
    ("dry-dam-break", 1e-3, "shallow-water", "WavePropagation(Relaxation, MC), order 2"),
])
def test_what_is_recommended(name, tol, model, scheme):
    advice = gr.advise(gr.scene(name), tol)
    assert (advice.scene, advice.model, advice.scheme) == (name, model, scheme)
    assert advice.grid_error <= 1.001 * tol or any("needs more than" in warning for warning in advice.warnings)
    assert scheme in str(advice)


@pytest.mark.parametrize(("name", "allowed"), [("dam-break", 2.0), ("dry-dam-break", 2.0), ("simple-wave", 2.5)])
def test_the_estimated_grid_error_is_near_the_true_one(name, allowed):
    given = gr.scene(name)
    problem = given.problem(gr.ShallowWater, 200)
    wanted = given.known_reference().averages(problem.model, problem.grid, given.t_end)
    error = np.abs(solve(problem).q[-1][0] - wanted[0]).mean() / wanted[0].mean()
    state = sampled(given)
    estimate = resolution(given, state, indicators(given, state), two_phase=False).error(200)
    assert 1.0 / allowed < estimate / error < allowed


def test_cells_give_the_tolerance():
    given = gr.scene("riemann")
    state = sampled(given)
    grid = resolution(given, state, indicators(given, state))
    for tol in (1e-3, 1e-4):
        cells = grid.cells(tol)
        assert grid.error(cells) <= tol < grid.error(cells - 20)


@pytest.mark.parametrize(("changes", "words"), [
    ({"sources": gr.CoulombFriction(0.2)}, "friction at the bed"),
    ({"sources": gr.PitmanLeDrag(1.0, 2.0)}, "variable drag"),
    ({"initial": lambda x: {"h": 1.0, "phi": 0.5, "vs": 2.0}}, "slip is close to"),
    ({"boundary": fv.Wall(), "t_end": 3.0}, "return from the walls"),
    ({"boundary": (fv.Inflow([0.5, 0.0, 0.5, 0.0]), fv.Outflow())}, "inflow"),
])
def test_it_says_where_it_may_fail(changes, words):
    assert gr.advise(scene()).warnings == ()
    (warning,) = gr.advise(scene(**changes)).warnings
    assert words in warning
    assert f"caution: {warning}" in " ".join(gr.advise(scene(**changes)).text().split())


def slope(x):
    return 0.3 * (10.0 - x)


VARYING = {"initial": lambda x: {"h": 1.0, "phi": 0.4 + 0.2 * (x < 5.0)}}


@pytest.mark.parametrize("changes", [
    {"sources": gr.CoulombFriction(0.2), "bottom": slope}, {"sources": gr.Voellmy(0.2, 500.0)}, {"sources": gr.Manning(0.03)},
    {"sources": (gr.ConstantDrag(1.0), gr.CoulombFriction(0.2)), "bottom": lambda x: 0.1 * np.sin(x)},
    {"sources": gr.PitmanLeDrag(1.0, 2.0)}, {"boundary": (fv.Inflow([0.5, 0.0, 0.5, 0.0]), fv.Outflow())},
    {"boundary": (fv.Outflow(), gr.FixedLevel(1.0))}, {"boundary": (gr.GivenFlow(h=1.0, phi=0.5, vs=0.1, vf=0.1), fv.Outflow())},
    {"boundary": fv.Wall(), "t_end": 3.0}, {"boundary": fv.Periodic(), "t_end": 9.0},
    {"initial": lambda x: {"h": 1.0, "phi": 0.5, "vs": 2.0}}, VARYING | {"bottom": slope}, VARYING | {"gamma": 0.05},
    {"initial": lambda x: {"h": 1.0, "phi": 0.4 + 0.2 * (x < 5.0), "vs": 6.0, "vf": 6.0}},
    {"initial": lambda x: {"h": 1.0 * (x < 5.0), "phi": 0.1 + 0.8 * (x < 2.0)}},
])
def test_no_error_is_predicted_where_that_was_never_validated(changes):
    advice = gr.advise(scene(**changes), 1e-2)
    assert not advice.valid
    assert advice.model == "two-phase"
    assert "predicted model error: not valid here" in advice.text()
    assert f"{advice.numbers.shallow:.1e}" not in advice.text()
    assert advice.warnings


@pytest.mark.parametrize("kind", [kind for kind in KINDS if kind != "dry"])
def test_what_was_validated_is_valid(kind):
    assert all(gr.advise(random_scene(kind, 1, index)).valid for index in range(10))


def test_uniform_scenes_without_slip_are_valid_over_any_bottom():
    assert gr.advise(scene(bottom=slope, gamma=0.05)).valid


def test_the_command_prints_no_prediction_where_none_is_valid(capsys):
    assert main(["advise", "sliding-dam-break", "--check", "--backend", "numpy"]) == 0
    out = capsys.readouterr().out
    assert "no valid prediction" in out
    assert [line.split()[1:3] for line in out.splitlines() if line.startswith(("reduced ", "shallow-water "))] == [["not", "valid"]] * 2


def test_friction_without_buoyancy_speaks_against_shallow_water():
    found = indicators(gr.scene("sliding-dam-break"))
    assert found.shallow > 1e-3
    assert found.reduced < 1e-6


def test_it_takes_little_time():
    given = gr.scene("dam-break-phi")
    spent = []
    for _ in range(5):
        start = time.perf_counter()
        gr.advise(given)
        spent.append(time.perf_counter() - start)
    assert min(spent) < 0.01


@pytest.mark.parametrize(("given", "tol", "words"), [
    (scene(initial=lambda x: {"h": 0.0, "phi": 0.5}), 1e-3, "dry everywhere"), (scene(), 0.0, "`tol` must be"), (scene(), 2.0, "< 1"),
])
def test_bad_input_is_refused(given, tol, words):
    with pytest.raises(ValueError, match=words):
        gr.advise(given, tol)


def test_the_command_advises_and_checks(capsys):
    assert main(["advise", "stiff-drag", "--check", "--backend", "numpy"]) == 0
    out = capsys.readouterr().out
    assert "stiff-drag: the reduced model suffices" in out
    assert "reduced (advised)" in out
    assert "grid error of reduced on these cells, second order: estimated" in out


def test_the_validation_prints_its_tables(capsys):
    assert advice_validation.main(["4", "--cells", "20", "--backend", "numpy"]) == 0
    assert "decisions with doubled indicators" in capsys.readouterr().out


@pytest.mark.parametrize(("arguments", "words"), [
    (["advise"], "SCENE"),
    (["advise", "riemannn"], "did you mean riemann?"), (["advise", "rest", "--tol", "-1"], "`--tol` must be"),
])
def test_mistakes_are_one_line(arguments, words, capsys):
    assert main(arguments) == 2
    error = capsys.readouterr().err
    assert words in error
    assert len(error.strip().splitlines()) == 1


@pytest.mark.parametrize("name", ["riemann", "debris-slope", "column-collapse"])
def test_printed_advice_keeps_to_100_columns(name):
    assert max(map(len, str(gr.advise(gr.scene(name))).splitlines())) <= 100
