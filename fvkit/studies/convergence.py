"""`convergence`: errors under grid refinement and the observed order of convergence."""

from collections.abc import Callable, Sequence
from itertools import pairwise
from typing import Any

import numpy as np

from fvkit import validation
from fvkit.output.solution import Solution
from fvkit.problem.cell_averages import cell_averages
from fvkit.problem.directions import component_names
from fvkit.problem.grid import Grid
from fvkit.problem.model import Model
from fvkit.problem.problem import Problem
from fvkit.run.interruption import keeping
from fvkit.run.solve import solve
from fvkit.schemes.fitting import default_scheme
from fvkit.schemes.scheme import Scheme
from fvkit.studies.orders import Convergence
from fvkit.studies.scheme_names import scheme_name

#: {name: norm of differences (num_eqn, number of cells) of averages over cells of that volume, per component}.
NORMS: dict[str, Callable[[np.ndarray, float], np.ndarray]] = {
    "l1": lambda difference, volume: volume * np.abs(difference).sum(axis=1),
    "l2": lambda difference, volume: np.sqrt(volume * (difference**2).sum(axis=1)),
    "max": lambda difference, volume: np.abs(difference).max(axis=1),
}


def convergence(problem_of: Callable[[int], Problem], scheme: Scheme | None = None,
                cells: Sequence[int] = (50, 100, 200, 400), reference: Any = None, *, expect: float | None = None,
                norm: str = "l1", backend: str = "auto", progress: Callable[[str], None] | None = None) -> Convergence:
    """Measure the order of convergence of a scheme under grid refinement.

    ::

        p = log(E_coarse/E_fine) / log(N_fine/N_coarse),   E = norm of (computed - reference cell averages) at t_end.

    Parameters
    ----------
    problem_of : number of cells -> `fvkit.Problem`; for a scene ``partial(scene.problem, gr.TwoPhase)``. With two axes it is the
        number along x; those along y should grow alike.
    scheme : the scheme; None for the default of `fvkit.solve`.
    cells : numbers of cells, ascending.
    reference : function (x, t) -> conserved values (num_eqn, m) at x (m,), averaged over the cells by quadrature; or an
        object with ``averages(model, grid, t)`` -> (num_eqn, n), such as the reference of a scene. With two axes a function
        (x, y, t) -> (num_eqn, my, mx) at x and y (my, mx), or averages (num_eqn, ny, nx). None for self-convergence:
        E is then the difference to the next finer grid, averaged onto the coarse one. It measures the order but does not
        verify the limit; ``cells`` must grow by a constant integer factor.
    expect : required order, between the last two errors summed over the components.
    norm : ``"l1"`` (integral of |difference|), ``"l2"`` or ``"max"``.
    backend : as for `fvkit.solve`.
    progress : function called with a line of text before each run.

    Returns
    -------
    Convergence
        Errors and observed orders; ``str()`` returns the table.

    Raises
    ------
    OrderError
        If the order is below ``expect``; an AssertionError with the table in its message.
    fvkit.SolveError
        If a run fails.
    ValueError, TypeError
        For invalid input.
    KeyboardInterrupt
        After Ctrl-C; its attribute ``result`` is the Convergence of the finished grids, None if these are too few.

    Examples
    --------
    >>> import fvkit as fv
    >>> import numpy as np
    >>> def wave(x, t):
    ...     return np.sin(2 * np.pi * (x - t))[None]
    >>> def problem(n):
    ...     return fv.Problem(fv.Advection(1.0), fv.Grid(0.0, 1.0, n), lambda x: wave(x, 0.0), 0.2, boundary=fv.Periodic())
    >>> found = fv.convergence(problem, fv.MethodOfLines(fv.Roe(), integrator=fv.DP5()), (20, 40), wave, expect=4.8,
    ...                        backend="numpy")
    >>> round(float(found.total_orders[-1]), 1)
    5.0
    """
    validation.function(problem_of, "problem_of", "of the number of cells")
    if progress is not None:
        validation.function(progress, "progress", "of a line of text")
    counts = _counts(cells, reference is None)
    measure = NORMS[validation.choice(norm, "norm", NORMS)]
    wanted = None if expect is None else validation.real(expect, "expect")
    exact = None if reference is None else averaging(reference)
    solutions: list[Solution] = []

    def found() -> Convergence:
        if exact is None:
            others = [onto(fine.q[-1], coarse.grid) for coarse, fine in pairwise(solutions)]
        else:
            others = [exact(solution.model, solution.grid, float(solution.t[-1])) for solution in solutions]
        errors = [measure((solution.q[-1] - other).reshape(len(other), -1), solution.grid.cell_volume)
                  for solution, other in zip(solutions, others, strict=False)]
        chosen = default_scheme(problem_of(counts[0])) if scheme is None else scheme
        kind = "self-converged" if exact is None else getattr(reference, "kind", "exact")
        return Convergence(scheme_name(chosen), type(solutions[0].model).__name__, kind, norm,
                           component_names(solutions[0].model, solutions[0].grid), counts[:len(solutions)], np.array(errors),
                           tuple(solution.stats.seconds for solution in solutions))

    with keeping(lambda: found() if len(solutions) >= _least(exact is None) else None):
        for count in counts:
            solutions.append(_run(problem_of, scheme, count, backend, progress))
    result = found()
    if wanted is not None:
        result.check(wanted)
    return result


