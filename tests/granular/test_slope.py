"""Steep ground: what is a slope and what is a cliff, who says so, and the size of the error."""

import warnings

import numpy as np
import pytest

import fvkit as fv
import fvkit_granular as gr
from fvkit.cli import main
from fvkit.problem.slopes import resolved_steps
from fvkit_granular import shapes
from fvkit_granular.scenes.slope import MILD, sentence, steepest


def on(bottom, interval=(0.0, 100.0), surface=None, boundary=None, h=None, **more):
    flow = {"surface": surface, "phi": 0.5} if surface is not None else {"h": (lambda x: 1.0 + 0.0 * x) if h is None else h, "phi": 0.5}
    return gr.Scene(interval, 1.0, lambda x: {k: v(x) if callable(v) else v for k, v in flow.items()} | more, bottom=bottom,
                    boundary=boundary or fv.Wall())


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


def test_resolved_steps():
    np.testing.assert_array_equal(resolved_steps(np.array([0.0, 1.0, 3.0, 3.0, 2.0, 0.0, 5.0])), [1.0, 0.0, 0.0, -1.0, 0.0])
    assert resolved_steps(np.array([1.0])).size == resolved_steps(np.array([1.0, 2.0])).size == 0


def test_run_and_advise_say_it(tmp_path, capsys, monkeypatch):
    monkeypatch.chdir(tmp_path)
    for name, slope, word in (("steep", 0.7, "caution: steepest slope 35 degrees"), ("mild", 0.1, "  steepest slope 5.71 degrees"), ("flat", 0.0, None)):
        path = tmp_path / f"{name}.toml"
        path.write_text('interval = [0, 10]\nt_end = 0.05\ninitial = {h = 1, phi = 0.5}\n'
                        f'bottom = {{shape = "plane", slope = -{slope}}}\n')
        assert main(["run", str(path), "--cells", "40"]) == 0
        ran = capsys.readouterr()
        assert main(["advise", str(path)]) == 0
        advice = capsys.readouterr().out
        for text in (ran.out, advice):
            assert ("steepest" in text) == (word is not None)
            assert word is None or word in text
        assert "steepest" not in ran.err
