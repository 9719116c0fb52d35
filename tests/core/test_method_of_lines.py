"""The method of lines for any law: tableaux, polynomials, order, user's own parts, refusals."""
from functools import partial
from itertools import pairwise

import attrs
import numpy as np
import pytest
from scipy.integrate import solve_ivp

import fvkit as fv
import fvkit_granular as gr
from fvkit.pointwise.polynomial import exchange, polynomial, product_slope
from fvkit.schemes.program import program
from fvkit.schemes.riemann import default_riemann
from tests.cases import PSystem, Traffic, averages, burgers_exact, l1, name_of, orders, solve

INTEGRATORS = (fv.SSPRK3(), fv.SSPRK104(), fv.DP5(), fv.ARK4())
ORDERS = {"SSPRK3": 3, "SSPRK104": 4, "DP5": 5, "ARK4": 4}
TINY = 1e-15  # what conditions on a table may miss: each of its digits counts
RECONSTRUCTIONS = (fv.MP5(), fv.WENO5(), fv.MUSCL())


def name_of_class(value):
    return type(value).__name__


def butcher(method):
    """Butcher's matrix and weights of the table in Shu and Osher's form."""
    count = len(method.beta)
    rows = np.zeros((count + 1, count))
    for k in range(count):
        rows[k + 1] = np.array(method.alpha[k]) @ rows[:len(method.alpha[k])]
        rows[k + 1, :len(method.beta[k])] += method.beta[k]
    return rows[:-1], rows[-1]


@pytest.mark.parametrize("method", INTEGRATORS, ids=name_of_class)
def test_tables_satisfy_the_order_conditions(method):
    a, b = butcher(method)
    c, order = a.sum(axis=1), ORDERS[type(method).__name__]
    assert all(abs(sum(alpha) - 1.0) < TINY for alpha in method.alpha)
    for power in range(order):
        assert b @ c**power == pytest.approx(1.0 / (power + 1), abs=TINY)
    ac, ac2, aac = a @ c, a @ c**2, a @ (a @ c)
    conditions = {3: [(b @ ac, 6)], 4: [(b @ (c * ac), 8), (b @ ac2, 12), (b @ aac, 24)],
                  5: [(b @ (c**2 * ac), 10), (b @ ac**2, 20), (b @ (c * ac2), 15), (b @ (a @ c**3), 20), (b @ (c * aac), 30),
                      (b @ (a @ (c * ac)), 40), (b @ (a @ ac2), 60), (b @ (a @ aac), 120)]}
    for at, checks in conditions.items():
        for value, over in checks if at <= order else ():
            assert value == pytest.approx(1.0 / over, abs=TINY)


@pytest.mark.parametrize("method", INTEGRATORS[:2], ids=name_of_class)
def test_ssp_steps_are_convex_combinations_of_euler_steps(method):
    for alpha, beta in zip(method.alpha, method.beta, strict=True):
        for share, weight in zip(alpha, beta, strict=False):
            assert share >= 0.0
            assert 0.0 <= weight <= share / method.ssp + 1e-15


def test_the_additive_method_is_of_fourth_order_in_both_tables_and_across_them():
    method = fv.ARK4()
    explicit, b = butcher(method)
    implicit = np.zeros_like(explicit)
    for k, row in enumerate(method.implicit):
        implicit[k + 1, :len(row)] = row
    c = explicit.sum(axis=1)
    np.testing.assert_allclose(c, [0.0, 0.5, 0.332, 0.62, 0.85, 1.0], rtol=0.0, atol=TINY)
    np.testing.assert_allclose(implicit.sum(axis=1), c, rtol=0.0, atol=TINY)
    assert tuple(b) == method.weights
    for first in (explicit, implicit):
        for value, over in ((b @ (first @ c), 6), (b @ (c * (first @ c)), 8), (b @ (first @ c**2), 12),
                            *[(b @ (first @ (second @ c)), 24) for second in (explicit, implicit)]):
            assert value == pytest.approx(1.0 / over, abs=TINY)


@pytest.mark.parametrize("method", INTEGRATORS, ids=name_of_class)
def test_the_program_of_an_integrator_needs_few_registers(method):
    assert program(method).registers <= 2 * len(method.beta) + 3
    assert sum(not sweep.implicit for sweep in program(method).sweeps) == len(method.beta)


