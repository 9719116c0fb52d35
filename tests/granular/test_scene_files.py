"""Scene files: what they say becomes a scene to the bit, and mistakes have file, key and nearest match."""

import re
from pathlib import Path

import attrs
import numpy as np
import pytest

import fvkit as fv
import fvkit_granular as gr
from fvkit.cli import MISTAKE, SUCCESS, main
from fvkit_granular.csv_table import UNITS
from fvkit_granular.scenes.library.catalogue import scene_factory
from fvkit_granular.scenes.shapes import SHAPES, Hump, PiecewiseLinear, Step, Sum, Uniform
from fvkit_granular.scenes.toml.read import BOUNDARIES, COLUMN, FLOW, SOURCES, TOP, find_scene
from tests.pages import code_blocks

PAGE = Path(__file__).parents[2] / "docs" / "scene_files.md"
COMPLETE = """name = "release"
description = "made up"
interval = [0.0, 100]
t_end = 2
g = 9.8
gamma = 0.4

[initial]
h = [{shape = "hump", centre = 20, half_width = 10, height = 3}, 0.1]
phi = {shape = "step", at = 50, left = 0.6, right = 0.3}
vs = {file = "state.csv", column = "v", interpolation = "constant"}

[bottom]
file = "state.csv"
interpolation = "linear"

[boundary]
left = "wall"
right = {type = "inflow", h = 0.2, phi = 0.5, vs = -1}

[[sources]]
type = "coulomb"
nu = 0.3

[[sources]]
type = "velocity-drag"
d0 = 1
d1 = 2.5

[outputs]
times = [0.5, 2]
"""

STATE = "x [m], b [m], v [m/s]\n0, 30, 0.1\n50, 5, 0\n100, 0, 0\n"


@pytest.fixture
def folder(tmp_path, monkeypatch):
    (tmp_path / "release.toml").write_text(COMPLETE)
    (tmp_path / "state.csv").write_text(STATE)
    monkeypatch.chdir(tmp_path)
    return tmp_path


def same_problem(one, other):
    assert (one.t_end, one.model, one.grid) == (other.t_end, other.model, other.grid)
    assert (one.boundary, one.sources) == (other.boundary, other.sources)
    np.testing.assert_array_equal(one.q0, other.q0)
    np.testing.assert_array_equal(one.aux_averages["b"], other.aux_averages["b"])


def test_a_complete_file_becomes_the_scene(folder):
    scene = gr.load_scene("release.toml")
    assert (scene.name, scene.description, scene.interval, scene.t_end, scene.g, scene.gamma) == (
        "release", "made up", (0.0, 100.0), 2.0, 9.8, 0.4)
    assert scene.initial.h == Sum([Hump(20.0, 10.0, 3.0), Uniform(0.1)])
    assert scene.initial.phi == Step(50.0, 0.6, 0.3)
    assert scene.boundary == (fv.Wall(), gr.GivenFlow(0.2, 0.5, -1.0))
    assert scene.sources == (gr.CoulombFriction(0.3), gr.VelocityDrag(1.0, 2.5))
    assert scene.times == (0.5, 2.0)
    x = np.array([0.0, 25.0, 60.0])
    np.testing.assert_allclose(scene.bottom(x), [30.0, 17.5, 4.0])
    np.testing.assert_array_equal(scene.initial(x)["vs"], [0.1, 0.1, 0.0])
    np.testing.assert_array_equal(scene.initial(x)["vf"], 0.0)


def test_the_least_file_takes_the_defaults(tmp_path):
    path = tmp_path / "least.toml"
    path.write_text("interval = [0, 1]\nt_end = 1\ninitial = {h = 1, phi = 0.5}\n")
    scene = gr.load_scene(path)
    plain = gr.Scene((0.0, 1.0), 1.0, lambda x: {"h": 1.0, "phi": 0.5})
    same_problem(scene.problem(gr.TwoPhase, 7), plain.problem(gr.TwoPhase, 7))
    assert (scene.name, scene.times, scene.reference) == ("least", None, None)


