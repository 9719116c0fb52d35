"""Laws that depend on x: flux(q, aux) and wave_speeds(q, aux), with every solver and scheme, on both backends."""

import warnings
from itertools import pairwise

import attrs
import numpy as np
import pytest

import fvkit as fv
import fvkit_granular as gr
from fvkit.problem import answers
from fvkit.testing import ModelConformance
from fvkit.testing.common import BACKENDS


class Transport(fv.Model):
    """q_t + (u(x) q)_x = 0."""

    conserved = ("q",)
    aux = ("u",)

    def flux(self, q, aux):
        return (aux[0] * q[0],)

    def wave_speeds(self, q, aux):
        return aux[0], aux[0]

    def decompose(self, ql, qr, auxl, auxr, jump):
        return (jump,), (0.5 * (auxl[0] + auxr[0]),)


class Colour(Transport):
    """q_t + u(x) q_x = 0."""

    def jump(self, ql, qr, auxl, auxr):
        return (0.5 * (auxl[0] + auxr[0]) * (qr[0] - ql[0]),)

    def cross(self, ql, qr, auxl, auxr):
        return (0.5 * (auxl[0] * auxl[0] - auxr[0] * auxr[0]) * (qr[0] - ql[0]),)


class Layers(fv.Model):
    """Nonlinear elasticity: eps_t - (m/rho)_x = 0, m_t - (K eps + 0.3 K^2 eps^2)_x = 0."""

    conserved = ("eps", "m")
    aux = ("rho", "K")

    def flux(self, q, aux):
        (eps, m), (rho, k) = q, aux
        return -m / rho, -(k * eps + 0.3 * k * k * eps * eps)

    def wave_speeds(self, q, aux):
        c = self.sound(q, aux)
        return -c, c

    def sound(self, q, aux):
        return np.sqrt((aux[1] + 0.6 * aux[1] * aux[1] * q[0]) / aux[0])

    def decompose(self, ql, qr, auxl, auxr, jump):
        left, right = self.sound(ql, auxl), self.sound(qr, auxr)
        zl, zr = auxl[0] * left, auxr[0] * right
        first = (jump[1] + zr * jump[0]) / (zl + zr)
        second = jump[0] - first
        return ((first, zl * first), (second, -zr * second)), (-left, right)

    def wall_signs(self):
        return 1.0, -1.0


class Sound(fv.Model):
    """Acoustics of a medium that varies, p_t + K u_x = 0, u_t + p_x/rho = 0, without a flux."""

    conserved = ("p", "u")
    aux = ("K", "rho")

    def flux(self, q, aux):
        return aux[0] * q[1], q[0] / aux[1]

    def wave_speeds(self, q, aux):
        c = np.sqrt(aux[0] / aux[1])
        return -c, c

    def jump(self, ql, qr, auxl, auxr):
        return 0.5 * (auxl[0] + auxr[0]) * (qr[1] - ql[1]), 2.0 * (qr[0] - ql[0]) / (auxl[1] + auxr[1])


class WithCross(Sound):
    """The same with the term of second order, -A_a da G."""

    def cross(self, ql, qr, auxl, auxr):
        first, second = self.jump(ql, qr, auxl, auxr)
        return (auxl[0] - auxr[0]) * second, first * (1.0 / auxl[1] - 1.0 / auxr[1])


def u(x):
    return 1.0 + 0.5 * np.sin(2.0 * np.pi * x)


def k(x):
    return 1.0 + 0.4 * np.cos(2.0 * np.pi * x)


def rho(x):
    return 1.0 + 0.3 * np.sin(2.0 * np.pi * x)


CASES = {"transport": (Transport(), {"u": u}), "colour": (Colour(), {"u": u}), "layers": (Layers(), {"rho": rho, "K": k}),
         "sound": (WithCross(), {"rho": rho, "K": k})}


def wave(model):
    return lambda x: np.stack([0.1 * (1.0 + 0.5 * np.sin(2.0 * np.pi * (x + 0.3 * row))) for row in range(len(model.conserved))])


def order(model, aux, scheme, cells=(40, 80, 160)):
    ends = [fv.solve(fv.Problem(model, fv.Grid(0.0, 1.0, n), wave(model), 0.4, aux, fv.Periodic()), scheme, backend="numpy").q[-1] for n in cells]
    apart = [np.abs(a - 0.5 * (b[:, ::2] + b[:, 1::2])).mean() for a, b in pairwise(ends)]
    return np.log2(apart[-2] / apart[-1])


