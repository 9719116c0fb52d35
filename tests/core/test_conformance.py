"""The conformance suites on the framework's own parts, and on parts of a user."""

import attrs
import numpy as np
import pytest

import fvkit as fv
import fvkit.testing
from fvkit.testing import LimiterConformance, ModelConformance, RiemannConformance
from fvkit.testing.common import Suite
from tests.cases import PSystem, Traffic


class TestAdvection(ModelConformance):
    model = fv.Advection(-1.5)

    def states(self, rng, count):
        return rng.uniform(-1.0, 1.0, (1, count))


class TestBurgers(ModelConformance):
    model = fv.Burgers()

    def states(self, rng, count):
        return rng.uniform(0.5, 2.0, (1, count))


class TestAcoustics(ModelConformance):
    model = fv.Acoustics(rho=2.0, bulk=3.0)

    def states(self, rng, count):
        return rng.uniform(-1.0, 1.0, (2, count))


class TestTraffic(ModelConformance):
    model = Traffic(limit=1.3)

    def states(self, rng, count):
        return rng.uniform(0.1, 0.4, (1, count))


class TestIsothermalGas(ModelConformance):
    model = PSystem(c=1.2)

    def states(self, rng, count):
        return np.stack([rng.uniform(0.5, 2.0, count), rng.uniform(-0.5, 0.5, count)])


@attrs.frozen
class AwRascleZhang(fv.Model):
    """Traffic whose waves steepen to shocks well before they have crossed the interval."""

    conserved = ("rho", "y")

    def flux(self, q):
        v = q[1] / q[0] - q[0] * q[0]
        return q[0] * v, q[1] * v

    def wave_speeds(self, q):
        v = q[1] / q[0] - q[0] * q[0]
        return v - 2.0 * q[0] * q[0], v


class TestWavesThatSteepen(ModelConformance):
    model = AwRascleZhang()

    def states(self, rng, count):
        rho, v = rng.uniform(0.2, 0.9, count), rng.uniform(0.2, 1.0, count)
        return np.stack([rho, rho * (v + rho * rho)])


class TestMC(LimiterConformance):
    limiter = fv.MC()


class TestMinmod(LimiterConformance):
    limiter = fv.Minmod()


class TestSuperbee(LimiterConformance):
    limiter = fv.Superbee()


class TestVanLeer(LimiterConformance):
    limiter = fv.VanLeer()


class TestNoLimiter(LimiterConformance):
    limiter, monotone = fv.NoLimiter(), False


class TestThirdOrder(LimiterConformance):
    """Its caps depend on nu, and go beyond 2."""

    limiter, monotone = fv.ThirdOrder(), False


def gas(q_l, q_r, aux_l, aux_r, problem_data):
    """Roe's solver of the isothermal gas in PyClaw's form, written for this test."""
    c = problem_data["c"]
    root_l, root_r = np.sqrt(q_l[0]), np.sqrt(q_r[0])
    u = (q_l[1] / root_l + q_r[1] / root_r) / (root_l + root_r)
    d_rho, d_m = q_r[0] - q_l[0], q_r[1] - q_l[1]
    first = ((u + c) * d_rho - d_m) / (2.0 * c)
    second = d_rho - first
    wave = np.empty((2, 2, q_l.shape[1]))
    wave[:, 0], wave[:, 1] = (first, first * (u - c)), (second, second * (u + c))
    s = np.array([u - c, u + c])
    amdq = sum(np.minimum(s[k], 0.0) * wave[:, k] for k in range(2))
    apdq = sum(np.maximum(s[k], 0.0) * wave[:, k] for k in range(2))
    return wave, s, amdq, apdq


class TestPyClawAdapter(RiemannConformance):
    model = PSystem(c=1.2)
    riemann = fv.PyClawRiemann(gas, {"c": 1.2})
    states = TestIsothermalGas.states


@attrs.frozen
class Upwind(fv.RiemannSolver):
    """A user's own solver for scalar laws: one wave, at the speed of the jump."""

    def solve(self, model, ql, qr, auxl, auxr, jump):
        change = qr[0] - ql[0]
        low, _ = model.wave_speeds(ql)
        return (jump,), (fv.where(change == 0.0, low, jump[0] / fv.where(change == 0.0, 1.0, change)),)


