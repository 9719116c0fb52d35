"""Parts that work but break a promise of their contract are refused before the first step, with a sentence."""

import attrs
import numpy as np
import pytest

import fvkit as fv
import fvkit_granular as gr
from fvkit.schemes.splitting import Unsplit

WAVES, LINES = fv.WavePropagation, fv.MethodOfLines


def problem(sources=()):
    return fv.Problem(fv.Advection(1.0), fv.Grid(0.0, 1.0, 20), lambda x: 1.0 + np.sin(6.28 * x)[None], 0.1,
                      boundary=fv.Periodic(), sources=sources)


def integrator(**tables):
    return type("Mine", (fv.Integrator,), tables)()


HEUN = {"alpha": ((1.0,), (0.5, 0.5)), "beta": ((1.0,), (0.0, 0.5))}


class Leaning(fv.Reconstruction):
    def right(self, a, b, c, d, e):
        return 1.001 * c + 0.25 * (d - b)


class Offset(fv.Reconstruction):
    def right(self, a, b, c, d, e):
        return c + 1e-4


class FarSighted(fv.Reconstruction):
    reach = 1

    def right(self, a, b, c, d, e):
        return c + 0.1 * (e - a)


class Dull(fv.Limiter):
    def phi(self, theta, nu):
        return fv.minimum(0.9, fv.maximum(0.0, theta))


class Unlimited(fv.Limiter):
    limits = False

    def phi(self, theta, nu):
        return fv.maximum(0.0, fv.minimum(1.0, theta))


class Loser(fv.Rusanov):
    def solve(self, model, ql, qr, auxl, auxr, jump):
        return (fv.pointwise.scale(0.4, jump), fv.pointwise.scale(0.5, jump)), (-1.0, 1.0)


@attrs.frozen
class Late(fv.Splitting):
    before = 0.5
    after = 1.0


class Jump(fv.Source):
    def step(self, model, q, aux, dt):
        return (1.01 * q[0],)

    def rate(self, model, q, aux):
        return (0.0 * q[0],)


INCONSISTENT = {
    "alpha adds up to 1.1": (LINES(fv.Roe(), integrator=integrator(**HEUN | {"alpha": ((1.0,), (0.5, 0.6))})), "row 1 of alpha of Mine"),
    "weights of Butcher's form": (LINES(fv.Roe(), integrator=integrator(alpha=((1.0,), (1.0,)), beta=((1.0,), (0.5, 0.4)))),
                                  "the time of the last state of Mine must add up to 1"),
    "a step of half dt": (LINES(fv.Roe(), integrator=integrator(alpha=((1.0,),), beta=((0.5,),))), "got 0.5"),
    "not a number": (LINES(fv.Roe(), integrator=integrator(alpha=((float("nan"),),), beta=((1.0,),))), "row 0 of alpha"),
    "too many Euler steps": (LINES(fv.Roe(), integrator=integrator(**HEUN, ssp=2.0)), "`ssp` of Mine must be at most alpha/beta"),
    "steps backwards": (LINES(fv.Roe(), integrator=integrator(alpha=((1.0,), (0.5, 0.5)), beta=((1.0,), (-0.1, 0.6)), ssp=0.5)), "`ssp`"),
    "a row too long": (LINES(fv.Roe(), integrator=integrator(alpha=((0.5, 0.5),), beta=((1.0,),))), "row 0 of the tables of Mine"),
    "rows that miss": (LINES(fv.Roe(), integrator=integrator(alpha=((1.0,), (1.0,)), beta=((1.0,),))), "as many rows each"),
    "implicit weights": (LINES(fv.Roe(), integrator=integrator(**HEUN, implicit=((0.0, 0.5),), weights=(0.5, 0.4))), "`weights` of Mine"),
    "a constant grows": (LINES(fv.Roe(), Leaning()), r"Leaning.right .*: must return the mean that five cells share, got .* where"),
    "a constant is shifted": (LINES(fv.Roe(), Offset()), "Offset.right"),
    "a wider stencil": (LINES(fv.Roe(), FarSighted()), "`reach` is 1"),
    "a limiter of first order": (WAVES(fv.Roe(), Dull()), r"Dull.phi .*: must be 1 for theta = 1"),
    "one of several limiters": (WAVES(fv.HLL(), (fv.MC(), Dull())), "Dull.phi"),
    "a limiter that says it is none": (WAVES(fv.Roe(), Unlimited()), "`limits` is False"),
    "waves that lose": (WAVES(Loser()), r"Loser.solve .*: the waves must add up to the jump"),
    "sources for 1.5 dt": (WAVES(fv.Roe(), splitting=Late()), "add up to 1, got 0.5 and 1"),
}


@pytest.mark.parametrize("name", INCONSISTENT)
def test_an_inconsistent_part_is_refused_before_the_run(name):
    scheme, sentence = INCONSISTENT[name]
    model = gr.scene("riemann").problem(gr.ShallowWater, 20) if "several" in name else problem()
    for start in (fv.Stepper, fv.solve, fv.rhs):
        with pytest.raises(ValueError, match=sentence):
            start(model, scheme)


def test_a_source_that_acts_in_no_time_is_refused():
    with pytest.raises(ValueError, match=r"Jump.step .*: must return the state for dt = 0, got .* where"):
        problem(Jump())


@pytest.mark.parametrize("kind", [fv.SSPRK3, fv.SSPRK104, fv.DP5, fv.ARK4])
def test_tables_of_our_own_are_consistent(kind):
    kind().check()


@pytest.mark.parametrize("splitting", [fv.Godunov(), fv.Strang(), Unsplit()])
def test_splittings_of_our_own_are_consistent(splitting):
    splitting.check()


def test_consistent_parts_of_ones_own_run():
    assert fv.solve(problem(), LINES(fv.Roe(), fv.MUSCL(), integrator(**HEUN, ssp=1.0))).success
