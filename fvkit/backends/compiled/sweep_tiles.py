"""Generated code of a sweep along one axis of a grid with two: the same stage loops, over pieces of lines.

Along x a tile is a piece of one line of the memory. Along y it is `LANES` lines side by side, so that neighbours along the axis
lie that far apart and nothing is transposed; a block at the edge that has fewer lines repeats its last one.

A sweep may write where it reads. The cells before a piece are then new already: what they were stands in scratch, from the piece
before.
"""

from typing import Any, NamedTuple

from fvkit.backends.compiled.generator import Generator, Source, located
from fvkit.backends.compiled.loops import SPARE, TILE, Row
from fvkit.backends.plan import Plan
from fvkit.backends.sweeps import FIRST, LAST
from fvkit.problem.directions import Direction
from fvkit.problem.model import Model
from fvkit.problem.turned import momenta, with_momenta
from fvkit.schemes.scheme import MASS_FLUX, MOVED, PULLS, Parts, Scheme

#: Lines that lie side by side in a tile of a sweep along y, and entries of a row of scratch.
LANES, LENGTH = 16, 2 * TILE + SPARE


class AxisProblem(NamedTuple):
    """The problem as the generator of a sweep uses it: the equations along the axis. Ghost cells are filled elsewhere."""

    model: Model
    ends: tuple[Any, ...] = ()