class TestOwnSolver(RiemannConformance):
    model, riemann, states = fv.Burgers(), Upwind(), TestBurgers.states


def test_a_solver_in_pyclaws_form_gives_the_dam_break_of_a_gas_as_hll_does():
    def start(x):
        return np.stack([np.where(x < 0.5, 2.0, 1.0), 0.0 * x])

    problem = fv.Problem(PSystem(c=1.2), fv.Grid(0.0, 1.0, 200), start, 0.15)
    adapted, own = (fv.solve(problem, fv.WavePropagation(solver)) for solver in (TestPyClawAdapter.riemann, fv.HLL()))
    assert adapted.stats.backend == "numpy"
    assert np.abs(adapted.q[-1] - own.q[-1]).mean() < 2e-3


def test_the_adapter_names_what_cannot_work():
    with pytest.raises(TypeError, match="`function` must be a Riemann solver"):
        fv.PyClawRiemann("roe")
    problem = fv.Problem(PSystem(), fv.Grid(0.0, 1.0, 20), np.ones((2, 20)), 0.1)
    pytest.importorskip("numba")
    with pytest.raises(ValueError, match="needs whole arrays"):
        fv.solve(problem, fv.WavePropagation(TestPyClawAdapter.riemann), backend="numba")


@attrs.frozen
class Wrong(fv.Model):
    """Its speeds are too small by half."""

    conserved = ("u",)

    def flux(self, q):
        return (q[0] * q[0],)

    def wave_speeds(self, q):
        return 0.5 * q[0], 0.5 * q[0]


#: No test class of this module: it must fail.
LYING = type("Lying", (ModelConformance,), {"model": Wrong(), "states": TestBurgers.states})


def test_a_model_that_lies_is_caught_and_pytest_shows_the_values():
    with pytest.raises(AssertionError, match=r"where .* all"):
        LYING().test_speeds_bound_the_derivative_of_the_jump()


def test_a_suite_runs_without_pytest_and_names_what_failed_or_was_skipped():
    outcome = fvkit.testing.run(TestMinmod)
    assert len(outcome.passed) == 4
    assert str(outcome) == "4 checks passed, 0 skipped"
    outcome = fvkit.testing.run(TestNoLimiter)
    assert outcome.skipped == {"test_it_lies_in_the_region_without_new_extrema": "NoLimiter is said not to be monotone"}
    with pytest.raises(AssertionError, match=r"(?s)Lying: \d of \d+ checks failed.*test_speeds_bound_the_derivative_of_the_jump: Asser"):
        fvkit.testing.run(LYING)


def test_a_suite_calls_a_check_for_each_of_its_parameters():
    class Two(Suite):
        """A suite of one check with two parameters, of which one call fails, without a message."""

        @pytest.mark.parametrize("a", [1, 2])
        @pytest.mark.parametrize("b", [3, 4])
        def test_sum(self, a, b):
            if a + b == 6:
                raise KeyError

    with pytest.raises(AssertionError, match=r"1 of 4 checks failed\n  test_sum\[4\]\[2\]: KeyError: raise KeyError"):
        fvkit.testing.run(Two)


@pytest.mark.parametrize(("given", "message"), [(TestMinmod(), "must be the class"), (fv.Minmod, "subclass of a suite"), ("mine", "the class")])
def test_what_is_no_suite_is_refused(given, message):
    with pytest.raises(TypeError, match=message):
        fvkit.testing.run(given)


def test_mistakes_of_a_suite_are_named_where_they_are_made():
    with pytest.raises(TypeError, match=r"`model of Mine` must be an instance of Model, got the class Burgers: write Burgers\(\)"):
        type("Mine", (ModelConformance,), {"model": fv.Burgers})
    with pytest.raises(TypeError, match="Mine must set `riemann`"):
        fvkit.testing.run(type("Mine", (RiemannConformance,), {"model": fv.Burgers()}))
    flat = type("Mine", (ModelConformance,), {"model": fv.Burgers(), "states": lambda self, rng, count: rng.uniform(1.0, 2.0, count)})
    with pytest.raises(ValueError, match=r"`states\(rng, count\)` must have shape \(1, 200\), got \(200,\)"):
        flat().drawn(1)
