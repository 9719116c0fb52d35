"""Steep ground: what is a slope and what is a cliff, who says so, and the size of the error."""

import warnings

import attrs
import numpy as np
import pytest

import fvkit as fv
import fvkit_granular as gr
from fvkit.cli import main
from fvkit.problem.slopes import resolved_steps
from fvkit_granular import shapes
from fvkit_granular.models.slope import MILD, sentence, steepest


def on(bottom, interval=(0.0, 100.0), surface=None, boundary=None, h=None, **more):
    flow = {"surface": surface, "phi": 0.5} if surface is not None else {"h": (lambda x: 1.0 + 0.0 * x) if h is None else h, "phi": 0.5}
    return gr.Scene(interval, 1.0, lambda x: {k: v(x) if callable(v) else v for k, v in flow.items()} | more, bottom=bottom,
                    boundary=boundary or fv.Wall(), slope="mild")


@pytest.mark.parametrize("degrees", [1.0, 14.9, 15.1, 30.0, 54.7356, 70.0])
def test_a_plane_slope_warns_above_15_degrees_with_its_error(degrees):
    slope = np.tan(np.radians(degrees))
    assert steepest(-slope * np.arange(50), 1.0, np.full(50, True)) == pytest.approx(slope)
    assert f"{degrees:.3g} degrees" in sentence(slope)
    assert sentence(slope).endswith(f"by {float(f'{100.0 * slope**2:.2g}'):.15g} %")
    scene = on(shapes.Plane(-slope))
    if degrees > MILD:
        with pytest.warns(gr.SteepSlopeWarning, match=f"steepest slope {degrees:.3g} degrees.*too large by") as caught:
            scene.problem(gr.TwoPhase, 100)
        assert caught[0].filename == __file__
    else:
        silent(scene)


@pytest.mark.parametrize("kind", [gr.TwoPhase, gr.Reduced, gr.ShallowWater, gr.PitmanLe, gr.TwoLayer])
@pytest.mark.parametrize(("degrees", "axes", "slope", "comes"), [
    (20.0, 1, "mild", True), (20.0, 2, "mild", True), (14.0, 1, "mild", False), (20.0, 1, "steep", False), (20.0, 2, "steep", False)])
def test_a_problem_without_a_scene_warns_too(kind, degrees, axes, slope, comes):
    grid, model = (fv.Grid(0.0, 10.0, 12), fv.Grid((0.0, 0.0), (10.0, 8.0), (12, 9)))[axes - 1], kind(slope=slope)
    if kind is gr.PitmanLe and axes == 2:
        pytest.skip("PitmanLe serves one axis")
    q = model.conserved_from(np.ones(grid.shape), 0.5)
    rows = q if axes == 1 else np.concatenate([q, q[[momentum for _, momentum in model.phases]]])
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        fv.Problem(model, grid, rows, 1.0, {"b": lambda *places: -np.tan(np.radians(degrees)) * places[0]})
    assert [(issubclass(one.category, gr.SteepSlopeWarning), one.filename) for one in caught] == [(True, __file__)] * comes


def silent(scene, cells=100):
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        for model in (gr.TwoPhase, gr.ShallowWater):
            scene.problem(model, cells)


@pytest.mark.parametrize("bottom", [
    0.0, 2.0, shapes.Block(50.0, 20.0, 5.0), shapes.Step(30.0, 4.0, 0.0), shapes.Steps([20.0, 50.0, 51.0], [0.0, 3.0, 9.0, 3.0]),
    shapes.Plane(-0.1) + shapes.Block(50.0, 20.0, 5.0), shapes.Gaussian(50.0, 10.0, 1.0),
])
def test_walls_and_cliffs_are_no_slopes(bottom):
    for cells in (50, 100, 400):
        silent(on(bottom), cells)


