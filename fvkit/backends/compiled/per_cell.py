"""Per-cell precomputation: divisions and roots of one cell that both of its faces use, computed once."""

from typing import Any

from fvkit.pointwise.tracing import Expr, Graph, needed

#: Operations that cost no more than reading their result from scratch would.
_CHEAP = frozenset(("load", "uniform", "+", "-", "*", "abs", "neg", "where", "maximum", "minimum", "sign", "floor", "ceil",
                    "isfinite", "isnan", "<", "<=", ">", ">=", "==", "!=", "&", "|", "not"))


#: Profile of a node that depends on more than one cell.
_NO_CELL: tuple[int, int | None, bool] = (-1, None, False)


class PerCell:
    """Recognises equal computations at different places of a loop.

    A node that reads given fields at one place alone is a function of that cell. Two nodes with the same function at two
    places need it only once per cell: `find` picks them, and keeps for each function a row of scratch.
    """

    def __init__(self, graph: Graph) -> None:
        self.graph = graph
        #: (row, place) of the loads of given fields, by index of the node.
        self.loads: dict[int, tuple[Any, int]] = {}
        #: Row of each function that has one, and a node that computes it at some place.
        self.rows: dict[int, Any] = {}
        self.samples: dict[int, Expr] = {}
        self._functions: dict[tuple[Any, ...], int] = {}
        self._profiles: dict[int, tuple[int, int | None, bool]] = {}

    def profile(self, node: Expr) -> tuple[int, int | None, bool]:
        """Return the function that a node is, the place that it reads, and whether it reads none or that one alone.

        The operands of the node must have been looked up before.
        """
        known = self._profiles.get(node.index)
        if known is None:
            known = self._profiles[node.index] = self._profile(node)
        return known

    def _profile(self, node: Expr) -> tuple[int, int | None, bool]:
        if node.operation == "load":
            if node.index not in self.loads:
                return _NO_CELL
            row, at = self.loads[node.index]
            return self._function(("load", row)), at, True
        if node.uniform:
            return self._function(("uniform", node.index)), None, True
        here: int | None = None
        name: list[Any] = [node.operation]
        for item in node.arguments:
            if not isinstance(item, Expr):
                name.append(repr(item))
                continue
            function, place, own = self.profile(item)
            if not own or (place is not None and here is not None and place != here):
                return _NO_CELL
            here = place if place is not None else here
            name.append(function)
        return self._function(tuple(name)), here, True

    def _function(self, key: tuple[Any, ...]) -> int:
        return self._functions.setdefault(key, len(self._functions))

    def find(self, outputs: list[Expr], leaf: Any, new: bool) -> dict[int, tuple[int, int]]:
        """Return {node: (function, place)} for the nodes that are read from scratch instead of computed.

        With ``new`` functions without a row may get one: those that occur at two places at least.
        """
        found: dict[int, dict[int, Expr]] = {}
        for node in needed(outputs, leaf):
            function, place, own = self.profile(node)
            if own and place is not None and node.operation not in _CHEAP and (new or function in self.rows):
                found.setdefault(function, {})[place] = node
        return {node.index: (function, place) for function, nodes in found.items()
                if len(nodes) > 1 or function in self.rows for place, node in nodes.items()}

    def at(self, node: Expr, place: int, load: Any) -> Any:
        """Return the symbol of a node's function at another place; ``load`` gives that of a row at a place."""
        if node.operation == "load":
            return load(self.loads[node.index][0], place)
        return node if node.uniform else self.graph.node(node.operation, *(
            self.at(item, place, load) if isinstance(item, Expr) else item for item in node.arguments))
