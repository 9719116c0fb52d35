"""Whether a condition may hold anywhere in a tile, by interval arithmetic: where it cannot, no face is asked.

Conditions that seldom hold, such as "neighbours differ much", cost many compares at every face. They are made of functions of one
cell, of values that a loop computes anyway, and of differences of neighbours: the smallest and the largest of each over the tile
take an instruction each, and the bounds of the whole condition are computed from them once per tile.
"""

from collections.abc import Callable
from functools import reduce
from itertools import product
from operator import or_
from typing import Any, NamedTuple

import attrs
import numpy as np

from fvkit.backends.compiled.calls import intrinsic
from fvkit.backends.compiled.per_cell import PerCell
from fvkit.pointwise import maximum, minimum
from fvkit.pointwise.tracing import KEEPS_NAN, Expr, Graph, needed

#: Share of its size by which an interval is widened: what computes a term for one face may round otherwise than the loop that
#: took its extremes. Much more than rounding, and much less than what matters.
WIDENED = 1e-12

#: Beyond any number that a term may be.
HUGE = 1e300

#: Operations of which `_Ends` knows what they make of intervals.
ARITHMETIC = ("+", "-", "*", "neg", "abs", "sqrt", "where", "maximum", "minimum", f"maximum{KEEPS_NAN}", f"minimum{KEEPS_NAN}")


class Unbounded(Exception):
    """A condition has a part for which there are no bounds."""


class Term(NamedTuple):
    """A node of which ``ends``, "low" and "high", are its smallest and largest values over a tile.

    ``given`` are given values and their differences, which are finite.
    """

    node: Expr
    ends: set[str]
    given: bool = False


class TileBounds:
    """The bounds of conditions of one kernel, and the terms of which the kernel takes extremes.

    A term is the largest part of a condition that is a function of one cell; or a value that the loop computes, or reads from
    an earlier one; or the difference of a given value of two neighbours, since a bottom falls further over a tile than over a
    face; or what is not `ARITHMETIC`.
    """

    def __init__(self, graph: Graph, percell: PerCell) -> None:
        self.graph, self.percell = graph, percell
        #: Terms of one cell, by their function.
        self.cells: dict[int, Term] = {}

    def may_hold(self, conditions: list[Any], own: set[int]) -> tuple[Any, list[Term]]:
        """Return the symbol of whether one of the conditions may hold in the tile, and the terms of faces in it.

        ``own`` are the indices of what the loop computes. True where there are no bounds.
        """
        faces: dict[int, Term] = {}
        for node in needed(conditions):
            self.percell.profile(node)

        def term(node: Expr) -> Term | None:
            function, place, single = self.percell.profile(node)
            if single and place is not None:
                return self.cells.setdefault(function, Term(node, set(), node.operation == "load"))
            differs = self._differs(node)
            kept = differs or node.index in own or node.operation not in ARITHMETIC
            if kept and node.index not in own and any(part.index in own and part.operation == "load" for part in needed([node])):
                raise Unbounded  # of a row that the loop itself writes, and cannot read yet
            return faces.setdefault(node.index, Term(node, set(), differs)) if kept else None

        try:
            ends = _Ends(self.graph, term)
            found = reduce(or_, map(ends.may_hold, conditions), False)
        except Unbounded:
            return True, []
        return found, list(faces.values())

    def beyond_bounds(self, *sums: str) -> Any:
        """Symbol of whether one of the sums is not finite: extremes may miss NaN."""
        return reduce(or_, [~self.graph.node("isfinite", self.graph.node("load", name)) for name in sums])

    def _differs(self, node: Expr) -> bool:
        """Whether a node is the difference of the same given value in two cells."""
        loads = [self.percell.loads.get(item.index) for item in node.arguments if isinstance(item, Expr)]
        return node.operation == "-" and len(loads) == 2 and None not in loads and loads[0][0] == loads[1][0]  # type: ignore[index]


def opened(terms: list[Term]) -> list[str]:
    """Lines before the loop that takes the extremes of the terms."""
    return [f"{end}{term.node.index} = {HUGE if end == 'low' else -HUGE}" for term in terms for end in sorted(term.ends)]


def taken(terms: list[Term], values: list[Any]) -> list[tuple[str, Any]]:
    """Lines of that loop, each with its value; ``values`` are those of the terms in it."""
    return [(f"{end}{term.node.index} = {end}er({end}{term.node.index}, {{}})", value)
            for term, value in zip(terms, values, strict=True) for end in sorted(term.ends)]