@pytest.mark.parametrize("inside", [0.0, 0.1, 0.5, 0.9])
def test_a_cliff_inside_a_cell_is_no_slope(inside):
    dx = 0.5
    for bottom in (shapes.Step(30.0 + inside * dx, 4.0, 0.0), shapes.Block(50.0 + inside * dx, 20.0, 5.0),
                   shapes.Plane(-0.1) + shapes.Step(30.0 + inside * dx, 4.0, 0.0)):
        silent(on(bottom), round(100.0 / dx))
    ramp = shapes.PiecewiseLinear([(0.0, 4.0), (30.0 + inside * dx, 4.0), (30.0 + (3.5 + inside) * dx, 0.0), (100.0, 0.0)])
    with pytest.warns(gr.SteepSlopeWarning):
        on(ramp).problem(gr.TwoPhase, round(100.0 / dx))


def test_a_cliff_hides_no_slope():
    with pytest.warns(gr.SteepSlopeWarning, match="30 degrees"):
        on(shapes.Plane(-np.tan(np.radians(30.0))) + shapes.Block(50.0, 20.0, 5.0)).problem(gr.TwoPhase, 200)


def test_ground_counts_where_the_flow_may_come():
    steep = shapes.PiecewiseLinear([(0.0, 43.0), (50.0, 3.0), (50.01, 0.0), (100.0, 0.0)])
    silent(on(steep, surface=2.0))
    high = {"h": lambda x: np.where(x < 5.0, 1.0, 0.0)}
    with pytest.warns(gr.SteepSlopeWarning, match="38.7 degrees"):
        on(steep, **high).problem(gr.TwoPhase, 100)
    with pytest.warns(gr.SteepSlopeWarning):
        on(steep, surface=2.0, vs=-30.0, vf=-30.0).problem(gr.TwoPhase, 100)
    dry = {"h": lambda x: 0.0 * x}
    silent(on(steep, **dry))
    inflow = gr.Hydrograph(times=[0.0, 1.0], discharge=[1.0, 1.0], phi=[0.5, 0.5])
    with pytest.warns(gr.SteepSlopeWarning):
        on(steep, **dry, boundary=(inflow, fv.Outflow())).problem(gr.TwoPhase, 100)


#: Flat, then up at 35 degrees from 50 m to 60 m, then flat: dry.
BANK = shapes.PiecewiseLinear([(0.0, 0.0), (50.0, 0.0), (60.0, 7.0), (100.0, 7.0)])


@pytest.mark.parametrize(("end", "comes"), [
    (gr.GivenFlow(h=5.0, phi=0.5), True), (gr.GivenFlow(h=0.1, phi=0.5), False), (gr.GivenFlow(h=0.1, phi=0.5, vs=9.0, vf=9.0), True),
    (gr.FixedLevel(5.0), True), (gr.FixedLevel(-1.0), False), (gr.FixedLevel([0.0, 5.0, 0.0], times=[0.0, 0.1, 0.2]), True),
    (gr.FixedLevel(lambda t: 5.0 * t), True), (gr.Hydrograph([0.0, 1.0], [0.0, 30.0], [0.5]), True),
    (gr.Hydrograph([0.0, 1.0], [0.0, 0.0], [0.5]), False), (fv.Outflow(), False), (fv.Wall(), False),
    (fv.Inflow(lambda t: [5.0 * t, 0.0, 0.0, 0.0]), True),
])
@pytest.mark.parametrize("left", [True, False])
def test_ground_that_an_inflow_may_climb_counts(end, comes, left):
    ends, bottom = ((end, fv.Wall()), BANK) if left else ((fv.Wall(), end), lambda x: BANK(100.0 - x))
    if not left and isinstance(end, gr.GivenFlow):
        end = attrs.evolve(end, vs=-end.vs, vf=-end.vf)
    scene = on(bottom, h=lambda x: 0.0 * x, boundary=ends)
    found = scene.model(gr.TwoPhase(dry=1e-6))
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        scene.problem(found, 100)
    assert [issubclass(warning.category, gr.SteepSlopeWarning) for warning in caught] == [True] * comes


