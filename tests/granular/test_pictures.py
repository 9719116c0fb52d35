"""Pictures, films and what a notebook shows: the right data on the given axes."""

import os
from base64 import b64encode

import numpy as np
import pytest
from matplotlib.image import imread

import fvkit as fv
import fvkit_granular as gr
from fvkit.cli import MISTAKE, SUCCESS, main
from fvkit.output.figures import new_axes
from fvkit.output.plots import enlargement, space_time
from tests.cases import solve


@pytest.fixture(scope="module")
def slide():
    return solve(gr.scene("debris-slope").problem(gr.TwoPhase, 60), times=[0.5, 1.0, 1.5], nonhyperbolic="ignore")


@pytest.fixture(scope="module")
def burgers():
    problem = fv.Problem(fv.Burgers(), fv.Grid(0.0, 1.0, 20), lambda x: np.sin(2 * np.pi * x)[None], 0.1, boundary=fv.Periodic())
    return solve(problem, fv.WavePropagation(fv.Roe()))


@pytest.mark.parametrize("kind", ["state", "profile", "depth", "speeds", "margin"])
def test_every_kind_draws_on_the_given_axes(slide, kind):
    _, (ax,) = new_axes()
    assert slide.plot(ax, 2, kind=kind) is ax
    assert "t = 1" in ax.get_title()
    ax.figure.canvas.draw()


def test_a_profile_stacks_grains_and_water_on_the_bottom(slide):
    ax = slide.plot(kind="profile")
    (surface,) = ax.get_lines()
    np.testing.assert_allclose(surface.get_ydata(), slide.observables()["surface"], rtol=1e-13)
    assert [text.get_text() for text in ax.get_legend().get_texts()] == ["bottom", "solid", "fluid"]
    solid = next(shade for shade in ax.collections if shade.get_label() == "solid")
    highest = solid.get_paths()[0].vertices[:, 1].max()
    assert highest == pytest.approx((slide.aux["b"] + slide.q[-1, 0]).max(), rel=1e-12)


@pytest.mark.parametrize("model", [gr.Reduced, gr.ShallowWater, gr.PitmanLe, gr.TwoLayer])
def test_thicknesses_add_up_to_the_depth(model):
    problem = gr.scene("dam-break").problem(model, 10)
    seen = problem.model.observables(problem.q0)
    np.testing.assert_allclose(sum(problem.model.thicknesses(seen).values()), seen["h"], rtol=1e-14)


def test_space_time_holds_every_output(slide):
    ax = space_time(slide, name="h")
    values = ax.collections[0].get_array()
    np.testing.assert_array_equal(values, [slide.observables(i)["h"] for i in range(4)])
    with pytest.raises(ValueError, match="did you mean surface"):
        space_time(slide, name="surfac")


def test_speeds_are_those_of_the_model(burgers):
    np.testing.assert_array_equal(burgers.plot(kind="speeds").get_lines()[0].get_ydata(), burgers.q[-1, 0])


def test_complex_speeds_are_shown_where_they_are(slide):
    ax = slide.plot(kind="margin")
    red = next(shade for shade in ax.collections if shade.get_label() == "complex speeds")
    assert bool(red.get_paths()) == bool((slide.hyperbolicity_margin() < 0.0).any())


def test_slip_is_drawn_where_both_phases_are(slide):
    seen = slide.observables()
    drawn = gr.plots.slip(slide).get_lines()[0].get_ydata()
    there = np.isfinite(drawn)
    assert there.any()
    np.testing.assert_array_equal(drawn[there], (seen["vf"] - seen["vs"])[there])


def test_what_a_model_has_not_is_a_sentence(burgers, tmp_path):
    for kind in ("profile", "depth"):
        with pytest.raises(ValueError, match=f"thicknesses.*no {kind}"):
            burgers.plot(kind=kind)
    with pytest.raises(ValueError, match="did you mean state"):
        burgers.plot(kind="stat")
    with pytest.raises(ValueError, match="more than the start and the end"):
        space_time(burgers)
    with pytest.raises(ValueError, match="one velocity"):
        gr.plots.slip(burgers)
    with pytest.raises(ValueError, match=r"\.gif or \.mp4"):
        burgers.animate(tmp_path / "film.avi")


