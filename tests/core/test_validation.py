"""Bad input to every public constructor and function is refused by name, with the value."""

import attrs
import numpy as np
import pytest

import fvkit as fv
import fvkit_granular as gr
from tests.cases import Stepper, solve

GRID = fv.Grid(0.0, 1.0, 5)


@attrs.frozen
class Sloped(fv.Burgers):
    aux = ("bottom", "width")


def problem(model=None, grid=GRID, initial=None, t_end=1.0, **options):
    return fv.Problem(fv.Burgers() if model is None else model, grid, np.ones((1, 5)) if initial is None else initial,
                      t_end, **options)


def water(q, **options):
    return fv.Problem(gr.ShallowWater(), GRID, q, 1.0, **options)


def spoiled(value, row=0, rows=1):
    q = np.ones((rows, 5))
    q[row, 3] = value
    return q


BAD = {
    "grid: reversed": (lambda: fv.Grid(1.0, 0.0, 5), ValueError, ["lower", "upper", "1", "0"]),
    "grid: empty": (lambda: fv.Grid(1.0, 1.0, 5), ValueError, ["lower", "upper", "1"]),
    "grid: nan": (lambda: fv.Grid(np.nan, 1.0, 5), ValueError, ["`lower`", "nan"]),
    "grid: infinite": (lambda: fv.Grid(0.0, np.inf, 5), ValueError, ["`upper`", "inf"]),
    "grid: no cells": (lambda: fv.Grid(0.0, 1.0, 0), ValueError, ["`num_cells`", "0"]),
    "grid: negative cells": (lambda: fv.Grid(0.0, 1.0, -3), ValueError, ["`num_cells`", "-3"]),
    "grid: half a cell": (lambda: fv.Grid(0.0, 1.0, 2.5), TypeError, ["`num_cells`", "2.5"]),
    "grid: true cells": (lambda: fv.Grid(0.0, 1.0, True), TypeError, ["`num_cells`", "True"]),
    "grid: text": (lambda: fv.Grid("0", 1.0, 5), TypeError, ["`lower`", "'0'"]),
    "grid: array": (lambda: fv.Grid(np.zeros(3), 1.0, 5), TypeError, ["`lower`"]),
    "problem: model class": (lambda: problem(fv.Burgers), TypeError, ["`model`", "write Burgers()"]),
    "problem: no model": (lambda: problem("burgers"), TypeError, ["`model`", "'burgers'"]),
    "problem: grid": (lambda: problem(grid=5), TypeError, ["`grid`", "5"]),
    "problem: t_end nan": (lambda: problem(t_end=np.nan), ValueError, ["`t_end`", "nan"]),
    "problem: t_end text": (lambda: problem(t_end="1"), TypeError, ["`t_end`", "'1'"]),
    "problem: t_end before start": (lambda: problem(t_end=1.0, t_start=2.0), ValueError, ["`t_end`", "1", "2"]),
    "problem: t_start infinite": (lambda: problem(t_start=-np.inf), ValueError, ["`t_start`", "inf"]),
    "problem: initial shape": (lambda: problem(initial=np.ones((2, 5))), ValueError, ["`initial`", "(1, 5)", "(2, 5)"]),
    "problem: initial flat": (lambda: problem(initial=np.ones(5)), ValueError, ["`initial`", "(1, 5)", "(5,)"]),
    "problem: initial nan": (lambda: problem(initial=spoiled(np.nan)), ValueError, ["`initial`", "nan", "(0, 3)"]),
    "problem: initial inf": (lambda: problem(initial=spoiled(-np.inf)), ValueError, ["`initial`", "inf", "(0, 3)"]),
    "problem: initial text": (lambda: problem(initial="sine"), TypeError, ["`initial`", "sine"]),
    "problem: function shape": (lambda: problem(initial=lambda x: x), ValueError, ["`initial(x)`", "(1, 25)", "(25,)"]),
    "problem: function nan": (
        lambda: problem(initial=lambda x: np.where(x > 0.5, np.nan, x)[None]),
        ValueError,
        ["`initial`", "nan"],
    ),
    "problem: negative depth": (
        lambda: water(spoiled(-0.5, rows=2)),
        ValueError,
        ["`initial`", "h", "-0.5", "cell 3", "0.7"],
    ),
    "problem: negative solid": (
        lambda: fv.Problem(gr.TwoPhase(), GRID, spoiled(-0.25, 0, 4), 1.0),
        ValueError,
        ["hs >= 0", "-0.25"],
    ),
    "problem: negative fluid": (
        lambda: fv.Problem(gr.TwoPhase(), GRID, spoiled(-0.25, 2, 4), 1.0),
        ValueError,
        ["hf >= 0", "-0.25"],
    ),
    "problem: unknown aux": (
        lambda: problem(Sloped(), aux={"botom": 1.0}),
        ValueError,
        ["aux", "'botom'", "did you mean bottom?"],
    ),
    "problem: aux of a model without": (lambda: problem(aux={"b": 1.0}), ValueError, ["aux", "'b'"]),
    "problem: aux no mapping": (lambda: problem(Sloped(), aux=[1.0]), TypeError, ["`aux`", "[1.0]"]),
    "problem: aux shape": (
        lambda: problem(Sloped(), aux={"width": np.ones(4)}),
        ValueError,
        ["aux['width']", "(5,)", "(4,)"],
    ),
    "problem: aux nan": (lambda: problem(Sloped(), aux={"width": np.nan}), ValueError, ["aux['width']", "nan"]),
    "problem: aux function": (
        lambda: problem(Sloped(), aux={"width": lambda x: x[None]}),
        ValueError,
        ["aux['width'](x)", "(25,)", "(1, 25)"],
    ),
    "problem: boundary class": (lambda: problem(boundary=fv.Outflow), TypeError, ["`boundary`", "write Outflow()"]),
    "problem: boundary text": (lambda: problem(boundary="wall"), TypeError, ["`boundary`"]),
    "problem: boundary pair": (lambda: problem(boundary=(fv.Outflow(), None)), TypeError, ["`boundary`", "None"]),
    "problem: three boundaries": (lambda: problem(boundary=[fv.Outflow()] * 3), ValueError, ["`boundary`", "3"]),
    "problem: one periodic side": (
        lambda: problem(boundary=(fv.Periodic(), fv.Outflow())),
        ValueError,
        ["periodic", "both sides", "Periodic", "Outflow"],
    ),
    "problem: source": (lambda: problem(sources="drag"), TypeError, ["`sources`", "'drag'"]),
    "problem: source in a list": (lambda: problem(sources=[None]), TypeError, ["`sources`", "None"]),
    "inflow: nan": (lambda: fv.Inflow([1.0, np.nan]), ValueError, ["`state`", "nan"]),
    "inflow: text": (lambda: fv.Inflow("high"), TypeError, ["`state`", "high"]),
    "inflow: wrong length": (
        lambda: water(np.ones((2, 5)), boundary=fv.Inflow([1.0])),
        ValueError,
        ["`state`", "2 components", "h, h v", "got 1"],
    ),
    "inflow: wrong length of a function": (
        lambda: water(np.ones((2, 5)), boundary=fv.Inflow(lambda t: [1.0, t, t])),
        ValueError,
        ["`state`", "got 3"],
    ),
    "scheme: solver class": (lambda: fv.WavePropagation(fv.Roe), TypeError, ["`riemann`", "write Roe()"]),
    "scheme: solver text": (lambda: fv.WavePropagation("roe"), TypeError, ["`riemann`", "'roe'"]),
    "scheme: limiter class": (lambda: fv.WavePropagation(fv.Roe(), fv.MC), TypeError, ["`limiter`", "write MC()"]),
    "scheme: limiter number": (lambda: fv.WavePropagation(fv.Roe(), 4), TypeError, ["`limiter`", "4"]),
    "scheme: limiter in a tuple": (lambda: fv.WavePropagation(fv.Roe(), (fv.MC(), 4)), TypeError, ["`limiter`", "4"]),
    "scheme: order 3": (lambda: fv.WavePropagation(fv.Roe(), order=3), ValueError, ["`order`", "3", "1, 2"]),
    "scheme: order text": (lambda: fv.WavePropagation(fv.Roe(), order="2"), ValueError, ["`order`", "'2'"]),
    "scheme: cfl 0": (lambda: fv.WavePropagation(fv.Roe(), cfl=0.0), ValueError, ["`cfl`", "0"]),
    "scheme: cfl above 1": (lambda: fv.WavePropagation(fv.Roe(), cfl=1.01), ValueError, ["`cfl`", "1.01"]),
    "scheme: cfl nan": (lambda: fv.WavePropagation(fv.Roe(), cfl=np.nan), ValueError, ["`cfl`", "nan"]),
    "scheme: splitting class": (
        lambda: fv.WavePropagation(fv.Roe(), splitting=fv.Strang),
        TypeError,
        ["`splitting`", "Strang()"],
    ),
    "scheme: splitting text": (
        lambda: fv.WavePropagation(fv.Roe(), splitting="strang"),
        TypeError,
        ["`splitting`", "'strang'"],
    ),
    "solve: problem class": (lambda: solve(fv.Problem), TypeError, ["`problem`", "Problem"]),
    "solve: no problem": (lambda: solve(None), TypeError, ["`problem`", "None"]),
    "solve: scheme class": (
        lambda: solve(problem(), fv.WavePropagation),
        TypeError,
        ["`scheme`", "WavePropagation"],
    ),
    "solve: solver for a scheme": (lambda: solve(problem(), fv.Roe()), TypeError, ["`scheme`", "Roe()"]),
    "solve: backend": (
        lambda: solve(problem(), backend="numpi"),
        ValueError,
        ["`backend`", "'numpi'", "did you mean numpy?"],
    ),
    "solve: nonhyperbolic": (
        lambda: solve(problem(), nonhyperbolic="rise"),
        ValueError,
        ["`nonhyperbolic`", "'rise'", "did you mean raise?"],
    ),
    "solve: max_steps negative": (lambda: solve(problem(), limits=fv.Limits(steps=-1)), ValueError, ["`steps`", "-1"]),
    "solve: max_steps real": (lambda: solve(problem(), limits=fv.Limits(steps=1e3)), TypeError, ["`steps`", "1000.0"]),
    "solve: times after the end": (
        lambda: solve(problem(), times=[0.5, 1.5]),
        ValueError,
        ["`times`", "1.5", "[0, 1]"],
    ),
    "solve: times before the start": (lambda: solve(problem(), times=[-0.5]), ValueError, ["`times`", "-0.5"]),
    "solve: times descending": (
        lambda: solve(problem(), times=[0.5, 0.2]),
        ValueError,
        ["`times`", "ascend", "0.2"],
    ),
    "solve: times twice": (lambda: solve(problem(), times=[0.5, 0.5]), ValueError, ["`times`", "0.5"]),
    "solve: no times": (lambda: solve(problem(), times=[]), ValueError, ["`times`", "[]"]),
    "solve: times nan": (lambda: solve(problem(), times=[np.nan]), ValueError, ["`times`", "nan"]),
    "solve: times text": (lambda: solve(problem(), times="ab"), TypeError, ["`times`"]),
    "solve: times number": (lambda: solve(problem(), times=0.5), (TypeError, ValueError), ["`times`", "0.5"]),
    "solve: observers": (lambda: solve(problem(), observers=[3]), TypeError, ["`observers`", "3"]),
    "solve: progress": (lambda: solve(problem(), progress="yes"), TypeError, ["`progress`", "'yes'"]),
    "stepper: problem": (lambda: Stepper(fv.Burgers()), TypeError, ["`problem`", "Burgers()"]),
    "stepper: scheme": (lambda: Stepper(problem(), fv.HLL()), TypeError, ["`scheme`", "HLL()"]),
    "stepper: step 0": (lambda: Stepper(problem()).step(0.0), ValueError, ["`dt`", "0.0"]),
    "stepper: step back": (lambda: Stepper(problem()).step(-1.0), ValueError, ["`dt`", "-1.0"]),
    "stepper: step nan": (lambda: Stepper(problem()).step(np.nan), ValueError, ["`dt`", "nan"]),
    "stepper: advance back": (lambda: Stepper(problem()).advance(-1.0), ValueError, ["`t`", "-1.0"]),
    "stepper: advance nan": (lambda: Stepper(problem()).advance(np.nan), ValueError, ["`t`", "nan"]),
    "stepper: few cells": (
        lambda: Stepper(
            fv.Problem(fv.Burgers(), fv.Grid(0.0, 1.0, 1), np.ones((1, 1)), 1.0, boundary=fv.Periodic())
        ),
        ValueError,
        ["`num_cells`", "1"],
    ),
    "rhs: problem": (lambda: fv.rhs(None), TypeError, ["`problem`", "None"]),
    "rhs: scheme": (lambda: fv.rhs(problem(), "roe"), TypeError, ["`scheme`", "'roe'"]),
    "advection: nan": (lambda: fv.Advection(np.nan), ValueError, ["`speed`", "nan"]),
    "advection: text": (lambda: fv.Advection("fast"), TypeError, ["`speed`", "'fast'"]),
    "acoustics: no density": (lambda: fv.Acoustics(rho=0.0), ValueError, ["`rho`", "0.0"]),
    "acoustics: negative bulk": (lambda: fv.Acoustics(bulk=-1.0), ValueError, ["`bulk`", "-1.0"]),
    "acoustics: array": (lambda: fv.Acoustics(bulk=np.ones(2)), TypeError, ["`bulk`"]),
    "drag: negative": (lambda: gr.ConstantDrag(-1.0), ValueError, ["`D`", "-1.0"]),
    "drag: nan": (lambda: gr.ConstantDrag(D=np.nan), ValueError, ["`D`", "nan"]),
    "drag: text": (lambda: gr.ConstantDrag("strong"), TypeError, ["`D`", "'strong'"]),
    "drag: missing": (lambda: gr.ConstantDrag(), TypeError, ["D"]),
    "drag: class": (lambda: problem(sources=gr.ConstantDrag), TypeError, ["`sources`", "ConstantDrag()"]),
    "drag: one velocity": (
        lambda: fv.Problem(gr.Reduced(), GRID, np.ones((3, 5)), 1.0, sources=gr.ConstantDrag(1.0)),
        ValueError,
        ["ConstantDrag", "Reduced"],
    ),
    "drag: general law": (lambda: problem(sources=gr.ConstantDrag(1.0)), ValueError, ["ConstantDrag", "Burgers"]),
    "two-phase: g": (lambda: gr.TwoPhase(g=0.0), ValueError, ["`g`", "0.0"]),
    "two-phase: gamma 1": (lambda: gr.TwoPhase(gamma=1.0), ValueError, ["`gamma`", "1.0", "density of the fluid"]),
    "two-phase: gamma 0": (lambda: gr.TwoPhase(gamma=0.0), ValueError, ["`gamma`", "0.0"]),
    "two-phase: gamma 2": (lambda: gr.TwoPhase(gamma=2), ValueError, ["`gamma`", "2"]),
    "two-phase: g true": (lambda: gr.TwoPhase(g=True), TypeError, ["`g`", "True"]),
    "reduced: gamma": (lambda: gr.Reduced(gamma=-0.1), ValueError, ["`gamma`", "-0.1"]),
    "reduced: g": (lambda: gr.Reduced(g=np.inf), ValueError, ["`g`", "inf"]),
    "shallow water: g": (lambda: gr.ShallowWater(g=-9.81), ValueError, ["`g`", "-9.81"]),
    "shallow water: g none": (lambda: gr.ShallowWater(g=None), TypeError, ["`g`", "None"]),
}