@pytest.mark.parametrize("method", INTEGRATORS, ids=name_of_class)
def test_each_sweep_asks_the_boundaries_at_the_time_of_its_stage(method):
    c = butcher(method)[0].sum(axis=1)
    sweeps = program(method).sweeps
    np.testing.assert_allclose([sweep.time for sweep in sweeps if not sweep.implicit], c, rtol=0.0, atol=TINY)
    if method.implicit:
        np.testing.assert_allclose([sweep.time for sweep in sweeps if sweep.implicit], c, rtol=0.0, atol=TINY)


def test_products_of_polynomials_obey_the_product_rule():
    rng = np.random.default_rng(1)
    p, q = (polynomial(*rng.uniform(-1.0, 1.0, (4, 200))) for _ in range(2))
    rise = p.right * q.right - p.left * q.left
    np.testing.assert_allclose(product_slope(p, q) + product_slope(q, p), rise, atol=2e-15)
    np.testing.assert_allclose(product_slope(p, q) - product_slope(q, p), exchange(p, q), atol=2e-15)
    nodes, weights = np.polynomial.legendre.leggauss(6)
    step = 1e-20
    integral = sum(0.5 * w * p.at(0.5 * x) * q.at(0.5 * x + 1j * step).imag / step for x, w in zip(nodes, weights, strict=True))
    np.testing.assert_allclose(product_slope(p, q), integral, atol=3e-15)
    np.testing.assert_allclose(sum(0.5 * w * p.at(0.5 * x) for x, w in zip(nodes, weights, strict=True)), p.mean, atol=1e-15)


# ---------------------------------------------------------------------- orders

def refined(model, initial, exact, t, cells, scheme, length=1.0):
    errors = []
    for count in cells:
        grid = fv.Grid(0.0, length, count)
        problem = fv.Problem(model, grid, initial, t, boundary=fv.Periodic())
        errors.append(l1(grid, solve(problem, scheme).q[-1] - averages(exact, grid)))
    return orders(errors)


def bump(x):
    return np.sin(2.0 * np.pi * x)


LAWS = {
    "advection": (fv.Advection(1.0), lambda x: bump(x)[None], lambda x: bump(x - 0.4)[None], 0.4, (40, 80)),
    "burgers": (fv.Burgers(), lambda x: 1.0 + 0.3 * bump(x)[None],
                lambda x: burgers_exact(x, 0.2, lambda y: 1.0 + 0.3 * bump(y), lambda y: 0.6 * np.pi * np.cos(2.0 * np.pi * y))[None],
                0.2, (80, 160)),
    "traffic": (Traffic(), lambda x: 0.5 * (1.0 - (0.2 + 0.1 * bump(x)))[None],
                lambda x: 0.5 * (1.0 - burgers_exact(x, 0.6, lambda y: 0.2 + 0.1 * bump(y),
                                                     lambda y: 0.2 * np.pi * np.cos(2.0 * np.pi * y)))[None], 0.6, (80, 160)),
}


@pytest.mark.parametrize("name", LAWS)
def test_scalar_laws_are_fifth_order(name):
    assert refined(*LAWS[name], fv.MethodOfLines(default_riemann(LAWS[name][0]), integrator=fv.DP5()))[-1] >= 4.8


def test_acoustics_is_fifth_order():
    model = fv.Acoustics(2.0, 3.0)
    problem = fv.Problem(model, fv.Grid(0.0, 1.0, 10), lambda x: np.array([bump(x), 0.0 * x]), 1.0)
    c, t = float(np.max(model.wave_speeds(tuple(problem.q0))[1])), 0.1

    def exact(x):
        left, right = bump(x + c * t), bump(x - c * t)
        return 0.5 * (left + right)

    errors = []
    for cells in (40, 80):
        grid = fv.Grid(0.0, 1.0, cells)
        run = solve(fv.Problem(model, grid, lambda x: np.array([bump(x), 0.0 * x]), t, boundary=fv.Periodic()),
                    fv.MethodOfLines(fv.Roe(), integrator=fv.DP5()))
        errors.append(l1(grid, run.q[-1][:1] - averages(lambda x: exact(x)[None], grid)))
    assert orders(errors)[-1] >= 4.8


