"""A long loop body as several loops, one after the other, with intermediate values in scratch.

A processor looks some hundred instructions ahead. A body that fills that window runs at the pace of its longest chain of
dependent operations, however many of them could go side by side. Cut in two, each half has half the chain, and twice as many
vectors are under way. The same operations, contracted alike: the same bits.
"""

from itertools import pairwise
from typing import Any

from fvkit.backends.compiled.llvm import Block, block, is_condition
from fvkit.backends.compiled.quotients import BUSY, PRODUCTS, SHARING, divides_slowly
from fvkit.pointwise.tracing import KEEPS_NAN, Expr

#: Instructions that are under way at once, and those that start in a cycle. Windows of 200 to 450 were tried: shallow water with
#: Manning and two-phase Roe took the least time at 300; schemes with shorter bodies do not depend on it.
WINDOW, WIDTH = 320.0, 3.0

#: Cycles that one more loop costs, and each value that a loop leaves to a later one.
LOOP, HANDED = 6.0, 1.5

#: Cycles until a result is there, where it is not `USUAL`, and the instructions of an operation, where they are not one.
USUAL = 4
CYCLES = {"/": 14, "sqrt": 20, "cbrt": 80, "sign": 8, "exp": 75, "expm1": 80, "log": 110, "pow": 200, "abs": 1, "neg": 1}
INSTRUCTIONS = {"sign": 4, f"maximum{KEEPS_NAN}": 3, f"minimum{KEEPS_NAN}": 3, "cbrt": 34, "exp": 36, "expm1": 56, "log": 42,
                "pow": 120}

#: Largest share of the time of one loop that several may take: each is compiled, and less of a gain is not worth that.
SHARE = 0.8

#: Largest share of the time of a loop that it may take with products in place of its quotients: where half of the time was to be
#: gained by the number of instructions, a tenth was gained in trials, or lost.
PAYS = 0.7

#: Nodes between two places where a body may be cut.
GRAIN = 8


def pieces(whole: Block, number: int) -> list[Block]:
    """Return the blocks that take the least time, by the estimate of `_Body.time`, in place of one; often that one alone.

    The outputs of each are those of the whole that it computes, and what later ones need. ``number`` is that of the first.
    """
    body = _Body(whole)
    cuts = body.best()
    if len(cuts) <= 2:
        return [whole]
    name, result, known = whole.name[:whole.name.rindex("_") + 1], [], {node.index for node in whole.inputs}

    def at_hand(node: Expr) -> bool:
        return node.index in known

    for k, (start, stop) in enumerate(pairwise(cuts)):
        result.append(block(f"{name}{number + k}", body.left(start, stop), at_hand, like=whole))
        known |= {node.index for node in result[-1].outputs if not is_condition(node)}
    return result