@pytest.mark.parametrize("case", BAD)
def test_bad_input_is_refused_by_name_and_value(case):
    call, kind, words = BAD[case]
    with pytest.raises(kind) as error:
        call()
    for word in words:
        assert word in str(error.value)


@pytest.mark.parametrize(("model", "state", "word"), [
    (gr.TwoPhase(), dict(h=-1.0, phi=0.5), "`h`"), (gr.TwoPhase(), dict(h=np.nan, phi=0.5), "`h`"),
    (gr.TwoPhase(), dict(h=1.0, phi=1.5), "`phi`"), (gr.Reduced(), dict(h=1.0, phi=-0.1), "`phi`"),
    (gr.Reduced(), dict(h=1.0, phi=np.nan), "`phi`"), (gr.ShallowWater(), dict(h=1.0, phi=0.5, vs=np.inf), "`vs`"),
    (gr.TwoPhase(), dict(h=1.0, phi=0.5, vf=[0.0, np.nan]), "`vf`"),
])
def test_conversions_refuse_impossible_states_by_name_and_value(model, state, word):
    with pytest.raises(ValueError, match=word) as error:
        model.conserved_from(**state)
    value = next(v for name, v in state.items() if f"`{name}`" == word)
    assert str(np.ravel(value)[-1]) in str(error.value)


