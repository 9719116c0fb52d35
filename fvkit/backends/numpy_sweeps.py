"""Sweeps by the NumPy backend: the stages of a scheme on all lines at once."""

from typing import Any, ClassVar

import numpy as np

from fvkit.backends.numpy_stages import Field, Runner, cut, lost_faces
from fvkit.backends.plane_kernel import PlaneKernel
from fvkit.backends.python_loop import LostFaces, SweepOutcome
from fvkit.backends.sweeps import FIRST, Sweep
from fvkit.pointwise import CHUNK
from fvkit.problem.problem import Problem
from fvkit.schemes.scheme import MASS_FLUX, MOVED, PULLS, SPEED, Parts, Scheme


class NumpySweep(Sweep):
    """Runs the stages on arrays (cells along the axis, lines), some lines at a time so that temporaries stay in cache."""

    def __init__(self, problem: Problem, scheme: Scheme, parts: Parts, number: int, halo: int) -> None:
        super().__init__(problem, scheme, parts, number, halo)
        n = self.axis.num_cells
        self._runner = Runner(parts, self.plan, {n})
        self._puller = None if self.pulling is None else Runner(parts, self.pulling, {n})

    def prepare(self, given: np.ndarray, threads: int) -> None:
        n = self.axis.num_cells
        lines = self.problem.grid.size // n
        chunk = max(1, CHUNK // n)
        self._chunks = [slice(first, min(first + chunk, lines)) for first in range(0, lines, chunk)]

    def _fields(self, q: np.ndarray, aux: np.ndarray, lanes: slice) -> dict[str, Field]:
        state = self.lines(q)[:, :, lanes]
        return {"q": tuple(state[row] for row in self.rows), "aux": tuple(self.lines(aux)[:, :, lanes]),
                "across": tuple(state[row] for row in self.direction.across)}

    def run(self, q: np.ndarray, out: np.ndarray, aux: np.ndarray, dt: float, place: int, other: np.ndarray) -> SweepOutcome:
        n, halo, runner, masses = self.axis.num_cells, self.halo, self._runner, self.model.mass_rows()
        target, source = (self.lines(one)[:, halo:halo + n] for one in (out, q))
        for row in self.direction.still:
            target[row] = source[row]
        compression = self.lines(other[-1:])[0, halo:halo + n] if self.direction.across else None
        given, flux = self.fluxes(), np.zeros((2, max(len(masses), 1)))
        speeds, lost, first = [], LostFaces(), -1
        for lanes in self._chunks:
            def set_ends(fields: dict[str, Field], here: slice = lanes) -> None:
                self._impose(given, fields, here)

            fields = runner.run(self._fields(q, aux, lanes), n, dt / self.axis.dx, set_ends)
            speeds.append(np.maximum.reduce(fields[SPEED], None))
            if masses and not self.periodic:
                low = runner.lows[MASS_FLUX]
                flux += [[row[face - low].sum() for row in fields[MASS_FLUX]] for face in (0, n)]
            places, depths = lost_faces(self.model, *[cut(fields[name], slice(halo + offset, halo + n + 1 + offset))
                                                      for name in ("q", "aux") for offset in (-1, 0)])
            if len(places[0]):
                along, line = min(int(places[0][0]), n - 1), lanes.start + int(places[1][0])
                cell = (line, along) if self.number == 0 else (along, line)
                first = int(np.ravel_multi_index(cell, self.problem.grid.shape)) if first < 0 else first
                lost = lost.more(depths, len(places[0]))
            for row, item in zip((*self.rows, *self.direction.across), fields[MOVED], strict=False):
                target[row, :, lanes] = item  # what was read may stand in the same place
            if compression is not None and place == FIRST:
                compression[:, lanes] = fields[MOVED][-1]
        return SweepOutcome(float(np.maximum.reduce(speeds)), flux, lost, first)

    def _impose(self, given: list[tuple[int, slice, Any]], fields: dict[str, Field], here: slice) -> None:
        """Impose the mass fluxes of the conditions at the sides."""
        for side, lanes, through in given:
            low, high = max(lanes.start, here.start), min(lanes.stop, here.stop)
            if low >= high or MASS_FLUX not in fields:
                continue
            face = side * self.axis.num_cells - self._runner.lows[MASS_FLUX]
            for row, value in zip(fields[MASS_FLUX], through, strict=True):
                passing = row[face, low - here.start:high - here.start]
                given_flux = value[low - lanes.start:high - lanes.start] if np.ndim(value) else value
                np.copyto(passing, given_flux, where=~np.isnan(given_flux))

    def pull(self, q: np.ndarray, out: np.ndarray, aux: np.ndarray) -> None:
        n, halo = self.axis.num_cells, self.halo
        target = self.lines(out)[:, halo:halo + n]
        if self._puller is None:
            return
        for lanes in self._chunks:
            found = self._puller.run(self._fields(q, aux, lanes), n, 0.0)[PULLS]
            for row, item in zip(target, found, strict=True):
                row[:, lanes] = item


class NumpyPlaneKernel(PlaneKernel):
    """Runs sweeps on whole arrays; the pointwise functions are called as they are."""

    name: ClassVar[str] = "numpy"
    sweep_kind = NumpySweep
