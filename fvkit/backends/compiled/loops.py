"""Building blocks of generated kernel source: symbols, scratch rows, loops and blocks of arithmetic.

A tile of cells is one scratch buffer, every field a row at a fixed offset. Rows are longer than a page, offsets are
constants, nothing is indexed from below: each of these was measured to matter by a factor.
"""

import re
from collections.abc import Iterable
from typing import Any, NamedTuple

import attrs
import numpy as np

from fvkit.backends.compiled.llvm import Block, block, is_condition
from fvkit.backends.compiled.per_cell import PerCell
from fvkit.backends.compiled.pieces import by_products, pieces
from fvkit.backends.compiled.tile_bounds import TileBounds, opened, summed, taken
from fvkit.backends.plan import Plan
from fvkit.pointwise.tracing import Expr, Graph, with_symbols
from fvkit.problem.problem import Problem
from fvkit.schemes.scheme import Parts, Read, Scheme, Stage

#: Cells per tile, and spare entries of a row (halo, and no two rows a multiple of a page apart).
TILE, SPARE = 512, 16


class Row(NamedTuple):
    """A field component in the scratch buffer: entry 0 is place ``low``; ``pitch`` entries lie between neighbouring places."""

    number: int
    low: int
    pitch: int = 1
    length: int = TILE + SPARE

    @property
    def start(self) -> int:
        """Its first entry in the buffer."""
        return self.number * self.length

    def at(self, place: int) -> str:
        """Text of the entry of loop variable j for place j + ``place``."""
        return f"buf[{self.start + (place - self.low) * self.pitch} + j]"


def entry_of(text: str) -> int | None:
    """Return the number of the entry, counted from j, of a text of `Row.at`, None of another text."""
    found = re.fullmatch(r"buf\[(\d+) \+ j\]", text)
    return int(found[1]) if found else None


