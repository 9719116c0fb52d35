"""Polygons on cells: shares are exact, whatever the shape, and rings that cross are found."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from matplotlib.path import Path

import fvkit as fv
from fvkit_granular.terrain.polygons import area, crossing, ring, shares

GRID = fv.Grid((1000.0, 5000.0), (1040.0, 5021.0), (8, 7))


def star(angles, radii, centre=(1020.0, 5010.0)):
    """Return a ring around a centre, counter-clockwise: it never crosses itself."""
    return np.stack([centre[0] + radii * np.cos(angles), centre[1] + radii * np.sin(angles)], axis=1)


def sampled(polygon, grid, fine=60):
    """Return shares by counting points, even-odd."""
    x, y = ((axis.lower + (np.arange(axis.num_cells * fine) + 0.5) * axis.dx / fine) for axis in grid.axes)
    points = np.stack(np.meshgrid(x, y), axis=-1).reshape(-1, 2)
    inside = np.logical_xor.reduce([Path(points_).contains_points(points) for points_ in polygon])
    return inside.reshape(grid.shape[0], fine, grid.shape[1], fine).mean(axis=(1, 3))


@settings(max_examples=60)
@given(st.lists(st.floats(0.5, 9.9), min_size=3, max_size=12), st.booleans(), st.floats(0.0, 6.0))
def test_shares_add_up_to_the_area_of_any_ring(radii, clockwise, turn):
    points = star(turn + np.linspace(0.0, 2.0 * np.pi, len(radii), endpoint=False), np.array(radii))
    polygon = [points[::-1] if clockwise else points]
    found = shares(polygon, GRID)
    assert found.min() > -1e-12
    assert found.max() < 1.0 + 1e-12
    assert found.sum() * GRID.cell_volume == pytest.approx(area(polygon), rel=1e-11)
    assert crossing(polygon) is None


def test_each_share_is_what_points_count():
    outer = star(np.linspace(0.0, 2.0 * np.pi, 9, endpoint=False), np.array([9.0, 4.0] * 4 + [7.0]))
    polygon = [outer, star(np.linspace(0.3, 6.0, 5), np.full(5, 2.5))]
    found = shares(polygon, GRID)
    np.testing.assert_allclose(found, sampled(polygon, GRID), atol=0.01)
    assert found.sum() * GRID.cell_volume == pytest.approx(area(polygon), rel=1e-12)


def test_a_rectangle_on_the_edges_of_cells_covers_them_alone():
    box = np.array([[1005.0, 5003.0], [1020.0, 5003.0], [1020.0, 5009.0], [1005.0, 5009.0]])
    expected = np.zeros(GRID.shape)
    expected[1:3, 1:4] = 1.0
    for points in (box, box[::-1]):
        np.testing.assert_allclose(shares([points], GRID), expected, atol=1e-13)
    whole = np.array([[1000.0, 5000.0], [1040.0, 5000.0], [1040.0, 5021.0], [1000.0, 5021.0]])
    np.testing.assert_allclose(shares([whole], GRID), 1.0, atol=1e-13)


def test_what_is_outside_of_the_grid_is_left_out():
    wide = np.array([[0.0, 4000.0], [1012.5, 4000.0], [1012.5, 9000.0], [0.0, 9000.0]])
    np.testing.assert_allclose(shares([wide], GRID), [[1.0, 1.0, 0.5, 0.0, 0.0, 0.0, 0.0, 0.0]] * 7, atol=1e-12)
    np.testing.assert_allclose(shares([wide + np.array([1012.5, 0.0])], GRID), [[0.0, 0.0, 0.5, 1.0, 1.0, 1.0, 1.0, 1.0]] * 7, atol=1e-12)
    np.testing.assert_allclose(shares([np.array([[0.0, 0.0], [9e3, 0.0], [9e3, 9e3], [0.0, 9e3]])], GRID), 1.0, atol=1e-12)


def test_rings_that_cross_are_found_and_those_that_touch_are_not():
    bow = np.array([[0.0, 0.0], [2.0, 2.0], [2.0, 0.0], [0.0, 2.1]])
    assert crossing([bow]) == (0.0, 0.0)
    square = np.array([[0.0, 0.0], [4.0, 0.0], [4.0, 4.0], [0.0, 4.0]])
    assert crossing([square, square * 0.5 + 1.0]) is None
    assert crossing([square, square * 0.5 + 3.0]) is not None
    assert crossing([square, np.array([[0.0, 0.0], [2.0, 1.0], [1.0, 2.0]])]) is None


@pytest.mark.parametrize(("points", "words"), [([], "enclose an area, got 0"), ([[0, 0], [1, 1], [0, 0]], "enclose an area"),
                                               ([[0, 0], [1, np.nan], [2, 0]], "finite"), ([[0], [1], [2]], "points"), ("ring", "points"), (None, "points"),
                                               ([[0, 0], [1, 0], [1, 10**400]], "points")])
def test_what_is_no_ring_is_refused(points, words):
    with pytest.raises(ValueError, match=f"feature 'a': .*{words}"):
        ring(points, "feature 'a'")


def test_the_closing_point_of_a_ring_goes():
    assert len(ring([[0, 0, 7], [1, 0, 7], [1, 1, 7], [0, 0, 7]], "a")) == len(ring([[0, 0], [1, 0], [1, 1]], "a")) == 3
