"""Shapes: values at chosen points, sums, and what they refuse."""

import pickle

import numpy as np
import pytest

from fvkit_granular import ShapedFlow, shapes

X = np.array([-1.0, 0.0, 0.5, 1.0, 3.0])


@pytest.mark.parametrize(("shape", "values"), [
    (shapes.Uniform(2), [2.0, 2.0, 2.0, 2.0, 2.0]),
    (shapes.Step(0.0, 1.0, 3.0), [1.0, 3.0, 3.0, 3.0, 3.0]),
    (shapes.Steps([0.0, 1.0], [5.0, 6.0, 7.0]), [5.0, 6.0, 6.0, 7.0, 7.0]),
    (shapes.Block(0.0, 1.0, 4.0), [0.0, 4.0, 4.0, 0.0, 0.0]),
    (shapes.Hump(0.0, 1.0, 4.0), [0.0, 4.0, 2.0, 0.0, 0.0]),
    (shapes.Gaussian(0.0, 0.5, 2.0), 2.0 * np.exp(-4.0 * X**2)),
    (shapes.Cosine(1.0, 0.5, 2.0), [0.5, 1.5, 1.0, 0.5, 0.5]),
    (shapes.Cosine(1.0, 0.5, 2.0, crest=1.0), [1.5, 0.5, 1.0, 1.5, 1.5]),
    (shapes.Plane(-2.0, at=1.0, level=3.0), [7.0, 5.0, 4.0, 3.0, -1.0]),
    (shapes.PiecewiseLinear([(0.0, 0.0), (1.0, 2.0), (5.0, 4.0)]), [0.0, 0.0, 1.0, 2.0, 3.0]),
    (shapes.Step(0.0, 1.0, 3.0) + shapes.Block(0.0, 1.0, 4.0) + 0.5, [1.5, 7.5, 7.5, 3.5, 3.5]),
])
def test_values(shape, values):
    np.testing.assert_allclose(shape(X), values, atol=1e-15)
    assert pickle.loads(pickle.dumps(shape)) == shape


@pytest.mark.parametrize(("make", "words"), [
    (lambda: shapes.Step(0.0, 1.0, np.nan), "`right` must be finite"),
    (lambda: shapes.Step("0", 1.0, 2.0), "`at` must be a number"),
    (lambda: shapes.Block(0.0, 0.0, 1.0), "`half_width` must be finite and > 0"),
    (lambda: shapes.Steps([1.0, 0.0], [1.0, 2.0, 3.0]), "`at`: x must ascend, got 1, 0"),
    (lambda: shapes.Steps([1.0], [1.0]), "`values` must be one more than `at`, got 1 and 1"),
    (lambda: shapes.Steps(1.0, [1.0, 2.0]), "`at` must be a list, not empty"),
    (lambda: shapes.PiecewiseLinear([[0.0, 1.0], [0.0, 2.0]]), "`points`: x must ascend, got 0, 0"),
    (lambda: shapes.PiecewiseLinear([[0.0, 1.0, 2.0]]), "`points` must have shape"),
    (lambda: shapes.PiecewiseLinear([]), "`points` must be a list, not empty"),
    (lambda: shapes.Sum([]), "`terms` must be a non-empty list"),
    (lambda: shapes.Uniform(1.0) + "x", "a number or a shape"),
    (lambda: ShapedFlow(phi=0.5), "either `h`, the depth, or `surface`"),
    (lambda: ShapedFlow(1.0, phi=0.5, surface=1.0), "either `h`, the depth, or `surface`"),
    (lambda: ShapedFlow(1.0), "needs `phi`"),
])
def test_mistakes(make, words):
    with pytest.raises((ValueError, TypeError), match=words):
        make()


def test_a_surface_makes_a_depth_that_is_never_negative():
    flow = ShapedFlow(surface=1.0, phi=0.5, bottom=shapes.Plane(1.0))
    np.testing.assert_array_equal(flow(X)["h"], [2.0, 1.0, 0.5, 0.0, 0.0])
    np.testing.assert_array_equal(ShapedFlow(surface=1.0, phi=0.5, bottom=0.25).depth(X), np.full(5, 0.75))
