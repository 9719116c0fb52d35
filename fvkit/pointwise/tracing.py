"""Tracing: run a pointwise function once on symbols, and keep the arithmetic that it did.

Pointwise code has no branches on values, so one run on symbols sees all of it: models, solvers, helpers, loops over
components, whatever Python builds it from. What comes out is a graph of elementary operations, equal ones shared. Its
text is the content of what is compiled: two sources that compute the same are the same. A literal 0 times a value is 0.
"""

from collections.abc import Callable
from typing import Any

import attrs
import numpy as np

from fvkit.pointwise.part import Part, Wrapper, seen_as

#: Behind "maximum" and "minimum" in the operation of a node: NaN where either value is, as NumPy has it. It costs two more
#: instructions, too many for all of them; the plain ones drop NaN of their first value.
KEEPS_NAN = " with nan"


class Untraceable(TypeError):
    """A pointwise function did something with a value that only whole arrays can do."""


class Graph:
    """Nodes of a trace; equal operations on equal arguments are one node."""

    def __init__(self) -> None:
        self.nodes: list[Expr] = []
        self._known: dict[tuple[Any, ...], Expr] = {}
        #: Conditions of `fvkit.rarely` that a trace takes for unmet; None where it keeps both cases.
        self.rare: list[Expr] | None = None

    def node(self, operation: str, *arguments: Any) -> "Expr":
        """Return the node of an operation, made if it is new."""
        key = (operation, *(id(item) if isinstance(item, Expr) else repr(item) for item in arguments))
        if key not in self._known:
            self._known[key] = Expr(self, len(self.nodes), operation, arguments)
            self.nodes.append(self._known[key])
        return self._known[key]

    def function(self, name: str, *values: Any) -> Any:
        """Return the result of a NumPy function of symbols and numbers."""
        if name not in _FUNCTIONS:
            raise Untraceable(f"np.{name} does not take cells one by one, as pointwise code does (no sums, no extremes, no "
                              f"shifts); these do: {', '.join(sorted(_FUNCTIONS))}")
        return _FUNCTIONS[name](self, *(_value(value) for value in values))


def chosen_among(item: Any) -> dict[int, Any]:
    """Return the nodes, by index, of which the largest or smallest sizes make a node."""
    if isinstance(item, Expr) and item.operation in ("maximum", "minimum", "abs", "neg"):
        return {index: node for argument in item.arguments for index, node in chosen_among(argument).items()}
    return {item.index: item} if isinstance(item, Expr) else {}


def keeping_nan(item: Any) -> Any:
    """Return a value that is NaN wherever one of those among which it was chosen is."""
    if not isinstance(item, Expr) or item.operation not in ("maximum", "minimum", "abs", "neg"):
        return item
    name = item.operation if len(item.arguments) == 1 else item.operation + KEEPS_NAN
    return item.graph.node(name, *[keeping_nan(argument) for argument in item.arguments])