def _least(alone: bool) -> int:
    """Return the smallest number of grids: 2 with a reference, 3 without, since the finest grid then has no error."""
    return 3 if alone else 2


def _counts(cells: Sequence[int], alone: bool) -> tuple[int, ...]:
    counts = tuple(validation.whole(count, "cells", at_least=1) for count in validation.listed(cells, "cells", "[50, 100, 200]"))
    least = _least(alone)
    if len(counts) < least or any(b <= a for a, b in pairwise(counts)):
        raise ValueError(f"`cells` must hold at least {least} ascending numbers{' without a reference' * alone}, got {counts}")
    if alone and any(b * counts[0] != a * counts[1] or b % a for a, b in pairwise(counts)):
        raise ValueError(f"`cells` must grow by one whole factor without a reference, such as 50, 100, 200; got {counts}")
    return counts


def averaging(reference: Any) -> Callable[[Model, Grid, float], np.ndarray]:
    """Return the reference as a function (model, grid, t) -> cell averages (num_eqn, *grid.shape)."""
    if hasattr(reference, "averages"):
        return reference.averages
    if not callable(reference):
        raise TypeError("`reference` must be a function (x, t) -> (num_eqn, m), an object with `averages(model, grid, t)`, or "
                        f"None; got {validation.shown(reference)}")
    return lambda model, grid, t: validation.array(
        cell_averages(lambda *places: reference(*places, t), grid, len(component_names(model, grid)), "reference"), "reference")


def _run(problem_of: Callable[[int], Problem], scheme: Scheme | None, count: int, backend: str,
         progress: Callable[[str], None] | None) -> Solution:
    problem = validation.instance(problem_of(count), "problem_of(n)", Problem, "a function of the number of cells")
    found = problem.grid.axes[0].num_cells
    if found != count:
        raise ValueError(f"`problem_of({count})` must have {count} cells{' along x' * (len(problem.grid.axes) > 1)}, got {found}")
    if progress is not None:
        progress(f"convergence: N = {count}")
    return solve(problem, scheme, backend=backend, nonhyperbolic="ignore")


def onto(q: np.ndarray, grid: Grid) -> np.ndarray:
    """Return averages over the cells of a coarse grid, (num_eqn, *grid.shape), of averages on a refined grid."""
    for axis, count in enumerate(grid.shape, start=1):
        if q.shape[axis] % count:
            raise ValueError(f"`cells` must grow by a whole factor along every axis without a reference, got {count} cells "
                             f"and then {q.shape[axis]}")
        q = q.reshape(*q.shape[:axis], count, -1, *q.shape[axis + 1:]).mean(axis=axis + 1)
    return q
