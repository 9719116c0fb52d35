"""Blocks of traced arithmetic as functions that the compiler inlines: nodes become LLVM instructions, one each.

Products are contracted into sums here and not by LLVM, whose choice differs between the vectors of a loop and the rest of it: the
same face, computed at the end of one tile and at the start of the next, must have the same flux to the bit, or mass is lost.

A block is one loop body without its loads and stores. Numba sees a single call where it would otherwise infer types for
hundreds of operations, which is what most of a compilation would be spent on; selections are instructions and no branches.
"""

import math
import platform
from collections import Counter
from collections.abc import Callable
from functools import cache
from typing import Any

import attrs

from fvkit.backends.compiled.calls import intrinsic
from fvkit.backends.compiled.cube_roots import cube_root
from fvkit.backends.compiled.quotients import quotient
from fvkit.pointwise.tracing import KEEPS_NAN, Expr, needed

_ARITHMETIC = {"+": "fadd", "-": "fsub", "*": "fmul", "/": "fdiv"}
_COMPARISONS = ("<", "<=", ">", ">=", "==")
_EXTREMES = {"maximum": ">", "minimum": "<", f"maximum{KEEPS_NAN}": ">", f"minimum{KEEPS_NAN}": "<"}
_BOOLEAN = (*_COMPARISONS, "!=", "&", "|", "not", "isfinite", "isnan")
#: Lets LLVM use vectors of 512 bits on processors that have them and prefer 256: on those a step then takes less time.
WIDEST = '"prefer-vector-width"="512"'
_LIBRARY = {"arcsin": "asin", "arccos": "acos", "arctan": "atan", "arctan2": "atan2"}