def test_bad_input_raises_even_where_failures_are_not_thrown():
    with pytest.raises(ValueError, match=r"`times`"):
        solve(problem(), times=[2.0], throw=False)


def test_an_unknown_keyword_is_refused():
    with pytest.raises(TypeError, match=r"limitr"):
        fv.WavePropagation(fv.Roe(), limitr=fv.MC())


@pytest.mark.parametrize("part", [fv.Grid(0.0, 1.0, 5), fv.Burgers(), fv.Roe(), fv.MC(), fv.WavePropagation(fv.Roe()),
                                  problem(), fv.Outflow(), gr.TwoPhase()], ids=lambda part: type(part).__name__)
def test_parts_are_frozen(part):
    with pytest.raises(AttributeError):
        part.order = 7
    with pytest.raises(AttributeError):
        part.g = 7.0


def test_numpy_scalars_and_whole_numbers_are_numbers():
    grid = fv.Grid(np.float32(0.0), np.int64(2), np.int32(4))
    assert (grid.lower, grid.upper, grid.num_cells, grid.dx) == (0.0, 2.0, 4, 0.5)
    assert gr.TwoPhase(g=np.array(9.0)).g == 9.0


def test_the_grid_knows_its_edges_and_centres():
    grid = fv.Grid(-1.0, 1.0, 4)
    assert grid.edges.tolist() == [-1.0, -0.5, 0.0, 0.5, 1.0]
    assert grid.centers.tolist() == [-0.75, -0.25, 0.25, 0.75]


def test_the_array_of_the_user_is_copied():
    q = np.ones((1, 5))
    made = problem(initial=q)
    q[0, 0] = 9.0
    assert made.q0[0, 0] == 1.0
