"""Built-in scenes with two axes and their exact solutions: the equations hold, the scenes are found, stay near references."""

import attrs
import numpy as np
import pytest

import fvkit as fv
import fvkit_granular as gr
from fvkit.cli import main
from fvkit_granular.scenes.library.plane import PLANE_SCENES
from tests.cases import solve

SOLVED = [gr.exact.ThackerBowl("rotating"), gr.exact.ThackerBowl("paraboloid"), gr.exact.Vortex(radius=0.4, centre=(0.1, -0.2), drift=(0.5, -0.3))]


@pytest.mark.parametrize("solved", SOLVED, ids=lambda solved: f"{type(solved).__name__} {getattr(solved, 'motion', '')}")
@pytest.mark.parametrize("t", [0.0, 0.37, 1.9])
def test_solutions_obey_the_equations_of_shallow_water_at_any_time(solved, t):
    """Mass and both momenta, by central differences, at points that stay wet."""
    x, y = np.random.default_rng(0).uniform(-0.15, 0.15, (2, 50))
    near = 1e-4

    def along(place, what):
        def of(x, y, t):
            seen = solved.at(x, y, t)
            return what(seen["h"], seen["v_x"], seen["v_y"])

        steps = [near if name == place else 0.0 for name in "xyt"]
        return (of(x + steps[0], y + steps[1], t + steps[2]) - of(x - steps[0], y - steps[1], t - steps[2])) / (2.0 * near)

    seen, g = solved.at(x, y, t), solved.g
    rise = [0.0, 0.0] if not hasattr(solved, "bottom") else [
        (solved.bottom(x + dx, y + dy) - solved.bottom(x - dx, y - dy)) / (2.0 * near) for dx, dy in ((near, 0.0), (0.0, near))]
    assert seen["h"].min() > 0.0
    mass = along("t", lambda h, u, v: h) + along("x", lambda h, u, v: h * u) + along("y", lambda h, u, v: h * v)
    first = along("t", lambda h, u, v: h * u) + along("x", lambda h, u, v: h * u * u + 0.5 * g * h * h) \
        + along("y", lambda h, u, v: h * u * v) + g * seen["h"] * rise[0]
    second = along("t", lambda h, u, v: h * v) + along("x", lambda h, u, v: h * u * v) \
        + along("y", lambda h, u, v: h * v * v + 0.5 * g * h * h) + g * seen["h"] * rise[1]
    assert max(np.abs(one).max() for one in (mass, first, second)) < 1e-6


def test_the_vortex_of_two_phases_is_in_balance():
    """v^2/r is the push of each phase over its mass, as the two-phase model has it, by central differences along x."""
    solved, x = gr.exact.TwoPhaseVortex(gamma=0.3), np.linspace(0.2, 2.5, 30)

    def parts(x):
        seen = solved.at(x, 0.0 * x)
        return seen["h"] * seen["phi"], seen["h"] * (1.0 - seen["phi"]), solved.bottom(x, 0.0 * x)

    def slope(what):
        return (what(*parts(x + 1e-4)) - what(*parts(x - 1e-4))) / 2e-4

    hs, seen, g, gamma = parts(x)[0], solved.at(x, 0.0 * x), solved.g, solved.gamma
    solid = (g * hs * slope(lambda hs, hf, b: hs) + 0.5 * g * (1.0 - gamma) * slope(lambda hs, hf, b: hs * hf)
             + gamma * g * hs * slope(lambda hs, hf, b: hf) + g * hs * slope(lambda hs, hf, b: b)) / hs
    fluid = g * slope(lambda hs, hf, b: hs + hf + b)
    np.testing.assert_allclose(seen["vs_y"] ** 2 / x, solid, atol=1e-6)
    np.testing.assert_allclose(seen["vf_y"] ** 2 / x, fluid, atol=1e-6)
    assert np.abs(seen["vs_y"] - seen["vf_y"]).max() > 0.05


@pytest.mark.parametrize(("make", "words"), [
    (lambda: gr.exact.Vortex(speed=3.0), r"`depth` must be > e B\^2/\(2 g\) = 1\.2"),
    (lambda: gr.exact.Vortex(centre=1.0), r"`centre` must be a pair \(x, y\), got 1.0"),
    (lambda: gr.exact.ThackerBowl("round"), "`motion` must be one of rotating, paraboloid"),
    (lambda: gr.exact.ThackerBowl(r0=1.0), "`r0` must be < `a`, got 1 and 1")])
def test_solutions_that_do_not_exist_are_refused(make, words):
    with pytest.raises((ValueError, TypeError), match=words):
        make()


def test_a_circular_dam_break_looks_alike_on_all_sides_and_starts_as_it_is_given():
    dam = gr.exact.RadialDamBreak(cells=50)
    one, other = dam.at(np.array([3.0]), np.array([0.0]), 0.2), dam.at(np.array([0.0]), np.array([-3.0]), 0.2)
    assert one["h"] == other["h"] != 2.0
    assert one["v_x"] == -other["v_y"] > 0.0 == one["v_y"] == other["v_x"]
    assert dam.at(np.zeros(1), np.zeros(1), 0.2)["v_x"] == 0.0
    assert dam.at(np.array([2.4, 2.6]), np.zeros(2), 0.0)["h"].tolist() == [2.0, 0.5]


@pytest.mark.parametrize("name", ["thacker-rotating", "thacker-paraboloid", "travelling-vortex"])
def test_references_hold_before_the_end_too(name):
    scene = gr.scene(name)
    part = attrs.evolve(scene, t_end=0.3 * scene.t_end)
    errors = []
    for cells in (20, 40):
        problem = part.problem(gr.ShallowWater, cells)
        wanted = scene.known_reference().averages(problem.model, problem.grid, part.t_end)
        errors.append(np.abs(solve(problem).q[-1] - wanted).mean())
        moved = np.abs(problem.q0 - wanted).mean()
    assert errors[1] < 0.5 * errors[0]
    assert errors[1] < 0.1 * moved


def test_every_scene_says_how_many_axes_it_has(capsys):
    assert main(["scenes"]) == 0
    printed = capsys.readouterr().out.splitlines()
    assert max(map(len, printed)) <= 100
    lines = dict(line.split(maxsplit=1) for line in printed if not line.startswith(" "))  # others go on
    assert set(lines) == {*gr.scene_names(), "sample-torrent"}
    assert {name for name, rest in lines.items() if rest.startswith("2 axes")} == {*PLANE_SCENES, "sample-torrent"}
    assert all(rest.startswith(("1 axis  ", "2 axes  ")) for rest in lines.values())


@pytest.mark.parametrize("name", PLANE_SCENES)
def test_a_scene_comes_back_from_its_text_with_its_reference(name, tmp_path):
    made, path = gr.scene(name), tmp_path / "scene.toml"
    path.write_text(gr.scene_text(made))
    read = gr.load_scene(path)
    one, other = (scene.problem(gr.TwoPhase, 8) for scene in (made, read))
    assert np.array_equal(one.q0, other.q0)
    assert np.array_equal(one.aux_averages["b"], other.aux_averages["b"])
    assert (made.reference is None) == (read.reference is None)


def test_a_collapse_comes_to_rest():
    solution = solve(gr.scene("circular-collapse").problem(gr.Reduced, 20), until=fv.StopAtRest(1e-3))
    assert solution.t[-1] < 2.4
    assert not solution.observables()["speed"].max() > 1e-3