@pytest.mark.parametrize(("source", "comes"), [
    (gr.Rain(1e-5), True), (gr.Rain(-1e-5), False), (gr.Rain(0.0), False), (gr.Rain(lambda x: np.where(x > 80.0, 1e-5, 0.0)), True),
    (gr.Rain(lambda x: np.where(x < 20.0, 1e-5, 0.0)), False), (gr.Rain(lambda x, t: 1e-5 * (t > 0.5) + 0.0 * x), True),
    (fv.Forcing(lambda x: [1e-5 + 0.0 * x] + [0.0 * x] * 3), True), (gr.Manning(0.03), False), (gr.ConstantDrag(1.0), False),
])
def test_ground_that_a_source_wets_counts(source, comes):
    scene = attrs.evolve(on(BANK, h=lambda x: 0.0 * x), sources=source)
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        scene.problem(gr.TwoPhase, 100)
    assert [issubclass(warning.category, gr.SteepSlopeWarning) for warning in caught] == [True] * comes


def test_resolved_steps():
    np.testing.assert_array_equal(resolved_steps(np.array([0.0, 1.0, 3.0, 3.0, 2.0, 0.0, 5.0])), [1.0, 0.0, 0.0, -1.0, 0.0])
    assert resolved_steps(np.array([1.0])).size == resolved_steps(np.array([1.0, 2.0])).size == 0


def test_a_run_says_what_may_get_wet_between_and_after_its_outputs(tmp_path, capsys, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "bank.toml").write_text("""
interval = [0, 100]
t_end = 0.01
initial = {h = 0, phi = 0.5}
bottom = {shape = "piecewise-linear", points = [[0, 0], [50, 0], [60, 7], [100, 7]]}
[boundary]
left = {type = "inflow", h = 5, phi = 0.5}
right = "wall"
""")
    main(["run", "bank.toml", "--cells", "100"])
    assert "steepest slope 35 degrees: computed with the equations for steep ground" in capsys.readouterr().out
    text = (tmp_path / "bank.toml").read_text()
    (tmp_path / "bank.toml").write_text('slope = "mild"\n' + text)
    main(["run", "bank.toml", "--cells", "100"])
    assert "caution: steepest slope 35 degrees" in capsys.readouterr().out


def test_run_and_advise_say_it(tmp_path, capsys, monkeypatch):
    monkeypatch.chdir(tmp_path)
    for name, equations, slope, word in (("caution", "mild", 0.7, "caution: steepest slope 35 degrees"), ("steep", "auto", 0.7, "steepest slope 35 degrees"),
                                         ("mild", "auto", 0.1, "  steepest slope 5.71 degrees"), ("flat", "auto", 0.0, None)):
        path = tmp_path / f"{name}.toml"
        path.write_text(f'slope = "{equations}"\n' 'interval = [0, 10]\nt_end = 0.05\ninitial = {h = 1, phi = 0.5}\n'
                        f'bottom = {{shape = "plane", slope = -{slope}}}\n')
        assert main(["run", str(path), "--cells", "40"]) == 0
        ran = capsys.readouterr()
        assert main(["advise", str(path)]) == 0
        advice = capsys.readouterr().out
        for text in (ran.out, advice):
            assert ("steepest" in text) == (word is not None)
            assert word is None or word in text
        assert "steepest" not in ran.err


@pytest.mark.parametrize("kind", [gr.TwoPhase, gr.Reduced, gr.ShallowWater])
def test_a_class_gets_the_equations_that_its_ground_asks_for(kind):
    for degrees, word, expected in ((9.9, "auto", "mild"), (10.1, "auto", "steep"), (40.0, "mild", "mild"), (1.0, "steep", "steep")):
        scene = attrs.evolve(on(shapes.Plane(-np.tan(np.radians(degrees)))), slope=word)
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", gr.SteepSlopeWarning)
            assert scene.problem(kind, 100).model.slope == expected
            assert scene.problem(kind(), 100).model.slope == "mild"
            assert scene.problem(kind(slope="steep"), 100).model.slope == "steep"


def test_built_in_scenes_have_the_equations_of_their_references():
    for name in gr.scene_names():
        assert gr.scene(name).slope == "mild"
