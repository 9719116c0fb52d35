"""Scenes with two axes: problems that they make, levels, slopes, shapes, files, and what they refuse."""

import warnings

import numpy as np
import pytest

import fvkit as fv
import fvkit_granular as gr
from fvkit.problem.directions import in_plane
from fvkit_granular import shapes
from fvkit_granular.models.slope import steepest
from tests.cases import solve

#: Corners that are neither square nor at the origin.
CORNERS = ((0.0, -1.0), (6.0, 2.0))


def streaming(x, y):
    return {"h": 1.0 + 0.1 * x, "phi": 0.5 + 0.02 * y, "vs_x": 0.3, "vs_y": 0.1 * x, "vf_y": -0.2}


def scene(initial=streaming, interval=CORNERS, **options):
    return gr.Scene(interval, 0.1, initial, **options)


def test_cells_are_square_or_as_given():
    assert scene().grid(12).shape == (6, 12)
    assert scene().grid((5, 7)).shape == scene().grid([5, 7]).shape == (7, 5)
    assert scene(interval=((0.0, 0.0), (100.0, 1.0))).grid(10).shape == (1, 10)
    assert scene().axes == ("x", "y")
    assert gr.Scene((0.0, 1.0), 1.0, lambda x: {"h": x, "phi": 0.5}).axes == ("x",)


@pytest.mark.parametrize("kind", [gr.TwoPhase, gr.Reduced, gr.ShallowWater, gr.TwoLayer])
def test_every_model_gets_its_own_state_with_momenta_along_both_axes(kind):
    problem = scene(g=5.0).problem(kind, 6)
    x, y = np.meshgrid(*(axis.centers for axis in problem.grid.axes))
    model, (h, phi) = problem.model, (1.0 + 0.1 * x, 0.5 + 0.02 * y)
    middle = in_plane(model, model.conserved_from(h, phi, 0.3, 0.0), model.conserved_from(h, phi, 0.1 * x, -0.2))
    assert model.g == 5.0
    np.testing.assert_allclose(problem.q0, middle, rtol=0.0, atol=2e-3)


def test_an_interval_of_arrays_is_that_of_pairs():
    assert scene(interval=np.array(CORNERS)).interval == CORNERS
    assert scene(interval=[[0, -1], [6, 2]]).interval == CORNERS


@pytest.mark.parametrize(("interval", "words"), [
    (((0.0, 0.0), 1.0), r"`interval` must be a pair \(lower, upper\), or corners"),
    (((0.0, 0.0, 0.0), (1.0, 1.0, 1.0)), r"corners \(\(x0, y0\), \(x1, y1\)\) for two axes, got"),
    (((0.0, 2.0), (1.0, 1.0)), r"`interval` along `y\[1\]` must be finite and > 2, got 1")])
def test_intervals_that_are_none_are_refused(interval, words):
    with pytest.raises((ValueError, TypeError), match=words):
        scene(interval=interval)


@pytest.mark.parametrize(("make", "words"), [
    (lambda: scene(lambda x: {"h": 1.0, "phi": 0.5}), "`initial` must be a function of x and y on a grid with two axes"),
    (lambda: scene(bottom=lambda x: 0.0 * x), "`bottom` must be a function of x and y on a grid with two axes"),
    (lambda: gr.Scene((0.0, 1.0), 1.0, streaming), "`initial` must be a function of x, got one that takes other arguments"),
    (lambda: scene(reference=gr.FunctionReference("exact", "", at=lambda x, t: {"h": 1.0, "phi": 0.5})),
     "`at` of the reference must be a function of x, y and t for this scene"),
    (lambda: gr.plots.slip(solve(scene().problem(gr.TwoPhase, 4))), "the slip is drawn over one axis, got a grid with two"),
    (lambda: scene(boundary=(fv.Wall(), fv.Wall())), "`boundary` must be one condition, four"),
    (lambda: scene(boundary={"left": fv.Wall()}), "write 'west'"),
    (lambda: scene(lambda x, y: {"h": 1.0, "phi": 0.5, "vs": 1.0}).problem(gr.TwoPhase, 4),
     "on a grid with two axes needs h and phi, and takes vs_x, vf_x, vs_y and vf_y"),
    (lambda: scene(lambda x, y: {"h": x[0], "phi": 0.5}).problem(gr.TwoPhase, 4), r"`h` must have shape \(10, 20\)"),
    (lambda: scene().problem(gr.PitmanLe, 4), "PitmanLe serves one axis alone"),
    (lambda: scene(bottom=np.zeros(4)).problem(gr.TwoPhase, 4), r"`aux\['b'\]` must have shape \(2, 4\), got \(4,\)"),
    (lambda: scene(bottom=lambda x, y: np.where((x > 3.0) & (y > 0.0), -9999.0, 0.0)).problem(gr.TwoPhase, 6),
     "`bottom` is -9999 at x = 3.5, y = 0.5 m, which looks like a code for a missing value")])