class SweepGenerator(Generator):
    """Builds the text of the tiles of one sweep."""

    arguments = ("q, out, aux, other, line, w, n, c0, nt, closing, place, before, ratio, par, gates, gated, buf, smx, through, "
                 "found")

    def __init__(self, direction: Direction, scheme: Scheme, parts: Parts, plan: Plan, varies: list[bool],
                 prefix: str = "") -> None:
        self.direction, self.pitch, self.length = direction, LANES if direction.number else 1, LENGTH
        super().__init__(AxisProblem(direction.model), scheme, parts, plan, varies, prefix)  # type: ignore[arg-type]  # all that is used
        self.given += len(direction.across)
        self.real_place, self.number_of_face = (f" and j % {LANES} < w", f"(min(c0 + j // {LANES}, n - 1)) * (q.shape[2] - "
                                                f"{2 * plan.halo}) + line - {plan.halo} + j % {LANES}") if direction.number else \
            ("", f"(line - {plan.halo}) * n + min(c0 + j, n - 1)")

    def copy_in(self) -> None:
        """Copy the tile's cells and halo into scratch, without those that the piece before it has left there: ``before`` is its
        number of cells, 0 where it is another's or has been written elsewhere.
        """
        halo = self.plan.halo
        self.fields["q"] = tuple(self.new_row(-halo) for _ in self.direction.rows)
        self.fields["aux"] = tuple(self.new_row(-halo) if varies else 0.0 for varies in self.varies)
        self.fields["across"] = tuple(self.new_row(-halo) for _ in self.direction.across)
        rows = [*(("q", k, row) for k, row in zip(self.direction.rows, self.fields["q"], strict=True)),
                *(("aux", k, row) for k, row in enumerate(self.fields["aux"]) if isinstance(row, Row)),
                *(("q", k, row) for k, row in zip(self.direction.across, self.fields["across"], strict=True))]
        self.emit(f"skip = {2 * halo} if before != 0 else 0")
        for name, k, row in rows:
            if name == "q":
                self.emit("if before != 0:")
                self.emit(f"move(buf, {row.start}, buf, {row.start} + before * {self.pitch}, {2 * halo * self.pitch})", 2)
                self.copy_row(name, k, row, "skip")
            elif self.direction.across and k == len(self.varies) - 1:
                self.emit(f"if place == {FIRST}:")
                self.emit(f"for j in range({self.span(2 * halo)}):", 2)
                self.emit(f"buf[{row.start} + j] = 0.0", 3)
                self.emit("else:")
                self.copy_row(name, k, row, depth=2)
            else:
                self.copy_row(name, k, row)

    def copy_row(self, name: str, k: int, row: Row, first: str = "0", depth: int = 1) -> None:
        """Copy a component of the lines of a tile into a row, from its place ``first`` on."""
        width = f"nt + {2 * self.plan.halo}"
        if self.pitch == 1:
            self.emit(f"move(buf, {row.start} + {first}, {name}[{k}, line], c0 + {first}, {width} - {first})", depth)
            return
        self.emit(f"if w == {LANES}:", depth)
        self.emit(f"for i in range({first}, {width}):", depth + 1)
        self.emit(f"move(buf, {row.start} + i * {LANES}, {name}[{k}, c0 + i], line, {LANES})", depth + 2)
        self.emit("else:", depth)
        self.emit(f"for i in range({first}, {width}):", depth + 1)
        self.emit(f"for j in range({LANES}):", depth + 2)
        self.emit(f"buf[{row.start} + i * {LANES} + j] = {name}[{k}, c0 + i, line + min(j, w - 1)]", depth + 3)

    def copy_out(self, row: Row, place: int, target: str = "out", depth: int = 1) -> None:
        """Copy a row into the cells of a component of ``out`` or another array."""
        halo = self.plan.halo
        if self.pitch == 1:
            self.emit(f"move({target}[{place}, line], c0 + {halo}, buf, {row.start}, nt)", depth)
            return
        self.emit(f"if w == {LANES}:", depth)
        self.emit("for i in range(nt):", depth + 1)
        self.emit(f"move({target}[{place}, c0 + {halo} + i], line, buf, {row.start} + i * {LANES}, {LANES})", depth + 2)
        self.emit("else:", depth)
        self.emit("for i in range(nt):", depth + 1)
        self.emit("for j in range(w):", depth + 2)
        self.emit(f"{target}[{place}, c0 + {halo} + i, line + j] = buf[{row.start} + i * {LANES} + j]", depth + 3)

    def set_mass_fluxes(self) -> None:
        """Impose the mass fluxes of the conditions at a side, and leave those of both sides in ``through``."""
        rows = [row for row in self.fields.get(MASS_FLUX, ()) if isinstance(row, Row)]
        lane, lanes = ("j", "w") if self.pitch > 1 else ("0", "1")
        for side, test, face in ((0, "c0 == 0", "0"), (1, "closing == 1", f"nt * {self.pitch}")):
            self.emit(f"if {test}:")
            self.emit(f"for j in range({lanes}):", 2)
            self.emit(f"lane = line - {self.plan.halo} + {lane}", 3)
            self.emit(f"if gated[{side}, lane] != 0:", 3)
            for k, row in enumerate(rows):
                self.emit(f"{self.entry(row, face)} = gates[{side}, {k}, lane]", 4)
            self.emit("else:", 3)
            for k, row in enumerate(rows):
                self.emit(f"gates[{side}, {k}, lane] = {self.entry(row, face)}", 4)
            if not rows:
                self.emit("pass", 4)

    def entry(self, row: Row, face: str) -> str:
        """Text of the entry of line j at a face."""
        return f"buf[{row.start - row.low * self.pitch} + {face} + j]"

    def update(self, group: tuple[tuple[int, int], list[Any]]) -> None:
        """The loop that makes the new state, settled and judged at the `LAST` place of a step, and copies it out."""
        (low, _), stages = group
        own = self.run(stages, low)
        self.emit("bad, total, least = 0, 0.0, 0.0")
        if PULLS in own:
            rows = [self.new_row(0) for _ in own[PULLS]]
            self.loop(self.span(), list(zip(rows, own[PULLS], strict=True)), 0, [])
            for place, row in enumerate(rows):
                self.copy_out(row, place)
            self.emit("return bad")
            return
        new = own[MOVED]
        count = len(self.direction.rows) + len(self.direction.across)
        squeezes, new = new[count:], new[:count]
        rows = [self.new_row(0) for _ in new]
        self.emit(f"if place == {LAST}:")
        settled = self.settled(new)
        first = len(self.direction.rows)
        self.loop(self.span(), list(zip(rows, settled, strict=True)), 0, self.judging(settled[:first], *settled[first:]), depth=2)
        self.judge(2)
        self.emit("else:")
        self.loop(self.span(), list(zip(rows, new, strict=True)), 0, [], depth=2)
        for row, place in zip(rows, (*self.direction.rows, *self.direction.across), strict=True):
            self.copy_out(row, place)
        if squeezes:
            row = self.new_row(0)
            self.emit(f"if place == {FIRST}:")
            self.loop(self.span(), [(row, squeezes[0])], 0, [], depth=2)
            self.copy_out(row, len(self.varies) - 1, "other", depth=2)
        self.emit("return bad")

    def settled(self, new: Any) -> Any:
        """Symbols of a state without the momenta, along and across, of layers that are too thin to move."""
        model, own = self.parts.model, len(self.direction.rows)
        if not self.problem.model.defines("settle"):
            return new
        first = model.settle(new[:own])
        return (*first, *momenta(model, model.settle(with_momenta(model, first, new[own:]))))