class Expr:
    """A symbol: represents one number per cell or face, and records the operations on it."""

    __slots__ = ("arguments", "graph", "index", "operation", "uniform")

    uniform: bool

    def __init__(self, graph: Graph, index: int, operation: str, arguments: tuple[Any, ...]) -> None:
        self.graph, self.index, self.operation, self.arguments = graph, index, operation, arguments
        #: Whether it is the same in every cell: parameters and what is computed from them alone.
        self.uniform = operation == "uniform" or (operation != "load" and all(
            item.uniform for item in arguments if isinstance(item, Expr)))

    def __neg__(self) -> Any:
        return self.graph.node("neg", self)

    def __pos__(self) -> Any:
        return self

    def __abs__(self) -> Any:
        return self.graph.node("abs", self)

    def __invert__(self) -> Any:
        return self.graph.node("not", self)

    __hash__ = None  # type: ignore[assignment]  # a symbol compares to a symbol: it is no key

    def __bool__(self) -> bool:
        raise Untraceable("a value decides here what is computed (if, while, and, or, not, max, min); use fv.where(condition, "
                          "a, b), &, |, ~, fv.maximum(a, b) or fv.minimum(a, b)")

    def __float__(self) -> float:
        raise Untraceable("a value is turned into a Python float here, which no array is; use np.sqrt and its like, not "
                          "those of math")

    def __index__(self) -> int:
        raise Untraceable("a value is the number of one cell, not an index or a count (aux[k], range(k), int(k)), and so is a "
                          "parameter; a constant of the class (ClassVar) is an integer: let `along(axis)` return a part of "
                          "another class, or write (1 - k) * a + k * b")

    def __array__(self, *arguments: Any, **settings: Any) -> Any:
        raise Untraceable("values are put into an array here, where sums would count cells as well; keep components in tuples")

    def __array_ufunc__(self, ufunc: Any, method: str, *inputs: Any, **settings: Any) -> Any:
        if method != "__call__" or settings:
            raise Untraceable(f"np.{ufunc.__name__} is used here with more than plain arguments")
        return self.graph.function(ufunc.__name__, *inputs)

    def __array_function__(self, function: Any, kinds: Any, arguments: Any, settings: Any) -> Any:
        if settings:
            raise Untraceable(f"np.{function.__name__} is used here with more than plain arguments")
        return self.graph.function(function.__name__, *arguments)


def _value(value: Any) -> Any:
    """A symbol, or the number that a value is."""
    if isinstance(value, Expr):
        return value
    if isinstance(value, (bool, np.bool_)):
        return bool(value)
    if isinstance(value, (int, float, np.number)) or (isinstance(value, np.ndarray) and value.ndim == 0):
        return float(value)
    raise Untraceable(f"a {type(value).__name__} meets a value here; only numbers and values serve")


def _add(graph: Graph, a: Any, b: Any) -> Any:
    a, b = _value(a), _value(b)
    if not isinstance(a, Expr) and a == 0.0:
        return b
    if not isinstance(b, Expr) and b == 0.0:
        return a
    return graph.node("+", a, b)


def _subtract(graph: Graph, a: Any, b: Any) -> Any:
    a, b = _value(a), _value(b)
    if not isinstance(b, Expr) and b == 0.0:
        return a
    if not isinstance(a, Expr) and a == 0.0:
        return graph.node("neg", b)
    return graph.node("-", a, b)


def _multiply(graph: Graph, a: Any, b: Any) -> Any:
    a, b = _value(a), _value(b)
    for constant, other in ((a, b), (b, a)):
        if not isinstance(constant, Expr) and constant in (0.0, 1.0, -1.0):
            return 0.0 if constant == 0.0 else other if constant == 1.0 else graph.node("neg", other)
    return graph.node("*", a, b)


def _divide(graph: Graph, a: Any, b: Any) -> Any:
    a, b = _value(a), _value(b)
    if (not isinstance(b, Expr) and b == 1.0) or (not isinstance(a, Expr) and a == 0.0):
        return a
    return graph.node("/", a, b)


def _power(graph: Graph, a: Any, b: Any) -> Any:
    a, b = _value(a), _value(b)
    if isinstance(b, Expr) or b not in (-2.0, -1.0, 0.5, 1.0, 2.0, 3.0, 4.0):
        return graph.node("pow", a, b)
    if b == 0.5:
        return graph.node("sqrt", a)
    result = a
    for _ in range(int(abs(b)) - 1):
        result = result * a
    return result if b > 0 else 1.0 / result


def _where(graph: Graph, condition: Any, *choices: Any) -> Any:
    if len(choices) != 2:
        raise Untraceable("np.where(condition) looks for cells; fv.where(condition, a, b) serves each")
    a, b = choices
    if not isinstance(condition, Expr):
        return a if condition else b
    if a is b or (not isinstance(a, Expr) and repr(a) == repr(b)):
        return a
    return graph.node("where", condition, a, b)


def _both(graph: Graph, a: Any, b: Any) -> Any:
    a, b = (b, a) if isinstance(b, Expr) and not isinstance(a, Expr) else (a, _value(b))
    return graph.node("&", a, b) if isinstance(b, Expr) else a if b else False