def test_a_system_of_the_users_own_is_fifth_order():
    ends = []
    for cells in (40, 80, 160):
        problem = fv.Problem(PSystem(), fv.Grid(0.0, 1.0, cells), lambda x: np.array([1.0 + 0.1 * bump(x), 0.2 + 0.0 * x]), 0.2,
                             boundary=fv.Periodic())
        ends.append(solve(problem, fv.MethodOfLines(fv.HLL(), integrator=fv.DP5())).q[-1])
    coarse = [np.abs(one - 0.5 * (two[:, ::2] + two[:, 1::2])).mean() for one, two in pairwise(ends)]
    assert orders(coarse)[-1] >= 4.8


@pytest.mark.parametrize(("reconstruction", "least"), [(fv.WENO5(), 4.5), (fv.MUSCL(), 1.75)], ids=name_of)
def test_the_other_reconstructions_have_their_order(reconstruction, least):
    assert refined(*LAWS["burgers"], fv.MethodOfLines(fv.Rusanov(), reconstruction, fv.DP5()))[-1] >= least


# ---------------------------------------------------------------------- rhs

@pytest.mark.parametrize("sources", [(), gr.ConstantDrag(3.0)], ids=["plain", "drag"])
def test_rhs_in_the_hands_of_scipy_agrees_with_our_own_steps(sources):
    model = gr.TwoPhase()
    problem = fv.Problem(model, fv.Grid(0.0, 1.0, 40), lambda x: model.conserved_from(1.0 + 0.1 * bump(x), 0.5, 0.2, 0.1), 0.05,
                         {"b": lambda x: 0.1 * bump(x)}, fv.Periodic(), sources)
    rate = fv.rhs(problem, fv.MethodOfLines(fv.Roe(), integrator=fv.DP5()))
    found = solve_ivp(rate, (0.0, 0.05), problem.q0.ravel(), rtol=1e-10, atol=1e-12).y[:, -1].reshape(4, 40)
    ours = solve(problem, fv.MethodOfLines(fv.Roe(), integrator=fv.DP5(), cfl=0.5)).q[-1]
    assert np.abs(ours - found).max() < (1e-4 if sources else 2e-7)
    assert np.abs(ours - problem.q0).max() > 1e-2


# ---------------------------------------------------------------------- parts of the user's own, refusals

@attrs.frozen
class Euler(fv.Integrator):
    """Forward Euler."""

    alpha = ((1.0,),)
    beta = ((1.0,),)
    cfl = 0.5
    ssp = 1.0


@attrs.frozen
class Constant(fv.Reconstruction):
    """First order."""

    reach = 1
    cubic = False

    def right(self, a, b, c, d, e):
        return c


def test_an_integrator_and_a_reconstruction_of_the_users_own_work():
    model, grid = fv.Advection(1.0), fv.Grid(0.0, 1.0, 50)
    problem = fv.Problem(model, grid, lambda x: bump(x)[None], 0.2, boundary=fv.Periodic())
    mine = solve(problem, fv.MethodOfLines(fv.Roe(), Constant(), Euler()))
    upwind = solve(problem, fv.WavePropagation(fv.Roe(), order=1, cfl=0.5))
    np.testing.assert_allclose(mine.q[-1], upwind.q[-1], atol=1e-14)


def test_what_cannot_work_is_refused_with_the_reason():
    model = gr.TwoPhase()
    flow = model.conserved_from(np.ones(20), 0.6)
    make = partial(fv.Problem, model, fv.Grid(0.0, 1.0, 20), flow, 1.0)
    with pytest.raises(ValueError, match="pile held by static friction needs WavePropagation"):
        fv.Stepper(make(sources=gr.CoulombFriction(0.3)), fv.MethodOfLines(fv.Roe()))
    with pytest.raises(ValueError, match="ARK4 takes one source that defines `implicit_rate`"):
        fv.Stepper(make(sources=(gr.ConstantDrag(1.0), gr.ConstantDrag(2.0))), fv.MethodOfLines(fv.Roe(), integrator=fv.ARK4()))
    with pytest.raises(TypeError, match="riemann"):
        fv.MethodOfLines("roe")
    with pytest.raises(TypeError, match="reconstruction"):
        fv.MethodOfLines(fv.Roe(), fv.MC())
    with pytest.raises(TypeError, match="integrator"):
        fv.MethodOfLines(fv.Roe(), integrator=fv.MP5())
    with pytest.raises(ValueError, match="cfl"):
        fv.MethodOfLines(fv.Roe(), cfl=0.0)
    pytest.importorskip("numba")
    with pytest.raises(ValueError, match="threads"):
        fv.Stepper(make(), fv.MethodOfLines(fv.Roe()), backend="numba", threads=2)
