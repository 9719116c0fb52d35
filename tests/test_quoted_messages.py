"""Messages that the documents quote are those of the program."""

import warnings
from pathlib import Path

import numpy as np
import pytest

import fvkit as fv
import fvkit_granular as gr

DOCS = Path(__file__).parent.parent / "docs"


def sound(q_l, q_r, aux_l, aux_r, problem_data):
    """A solver of PyClaw's for sound whose speed is not that of `fv.Acoustics`."""
    wave, c = np.zeros((2, 2, q_l.shape[1])), problem_data["c"]
    (dp, du) = q_r - q_l
    wave[:, 0], wave[:, 1] = (0.5 * (dp - c * du), -0.5 * (dp - c * du) / c), (0.5 * (dp + c * du), 0.5 * (dp + c * du) / c)
    return wave, np.array([np.full_like(dp, -c), np.full_like(dp, c)]), None, None


def acoustics(**options):
    return fv.Problem(fv.Acoustics(), fv.Grid(-1.0, 1.0, 20), lambda x: [np.exp(-8.0 * x**2), 0.0 * x], 0.1, **options)


def slope(fall, **options):
    return gr.Scene((0.0, 100.0), 1.0, lambda x: {"h": 1.0, "phi": 0.5}, bottom=lambda x: -fall * x, **options).problem(gr.TwoPhase, 50)


def solved(problem, scheme=None, **options):
    return fv.solve(problem, scheme, backend="numpy", limits=fv.Limits(steps=3), throw=False, **options)


RAISED = {
    ("pyclaw.md", "`lower` must be a number, got (0, 0, 0)"): lambda: fv.Grid((0, 0, 0), (1, 1, 1), (4, 4, 4)),
    ("pyclaw.md", "`lower` must be a number, got [0.0, 0.1, 0.3]"): lambda: fv.Grid([0.0, 0.1, 0.3], 1.0, 2),
    ("pyclaw.md", "Problem.__init__() got an unexpected keyword argument 'capacity'"): lambda: acoustics(capacity=1.0),
    ("pyclaw.md", "WavePropagation.__init__() got an unexpected keyword argument 'cfl_max'"): lambda: fv.WavePropagation(fv.Roe(), cfl_max=1.0),
    ("pyclaw.md", "solve() got an unexpected keyword argument 'num_ghost'"): lambda: solved(acoustics(), num_ghost=2),
    ("pyclaw.md", "`limiter` must be an instance of Limiter, got 4 (such as fv.MC(), or a tuple of them)"):
        lambda: fv.WavePropagation(fv.Roe(), limiter=4),
    ("pyclaw.md", "`boundary` must be an instance of BoundaryCondition, got 'wall' (such as fv.Outflow())"):
        lambda: acoustics(boundary="wall"),
    ("pyclaw.md", "`riemann` must be an instance of RiemannSolver, got <function "): lambda: fv.WavePropagation(sound),
    ("pyclaw.md", "`sources` must be an instance of Source, got <function "): lambda: acoustics(sources=sound),
    ("pyclaw.md", "PyClawRiemann needs whole arrays: use backend='numpy' or 'auto', got 'numba'"):
        lambda: fv.solve(acoustics(), fv.WavePropagation(fv.PyClawRiemann(sound, {"c": 1.0})), backend="numba"),
    ("pyclaw.md", "MethodOfLines serves a grid with one axis, got one with two: take fv.WavePropagation"):
        lambda: solved(gr.scene("vortex").problem(gr.ShallowWater, 8), fv.MethodOfLines(fv.HLL())),
    ("pitfalls.md", "MethodOfLines has the equations for mild slopes only"): lambda: solved(slope(0.5), fv.MethodOfLines(fv.Roe())),
    ("pitfalls.md", "must be in [0, 1] (a fraction: 60 % is 0.6), got 60.0"):
        lambda: gr.Scene((0.0, 1.0), 1.0, lambda x: {"h": 1.0, "phi": 60.0}).problem(gr.TwoPhase, 50),
    ("pitfalls.md", "<= 5.67, got 30.0 (the tangent of the friction angle: tan(35 deg) = 0.70)"): lambda: gr.CoulombFriction(30.0),
    ("pitfalls.md", "> 0 and < 1, got 2.0 (density of the fluid over density of the solid)"):
        lambda: gr.Scene((0.0, 1.0), 1.0, lambda x: {"h": 1.0, "phi": 0.5}, gamma=2.0),
}
WARNED = {
    ("pyclaw.md", "Acoustics does not define the matrix of PyClawRiemann: the waves do not add up to its flux"):
        lambda: solved(acoustics(), fv.WavePropagation(fv.PyClawRiemann(sound, {"c": 2.0}))),
    ("pitfalls.md", "steepest slope 26.6 degrees:"): lambda: slope(0.5, slope="mild"),
    ("pitfalls.md", "has a cliff of 9.8 at the seam"): lambda: slope(0.1, boundary=fv.Periodic()),
    ("pitfalls.md", "characteristic speeds are complex from t = 0 on, first at x = 0.32, so far 1 m deep"):
        lambda: solved(gr.scene("lost-hyperbolicity").problem(gr.TwoPhase, 50)),
}


@pytest.mark.parametrize("quoted", [*RAISED, *WARNED], ids=lambda quoted: f"{quoted[0]}: {quoted[1][:30]}")
def test_the_page_quotes_it(quoted):
    page, message = quoted
    text = (DOCS / page).read_text(encoding="utf-8")
    assert message in text or message in text.replace("`", "")


@pytest.mark.parametrize("quoted", RAISED, ids=lambda quoted: quoted[1][:40])
def test_the_program_raises_it(quoted):
    if "'numba'" in quoted[1]:
        pytest.importorskip("numba")
    with pytest.raises((TypeError, ValueError)) as caught:
        RAISED[quoted]()
    assert quoted[1] in str(caught.value)


@pytest.mark.parametrize("quoted", WARNED, ids=lambda quoted: quoted[1][:40])
def test_the_program_warns_so(quoted):
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        WARNED[quoted]()
    assert any(quoted[1] in str(one.message) for one in caught)