class Writer:
    """Symbols, rows and loops of one kernel. Everything that varies without recompilation is an argument of it.

    ``pitch`` and ``length`` are those of its rows: several lines lie side by side where a sweep goes across the memory.
    """

    pitch, length = 1, TILE + SPARE

    def __init__(self, problem: Problem, scheme: Scheme, parts: Parts, plan: Plan, varies: list[bool], prefix: str = "") -> None:
        self.problem, self.scheme, self.plan, self.varies, self.prefix = problem, scheme, plan, varies, prefix
        self.staged = scheme.program.registers > 0
        self.lines: list[str] = []
        self.graph = Graph()
        self.blocks: list[Block] = []
        self.rows = 0
        self.names: list[str] = []
        #: Numbers of the rows by which a loop hands values to the next.
        self.passing: list[int] = []
        self.model, self.parts = parts.model, parts.mapped(self._symbolic)
        self.boundary = tuple(self._symbolic(side) for side in problem.ends)
        self.parts = self.parts._replace(dx=self._parameter())
        self.ratio, self.before, self.after = (self.graph.node("uniform", name) for name in ("ratio", "before", "after"))
        self.fields: dict[str, Any] = {}
        self.percell = PerCell(self.graph)
        self.bounds = TileBounds(self.graph, self.percell)
        self.read_from: dict[int, str] = {}
        self.given = len(problem.model.conserved) + sum(varies)
        #: Row and values of what differs between the two versions of the loop that is being written, by the index of the
        #: symbol that reads it. A later loop may pass that symbol on: there it is a plain value.
        self.twofold: dict[int, tuple[Row, tuple[Any, Any]]] = {}
        self.light = {name: stage for stage in plan.stages if stage.light for name in stage.writes}

    def _symbolic(self, part: Any) -> Any:
        return with_symbols(part, self._parameter)

    def _parameter(self) -> Expr:
        """The symbol of the next parameter."""
        self.names.append(f"par[{len(self.names)}]")
        return self.graph.node("uniform", self.names[-1])

    def emit(self, line: str, depth: int = 1) -> None:
        """Append a line at a depth of indentation."""
        self.lines.append("    " * depth + line)

    def new_row(self, low: int) -> Row:
        """Return a new row of scratch."""
        self.rows += 1
        return Row(self.rows - 1, low, self.pitch, self.length)

    def span(self, more: Any = 0) -> str:
        """Text of the number of entries of nt places and ``more``."""
        places = "nt" if more == 0 else f"nt + {more}"
        return places if self.pitch == 1 else f"({places}) * {self.pitch}"

    def load(self, row: Row, place: int) -> Expr:
        """Return the symbol of a row's entry at loop variable + place."""
        node = self.graph.node("load", row.at(place))
        if row.number < self.given:
            self.percell.loads[node.index] = (row, place)
        return node

    def reads(self, stage: Stage) -> list[Read]:
        """Fields that a stage reads from cells and other loops: light stages are replaced by the fields that they read."""
        return [inner for read in stage.reads.values() for inner in self.sources_of(read)]

    def sources_of(self, read: Read) -> list[Read]:
        """The read itself, or those of the light stage that writes its field."""
        if read.field not in self.light:
            return [read]
        first, last = read.offsets[0], read.offsets[-1]
        return [Read(inner.field, first + inner.offsets[0], last + inner.offsets[-1])
                for inner in self.reads(self.light[read.field])]

    def inputs(self, stage: Stage, place: int, own: dict[str, Any], low: int) -> dict[str, Any]:
        """Symbols for everything that a stage reads at loop variable + place; ``own`` are values of this loop, at ``low``."""
        found = {name: tuple(self.value(read.field, place + offset, own, low) for offset in read.offsets)
                 for name, read in stage.reads.items()}
        return {name: values[0] if stage.reads[name].last is None else values for name, values in found.items()}

    def value(self, field: str, place: int, own: dict[str, Any], low: int) -> Any:
        """Symbols of a field at loop variable + place: of this loop, computed again if light, else from scratch."""
        if field in own and place == low:
            return own[field]
        if field in self.light:
            stage = self.light[field]
            return stage.run(self.parts, self.ratio, self.inputs(stage, place, own, low))[field]
        return self.loaded(self.fields[field], place)

    def loaded(self, value: Any, place: int) -> Any:
        """Symbols for every row in nested tuples at loop variable + place; constants and uniform symbols stay."""
        if isinstance(value, Row):
            return self.load(value, place)
        return tuple(self.loaded(item, place) for item in value) if isinstance(value, tuple) else value

    def store(self, values: dict[str, Any], low: int, later: dict[str, Any]) -> list[tuple[Row, Expr]]:
        """Give rows to the values that vary from cell to cell, here or in a guarded stage; return what to write where.

        ``later`` holds what guarded stages make of them.
        """
        writes: list[tuple[Row, Expr]] = []

        def place(value: Any, other: Any) -> Any:
            if isinstance(value, tuple):
                return tuple(place(item, other[k]) for k, item in enumerate(value))
            if isinstance(value, Expr) and value.index in self.twofold:
                writes.append((self.twofold[value.index][0], value))
                return writes[-1][0]
            if value is other and value.uniform if isinstance(value, Expr) else not isinstance(other, Expr) and value == other:
                return value
            writes.append((self.new_row(low), value))
            return writes[-1][0]

        for name, value in values.items():
            self.fields[name] = place(value, later.get(name, value))
        return writes

    def shared(self, usual: Any, whole: Any, low: int) -> Any:
        """Symbols of values that both versions of a loop leave: where they differ, of the row that either writes."""
        if isinstance(usual, tuple):
            return tuple(self.shared(one, other, low) for one, other in zip(usual, whole, strict=True))
        if usual is whole if isinstance(usual, Expr) else not isinstance(whole, Expr) and usual == whole:
            return usual
        row = self.new_row(low)
        node = self.load(row, low)
        self.twofold[node.index] = row, (usual, whole)
        return node

    def version(self, writes: list[tuple[Row, Any]], which: int) -> list[tuple[Row, Any]]:
        """What one of the two versions of a loop writes: 0 the usual one."""
        return [(row, self.in_version(value, which)) for row, value in writes]

    def in_version(self, value: Any, which: int) -> Any:
        """A value in one of the two versions of a loop."""
        return self.twofold[value.index][1][which] if isinstance(value, Expr) and value.index in self.twofold else value

    def restore(self, values: dict[str, Any]) -> list[tuple[Row, Any]]:
        """Return the values that a guarded stage writes to the rows of its fields."""
        def pairs(row: Any, value: Any) -> list[tuple[Row, Any]]:
            if isinstance(row, Row):
                return [(row, value)]
            inner = zip(row, value, strict=True) if isinstance(row, tuple) else ()
            return [pair for one, other in inner for pair in pairs(one, other)]

        return [pair for name, value in values.items() for pair in pairs(self.fields[name], value)]

    def loop(self, count: str, writes: list[tuple[Row, Any]], low: int, extra: list[tuple[str, Any]], depth: int = 1,
             always: bool = False, rows: dict[int, str] | None = None, like: Block | None = None,
             beside: Iterable[Any] = ()) -> Block:
        """Loops that compute the written values and those of the extra lines, and write. ``{}`` in a line is its value.

        With ``always`` they run in every tile: values per cell are then worth a separate loop. ``rows`` has the
        rows of nodes that an earlier loop has stored, which these do not compute. What they share with the block ``like`` has
        its bits, else what they write those that it has with the values ``beside`` it in place of the extra lines. Returns the
        block that they compute, all of them together.
        """
        lines = [*extra, *((f"{row.at(low)} = {{}}", value) for row, value in writes)]
        places = {_index(value): row.at(low) for row, value in writes}
        stored = dict(rows or {})
        usual = like or self.content([*beside, *(value for _, value in writes)], always=always, stored=stored)
        whole = self.content([value for _, value in lines], always=always, stored=stored, like=usual)
        # The second version of a loop and code behind a test run seldom: cutting them is not worth its compilation.
        often = rows is None and like is None and all(value is not None for _, value in lines)
        parts = pieces(whole, len(self.blocks)) if often else [whole]
        parts = [attrs.evolve(part, multiplied=by_products(part)) for part in parts] if often else parts
        whole = attrs.evolve(whole, multiplied=whole.multiplied.union(*(part.multiplied for part in parts)))
        passing = 0
        while parts:
            part, parts = parts[0], parts[1:]
            self.emit(f"for j in range({count}):", depth)
            left = {item.index: item for item in part.outputs}
            own = [item for item in lines if not parts or _index(item[1]) in left]
            lines = [item for item in lines if _index(item[1]) not in left]
            before = dict(stored)
            stored |= {index: places[index] for index in left if index in places}
            asked = {item.index for later in parts for item in later.inputs}
            for index in [index for index in left if index in asked and index not in stored]:
                stored[index] = self.passing_row(passing, low).at(low)
                own.append((f"{stored[index]} = {{}}", left[index]))
                passing += 1
            self.body(part, own, depth + 1, before)
        return whole

    def passing_row(self, number: int, low: int) -> Row:
        """Return a row for what one loop hands to the next; the next group of loops gets the same again."""
        while len(self.passing) <= number:
            self.passing.append(self.new_row(low).number)
        return Row(self.passing[number], low, self.pitch, self.length)

    def compute(self, writes: list[tuple[Row, Any]], low: int, extra: list[tuple[str, Any]], depth: int,
                rows: dict[int, str] | None = None) -> None:
        """The body of a loop that is written by hand; see `loop`."""
        lines = [*extra, *((f"{row.at(low)} = {{}}", value) for row, value in writes)]
        self.body(self.content([value for _, value in lines], stored=rows), lines, depth, rows or {})

    def body(self, made: Block, lines: list[tuple[str, Any]], depth: int, stored: dict[int, str]) -> None:
        """Emit the call of a block, which writes to scratch what goes there, and the other lines."""
        outputs = {item.index for item in made.outputs}
        stores, left = [], []
        for line, value in lines:
            place = entry_of(line.removesuffix(" = {}")) if _index(value) in outputs else None
            if place is None:
                left.append((line, value))
            else:
                stores.append((place, value))
        asked = {_index(value) for _, value in left}
        returned = tuple(item for item in made.outputs if item.index in asked)
        names = self.call(attrs.evolve(made, stores=tuple(stores), returned=returned), depth, stored)
        for line, value in left:
            self.emit(line.format(names.get(_index(value)) or _number(value)), depth)

    def assign(self, values: list[Any], depth: int, fixed: bool = False) -> list[str]:
        """Emit the call of a block that computes the values; return the name or number of each.

        With ``fixed`` uniform values are not available, as they are in ``tile``, and are computed by the block too.
        """
        names = self.call(self.content(values, fixed), depth, {})
        return [names.get(_index(value)) or _number(value) for value in values]

    def content(self, values: list[Any], fixed: bool = False, always: bool = False, stored: dict[int, str] | None = None,
                like: Block | None = None) -> Block:
        """Return the block that computes the values, without outputs where all are numbers."""
        def plain(node: Expr) -> bool:
            if node.operation in ("load", "uniform") or (stored and node.index in stored):
                return True
            return node.uniform and not fixed and not is_condition(node)

        outputs = list({value.index: value for value in values if isinstance(value, Expr)}.values())
        known = self.percell.find(outputs, plain, always)
        made = block(f"{self.prefix}block_{len(self.blocks)}", outputs, lambda node: node.index in known or plain(node), like)
        for item in made.inputs:
            if item.index in known:
                self.keep_per_cell(item, *known[item.index])
        return made

    def call(self, made: Block, depth: int, stored: dict[int, str]) -> dict[int, str]:
        """Emit the call of a block; return the name of each of its outputs."""
        if not made.outputs:
            return {}
        inputs = {item.index: stored.get(item.index) or self.argument(item) for item in made.inputs}
        loads = {index: place for index, text in inputs.items() if (place := entry_of(text)) is not None}
        self.blocks.append(attrs.evolve(made, loads=loads))
        names = {item.index: f"v{len(self.blocks)}_{item.index}" for item in made.returned if isinstance(item, Expr)}
        left = f"({''.join(f'{name}, ' for name in names.values())}) = " if names else ""
        arguments = ["buf", "j"][:2 * self.blocks[-1].in_scratch] + [text for index, text in inputs.items() if index not in loads]
        self.emit(f"{left}{made.name}({', '.join(arguments)})", depth)
        return names

    def keep_per_cell(self, node: Expr, function: int, place: int) -> None:
        """Store a function of one cell in a row, from which the node is read."""
        if function not in self.percell.rows:
            self.percell.rows[function] = self.new_row(-self.plan.halo)
            self.percell.samples[function] = node
        self.read_from[node.index] = self.percell.rows[function].at(place)

    def per_cell(self) -> list[str]:
        """Text of the loop over the cells of a tile and its halo: the rows of `keep_per_cell`, and extremes of `TileBounds`."""
        kept, self.lines = self.lines, []
        halo, terms = self.plan.halo, list(self.bounds.cells.values())
        writes = [(self.percell.rows[function], self.percell.at(node, -halo, self.load))
                  for function, node in self.percell.samples.items()]
        self.percell.rows = {}
        for line in ("cells = 0.0", *opened(terms)):
            self.emit(line)
        if writes or terms:
            values = [self.percell.at(term.node, -halo, self.load) for term in terms]
            made = [value for term, value in zip(terms, values, strict=True) if not term.given]
            self.loop(self.span(2 * halo), writes, -halo, [*taken(terms, values), *summed("cells", made)])
        made, self.lines = self.lines, kept
        return made

    def argument(self, item: Expr) -> str:
        """Text of an input of a block."""
        if item.index in self.read_from:
            return self.read_from[item.index]
        return f"u{item.index}" if item.uniform and item.operation != "uniform" else str(item.arguments[0])

    def run(self, stages: list[Stage], low: int) -> dict[str, Any]:
        """Symbols of what stages that share a loop write, at ``low``."""
        own: dict[str, Any] = {}
        for stage in stages:
            own |= stage.run(self.parts, self.ratio, self.inputs(stage, low, own, low))
        return own


def _index(value: Any) -> int:
    """The index of a symbol, -1 of a number."""
    return value.index if isinstance(value, Expr) else -1


def _number(value: Any) -> str:
    """Text of a constant that tracing has found: a plain number, whatever NumPy calls it; nothing for None."""
    return "" if value is None else repr(value.item() if isinstance(value, np.generic) else value)
