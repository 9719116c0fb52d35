"""Sweeps by the compiled backend: pieces of lines in active blocks, on one thread or several."""

import time
from concurrent.futures import ThreadPoolExecutor
from itertools import pairwise
from typing import Any, ClassVar

import numpy as np

from fvkit.backends.compiled.active_blocks import ActiveBlocks
from fvkit.backends.compiled.calls import Call, address
from fvkit.backends.compiled.numba_kernel import module_of
from fvkit.backends.compiled.sweep_tiles import DRIVER, LANES, LENGTH, generate_sweep, signatures
from fvkit.backends.layout import aligned
from fvkit.backends.plane_kernel import PlaneKernel
from fvkit.backends.python_loop import SweepOutcome, counted
from fvkit.backends.sweeps import FIRST, Sweep
from fvkit.problem.problem import Problem
from fvkit.schemes.scheme import Parts, Scheme


class NumbaSweep(Sweep):
    """Runs the tiles of a sweep in compiled code; new parameter values never recompile."""

    settles: ClassVar[bool] = True

    def prepare(self, given: np.ndarray, threads: int) -> None:
        """Make the code, once it is known which of the given rows are not zero everywhere."""
        varies = [bool(row.any()) or k >= len(self.problem.model.aux) for k, row in enumerate(given)]
        source = generate_sweep(self.direction, self.scheme, self.parts, self.plan, self.pulling, varies)
        started = time.perf_counter()
        import numba

        tile, whole = signatures(numba)
        names = ("tile", "pull_tile")[:1 if self.pulling is None else 2]
        kernel = module_of("kernel", source.text, source.blocks, dict.fromkeys(names, tile))
        self._tiles = [address(getattr(kernel, name)) for name in names]
        self._loop = module_of("loop", DRIVER, (Call("tile", tile),), {"sweep": whole}).sweep
        self.compile_seconds = time.perf_counter() - started
        self._parameters = np.array([value for part in self.parts.every for value in part.parameters()] + [self.parts.dx])
        lines = self.problem.grid.size // self.axis.num_cells
        masses = max(1, len(self.model.mass_rows()))
        self._gates, self._gated = np.zeros((2, masses, lines)), np.zeros((2, lines), dtype=np.int64)
        self._scratch = [(aligned(source.rows * LENGTH), aligned(LENGTH), np.zeros((1, 1)), np.zeros(4, dtype=np.int64))
                         for _ in range(threads)]
        self._pool = ThreadPoolExecutor(threads, thread_name_prefix="fvkit") if threads > 1 else None
        self._version, self._jobs, self._begins = -1, np.zeros((0, 4), dtype=np.int64), np.zeros(1, dtype=np.int64)

    def idle(self, side: int) -> bool:
        sides = (0, 1) if self.periodic else (side,)
        return not any(self.blocks.reaches(self.number, one) for one in sides)

    def jobs(self) -> np.ndarray:
        """Pieces of lines in active blocks, made again where these have changed."""
        if self._version != self.blocks.version:
            lanes = LANES if self.number else 1
            jobs = self._jobs = self.blocks.jobs(self.number, lanes, LENGTH // lanes - 2 * self.halo - 1)
            self._begins = np.append(np.flatnonzero(np.diff(jobs[:, 0], prepend=-1)), len(jobs))
            self._version = self.blocks.version
        return self._jobs

    def _call(self, tile: int, q: np.ndarray, out: np.ndarray, aux: np.ndarray, other: np.ndarray, place: int,
              ratio: float) -> list[Any]:
        """Run the jobs, each thread its share of whole lines."""
        def share(jobs: np.ndarray, scratch: tuple[np.ndarray, ...]) -> Any:
            buffer, speeds, through, found = scratch
            return self._loop(tile, jobs, q, out, aux, other, self.axis.num_cells, place, int(q is out), ratio, self._parameters,
                              self._gates, self._gated, buffer, speeds, through, found)

        count, every = len(self._scratch), self.jobs()
        cuts = self._begins[[(len(self._begins) - 1) * k // count for k in range(count + 1)]]
        shares = [every[first:stop] for first, stop in pairwise(cuts)]
        if self._pool is None:
            return [share(shares[0], self._scratch[0])]
        return [one.result() for one in [self._pool.submit(share, *pair) for pair in zip(shares, self._scratch, strict=True)]]

    def run(self, q: np.ndarray, out: np.ndarray, aux: np.ndarray, dt: float, place: int, other: np.ndarray) -> SweepOutcome:
        self._gated[:], self._gates[:] = 0, 0.0
        for side, lanes, through in self.fluxes():
            passing = np.array(through, dtype=float).reshape(len(through), -1)
            self._gated[side, lanes] = ~np.isnan(passing).any(axis=0)
            self._gates[side][:, lanes] = np.nan_to_num(passing)
            self.blocks.touch(self.number, side, self._gates[side].any(axis=0))
        for row in self.direction.still if q is not out else ():
            out[row] = q[row]
        reports = self._call(self._tiles[0], q, out, aux, other, place, dt / self.axis.dx)
        flux = np.zeros((2, max(1, len(self.model.mass_rows())))) if self.periodic or not self.model.mass_rows() else \
            self._gates.sum(axis=2)
        lost, first = counted([scratch[3] for scratch in self._scratch])
        speeds = [speed for speed, _ in reports]
        return SweepOutcome(float(np.max(speeds)), flux, lost, first, any(bad for _, bad in reports))

    def pull(self, q: np.ndarray, out: np.ndarray, aux: np.ndarray) -> None:
        self._call(self._tiles[1], q, out, aux, aux, FIRST, 0.0)


class NumbaPlaneKernel(PlaneKernel):
    """Runs sweeps in compiled code, on ``threads`` threads with the same bits."""

    name: ClassVar[str] = "numba"
    sweep_kind = NumbaSweep

    def __init__(self, problem: Problem, scheme: Scheme, parts: tuple[Parts, ...], threads: int = 1) -> None:
        super().__init__(problem, scheme, parts, threads)
        wetting = [source.acts_in() for source in self.parts.beside if source.wets]
        every = not problem.model.phases or any(cells is None for cells in wetting)
        self.blocks = ActiveBlocks(problem.grid.shape, self.halo, every, wetting)
        for sweep in self.sweeps:
            sweep.blocks = self.blocks

    def restarted(self) -> None:
        self.blocks.forget()

    def _find_active(self, q: np.ndarray, sweep: Sweep | None = None) -> None:
        if sweep is None:
            self.blocks.look(q)
        for one in self.sweeps if sweep is None else (sweep,):
            lines = one.lines(q)
            for side, ghosts in enumerate((lines[:, :self.halo], lines[:, lines.shape[1] - self.halo:])):
                if not (one.idle(side) and all(border.quiet for border in one.borders[side])):
                    self.blocks.touch(one.number, side, np.asarray(ghosts.any(axis=(0, 1))))

    def _clear(self, row: np.ndarray) -> None:
        """Leave it: the first sweep reads none, and writes all that the second reads but for idle blocks, where all is 0."""