def test_a_surface_lies_over_the_bottom(tmp_path):
    path = tmp_path / "lake.toml"
    path.write_text('interval = [0, 2]\nt_end = 0.2\nboundary = {both = "wall"}\ninitial = {surface = 1, phi = 0.6}\n[bottom]\n'
                    'shape = "piecewise-linear"\npoints = [[0, 0], [1, 1.5], [2, 0]]\n')
    scene = gr.load_scene(path)
    assert scene.bottom == PiecewiseLinear([(0, 0), (1, 1.5), (2, 0)])
    problem = scene.problem(gr.ShallowWater, 20)
    seen = problem.model.observables(problem.q0, problem.aux_averages)
    assert (seen["h"] == 0.0).any()
    np.testing.assert_allclose(seen["surface"][problem.aux_averages["b"] < 0.8], 1.0, rtol=1e-15)


@pytest.mark.parametrize("bottom", ['[{file = "state.csv", interpolation = "linear"}, {shape = "step", at = 50, left = 0, right = 2}]',
                                    '[{file = "state.csv", interpolation = "linear", column = "b"}, 0, {shape = "block", centre = 75, half_width = 25.5, height = 2}]'])
def test_columns_shapes_and_numbers_add_up(bottom, folder):
    head, tail = COMPLETE.split("[bottom]")
    (folder / "release.toml").write_text(f"bottom = {bottom}\n{head}[boundary]{tail.split('[boundary]')[1]}")
    scene = gr.load_scene("release.toml")
    np.testing.assert_allclose(scene.bottom(np.array([0.0, 25.0, 60.0])), [30.0, 17.5, 6.0])
    again = folder / "again.toml"
    again.write_text(gr.scene_text(scene))
    same_problem(gr.load_scene(again).problem(gr.TwoPhase, 30), scene.problem(gr.TwoPhase, 30))


def test_outputs_by_count(folder):
    path = folder / "release.toml"
    path.write_text(COMPLETE.replace("times = [0.5, 2]", "count = 4"))
    assert gr.load_scene(path).times == (0.5, 1.0, 1.5, 2.0)


@pytest.mark.parametrize("name", gr.scene_names())
def test_every_built_in_scene_is_the_same_from_its_text_to_the_bit(name, tmp_path):
    scene, path = gr.scene(name), tmp_path / "shown.toml"
    path.write_text(gr.scene_text(scene))
    loaded = gr.load_scene(path)
    for model, cells in ((gr.TwoPhase, 60), (gr.ShallowWater, 37)):
        same_problem(loaded.problem(model, cells), scene.problem(model, cells))
    assert gr.scene_text(loaded) == path.read_text()
    assert (loaded.reference is None) == (scene.reference is None)
    assert (loaded.name, loaded.description) == (scene.name, scene.description)


def test_text_of_a_loaded_scene_loads_again_from_anywhere(folder, tmp_path_factory):
    scene = gr.load_scene("release.toml")
    path = tmp_path_factory.mktemp("elsewhere") / "again.toml"
    path.write_text(gr.scene_text(scene))
    again = gr.load_scene(path)
    same_problem(again.problem(gr.TwoPhase, 50), scene.problem(gr.TwoPhase, 50))
    assert again.times == scene.times


def test_a_built_in_scene_with_other_arguments_is_written_where_shapes_say_it(tmp_path):
    scene, path = scene_factory("perturbed-rest")(eps=0.2), tmp_path / "steeper.toml"
    path.write_text(gr.scene_text(scene))
    same_problem(gr.load_scene(path).problem(gr.TwoPhase, 80), scene.problem(gr.TwoPhase, 80))
    with pytest.raises(ValueError, match="`initial` is a function"):
        gr.scene_text(scene_factory("perturbed-moving")(eps=0.2))


@pytest.mark.parametrize("value", [0.1, 1e-300, 5e-324, 1.7976931348623157e308, -1e22, 1 / 3])
def test_numbers_survive_to_the_bit(value, tmp_path):
    scene = gr.Scene((0.0, 1.0), 1.0, gr.ShapedFlow(1.0, phi=0.5, vs=value), name='a "quoted"\nname\\ é')
    path = tmp_path / "numbers.toml"
    path.write_text(gr.scene_text(scene), encoding="utf-8")
    loaded = gr.load_scene(path)
    assert loaded.initial.vs.value == value
    assert loaded.name == scene.name