#: All jobs of a sweep, or of a share of it: pieces of lines, each a row with line, number of lines, first cell and cells.
#: ``tile`` is called by its address ``at``, the same loop for all. ``inside`` is 1 where ``out`` is ``q``.
DRIVER = '''
def sweep(at, jobs, q, out, aux, other, n, place, inside, ratio, par, gates, gated, buf, smx, through, found):
    wide()
    found[:] = 0
    found[1] = -1
    for j in range(smx.shape[0]):
        smx[j] = 0.0
    bad = 0
    for k in range(jobs.shape[0]):
        closing = 1 if jobs[k, 2] + jobs[k, 3] == n else 0
        before = 0
        if inside != 0 and k > 0 and jobs[k - 1, 0] == jobs[k, 0] and jobs[k - 1, 2] + jobs[k - 1, 3] == jobs[k, 2]:
            before = jobs[k - 1, 3]
        bad = bad | tile(at, q, out, aux, other, jobs[k, 0], jobs[k, 1], n, jobs[k, 2], jobs[k, 3], closing, place, before,
                         ratio, par, gates, gated, buf, smx, through, found)
    speed = 0.0
    for j in range(smx.shape[0]):
        speed = smx[j] if smx[j] > speed or smx[j] != smx[j] else speed
    return speed, bad

'''


def generate_sweep(direction: Direction, scheme: Scheme, parts: Parts, plan: Plan, pulling: Plan | None,
                   varies: list[bool]) -> Source:
    """Return the text of ``tile`` of a sweep along an axis, and of ``pull_tile`` where sources act across it."""
    text: list[str] = []
    blocks: tuple[Any, ...] = ()
    rows = 0
    for prefix, stages in (("", plan), ("pull_", pulling)):
        if stages is None:
            continue
        made = SweepGenerator(direction, scheme, parts, stages, varies, prefix)
        text += ["", "", *located(made.tile)]
        blocks, rows = (*blocks, *made.blocks), max(rows, made.rows)
    return Source("\n".join([*(one.text() for one in blocks), *text]), blocks, rows)


def signatures(numba: Any) -> tuple[Any, Any]:
    """Return the types of ``tile`` and of the arguments of ``sweep``."""
    real, whole = numba.float64, numba.int64
    rows, row = real[:, ::1], real[::1]
    cells, common = 4 * (real[:, :, :],), (real, row, real[:, :, ::1], whole[:, ::1], row, row, rows, whole[::1])
    return whole(*cells, *(8 * [whole]), *common), (whole, whole[:, ::1], *cells, whole, whole, whole, *common)