def _either(graph: Graph, a: Any, b: Any) -> Any:
    a, b = (b, a) if isinstance(b, Expr) and not isinstance(a, Expr) else (a, _value(b))
    return graph.node("|", a, b) if isinstance(b, Expr) else True if b else a


def _clip(graph: Graph, a: Any, low: Any, high: Any) -> Any:
    return graph.node("minimum", graph.node("maximum", a, low), high)


def _plain(name: str) -> Callable[..., Any]:
    return lambda graph, *values: graph.node(name, *values)


def _binary(operation: Callable[..., Any], turned: bool = False) -> Callable[[Expr, Any], Any]:
    """The operator that records an operation; ``turned`` where the symbol stands on its right."""
    return (lambda self, other: operation(self.graph, other, self)) if turned else \
        (lambda self, other: operation(self.graph, self, other))


def _comparison(name: str) -> Callable[[Expr, Any], Any]:
    return lambda self, other: self.graph.node(name, self, _value(other))


for _name, _operation in {"add": _add, "sub": _subtract, "mul": _multiply, "truediv": _divide, "pow": _power, "and": _both,
                          "or": _either}.items():
    setattr(Expr, f"__{_name}__", _binary(_operation))
    setattr(Expr, f"__r{_name}__", _binary(_operation, turned=True))
for _name, _sign in {"lt": "<", "le": "<=", "gt": ">", "ge": ">=", "eq": "==", "ne": "!="}.items():
    setattr(Expr, f"__{_name}__", _comparison(_sign))


_UNARY = ("sqrt", "cbrt", "exp", "expm1", "log", "log1p", "sin", "cos", "tan", "arcsin", "arccos", "arctan", "sinh", "cosh",
          "tanh", "floor", "ceil", "sign", "isfinite", "isnan")
_FUNCTIONS: dict[str, Callable[..., Any]] = {
    **{name: _plain(name) for name in _UNARY},
    **{name: _plain(name) for name in ("maximum", "minimum", "hypot", "arctan2")},
    **{ufunc: _plain(operation) for ufunc, operation in (
        ("less", "<"), ("less_equal", "<="), ("greater", ">"), ("greater_equal", ">="), ("equal", "=="), ("not_equal", "!="),
        ("invert", "not"), ("logical_not", "not"), ("absolute", "abs"), ("fabs", "abs"), ("negative", "neg"))},
    "add": _add, "subtract": _subtract, "multiply": _multiply, "divide": _divide, "true_divide": _divide, "power": _power,
    "bitwise_and": _both, "logical_and": _both, "bitwise_or": _either, "logical_or": _either,
    "float_power": _power, "where": _where, "clip": _clip, "positive": lambda graph, a: a,
    "zeros_like": lambda graph, a: 0.0, "ones_like": lambda graph, a: 1.0, "full_like": lambda graph, a, value: value,
    "square": lambda graph, a: a * a, "reciprocal": lambda graph, a: 1.0 / a,
}


def needed(roots: list[Any], leaf: Callable[[Expr], bool] = lambda node: False) -> list[Expr]:
    """Return the nodes that the roots are computed from, themselves included, in order; nothing behind a leaf."""
    found: dict[int, Expr] = {}
    pending = [root for root in roots if isinstance(root, Expr)]
    while pending:
        node = pending.pop()
        if node.index not in found:
            found[node.index] = node
            if not leaf(node):
                pending += [item for item in node.arguments if isinstance(item, Expr)]
    return [found[index] for index in sorted(found)]


def with_symbols(part: Any, symbol: Callable[[], Expr]) -> Any:
    """Return a copy of a part whose numeric fields are symbols: its methods then trace themselves."""
    if isinstance(part, Wrapper):
        return attrs.evolve(part, part=with_symbols(part.part, symbol))
    return seen_as(part, {name: symbol() for name in part.parameter_names()}) if isinstance(part, Part) else part