@pytest.mark.parametrize("name", ["riemann", "island-step", "block-stop"])
def test_a_shown_scene_runs_to_the_same_result_to_the_bit(name, tmp_path, capsys, monkeypatch):
    monkeypatch.chdir(tmp_path)
    assert main(["scenes", "--show", name]) == SUCCESS
    (tmp_path / "shown.toml").write_text(capsys.readouterr().out)
    printed = []
    for scene in (name, "shown.toml"):
        assert main(["run", scene, "--cells", "50", "--backend", "numpy"]) == SUCCESS
        printed.append([line for line in capsys.readouterr().out.splitlines() if "L1 error" in line or "mass drift" in line])
    first, second = (fv.load(tmp_path / f"fvkit-run-{label}-two-phase-relaxation" / "solution.npz") for label in (name, "shown"))
    np.testing.assert_array_equal(first.q, second.q)
    np.testing.assert_array_equal(first.t, second.t)
    assert printed[0] == printed[1]
    assert any("L1 error" in line for line in printed[0])


@pytest.mark.parametrize(("before", "after", "words"), [
    ("t_end = 2", "t_emd = 2", ("release.toml: unknown key `t_emd`; did you mean `t_end`?",)),
    ("t_end = 2\n", "", ("release.toml: the key `t_end` is missing",)),
    ("t_end = 2", "t_end = -2", ("release.toml, t_end: `t_end` must be", "> 0", "-2")),
    ("t_end = 2", "t_end = 1" + 400 * "0", ("release.toml, t_end: ", "too large")),
    ("interval = [0.0, 100]", "interval = [0.0, 1" + 400 * "0" + "]", ("too large",)),
    ("nu = 0.3", "nu = nan", ("release.toml, sources[0].nu: `nu` must be finite",)),
    ("nu = 0.3", "nu = 1979-05-27", ("release.toml, sources[0].nu: `nu` must be a number",)),
    ("[initial]", "[[initial]]", ("release.toml, initial: `initial` must be a table",)),
    ("t_end = 2", "t_end = true", ("release.toml, t_end: `t_end` must be a number",)),
    ("interval = [0.0, 100]", "interval = [100, 0]", ("release.toml, interval: `interval[1]` must be",)),
    ("interval = [0.0, 100]", "interval = [0, 101]", ("release.toml, bottom: state.csv: column `b` covers x from 0 to 100 m", "shorten `interval`")),
    ("gamma = 0.4", "gamma = 1.4", ("release.toml, gamma: `gamma` must be",)),
    ('name = "release"', "name = 3", ("release.toml, name: `name` must be a text",)),
    ("height = 3}", "heigth = 3}", ("release.toml, initial.h[0]: unknown key `heigth`; did you mean `height`?",)),
    (", height = 3}", "}", ("release.toml, initial.h[0]: the key `height` is missing",)),
    ('shape = "hump"', 'shape = "humpp"', ("release.toml, initial.h[0].shape: `shape` must be one of step, ", "did you mean hump?")),
    ("half_width = 10", "half_width = 0", ("release.toml, initial.h[0].half_width: `half_width` must be finite and > 0",)),
    (", 0.1]", ", [0.1]]", ("release.toml, initial.h[1]: `h` must be a number",)),
    (", 0.1]", ", -4]", ("release.toml, initial.h: `h` must be >= 0, got -4 at x = 0",)),
    ("left = 0.6", "left = 1.6", ("release.toml, initial.phi: `phi` must be >= 0 and <= 1, got 1.6 at x = 0",)),
    ("phi = {", "surface = 1\nphi = {", ("release.toml, initial.h: a flow of shapes takes either `h`",)),
    ("h = [{", "hh = [{", ("release.toml, initial: unknown key `hh`; did you mean `h`?",)),
    ('column = "v"', 'column = "vv"', ("release.toml, initial.vs.column", "`column of state.csv` must be one of x, b, v")),
    ('column = "v"', 'column = "b"', ("release.toml, initial.vs: state.csv: column `b` must be a speed in one of m/s, km/h; got b [m]",)),
    ('file = "state.csv"\ninterp', 'file = "stat.csv"\ninterp', ("release.toml, bottom", "there is no file stat.csv")),
    ('interpolation = "linear"', "", ("release.toml, bottom: the key `interpolation` is missing",)),
    ('interpolation = "linear"', 'interpolation = "cubic"', ("release.toml, bottom.interpolation: `interpolation` must be one of linear, constant",)),
    ('left = "wall"', 'left = "walls"', ("release.toml, boundary.left: `left` must be one of outflow, wall", "did you mean wall?")),
    ('left = "wall"', 'left = "inflow"', ("release.toml, boundary.left: `left` needs a table with fields",)),
    ('left = "wall"', 'left = "periodic"', ("release.toml, boundary.left: a periodic boundary needs both sides",)),
    ('left = "wall"\n', "", ("release.toml, boundary: the key `left` is missing",)),
    ('left = "wall"', 'both = "wall"', ("release.toml, boundary: unknown key `right`; allowed: both",)),
    ("phi = 0.5, vs", "phi = 1.5, vs", ("release.toml, boundary.right.phi: `phi` must be finite and >= 0 and <= 1",)),
    ('type = "coulomb"', 'type = "columb"', ("release.toml, sources[0].type: `type` must be one of constant-drag", "did you mean coulomb?")),
    ("nu = 0.3", "mu = 0.3", ("release.toml, sources[0]: unknown key `mu`; did you mean `nu`?",)),
    ("nu = 0.3", "nu = -0.3", ("release.toml, sources[0].nu: `nu` must be finite and >= 0",)),
    ("d1 = 2.5\n", "", ("release.toml, sources[1]: the key `d1` is missing",)),
    ("times = [0.5, 2]", "times = [0.5, 3]", ("release.toml, outputs.times: `times` must be a list that ascends within (0, t_end = 2]",)),
    ("times = [0.5, 2]", "count = 0", ("release.toml, outputs.count: `count` must be >= 1",)),
    ("times = [0.5, 2]", "count = 1_000_000_000", ("release.toml, outputs.count: `count` must be <= 100000",)),
    ("times = [0.5, 2]", "times = [0.5, 2]\ncount = 3", ("release.toml, outputs: [outputs] takes either",)),
    ('description = "made up"', 'reference = "riemann"', ("release.toml, reference: `reference` is the solution of riemann", "another flow", "gamma")),
    ('description = "made up"', 'reference = "pitman-le"', ("release.toml, reference: the built-in scene pitman-le has no reference",)),
    ("h = [{", 'flow = "riemann"\nh = [{', ("release.toml, initial: unknown key `h`; allowed: flow",)),
    ("nu = 0.3", "nu = exec('x')", ("release.toml, line 23, column", "not TOML")),
])
def test_a_mistake_has_its_file_and_key(before, after, words, folder):
    assert COMPLETE.count(before) == 1
    (folder / "release.toml").write_text(COMPLETE.replace(before, after))
    with pytest.raises(ValueError, match=r"^release.toml[,:] ") as refusal:
        gr.load_scene("release.toml")
    for word in words:
        assert word in str(refusal.value)


