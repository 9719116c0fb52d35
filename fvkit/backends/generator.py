"""The kernel generator: stages become loops over tiles, straight enough for the compiler to vectorise.

A tile of cells is copied into one scratch buffer, every field a row at a fixed offset; each group of stages is one loop
from 0; the new cells are copied out. Rows are longer than a page, offsets are constants, nothing is indexed from below:
each of these was measured to matter by a factor. Stages that cover the same range and read each other's fields only at
offset 0 share a loop; a light stage is computed again where it is read; stages with a guard have their own loops, behind
tests that the loop before them makes. Divisions and roots that look at one cell only, and that faces ask of both their
cells, are computed once per cell beforehand. A given function that is zero everywhere, such as a flat bottom, is a
literal 0 and makes no code.
"""

from collections.abc import Callable
from itertools import takewhile
from typing import Any, NamedTuple

import attrs

from fvkit.backends.emit import Block, block, is_condition
from fvkit.backends.halo import Plan
from fvkit.backends.percell import PerCell
from fvkit.backends.trace import Expr, Graph, Untraceable, with_symbols
from fvkit.problem import Problem
from fvkit.schemes.base import Parts, Read, Scheme, Stage

#: Cells per tile, and spare entries of a row (halo, and no two rows a multiple of a page apart).
TILE, SPARE = 509, 19

#: Fields whose values the step itself needs after the stages.
_KEPT = ("fastest", "to_left")


class Row(NamedTuple):
    """A field component in the scratch buffer: entry 0 is place ``low``."""

    number: int
    low: int

    def at(self, place: int) -> str:
        """Text of the entry of loop variable j that stands for place j + ``place``."""
        return f"buf[{self.number * (TILE + SPARE) + place - self.low} + j]"


@attrs.frozen
class Source:
    """Generated text of a kernel and the sizes that go with it.

    Parameters
    ----------
    text : module source with ``tile`` and ``ghosts``, and the content of the blocks that they call.
    blocks : the blocks.
    rows : rows of scratch.
    """

    text: str
    blocks: tuple[Block, ...]
    rows: int


