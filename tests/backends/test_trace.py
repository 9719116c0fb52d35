"""Tracing: every operation means under the compiler what NumPy means, and what cannot be traced is named."""

import inspect
import math
from fractions import Fraction
from functools import cache
from pathlib import Path

import attrs
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import fvkit as fv
from fvkit.backends.compiled import llvm
from fvkit.backends.compiled.llvm import block
from fvkit.pointwise.tracing import Expr, Graph, Untraceable, keeping_nan, needed

values = st.floats(-20.0, 20.0).map(lambda x: 0.0 if abs(x) < 1e-100 else x)
OPERATIONS = {
    "+": lambda x, y: x + y, "-": lambda x, y: x - y, "*": lambda x, y: x * y, "neg": lambda x, y: -x + 0.0 * y, "abs": lambda x, y: abs(x),
    "squares": lambda x, y: x**2 + x**4, "cube": lambda x, y: y**3 + 0.0 * x, "where": lambda x, y: np.where(x < y, x, 2.0 * y), "max": lambda x, y: np.maximum(x, y),
    "min": lambda x, y: np.minimum(x, np.minimum(y, 1.0)), "sign": lambda x, y: np.sign(x) - np.sign(y),
    "sqrt": lambda x, y: np.sqrt(x * x + 1.0) + (y * y) ** 0.5, "logic": lambda x, y: np.where(((x > 0) & (y > 0)) | ~(x != 1.0), 1.0, x),
    "exp": lambda x, y: np.exp(x) + np.expm1(y), "log": lambda x, y: np.log(x * x + 1.0) - np.log1p(y * y),
    "trigonometry": lambda x, y: np.sin(x) * np.cos(y) + np.tanh(x) + np.arctan2(y, x * x + 1.0), "clip": lambda x, y: np.clip(x, -1.0, 3.0) + y,
    "division": lambda x, y: x / (1.0 + y * y) + 2.0 / (3.0 + x * x), "numpy scalar": lambda x, y: np.float64(2.0) * x - np.float64(1.0) / (2.0 + y * y),
    "comparisons": lambda x, y: np.where(x <= y, 1.0, 0.0) + np.where(x >= 1.0, 2.0, 0.0) + np.where(x == y, 3.0, y), "square": lambda x, y: np.square(x) + np.abs(y),
    "logic of constants": lambda x, y: np.where((((x > 0) & True) | False) & (np.False_ | (y < 1.0)), x, 1.0) + np.where(((x > y) & False) | (True | (x > y)), y, 2.0),
    "cube root": lambda x, y: np.cbrt(x) + 1.0 / (1.0 + np.cbrt(y) ** 2), "reflection": lambda x, y: (-1.0 - x) + (0.0 - y), "halves": lambda x, y: x / 2.0 - y / 1.0 + 0.0 / (1.0 + y * y),
    "constants": lambda x, y: 1.0 * x + 0.0 * y - 1.0 * y + 0.0, "negative power": lambda x, y: (1.0 + x * x) ** -1 + (2.0 + y * y) ** -2, "hypot": lambda x, y: np.hypot(x, y),
}


@cache
def compiled(name: str, changed=lambda result: result):
    """Trace an operation, and compile what came out as a function of two arrays."""
    import numba

    graph = Graph()
    result = OPERATIONS[name](graph.node("load", "x"), graph.node("load", "y"))
    made = block("made", [changed(result)], lambda node: node.operation == "load")
    order = [0 if node.arguments[0] == "x" else 1 for node in made.inputs]
    space = {"made": made.compiled(), "njit": numba.njit(error_model="numpy")}
    arguments = ", ".join("xy"[k] for k in order)
    exec(f"@njit\ndef run(x, y):\n    return made({arguments})[0]", space)
    return space["run"]


@pytest.mark.parametrize("name", OPERATIONS)
@given(x=values, y=values)
def test_a_compiled_operation_means_what_numpy_means(name, x, y):
    wanted = OPERATIONS[name](np.array([x]), np.array([y]))[0]
    assert compiled(name)(x, y) == pytest.approx(wanted, rel=1e-13, abs=1e-13)


@pytest.mark.parametrize("name", sorted(OPERATIONS.keys() - {"neg", "cube"}))  # they hold 0 x, which is traced as 0
@pytest.mark.parametrize(("x", "y"), [(np.nan, 1.5), (-0.5, np.nan), (np.nan, np.nan)])
def test_nan_is_kept_or_dropped_where_numpy_does(name, x, y):
    wanted = OPERATIONS[name](np.array([x]), np.array([y]))[0]
    assert compiled(name, keeping_nan)(x, y) == pytest.approx(wanted, rel=1e-13, abs=1e-13, nan_ok=True)