def test_a_film_has_a_frame_per_output(slide, tmp_path):
    from PIL import Image

    found = slide.animate(tmp_path / "film.gif", kind="profile", fps=5)
    path = found.path
    with Image.open(path) as film:
        assert film.n_frames == 4
        assert film.info["duration"] == 200
    assert [entry.name for entry in tmp_path.iterdir()] == ["film.gif"]
    assert imread(path).std() > 0.0
    assert b64encode(path.read_bytes()).decode() in found._repr_html_()
    assert os.fspath(found) == str(path)


def test_axes_as_the_last_line_of_a_notebook_show_their_picture(slide):
    assert slide.plot()._repr_png_().startswith(b"\x89PNG")


def test_a_missing_ffmpeg_is_a_sentence(burgers, tmp_path, monkeypatch):
    monkeypatch.setattr("matplotlib.animation.FFMpegWriter.isAvailable", classmethod(lambda cls: False))
    with pytest.raises(ValueError, match=r"ffmpeg.*write a \.gif"):
        burgers.animate(tmp_path / "film.mp4")


def test_notebooks_show_tables(slide):
    shown = slide._repr_html_()
    assert "<th>model</th><td>TwoPhase</td>" in shown
    assert f"{slide.stats.steps} (" in shown
    report = gr.compare(gr.scene("dam-break"), [gr.ShallowWater], cells=(10,), repeats=1)
    assert report._repr_html_().startswith("<pre>scene dam-break")
    assert "&lt;" in report._repr_html_() or "<" not in report.table()


def test_the_command_draws_and_films(tmp_path, capsys, monkeypatch):
    monkeypatch.setattr("fvkit_granular.cli.run.FRAMES", 5)
    out = tmp_path / "out"
    arguments = ["run", "dam-break-phi", "--cells", "30", "--out", str(out)]
    assert main([*arguments, "--plot", "profile", "slip", "--animate", "film.gif"]) == SUCCESS
    assert "solution.npz, run.txt, profile.png, slip.png, film.gif" in capsys.readouterr().out
    assert {path.name for path in out.iterdir()} == {"solution.npz", "run.txt", "profile.png", "slip.png", "film.gif"}
    assert main([*arguments, "--plot", "profil"]) == MISTAKE
    assert "did you mean profile?" in capsys.readouterr().err
    assert main([*arguments, "--animate", "film.avi"]) == MISTAKE


def test_the_accuracy_of_a_solver_is_drawn_against_both_references():
    figure = gr.plots.accuracy(fv.HLL(), cells=(20, 40, 80), backend="numpy")
    profile, error = figure.axes
    assert [text.get_text() for text in profile.get_legend().get_texts()] == ["20 cells", "80 cells", "semi-exact"]
    assert [text.get_text() for text in error.get_legend().get_texts()] == ["dam-break-phi (semi-exact)", "simple-wave (exact)"]
    for line in error.get_lines():
        assert (np.diff(line.get_ydata()) < 0.0).all()
    coarse, fine, exact = (line.get_ydata() for line in profile.get_lines())
    assert np.abs(fine - exact).mean() < 0.5 * np.abs(coarse - exact.reshape(20, 4).mean(axis=1)).mean()
    figure.canvas.draw()


def test_a_scheme_has_a_picture_as_a_solver_has():
    error = gr.plots.accuracy(fv.WavePropagation(fv.HLL(), order=1), cells=(20, 40), backend="numpy").axes[1]
    guides = [text.get_text() for text in error.texts]
    assert guides == ["order 1", "order 1"]


def test_a_figure_is_a_picture_for_a_notebook_without_pyplot(burgers):
    figure = burgers.plot().figure
    assert figure._repr_png_().startswith(b"\x89PNG")


