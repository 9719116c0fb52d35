"""A user's short model runs at once with every solver that can serve it, to full order."""

import attrs
import numpy as np
import pytest

import fvkit as fv
from tests.cases import PSystem, Stepper, Traffic, averages, burgers_exact, coarsen, l1, name_of, orders, solve

GENERAL = (fv.HLL(), fv.Rusanov())


class PlainBurgers(fv.Model):
    """Burgers' equation without a Roe decomposition."""

    conserved = ("u",)

    def flux(self, q):
        (u,) = q
        return (0.5 * u * u,)

    def wave_speeds(self, q):
        (u,) = q
        return u, u


def red_light(x):
    return np.where(x < 0.0, 0.3, 0.9)[None]


@pytest.mark.parametrize("order", [1, 2])
@pytest.mark.parametrize("riemann", GENERAL, ids=name_of)
def test_a_traffic_shock_moves_at_its_exact_speed(riemann, order):
    grid = fv.Grid(-1.0, 1.0, 200)
    solution = solve(fv.Problem(Traffic(), grid, red_light, 2.0), fv.WavePropagation(riemann, order=order))
    shock = 1.0 - 0.3 - 0.9
    exact = averages(lambda x: np.where(x < 2.0 * shock, 0.3, 0.9), grid)
    assert l1(grid, solution.q[-1, 0] - exact) < 0.01
    assert solution.success


@pytest.mark.parametrize("order", [1, 2])
@pytest.mark.parametrize("riemann", GENERAL, ids=name_of)
def test_an_isothermal_gas_keeps_mass_and_momentum_on_a_ring(riemann, order):
    def initial(x):
        return np.array([1.0 + 0.5 * (np.abs(x - 0.5) < 0.2), 0.3 * np.sin(2.0 * np.pi * x)])

    problem = fv.Problem(PSystem(), fv.Grid(0.0, 1.0, 100), initial, 0.5, boundary=fv.Periodic())
    solution = solve(problem, fv.WavePropagation(riemann, order=order))
    np.testing.assert_allclose(solution.q[-1].sum(axis=1), solution.q[0].sum(axis=1), atol=1e-11)


@pytest.mark.parametrize("model", [Traffic(), PSystem(), PlainBurgers()], ids=name_of)
def test_the_default_scheme_of_a_model_without_decomposition_is_hll(model):
    q = np.full((len(model.conserved), 8), 0.5)
    scheme = Stepper(fv.Problem(model, fv.Grid(0.0, 1.0, 8), q, 1.0)).scheme
    assert scheme == fv.WavePropagation(fv.HLL())


def test_the_default_scheme_of_a_model_with_decomposition_is_roe():
    problem = fv.Problem(fv.Burgers(), fv.Grid(0.0, 1.0, 8), np.ones((1, 8)), 1.0)
    assert Stepper(problem).scheme == fv.WavePropagation(fv.Roe())


def test_roe_refuses_a_model_without_decomposition_and_lists_what_fits():
    problem = fv.Problem(Traffic(), fv.Grid(-1.0, 1.0, 10), red_light, 1.0)
    with pytest.raises(ValueError, match=r"Roe cannot serve Traffic.*`decompose`.*Solvers that fit it: .*HLL.*Rusanov"):
        solve(problem, fv.WavePropagation(fv.Roe()))


@pytest.mark.parametrize("riemann", GENERAL, ids=name_of)
def test_the_generic_matrix_product_gives_second_order_on_burgers(riemann):
    def wave(x):
        return 1.5 + np.sin(2.0 * np.pi * x)

    def slope(x):
        return 2.0 * np.pi * np.cos(2.0 * np.pi * x)

    errors = []
    for cells in (80, 160, 320):
        grid = fv.Grid(0.0, 1.0, cells)
        problem = fv.Problem(PlainBurgers(), grid, lambda x: wave(x)[None], 0.08, boundary=fv.Periodic())
        solution = solve(problem, fv.WavePropagation(riemann, fv.NoLimiter()))
        exact = averages(lambda x: burgers_exact(x, 0.08, wave, slope), grid)
        errors.append(l1(grid, solution.q[-1, 0] - exact))
    assert orders(errors).min() > 1.9


@pytest.mark.parametrize("riemann", GENERAL, ids=name_of)
def test_the_generic_matrix_product_gives_second_order_on_a_nonlinear_system(riemann):
    def initial(x):
        rho = 1.0 + 0.2 * np.sin(2.0 * np.pi * x)
        return np.array([rho, rho * (0.3 + 0.2 * np.cos(2.0 * np.pi * x))])

    states = {}
    for cells in (50, 100, 200, 400):
        problem = fv.Problem(PSystem(), fv.Grid(0.0, 1.0, cells), initial, 0.2, boundary=fv.Periodic())
        states[cells] = solve(problem, fv.WavePropagation(riemann, fv.NoLimiter())).q[-1]
    differences = [np.abs(states[n] - coarsen(states[2 * n])).mean() for n in (50, 100, 200)]
    assert orders(differences).min() > 1.9


