"""The self-converged reference of a comparison: the finest run that is affordable, and its own error."""

from collections.abc import Callable
from math import log2

import numpy as np

from fvkit import Limits, MethodOfLines, Model, Roe, Scheme, Solution, SolveError, Status, WavePropagation, solve
from fvkit.pointwise.part import public_name
from fvkit.schemes.riemann import default_riemann
from fvkit.studies.convergence import onto
from fvkit.studies.cost import predicted
from fvkit.studies.scheme_names import describe
from fvkit.studies.tables import ROUNDING
from fvkit_granular.scenes.reference import SelfConverged
from fvkit_granular.scenes.scene import Scene

#: A self-converged reference has this many times the cells of the finest run.
REFINEMENT = 4


def fine_scheme(model: Model, high_order: bool) -> Scheme:
    """Return the scheme of the reference: of fifth order where runs of high order are to be measured."""
    solver = Roe() if model.defines("decompose") else default_riemann(model)
    return MethodOfLines(solver) if high_order else WavePropagation(solver)


def self_converged(scene: Scene, model: Model, scheme: Scheme, cells: tuple[int, ...], backend: str, seconds: float | None,
                   tell: Callable[[str], None]) -> SelfConverged:
    """Return the model itself on ``REFINEMENT`` times the finest grid, or on the finest grid that is affordable.

    Two coarser runs, and with a budget as many as it takes, say what the next one will cost, and how far the last is from
    converged.

    Parameters
    ----------
    cells : those of the runs that are to be measured.
    seconds : their budget; the reference, ``REFINEMENT`` times as fine, may take the square of that longer, with two axes
        the cube.
    """
    wanted = REFINEMENT * max(cells)
    ladder = [wanted, wanted // 2, wanted // 4]
    while seconds is not None and ladder[-1] % 2 == 0 and ladder[-1] // 2 >= min(cells):
        ladder.append(ladder[-1] // 2)
    axes = len(scene.axes)
    limit = None if seconds is None else REFINEMENT ** (axes + 1) * seconds
    solutions: list[Solution] = []
    for count in reversed(ladder):
        tell(f"reference: {public_name(model)} {describe(scheme)} N={count}")
        if limit is not None and predicted(count, _costs(solutions), axes) > limit:
            break
        try:
            solutions.append(solve(scene.problem(model, count), scheme, limits=Limits(seconds=limit), backend=backend,
                                   nonhyperbolic="ignore"))
        except SolveError as error:
            if error.status is not Status.OVER_BUDGET or not solutions:
                raise
            break
    found = solutions[-1].grid.axes[0].num_cells
    detail = f"the full model itself, {describe(scheme)}, N = {solutions[-1].grid.described}; {own_error(solutions)}"
    if found < wanted:
        detail += f"; N = {wanted} would take more than the {limit:g} s of the reference"
    return SelfConverged("self-converged", detail, solution=solutions[-1])


def _costs(solutions: list[Solution]) -> list[tuple[int, float]]:
    return [(run.grid.axes[0].num_cells, run.stats.seconds) for run in solutions]


def own_error(solutions: list[Solution]) -> str:
    """Return a few words on the error of the last of some runs, each with twice the cells of the one before."""
    depths = [solution.observables()["h"] for solution in solutions[-3:]]
    gaps = [solution.grid.cell_volume * np.abs(coarse - onto(fine[None], solution.grid)[0]).sum()
            for solution, coarse, fine in zip(solutions[-3:], depths, depths[1:], strict=False)]
    if len(gaps) < 2:
        return "its own error is unknown"
    if gaps[1] < ROUNDING:
        return "its own error of h is rounding"
    order = log2(gaps[0] / gaps[1]) if gaps[0] > 0.0 else 0.0
    if order < 0.1:
        return f"it has not converged: its own L1 error of h is at least about {gaps[1]:.0e}"
    return f"own L1 error of h about {gaps[1] / (2.0**order - 1.0):.0e} by Richardson (observed order {order:.1f})"
