"""Fluxes that are not convex: entropy solutions, from the hull of the flux, with the natural speeds of a model."""

from itertools import pairwise

import attrs
import numpy as np
import pytest

import fvkit as fv
from fvkit.problem import answers
from fvkit.schemes.background import Scanning
from fvkit.schemes.fitting import assemble
from fvkit.testing.common import BACKENDS


class BuckleyLeverett(fv.Model):
    """s_t + f(s)_x = 0, f = s^2/(s^2 + (1 - s)^2/2): both end states of 1 | 0 stand still."""

    conserved = ("s",)

    def flux(self, q):
        (s,) = q
        return (s * s / (s * s + 0.5 * (1.0 - s) ** 2),)

    def wave_speeds(self, q):
        (s,) = q
        below = s * s + 0.5 * (1.0 - s) ** 2
        return s * (1.0 - s) / (below * below), s * (1.0 - s) / (below * below)


@attrs.frozen
class Polynomial(fv.Model):
    """u_t + (u^3 - a u)_x = 0."""

    conserved = ("u",)

    a: float = 0.0

    def flux(self, q):
        (u,) = q
        return (u * u * u - self.a * u,)

    def wave_speeds(self, q):
        (u,) = q
        return 3.0 * u * u - self.a, 3.0 * u * u - self.a


class WithRoe(Polynomial):
    """The same with a Roe decomposition."""

    def decompose(self, ql, qr, auxl, auxr, jump):
        (a,), (b,) = ql, qr
        return (jump,), (a * a + a * b + b * b - self.a,)


class Sine(fv.Model):
    """u_t + (sin u)_x = 0."""

    conserved = ("u",)

    def flux(self, q):
        return (np.sin(q[0]),)

    def wave_speeds(self, q):
        return np.cos(q[0]), np.cos(q[0])


class TwoWells(fv.Model):
    """u_t + (u^4 - u^2)_x = 0: fans on both sides of a shock that stands between the bottoms of both wells."""

    conserved = ("u",)

    def flux(self, q):
        (u,) = q
        return (u * u * (u * u - 1.0),)

    def wave_speeds(self, q):
        (u,) = q
        return 4.0 * u * u * u - 2.0 * u, 4.0 * u * u * u - 2.0 * u


def entropy_solution(model, left, right, xi):
    """The state at x/t = xi: where f(u) - xi u is least between the states, or largest where the right one is below."""
    u = np.linspace(min(left, right), max(left, right), 20001)
    over = np.asarray(model.flux((u,))[0]) - xi[:, None] * u
    return u[np.argmin(over, axis=1) if left < right else np.argmax(over, axis=1)]


CASES = {
    "Buckley-Leverett 1|0": (BuckleyLeverett(), 1.0, 0.0), "Buckley-Leverett 0|1": (BuckleyLeverett(), 0.0, 1.0),
    "cubic -1|1": (Polynomial(), -1.0, 1.0), "cubic 1|-1": (Polynomial(), 1.0, -1.0), "Roe, cubic -1|1": (WithRoe(), -1.0, 1.0),
    "both ways": (WithRoe(1.0), -1.2, 1.2), "both ways back": (WithRoe(1.0), 1.2, -1.2),
    "two wells": (TwoWells(), -1.0, 1.0), "two wells, uneven": (TwoWells(), -1.0, 0.9), "sine": (Sine(), 0.0, 6.0), "sine back": (Sine(), 6.0, -3.0),
}


def error(model, left, right, scheme, cells, backend="numpy", time=0.25):
    grid = fv.Grid(-1.0, 1.0, cells)
    problem = fv.Problem(model, grid, lambda x: np.where(x < 0.0, left, right)[None], time)
    solution = fv.solve(problem, scheme, backend=backend)
    reach = 0.03 * abs(right - left)
    assert min(left, right) - reach < solution.q[-1].min() <= solution.q[-1].max() < max(left, right) + reach
    return np.abs(solution.q[-1][0] - entropy_solution(model, left, right, grid.centers / time)).mean() / abs(right - left)


SCHEMES = {
    "order 1": lambda riemann: fv.WavePropagation(riemann, order=1), "order 2": lambda riemann: fv.WavePropagation(riemann),
    "MP5": lambda riemann: fv.MethodOfLines(riemann), "MUSCL": lambda riemann: fv.MethodOfLines(riemann, fv.MUSCL(), fv.SSPRK3()),
}