def test_the_generic_matrix_product_is_the_jacobian_times_a_small_vector():
    model, rng = PSystem(2.0), np.random.default_rng(1)
    ql, qr = rng.uniform(0.5, 2.0, (2, 2, 50))
    v = 1e-3 * rng.uniform(-1.0, 1.0, (2, 50))
    rho, m = 0.5 * (ql + qr)
    exact = np.array([v[1], (4.0 - (m / rho) ** 2) * v[0] + 2.0 * m / rho * v[1]])
    np.testing.assert_allclose(model.matrix_product(tuple(ql), tuple(qr), (), (), tuple(v)), exact, atol=1e-8)


def test_observables_of_a_user_model_are_its_components():
    problem = fv.Problem(PSystem(), fv.Grid(0.0, 1.0, 4), np.ones((2, 4)), 0.1)
    assert list(solve(problem).observables()) == ["rho", "m"]


@pytest.mark.parametrize(("declared", "message"), [
    ({"conserved": "h"}, r"`conserved` of Mine must be a tuple of names .* write \('h',\)"),
    ({"conserved": ("h", "m"), "aux": "b"}, r"`aux` of Mine must be a tuple of names .* write \('b',\)"),
    ({"conserved": ("h", "m"), "phases": ((0, 1),)}, r"`phases` of Mine must be a tuple of phases.* got \(\(0, 1\),\)"),
    ({"conserved": ("h", "m"), "phases": (((0,), 2),)}, "with rows below 2"),
    ({"conserved": ("h", "m"), "phases": (((), 1),)}, "`phases` of Mine"),
])
def test_what_a_model_declares_is_checked_where_it_is_written(declared, message):
    with pytest.raises(TypeError, match=message):
        type("Mine", (fv.Model,), declared)


def test_a_parameter_without_decorator_is_refused_by_name():
    class Fast(PlainBurgers):
        factor: float = 2.0

    for arguments in ({}, {"factor": 3.0}):
        with pytest.raises(TypeError, match=r"Fast has parameters \(factor\) but no decorator: write @attrs.frozen"):
            Fast(**arguments)


@attrs.frozen
class Water(fv.Model):
    """Shallow water over a bottom, whose jump vanishes at rest."""

    conserved, aux, phases = ("h", "h v"), ("b",), (fv.Phase((0,), 1),)

    def flux(self, q):
        h, m = q
        return m, m * m / h + 5.0 * h * h

    def wave_speeds(self, q):
        h, m = q
        return m / h - np.sqrt(10.0 * h), m / h + np.sqrt(10.0 * h)

    def jump(self, ql, qr, auxl, auxr):
        (hl, ml), (hr, mr) = ql, qr
        return mr - ml, mr * mr / hr - ml * ml / hl + 5.0 * (hl + hr) * ((hr - hl) + (auxr[0] - auxl[0]))

    def cross(self, ql, qr, auxl, auxr):
        push = 10.0 * (qr[1] - ql[1]) * (auxr[0] - auxl[0])
        return 0.0 * push, push


class Level(Water):
    """The same, with a difference that vanishes at rest."""

    def balanced_difference(self, ql, qr, auxl, auxr):
        return (qr[0] - ql[0]) + (auxr[0] - auxl[0]), qr[1] - ql[1]


BOTTOMS = {"step": np.where(np.arange(40) < 20, 0.0, 0.5), "rough": 0.5 * np.random.default_rng(3).random(40), "flat": np.full(40, 0.3)}


@pytest.mark.parametrize("scheme", [fv.WavePropagation, lambda riemann: fv.WavePropagation(riemann, order=1), fv.MethodOfLines])
@pytest.mark.parametrize("riemann", GENERAL, ids=name_of)
@pytest.mark.parametrize("bottom", BOTTOMS)
def test_a_lake_that_a_viscosity_moves_is_warned_of(bottom, riemann, scheme):
    b = BOTTOMS[bottom]

    def moved(model):
        problem = fv.Problem(model, fv.Grid(0.0, 1.0, 40), np.stack([2.0 - b, 0.0 * b]), 0.1, {"b": b}, fv.Wall())
        return np.abs(fv.solve(problem, scheme(riemann), backend="numpy").q[-1, 1]).max()

    assert moved(Level()) < 1e-13
    if bottom == "flat":
        assert moved(Water()) < 1e-13
    else:
        with pytest.warns(RuntimeWarning, match="with a force at rest over a step of b, and no `balanced_difference`"):
            assert moved(Water()) > 1e-3


def test_the_suite_of_models_asks_for_a_balanced_difference():
    def suite(model):
        return type("OfWater", (fv.testing.ModelConformance,), {"model": model, "states": lambda self, rng, count: rng.uniform(1.0, 2.0, (2, count))})()

    suite(Level()).test_no_viscosity_moves_what_is_at_rest_over_a_step()
    with pytest.raises(AssertionError, match="define `balanced_difference`, 0 at rest"):
        suite(Water()).test_no_viscosity_moves_what_is_at_rest_over_a_step()
