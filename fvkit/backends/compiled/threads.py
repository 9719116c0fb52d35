"""Compiled steps on several threads: each takes its share of the tiles, so the result is that of one thread, to the bit."""

from concurrent.futures import ThreadPoolExecutor
from functools import partial
from itertools import pairwise
from typing import ClassVar

import numpy as np

from fvkit.backends.compiled.loops import TILE
from fvkit.backends.compiled.numba_kernel import NumbaKernel
from fvkit.backends.march import March
from fvkit.backends.python_loop import StepwiseKernel, Trial, counted
from fvkit.problem.problem import Problem
from fvkit.schemes.scheme import Parts, Scheme

#: Cells below which threads cost more than they gain: handing out a step takes about as long as 10,000 cells.
SMALLEST = 100_000


class ThreadedKernel(StepwiseKernel):
    """Runs the tiles of a compiled kernel on ``threads`` threads, and refuses fewer cells than pay for them."""

    name: ClassVar[str] = "numba"

    def __init__(self, problem: Problem, scheme: Scheme, parts: Parts, threads: int) -> None:
        super().__init__(problem, scheme, parts)
        if self.cells < SMALLEST:
            raise ValueError(f"`threads` pays from {SMALLEST} cells on, got {threads} threads for {self.cells} cells: "
                             "use threads=1, and run several problems at once instead")
        self._kernel = NumbaKernel(problem, scheme, parts)
        self.compile_seconds = self._kernel.compile_seconds
        count = (self.cells + TILE - 1) // TILE
        cuts = [count * k // threads for k in range(threads + 1)]
        self._shares = [(begin, end, self._kernel.scratch()) for begin, end in pairwise(cuts)]
        self._pool = ThreadPoolExecutor(threads, thread_name_prefix="fvkit")

    def trial(self, march: March, dt: float) -> Trial:
        kernel, splitting = self._kernel, self.scheme.splitting
        if not self.steady_fields:
            self.set_fields(march.t + 0.5 * dt)
        before = splitting.before * dt
        values = kernel.boundary_values(*kernel.times(march.t, dt))
        kernel.loop.fill(kernel.at, march.now, self.aux, self.cells, before, kernel.parameters, values[0])
        common = (True, march.now, march.next, self.aux, self.aux_edges, self.cells, dt / self.problem.grid.dx, dt, before,
                  splitting.after * dt, self.scheme.cfl_max, kernel.parameters, values, kernel.registers, kernel.sweeps,
                  kernel.weights, self.scheme.program.last)
        work = [self._pool.submit(partial(kernel.loop.step, kernel.at, begin, end, *common, *scratch))
                for begin, end, scratch in self._shares]
        reports = [item.result() for item in work]
        speed, bad = max(report[0] for report in reports), any(report[1] for report in reports)
        lost, first = counted([scratch.found[0] for _, _, scratch in self._shares])
        fluxes = [scratch.fluxes for _, _, scratch in self._shares]
        brought = np.add.reduce([flux[2] for flux in fluxes])
        return Trial(speed, not bad, np.array([fluxes[0][0], fluxes[-1][1]]), brought[None], lost, first)