def summed(name: str, values: list[Any]) -> list[tuple[str, Any]]:
    """The line of a loop that adds values up, in any order: the sum is finite if all of them are."""
    return [(f"{name} = gathered({name}, {{}})", sum(values[1:], values[0]))] if values else []


class _Ends:
    """Interval arithmetic on symbols. ``term`` returns the node whose extremes the kernel takes in place of a node, or None."""

    def __init__(self, graph: Graph, term: Callable[[Expr], Term | None]) -> None:
        self.graph, self.term = graph, term
        self._known: dict[tuple[int, bool], Any] = {}

    def may_hold(self, item: Any, holds: bool = True) -> Any:
        """Symbol of whether a condition may be true somewhere, or, without ``holds``, false."""
        if not isinstance(item, Expr):
            return bool(item) is holds
        operation, items = item.operation, item.arguments
        if operation == "not":
            return self.may_hold(items[0], not holds)
        if operation in ("&", "|"):
            one, other = (self.may_hold(part, holds) for part in items)
            return one & other if (operation == "&") is holds else one | other
        if operation in ("==", "!="):
            a, b = items
            return ~((self.end(a, True) < self.end(b, False)) | (self.end(a, False) > self.end(b, True))) \
                if (operation == "==") is holds else True
        if operation not in ("<", "<=", ">", ">="):
            raise Unbounded
        less, more = items if operation[0] == "<" else items[::-1]
        if holds:
            low, high = self.end(less, False), self.end(more, True)
            return ~(low > high if "=" in operation else low >= high)
        high, low = self.end(less, True), self.end(more, False)
        return ~(high <= low if "=" in operation else high < low)

    def end(self, item: Any, upper: bool) -> Any:
        """The upper or lower end of a value."""
        if not isinstance(item, Expr) or item.uniform:
            return item
        key = item.index, upper
        if key not in self._known:
            term = self.term(item)
            self._known[key] = self._of_parts(item, upper) if term is None else self._extreme(term, upper)
        return self._known[key]

    def _extreme(self, term: Term, upper: bool) -> Any:
        """The extreme of a term, widened."""
        end = "high" if upper else "low"
        term.ends.add(end)
        value = self.graph.node("load", f"{end}{term.node.index}")
        return value + (WIDENED if upper else -WIDENED) * abs(value)

    def _of_parts(self, item: Expr, upper: bool) -> Any:
        """The end of what an operation makes of intervals."""
        operation, items, extreme = item.operation.removesuffix(KEEPS_NAN), item.arguments, maximum if upper else minimum
        if operation == "+":
            return self.end(items[0], upper) + self.end(items[1], upper)
        if operation == "-":
            return self.end(items[0], upper) - self.end(items[1], not upper)
        if operation == "neg":
            return -self.end(items[0], not upper)
        if operation == "abs":
            low, high = self.end(items[0], False), self.end(items[0], True)
            return maximum(-low, high) if upper else maximum(0.0, maximum(low, -high))
        if operation in ("maximum", "minimum"):
            ends = [self.end(part, upper) for part in items]
            return maximum(*ends) if operation == "maximum" else minimum(*ends)
        if operation == "sqrt":
            return np.sqrt(self.end(items[0], upper))
        if operation == "where":
            return extreme(self.end(items[1], upper), self.end(items[2], upper))
        ends = [[self.end(part, side) for side in ((True,) if not isinstance(part, Expr) or part.uniform else (False, True))]
                for part in items]
        return reduce(extreme, [a * b for a, b in product(*ends)])


@attrs.frozen
class Running:
    """A function of a result so far and a value, for loops that are vectorised: the ``lower`` or the ``higher`` of both, or the
    sum ``gathered``, in any order.

    Extremes may miss NaN, which a sum never does.
    """

    name: str

    def text(self) -> str:
        """The content, for the key of the cache."""
        return f"# {self.name} of what is so far and a value"

    def compiled(self) -> Any:
        """The function for numba; it is compiled where it is called."""
        from numba import float64

        return intrinsic(self.name, 2, float64(float64, float64), self._code)

    def _code(self, context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        so_far, value = arguments
        if self.name == "gathered":
            return builder.fadd(so_far, value, flags=("reassoc",))
        plain = ("nnan", "nsz")
        sooner = builder.fcmp_ordered("<" if self.name == "lower" else ">", value, so_far, flags=plain)
        return builder.select(sooner, value, so_far, flags=plain)


#: The functions that the lines of `taken` call.
RUNNING = tuple(map(Running, ("lower", "higher", "gathered")))
