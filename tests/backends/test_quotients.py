"""Quotients made of products are those of the divider, at zero, infinity and NaN too."""

import attrs
import numpy as np
import pytest
from numpy.testing import assert_array_equal

from fvkit.backends.compiled import pieces
from fvkit.backends.compiled.llvm import block, has_fma
from fvkit.backends.compiled.pieces import by_products
from fvkit.pointwise.tracing import Graph


@pytest.fixture(scope="module")
def divided():
    """A compiled function: quotients of two arrays, made of products."""
    numba = pytest.importorskip("numba")
    graph = Graph()
    a, b = (graph.node("load", name) for name in "ab")
    ratio = a / b
    made = block("ratio", [ratio], lambda node: node.operation == "load")
    function = attrs.evolve(made, multiplied=frozenset([ratio.index])).compiled()
    first = [item.index for item in made.inputs] == [a.index, b.index]

    @numba.njit(error_model="numpy")
    def run(a, b):
        result = np.empty_like(a)
        for k in range(len(a)):
            x, y = (a[k], b[k]) if first else (b[k], a[k])
            result[k] = function(x, y)[0]
        return result

    return run


needs_fma = pytest.mark.skipif(not has_fma(), reason="the remainder needs multiply and add in one instruction")


@needs_fma
@pytest.mark.parametrize(("low", "high"), [(-1.0, 1.0), (-40.0, 40.0), (-300.0, 300.0)])
def test_quotients_of_any_size_are_the_dividers(divided, low, high):
    rng = np.random.default_rng(3)
    a, b = (np.exp(rng.uniform(low, high, 400_000)) * rng.choice([-1.0, 1.0], 400_000) for _ in range(2))
    assert_array_equal(divided(a, b), a / b)


@needs_fma
def test_quotients_close_to_the_middle_between_two_numbers_are_the_dividers(divided):
    rng = np.random.default_rng(4)
    b = 1.0 + rng.uniform(size=200_000)
    middle = 1.0 + rng.uniform(size=200_000)
    a = np.concatenate([b * middle, np.nextafter(b * middle, 9.0), np.nextafter(b * middle, 0.0), b, 1.0 - 2.0**-53 * b])
    b = np.tile(b, 5)
    assert_array_equal(divided(a, b), a / b)


@needs_fma
def test_zero_infinity_nan_and_the_smallest_numbers_are_what_they_are_for_the_divider(divided):
    tiny, large = float(np.finfo(float).tiny), 2.0**1019
    values = np.array([0.0, -0.0, np.inf, -np.inf, np.nan, 1.0, -3.0, tiny, -tiny, large, -large, 1e-200, 1e200])
    a, b = (item.reshape(-1) for item in np.meshgrid(values, values))
    with np.errstate(all="ignore"):
        expected = a / b
        usual = ~np.isfinite(expected) | (expected == 0.0) | (np.abs(np.log2(np.abs(expected) + tiny)) < 960.0)
        usual &= (np.abs(a) > 2.0**-960) | (a == 0.0) | ~np.isfinite(a)  # else the remainder is no number that there is
    found = divided(a, b)
    assert_array_equal(found[usual], expected[usual])
    assert_array_equal(np.signbit(found[usual]), np.signbit(np.where(np.isnan(expected), found, expected)[usual]))
    zero = (a == 0.0) & (b == tiny)
    assert not found[zero].any()


def test_quotients_are_made_of_products_where_the_divider_takes_most_of_the_time(monkeypatch):
    graph = Graph()
    x, y = (graph.node("load", f"buf[{k} + j]") for k in range(2))
    short = block("short", [x / y, y / x], lambda node: node.operation == "load")
    chain = x
    for _ in range(60):
        chain = chain * y + x
    long = block("long", [chain, chain / y], lambda node: node.operation == "load")
    roots = block("roots", [x / y, *(np.sqrt(x + float(k)) for k in range(1, 6))], lambda node: node.operation == "load")
    monkeypatch.setattr(pieces, "divides_slowly", lambda: True)
    assert len(by_products(short)) == 2
    assert not by_products(long)
    assert not by_products(roots)
    monkeypatch.setattr(pieces, "divides_slowly", lambda: False)
    assert not by_products(short)
