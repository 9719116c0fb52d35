"""The NumPy backend: every stage of a scheme on whole arrays, in chunks where they are long."""

from math import isfinite
from typing import Any, ClassVar

import numpy as np

from fvkit.backends.kernel import deepness, imposed
from fvkit.backends.march import March
from fvkit.backends.numpy_stages import Field, Runner, cut
from fvkit.backends.python_loop import Lost, StepwiseKernel, Trial
from fvkit.backends.runge_kutta import TRANSPORT, Term, program
from fvkit.pointwise import CHUNK
from fvkit.problem.answers import at_face
from fvkit.problem.problem import Problem
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
        self._work = self.padded(problem.q0) if parts.beside else np.empty(0)
        self._aux = self.padded_aux()
        self._runner = Runner(parts, self.plan, {n for _, n in self._chunks})
        self._no_flux = np.zeros((2, max(len(self.mass_rows), 1)))

    def trial(self, march: March, dt: float) -> Trial:
        splitting, q, new = self.scheme.splitting, march.now, march.next
        start, brought = q, np.zeros((1, max(len(self.mass_rows), 1)))
        if not self.steady_fields:
            self.set_fields(march.t + 0.5 * dt)
        for source in self.parts.beside if splitting.before > 0.0 else ():
            self._act(source, start, self._work, splitting.before * dt, brought[0])
            start = self._work
        self.fill_ghosts(start, march.t + 0.5 * dt)
        speed, flux, lost, lost_face = self._transport(start, new, march.t, dt)
        for source in reversed(self.parts.beside) if splitting.after > 0.0 else ():
            self._act(source, new, new, splitting.after * dt, brought[0])
        if self.problem.model.defines("settle"):
            inside = self.inside(new)
            for row, component in zip(inside, self.problem.model.settle(tuple(inside)), strict=True):
                row[:] = component
        return Trial(speed, self._good(new), flux, brought, lost, lost_face)

    def set_fields(self, t: float) -> None:
        super().set_fields(t)
        self._aux[:] = self.padded_aux()

    def _good(self, padded: np.ndarray) -> bool:
        """Whether a state is finite, without negative masses, and admissible. Its ghost cells are those of an earlier one."""
        if not isfinite(np.add.reduce(padded, None)):
            return False
        q = self.inside(padded)
        if any(np.minimum.reduce(q[row]) < 0.0 for row in self.mass_rows):
            return False
        return not self.problem.model.defines("admissible") or bool(np.all(self.problem.model.admissible(tuple(q))))

    def _transport(self, q: np.ndarray, out: np.ndarray, t: float, dt: float) -> tuple[float, np.ndarray, Lost, int]:
        """Write into ``out`` the state after transport for dt; return largest speed, end fluxes, lost faces and the first."""
        ratio = dt / self.problem.grid.dx

        def step(target: np.ndarray, row: np.ndarray, net: Any) -> None:
            np.multiply(net, -ratio, out=target)
            target += row

        def keep(target: np.ndarray, _: np.ndarray, new: Any) -> None:
            target[:] = new

        return self._sweep(q, out, ratio, NEW, keep) if self.parts.joint else self._sweep(q, out, ratio, NET, step)

    def _sweep(self, q: np.ndarray, out: np.ndarray, ratio: float, made: str, write: Any) -> tuple[float, np.ndarray, Lost, int]:
        """Write into the cells of ``out`` what ``write`` makes of those of q and a field; return what `_transport` does."""
        speeds, lost, lost_face, lows = [], Lost(), -1, self._runner.lows
        flux = self._no_flux if self.closed or not self.mass_rows else np.zeros_like(self._no_flux)
        for start, n in self._chunks:
            fields = self._run(q, start, n, ratio)
            here = slice(self.halo + start, self.halo + start + n)
            for target, row, net in zip(out, q, fields[made], strict=True):
                write(target[here], row[here], net)
            speeds.append(_largest(fields[SPEED]))
            if self.mass_rows and not self.closed:
                through, low = fields[MASS_FLUX], lows[MASS_FLUX]
                if start == 0:
                    flux[0] = [row[-low] for row in through]
                if start + n == self.cells:
                    flux[1] = [row[n - low] for row in through]
            faces, depths = self._lost_faces(fields["q"], fields["aux"], n, closing=start + n == self.cells)
            if len(faces):
                lost_face = start + int(faces[0]) if lost_face < 0 else lost_face
                lost = lost.more(depths, len(faces))
        return float(np.maximum.reduce(speeds)), flux, lost, lost_face

    def _lost_faces(self, q: Field, aux: Field, n: int, closing: bool) -> tuple[Any, np.ndarray | None]:
        """Faces of a chunk whose Roe mean has complex speeds, and their depths; the last face belongs to the next chunk."""
        model = self.parts.model
        if not model.defines("hyperbolic_discriminant"):
            return (), None
        face = ql, qr, _, _ = [cut(field, self._runner.part(name, offset, 0, int(closing), n))
                               for name, field in (("q", q), ("aux", aux)) for offset in (-1, 0)]
        if model.defines("may_lose_hyperbolicity") and not at_face(model, "may_lose_hyperbolicity", *face).any():
            return (), None
        faces = np.flatnonzero(at_face(model, "hyperbolic_discriminant", *face) < 0.0)
        depths = deepness(model, ql, qr)
        return faces, None if depths is None else np.broadcast_to(depths, np.shape(ql[0]))[faces]

    def rate(self, q: np.ndarray, t: float) -> np.ndarray:
        """Return dq/dt (num_eqn, num_cells) at the padded state q: the scheme in the limit dt -> 0, sources left out."""
        self.fill_ghosts(q, t)
        result = np.empty((q.shape[0], self.cells))
        for start, n in self._chunks:
            for row, net in zip(result, self._run(q, start, n, 0.0)[NET], strict=True):
                row[start:start + n] = -net / self.problem.grid.dx
        return result

    def _act(self, source: Any, q: np.ndarray, out: np.ndarray, dt: float, brought: np.ndarray) -> None:
        """Write into the cells of ``out`` those of the padded state q after the source's pointwise step, and add what it
        makes of each mass to ``brought``."""
        for start, n in self._chunks:
            here = slice(self.halo + start, self.halo + start + n)
            state = tuple(q[:, here])
            result = source.step(self.problem.model, state, tuple(self._aux[:, here]), dt)
            for k, row in enumerate(self.mass_rows):
                if result[row] is not state[row]:
                    brought[k] += np.add.reduce(result[row] - state[row])
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