def test_a_reference_holds_for_the_same_flow_up_to_the_same_time(tmp_path):
    path = tmp_path / "mine.toml"
    text = gr.scene_text(gr.scene("riemann"))
    path.write_text(text.replace("t_end = 0.5", "t_end = 0.25"))
    assert gr.load_scene(path).known_reference().kind == "semi-exact"
    path.write_text(text.replace("t_end = 0.5", "t_end = 5.0"))
    with pytest.raises(ValueError, match="another flow: t_end differs"):
        gr.load_scene(path)
    path.write_text(text.replace("left = 3.0", "left = 3.1"))
    with pytest.raises(ValueError, match="another flow: initial differs"):
        gr.load_scene(path)


@pytest.mark.parametrize(("scene", "words"), [
    (gr.Scene((0.0, 1.0), 1.0, lambda x: {"h": 1.0, "phi": 0.5}), "`initial` is a function"),
    (gr.Scene((0.0, 1.0), 1.0, lambda x: {"h": 1.0, "phi": 0.5}, name="riemann"), "`initial` is a function"),
    (attrs.evolve(gr.scene("rest"), bottom=0.5, reference=None), "`surface` of the initial state lies over another bottom"),
    (gr.Scene((0.0, 1.0), 1.0, gr.ShapedFlow(1.0, phi=0.5), bottom=np.abs), "`bottom` is a function"),
    (gr.Scene((0.0, 1.0), 1.0, gr.ShapedFlow(1.0, phi=0.5), bottom=np.ones(3)), "cell averages"),
    (gr.Scene((0.0, 1.0), 1.0, gr.ShapedFlow(1.0, phi=0.5), boundary=fv.Inflow([1.0, 0.0, 1.0, 0.0])), "Inflow has no name in scene files"),
    (attrs.evolve(gr.scene("riemann"), gamma=0.3), "`reference` is the solution of riemann.*gamma differs"),
    (attrs.evolve(gr.scene("riemann"), name="mine"), "`reference` can be written for built-in scenes alone"),
])
def test_what_no_file_can_say_is_refused(scene, words):
    with pytest.raises(ValueError, match=words):
        gr.scene_text(scene)