class _Body:
    """The nodes of a block that may be handed on, each as late as its longest way to an output allows: few are then handed on.

    Conditions, and products that a sum contracts, are not: who needs them makes them again.
    """

    def __init__(self, whole: Block) -> None:
        again = set(whole.fused.values())
        left = _ahead(whole)
        self.nodes = sorted((node for node in whole.nodes if not is_condition(node) and node.index not in again),
                            key=lambda node: -left[node.index])
        self.place = {node.index: k for k, node in enumerate(self.nodes)}
        #: Places of what each node of the block is made from.
        self.sources: dict[int, set[int]] = {}
        for node in whole.nodes:
            self.sources[node.index] = set().union(*(
                {self.place[item.index]} if item.index in self.place else self.sources.get(item.index, set())
                for item in node.arguments if isinstance(item, Expr)))
        self.inputs = [self.sources[node.index] for node in self.nodes]
        self.outputs = [(item, self._made(item)) for item in whole.outputs if isinstance(item, Expr)]
        #: Place of the last node that needs each.
        self.last = list(range(len(self.nodes)))
        asking = [*enumerate(self.inputs), *((made, self._sources(item)) for item, made in self.outputs)]
        for place, sources in asking:
            for one in sources:
                self.last[one] = max(self.last[one], place)
        self.ends = [*range(GRAIN, len(self.nodes) - GRAIN // 2, GRAIN), len(self.nodes)]

    def _sources(self, item: Expr) -> set[int]:
        """Places of what an output that is made again is made from."""
        return set() if item.index in self.place else self.sources.get(item.index, set())

    def _made(self, item: Expr) -> int:
        """Place of the last node that an output needs."""
        return self.place.get(item.index, max(self._sources(item), default=0))

    def time(self, start: int) -> list[float]:
        """Cycles per vector of loops over the nodes from ``start`` up to each of ``ends``; those before it count as at hand."""
        depth = [0] * len(self.nodes)
        count, longest, result = 0.0, 0, []
        for k in range(start, len(self.nodes)):
            operation = self.nodes[k].operation
            depth[k] = max((depth[one] for one in self.inputs[k] if one >= start), default=0) + CYCLES.get(operation, USUAL)
            longest = max(longest, depth[k])
            count += INSTRUCTIONS.get(operation, 1.3)
            if k + 1 in self.ends:
                result.append(LOOP + max(count / WIDTH, longest * count / WINDOW))
        return [0.0] * (len(self.ends) - len(result)) + result

    def best(self) -> list[int]:
        """The places of the cuts that take the least time, with both ends."""
        handed = [HANDED * sum(self.last[one] >= end for one in range(end)) for end in self.ends]
        best: dict[int, tuple[float, list[int]]] = {0: (0.0, [0])}
        for start in (0, *self.ends[:-1]):
            so_far, cuts = best[start]
            for end, cycles, left in zip(self.ends, self.time(start), handed, strict=True):
                total = so_far + cycles + left
                if end > start and (end not in best or total < best[end][0]):
                    best[end] = (total, [*cuts, end])
        total, cuts = best[len(self.nodes)]
        return cuts if total < SHARE * self.time(0)[-1] else [0, len(self.nodes)]

    def left(self, start: int, stop: int) -> list[Any]:
        """Results of the nodes of a piece: outputs, and values that nodes from ``stop`` on need."""
        result = {item.index: item for item, made in self.outputs if start <= made < stop}
        result |= {node.index: node for k, node in enumerate(self.nodes[start:stop], start) if self.last[k] >= stop}
        return list(result.values())


def by_products(block: Block) -> frozenset[int]:
    """Return the quotients of a block to be made of products: so many that the divider no longer sets its pace, those first that
    least else waits for; none where little is gained.

    A long body has other things to do meanwhile, and more instructions lengthen it.
    """
    quotients = [node for node in block.nodes if node.operation == "/"]
    if not quotients or not divides_slowly():
        return frozenset()
    busy = sum(BUSY.get(node.operation, 0.0) for node in block.nodes)
    ways, found = _longest_ways(block), frozenset[int]()
    times = {found: max(_running(block, found), busy)}
    for node in sorted(quotients, key=lambda node: ways[node.index]):
        busy -= BUSY["/"]
        found |= {node.index}
        times[found] = max(_running(block, found), busy)
    before, best = times[frozenset()], min(times, key=lambda found: times[found])
    return best if times[best] < PAYS * before else frozenset()


def _longest_ways(block: Block) -> dict[int, int]:
    """Cycles of the longest chain of operations through each node."""
    behind, before = _ahead(block), dict[int, int]()
    for node in block.nodes:
        before[node.index] = max((before.get(item.index, 0) + CYCLES.get(item.operation, USUAL)
                                  for item in node.arguments if isinstance(item, Expr)), default=0)
    return {index: start + behind[index] for index, start in before.items()}


def _running(block: Block, multiplied: frozenset[int]) -> float:
    """Cycles per vector of a loop over a block with a divider that is never busy, some quotients being ``multiplied``: those with
    the same denominator share its reciprocal."""
    depth: dict[int, int] = {}
    count, contracted, known = 0.0, set(block.fused.values()), set[Any]()
    for node in block.nodes:
        instructions, cycles = INSTRUCTIONS.get(node.operation, 1.3), CYCLES.get(node.operation, USUAL)
        if node.index in multiplied:
            below = getattr(node.arguments[1], "index", None)
            instructions, cycles = SHARING if below in known else PRODUCTS
            known.add(below)
        count += instructions * (node.index not in contracted)
        ways = (depth.get(item.index, 0) for item in node.arguments if isinstance(item, Expr))
        depth[node.index] = cycles + max(ways, default=0)
    return max(count / WIDTH, max(depth.values()) * count / WINDOW)


def _ahead(whole: Block) -> dict[int, int]:
    """Cycles from the start of each node to the end of the block."""
    result: dict[int, int] = {}
    for node in reversed(whole.nodes):
        own = result[node.index] = result.get(node.index, 0) + CYCLES.get(node.operation, USUAL)
        for item in node.arguments:
            if isinstance(item, Expr):
                result[item.index] = max(result.get(item.index, 0), own)
    return result