@pytest.mark.parametrize("made", SCHEMES.values(), ids=SCHEMES)
@pytest.mark.parametrize("riemann", [fv.HLL(), fv.Rusanov(), fv.Roe()], ids=lambda one: type(one).__name__)
@pytest.mark.parametrize(("model", "left", "right"), CASES.values(), ids=CASES)
def test_runs_converge_to_the_entropy_solution(model, left, right, riemann, made):
    if not riemann.serves(model):
        pytest.skip("no decompose")
    scheme = made(riemann)
    coarse, fine = (error(model, left, right, scheme, cells) for cells in (100, 400))
    assert fine < 0.65 * coarse
    assert fine < 0.005


@pytest.mark.parametrize("backend", BACKENDS)
def test_the_shock_of_buckley_and_leverett_has_its_speed(backend):
    """Tangent from (0, 0): f(s) = s f'(s) at s = 1/sqrt(3), speed (1 + sqrt(3))/2."""
    grid = fv.Grid(-0.2, 1.0, 600)
    problem = fv.Problem(BuckleyLeverett(), grid, lambda x: np.where(x < 0.0, 1.0, 0.0)[None], 0.5)
    for riemann in (fv.HLL(), fv.Rusanov()):
        solution = fv.solve(problem, fv.WavePropagation(riemann), backend=backend)
        front = grid.centers[np.flatnonzero(solution.q[-1][0] > 0.3)[-1]]
        assert front == pytest.approx(0.5 * 0.5 * (1.0 + np.sqrt(3.0)), abs=3.0 * grid.dx)
        assert solution.stats.rejected == 0


def test_speeds_between_are_what_the_model_says():
    class Said(BuckleyLeverett):
        def speeds_between(self, ql, qr):
            return 0.0 * ql[0], 2.2 + 0.0 * ql[0]

    class WithSides(Said):
        aux = ("a",)

        def speeds_between(self, ql, qr, auxl, auxr):
            return 0.0 * ql[0], 2.2 + auxl[0] + auxr[0]

    face = (np.ones(1),), (np.zeros(1),), (np.ones(1),), (np.ones(1),)
    assert answers.face_speeds(Said(), *face)[1] == 2.2
    assert answers.face_speeds(WithSides(), *face)[1] == 4.2
    assert answers.face_speeds(Scanning(BuckleyLeverett()), *face)[1] > 2.0
    assert error(Said(), 1.0, 0.0, fv.WavePropagation(fv.HLL()), 400) < 0.004


class Power(fv.Model):
    """u_t + (u^1.5)_x = 0, convex."""

    conserved = ("u",)

    def flux(self, q):
        return (q[0] * np.sqrt(q[0]),)

    def wave_speeds(self, q):
        return 1.5 * np.sqrt(q[0]), 1.5 * np.sqrt(q[0])


def test_what_is_convex_looks_at_both_sides_alone():
    for model, low, high in ((fv.Advection(1.0), -1.0, 2.0), (fv.Burgers(), -1.0, 2.0), (Power(), 0.0, 1.0), (Power(), 1.0, 1.0),
                             (Polynomial(), 1.0, 2.0)):
        problem = fv.Problem(model, fv.Grid(0.0, 1.0, 10), np.linspace(low, high, 10)[None], 1.0)
        assert assemble(problem, fv.WavePropagation(fv.HLL()))[1][0].model is problem.model
    for model, low, high in ((BuckleyLeverett(), 0.0, 1.0), (Polynomial(), 0.1, 0.4), (Sine(), 0.0, 6.0)):
        problem = fv.Problem(model, fv.Grid(0.0, 1.0, 10), np.linspace(low, high, 10)[None], 1.0)
        assert assemble(problem, fv.WavePropagation(fv.HLL()))[1][0].model.scans
        assert type(problem.model) is type(model)


@pytest.mark.parametrize("state", [[1.0], lambda t: [min(5.0 * t, 1.0)]])
def test_what_comes_in_counts(state):
    """Water floods a reservoir that is empty at the start: the entropy solution of 1 | 0 behind the inflow."""
    grid = fv.Grid(0.0, 1.0, 200)
    problem = fv.Problem(BuckleyLeverett(), grid, np.zeros((1, 200)), 0.5, boundary=(fv.Inflow(state), fv.Outflow()))
    solution = fv.solve(problem, fv.WavePropagation(fv.HLL()), backend="numpy", step=fv.Step(dt_max=0.01))
    assert -1e-3 < solution.q[-1].min() <= solution.q[-1].max() < 1.001
    late = 0.0 if not callable(state) else 0.2
    front = grid.centers[np.flatnonzero(solution.q[-1][0] > 0.3)[-1]]
    assert front == pytest.approx((0.5 - 0.5 * late) * 0.5 * (1.0 + np.sqrt(3.0)), abs=0.05)