def test_what_does_not_fit_two_axes_is_refused(make, words):
    with pytest.raises((ValueError, TypeError), match=words):
        make()


def test_a_bottom_of_cell_averages_is_found_again():
    b = np.arange(8.0).reshape(2, 4) / 100.0
    made = scene(bottom=b)
    problem = made.problem(gr.ShallowWater, (4, 2))
    assert np.array_equal(problem.aux_averages["b"], b)
    assert np.array_equal(made.height(*np.meshgrid(*(axis.centers for axis in problem.grid.axes))), b)


def islands(x, y):
    return 1.4 * np.exp(-((x - 2.0) ** 2) - y * y) + np.where((x > 4.0) & (y > 1.0), 1.3, 0.0)


@pytest.mark.parametrize("kind", [gr.TwoPhase, gr.ShallowWater])
def test_a_lake_given_by_its_level_is_at_rest_among_islands(kind):
    lake = scene(lambda x, y: {"surface": 1.0, "phi": 0.4}, bottom=islands, boundary=fv.Wall())
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", gr.SteepSlopeWarning)
        problem = lake.problem(kind, 24)
    solution = solve(problem)
    assert 0.0 < (problem.q0[0] == 0.0).mean() < 0.5
    assert max(np.abs(values).max() for name, values in solution.observables().items() if name.startswith("speed")) < 1e-13


@pytest.mark.parametrize("azimuth", [0.0, 30.0, 45.0, 90.0])
def test_steep_ground_warns_with_its_angle_along_any_azimuth(azimuth):
    c, s = np.cos(np.radians(azimuth)), np.sin(np.radians(azimuth))

    def slope(angle):
        return scene(lambda x, y: {"h": 1.0, "phi": 0.5}, bottom=lambda x, y: -np.tan(np.radians(angle)) * (c * x + s * y), slope="mild")

    with pytest.warns(gr.SteepSlopeWarning, match="steepest slope 20 degrees"):
        slope(20.0).problem(gr.TwoPhase, 12)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        slope(14.0).problem(gr.ShallowWater, 12)


def test_dry_steep_ground_counts_where_flow_comes_in_or_rains():
    options = {"bottom": lambda x, y: 0.5 * (6.0 - x) + 0.0 * y, "initial": lambda x, y: {"h": 0.0, "phi": 0.5}, "slope": "mild"}
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        scene(**options, boundary=fv.Wall()).problem(gr.ShallowWater, 12)
    inflow = gr.Hydrograph([0.0, 1.0], [1.0, 1.0], [0.0, 0.0], [0.5, 0.5])
    with pytest.warns(gr.SteepSlopeWarning, match="26.6 degrees"):
        scene(**options, boundary={"west": fv.Along(0.0, 1.0, inflow)}).problem(gr.ShallowWater, 12)
    with pytest.warns(gr.SteepSlopeWarning, match="26.6 degrees"):
        scene(**options, boundary={"east": gr.FixedLevel(2.6)}).problem(gr.ShallowWater, 12)
    with pytest.warns(gr.SteepSlopeWarning, match="26.6 degrees"):
        scene(**options, boundary=fv.Wall(), sources=gr.Rain(1e-5)).problem(gr.ShallowWater, 12)


def test_a_cliff_on_the_plane_is_no_slope():
    b = np.where(np.arange(12) > 5, 5.0, 0.0) * np.ones((6, 1))
    assert steepest(b, (0.5, 0.5), np.full(b.shape, True)) == 0.0
    x, y = np.meshgrid(np.arange(12.0), np.arange(6.0))
    assert steepest(b + 0.3 * x + 0.4 * y, (1.0, 1.0), np.full(b.shape, True)) == pytest.approx(0.5)
    assert steepest(b + 0.3 * x + 0.4 * y, (1.0, 1.0), x < 2.0) == pytest.approx(0.4)


# Shapes and files.


def test_shapes_vary_over_x_y_or_a_distance():
    x, y = np.meshgrid([0.0, 1.0, 3.0], [0.0, 4.0])
    assert np.array_equal(shapes.Plane(2.0)(x, y), 2.0 * x)
    assert np.array_equal(shapes.Plane(2.0, over="y")(x, y), 2.0 * y)
    assert np.array_equal(shapes.Plane(1.0, over=(0.0, 0.0))(x, y), np.hypot(x, y))
    assert np.array_equal((shapes.Plane(1.0) + shapes.Plane(1.0, over="y") + 1.0)(x, y), x + y + 1.0)
    assert np.array_equal(shapes.Uniform(3.0)(x, y), np.full((2, 3), 3.0))
    assert shapes.Plane(2.0, over="x") == shapes.Plane(2.0) != shapes.Plane(2.0, over="y")


