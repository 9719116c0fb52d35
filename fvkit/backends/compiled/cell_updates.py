"""Generated code around the stages: sources, admissibility, ghost cells, boundary fluxes."""

from typing import Any

from fvkit.backends.compiled.loops import Row, Writer
from fvkit.backends.compiled.tile_bounds import summed
from fvkit.backends.kernel import imposed
from fvkit.pointwise.tracing import Expr
from fvkit.problem.sources import brought
from fvkit.schemes.scheme import MASS_FLUX


class Ends(Writer):
    """What a kernel does to states before and after its stages, and at the ends of the grid."""

    def act(self, q: Any, aux: Any, dt: Expr, sources: tuple[Any, ...]) -> Any:
        """Symbols of a state after the steps of the sources."""
        for source in sources:
            q = source.step(self.parts.model, q, aux, dt)
        return q

    def count_brought(self, rows: list[tuple[int, Row]]) -> None:
        """Add rows of what sources bring up in ``ends``, in loops of their own: sums in order are not vectorised."""
        for k, row in rows:
            self.emit("total = 0.0")
            self.emit("for j in range(nt):")
            self.emit(f"total += {row.at(0)}", 2)
            self.emit(f"ends[2, {k}] += total")

    def finished(self, q: Any, aux: Any) -> tuple[Any, list[tuple[int, Any]]]:
        """Symbols of a state after the last part of the sources, settled, and the masses that they add, see `brought`."""
        after = self.act(q, aux, self.after, self.parts.beside[::-1]) if self.scheme.splitting.after > 0.0 else q
        gains = brought(self.parts.model.mass_rows(), q, after)
        return self.parts.model.settle(after) if self.problem.model.defines("settle") else after, gains

    def judging(self, q: Any, *others: Any) -> list[tuple[str, Any]]:
        """Lines of a loop by which `judge` says whether its states may be accepted; ``others`` must be finite, too.

        Without compares, which would take more time.
        """
        masses = [q[row] for row in self.problem.model.mass_rows()]
        lines = [*summed("total", [*q, *others]), *(("least = lower(least, {})", mass) for mass in masses)]
        if self.problem.model.defines("admissible"):
            lines.append(("bad = bad | (1 - {})", self.parts.model.admissible(q)))
        return lines

    def judge(self, depth: int = 1) -> None:
        """Lines after that loop: ``bad`` is 1 where a state may not be accepted."""
        self.emit("if not (total - total == 0.0 and least >= 0.0):", depth)
        self.emit("bad = 1", depth + 1)

    def ends(self) -> list[str]:
        """Text of ``opening`` and ``finish``: operations of a staged step on nt cells from c0 before and after its sweeps."""
        rows, halo = len(self.problem.model.conserved), self.plan.halo
        text: list[str] = []
        for name in ("opening", "finish"):
            state = tuple(self.graph.node("load", f"q[{k}, c0 + {halo} + j]") for k in range(rows))
            aux = tuple(self.graph.node("load", f"aux[{k}, c0 + j]") if varies else 0.0 for k, varies in enumerate(self.varies))
            self.emit("bad, total, least = 0, 0.0, 0.0")
            self.emit("for j in range(nt):")
            if name == "opening":
                new = self.act(state, aux, self.before, self.parts.beside)
                gains = brought(self.parts.model.mass_rows(), state, new)
            else:
                new, gains = self.finished(state, aux)
            lines = [(f"flux[2, {k}] += {{}}", change) for k, change in gains]
            if name == "finish":
                lines += self.judging(new)
            names = self.assign([*new, *(value for _, value in lines)], 2, fixed=True)
            for (line, _), value in zip(lines, names[len(new):], strict=True):
                self.emit(line.format(value), 2)
            for k, value in enumerate(names[:len(new)]):
                self.emit(f"q[{k}, c0 + {halo} + j] = {value}", 2)
            self.judge()
            self.emit("return bad")
            text += [f"def {name}(q, aux, c0, nt, before, after, par, flux):", *self.lines, "", ""]
            self.lines = []
        return text

    def extend(self) -> list[str]:
        """Text of ``extend``: the ghost cells of open ends get the state of the last cell, for sweeps of implicit sources."""
        halo = self.plan.halo
        text = ["def extend(q, n):", "    for k in range(q.shape[0]):", f"        for j in range({halo}):"]
        for side, part in enumerate(self.boundary):
            if part.reads == "nearest":
                ghost, cell = ("j", f"{halo}") if side == 0 else (f"n + {halo} + j", f"n + {halo - 1}")
                text.append(f"            q[k, {ghost}] = q[k, {cell}]")
        return [*text, "            pass", "    return"]

    def set_mass_fluxes(self) -> None:
        """Impose the mass fluxes of the boundary condition at an end of the grid."""
        rows = self.fields.get(MASS_FLUX, ())
        for side, (part, test, face) in enumerate(zip(self.boundary, ("c0 == 0", "closing == 1"), ("0", "nt"), strict=True)):
            fluxes = imposed(part, self.parts.model, self.values(side))
            if not fluxes or not rows:
                continue
            self.emit(f"if {test}:")
            self.emit(f"j = {face}", 2)
            for row, name in zip(rows, self.assign(list(fluxes), 2, fixed=True), strict=True):
                if isinstance(row, Row):
                    self.emit(f"if {name} == {name}:", 2)
                    self.emit(f"{row.at(0)} = {name}", 3)

    def values(self, side: int) -> tuple[Expr, ...]:
        """Symbols of the ghost states of the boundary condition of a side."""
        given = self.problem.ends[side].values(self.model, self.problem.t_start)
        return tuple(self.graph.node("uniform", f"values[{side}, {k}]") for k in range(len(given)))

    def end_fluxes(self) -> None:
        """Leave the mass fluxes of the tile's first and last face in ``ends``."""
        rows = self.problem.model.mass_rows()
        if not rows or self.problem.ends[0].reads == "opposite":
            return
        for k, face in enumerate(("0", "nt")):
            self.emit(f"j = {face}")
            names = self.assign(list(self.value(MASS_FLUX, 0, {}, 0)), 1)
            for position, name in enumerate(names):
                self.emit(f"ends[{k}, {position}] = {name}")

    @property
    def opens(self) -> bool:
        """Whether sources act before the transport, in the kernel of a scheme without time integrator."""
        return bool(self.parts.beside) and self.scheme.splitting.before > 0.0 and not self.staged

    def ghosts(self) -> list[str]:
        """Text of ``ghosts``: fill the ghost cells of a padded state; ``values`` are those of the boundaries.

        They copy cells after the sources of the first part of the step.
        """
        halo, model = self.plan.halo, self.problem.model
        self.emit("def ghosts(q, aux, n, before, par, values):", 0)
        for side, part in enumerate(self.boundary):
            left = side == 0
            for layer in range(halo):
                cell = {"opposite": f"n + {layer - halo}" if left else f"{layer}",
                        "mirror": f"{halo - 1 - layer}" if left else f"n - {1 + layer}",
                        "nearest": "0" if left else "n - 1"}[part.reads]
                state = tuple(self.graph.node("load", f"q[{k}, {cell} + {halo}]") for k in range(len(model.conserved)))
                if self.opens:
                    given = tuple(self.graph.node("load", f"aux[{k}, {cell}]") if varies else 0.0
                                  for k, varies in enumerate(self.varies))
                    state = self.act(state, given, self.before, self.parts.beside)
                values = part.layer(self.values(side), float(halo - layer if left else layer + 1))
                result = part.ghost(self.parts.model, state, values)
                for k, name in enumerate(self.assign(list(result), 1, fixed=True)):
                    self.emit(f"q[{k}, {layer if left else f'n + {halo + layer}'}] = {name}")
        self.emit("return")
        text, self.lines = self.lines, []
        return text