class Generator:
    """Builds the text of one kernel. Everything that varies without recompilation is an argument of it."""

    def __init__(self, problem: Problem, scheme: Scheme, parts: Parts, plan: Plan, varies: list[bool], prefix: str = "") -> None:
        self.problem, self.scheme, self.plan, self.varies, self.prefix = problem, scheme, plan, varies, prefix
        self.staged = scheme.time_integrator is not None
        self.lines: list[str] = []
        self.graph = Graph()
        self.blocks: list[Block] = []
        self.rows = 0
        self.names: list[str] = []
        self.parts = Parts(self._symbolic(parts.model), self._symbolic(parts.riemann),
                           tuple(self._symbolic(limiter) for limiter in parts.limiters),
                           tuple(self._symbolic(source) for source in parts.sources),
                           reconstruction=parts.reconstruction and self._symbolic(parts.reconstruction))
        self.boundary = tuple(self._symbolic(side) for side in problem.boundary)
        self.parts = self.parts._replace(dx=self._parameter())
        self.ratio, self.before, self.after = (self.graph.node("uniform", name) for name in ("ratio", "before", "after"))
        self.fields: dict[str, Any] = {}
        self.percell = PerCell(self.graph)
        self.read_from: dict[int, str] = {}
        self.given = len(problem.model.conserved) + sum(varies)
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
        return Row(self.rows - 1, low)

    def load(self, row: Row, place: int) -> Expr:
        """Return the symbol of a row's entry at loop variable + place."""
        node = self.graph.node("load", row.at(place))
        if row.number < self.given:
            self.percell.loads[node.index] = (row, place)
        return node

    # ------------------------------------------------------------------ groups of stages

    def reads(self, stage: Stage) -> list[Read]:
        """What a stage reads from cells and other loops: light stages are replaced by what they read themselves."""
        return [inner for read in stage.reads for inner in self.sources_of(read)]

    def sources_of(self, read: Read) -> list[Read]:
        """The read itself, or those of the light stage that writes its field."""
        field, first, last = read
        if field not in self.light:
            return [read]
        return [Read(inner.field, first + inner.first, last + inner.last) for inner in self.reads(self.light[field])]

    def groups(self) -> list[tuple[tuple[int, int], list[Stage]]]:
        """Consecutive stages that share a loop."""
        result: list[tuple[tuple[int, int], list[Stage]]] = []
        for stage, span in zip(self.plan.stages, self.plan.ranges, strict=True):
            if stage.light:
                continue
            shares = bool(result) and result[-1][0] == span and stage.guard is None and result[-1][1][0].guard is None
            if shares:
                written = {name for earlier in result[-1][1] for name in earlier.writes}
                shares = all(read.field not in written or read.first == read.last == 0 for read in self.reads(stage))
            if shares:
                result[-1][1].append(stage)
            else:
                result.append((span, [stage]))
        return result

    def inputs(self, stage: Stage, place: int, own: dict[str, Any], low: int) -> list[Any]:
        """Symbols for everything that a stage reads at loop variable + place; ``own`` are values of this loop, at ``low``."""
        return [self.value(field, place + offset, own, low)
                for field, first, last in stage.reads for offset in range(first, last + 1)]

    def value(self, field: str, place: int, own: dict[str, Any], low: int) -> Any:
        """Symbols of a field at loop variable + place: of this loop, computed again if light, else from scratch."""
        if field in own and place == low:
            return own[field]
        if field in self.light:
            stage = self.light[field]
            written = stage.compute(self.parts, self.ratio, *self.inputs(stage, place, own, low))
            return dict(zip(stage.writes, written, strict=True))[field]
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
            if value is other and value.uniform if isinstance(value, Expr) else not isinstance(other, Expr) and value == other:
                return value
            writes.append((self.new_row(low), value))
            return writes[-1][0]

        for name, value in values.items():
            self.fields[name] = place(value, later.get(name, value))
        return writes

    def restore(self, values: dict[str, Any]) -> list[tuple[Row, Any]]:
        """Return what a guarded stage writes to the rows that its fields have."""
        def pairs(row: Any, value: Any) -> list[tuple[Row, Any]]:
            if isinstance(row, Row):
                return [(row, value)]
            inner = zip(row, value, strict=True) if isinstance(row, tuple) else ()
            return [pair for one, other in inner for pair in pairs(one, other)]

        return [pair for name, value in values.items() for pair in pairs(self.fields[name], value)]

    def loop(self, count: str, writes: list[tuple[Row, Any]], low: int, extra: list[tuple[str, Any]], depth: int = 1,
             always: bool = False, rows: dict[int, str] | None = None) -> None:
        """One loop: compute what is written and what the extra lines need, then write. ``{}`` in a line is its value.

        ``always`` says that the loop runs in every tile: what it needs per cell is then worth a loop of its own. ``rows``
        tells where nodes stand that an earlier loop has stored.
        """
        self.emit(f"for j in range({count}):", depth)
        self.compute(writes, low, extra, depth + 1, always, rows)

    def compute(self, writes: list[tuple[Row, Any]], low: int, extra: list[tuple[str, Any]], depth: int, always: bool = False,
                rows: dict[int, str] | None = None) -> None:
        """The body of a `loop`."""
        names = self.assign([value for _, value in (*extra, *writes)], depth, always=always, rows=rows or {})
        for (line, _), name in zip(extra, names, strict=False):
            self.emit(line.format(name), depth)
        for (row, _), name in zip(writes, names[len(extra):], strict=True):
            self.emit(f"{row.at(low)} = {name}", depth)

    def assign(self, values: list[Any], depth: int, fixed: bool = False, always: bool = False,
               rows: dict[int, str] | None = None) -> list[str]:
        """Emit the call of a block that computes the values; return the name or number that stands for each.

        ``fixed`` says that uniform values are not at hand, as they are in ``tile``, and are computed by the block too.
        """
        stored = rows or {}

        def plain(node: Expr) -> bool:
            if node.operation in ("load", "uniform") or node.index in stored:
                return True
            return node.uniform and not fixed and not is_condition(node)

        outputs = list({value.index: value for value in values if isinstance(value, Expr)}.values())
        if not outputs:
            return ["" if value is None else repr(value) for value in values]
        known = self.percell.find(outputs, plain, always)
        made = block(f"{self.prefix}block_{len(self.blocks)}", outputs, lambda node: node.index in known or plain(node))
        for item in made.inputs:
            if item.index in known:
                self.keep_per_cell(item, *known[item.index])
        self.blocks.append(made)
        names = {value.index: f"v{len(self.blocks)}_{value.index}" for value in outputs}
        left = "".join(f"{name}, " for name in names.values())
        inputs = (stored.get(item.index) or self.argument(item) for item in made.inputs)
        self.emit(f"({left}) = {made.name}({', '.join(inputs)})", depth)
        return [names[value.index] if isinstance(value, Expr) else "" if value is None else repr(value) for value in values]

    def keep_per_cell(self, node: Expr, function: int, place: int) -> None:
        """Give a function of one cell a row, and let the node be read from it."""
        if function not in self.percell.rows:
            self.percell.rows[function] = self.new_row(-self.plan.halo)
            self.percell.samples[function] = node
        self.read_from[node.index] = self.percell.rows[function].at(place)

    def per_cell(self) -> list[str]:
        """Text of the loop that computes the rows of `keep_per_cell` from the cells of a tile and its halo."""
        kept, self.lines = self.lines, []
        halo = self.plan.halo
        writes = [(self.percell.rows[function], self.percell.at(node, -halo, self.load))
                  for function, node in self.percell.samples.items()]
        self.percell.rows = {}
        if writes:
            self.loop(f"nt + {2 * halo}", writes, -halo, [])
        made, self.lines = self.lines, kept
        return made

    def argument(self, item: Expr) -> str:
        """Text of an input of a block."""
        if item.index in self.read_from:
            return self.read_from[item.index]
        return f"u{item.index}" if item.uniform and item.operation != "uniform" else str(item.arguments[0])

    # ------------------------------------------------------------------ the tile

    def tile(self) -> list[str]:
        """Text of ``tile``: one transport step of nt cells from c0, sources included; of a staged scheme, minus ``net`` alone.

        It returns 1 where a new state is not acceptable, else 0; ``closing`` is 1 for the tile that owns the last face.
        """
        self.copy_in()
        start = len(self.lines)
        later = self.remaining_reads()
        groups = self.groups()
        k = 0
        while k < len(groups) - 1:
            guarded = [stages[0] for _, stages in takewhile(lambda group: group[1][0].guard is not None, groups[k + 1:])]
            self.stage_loop(*groups[k], guarded, later[k + len(guarded)], first=k == 0)
            k += 1 + len(guarded)
        if k:
            self.count_lost()
        self.close_walls()
        self.update(groups[-1])
        self.lines[start:start] = self.per_cell()
        body, self.lines = self.lines, []
        arguments = "q, out, aux, edges, n, c0, nt, closing, ratio, before, after, par, buf, smx, ends, found"
        self.emit(f"def {self.prefix}tile({arguments}):", 0)
        uniform = [node for node in self.graph.nodes
                   if node.uniform and node.operation != "uniform" and not is_condition(node)]
        for node, name in zip(uniform, self.assign(list(uniform), 1, fixed=True), strict=True):
            self.emit(f"u{node.index} = {name}")
        text, self.lines = self.lines + body, []
        return text

    def remaining_reads(self) -> list[set[str]]:
        """For each group, the fields that groups after it read, or that the step itself needs."""
        result: list[set[str]] = []
        wanted = {field for name in _KEPT[1:] for field, _, _ in self.sources_of(Read(name, 0, 0))}
        for _, stages in reversed(self.groups()):
            result.append(set(wanted))
            wanted |= {read.field for stage in stages for read in self.reads(stage)}
        return list(reversed(result))

    def copy_in(self) -> None:
        """Copy the tile's cells and halo into scratch, with the sources of the first share of the step."""
        halo, model = self.plan.halo, self.problem.model
        width = f"nt + {2 * halo}"
        self.fields["q"] = tuple(self.new_row(-halo) for _ in model.conserved)
        for k, row in enumerate(self.fields["q"]):
            self.copy(f"q[{k}, c0:c0 + {width}]", width, row, "0")
        self.fields["aux"] = tuple(self.new_row(-halo) if varies else 0.0 for varies in self.varies)
        rows = [(k, row) for k, row in enumerate(self.fields["aux"]) if isinstance(row, Row)]
        if rows:
            self.emit(f"low = max(c0 - {halo}, 0)")
            self.emit(f"high = min(c0 + nt + {halo}, n)")
        for k, row in rows:
            self.copy(f"aux[{k}, low:high]", "high - low", row, f"low - c0 + {halo}")
            self.copy(f"edges[{k}, c0:{halo}]", f"{halo} - c0", row, "0")
            self.copy(f"edges[{k}, {halo}:]", f"c0 + nt + {halo} - n", row, f"n - c0 + {halo}")
        if self.parts.sources and self.scheme.splitting.before > 0.0 and not self.staged:
            q, aux = (self.loaded(self.fields[name], -halo) for name in ("q", "aux"))
            state = self.act(q, aux, self.before, self.parts.sources)
            self.loop(width, list(zip(self.fields["q"], state, strict=True)), -halo, [])

    def copy(self, source: str, count: str, row: Row, first: str) -> None:
        """Copy ``count`` numbers, none if it is negative, into a row from its entry ``first`` on."""
        self.emit(f"src = {source}")
        self.emit(f"dst = buf[{row.number * (TILE + SPARE)} + {first}:]")
        self.emit(f"for j in range({count}):")
        self.emit("dst[j] = src[j]", 2)

    def act(self, q: Any, aux: Any, dt: Expr, sources: tuple[Any, ...]) -> Any:
        """Symbols of a state after the steps of the sources."""
        for source in sources:
            q = source.step(self.parts.model, q, aux, dt)
        return q

    def stage_loop(self, span: tuple[int, int], stages: list[Stage], guarded: list[Stage], later: set[str],
                   first: bool) -> None:
        """The loop of a group, and behind tests that it makes, those of the guarded stages that follow it."""
        low, high = span
        count, own = f"nt + {high - low}", self.run(stages, low)
        extra: list[tuple[str, Any]] = []
        changed: dict[str, Any] = {}
        behind: list[dict[str, Any]] = []
        masks: dict[int, tuple[Row, Any]] = {}
        for k, stage in enumerate(guarded):
            inputs = self.inputs(stage, low, own, low)
            self.emit(f"hit{k} = 0")
            asks = stage.guard(self.parts, self.ratio, *inputs)  # type: ignore[misc]
            extra.append((f"hit{k} = hit{k} | {{}}", asks))
            if stage.sparse:
                masks[k] = self.new_row(low), self.graph.node("where", asks, 1.0, 0.0)
            behind.append(dict(zip(stage.writes, stage.compute(self.parts, self.ratio, *inputs), strict=True)))
            changed |= behind[-1]
            later = later | {read.field for read in self.reads(stage)} | set(stage.writes if stage.sparse else ())
        largest = self.graph.node("load", "smx[j]")
        if "fastest" in own and "fastest" not in changed:
            extra.append(("smx[j] = {}", self.graph.node("maximum", own["fastest"], largest)))
        if first and self.problem.model.defines("hyperbolic_discriminant"):
            self.emit("doubt = 0")
            extra.append(("doubt = doubt | {}", self.suspect(*self.face(low))))
        kept = {name: value for name, value in own.items() if name in later}
        writes = self.store(kept, low, changed)
        self.loop(count, [*writes, *masks.values()], low, extra, always=True)
        rows = {value.index: row.at(low) for row, value in writes if isinstance(value, Expr)}
        for k, values in enumerate(behind):
            self.emit(f"if hit{k} != 0:")
            if k in masks:
                self.where_asked(count, masks[k][0], self.restore(values), low, rows)
            else:
                self.loop(count, self.restore(values), low, [], depth=2, rows=rows)
        if "fastest" in changed:
            self.loop(count, [], low, [("smx[j] = {}", self.graph.node("maximum", self.value("fastest", low, {}, low), largest))])

    def where_asked(self, count: str, mask: Row, writes: list[tuple[Row, Any]], low: int, rows: dict[int, str]) -> None:
        """The loop of a sparse stage over the places where the loop before has left no 0 in ``mask``.

        They are listed first: a condition inside the loop would be vectorised, and everything computed everywhere.
        """
        self.emit("places = 0", 2)
        self.emit(f"for j in range({count}):", 2)
        self.emit(f"if {mask.at(low)} != 0.0:", 3)
        self.emit(f"buf[{mask.number * (TILE + SPARE)} + places] = j", 4)
        self.emit("places += 1", 4)
        self.emit("for k in range(places):", 2)
        self.emit(f"j = int(buf[{mask.number * (TILE + SPARE)} + k])", 3)
        self.compute(writes, low, [], 3, rows=rows)

    def run(self, stages: list[Stage], low: int) -> dict[str, Any]:
        """Symbols of what stages that share a loop write, at ``low``."""
        own: dict[str, Any] = {}
        for stage in stages:
            own |= dict(zip(stage.writes, stage.compute(self.parts, self.ratio, *self.inputs(stage, low, own, low)), strict=True))
        return own

    def face(self, place: int) -> tuple[Any, Any]:
        """Symbols of the states on both sides of the face at loop variable + place."""
        left, right = (tuple(self.load(row, place + offset) for row in self.fields["q"]) for offset in (-1, 0))
        return left, right

    def suspect(self, ql: Any, qr: Any) -> Any:
        """Symbol of whether a face may have lost hyperbolicity, so that it is worth counting."""
        return self.parts.model.may_lose_hyperbolicity(ql, qr) if self.problem.model.defines("may_lose_hyperbolicity") else True

    def count_lost(self) -> None:
        """Count the faces with complex speeds, and keep the first, where the first loop saw reason to doubt."""
        if not self.problem.model.defines("hyperbolic_discriminant"):
            return
        self.emit("if doubt != 0:")
        self.loop("nt + closing", [], 0, [
            ("if {} != 0:", self.parts.model.hyperbolic_discriminant(*self.face(0)) < 0.0), ("    found[0] += 1", None),
            ("    if found[1] < 0:", None), ("        found[1] = c0 + j", None)], depth=2)

    def update(self, group: tuple[tuple[int, int], list[Stage]]) -> None:
        """The loop that makes new cells, with the sources of the last share of the step, and copies them out."""
        (low, _), stages = group
        own = self.run(stages, low)
        self.emit("bad = 0")
        if self.staged:
            new, extra = tuple(-1.0 * net for net in own["net"]), []
        else:
            q, aux = (self.loaded(self.fields[name], low) for name in ("q", "aux"))
            new = self.finished(tuple(row - self.ratio * net for row, net in zip(q, own["net"], strict=True)), aux)
            extra = [("bad = bad | (1 - {})", self.good(new))]
        rows = tuple(self.new_row(0) for _ in new)
        self.loop("nt", list(zip(rows, new, strict=True)), 0, extra)
        for k, row in enumerate(rows):
            self.emit(f"dst = out[{k}, c0 + {self.plan.halo}:c0 + {self.plan.halo} + nt]")
            self.emit("for j in range(nt):")
            self.emit(f"dst[j] = {row.at(0)}", 2)
        if "to_left" in self.light:
            self.end_fluxes()
        self.emit("return bad")

    def finished(self, q: Any, aux: Any) -> Any:
        """Symbols of a state after the sources of the last share of the step, settled."""
        if self.scheme.splitting.after > 0.0:
            q = self.act(q, aux, self.after, self.parts.sources[::-1])
        return self.parts.model.settle(q) if self.problem.model.defines("settle") else q

    def ends(self) -> list[str]:
        """Text of ``opening`` and ``finish``: what a staged step does to nt cells from c0 before and after its sweeps."""
        rows, halo = len(self.problem.model.conserved), self.plan.halo
        text: list[str] = []
        for name in ("opening", "finish"):
            state = tuple(self.graph.node("load", f"q[{k}, c0 + {halo} + j]") for k in range(rows))
            aux = tuple(self.graph.node("load", f"aux[{k}, c0 + j]") if varies else 0.0 for k, varies in enumerate(self.varies))
            self.emit("bad = 0")
            self.emit("for j in range(nt):")
            if name == "opening":
                new = self.act(state, aux, self.before, self.parts.sources)
                names = self.assign(list(new), 2, fixed=True)
            else:
                new = self.finished(state, aux)
                *names, good = self.assign([*new, self.good(new)], 2, fixed=True)
                self.emit(f"bad = bad | (1 - {good})", 2)
            for k, value in enumerate(names):
                self.emit(f"q[{k}, c0 + {halo} + j] = {value}", 2)
            self.emit("return bad")
            text += [f"def {name}(q, aux, c0, nt, before, after, par):", *self.lines, "", ""]
            self.lines = []
        return text

    def good(self, q: Any) -> Any:
        """Symbol of whether a state may be accepted."""
        total = q[0]
        for component in q[1:]:
            total = total + component
        result = self.graph.node("isfinite", total)
        for row in self.problem.model.mass_rows():
            result = result & (q[row] >= 0.0)
        if self.problem.model.defines("admissible"):
            result = result & self.parts.model.admissible(q)
        return result

    def close_walls(self) -> None:
        """Let no mass pass a closed end of the grid."""
        for part, test, face in zip(self.boundary, ("c0 == 0", "closing == 1"), ("0", "nt"), strict=True):
            rows = [row for row in self.fields.get("carried", ()) if isinstance(row, Row)]
            if part.closed and rows:
                self.emit(f"if {test}:")
                self.emit(f"j = {face}", 2)
                for row in rows:
                    self.emit(f"{row.at(0)} = 0.0", 2)

    def end_fluxes(self) -> None:
        """Leave the mass fluxes of the tile's first and last face in ``ends``."""
        rows = self.problem.model.mass_rows()
        if not rows or self.problem.boundary[0].reads == "opposite":
            return
        for k, face in enumerate(("0", "nt")):
            self.emit(f"j = {face}")
            names = self.assign([self.value("to_left", 0, {}, 0)[row] for row in rows], 1)
            for position, name in enumerate(names):
                self.emit(f"ends[{k}, {position}] = {name}")

    # ------------------------------------------------------------------ boundaries

    def ghosts(self) -> list[str]:
        """Text of ``ghosts``: fill the ghost cells of a padded state; ``values`` holds what the boundaries give."""
        halo, model = self.plan.halo, self.problem.model
        self.emit("def ghosts(q, n, par, values):", 0)
        for side, part in enumerate(self.boundary):
            left = side == 0
            given = part.values(model, self.problem.t_start)
            symbols = tuple(self.graph.node("uniform", f"values[{side}, {k}]") for k in range(len(given)))
            for layer in range(halo):
                cell = {"opposite": f"n + {layer}" if left else f"{halo + layer}",
                        "mirror": f"{2 * halo - 1 - layer}" if left else f"n + {halo - 1 - layer}",
                        "nearest": f"{halo}" if left else f"n + {halo - 1}"}[part.reads]
                state = tuple(self.graph.node("load", f"q[{k}, {cell}]") for k in range(len(model.conserved)))
                result = part.ghost(self.parts.model, state, symbols)
                for k, name in enumerate(self.assign(list(result), 1, fixed=True)):
                    self.emit(f"q[{k}, {layer if left else f'n + {halo + layer}'}] = {name}")
        self.emit("return")
        text, self.lines = self.lines, []
        return text