def below(kind):
    return [kind, *(other for child in kind.__subclasses__() for other in below(child))]


def test_every_boundary_and_source_of_the_package_has_a_name():
    assert set(SOURCES.values()) == {gr.Curvature, *(
        kind for base in (gr.Drag, gr.BasalFriction) for kind in base.__subclasses__()
        if kind.__module__.startswith("fvkit_granular."))}
    assert set(BOUNDARIES.values()) == {fv.Outflow, fv.Wall, fv.Periodic, *(
        kind for kind in below(fv.BoundaryCondition) if kind.__module__.startswith("fvkit_granular."))}


def test_find_scene_tells_names_from_files(folder):
    assert find_scene("riemann").name == "riemann"
    assert find_scene("release.toml").name == "release"
    with pytest.raises(ValueError, match=r"did you mean riemann\?"):
        find_scene("rieman")
    with pytest.raises(ValueError, match=r"a file that ends in \.toml, got 'state.csv'"):
        find_scene("state.csv")
    with pytest.raises(FileNotFoundError, match=r"there is no file none\.toml"):
        find_scene("none.toml")


@pytest.mark.parametrize(("backend", "models"), [
    ("numpy", (gr.TwoPhase(), gr.Reduced(), gr.ShallowWater(), gr.PitmanLe(), gr.TwoLayer())), ("numba", (gr.TwoPhase(),))])
def test_given_flow_brings_the_same_water_in_for_every_model(backend, models):
    if backend == "numba":
        pytest.importorskip("numba", reason="the compiled backend needs the extra `fast`")
    side = gr.GivenFlow(1.0, 0.6, 2.0, 2.0)
    for model in models:
        scene = gr.Scene((0.0, 10.0), 0.5, gr.ShapedFlow(1.0, phi=0.6, vs=2.0, vf=2.0), boundary=side)
        solution = fv.solve(scene.problem(model, 20), backend=backend)
        np.testing.assert_allclose(solution.q[-1], solution.q[0], rtol=1e-12)
        onto_less = attrs.evolve(scene, initial=gr.ShapedFlow(0.5, phi=0.6), boundary=(side, fv.Wall()))
        filled = fv.solve(onto_less.problem(model, 20), backend=backend)
        assert filled.observables()["h"].mean() / 0.5 == pytest.approx(1.2, abs=5e-3), "about 2 m^2/s for half a second, onto 5 m^2"
    with pytest.raises(ValueError, match="GivenFlow needs a model with h, phi, vs, vf; Burgers"):
        fv.Problem(fv.Burgers(), fv.Grid(0.0, 1.0, 5), np.ones((1, 5)), 1.0, boundary=side)


@pytest.mark.parametrize(("arguments", "words"), [
    (("run", "release.toml", "--cells", "30"), ("release: two-phase", "written to fvkit-run-release-two-phase-relaxation/")),
    (("compare", "release.toml", "--cells", "10", "20", "--repeats", "1"), ("written to fvkit-compare-release/", "Verdict:")),
    (("advise", "release.toml"), ("release: ", "the prediction ignores inflow")),
    (("convergence", "release.toml", "--cells", "10", "20", "40"), ("scene release:",)),
])
def test_commands_take_a_file(arguments, words, folder, capsys):
    backend = () if arguments[0] == "advise" else ("--backend", "numpy")
    assert main([*arguments, *backend]) == SUCCESS
    printed = capsys.readouterr().out
    for word in words:
        assert word in printed