class StagedNumpyKernel(NumpyKernel):
    """The same for a scheme with a time integrator: a step is a program of sweeps."""

    def __init__(self, problem: Problem, scheme: Scheme, parts: Parts) -> None:
        super().__init__(problem, scheme, parts)
        integrator = scheme.time_integrator
        if integrator is None:
            raise TypeError(f"{type(scheme).__name__} has no time integrator")
        self._program = program(integrator)
        self._registers = np.zeros((self._program.registers, *self.padded(problem.q0).shape))
        self._sources = None if self.source_plan is None else Runner(parts, self.source_plan, {n for _, n in self._chunks})

    def _transport(self, q: np.ndarray, out: np.ndarray, t: float, dt: float) -> tuple[float, np.ndarray, Lost, int]:
        registers, units = self._registers, (1.0, dt / self.problem.grid.dx, dt)
        speed, flux, lost, started = 0.0, np.zeros_like(self._no_flux), (Lost(), -1), False
        self.inside(registers[0])[:] = self.inside(q)
        for sweep in self._program.sweeps:
            state, rate = registers[sweep.state], registers[sweep.rate]
            self.fill_ghosts(state, t + sweep.time * dt)
            if sweep.implicit:
                self._extend(state)
                self._source_rate(state, rate, sweep.share * dt)
            else:
                found = self._sweep(state, rate, sweep.share * units[TRANSPORT], NET,
                                    lambda to, _, net: np.negative(net, out=to))
                if found[0] == found[0]:
                    speed = max(speed, found[0])
                elif speed * units[TRANSPORT] <= self.scheme.cfl_max:  # else the step is too long, whatever later stages say
                    speed = np.nan
                flux = flux + sweep.flux * found[1]
                lost = lost if started else found[2:]
                started = True
            if sweep.target is not None:
                self._sum(sweep.terms, registers[sweep.target], units)
        self.inside(out)[:] = self.inside(registers[self._program.last])
        return (speed, flux, *lost)

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


def _largest(speed: Any) -> float:
    """Largest of speeds that are >= 0, NaN if any is."""
    return float(np.maximum.reduce(speed, None))
