"""Periodic boundaries: a slope that goes on for ever, and a cliff at the seam that nobody meant."""

import warnings

import attrs
import numpy as np
import pytest

import fvkit as fv
import fvkit_granular as gr
from fvkit.output import configuration
from fvkit.testing.common import BACKENDS


def on_slope(model, b, boundary, cells=60, t_end=2.0, h=1.0, phi=0.6):
    grid = fv.Grid(0.0, 30.0, cells)
    q = model.conserved_from(np.full(cells, h), phi)
    return fv.Problem(model, grid, q, t_end, {"b": b}, boundary)


@pytest.mark.parametrize("backend", BACKENDS)
@pytest.mark.parametrize("model", [gr.ShallowWater(), gr.TwoPhase(), gr.Reduced(), gr.PitmanLe()], ids=lambda model: type(model).__name__)
@pytest.mark.parametrize("slope", [-0.1, 0.02])
def test_uniform_flow_down_an_endless_slope_accelerates_as_a_whole(model, slope, backend):
    problem = on_slope(model, lambda x: 5.0 + slope * x, fv.Periodic(drop=-30.0 * slope))
    for scheme in (fv.WavePropagation(fv.HLL()), None, fv.MethodOfLines(fv.Rusanov())):
        if backend == "numba" and scheme is not None:
            continue
        seen = fv.solve(problem, scheme, backend=backend).observables()
        np.testing.assert_allclose(seen["h"], 1.0, rtol=1e-12)
        for name in {"v", "vs", "vf"} & seen.keys():
            np.testing.assert_allclose(seen[name], -9.81 * slope * 2.0, rtol=1e-11)


def test_a_wave_does_not_see_the_seam():
    """What starts at the seam is, shifted by half the domain, what starts in the middle."""
    def start(place):
        grid = fv.Grid(0.0, 30.0, 60)
        def depth(x):
            return np.stack([1.0 + 0.3 * np.exp(-((((x - place + 15.0) % 30.0) - 15.0) ** 2)), 0.0 * x])
        return fv.Problem(gr.ShallowWater(), grid, depth, 2.0, {"b": lambda x: -0.1 * x}, fv.Periodic(drop={"b": 3.0}))

    for scheme in (fv.WavePropagation(fv.Roe()), fv.MethodOfLines(fv.HLL())):
        middle, seam = (fv.solve(start(place), scheme, backend="numpy") for place in (15.0, 0.0))
        np.testing.assert_allclose(np.roll(seam.q[-1], 30, axis=1), middle.q[-1], rtol=1e-11, atol=1e-12)
        assert all(abs(drift) < 1e-13 for drift in seam.stats.mass_drift.values())


SLOPES = {
    "plane": (lambda x: -0.1 * x, 3.0),
    "rising plane": (lambda x: 0.02 * x, -0.6),
    "plane with a hump": (lambda x: -0.1 * x + 0.5 * np.exp(-((x - 12.0) ** 2)), 3.0),
    "plane with a higher weir": (lambda x: -0.05 * x + np.where(np.abs(x - 15.0) < 0.6, 2.0, 0.0), 1.5),
    "falling curve": (lambda x: 2.0 * np.exp(-x / 20.0), 2.0 * (1.0 - np.exp(-1.5))),
    "wavy slope": (lambda x: -0.1 * x + 0.2 * np.sin(2.0 * np.pi * x / 10.0), 3.0),
}


@pytest.mark.parametrize("cells", [10, 60, 400])
@pytest.mark.parametrize(("bottom", "fall"), SLOPES.values(), ids=SLOPES)
def test_a_slope_that_ends_at_the_seam_is_a_warning_with_its_height(bottom, fall, cells):
    model = gr.ShallowWater()
    with pytest.warns(UserWarning, match=r"`b` has a cliff of .* at the seam.*drop=\{'b': ") as caught:
        on_slope(model, bottom, fv.Periodic(), cells, h=5.0)
    caught = [one for one in caught if one.category is not gr.SteepSlopeWarning]  # the hump is steep
    assert len(caught) == 1
    height = float(str(caught[0].message).split("a cliff of ")[1].split()[0])
    assert height == pytest.approx(abs(fall), rel=0.4)
    proposed = float(str(caught[0].message).split("'b': ")[1].split("}")[0])
    assert proposed == pytest.approx(fall, rel=0.3)
    for drop in (fall, {"b": fall}, 0.0):
        on_slope(model, bottom, fv.Periodic(drop=drop), cells, h=5.0)


def test_a_wrong_drop_leaves_a_cliff():
    with pytest.warns(UserWarning, match="a cliff of 0.99"):
        on_slope(gr.ShallowWater(), lambda x: -0.1 * x, fv.Periodic(drop=2.0), 400)