@pytest.mark.parametrize("riemann", [fv.HLL(), fv.Rusanov(), fv.Roe()], ids=lambda one: type(one).__name__)
@pytest.mark.parametrize(("model", "aux"), CASES.values(), ids=CASES)
def test_every_solver_reaches_its_order(model, aux, riemann):
    if not riemann.serves(model):
        pytest.skip("no decompose")
    if isinstance(riemann, fv.Roe) and model.defines("jump"):
        pytest.skip("decompose is that of the flux")
    assert order(model, aux, fv.WavePropagation(riemann, fv.NoLimiter())) > 1.85
    assert order(model, aux, fv.MethodOfLines(riemann, integrator=fv.DP5())) > 4.3


@pytest.mark.parametrize("backend", BACKENDS)
@pytest.mark.parametrize(("model", "aux"), CASES.values(), ids=CASES)
def test_backends_agree_and_the_rate_is_that_of_the_scheme(model, aux, backend):
    for boundary in (fv.Periodic(), fv.Outflow()):
        problem = fv.Problem(model, fv.Grid(0.0, 1.0, 60), wave(model), 0.3, aux, boundary)
        for scheme in (fv.WavePropagation(fv.HLL()), fv.MethodOfLines(fv.Rusanov())):
            ends = [fv.solve(problem, scheme, backend=one).q[-1] for one in ("numpy", backend)]
            np.testing.assert_allclose(*ends, atol=1e-12)
        rate = fv.rhs(problem, fv.WavePropagation(fv.HLL(), order=1))(0.0, problem.q0)
        assert np.isfinite(rate).all()
        assert rate.any()


def test_what_is_conserved_stays():
    for model, aux in (CASES["transport"], CASES["layers"]):
        problem = fv.Problem(model, fv.Grid(0.0, 1.0, 80), wave(model), 1.0, aux, fv.Periodic())
        for scheme in (None, fv.MethodOfLines(fv.HLL())):
            np.testing.assert_allclose(fv.solve(problem, scheme, backend="numpy").q[-1].sum(axis=1), problem.q0.sum(axis=1), rtol=1e-12)


def test_transport_through_a_jump_of_the_speed_keeps_the_flux():
    """q is 2 where u is 1 and 1 where u is 2."""
    grid = fv.Grid(0.0, 1.0, 100)
    problem = fv.Problem(Transport(), grid, lambda x: np.where(x < 0.2, 2.0, 0.0)[None], 0.6, {"u": lambda x: np.where(x < 0.5, 1.0, 2.0)},
                         (fv.Inflow([2.0]), fv.Outflow()))
    for riemann in (fv.Roe(), fv.HLL()):
        q = fv.solve(problem, fv.WavePropagation(riemann), backend="numpy").q[-1][0]
        np.testing.assert_allclose(q[:48], 2.0, rtol=1e-10)
        np.testing.assert_allclose(q[52:80], 1.0, rtol=1e-6)


def test_colour_stays_between_its_values():
    problem = fv.Problem(Colour(), fv.Grid(0.0, 1.0, 200), lambda x: np.where(np.abs(x - 0.4) < 0.15, 1.0, 0.0)[None], 0.5, {"u": u}, fv.Periodic())
    q = fv.solve(problem, fv.WavePropagation(fv.HLL()), backend="numpy").q[-1]
    assert -0.01 < q.min() <= q.max() < 1.01


def test_the_first_step_and_the_speeds_know_aux():
    problem = fv.Problem(Transport(), fv.Grid(0.0, 1.0, 50), np.ones((1, 50)), 1.0, {"u": lambda x: np.where(x < 0.5, 1.0, 8.0)})
    assert fv.Stepper(problem, backend="numpy").dt == pytest.approx(0.9 * 0.02 / 8.0)
    assert fv.solve(problem, backend="numpy").stats.rejected == 0
    fv.solve(problem, backend="numpy").plot(kind="speeds")


def test_walls_of_a_medium():
    problem = fv.Problem(Layers(), fv.Grid(0.0, 1.0, 80), wave(Layers()), 1.0, {"rho": rho, "K": k}, fv.Wall())
    end = fv.solve(problem, backend="numpy").q[-1]
    assert end[0].sum() == pytest.approx(problem.q0[0].sum(), rel=1e-3)