def test_products_are_contracted_once_and_only_where_the_processor_can(monkeypatch):
    graph = Graph()
    x, y = graph.node("load", "x"), graph.node("load", "y")
    both, used = x * y + y * y, x * x
    nodes = tuple(needed([both, used + x, used], lambda node: node.operation == "load"))
    inside = tuple(node for node in nodes if node.operation != "load")
    assert llvm.contracted(inside, (both, used + x, used)) == {both.index: (x * y).index}
    near = 1.0 + 2.0**-30  # its square has more digits than there is room for
    once = float(Fraction(near) ** 2 - 1)
    for fma, wanted in ((True, once), (False, near * near - 1.0)):
        monkeypatch.setattr(llvm, "has_fma", lambda fma=fma: fma)
        monkeypatch.setitem(OPERATIONS, "contraction", lambda x, y: x * y - 1.0)
        assert compiled.__wrapped__("contraction")(near, near) == wanted
    assert once != near * near - 1.0


@pytest.mark.parametrize(("name", "low", "high"), [("exp", -700.0, 700.0), ("expm1", -0.34, 0.34), ("log", 0.5, 2.0), ("log", 1e-300, 1e-290)])
def test_functions_are_exact_to_a_unit_in_the_last_place(name, low, high):
    import numba

    graph = Graph()
    made = block("made", [getattr(np, name)(graph.node("load", "x"))], lambda node: node.operation == "load").compiled()
    run = numba.njit(error_model="numpy")(eval("lambda x: made(x)[0]", {"made": made}))
    x = np.random.default_rng(3).uniform(low, high, 20_000)
    found, wanted = (np.array([one(item) for item in x]) for one in (run, getattr(math, name)))
    assert (np.abs(found - wanted) <= 2.0 * np.spacing(np.abs(wanted))).all()  # one of ours and one of the library's


def test_what_two_blocks_share_is_contracted_alike():
    graph = Graph()
    x, y = graph.node("load", "x"), graph.node("load", "y")
    product, other = x * y, x * x
    first = block("first", [product + y], lambda node: node.operation == "load")
    assert first.fused == {(product + y).index: product.index}
    both = [product + y, product, other - x]  # here something else uses the product
    assert block("alone", both, lambda node: node.operation == "load").fused == {(other - x).index: other.index}
    assert block("second", both, lambda node: node.operation == "load", first).fused == {**first.fused, (other - x).index: other.index}
    apart = block("apart", [product + y, product], lambda node: node.operation == "load")
    assert block("third", [product + y], lambda node: node.operation == "load", apart).fused == {}


def test_equal_operations_are_shared_and_unused_ones_vanish():
    graph = Graph()
    x = graph.node("load", "x")
    unused = np.sqrt(x)
    result = (x + 1.0) * (x + 1.0)
    assert isinstance(unused, Expr)
    assert [node.operation for node in needed([result])] == ["load", "+", "*"]


def test_what_depends_on_parameters_alone_is_uniform():
    graph = Graph()
    g, x = graph.node("uniform", "par[0]"), graph.node("load", "x")
    assert (0.5 * g * (1.0 - g)).uniform
    assert not (0.5 * g * x).uniform


@attrs.frozen
class LookingUp(fv.WavePropagation):
    """A scheme with a stage that only whole arrays can run."""

    def stages(self, parts):
        first, *rest = super().stages(parts)

        def looked_up(parts, ratio, **inputs):
            np.interp(inputs["ql"][0], [-1e9, 1e9], [-1e9, 1e9])
            return first.compute(parts, ratio, **inputs)

        return (attrs.evolve(first, compute=looked_up), *rest)


def test_a_stage_that_cannot_be_traced_is_named_with_its_line_and_numpy_still_runs_it():
    problem = fv.Problem(fv.Burgers(), fv.Grid(0.0, 1.0, 20), lambda x: 1.0 + x[None], 0.1)
    with pytest.raises(Untraceable) as error:
        fv.solve(problem, LookingUp(fv.HLL()), backend="numba")
    line = inspect.getsourcelines(LookingUp.stages)[1] + 4
    assert f"looked_up ({Path(__file__)}:{line}): np.interp" in str(error.value)
    assert 'backend="numpy"' in str(error.value)
    assert fv.solve(problem, LookingUp(fv.HLL()), backend="numpy").success


@pytest.mark.parametrize(("misuse", "words"), [
    (lambda x: 1.0 if x > 0 else 2.0, "fv.where"), (float, "Python float"), (lambda x: np.add(x, 1.0, dtype=float), "plain arguments"),
    (lambda x: x + "one", "a str meets a value"), (lambda x: np.sum(x), "np.sum"), (lambda x: x * np.ones(3), "ndarray")])
def test_misuse_of_a_value_says_what_is_wrong(misuse, words):
    with pytest.raises(Untraceable, match=words):
        misuse(Graph().node("load", "x"))
