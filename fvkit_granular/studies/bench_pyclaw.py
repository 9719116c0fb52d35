"""PyClaw's Fortran solvers for shallow water, to be measured beside ours where the package ``clawpack`` is installed."""

import time
from collections.abc import Callable, Sequence
from typing import Any

import numpy as np


def pyclaw_runs(cells: int, orders: Sequence[int],
                bottom: Callable[[np.ndarray], np.ndarray]) -> dict[tuple[str, int], Callable[[int], float]]:
    """Return {(solver, order): function of a number of steps -> seconds per step} for the f-wave and the Roe solver.

    The flow is smooth and periodic, with the given bottom for the f-wave solver; MC limiter, Courant number 0.9.
    """
    from clawpack import pyclaw, riemann

    def make(solver_function: object, order: int, topography: bool) -> Callable[[int], float]:
        solver = pyclaw.ClawSolver1D(solver_function)
        solver.limiters, solver.order, solver.cfl_desired, solver.cfl_max = pyclaw.limiters.tvd.MC, order, 0.9, 1.0
        solver.fwave = topography
        solver.bc_lower[0] = solver.bc_upper[0] = pyclaw.BC.periodic
        solver.aux_bc_lower[0] = solver.aux_bc_upper[0] = pyclaw.BC.periodic
        domain = pyclaw.Domain(pyclaw.Dimension(0.0, 1.0, cells, name="x"))
        state = pyclaw.State(domain, 2, 1 if topography else 0)
        x = state.grid.x.centers
        height = bottom(x) if topography else 0.0
        state.problem_data.update({"grav": 9.81, "dry_tolerance": 1e-3, "sea_level": 0.0} if topography
                                  else {"grav": 9.81, "efix": True})
        state.q[0] = 1.0 + 0.4 * np.exp(-100.0 * (x - 0.4) ** 2) - height
        state.q[1] = 0.0
        if topography:
            state.aux[0] = height
        solution = pyclaw.Solution(state, domain)
        return _stepping(solver, solution, cells)

    return {("f-wave" if topography else "roe", order): make(function, order, topography)
            for order in orders
            for function, topography in ((riemann.shallow_bathymetry_fwave_1D, True), (riemann.shallow_roe_with_efix_1D, False))}


def pyclaw_runs_in_the_plane(cells: int, orders: Sequence[int]) -> dict[tuple[str, int], Callable[[int], float]]:
    """Return {(solver, order): function of a number of steps -> seconds per step} for the Roe solver on cells x cells.

    Dimensional splitting, as ours; the flow is smooth and periodic on level ground, MC limiter, Courant number 0.9.
    """
    from clawpack import pyclaw, riemann

    def make(order: int) -> Callable[[int], float]:
        solver = pyclaw.ClawSolver2D(riemann.shallow_roe_with_efix_2D)
        solver.limiters, solver.order, solver.cfl_desired, solver.cfl_max = pyclaw.limiters.tvd.MC, order, 0.9, 1.0
        solver.dimensional_split = True
        solver.all_bcs = pyclaw.BC.periodic
        domain = pyclaw.Domain([pyclaw.Dimension(0.0, 1.0, cells, name=name) for name in ("x", "y")])
        state = pyclaw.State(domain, solver.num_eqn)
        state.problem_data["grav"] = 9.81
        x, y = state.grid.p_centers
        state.q[0] = 1.0 + 0.4 * np.exp(-100.0 * ((x - 0.4) ** 2 + (y - 0.5) ** 2))
        state.q[1:] = 0.0
        solution = pyclaw.Solution(state, domain)
        return _stepping(solver, solution, cells)

    return {("roe", order): make(order) for order in orders}


def _stepping(solver: Any, solution: Any, cells: int) -> Callable[[int], float]:
    """Return the function of a number of steps -> seconds per step of a solver of PyClaw."""
    solver.dt_initial = 0.2 / cells
    solver.setup(solution)

    def run(steps: int) -> float:
        started = time.perf_counter()
        for _ in range(steps):
            solver.evolve_to_time(solution)
        return (time.perf_counter() - started) / steps

    return run