@pytest.mark.filterwarnings("ignore:characteristic speeds are complex")  # films of grains that outrun their water
def test_run_keeps_the_output_times_of_the_file_and_a_film_adds_its_own(folder):
    assert main(["run", "release.toml", "--cells", "20", "--backend", "numpy"]) == SUCCESS
    assert fv.load("fvkit-run-release-two-phase-relaxation/solution.npz").t.tolist() == [0.0, 0.5, 2.0]
    (folder / "release.toml").write_text(COMPLETE.replace("times = [0.5, 2]", "times = [0.51, 2]"))
    assert main(["run", "release.toml", "--cells", "20", "--backend", "numpy", "--animate", "film.gif"]) == SUCCESS
    times = fv.load("fvkit-run-release-two-phase-relaxation/solution.npz").t
    assert len(times) == 62
    assert 0.51 in times


def test_stress_takes_files_and_names_and_judges_both(folder, capsys):
    assert main(["stress", "release.toml", "--scenes", "tiny-depth", "--backends", "numpy", "--workers", "1", "--out", "s"]) == SUCCESS
    printed = capsys.readouterr().out
    assert "release.toml" in printed
    assert "tiny-depth" in printed
    (folder / "release.toml").write_text(COMPLETE.replace("nu = 0.3", "nu = -0.3"))
    assert main(["stress", "release.toml"]) == MISTAKE
    assert "release.toml, sources[0].nu: " in capsys.readouterr().err


def test_a_sweep_names_a_file_relative_to_its_own(folder, tmp_path_factory, monkeypatch, capsys):
    (folder / "sweep.toml").write_text('scene = "release.toml"\ncells = 20\nmembers = 2\nbackend = "numpy"\n[parameters]\n'
                                       '"sources.nu" = [0.2, 0.4]\n"initial.h" = [0.5, 1.0]\n')
    monkeypatch.chdir(tmp_path_factory.mktemp("elsewhere"))
    assert main(["sweep", str(folder / "sweep.toml"), "--workers", "1"]) == SUCCESS
    assert "2 of 2 members finished" in capsys.readouterr().out


@pytest.mark.filterwarnings("ignore:characteristic speeds are complex")  # films of grains that outrun their water
def test_a_run_of_a_file_that_fails_says_so(folder, capsys):
    assert main(["run", "release.toml", "--cells", "20", "--backend", "numpy"]) == SUCCESS
    (folder / "release.toml").write_text(COMPLETE.replace("gamma = 0.4", "gama = 0.4"))
    capsys.readouterr()
    assert main(["run", "release.toml"]) == MISTAKE
    captured = capsys.readouterr()
    assert captured.out == ""
    assert captured.err == ("fvkit: release.toml: unknown key `gama`; did you mean `gamma`? allowed: name, description, interval, "
                            "terrain, release, phi, t_end, g, gamma, slope, reference, initial, bottom, boundary, friction, "
                            "hydrograph, sources, outputs\n")


@pytest.fixture
def page(tmp_path, monkeypatch):
    """The files of docs/scene_files.md in a folder, and its text."""
    text = PAGE.read_text(encoding="utf-8")
    (toml, plane), (table,) = (code_blocks(PAGE, kind) for kind in ("toml", "text"))
    (tmp_path / "release.toml").write_text(toml)
    (tmp_path / "plane.toml").write_text(plane)
    (tmp_path / "torrent.csv").write_text(table)
    monkeypatch.chdir(tmp_path)
    return text


@pytest.mark.filterwarnings("ignore:characteristic speeds are complex")  # films of grains that outrun their water
def test_the_files_of_the_page_run(page):
    assert main(["run", "release.toml", "--cells", "40", "--backend", "numpy"]) == SUCCESS
    assert fv.load("fvkit-run-release-two-phase-relaxation/solution.npz").t.tolist() == [5.0 * k for k in range(9)]
    assert main(["run", "plane.toml", "--cells", "20", "--backend", "numpy"]) == SUCCESS
    assert fv.load("fvkit-run-plane-two-phase-relaxation/solution.npz").grid.shape == (10, 20)


@pytest.mark.parametrize(("file", "before", "after"), [("release.toml", "phi = {shape", "ph = {shape"), ("torrent.csv", "60\n", "6O\n")])
def test_the_mistakes_of_the_page_are_told_as_it_says(file, before, after, page, capsys):
    text = Path(file).read_text()
    assert text.count(before) == 1
    Path(file).write_text(text.replace(before, after))
    assert main(["run", "release.toml"]) == MISTAKE
    assert capsys.readouterr().err in page