def test_what_takes_aux_is_decided_with_the_class():
    assert Transport.takes_aux == {"flux", "wave_speeds"}
    assert fv.Burgers.takes_aux == frozenset()

    @attrs.frozen
    class Scaled(fv.Model):
        conserved = ("q",)

        def flux(self, q, power=2):
            return (q[0] ** power,)

        def wave_speeds(self, q):
            return 2.0 * q[0], 2.0 * q[0]

    assert Scaled.takes_aux == frozenset()
    assert answers.flux(Scaled(), (3.0,), ()) == (9.0,)
    with pytest.raises(TypeError, match=r"`wave_speeds` of Wrong must be wave_speeds\(self, q\), or wave_speeds\(self, q, aux\)"):
        type("Wrong", (fv.Model,), {"flux": Transport.flux, "wave_speeds": lambda self, q, aux, more: (0.0, 0.0)})


def test_a_mass_whose_flux_depends_on_aux_is_refused():
    class Channel(fv.Model):
        conserved = ("A", "Q")
        aux = ("w",)
        phases = (((0,), 1),)

        def flux(self, q, aux):
            return q[1], q[1] * q[1] / q[0] + 0.5 * 9.81 * q[0] * q[0] / aux[0]

        def wave_speeds(self, q, aux):
            c, v = np.sqrt(9.81 * q[0] / aux[0]), q[1] / q[0]
            return v - c, v + c

    class Wrong(Channel):
        def flux(self, q, aux):
            return aux[0] * q[1], q[1] * q[1] / q[0]

    def problem(model):
        return fv.Problem(model, fv.Grid(0.0, 1.0, 40), lambda x: np.stack([1.0 + 0.2 * np.sin(6.28 * x), 0.0 * x]), 0.05, {"w": 2.0}, fv.Wall())

    for scheme in (fv.WavePropagation(fv.HLL()), fv.MethodOfLines(fv.HLL())):
        assert abs(fv.solve(problem(Channel()), scheme, backend="numpy").stats.mass_drift["A"]) < 1e-14
    with pytest.raises(ValueError, match="the flux of the mass A must depend on q alone"):
        problem(Wrong())


class TestTransport(ModelConformance):
    model = Transport()

    def states(self, rng, count):
        return rng.uniform(0.5, 2.0, (1, count))

    def aux(self, rng, count):
        return rng.uniform(0.5, 2.0, (1, count))


class TestLayers(ModelConformance):
    model = Layers()

    def states(self, rng, count):
        return rng.uniform(-0.2, 0.2, (2, count))

    def aux(self, rng, count):
        return rng.uniform(0.5, 2.0, (2, count))


# ---------------------------------------------------------------------- what second order needs

def test_a_jump_without_its_cross_term_is_first_order_and_says_so():
    aux = {"rho": rho, "K": k}
    with pytest.warns(RuntimeWarning, match=r"Sound defines a `jump`.*no `cross`.*first order.*Define `cross\(ql, qr, auxl, auxr\)`.*`matrix_product`"):
        assert order(Sound(), aux, fv.WavePropagation(fv.HLL(), fv.NoLimiter())) < 1.5
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        for scheme in (fv.WavePropagation(fv.HLL(), order=1), fv.WavePropagation(fv.HLL(), cross_term=False), fv.MethodOfLines(fv.HLL())):
            fv.Stepper(fv.Problem(Sound(), fv.Grid(0.0, 1.0, 20), wave(Sound()), 0.4, aux, fv.Periodic()), scheme, backend="numpy")
        uniform = fv.Problem(Sound(), fv.Grid(0.0, 1.0, 20), wave(Sound()), 0.4, {"rho": 2.0, "K": 3.0}, fv.Periodic())
        fv.Stepper(uniform, fv.WavePropagation(fv.HLL()), backend="numpy")


class Products(fv.Model):
    """u_t + u u_x + w w_x = 0, w_t + u w_x = 0: products that are no flux, and a matrix from the jump alone."""

    conserved = ("u", "w")

    def flux(self, q):
        return 0.5 * (q[0] * q[0] + q[1] * q[1]), q[0] * q[1]

    def wave_speeds(self, q):
        return q[0] - 0.0 * q[1], q[0] + 0.0 * q[1]

    def jump(self, ql, qr, auxl, auxr):
        mean = 0.5 * (ql[0] + qr[0])
        return mean * (qr[0] - ql[0]) + 0.5 * (qr[1] * qr[1] - ql[1] * ql[1]), mean * (qr[1] - ql[1])


