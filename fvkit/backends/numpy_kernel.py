"""The NumPy backend: every stage of a scheme on whole arrays, in chunks where they are long."""

from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np

from fvkit.backends.halo import plan
from fvkit.model import aux_rows
from fvkit.problem import Problem
from fvkit.schemes.base import Parts, Scheme

#: Cells per chunk, and the number of cells above which the step is cut into chunks: temporaries then stay in cache.
CHUNK, UNCHUNKED = 8192, 30_000


class Transport(NamedTuple):
    """What one transport step reports: the largest speed, mass fluxes through both ends, faces that lost hyperbolicity."""

    max_speed: float
    left_flux: np.ndarray
    right_flux: np.ndarray
    nonhyperbolic: int
    first_nonhyperbolic: int


class NumpyKernel:
    """Runs the stages of a scheme for one problem; owns no state but the aux values and its ranges.

    States are padded arrays (num_eqn, halo + num_cells + halo), made by `padded`.
    """

    name = "numpy"
    compile_seconds = 0.0

    def __init__(self, problem: Problem, scheme: Scheme, parts: Parts) -> None:
        self.problem, self.parts = problem, parts
        self.plan = plan(scheme.stages(parts))
        self.halo, self.cells = self.plan.halo, problem.grid.num_cells
        if self.cells < self.halo:
            raise ValueError(f"`num_cells` must be >= {self.halo} for this scheme, got {self.cells}")
        chunk = CHUNK if self.cells > UNCHUNKED else self.cells
        self._chunks = [(start, min(chunk, self.cells - start)) for start in range(0, self.cells, chunk)]
        self._ghosts = [self._side(left=True), self._side(left=False)]
        self._values: list[tuple[float, ...] | None] = [
            side.values(problem.model, problem.t_start) if side.steady else None for side in problem.boundary]
        self._closed = problem.boundary[0].reads == "opposite"
        self._mass_rows = list(problem.model.mass_rows())
        self._aux = self._padded_aux()

    def padded(self, q: np.ndarray) -> np.ndarray:
        """Return a copy of q (num_eqn, num_cells) with room for ghost cells."""
        result = np.zeros((q.shape[0], self.cells + 2 * self.halo))
        self.inside(result)[:] = q
        return result

    def inside(self, padded: np.ndarray) -> np.ndarray:
        """View of the cells of the grid."""
        return padded[:, self.halo:self.halo + self.cells]

    def _side(self, left: bool) -> tuple[slice, slice | int]:
        """Ghost cells of one side and the cells that they look at."""
        halo, n = self.halo, self.cells
        ghosts = slice(0, halo) if left else slice(halo + n, n + 2 * halo)
        reads = self.problem.boundary[0 if left else 1].reads
        if reads == "nearest":
            seen = slice(halo, halo + 1) if left else slice(halo + n - 1, halo + n)
        elif reads == "mirror":
            seen = slice(2 * halo - 1, halo - 1, -1) if left else slice(halo + n - 1, n - 1, -1)
        else:
            seen = slice(n, n + halo) if left else slice(halo, 2 * halo)
        return ghosts, seen

    def _padded_aux(self) -> np.ndarray:
        rows = aux_rows(self.problem.model, self.problem.aux_averages)
        result = self.padded(np.array(rows).reshape(len(rows), self.cells))
        for ghosts, seen in self._ghosts:
            result[:, ghosts] = result[:, seen]
        return result

    def fill_ghosts(self, q: np.ndarray, t: float) -> None:
        """Set the ghost cells of a padded state at time t."""
        model = self.problem.model
        for side, (ghosts, seen), values in zip(self.problem.boundary, self._ghosts, self._values, strict=True):
            current = side.values(model, t) if values is None else values
            for row, component in zip(q, side.ghost(model, tuple(q[:, seen]), current), strict=True):
                row[ghosts] = component

    def transport(self, q: np.ndarray, out: np.ndarray, t: float, dt: float) -> Transport:
        """Write into ``out`` the state after a transport step of length dt from the padded state ``q``."""
        self.fill_ghosts(q, t)
        ratio = dt / self.problem.grid.dx
        speeds, count, first = [], 0, -1
        lost = _lost_faces(self.parts)
        for start, n in self._chunks:
            fields = self._run(q, start, n, ratio)
            here = slice(self.halo + start, self.halo + start + n)
            for target, row, net in zip(out, q, fields["net"][1], strict=True):
                np.multiply(net, -ratio, out=target[here])
                target[here] += row[here]
            speeds.append(_largest(fields["speeds"][1]))
            if start == 0:
                left = self._end_flux(q, 0, fields, "right_going", 0, -1.0)
            if start + n == self.cells:
                right = self._end_flux(q, self.cells - 1, fields, "left_going", n, 1.0)
            if lost is not None:
                faces = np.flatnonzero(lost(_read(fields["q"], -1, 0, 1, n), _read(fields["q"], 0, 0, 1, n)))
                faces = faces[: faces.size - (start + n < self.cells and faces.size > 0 and faces[-1] == n)]
                first = start + int(faces[0]) if faces.size and first < 0 else first
                count += faces.size
        return Transport(max(speeds) if np.isfinite(speeds).all() else np.nan, left, right, count, first)

    def rate(self, q: np.ndarray, t: float) -> np.ndarray:
        """Return dq/dt (num_eqn, num_cells) of the scheme in the limit dt -> 0, sources left out."""
        self.fill_ghosts(q, t)
        result = np.empty((q.shape[0], self.cells))
        for start, n in self._chunks:
            for row, net in zip(result, self._run(q, start, n, 0.0)["net"][1], strict=True):
                row[start:start + n] = -net / self.problem.grid.dx
        return result

    def act(self, step: Callable[..., Any], q: np.ndarray, out: np.ndarray, dt: float) -> None:
        """Write into ``out`` the cells of q after ``step(model, q, aux, dt)``, a source's pointwise step."""
        for start, n in self._chunks:
            here = slice(self.halo + start, self.halo + start + n)
            result = step(self.problem.model, tuple(q[:, here]), tuple(self._aux[:, here]), dt)
            for row, component in zip(out, result, strict=True):
                row[here] = component

    def _run(self, q: np.ndarray, start: int, n: int, ratio: float) -> dict[str, tuple[int, Any]]:
        """Run all stages over the cells start .. start + n - 1; return the fields with the place of their first entry."""
        here = slice(start, start + n + 2 * self.halo)
        fields: dict[str, tuple[int, Any]] = {name: (-self.halo, tuple(rows[:, here]))
                                              for name, rows in (("q", q), ("aux", self._aux))}
        for stage, (low, high) in zip(self.plan.stages, self.plan.ranges, strict=True):
            inputs = [_read(fields[field], offset, low, high, n)
                      for field, first, last in stage.reads for offset in range(first, last + 1)]
            if stage.guard is None or np.any(stage.guard(self.parts, ratio, *inputs)):
                for name, value in zip(stage.writes, stage.compute(self.parts, ratio, *inputs), strict=True):
                    fields[name] = (low, value)
        return fields

    def _end_flux(self, q: np.ndarray, cell: int, fields: dict[str, tuple[int, Any]], name: str, face: int,
                  sign: float) -> np.ndarray:
        """Mass fluxes through an end face: the flux of the cell inside and the fluctuation that enters it."""
        if self._closed or not self._mass_rows:
            return np.zeros(len(self._mass_rows))
        flux = self.parts.model.flux(tuple(q[:, self.halo + cell]))
        first, rows = fields[name]
        return np.array([flux[row] + sign * rows[row][face - first] for row in self._mass_rows])