def generate(problem: Problem, scheme: Scheme, parts: Parts, plan: Plan, source_plan: Plan | None, varies: list[bool]) -> Source:
    """Return the text of the kernel's own part: ``tile`` and ``ghosts``, and for a staged scheme ``opening``, ``finish`` and,
    with implicit sources, ``source_tile``. ``varies`` says which given functions are not zero everywhere.

    Raises
    ------
    Untraceable
        With the method, file and line of the pointwise code that only whole arrays can run.
    """
    generator = Generator(problem, scheme, parts, plan, varies)
    pieces, blocks, rows = [_located(generator.tile), _located(generator.ghosts)], generator.blocks, generator.rows
    if generator.staged:
        pieces.append(_located(generator.ends))
        if source_plan is not None:
            implicit = Generator(problem, scheme, parts, source_plan, varies, prefix="source_")
            pieces.append(_located(implicit.tile))
            blocks, rows = blocks + implicit.blocks, max(rows, implicit.rows)
    content = [made.text() for made in blocks]
    return Source("\n".join([*content, *(line for piece in pieces for line in ("", "", *piece)), ""]), tuple(blocks), rows)


def _located(build: Callable[[], list[str]]) -> list[str]:
    """Run a part of the generator; name method, file and line where pointwise code cannot be traced."""
    try:
        return build()
    except Untraceable as error:
        trace, frames = error.__traceback__, []
        while trace is not None:
            frames.append((trace.tb_frame.f_code, trace.tb_lineno))
            trace = trace.tb_next
        users = [(code, line) for code, line in frames if "/fvkit/backends/" not in code.co_filename.replace("\\", "/")]
        code, line = users[-1] if users else frames[-1]
        raise Untraceable(f"{code.co_qualname} ({code.co_filename}:{line}): {error}; "
                          'backend="numpy" runs it as it is') from None
