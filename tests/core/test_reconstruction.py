"""Reconstructions by themselves: exact on polynomials, constant on constants, and their formulas written a second way."""

from itertools import pairwise

import numpy as np
import pytest
from numpy.polynomial import Polynomial

import fvkit as fv

ALL = (fv.MP5(), fv.WENO5(), fv.MUSCL())
RANDOM = np.random.default_rng(5).normal(0.3, 1.0, (200, 5))


def cell_averages(polynomial, cells=range(-2, 3)):
    """Averages over cells of length 1 around 0."""
    whole = polynomial.integ()
    return [whole(k + 0.5) - whole(k - 0.5) for k in cells]


@pytest.mark.parametrize(("part", "degree"), [(fv.MP5(), 4), (fv.WENO5(), 2), (fv.MUSCL(), 1)])
def test_a_monotone_polynomial_is_exact(part, degree):
    for shape in (Polynomial([8.0, 1.0]) ** degree, Polynomial([3.0, -0.2]) ** degree, Polynomial([-5.0, 2.0])):
        assert part.right(*cell_averages(shape)) == pytest.approx(shape(0.5), rel=1e-13)


@pytest.mark.parametrize("part", ALL, ids=lambda part: type(part).__name__)
@pytest.mark.parametrize("value", [0.0, 1e-200, 3.7, -1e5])
def test_five_equal_averages_give_the_same(part, value):
    assert part.right(*np.full((5, 1), value)) == pytest.approx(value, rel=1e-15)


@pytest.mark.parametrize("part", ALL, ids=lambda part: type(part).__name__)
def test_a_jump_beside_the_cell_leaves_no_trace(part):
    for jump in (1.0, -1e-6, 1e4):
        assert part.right(*(jump * np.array([0.0, 0.0, 0.0, 1.0, 1.0]))) == pytest.approx(0.0, abs=1e-12 * abs(jump))
        assert part.right(*(jump * np.array([0.0, 0.0, 1.0, 1.0, 1.0]))) == pytest.approx(jump, rel=1e-12)


@pytest.mark.parametrize(("cells", "wanted"), [
    ((1.0, 2.0, 9.0), 3.0), ((1.0, 8.0, 9.0), 9.0), ((1.0, 4.0, 6.0), 5.25), ((9.0, 2.0, 1.0), 1.0), ((9.0, 8.0, 1.0), 7.0),
    ((6.0, 4.0, 1.0), 2.75), ((1.0, 5.0, 2.0), 5.0), ((5.0, 1.0, 2.0), 1.0), ((3.0, 3.0, 7.0), 3.0)])
def test_muscl_takes_the_smallest_slope(cells, wanted):
    wanted_slope = 2.0 * (wanted - cells[1])
    back, forth = cells[1] - cells[0], cells[2] - cells[1]
    candidates = (2.0 * back, 2.0 * forth, 0.5 * (back + forth))
    assert wanted_slope == (min(candidates, key=abs) if back * forth > 0.0 else 0.0)
    assert fv.MUSCL().right(None, *cells, None) == wanted


def test_weno_is_the_weighted_mean_of_three_parabolas():
    def parabola(values, cells):
        rows = [cell_averages(Polynomial.basis(k), cells) for k in range(3)]
        return Polynomial(np.linalg.solve(np.array(rows).T, values))

    def roughness(p):
        square = (p.deriv() ** 2 + p.deriv(2) ** 2).integ()
        return square(0.5) - square(-0.5)

    for data in RANDOM:
        parts = [parabola(data[k:k + 3], range(k - 2, k + 1)) for k in range(3)]
        rough = np.array([roughness(p) for p in parts])
        weights = np.array([0.1, 0.6, 0.3]) * (1.0 + (abs(rough[0] - rough[2]) / rough) ** 2)
        wanted = weights @ [p(0.5) for p in parts] / weights.sum()
        assert fv.WENO5().right(*data) == pytest.approx(wanted, rel=1e-9, abs=1e-11)


def test_mp5_is_the_median_of_fifth_order_and_its_bounds():
    def minmod(*values):
        return min(values, key=abs) if all(v > 0 for v in values) or all(v < 0 for v in values) else 0.0

    changed = 0
    for a, b, c, d, e in RANDOM:
        free = (2 * a - 13 * b + 47 * c + 27 * d - 3 * e) / 60
        bends = (a - 2 * b + c, b - 2 * c + d, c - 2 * d + e)
        behind, ahead = (minmod(4 * x - y, 4 * y - x, x, y) for x, y in pairwise(bends))
        median = (c + d) / 2 - ahead / 2
        large = c + (c - b) / 2 + 4 * behind / 3
        least = max(min(c, d, median), min(c, c + 4 * (c - b), large))
        most = min(max(c, d, median), max(c, c + 4 * (c - b), large))
        wanted = sorted((free, least, most))[1]
        changed += wanted != free
        assert fv.MP5().right(a, b, c, d, e) == pytest.approx(wanted, rel=1e-13, abs=1e-14)
    assert 50 < changed < 200
