"""The kernel generator: stages become loops over tiles, straight enough for the compiler to vectorise.

A tile of cells is copied into one scratch buffer, every field a row at a fixed offset; each group of stages is one loop
from 0; the new cells are copied out. Rows are longer than a page, offsets are constants, nothing is indexed from below:
each of these was measured to matter by a factor. Stages that cover the same range and read each other's fields only at
offset 0 share a loop; a light stage is computed again where it is read; stages with a guard have their own loops, behind
tests of the whole tile (`tile_bounds`), and where these leave it open, of its faces. Divisions and roots that look at one
cell only, and that faces ask of both their cells, are computed once per cell beforehand. A given function that is zero
everywhere, such as a flat bottom, is a literal 0 and makes no code.
"""

from collections.abc import Callable
from functools import reduce
from itertools import takewhile
from operator import or_
from typing import Any

import attrs

from fvkit.backends.compiled.cell_updates import Ends
from fvkit.backends.compiled.llvm import Block, is_condition
from fvkit.backends.compiled.loops import Row
from fvkit.backends.compiled.tile_bounds import Term, opened, summed, taken
from fvkit.backends.march import FILM, MICRO
from fvkit.backends.numpy_stages import deepness
from fvkit.backends.plan import Plan
from fvkit.pointwise.contract import users
from fvkit.pointwise.rare import chosen, usually
from fvkit.pointwise.tracing import Expr, Untraceable, chosen_among, keeping_nan
from fvkit.problem.answers import at_face
from fvkit.problem.problem import Problem
from fvkit.problem.sources import brought
from fvkit.schemes.scheme import MASS_FLUX, NET, NEW, SPEED, Parts, Scheme, Stage


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