def _read(field: tuple[int, Any], offset: int, low: int, high: int, n: int) -> Any:
    """The part of a field that a stage covering low .. n + high - 1 sees at an offset."""
    first, value = field
    return _cut(value, slice(low + offset - first, n + high + offset - first))


def _cut(value: tuple[Any, ...], here: slice) -> tuple[Any, ...]:
    """The same part of every array in nested tuples; scalars stay what they are."""
    return tuple([(item[here] if item.ndim else item) if type(item) is np.ndarray
                  else _cut(item, here) if type(item) is tuple else item for item in value])


def _largest(speeds: tuple[Any, ...]) -> float:
    """Largest |speed|, NaN if any is."""
    ends = [end for speed in speeds for end in (np.maximum.reduce(speed, None), -np.minimum.reduce(speed, None))]
    return float(np.maximum.reduce(ends))


def _lost_faces(parts: Parts) -> Callable[[Any, Any], Any] | None:
    """The function that tells which faces have complex speeds, None where the model does not say."""
    model = parts.model
    if not model.defines("hyperbolic_discriminant"):
        return None

    def lost(ql: Any, qr: Any) -> Any:
        if model.defines("may_lose_hyperbolicity") and not np.any(model.may_lose_hyperbolicity(ql, qr)):
            return ()
        return model.hyperbolic_discriminant(ql, qr) < 0.0

    return lost