@pytest.mark.parametrize("bottom", [
    lambda x: 0.0 * x, lambda x: np.cos(2.0 * np.pi * x / 30.0), lambda x: np.cos(2.0 * np.pi * (x - 3.0) / 30.0),
    lambda x: np.where(x > 15.0, 1.0, 0.0), lambda x: np.where(x < 0.5, 1.0, 0.0), lambda x: np.abs(x - 15.0),
    lambda x: np.where(np.abs(x - 20.0) < 4.0, -0.1 * x, 0.1), lambda x: np.exp(-((np.abs(x - 15.0) - 15.0) ** 2)),
])
def test_what_is_periodic_makes_no_warning(bottom):
    for cells in (12, 60, 301):
        on_slope(gr.ShallowWater(), bottom, fv.Periodic(), cells)


def test_random_ground_makes_no_warning():
    for seed in range(200):
        on_slope(gr.ShallowWater(), np.random.default_rng(seed).random(60), fv.Periodic())


def test_any_given_function_may_fall():
    @attrs.frozen
    class Drift(fv.Model):
        conserved = ("q",)
        aux = ("a", "k")

        def flux(self, q):
            return (0.0 * q[0],)

        def wave_speeds(self, q):
            return 0.0 * q[0], 0.0 * q[0]

        def jump(self, ql, qr, auxl, auxr):
            return (auxr[1] - auxl[1],)

    grid, q = fv.Grid(0.0, 1.0, 20), np.ones((1, 20))
    end = fv.Stepper(fv.Problem(Drift(), grid, q, 1.0, {"k": lambda x: 3.0 * x}, fv.Periodic(drop={"k": -3.0})), fv.WavePropagation(fv.HLL()),
                     backend="numpy")
    assert end.problem.ends[0].fall == (0.0, 3.0)
    with pytest.warns(UserWarning, match="`k` has a cliff"):
        fv.Problem(Drift(), grid, q, 1.0, {"k": lambda x: 3.0 * x}, fv.Periodic())
    with pytest.raises(ValueError, match=r"must say which aux function of Drift falls, .*it has a, k, got 1"):
        fv.Problem(Drift(), grid, q, 1.0, boundary=fv.Periodic(drop=1.0))
    with pytest.raises(ValueError, match="`drop` must be one of a, k"):
        fv.Problem(Drift(), grid, q, 1.0, boundary=fv.Periodic(drop={"b": 1.0}))
    with pytest.raises(ValueError, match="it has none"):
        fv.Problem(fv.Advection(1.0), grid, q, 1.0, boundary=fv.Periodic(drop=1.0))


def test_both_sides_fall_alike():
    with pytest.raises(ValueError, match="the same on both sides"):
        on_slope(gr.ShallowWater(), -0.1, (fv.Periodic(drop=3.0), fv.Periodic()))


@pytest.mark.parametrize("given", [np.nan, "3", {"b": np.inf}, True])
def test_a_drop_is_a_number(given):
    with pytest.raises((ValueError, TypeError), match="`drop"):
        fv.Periodic(drop=given)


def test_a_drop_is_data(tmp_path):
    for boundary in (fv.Periodic(), fv.Periodic(drop=3.0), fv.Periodic(drop={"b": 3.0})):
        hash(boundary)
        assert configuration.build(configuration.describe(boundary)) == boundary
    path = tmp_path / "slope.toml"
    path.write_text('interval = [0, 30]\nt_end = 1\ninitial = {h = 1, phi = 0.6}\nboundary = {both = {type = "periodic", drop = 3.0}}\n'
                    'bottom = {shape = "plane", slope = -0.1}\n')
    scene = gr.load_scene(path)
    path.write_text(gr.scene_text(scene))
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        problem = gr.load_scene(path).problem(gr.TwoPhase, 20)
    assert problem.boundary[0] == fv.Periodic(drop=3.0)


def test_a_scene_and_a_comparison_warn_of_the_seam_once(tmp_path):
    scene = gr.Scene((0.0, 20.0), 0.1, lambda x: {"h": 1.0 + 0.0 * x, "phi": 0.5}, bottom=lambda x: 2.0 - 0.1 * x, boundary=fv.Periodic())
    for run in (lambda: scene.problem(gr.TwoPhase, 50), lambda: scene.problem(gr.TwoPhase(), 50),
                lambda: gr.compare(scene, [gr.TwoPhase], [fv.Roe(), fv.HLL()], [10, 20], repeats=1, backend="numpy")):
        with warnings.catch_warnings(record=True) as caught:
            warnings.simplefilter("always")
            run()
        assert [(str(one.message)[:22], one.filename) for one in caught] == [("Periodic: `b` has a cl", __file__)]
