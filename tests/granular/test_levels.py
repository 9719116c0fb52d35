"""Initial states by level: a lake is at rest on any grid, whatever shore it has, and its volume is off at shores alone."""
from functools import partial

import numpy as np
import pytest

import fvkit as fv
import fvkit_granular as gr
from fvkit.problem.cell_averages import cell_averages
from fvkit.schemes.riemann import default_riemann
from fvkit_granular import shapes
from fvkit_granular.studies.model_error_indicators import sampled

#: These tests are about the equations for mild slopes, whatever the ground.
mild_scene = partial(gr.Scene, slope="mild")

#: Bottoms whose shores lie anywhere in a cell: an island, a beach that ends in a kink, random ground, an emerged block.
BOTTOMS = {
    "island": shapes.Gaussian(50.0, 10.0, 2.0),
    "beach": shapes.PiecewiseLinear([(0.0, -1.0), (33.3, 1.7), (61.7, 0.2), (100.0, 1.31)]),
    "waves": shapes.Cosine(0.7, 0.9, 13.7, crest=3.1),
    "block": shapes.Block(47.3, 11.1, 1.9),
}


def largest_speed(problem, scheme=None, steps=60):
    """The largest speed of any phase in the first steps."""
    top, stepper = 0.0, fv.Stepper(problem, scheme, backend="numpy")
    for _ in range(steps):
        stepper.step(1.0)
        seen = problem.model.observables(stepper.q, problem.aux_averages)
        top = max(top, *(float(np.abs(seen[name]).max()) for name in ("v", "vs", "vf") if name in seen))
    return top


def scene(bottom, **flow):
    return mild_scene((0.0, 100.0), 60.0, gr.ShapedFlow(**{"surface": 1.0, "phi": 0.5} | flow), bottom=bottom, boundary=fv.Wall())


@pytest.mark.parametrize("bottom", BOTTOMS.values(), ids=BOTTOMS)
@pytest.mark.parametrize(("model", "phi"), [(gr.ShallowWater, 0.5), (gr.TwoPhase, 0.5), (gr.Reduced, 0.5), (gr.PitmanLe, 0.5),
                                            (gr.TwoPhase, 1.0), (gr.TwoPhase, 0.0), (gr.TwoLayer, 0.0)])
@pytest.mark.parametrize("cells", [37, 100])
def test_a_lake_rests(bottom, model, phi, cells):
    problem = scene(bottom, phi=phi).problem(model, cells)
    for scheme in (None, fv.WavePropagation(fv.HLL()), fv.MethodOfLines(default_riemann(problem.model))):
        assert largest_speed(problem, scheme, steps=15) < 1e-13


def test_two_lakes_of_different_level_rest_on_both_sides_of_a_dam():
    for model in (gr.ShallowWater, gr.TwoPhase):
        for cells in (41, 100, 512):
            two = scene(shapes.Gaussian(51.0, 9.0, 3.0), surface=shapes.Step(52.0, 2.0, 1.3), phi=shapes.Step(52.0, 0.6, 0.2))
            assert largest_speed(two.problem(model, cells)) < 1e-13


@pytest.mark.parametrize("given", ["function", "file", "averages", "number", "built-in"])
def test_every_way_to_give_a_level(given, tmp_path):
    bottom = BOTTOMS["island"]
    if given == "file":
        path = tmp_path / "lake.toml"
        path.write_text('interval = [0, 100]\nt_end = 60\ninitial = {surface = 1, phi = 0.5}\nboundary = {both = "wall"}\n[bottom]\n'
                        'shape = "gaussian"\ncentre = 50\nwidth = 10\nheight = 2\n')
        lake = gr.load_scene(path)
        path.write_text(gr.scene_text(lake))
        np.testing.assert_array_equal(gr.load_scene(path).problem(gr.TwoPhase, 77).q0, lake.problem(gr.TwoPhase, 77).q0)
    elif given == "built-in":
        lake = gr.scene("island")
    else:
        ground = {"averages": cell_averages(bottom, fv.Grid(0.0, 100.0, 77), None, "b"), "number": 0.3}.get(given, bottom)
        lake = mild_scene((0.0, 100.0), 60.0, lambda x: {"surface": 1.0, "phi": 0.5}, bottom=ground, boundary=fv.Wall())
    assert largest_speed(lake.problem(gr.TwoPhase, 77)) < 1e-13
    seen = sampled(lake)
    np.testing.assert_allclose(seen["h"], np.maximum(1.0 - seen["b"], 0.0), atol=1e-15)


def test_built_in_lakes_agree_with_their_reference_on_any_grid():
    for name, cells in (("rest", 77), ("island", 77), ("island", 130), ("island-step", 61)):
        lake = gr.scene(name)
        problem = lake.problem(gr.TwoPhase, cells)
        reference = lake.known_reference().averages(problem.model, problem.grid, 0.3)
        np.testing.assert_allclose(reference, problem.q0, atol=1e-15)


def test_the_volume_is_exact_but_for_shores_where_it_is_off_by_the_square_of_the_cell():
    bottom, off = BOTTOMS["island"], []
    for cells in (100, 200, 400, 800):
        problem = scene(bottom).problem(gr.ShallowWater, cells)
        exact = cell_averages(lambda x: np.maximum(1.0 - bottom(x), 0.0), problem.grid, None, "h")
        differs = np.abs(problem.q0[0] - exact)
        assert (differs > 1e-14).sum() <= 2
        off.append(float(differs.sum()) * problem.grid.dx)
    assert max(value * cells**2 for value, cells in zip(off, (100, 200, 400, 800), strict=True)) < 400.0


def test_where_it_is_wet_products_of_depth_and_phi_are_exact():
    ground, phi = shapes.Cosine(0.2, 0.2, 50.0), shapes.Cosine(0.5, 0.2, 50.0)
    problem = scene(ground, phi=phi).problem(gr.TwoPhase, 20)
    exact = cell_averages(lambda x: phi(x) * (1.0 - ground(x)), problem.grid, None, "hs")
    np.testing.assert_allclose(problem.q0[0], exact, rtol=1e-14)


def test_a_factor_on_the_depth_of_a_level():
    run = gr.SceneRun(lambda: scene(BOTTOMS["island"]), cells=50)
    problem, _ = run.setup({"initial.h": 0.5})
    np.testing.assert_allclose(problem.q0[0] + problem.q0[2], 0.5 * np.maximum(1.0 - problem.aux_averages["b"], 0.0), atol=1e-15)
    assert largest_speed(run.setup({"initial.h": 1.0, "initial.phi": 0.5})[0]) < 1e-13


@pytest.mark.parametrize(("flow", "words"), [
    ({"surface": 1.0, "h": 0.5, "phi": 0.5}, "`surface` of the initial state.*contradicts `h`"),
    ({"surface": 1.0}, "a flow needs h and phi.*surface"),
    ({"surface": np.ones(3), "phi": 0.5}, "`surface` must have shape"),
    ({"surface": np.nan, "phi": 0.5}, "`h` must be finite"),
])
def test_mistakes(flow, words):
    with pytest.raises(ValueError, match=words):
        mild_scene((0.0, 1.0), 1.0, lambda x: flow, bottom=0.2).problem(gr.TwoPhase, 10)