@pytest.mark.parametrize(("make", "words"), [
    (lambda: shapes.Plane(1.0, over="z"), "`over` must be one of x, y; got 'z'"),
    (lambda: shapes.Plane(1.0, over=3.0), '`over` must be "x", "y", or a point'),
    (lambda: shapes.Plane(1.0, over="y")(np.zeros(3)), "`over` = 'y' of Plane needs a scene with two axes"),
    (lambda: gr.ShapedFlow(1.0, phi=0.5, vs=1.0)(np.zeros(3), np.zeros(3)), "`vs` of a flow of shapes is for a scene with one axis"),
    (lambda: gr.ShapedFlow(1.0, phi=0.5, vf_y=1.0)(np.zeros(3)), "`vf_y` of a flow of shapes is for a scene with two axes")])
def test_shapes_refuse_the_other_number_of_axes(make, words):
    with pytest.raises((ValueError, TypeError), match=words):
        make()


def test_a_scene_of_shapes_comes_back_from_its_file_to_the_bit(tmp_path):
    flow = gr.ShapedFlow(surface=shapes.Step(3.0, 0.9, 0.6, over="y"), phi=0.5, vs_x=shapes.Block(0.0, 1.0, 0.1, over=(3.0, 1.0)), vf_y=0.2)
    gate = fv.Along(0.0, 1.0, gr.FixedLevel(0.5), fv.Along(-1.0, -0.5, fv.Outflow()))
    made = scene(flow, bottom=shapes.Gaussian(0.0, 2.0, 0.3, over=(4.0, 0.0)), boundary={"west": fv.Wall(), "east": gate},
                 sources=gr.Manning(0.03), name="gate")
    path = tmp_path / "gate.toml"
    path.write_text(gr.scene_text(made))
    read = gr.load_scene(path)
    one, other = (each.problem(gr.TwoPhase, 12) for each in (made, read))
    assert (read.interval, read.boundary, read.sources, read.name) == (made.interval, made.boundary, made.sources, "gate")
    assert np.array_equal(one.q0, other.q0)
    assert np.array_equal(one.aux_averages["b"], other.aux_averages["b"])
    assert gr.scene_text(read) == gr.scene_text(made)


FILE = """
interval = [[0.0, -1.0], [6.0, 2.0]]
t_end = 0.1
[initial]
h = {shape = "step", at = 3.0, left = 2.0, right = 1.0}
phi = 0.5
"""


@pytest.mark.parametrize(("more", "boundary"), [
    ("", (fv.Outflow(),) * 4), ('[boundary]\nall = "wall"', (fv.Wall(),) * 4),
    ('[boundary]\nnorth = "wall"', (fv.Outflow(), fv.Outflow(), fv.Outflow(), fv.Wall())),
    ('[boundary]\nwest = "periodic"\neast = "periodic"', (fv.Periodic(), fv.Periodic(), fv.Outflow(), fv.Outflow()))])
def test_sides_in_files(tmp_path, more, boundary):
    path = tmp_path / "file.toml"
    path.write_text(FILE + more)
    assert gr.load_scene(path).boundary == boundary


@pytest.mark.parametrize(("old", "new", "words"), [
    ("phi = 0.5", 'phi = 0.5\n[boundary]\nleft = "wall"', "boundary: unknown key `left`; .*allowed: west, east, south, north, all"),
    ("phi = 0.5", 'phi = 0.5\n[boundary]\nwest = "periodic"', "periodic boundary is the same on both sides, west and east"),
    ("phi = 0.5", 'phi = 0.5\n[boundary]\nwest = {type = "along", lower = 0.0, condition = "wall"}', "boundary.west: the key `upper` is missing"),
    ("phi = 0.5", "phi = 0.5\nvs = 1.0", "initial: unknown key `vs`; .*allowed: h, surface, phi, vs_x, vf_x, vs_y, vf_y, flow"),
    ("phi = 0.5", 'phi = {shape = "plane", slope = 1.0, over = "y"}', r"initial.phi: `phi` must be >= 0 and <= 1, got -1 at x = 0, y = -1"),
    ("at = 3.0", 'at = 3.0, over = "r"', "initial.h.over: `over` must be one of x, y"),
    ("[6.0, 2.0]]", "[6.0]]", r"interval: `interval` must be a pair \(lower, upper\), or corners"),
    ('h = {shape = "step", at = 3.0, left = 2.0, right = 1.0}\nphi = 0.5', 'flow = "riemann"', "the built-in scene riemann has the axes x, and")])
def test_mistakes_in_files_are_told_with_their_place(tmp_path, old, new, words):
    path = tmp_path / "file.toml"
    path.write_text(FILE.replace(old, new))
    with pytest.raises(ValueError, match=words):
        gr.load_scene(path).problem(gr.TwoPhase, 4)