@attrs.frozen
class Block:
    """The nodes between inputs and outputs.

    Parameters
    ----------
    name : name of the function.
    inputs : leaves, loads or uniform values, in the order of the arguments.
    nodes : the nodes to compute, in order.
    outputs : nodes or numbers that are computed; those that ``stores`` does not hold are returned, as a tuple; conditions as
        integers 0 or 1.
    fused : {sum or difference: product that it contracts}, by index.
    multiplied : quotients that are made of products, by index.
    loads : {input: its entry of scratch, counted from j}, by index.
    stores : entry of scratch, counted from j, and output that is written there.
    returned : outputs that are returned besides.
    """

    name: str
    inputs: tuple[Expr, ...]
    nodes: tuple[Expr, ...]
    outputs: tuple[Any, ...]
    fused: dict[int, int]
    multiplied: frozenset[int] = frozenset()
    loads: dict[int, int] = attrs.field(factory=dict)
    stores: tuple[tuple[int, Expr], ...] = ()
    returned: tuple[Any, ...] = attrs.field(default=attrs.Factory(lambda self: self.outputs, takes_self=True))

    def text(self) -> str:
        """The content of the block, for the key of the cache."""
        lines = [f"# {self.name}({', '.join(_label(item) for item in self.inputs)})"]
        lines += [f"#   {_label(node)} = {node.operation} {' '.join(_label(item) for item in node.arguments)}"
                  + (f" (%{self.fused[node.index]} in one)" if node.index in self.fused else "")
                  + (" by products" if node.index in self.multiplied else "") for node in self.nodes]
        lines += [f"#   %{index} is at {place} + j" for index, place in self.loads.items()]
        lines += [f"#   {place} + j becomes {_label(item)}" for place, item in self.stores]
        return "\n".join([*lines, f"#   return {' '.join(_label(item) for item in self.returned)}"])

    def compiled(self) -> Any:
        """The function for numba; it is compiled where it is called."""
        from numba import float64, int64
        from numba.core import types

        kinds = [int64 if is_condition(item) else float64 for item in self.returned]
        arguments = [float64[::1], int64][:2 * self.in_scratch] + [float64] * (len(self.inputs) - len(self.loads))
        return intrinsic(self.name, len(arguments), types.Tuple(kinds)(*arguments), self._code)

    @property
    def in_scratch(self) -> bool:
        """Whether the function takes the scratch and j before its other arguments."""
        return bool(self.loads or self.stores)

    def _code(self, context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        # llvmlite refuses unknown names of attributes. Where a function is inlined its attribute is lost, so that
        # every function with loops needs a block of its own, if only `wide`.
        set.add(builder.function.attributes, WIDEST)
        given = iter(arguments)
        scratch = context.make_array(signature.args[0])(context, builder, next(given)).data if self.in_scratch else None
        first = next(given) if self.in_scratch else None

        def entry(place: int) -> Any:
            return builder.gep(scratch, [builder.add(first, context.get_constant(signature.args[1], place))])

        values = {node.index: builder.load(entry(self.loads[node.index])) if node.index in self.loads else next(given)
                  for node in self.inputs}
        emitter = _Emitter(context, builder, values, self.fused if has_fma() else {}, self.multiplied)
        for node in self.nodes:
            values[node.index] = emitter.node(node)
        for place, item in self.stores:
            builder.store(emitter.argument(item), entry(place))
        results = [emitter.widened(item) for item in self.returned]
        return context.make_tuple(builder, signature.return_type, results)


def wide() -> Block:
    """Return a block that does nothing but allow the widest vectors in the function that calls it."""
    return Block("wide", (), (), (), {})


def block(name: str, outputs: list[Any], leaf: Callable[[Expr], bool], like: Block | None = None) -> Block:
    """Return the block that computes the outputs from the nodes for which ``leaf`` is true; what it shares with the block
    ``like`` is computed as there, to the bit."""
    inputs: list[Expr] = []
    inside: list[Expr] = []
    for node in needed(outputs, leaf):
        (inputs if leaf(node) else inside).append(node)
    return Block(name, tuple(inputs), tuple(inside), tuple(outputs), contracted(inside, outputs, like),
                 frozenset() if like is None else like.multiplied)


def contracted(nodes: list[Expr], outputs: list[Any], like: Block | None = None) -> dict[int, int]:
    """Return for each sum or difference the product in it that nothing else uses: it is computed as a b + c, rounded once.

    Sums that occur in the block ``like`` are computed as there."""
    uses = Counter(item.index for node in nodes for item in node.arguments if isinstance(item, Expr))
    uses.update(item.index for item in outputs if isinstance(item, Expr))
    inside, found = {node.index for node in nodes}, {} if like is None else dict(like.fused)
    known = set() if like is None else {node.index for node in like.nodes}
    for node in nodes:
        for item in node.arguments if node.operation in ("+", "-") and node.index not in known else ():
            if isinstance(item, Expr) and item.operation == "*" and item.index in inside and uses[item.index] == 1:
                found[node.index] = item.index
                break
    return found


@cache
def has_fma() -> bool:
    """Whether the processor multiplies and adds in one instruction."""
    from llvmlite import binding

    return platform.machine().lower() in ("aarch64", "arm64") or bool(binding.get_host_cpu_features().get("fma", False))


def _label(item: Any) -> str:
    return f"%{item.index}" if isinstance(item, Expr) else repr(item)


def is_condition(item: Any) -> bool:
    """Whether a node or number is a condition."""
    return item.operation in _BOOLEAN if isinstance(item, Expr) else isinstance(item, bool)


class _Emitter:
    """Writes the instructions of nodes whose arguments are known."""

    def __init__(self, context: Any, builder: Any, values: dict[int, Any], fused: dict[int, int],
                 multiplied: frozenset[int]) -> None:
        from llvmlite import ir

        self.multiplied = multiplied
        self.context, self.builder, self.values, self.products, self.ir = context, builder, values, fused, ir
        self.double, self.whole = ir.DoubleType(), ir.IntType(64)

    def argument(self, item: Any) -> Any:
        """The value of a node or of a number."""
        if isinstance(item, Expr):
            return self.values[item.index]
        return self.ir.Constant(self.ir.IntType(1), int(item)) if isinstance(item, bool) else self.number(item)

    def number(self, value: float) -> Any:
        """A constant."""
        return self.ir.Constant(self.double, float(value))

    def widened(self, item: Any) -> Any:
        """The value of an output: conditions as integers."""
        value = self.argument(item)
        return self.builder.zext(value, self.whole) if is_condition(item) else value

    def node(self, node: Expr) -> Any:
        """The instructions of one node."""
        operation, builder = node.operation, self.builder
        if node.index in self.products:
            return self.contraction(node, next(item for item in node.arguments
                                               if isinstance(item, Expr) and item.index == self.products[node.index]))
        items = [self.argument(item) for item in node.arguments]
        if node.index in self.multiplied:
            return quotient(self, *items)
        if operation in _ARITHMETIC:
            return getattr(builder, _ARITHMETIC[operation])(*items)
        if operation in _COMPARISONS:
            return builder.fcmp_ordered(operation, *items)
        if operation == "!=":
            return builder.fcmp_unordered(operation, *items)
        if operation == "where":
            return builder.select(*items)
        if operation in _EXTREMES:
            return self.extreme(operation, *items)
        if operation in ("sqrt", "abs"):
            return self.intrinsic("llvm.sqrt" if operation == "sqrt" else "llvm.fabs", *items)
        if operation in ("&", "|"):
            return builder.and_(*items) if operation == "&" else builder.or_(*items)
        special = getattr(self, f"_{operation}", None)
        return special(*items) if special is not None else self.library(_LIBRARY.get(operation, operation), *items)

    def contraction(self, node: Expr, product: Expr) -> Any:
        """A sum or difference of which one part is a contracted product."""
        a, b = (self.argument(item) for item in product.arguments)
        first, second = node.arguments
        if first is product:
            c = self.argument(second)
            return self.fused(a, b, c if node.operation == "+" else self.builder.fneg(c))
        return self.fused(a if node.operation == "+" else self.builder.fneg(a), b, self.argument(first))

    def extreme(self, operation: str, a: Any, b: Any) -> Any:
        """The larger or smaller of two. The comparison takes the second where one is NaN, so a constant should be first."""
        if isinstance(b, self.ir.Constant):
            a, b = b, a
        found = self.builder.select(self.builder.fcmp_ordered(_EXTREMES[operation], a, b), a, b)
        sure = isinstance(a, self.ir.Constant) or not operation.endswith(KEEPS_NAN)
        return found if sure else self.builder.select(self._isnan(a), a, found)

    def intrinsic(self, name: str, *items: Any) -> Any:
        """A call of an LLVM intrinsic on doubles."""
        return self.builder.call(self.builder.module.declare_intrinsic(name, [self.double]), items)

    def library(self, name: str, *items: Any) -> Any:
        """A call of the mathematics library; such loops are not vectorised."""
        from numba import float64

        function = self.context.typing_context.resolve_value_type(getattr(math, name))
        signature = function.get_call_type(self.context.typing_context, (float64,) * len(items), {})
        return self.context.get_function(function, signature)(self.builder, items)

    def _not(self, a: Any) -> Any:
        return self.builder.not_(a)

    def _neg(self, a: Any) -> Any:
        return self.builder.fsub(self.number(-0.0), a)

    def _pow(self, a: Any, b: Any) -> Any:
        return self.builder.call(self.builder.module.declare_intrinsic("llvm.pow", [self.double]), (a, b))

    def _sign(self, a: Any) -> Any:
        zero, builder = self.number(0.0), self.builder
        below = builder.select(builder.fcmp_ordered("<", a, zero), self.number(-1.0), a)
        return builder.select(builder.fcmp_ordered(">", a, zero), self.number(1.0), below)

    def _isfinite(self, a: Any) -> Any:
        return self.builder.fcmp_ordered("==", self.builder.fsub(a, a), self.number(0.0))

    def _isnan(self, a: Any) -> Any:
        return self.builder.fcmp_unordered("uno", a, a)

    def _cbrt(self, x: Any) -> Any:
        return cube_root(self, x)

    def _exp(self, x: Any) -> Any:
        """exp as 2^k times a polynomial on |r| <= ln(2)/2, to one unit in the last place; below the normal range it is 0."""
        builder, number = self.builder, self.number
        low, high = number(-708.0), number(709.0)
        y = builder.select(builder.fcmp_ordered(">", x, high), high, x)
        y = builder.select(builder.fcmp_ordered("<", y, low), low, y)
        shift = number(6755399441055744.0)
        moved = builder.fadd(builder.fmul(y, number(1.4426950408889634)), shift)
        k = builder.fsub(moved, shift)
        r = self.fused(k, number(-0.6931471803691238), y)
        r = self.fused(k, number(-1.9082149292705877e-10), r)
        p = number(1.0 / math.factorial(12))
        for n in range(11, -1, -1):
            p = self.fused(p, r, number(1.0 / math.factorial(n)))
        # The last bits of the shifted number are k: taken as they are, since conversions are not vectorised everywhere.
        exponent = builder.shl(builder.add(builder.bitcast(moved, self.whole), self.ir.Constant(self.whole, 1023)),
                               self.ir.Constant(self.whole, 52))
        result = builder.fmul(p, builder.bitcast(exponent, self.double))
        result = builder.select(builder.fcmp_ordered(">", x, number(709.782712893384)), number(math.inf), result)
        return builder.select(builder.fcmp_ordered("<", x, low), number(0.0), result)

    def _expm1(self, x: Any) -> Any:
        """exp(x) - 1, from its series below 0.35."""
        builder, number = self.builder, self.number
        p = number(1.0 / math.factorial(14))
        for n in range(13, 0, -1):
            p = self.fused(p, x, number(1.0 / math.factorial(n)))
        near = builder.fcmp_ordered("<", self.intrinsic("llvm.fabs", x), number(0.35))
        return builder.select(near, builder.fmul(p, x), builder.fsub(self._exp(x), number(1.0)))

    def _log(self, x: Any) -> Any:
        """log of 2^k m as k log(2) + 2 artanh((m - 1)/(m + 1)), sqrt(1/2) < m < sqrt(2), to two units in the last place."""
        builder, number, whole = self.builder, self.number, lambda value: self.ir.Constant(self.whole, value)
        small = builder.fcmp_ordered("<", x, number(2.0**-1022))
        bits = builder.bitcast(builder.select(small, builder.fmul(x, number(2.0**54)), x), self.whole)
        shifted = builder.sub(bits, whole(0x3FE6A09E667F3BCD))
        k = builder.ashr(shifted, whole(52))
        m = builder.bitcast(builder.sub(bits, builder.shl(k, whole(52))), self.double)
        k = builder.bitcast(builder.add(k, whole(0x4338000000000000)), self.double)
        k = builder.fsub(builder.fsub(k, number(6755399441055744.0)), builder.select(small, number(54.0), number(0.0)))
        f = builder.fsub(m, number(1.0))
        s = builder.fdiv(f, builder.fadd(f, number(2.0)))
        z = builder.fmul(s, s)
        p = number(2.0 / 21.0)
        for n in range(19, 1, -2):
            p = self.fused(p, z, number(2.0 / n))
        # log(m) = f - s (f - z p): f is exact, the rest is small.
        rest = builder.fmul(s, builder.fsub(f, builder.fmul(z, p)))
        result = builder.fsub(f, builder.fsub(rest, builder.fmul(k, number(1.9082149292705877e-10))))
        result = builder.fadd(builder.fmul(k, number(0.6931471803691238)), result)
        result = builder.select(builder.fcmp_ordered("<", x, number(math.inf)), result, x)
        result = builder.select(builder.fcmp_ordered("==", x, number(0.0)), number(-math.inf), result)
        return builder.select(builder.fcmp_ordered("<", x, number(0.0)), number(math.nan), result)

    def fused(self, a: Any, b: Any, c: Any) -> Any:
        """a b + c, in one instruction where there is one."""
        if has_fma():
            return self.builder.fma(a, b, c)
        return self.builder.fadd(self.builder.fmul(a, b), c)