def test_a_smooth_flow_is_second_order_whatever_the_flux():
    errors = []
    for cells in (50, 100, 200, 400):
        problem = fv.Problem(Polynomial(0.3), fv.Grid(0.0, 1.0, cells), lambda x: 0.2 * np.sin(2.0 * np.pi * x)[None], 0.2, boundary=fv.Periodic())
        errors.append(fv.solve(problem, fv.WavePropagation(fv.HLL(), fv.NoLimiter()), backend="numpy").q[-1])
    apart = [np.abs(a - 0.5 * (b[:, ::2] + b[:, 1::2])).mean() for a, b in pairwise(errors)]
    assert np.log2(apart[-2] / apart[-1]) > 1.8


def test_a_smooth_flow_keeps_the_order_of_the_method_of_lines():
    found = []
    for cells in (20, 40, 80, 160):
        problem = fv.Problem(Polynomial(0.3), fv.Grid(0.0, 1.0, cells), lambda x: 0.2 * np.sin(2.0 * np.pi * x)[None], 0.15, boundary=fv.Periodic())
        found.append(fv.solve(problem, fv.MethodOfLines(fv.HLL(), integrator=fv.DP5()), backend="numpy").q[-1])
    apart = [np.abs(a - 0.5 * (b[:, ::2] + b[:, 1::2])).mean() for a, b in pairwise(found)]
    assert np.log2(apart[-2] / apart[-1]) > 4.5


class Pair(fv.Model):
    """Buckley and Leverett with a tracer: a system, of which both sides are looked at alone."""

    conserved = ("s", "c s")

    def flux(self, q):
        s, tracer = q
        f = s * s / (s * s + 0.5 * (1.0 - s) ** 2)
        return f, tracer * s / (s * s + 0.5 * (1.0 - s) ** 2)

    def wave_speeds(self, q):
        (s, _), below = q, q[0] ** 2 + 0.5 * (1.0 - q[0]) ** 2
        own, carried = s * (1.0 - s) / (below * below), s / below
        return fv.minimum(own, carried), fv.maximum(own, carried)


def test_bounds_of_a_system_that_do_not_bound_are_a_warning():
    class Still(Pair):
        def wave_speeds(self, q):
            s, below = q[0], q[0] ** 2 + 0.5 * (1.0 - q[0]) ** 2
            return 0.0 * s, s * (1.0 - s) / (below * below)

    class Said(Still):
        def speeds_between(self, ql, qr):
            return 0.0 * ql[0], 2.5 + 0.0 * ql[0]

    def problem(model):
        return fv.Problem(model, fv.Grid(-1.0, 1.0, 50), lambda x: np.where(x < 0.0, 1.0, 0.0) * np.ones((2, 1)), 0.2)

    for riemann in (fv.HLL(), fv.Rusanov()):
        with pytest.warns(RuntimeWarning, match=r"Still: speeds of states between.*at x|Still.*x = .*Define `speeds_between\(ql, qr\)`"):
            fv.Stepper(problem(Still()), fv.WavePropagation(riemann), backend="numpy")
        ended = fv.solve(problem(Said()), fv.WavePropagation(riemann), backend="numpy")
        assert -0.01 < ended.q[-1].min() <= ended.q[-1].max() < 1.01


@pytest.mark.parametrize("states", ["q", "q, aux, more"])
def test_a_method_with_other_arguments_is_refused_when_the_class_is_made(states):
    with pytest.raises(TypeError, match=r"`flux` of Wrong must be flux\(self, q\), or flux\(self, q, aux\) where it depends on x, got flux\(self"):
        exec(f"class Wrong(fv.Model):\n    def flux(self{', ' + states if states != 'q' else ''}):\n        return q\n", {"fv": fv})


@pytest.mark.parametrize("backend", BACKENDS)
def test_backends_agree(backend):
    for model in (BuckleyLeverett(), WithRoe(1.0)):
        for scheme in (None, fv.MethodOfLines(fv.HLL())):
            problem = fv.Problem(model, fv.Grid(-1.0, 1.0, 60), lambda x: np.where(x < 0.0, 0.9, 0.1)[None], 0.2)
            ends = [fv.solve(problem, scheme, backend=one).q[-1] for one in ("numpy", backend)]
            np.testing.assert_allclose(*ends, atol=1e-12)