class Generator(Ends):
    """Builds the text of one kernel from its stages."""

    arguments = "q, out, aux, edges, n, c0, nt, closing, ratio, before, after, par, values, buf, smx, ends, found"

    #: What a face with complex speeds must fulfil besides, and its number.
    real_place, number_of_face = "", "c0 + j"

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
            if self.plan.last_mass_flux in (*groups[k - 1][1], *guarded):
                self.set_mass_fluxes()
        if k:
            self.count_lost()
        self.update(groups[-1])
        self.lines[start:start] = self.per_cell()
        body, self.lines = self.lines, []
        self.emit(f"def {self.prefix}tile({self.arguments}):", 0)
        uniform = [node for node in self.graph.nodes
                   if node.uniform and node.operation != "uniform" and not is_condition(node)]
        for node, name in zip(uniform, self.assign(list(uniform), 1, fixed=True), strict=True):
            self.emit(f"u{node.index} = {name}")
        text, self.lines = self.lines + body, []
        return text

    def groups(self) -> list[tuple[tuple[int, int], list[Stage]]]:
        """Consecutive stages that share a loop."""
        result: list[tuple[tuple[int, int], list[Stage]]] = []
        for stage, span in zip(self.plan.stages, self.plan.ranges, strict=True):
            if stage.light:
                continue
            shares = bool(result) and result[-1][0] == span and stage.guard is None and result[-1][1][0].guard is None
            if shares:
                written = {name for earlier in result[-1][1] for name in earlier.writes}
                shares = all(read.field not in written or read.here for read in self.reads(stage))
            if shares:
                result[-1][1].append(stage)
            else:
                result.append((span, [stage]))
        return result

    def remaining_reads(self) -> list[set[str]]:
        """For each group, the fields that groups after it read, or that the step itself needs."""
        result: list[set[str]] = []
        wanted = {MASS_FLUX}
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
            self.copy(f"q[{k}]", "c0", width, row, "0")
        self.fields["aux"] = tuple(self.new_row(-halo) if varies else 0.0 for varies in self.varies)
        rows = [(k, row) for k, row in enumerate(self.fields["aux"]) if isinstance(row, Row)]
        if rows:
            self.emit(f"low = max(c0 - {halo}, 0)")
            self.emit(f"high = min(c0 + nt + {halo}, n)")
        for k, row in rows:
            self.copy(f"aux[{k}]", "low", "high - low", row, f"low - c0 + {halo}")
            self.copy(f"edges[{k}]", "c0", f"{halo} - c0", row, "0")
            self.copy(f"edges[{k}]", f"{halo}", f"c0 + nt + {halo} - n", row, f"n - c0 + {halo}")
        if self.opens:  # ghost cells have been filled from cells on which the sources have acted
            q, aux = (self.loaded(self.fields[name], -halo) for name in ("q", "aux"))
            state = self.act(q, aux, self.before, self.parts.beside)
            gains = brought(self.parts.model.mass_rows(), q, state)
            counted = [(k, self.new_row(-halo)) for k, _ in gains]
            changes = [(row, change) for (_, row), (_, change) in zip(counted, gains, strict=True)]
            self.emit(f"for j in range(max({halo} - c0, 0), min({width}, n + {halo} - c0)):")
            self.compute([*zip(self.fields["q"], state, strict=True), *changes], -halo, [], 2)
            self.count_brought(counted)

    def copy(self, source: str, start: str, count: str, row: Row, first: str) -> None:
        """Copy ``count`` numbers from ``start``, none if it is negative, into a row from its entry ``first`` on."""
        self.emit(f"move(buf, {row.start} + {first}, {source}, {start}, {count})")

    def stage_loop(self, span: tuple[int, int], stages: list[Stage], guarded: list[Stage], later: set[str],
                   first: bool) -> None:
        """The loop of a group, and behind tests, see `asked`, those of the guarded stages that follow it.

        A group that uses `fvkit.rarely` has two versions of its loop, and a short loop that chooses.
        """
        low, high = span
        count = self.span(high - low)
        self.twofold = {}
        usual, conditions = usually(self.graph, lambda: self.run(stages, low))
        versions, rare = [usual], reduce(or_, conditions, False)
        if conditions:  # the usual value stays to the bit where it is usual: both sides of a face may see it from two tiles
            versions.append(chosen(rare, self.run(stages, low), usual))
        later = later.union(*({read.field for read in self.reads(stage)} | set(stage.writes if stage.sparse else ())
                              for stage in guarded))
        own = usual | {name: self.shared(value, versions[-1][name], low) for name, value in usual.items() if name in later}
        changed: dict[str, Any] = {}
        behind: list[dict[str, Any]] = []
        for stage in guarded:
            behind.append(stage.run(self.parts, self.ratio, self.inputs(stage, low, own, low)))
            changed |= behind[-1]

        writes = self.store({name: value for name, value in own.items() if name in later}, low, changed)
        asks = {f"hit{k}": stage.guard(self.parts, self.ratio, **self.inputs(stage, low, own, low))  # type: ignore[misc]  # they have one
                for k, stage in enumerate(guarded)}
        if first and self.problem.model.defines("hyperbolic_discriminant"):
            asks["doubt"] = self.may_be_lost(low)
        maybe, terms = self.bounds.may_hold(list(asks.values()), {value.index for _, value in writes if isinstance(value, Expr)})
        if conditions:
            self.choose_version(count, rare, low)
        for line in ("faces, speeds, fastest = 0.0, 0.0, 0.0", *opened(terms)):
            self.emit(line)
        usual_block: Block | None = None
        for which, values in enumerate(versions):
            if conditions:
                self.emit("else:" if which else "if rare == 0:")
            extra = self.extremes(terms if which == 0 else [], values.get(SPEED))
            usual_block = self.loop(count, self.version(writes, which), low, extra, depth=2 if conditions else 1,
                                    always=which == 0, like=usual_block, beside=asks.values())
            if which and terms:
                self.emit("faces = 1e999", 2)  # no bounds: every face is asked
        rows = {value.index: row.at(low) for row, value in writes if isinstance(value, Expr)}
        masks = {k: self.new_row(low) for k, stage in enumerate(guarded) if stage.sparse}
        self.asked(count, asks, maybe, masks, low, rows)
        for k, values in enumerate(behind):
            self.emit(f"if hit{k} != 0:")
            if k in masks:
                self.where_asked(count, masks[k], self.restore(values), low, rows)
            else:
                self.loop(count, self.restore(values), low, [], depth=2, rows=rows)
        if SPEED in usual:
            self.keep_largest_speed(count, low, [k for k, values in enumerate(behind) if SPEED in values])

    def extremes(self, terms: list[Term], speed: Any) -> list[tuple[str, Any]]:
        """Lines of the first version of a loop that takes the extremes of terms, and the largest speed, if it computes one."""
        nodes = [self.in_version(term.node, 0) for term in terms]
        lines, among = taken(terms, nodes), chosen_among(speed)
        if speed is not None:
            lines += [("fastest = higher(fastest, {})", speed), *summed("speeds", [keeping_nan(speed)])]
        return lines + summed("faces", [node for term, node in zip(terms, nodes, strict=True)
                                        if not term.given and node.index not in among])

    def choose_version(self, count: str, rare: Any, low: int) -> None:
        """The loop that leaves in ``rare`` whether a face needs the second version of a loop, where bounds leave that open."""
        maybe, terms = self.bounds.may_hold([rare], set())
        for line in ("rare, faces = 0, 0.0", *opened(terms)):
            self.emit(line)
        if terms:
            self.loop(count, [], low, self.extremes(terms, None))
        self.emit(f"if {self.assign([maybe | self.bounds.beyond_bounds('cells', 'faces')], 1)[0]}:")
        self.loop(count, [], low, [("rare = rare | {}", rare)], depth=2)

    def asked(self, count: str, asks: dict[str, Any], maybe: Any, masks: dict[int, Row], low: int, rows: dict[int, str]) -> None:
        """The loop that leaves in each name whether its condition holds at a face, where bounds over the tile leave that open."""
        for name in asks:
            self.emit(f"{name} = 0")
        if not asks:
            return
        self.emit(f"if {self.assign([maybe | self.bounds.beyond_bounds('cells', 'faces', 'speeds')], 1)[0]}:")
        marks = [(row, self.graph.node("where", asks[f"hit{k}"], 1.0, 0.0)) for k, row in masks.items()]
        self.loop(count, marks, low, [(f"{name} = {name} | {{}}", value) for name, value in asks.items()], depth=2, rows=rows)

    def keep_largest_speed(self, count: str, low: int, hits: list[int]) -> None:
        """Lines that keep the largest speed, NaN if any is; ``hits`` are the numbers of guarded stages that change it."""
        self.emit(f"if {' and '.join(f'hit{k} == 0' for k in hits) or 'True'}:")
        self.emit("smx[0] = fastest if fastest > smx[0] else smx[0]", 2)
        self.emit("if speeds - speeds != 0.0:", 2)
        self.emit("smx[0] = speeds - speeds", 3)
        if hits:
            self.emit("else:")
            fastest = self.graph.node("maximum", self.value(SPEED, low, {}, low), self.graph.node("load", "smx[j]"))
            self.loop(count, [], low, [("smx[j] = {}", keeping_nan(fastest))], depth=2)

    def may_be_lost(self, low: int) -> Any:
        """Symbol of whether the speeds of a face may be complex."""
        if not self.problem.model.defines("may_lose_hyperbolicity"):
            return True
        return at_face(self.parts.model, "may_lose_hyperbolicity", *self.face(low, "q", "aux"))

    def where_asked(self, count: str, mask: Row, writes: list[tuple[Row, Any]], low: int, rows: dict[int, str]) -> None:
        """The loop of a sparse stage over the places where the loop before has left no 0 in ``mask``.

        They are listed first: a condition inside the loop would be vectorised, and everything computed everywhere.
        """
        self.emit("places = 0", 2)
        self.emit(f"for j in range({count}):", 2)
        self.emit(f"if {mask.at(low)} != 0.0:", 3)
        self.emit(f"buf[{mask.start} + places] = j", 4)
        self.emit("places += 1", 4)
        self.emit("for k in range(places):", 2)
        self.emit(f"j = int(buf[{mask.start} + k])", 3)
        self.compute(writes, low, [], 3, rows=rows)

    def face(self, place: int, *names: str) -> tuple[Any, ...]:
        """Symbols of fields on both sides of the face at loop variable + place."""
        return tuple(self.loaded(self.fields[name], place + offset) for name in names for offset in (-1, 0))

    def count_lost(self) -> None:
        """Count the faces with complex speeds, and keep the first, where the first loop saw reason to doubt."""
        if not self.problem.model.defines("hyperbolic_discriminant"):
            return
        lost = at_face(self.parts.model, "hyperbolic_discriminant", *self.face(0, "q", "aux")) < 0.0
        lines = [(f"if {{}} != 0{self.real_place}:", lost),
                 ("    found[0] += 1", None), ("    if found[1] < 0:", None), (f"        found[1] = {self.number_of_face}", None)]
        deep = deepness(self.parts.model, *self.face(0, "q"))
        if deep is not None:
            lines += [(f"    if {{}} < {FILM * MICRO}:", deep), ("        found[2] += 1", None),
                      ("    found[3] = max(found[3], int({}))", deep)]
        self.emit("if doubt != 0:")
        self.loop(self.span("closing"), [], 0, lines, depth=2)

    def update(self, group: tuple[tuple[int, int], list[Stage]]) -> None:
        """The loop that makes new cells, with the sources of the last share of the step, and copies them out."""
        (low, _), stages = group
        own = self.run(stages, low)
        extra: list[tuple[str, Any]] = []
        gains: list[tuple[int, Any]] = []
        self.emit("bad, total, least = 0, 0.0, 0.0")
        if self.staged:
            new = tuple(-1.0 * net for net in own[NET])
        else:
            q, aux = (self.loaded(self.fields[name], low) for name in ("q", "aux"))
            moved = own.get(NEW) or tuple(row - self.ratio * net for row, net in zip(q, own[NET], strict=True))
            new, gains = self.finished(moved, aux)
            extra += self.judging(new)
        rows, counted = tuple(self.new_row(0) for _ in new), [(k, self.new_row(0)) for k, _ in gains]
        changes = [(row, change) for (_, row), (_, change) in zip(counted, gains, strict=True)]
        self.loop("nt", [*zip(rows, new, strict=True), *changes], 0, extra)
        if not self.staged:
            self.judge()
        self.count_brought(counted)
        for k, row in enumerate(rows):
            self.emit(f"move(out[{k}], c0 + {self.plan.halo}, buf, {row.start}, nt)")
        if MASS_FLUX in self.fields:
            self.end_fluxes()
        self.emit("return bad")


