"""Cell averages of the functions of x that a problem is given."""

import numpy as np
import pytest

import fvkit as fv
import fvkit_granular as gr


def averages_of(function, cells=7):
    return fv.Problem(fv.Burgers(), fv.Grid(-1.0, 2.5, cells), lambda x: function(x)[None], 1.0).q0[0]


@pytest.mark.parametrize("degree", range(10))
def test_averages_of_a_polynomial_up_to_degree_nine_are_exact(degree):
    edges = fv.Grid(-1.0, 2.5, 7).edges
    exact = np.diff(edges ** (degree + 1)) / (degree + 1) / 0.5
    np.testing.assert_allclose(averages_of(lambda x: x**degree), exact, rtol=2e-13, atol=1e-14)


def test_a_polynomial_of_degree_ten_is_where_exactness_ends():
    edges = fv.Grid(-1.0, 2.5, 1).edges
    exact = (edges[1] ** 11 - edges[0] ** 11) / 11.0 / 3.5
    assert abs(averages_of(lambda x: x**10, 1)[0] / exact - 1.0) > 1e-4


def test_a_jump_at_an_edge_stays_exactly_sharp():
    for cells in (10, 70, 700):
        q = fv.Problem(fv.Burgers(), fv.Grid(0.0, 1.0, cells), lambda x: np.where(x < 0.3, 2.0, 1.0)[None], 1.0).q0[0]
        np.testing.assert_allclose(q, np.where(np.arange(cells) < 3 * cells // 10, 2.0, 1.0), rtol=4e-16)


def test_averages_of_a_constant_are_the_constant():
    q = averages_of(lambda x: np.full_like(x, 0.3))
    np.testing.assert_allclose(q, 0.3, rtol=2e-16)


def test_the_function_sees_points_inside_cells_only():
    seen = []
    averages_of(lambda x: seen.append(x.copy()) or x)
    edges = fv.Grid(-1.0, 2.5, 7).edges
    for x in seen:
        assert x.shape == (35,)
        assert (np.diff(x) > 0.0).all()
        assert np.abs(x[:, None] - edges).min() > 0.01


@pytest.mark.parametrize(("function", "given"), [
    (lambda x: x, "(35,)"),
    (lambda x: np.ones((3, x.size)), "(3, 35)"),
    (lambda x: np.ones((2, x.size - 1)), "(2, 34)"),
    (lambda x: 1.0, "()"),
    (lambda x: np.ones((x.size, 2)), "(35, 2)"),
])
def test_a_wrong_shape_is_named_with_the_right_one(function, given):
    with pytest.raises(ValueError, match=r"`initial\(x\)`") as error:
        fv.Problem(gr.ShallowWater(), fv.Grid(0.0, 1.0, 7), function, 1.0)
    assert "`initial(x)` must return shape (2, 35) for x of shape (35,), got " + given in str(error.value)


def test_a_constant_among_arrays_is_told_how_to_broadcast():
    with pytest.raises(ValueError, match=r"np.full_like"):
        fv.Problem(gr.ShallowWater(), fv.Grid(0.0, 1.0, 7), lambda x: [1.0 + x, 0.0], 1.0)


def test_aux_may_be_a_number_an_array_or_a_function():
    def make(b):
        return fv.Problem(gr.ShallowWater(), fv.Grid(0.0, 1.0, 4), np.ones((2, 4)), 1.0, {"b": b}).aux_averages["b"]

    assert make(0.5).tolist() == [0.5] * 4
    assert make([1, 2, 3, 4]).tolist() == [1.0, 2.0, 3.0, 4.0]
    np.testing.assert_allclose(make(lambda x: 4.0 * x), [0.5, 1.5, 2.5, 3.5], rtol=1e-15)
    assert make(lambda x: 2.0).tolist() == pytest.approx([2.0] * 4)


def test_missing_aux_is_zero():
    problem = fv.Problem(gr.ShallowWater(), fv.Grid(0.0, 1.0, 4), np.ones((2, 4)), 1.0)
    assert problem.aux_averages["b"].tolist() == [0.0] * 4
