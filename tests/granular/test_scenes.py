"""Scenes: each runs, each has the reference that it promises, and physics becomes data for every model."""

import warnings

import attrs
import numpy as np
import pytest

import fvkit as fv
import fvkit_granular as gr
from fvkit_granular.scenes.reference import KINDS

MODELS = (gr.TwoPhase, gr.Reduced, gr.ShallowWater)


@pytest.mark.parametrize("name", gr.scene_names())
def test_every_scene_runs_with_every_model_and_stays_near_its_reference(name):
    scene = gr.scene(name)
    assert scene.name == name
    assert len(scene.description) > 30
    reference = scene.known_reference()
    for model in MODELS:
        problem = scene.problem(model, 50 if len(scene.axes) == 1 else 25)
        solution = fv.solve(problem, fv.WavePropagation(fv.HLL()), nonhyperbolic="ignore",
                            backend="auto" if len(scene.axes) == 1 else "numpy")
        assert solution.success
        if reference is not None and model is gr.TwoPhase:
            assert reference.kind in KINDS
            wanted = reference.averages(problem.model, problem.grid, scene.t_end)
            assert np.abs(solution.q[-1] - wanted).mean() < 0.03 * np.abs(wanted).max()


def test_a_class_gets_the_constants_of_the_scene_and_an_instance_keeps_its_own():
    scene = gr.Scene((0.0, 1.0), 0.1, lambda x: {"h": 1.0, "phi": 0.5}, g=1.0, gamma=0.25)
    resolved = scene.problem(gr.TwoPhase, 10).model
    assert resolved.dry == pytest.approx(1e-8), "of the largest initial depth"
    assert attrs.evolve(resolved, dry=None) == gr.TwoPhase(g=1.0, gamma=0.25)
    assert attrs.evolve(scene.problem(gr.ShallowWater, 10).model, dry=None) == gr.ShallowWater(g=1.0)
    assert scene.problem(gr.Reduced(g=2.0, dry=1e-3), 10).model == gr.Reduced(g=2.0, dry=1e-3)


def test_drag_is_left_out_for_one_velocity_and_refused_by_the_problem():
    scene = gr.Scene((0.0, 1.0), 0.1, lambda x: {"h": 1.0, "phi": 0.5}, sources=gr.ConstantDrag(1.0))
    assert scene.problem(gr.TwoPhase, 10).sources == (gr.ConstantDrag(1.0),)
    assert scene.problem(gr.Reduced, 10).sources == ()
    with pytest.raises(ValueError, match="ConstantDrag acts between two phases, Reduced has one velocity"):
        fv.Problem(gr.Reduced(), fv.Grid(0.0, 1.0, 10), np.ones((3, 10)), 1.0, sources=gr.ConstantDrag(1.0))


@pytest.mark.parametrize(("flow", "word"), [({"h": 1.0}, "phi"), ({"h": 1.0, "phi": 0.5, "u": 0.0}, "u")])
def test_a_flow_without_h_or_phi_or_with_another_name_is_refused(flow, word):
    with pytest.raises(ValueError, match=f"a flow needs h and phi.*{'h' if word == 'phi' else word}"):
        gr.Scene((0.0, 1.0), 0.1, lambda x: flow).problem(gr.TwoPhase, 10)


def test_unknown_scene_names_list_the_known_ones():
    with pytest.raises(ValueError, match=r"got 'rieman', did you mean riemann\? known: riemann, dam-break-phi"):
        gr.scene("rieman")


def test_a_self_converged_reference_averages_exactly_onto_any_grid():
    scene = gr.Scene((0.0, 1.0), 0.1, lambda x: {"h": 1.0 + 0.2 * np.sin(2 * np.pi * x), "phi": 0.5}, boundary=fv.Periodic())
    fine = fv.solve(scene.problem(gr.TwoPhase, 120))
    reference = gr.SelfConverged("self-converged", "", solution=fine)
    for cells in (7, 40, 120):
        averages = reference.averages(gr.TwoPhase(), fv.Grid(0.0, 1.0, cells), 0.1)
        assert averages.sum(axis=1) / cells == pytest.approx(fine.q[-1].mean(axis=1), abs=1e-13)
    assert np.abs(reference.averages(gr.TwoPhase(), fine.grid, 0.1) - fine.q[-1]).max() < 1e-13


@pytest.mark.parametrize("code", [-9999.0, -32768.0, 32767.0, 1e20])
def test_a_code_for_a_missing_height_is_refused(code):
    scene = gr.Scene((0.0, 100.0), 1.0, lambda x: {"h": 1.0, "phi": 0.5}, bottom=lambda x: np.where(np.abs(x - 30.0) < 2.0, code, 100.0 - 0.1 * x))
    with pytest.raises(ValueError, match=r"`bottom` is .* at x = 28\.5 m, which looks like a code for a missing value.*fill the gap"):
        scene.problem(gr.ShallowWater, 100)


@pytest.mark.parametrize(("g", "warned"), [(981.0, True), (0.00981, True), (9.81, False), (1.62, False), (490.0, False)])
def test_gravity_in_another_unit_is_warned_of(g, warned):
    with warnings.catch_warnings(record=True) as seen:
        warnings.simplefilter("always")
        gr.Scene((0.0, 1.0), 1.0, lambda x: {"h": 1.0 + 0.0 * x, "phi": 0.5}, g=g)
    assert [f"`g` of Scene is {g:g}" in str(one.message) for one in seen] == [True] * warned