def channel(relief, depth, t_end=4.0, level=0.0):
    """A flow of a given depth on a slope of 1000 m that ends at a level."""
    scene = gr.Scene((0.0, 1000.0), t_end, lambda x: {"h": depth * (np.abs(x - 300.0) < 100.0), "phi": 0.5},
                     bottom=lambda x: level + relief * (1.0 - x / 1000.0), slope="mild")
    return solve(scene.problem(gr.ShallowWater, 50), times=[0.5 * t_end, t_end])


@pytest.mark.parametrize(("relief", "depth", "factor"), [
    (0.0, 1.0, 1.0), (15.0, 1.0, 1.0), (100.0, 2.0, 5.0), (100.0, 1.0, 10.0), (50.0, 0.02, 200.0), (100.0, 0.0, 1.0)])
@pytest.mark.filterwarnings("ignore::fvkit_granular.models.slope.SteepSlopeWarning")
def test_depths_are_enlarged_where_the_relief_would_hide_them(relief, depth, factor):
    """The factor is 1, 2 or 5 times a power of ten, the largest with which 0.15 of the relief holds the largest depth."""
    found = channel(relief, depth)
    assert enlargement(found) == factor
    ax, b = found.plot(kind="profile"), found.aux["b"]
    np.testing.assert_allclose(ax.get_lines()[0].get_ydata(), b + factor * found.observables()["h"], rtol=1e-13)
    assert ax.get_ylabel() == ("height, m" if factor == 1.0 else f"height, m; depth {factor:g} times enlarged")
    true = found.plot(kind="profile", enlarge=1.0)
    np.testing.assert_allclose(true.get_lines()[0].get_ydata(), b + found.observables()["h"], rtol=1e-13)
    labels = [text.get_text() for text in found.plot(kind="state").get_legend().get_texts()]
    assert ("surface" in labels) == (factor == 1.0)
    np.testing.assert_array_equal(found.plot(kind="depth").get_lines()[0].get_ydata(), found.observables()["h"])
    with pytest.raises(ValueError, match="`enlarge` must be"):
        found.plot(kind="profile", enlarge=0.0)


def test_high_ground_fills_the_picture():
    low, high = channel(100.0, 1.0, level=1500.0).plot(kind="profile").get_ylim()
    assert low > 1480.0
    assert high < 1650.0


@pytest.mark.filterwarnings("ignore::fvkit_granular.models.slope.SteepSlopeWarning")
def test_the_first_picture_and_the_film_of_a_channel_show_its_flow(tmp_path, monkeypatch):
    from PIL import Image

    monkeypatch.setattr("fvkit_granular.cli.run.FRAMES", 4)
    (tmp_path / "channel.toml").write_text("""t_end = 20.0
interval = [0.0, 2000.0]
initial = {h = {shape = "block", centre = 250.0, half_width = 100.0, height = 1.0}, phi = 0.6}
bottom = {shape = "piecewise-linear", points = [[0.0, 500.0], [1400.0, 60.0], [2000.0, 0.0]]}
friction = {type = "coulomb", nu = 0.2}
""")
    out = tmp_path / "out"
    assert main(["run", str(tmp_path / "channel.toml"), "--cells", "100", "--out", str(out), "--plot", "depth", "--animate",
                 "film.gif", "--model", "reduced"]) == SUCCESS
    sand = np.array([0xC9, 0xA6, 0x6B])

    def shown(picture):
        """Share of its pixels that have the colour of grains."""
        return np.mean(np.abs(np.asarray(picture.convert("RGB"), dtype=float) - sand).max(axis=-1) < 12.0)

    with Image.open(out / "film.gif") as film:
        assert film.n_frames == 5
        for k in range(5):
            film.seek(k)
            assert shown(film) > 2e-3
    for name in ("profile.png", "depth.png"):
        with Image.open(out / name) as picture:
            assert shown(picture) > 2e-3


def test_the_name_of_a_file_is_no_axes():
    with pytest.raises(TypeError, match=r"`ax` must be .*x\.pdf.*figure\.savefig"):
        fv.solve(gr.scene("rest").problem(gr.ShallowWater, 4), backend="numpy").plot("x.pdf")
