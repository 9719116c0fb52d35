"""The NumPy backend: every stage of a scheme on whole arrays, in chunks where they are long."""

from collections.abc import Callable
from typing import Any, ClassVar

import numpy as np

from fvkit.backends.kernel import imposed
from fvkit.backends.march import March
from fvkit.backends.numpy_stages import Field, Runner, accepted, cut, lost_faces, settle
from fvkit.backends.python_loop import LostFaces, StepwiseKernel, SweepOutcome, Trial
from fvkit.pointwise import CHUNK
from fvkit.problem.problem import Problem
from fvkit.problem.sources import brought
from fvkit.schemes.program import TRANSPORT, Term
from fvkit.schemes.scheme import MASS_FLUX, NET, NEW, SPEED, Parts, Scheme

#: Number of cells above which the step is cut into chunks of `CHUNK` cells.
UNCHUNKED = 30_000


class NumpyKernel(StepwiseKernel):
    """Runs the stages on whole arrays; the pointwise functions are called as they are."""

    name: ClassVar[str] = "numpy"

    def __init__(self, problem: Problem, scheme: Scheme, parts: Parts) -> None:
        super().__init__(problem, scheme, parts)
        chunk = CHUNK if self.cells > UNCHUNKED else self.cells
        self._chunks = [(start, min(chunk, self.cells - start)) for start in range(0, self.cells, chunk)]
        lengths = {n for _, n in self._chunks}
        self._work = self.padded(problem.q0) if parts.beside else np.empty(0)
        self._aux = self.padded_aux()
        self._runner = Runner(parts, self.plan, lengths)
        self._sources = None if self.source_plan is None else Runner(parts, self.source_plan, lengths)
        self._no_flux = np.zeros((2, max(len(self.mass_rows), 1)))
        self._sees = [(problem.model, range(len(problem.q0)))]
        self._registers = np.zeros((scheme.program.registers, *self.padded(problem.q0).shape))
        self._made = NET
        self._write: Callable[..., None] = _step
        if scheme.program.registers:
            self._write = _rate
        elif parts.joint:
            self._made, self._write = NEW, _state

    def trial(self, march: March, dt: float) -> Trial:
        splitting, q, new = self.scheme.splitting, march.now, march.next
        start, gained = q, np.zeros((1, max(len(self.mass_rows), 1)))
        if not self.steady_fields:
            self.set_fields(march.t + 0.5 * dt)
        for source in self.parts.beside if splitting.before > 0.0 else ():
            self._act(source, start, self._work, splitting.before * dt, gained[0])
            start = self._work
        found = self._transport(start, new, march.t, dt)
        for source in reversed(self.parts.beside) if splitting.after > 0.0 else ():
            self._act(source, new, new, splitting.after * dt, gained[0])
        inside = self.inside(new)
        settle(inside, self._sees)
        return Trial(found.speed, accepted(inside, self.mass_rows, self._sees), found.flux, gained, found.lost, found.lost_cell)

    def set_fields(self, t: float) -> None:
        super().set_fields(t)
        self._aux[:] = self.padded_aux()

    def _transport(self, q: np.ndarray, out: np.ndarray, t: float, dt: float) -> SweepOutcome:
        """Write into ``out`` the state after the sweeps of a step. Faces that lost hyperbolicity are those of the first sweep."""
        program, units = self.scheme.program, (1.0, dt / self.problem.grid.dx, dt)
        registers = self._registers if program.registers else (q, out)
        if program.registers:
            self.inside(registers[0])[:] = self.inside(q)
        speed, flux, first = 0.0, np.zeros_like(self._no_flux), None
        for sweep in program.sweeps:
            state, rate = registers[sweep.state], registers[sweep.rate]
            self.fill_ghosts(state, t + sweep.time * dt)
            if sweep.implicit:
                self._extend(state)
                self._source_rate(state, rate, sweep.share * dt)
            else:
                found = self._sweep(state, rate, sweep.share * units[TRANSPORT])
                if found.speed == found.speed:
                    speed = max(speed, found.speed)
                elif speed * units[TRANSPORT] <= self.scheme.cfl_max:  # else the step is too long, whatever later stages say
                    speed = np.nan
                flux = flux + sweep.flux * found.flux
                first = first or found
            if sweep.target is not None:
                self._sum(sweep.terms, registers[sweep.target], units)
        if program.registers:
            self.inside(out)[:] = self.inside(registers[program.last])
        return SweepOutcome(speed, flux, *(first[2:4] if first else ()))

    def _sweep(self, q: np.ndarray, out: np.ndarray, ratio: float) -> SweepOutcome:
        """Write into the cells of ``out`` what a sweep makes of those of q."""
        speeds, lost, lost_face, lows = [], LostFaces(), -1, self._runner.lows
        flux = self._no_flux if self.closed or not self.mass_rows else np.zeros_like(self._no_flux)
        for start, n in self._chunks:
            fields = self._run(q, start, n, ratio)
            here = slice(self.halo + start, self.halo + start + n)
            for target, row, made in zip(out, q, fields[self._made], strict=True):
                self._write(target[here], row[here], made, ratio)
            speeds.append(np.maximum.reduce(fields[SPEED], None))
            if self.mass_rows and not self.closed:
                through, low = fields[MASS_FLUX], lows[MASS_FLUX]
                if start == 0:
                    flux[0] = [row[-low] for row in through]
                if start + n == self.cells:
                    flux[1] = [row[n - low] for row in through]
            closing = int(start + n == self.cells)  # the last face of a chunk belongs to the next one
            (faces,), depths = lost_faces(self.parts.model, *[
                cut(fields[name], self._runner.part(name, offset, 0, closing, n)) for name in ("q", "aux") for offset in (-1, 0)])
            if len(faces):
                lost_face = start + int(faces[0]) if lost_face < 0 else lost_face
                lost = lost.more(depths, len(faces))
        return SweepOutcome(float(np.maximum.reduce(speeds)), flux, lost, lost_face)

    def rate(self, q: np.ndarray, t: float) -> np.ndarray:
        """Return dq/dt (num_eqn, num_cells) at the padded state q: the scheme in the limit dt -> 0, sources left out."""
        self.fill_ghosts(q, t)
        result = np.empty((q.shape[0], self.cells))
        for start, n in self._chunks:
            for row, net in zip(result, self._run(q, start, n, 0.0)[NET], strict=True):
                row[start:start + n] = -net / self.problem.grid.dx
        return result

    def _act(self, source: Any, q: np.ndarray, out: np.ndarray, dt: float, gained: np.ndarray) -> None:
        """Write into the cells of ``out`` those of the padded state q after the source's pointwise step, and add what it
        makes of each mass to ``gained``."""
        for start, n in self._chunks:
            here = slice(self.halo + start, self.halo + start + n)
            state = tuple(q[:, here])
            result = source.step(self.problem.model, state, tuple(self._aux[:, here]), dt)
            for k, gain in brought(self.mass_rows, state, result):
                gained[k] += np.add.reduce(gain)
            for row, component in zip(out, result, strict=True):
                row[here] = component

    def _run(self, q: np.ndarray, start: int, n: int, ratio: float) -> dict[str, Field]:
        """Run all stages over n cells from ``start``; return the fields."""
        return self._runner.run(self._given(q, start, n), n, ratio, lambda fields: self._set_mass_fluxes(fields, start, n))

    def _given(self, q: np.ndarray, start: int, n: int) -> dict[str, Field]:
        """Fields of n cells from ``start`` and their halo."""
        here = slice(start, start + n + 2 * self.halo)
        return {"q": tuple(q[:, here]), "aux": tuple(self._aux[:, here])}

    def _set_mass_fluxes(self, fields: dict[str, Field], start: int, n: int) -> None:
        """Impose the mass fluxes of the boundary condition at an end of the grid."""
        here = start == 0, start + n == self.cells
        for end, values, met, face in zip(self.problem.ends, self._given_values, here, (0, n), strict=True):
            if met and MASS_FLUX in fields:
                for row, flux in zip(fields[MASS_FLUX], imposed(end, self.problem.model, values), strict=False):
                    if flux == flux:
                        row[face - self._runner.lows[MASS_FLUX]] = flux

    def _extend(self, q: np.ndarray) -> None:
        """Let the ghost cells of open ends have the state of the last cell: no end could give that of a stage."""
        for side, (ghosts, seen) in zip(self.problem.ends, self._slices, strict=True):
            if side.reads == "nearest":
                q[:, ghosts] = q[:, seen]

    def _source_rate(self, q: np.ndarray, out: np.ndarray, implicit: float) -> None:
        """Write the mean rate of the implicit sources; 0 where there are none."""
        for start, n in self._chunks:
            here = slice(self.halo + start, self.halo + start + n)
            nets = (0.0,) * len(out) if self._sources is None else self._sources.run(self._given(q, start, n), n, implicit)[NET]
            for row, net in zip(out, nets, strict=True):
                np.negative(net, out=row[here])

    def _sum(self, terms: tuple[Term, ...], target: np.ndarray, units: tuple[float, float, float]) -> None:
        """Write a sum of registers, in cells alone."""
        inside = self.inside(target)
        np.multiply(self.inside(self._registers[terms[0].register]), terms[0].weight * units[terms[0].kind], out=inside)
        for term in terms[1:]:
            inside += (term.weight * units[term.kind]) * self.inside(self._registers[term.register])


def _rate(target: np.ndarray, q: np.ndarray, net: Any, ratio: float) -> None:
    np.negative(net, out=target)


def _step(target: np.ndarray, q: np.ndarray, net: Any, ratio: float) -> None:
    np.multiply(net, -ratio, out=target)
    target += q


def _state(target: np.ndarray, q: np.ndarray, new: Any, ratio: float) -> None:
    target[:] = new
