"""The self-converged reference of a comparison: the finest run that is affordable, and its own error."""

from collections.abc import Callable
from math import log2
from typing import NamedTuple

import numpy as np

from fvkit.output.solution import Solution
from fvkit.output.status import SolveError, Status
from fvkit.pointwise.part import public_name
from fvkit.problem.grid import Axis, Grid
from fvkit.problem.model import Model
from fvkit.problem.problem import Problem
from fvkit.run.control import Limits
from fvkit.run.solve import solve
from fvkit.schemes.method_of_lines import MethodOfLines
from fvkit.schemes.riemann import Roe, default_riemann
from fvkit.schemes.scheme import Scheme
from fvkit.schemes.wave_propagation import WavePropagation
from fvkit.studies.convergence import onto
from fvkit.studies.cost import predicted
from fvkit.studies.scheme_names import scheme_name
from fvkit.studies.tables import ROUNDING

#: A self-converged reference has this many times the cells of the finest run.
REFINEMENT = 4


class FineGrid(NamedTuple):
    """A reference that is a run on a fine grid, averaged onto the cells of coarser ones."""

    detail: str
    solution: Solution
    kind: str = "self-converged"

    def averages(self, model: Model, grid: Grid, t: float) -> np.ndarray:
        """Return the averages over the cells of a coarser grid at the output nearest to t, (num_eqn, *grid.shape)."""
        return averaged(self.solution.q[int(np.argmin(np.abs(self.solution.t - t)))], self.solution.grid, grid)


def averaged(q: np.ndarray, fine: Grid, coarse: Grid) -> np.ndarray:
    """Return averages over the cells of a coarse grid, (rows, *coarse.shape), of averages on any finer one."""
    for k, (own, other) in enumerate(zip(fine.axes, coarse.axes, strict=True), start=1):
        q = np.apply_along_axis(_along_an_axis, -k, q, own, other)
    return q


def _along_an_axis(values: np.ndarray, fine: Axis, coarse: Axis) -> np.ndarray:
    integrals = np.concatenate([np.zeros(1), np.cumsum(values) * fine.dx])
    return np.diff(np.interp(coarse.edges, fine.edges, integrals)) / coarse.dx


def fine_scheme(model: Model, high_order: bool) -> Scheme:
    """Return the scheme of the reference: of fifth order where runs of high order are to be measured."""
    solver = Roe() if model.defines("decompose") else default_riemann(model)
    return MethodOfLines(solver) if high_order else WavePropagation(solver)


def fine_grid_reference(problem_of: Callable[[int], Problem], scheme: Scheme, cells: tuple[int, ...], backend: str,
                        seconds: float | None, tell: Callable[[str], None]) -> FineGrid:
    """Return a run on ``REFINEMENT`` times the finest grid of ``cells``, or on the finest grid that is affordable.

    Two coarser runs, and with a budget as many as it takes, predict the cost of the next one and the distance of the last to
    converged. Where the measured runs have a budget of ``seconds`` it has ``REFINEMENT``^2 times that, with two axes ^3.
    """
    wanted = REFINEMENT * max(cells)
    ladder = [wanted, wanted // 2, wanted // 4]
    while seconds is not None and ladder[-1] % 2 == 0 and ladder[-1] // 2 >= min(cells):
        ladder.append(ladder[-1] // 2)
    first = problem_of(ladder[-1])
    axes = len(first.grid.axes)
    limit = None if seconds is None else REFINEMENT ** (axes + 1) * seconds
    solutions: list[Solution] = []
    for count in reversed(ladder):
        tell(f"reference: {public_name(first.model)} {scheme_name(scheme)} N={count}")
        costs = [(run.grid.axes[0].num_cells, run.stats.seconds) for run in solutions]
        if limit is not None and predicted(count, costs, axes) > limit:
            break
        try:
            solutions.append(solve(problem_of(count), scheme, limits=Limits(seconds=limit), backend=backend,
                                   nonhyperbolic="ignore"))
        except SolveError as error:
            if error.status is not Status.OVER_BUDGET or not solutions:
                raise
            break
    found = solutions[-1].grid.axes[0].num_cells
    detail = f"the full model itself, {scheme_name(scheme)}, N = {solutions[-1].grid.described}; {own_error(solutions)}"
    if found < wanted:
        detail += f"; N = {wanted} would take more than the {limit:g} s of the reference"
    return FineGrid(detail, solutions[-1])


def own_error(solutions: list[Solution]) -> str:
    """Return a few words on the error of the last of some runs, each with twice the cells of the one before."""
    seen = [solution.observables() for solution in solutions[-3:]]
    name = next(iter(seen[0]))
    gaps = [solution.grid.cell_volume * np.abs(coarse[name] - onto(fine[name][None], solution.grid)[0]).sum()
            for solution, coarse, fine in zip(solutions[-3:], seen, seen[1:], strict=False)]
    if len(gaps) < 2:
        return "its own error is unknown"
    if gaps[1] < ROUNDING:
        return f"its own error of {name} is rounding"
    order = log2(gaps[0] / gaps[1]) if gaps[0] > 0.0 else 0.0
    if order < 0.1:
        return f"it has not converged: its own L1 error of {name} is at least about {gaps[1]:.0e}"
    return f"own L1 error of {name} about {gaps[1] / (2.0**order - 1.0):.0e} by Richardson (observed order {order:.1f})"