def test_the_page_names_every_key_shape_boundary_and_source(page):
    for name in (*TOP, *FLOW, *COLUMN, *SHAPES, *BOUNDARIES, *SOURCES, *(unit for units in UNITS.values() for unit in units)):
        assert re.search(rf"[`\"\[]{re.escape(name)}[`\"\]]", page), name


ENDS = {
    'left = {type = "hydrograph", times = [0, 1.5], discharge = [1.0, 0.5], phi = 0.4}': gr.Hydrograph([0.0, 1.5], [1.0, 0.5], 0.4),
    'left = {type = "hydrograph", file = "flood.csv"}': gr.Hydrograph([0.0, 90.0, 180.0], [0.0, 2.0, 1.0], [0.1, 0.5, 0.3]),
    'left = {type = "hydrograph", times = [0, 9], discharge = 1, phi = 0.4, depth = [0.1, 0.2], slope = -0.1}':
        gr.Hydrograph([0.0, 9.0], 1.0, 0.4, [0.1, 0.2], slope=-0.1),
    'left = {type = "fixed-level", level = 2.5}': gr.FixedLevel(2.5),
    'left = {type = "fixed-level", level = [2.5, 3.0], times = [0, 9], slope = 0}': gr.FixedLevel([2.5, 3.0], times=[0.0, 9.0], slope=0.0),
    'left = {type = "outflow", slope = 0.1}': fv.Outflow(slope=0.1),
    'left = {type = "uniform-slope", slope = 0.1}': gr.UniformSlope(0.1),
    'left = "uniform-slope"': gr.UniformSlope(),
}


@pytest.fixture
def flood(folder):
    (folder / "flood.csv").write_text("t [min], discharge [m2/s], phi [%]\n0, 0, 10\n1.5, 2, 50\n3, 1, 30\n")
    return folder


@pytest.mark.parametrize("text", ENDS)
def test_ends_of_channels_in_files(flood, text):
    path = flood / "release.toml"
    path.write_text(COMPLETE.replace('left = "wall"', text))
    scene = gr.load_scene(path)
    assert scene.boundary[0] == ENDS[text]
    path.write_text(gr.scene_text(scene))
    assert gr.load_scene(path).boundary == scene.boundary


@pytest.mark.parametrize(("text", "words"), [
    ('{type = "hydrograph", times = [0, 1.5], discharge = [1.0], phi = 0.4, inward = 1}',
     r"boundary.left: unknown key `inward`; .*allowed: type, times, discharge, phi, depth"),
    ('{type = "hydrograph", file = "flood.csv", phi = 0.4}', r"boundary.left: unknown key `phi`; .*allowed: type, file"),
    ('{type = "hydrograph", file = "none.csv"}', "boundary.left.file: .*none.csv"),
    ('{type = "hydrograph", times = [0, 0], discharge = 1.0, phi = 0.4}', "boundary.left.times: `times` of a Hydrograph must ascend"),
    ('{type = "fixed-level"}', "boundary.left: .*`level`"), ('"fixed-level"', "boundary.left: `left` needs a table with fields"),
])
def test_mistakes_in_ends_of_channels(flood, text, words):
    path = flood / "release.toml"
    path.write_text(COMPLETE.replace('"wall"', text, 1))
    with pytest.raises(ValueError, match=words):
        gr.load_scene(path)


@pytest.mark.parametrize(("content", "words"), [
    ("t [min], discharge [m2/s], phi [-]\n0, 0, 0.1\n0, 2, 0.5\n", "line 3, column `t`: t must ascend, got 0 s after 0 s"),
    ("t [days], discharge [m2/s], phi [-]\n0, 0, 0.1\n", "column `t` must be a time in one of s, min, h"),
    ("t [s], Q [m2/s], phi [-]\n0, 0, 0.1\n", r"column of .*flood.csv` must be one of t, Q, phi; got 'discharge'"),
])
def test_mistakes_in_a_hydrograph(flood, content, words):
    (flood / "flood.csv").write_text(content)
    with pytest.raises(ValueError, match=words):
        gr.Hydrograph.read(flood / "flood.csv")