def generate(problem: Problem, scheme: Scheme, parts: Parts, plan: Plan, source_plan: Plan | None, varies: list[bool]) -> Source:
    """Return the text of the kernel's own part: ``tile`` and ``ghosts``, and for a staged scheme ``opening``, ``finish`` and,
    with implicit sources, ``source_tile``. ``varies`` marks the given functions that are not zero everywhere.
    """
    generator = Generator(problem, scheme, parts, plan, varies)
    pieces, blocks, rows = [located(generator.tile), located(generator.ghosts)], generator.blocks, generator.rows
    if generator.staged:
        pieces += [located(generator.ends), generator.extend()]
        if source_plan is not None:
            implicit = Generator(problem, scheme, parts, source_plan, varies, prefix="source_")
            pieces.append(located(implicit.tile))
            blocks, rows = blocks + implicit.blocks, max(rows, implicit.rows)
    content = [made.text() for made in blocks]
    return Source("\n".join([*content, *(line for piece in pieces for line in ("", "", *piece)), ""]), tuple(blocks), rows)


def located(build: Callable[[], list[str]]) -> list[str]:
    """Run a part of the generator; name function, file and line of a stage of the user's own that cannot be traced."""
    try:
        return build()
    except Untraceable as error:
        found = users(error)
        if found is None:
            raise
        code, line = found
        raise Untraceable(f'{code.co_qualname} ({code.co_filename}:{line}): {error}; backend="numpy" runs it as it is') from None
