"""Plots of solutions with two axes: what they show, and what they refuse."""

import numpy as np
import pytest
from PIL import Image

import fvkit as fv
import fvkit_granular as gr
from fvkit.output.plots import space_time
from tests.cases import solve
from tests.plane.scenes import pool


@pytest.fixture(scope="module")
def solution():
    return solve(pool(), times=[0.1, 0.2, 0.4])


@pytest.fixture(scope="module")
def line():
    return solve(fv.Problem(gr.ShallowWater(), fv.Grid(0.0, 1.0, 8), lambda x: [1.0 + x, 0.0 * x], 0.05), times=[0.02, 0.05])


def colours(ax):
    return next(item for item in ax.collections if item.colorbar is not None)


def test_a_map_shows_the_depth_with_contours_of_the_bottom(solution):
    ax = solution.plot(i=1)
    mesh = colours(ax)
    assert np.array_equal(np.ravel(mesh.get_array()), solution.q[1, 0].ravel())
    assert mesh.colorbar.ax.get_ylabel() == "h, m"
    assert ax.get_aspect() == 1.0
    assert (ax.get_xlim(), ax.get_ylim()) == ((0.0, 6.0), (-1.0, 2.5))
    (contours,) = (item for item in ax.collections if hasattr(item, "levels"))
    assert np.ptp(contours.levels) > 0.2


def test_a_map_without_a_bottom_has_no_contours():
    problem = fv.Problem(gr.ShallowWater(), fv.Grid((0.0, 0.0), (1.0, 1.0), (4, 5)), lambda x, y: [1.0 + x, y, 0.0 * x], 0.01)
    ax = solve(problem).plot(name="v_x")
    assert len(ax.collections) == 1
    assert colours(ax).colorbar.ax.get_ylabel() == "v_x, m s-1"


@pytest.mark.parametrize("vector", [None, "vf"])
def test_arrows_are_the_velocity(vector):
    found = solve(pool(gr.TwoPhase(), (60, 35)), times=[0.1, 0.2])
    ax = found.plot(kind="vectors", vector=vector, name="phi")
    (arrows,) = (item for item in ax.collections if hasattr(item, "U"))
    name = vector or "vs"
    x, y = found.grid.axes
    columns, rows = (np.rint((arrows.XY[:, k] - axis.centers[0]) / axis.dx).astype(int) for k, axis in ((0, x), (1, y)))
    assert len(set(columns)) == 30
    assert len(set(rows)) == 17
    seen = found.observables()
    assert np.allclose(arrows.U, seen[f"{name}_x"][rows, columns], rtol=1e-15)
    assert np.allclose(arrows.V, seen[f"{name}_y"][rows, columns], rtol=1e-15)
    assert np.array_equal(np.ravel(colours(ax).get_array()), seen["phi"].ravel())
    scales = [found.plot(kind="vectors", i=i).collections[-1].scale for i in (1, 2)]
    assert scales[0] == scales[1]


def test_a_cut_shows_the_cells_along_a_line(solution):
    ax = solution.plot(kind="cut", name="speed", line=((1.2, -1.0), (1.2, 2.5)))
    (curve,) = ax.lines
    assert np.allclose(curve.get_xdata(), solution.grid.axes[1].centers + 1.0)
    assert np.array_equal(curve.get_ydata(), solution.observables()["speed"][:, 2])
    assert ax.get_ylabel() == "speed, m s-1"
    backwards = solution.plot(kind="cut", name="speed", line=((1.2, 2.5), (1.2, -1.0))).lines[0]
    assert np.array_equal(backwards.get_ydata(), curve.get_ydata()[::-1])


def test_a_cut_shows_layers_above_the_bottom_by_itself(solution):
    (surface,) = solution.plot(kind="cut").lines
    assert np.allclose(surface.get_xdata(), solution.grid.axes[0].centers)
    assert np.array_equal(surface.get_ydata(), solution.observables()["surface"][3])


def test_a_slanting_cut_misses_no_column(solution):
    (curve,) = solution.plot(kind="cut", name="h", line=((0.0, -1.0), (6.0, 2.5))).lines
    assert len(curve.get_xdata()) == 12
    assert curve.get_xdata()[-1] < np.hypot(6.0, 3.5)
    assert [curve.get_ydata()[k] for k in (0, -1)] == [solution.q[-1, 0, 0, 0], solution.q[-1, 0, -1, -1]]


@pytest.mark.parametrize(("line", "words"), [
    (((0.0, 0.0), (6.5, 0.0)), r"`line` must be within \[0, 6\], got 6"),
    (((1.0, 1.0), (1.0, 1.0)), r"`line` must have two ends that differ"),
    ((1.0, 2.0), r"`line` must have shape \(2, 2\)")])
def test_a_cut_refuses_what_is_no_line(solution, line, words):
    with pytest.raises(ValueError, match=words):
        solution.plot(kind="cut", line=line)


def test_kinds_of_the_other_number_of_axes_are_refused(solution, line, tmp_path):
    for kind in ("state", "profile", "depth", "speeds", "margin"):
        with pytest.raises(ValueError, match=r"`kind` must be one of map, vectors, cut; got"):
            solution.plot(kind=kind)
        with pytest.raises(ValueError, match=r"`kind` must be one of map, vectors, cut; got"):
            solution.animate(tmp_path / "film.gif", kind)
    for kind in ("map", "vectors", "cut"):
        with pytest.raises(ValueError, match=r"`kind` must be one of state, profile, depth, speeds, margin; got"):
            line.plot(kind=kind)
    with pytest.raises(ValueError, match=r"needs a grid with one axis, got one with two: take kind='map'"):
        space_time(solution)


def test_vectors_need_a_vector():
    problem = fv.Problem(fv.Advection((1.0, 1.0)), fv.Grid((0.0, 0.0), (1.0, 1.0), (4, 5)), lambda x, y: [x], 0.1)
    found = solve(problem)
    with pytest.raises(ValueError, match=r"Advection has no observable that is a vector: take kind='map'"):
        found.plot(kind="vectors")
    assert len(found.plot(kind="cut").lines) == 1


def test_a_film_has_the_same_colours_in_all_frames(solution, monkeypatch, tmp_path):
    from fvkit.output import plots

    seen = []
    draw = plots.plot_map

    def noted(*arguments, **options):
        ax = draw(*arguments, **options)
        seen.append(ax)
        return ax

    monkeypatch.setitem(plots.MAPS, "map", noted)
    path = solution.animate(tmp_path / "film.gif", fps=2, name="h").path
    with Image.open(path) as film:
        assert film.n_frames == 4
    film_axes = seen[-1]
    depths = solution.q[:, 0]
    assert colours(film_axes).get_clim() == (depths.min(), depths.max())
    assert len(film_axes.figure.axes) == 2


def test_a_film_of_a_line_keeps_its_limits(line, tmp_path):
    ax = line.plot()
    line.animate(tmp_path / "film.gif", ax=ax)
    ends = [line.plot(i=i).get_ylim() for i in range(3)]
    assert ax.get_ylim() == (min(low for low, _ in ends), max(high for _, high in ends))


def test_solutions_problems_and_steppers_show_both_axes(solution):
    assert "12 x 7 cells on [0, 6] x [-1, 2.5] m" in repr(solution)
    assert "<td>12 x 7</td>" in solution._repr_html_()
    problem = pool()
    assert "num_cells=(12, 7)" in repr(problem)
    assert "Along(lower=0.0" in repr(problem)
    assert "array" not in repr(problem)
    assert repr(fv.Stepper(problem, backend="numpy")).startswith("<Stepper of ShallowWater")