class Said(Products):
    def cross(self, ql, qr, auxl, auxr):
        first, second = self.jump(ql, qr, auxl, auxr)
        return 0.0 * first, first * (qr[1] - ql[1]) - (qr[0] - ql[0]) * second


def test_products_need_a_cross_term():
    scheme = fv.WavePropagation(fv.HLL(), fv.NoLimiter())
    with pytest.warns(RuntimeWarning, match="Products defines a `jump`"):
        without = order(Products(), {}, scheme, (80, 160, 320))
    assert without < 1.6 < 1.85 < order(Said(), {}, scheme, (80, 160, 320))


def test_a_conservation_law_with_a_jump_of_its_own_needs_none():
    class Own(fv.Burgers):
        def jump(self, ql, qr, auxl, auxr):
            return (0.5 * (ql[0] + qr[0]) * (qr[0] - ql[0]),)

    problem = fv.Problem(Own(), fv.Grid(0.0, 1.0, 20), wave(fv.Burgers()), 0.1, boundary=fv.Periodic())
    fv.Stepper(problem, fv.WavePropagation(fv.HLL()), backend="numpy")


def test_the_suite_finds_a_cross_term_that_is_missing():
    class NoCross(gr.TwoPhase):
        cross = fv.Model.cross

    class Suite(ModelConformance):
        model = NoCross()

        def states(self, rng, count):
            return self.model.conserved_from(rng.uniform(0.8, 1.2, count), rng.uniform(0.4, 0.6, count), rng.uniform(-0.2, 0.2, count), 0.1)

    suite = Suite()
    with pytest.warns(RuntimeWarning, match="NoCross defines a `jump`"), pytest.raises(AssertionError, match="observed order"):
        suite.test_second_order_of_larger_waves()
    suite.model = gr.TwoPhase()
    suite.test_second_order_of_larger_waves()


# ---------------------------------------------------------------------- PyClaw

def colour(ql, qr, auxl, auxr, data):
    """PyClaw's colour equation, whose speed stands in aux."""
    wave, speed = (qr - ql)[:, None, :], 0.5 * (auxl[:1] + auxr[:1])
    return wave, speed, np.minimum(speed, 0.0) * wave[:, 0], np.maximum(speed, 0.0) * wave[:, 0]


class Nothing(fv.Model):
    """Says names and speeds, and a flux that is none."""

    conserved = ("q",)
    aux = ("u",)

    def flux(self, q):
        return (0.0 * q[0],)

    def wave_speeds(self, q, aux):
        return aux[0], aux[0]


class OnlyJump(Nothing):
    def jump(self, ql, qr, auxl, auxr):
        return (0.5 * (auxl[0] + auxr[0]) * (qr[0] - ql[0]),)


@pytest.mark.parametrize("model", [Nothing(), OnlyJump()])
def test_a_solver_of_pyclaw_without_a_matrix_is_first_order_and_says_so(model):
    def problem(cells):
        return fv.Problem(model, fv.Grid(0.0, 1.0, cells), lambda x: np.where(np.abs(x - 0.4) < 0.15, 1.0, 0.0)[None], 0.5, {"u": u}, fv.Periodic())

    with pytest.warns(RuntimeWarning, match="does not define the matrix of PyClawRiemann.*at first order"):
        solution = fv.solve(problem(200), fv.WavePropagation(fv.PyClawRiemann(colour)))
    assert -1e-12 < solution.q[-1].min() <= solution.q[-1].max() < 1.0 + 1e-12
    same = fv.solve(fv.Problem(Colour(), fv.Grid(0.0, 1.0, 200), problem(200).q0, 0.5, {"u": u}, fv.Periodic()),
                    fv.WavePropagation(fv.HLL(), order=1), backend="numpy")
    np.testing.assert_allclose(solution.q[-1], same.q[-1], atol=1e-10)


def test_a_solver_of_pyclaw_on_a_model_that_knows_its_flux():
    def conservative(ql, qr, auxl, auxr, data):
        return (auxr * qr - auxl * ql)[:, None, :], 0.5 * (auxl[:1] + auxr[:1]), 0.0, 0.0

    scheme = fv.WavePropagation(fv.PyClawRiemann(conservative, fwave=True), fv.NoLimiter())
    assert order(Transport(), {"u": u}, scheme) > 1.85
