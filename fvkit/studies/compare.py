"""`compare`: error against run time of schemes on one problem or several, on a sequence of grids."""

from collections.abc import Callable, Mapping, Sequence
from functools import partial
from statistics import median
from typing import Any, NamedTuple

import attrs
import numpy as np

from fvkit import validation
from fvkit.output.solution import Solution
from fvkit.output.status import Status
from fvkit.pointwise.part import public_name
from fvkit.problem.directions import observables
from fvkit.problem.grid import Grid
from fvkit.problem.problem import Problem
from fvkit.run.control import Limits
from fvkit.run.interruption import keeping, uninterrupted
from fvkit.run.solve import solve
from fvkit.schemes.fitting import check_axes
from fvkit.schemes.riemann import HLL, Roe, Rusanov
from fvkit.schemes.scheme import Scheme
from fvkit.schemes.wave_propagation import WavePropagation
from fvkit.studies.convergence import averaging
from fvkit.studies.cost import predicted
from fvkit.studies.fine_grid_reference import fine_grid_reference, fine_scheme
from fvkit.studies.report import Report, Row, environment, observed_orders
from fvkit.studies.report_data import FinalProfile
from fvkit.studies.scheme_names import scheme_name, settings

ProblemOf = Callable[[int], Problem]

#: {observable: |computed - reference|} of a run and the reference's averages of the conserved quantities.
Deviations = Callable[[Solution, np.ndarray], dict[str, np.ndarray]]

#: Numbers of cells, along x, where none are given, by the number of axes.
CELLS = {1: (100, 200, 400, 800), 2: (25, 50, 100)}


def compare(problems: ProblemOf | Mapping[str, ProblemOf], schemes: Sequence[Scheme] | None = None,
            cells: Sequence[int] = CELLS[1], reference: Any = None, *, name: str = "problem", repeats: int = 3,
            backend: str = "auto", seconds: float | None = None, progress: Callable[[str], None] | None = None) -> Report:
    """Compare schemes, and models, on one problem: L1 error and observed order against run time.

    ::

        E = sum over the cells of |observable(computed averages) - observable(reference averages)| * volume, at t_end.

    Parameters
    ----------
    problems : number of cells -> `fvkit.Problem`, or {label: such a function} for several models of one flow. With two axes
        it is the number along x.
    schemes : schemes; each runs with every model that it serves. Default: second order with `Roe` (where the model defines
        ``decompose``), `HLL` and `Rusanov`.
    cells : numbers of cells, ascending.
    reference : function (x, t) -> conserved values (num_eqn, m) at x (m,), averaged over the cells by quadrature, with two
        axes (x, y, t) -> (num_eqn, my, mx); or an object with ``averages(model, grid, t)`` -> (num_eqn, *grid.shape), which
        models with other conserved quantities need. None for a run of the first problem on 4 times the finest grid.
    name : name of the problem in the report.
    repeats : number of repeats of each run, interleaved, after a warm-up; the report has median and minimum.
    backend : as for `fvkit.solve`.
    seconds : time limit per run, s. Runs expected to take longer, from coarser ones, are skipped, others
        are stopped: rows with the status ``"over_budget"``.
    progress : function called with a line of text before each run.

    Returns
    -------
    fvkit.studies.Report
        One row per run, a failed one with its status; ``print(report.table())``, ``report.plot()``, ``report.save(folder)``.

    Raises
    ------
    ValueError, TypeError
        For invalid input; models with different conserved quantities under a reference that is a function or None.
    KeyboardInterrupt
        After Ctrl-C; its attribute ``result`` is the Report of the finished runs, None where there are none.

    Examples
    --------
    >>> import fvkit as fv
    >>> import numpy as np
    >>> def wave(x, t):
    ...     return np.exp(-100.0 * (x - t - 0.3) ** 2)[None]
    >>> def problem(n):
    ...     return fv.Problem(fv.Advection(1.0), fv.Grid(0.0, 1.0, n), lambda x: wave(x, 0.0), 0.2)
    >>> schemes = [fv.WavePropagation(fv.Roe(), limiter=fv.MC()), fv.WavePropagation(fv.Roe(), order=1)]
    >>> report = fv.compare(problem, schemes, (50, 100), wave, repeats=1, backend="numpy")
    >>> [row["order"] for row in report.rows], report.rows[1]["error"]["u"] < 0.3 * report.rows[3]["error"]["u"]
    ([2, 2, 1, 1], True)
    """
    named = problems if isinstance(problems, Mapping) else {"": problems}
    if not named:
        raise ValueError("`problems` must hold at least one function of the number of cells, got {}")
    for problem_of in named.values():
        validation.function(problem_of, "problems", "of the number of cells")
    counts, repetitions, budget, tell = limits_of(cells, repeats, seconds, progress)
    coarse = {label: validation.instance(problem_of(counts[0]), "problems(n)", Problem, "a function of the number of cells")
              for label, problem_of in named.items()}
    given = None if schemes is None else validation.listed(schemes, "schemes", SCHEMES)
    models = [(label or public_name(problem.model), named[label], problem) for label, problem in coarse.items()]
    runs = runs_of(models, given, counts)
    first = next(iter(named.values()))
    if reference is not None:
        averaging(reference)
    if not hasattr(reference, "averages"):
        _check_alike(coarse)
    if reference is None:
        model = next(iter(coarse.values())).model
        high = any(run.scheme.time_integrator is not None for run in runs)
        reference = fine_grid_reference(first, fine_scheme(model, high), counts, backend, budget, tell)
    comparison = Comparison(name, runs[0].label, partial(first, max(counts)), reference)
    return comparison.measure(runs, repetitions, backend, budget, tell)


def limits_of(cells: Any, repeats: Any, seconds: Any, progress: Any
              ) -> tuple[tuple[int, ...], int, float | None, Callable[[str], None]]:
    """Return these arguments of a comparison, checked: cells, repeats, budget of a run, s, and the function told of each run."""
    counts = tuple(validation.whole(count, "cells", at_least=1) for count in validation.listed(cells, "cells", "[100, 200]"))
    if not counts:
        raise ValueError("`cells` must not be empty")
    return (counts, validation.whole(repeats, "repeats", at_least=1),
            None if seconds is None else validation.real(seconds, "seconds", above=0.0),
            (lambda line: None) if progress is None else validation.function(progress, "progress", "of a line of text"))


#: An example of `schemes`, for messages.
SCHEMES = "[fv.WavePropagation(fv.HLL())]"


def _check_alike(problems: Mapping[str, Problem]) -> None:
    names = {label: problem.model.conserved for label, problem in problems.items()}
    if len(set(names.values())) > 1:
        raise ValueError("`reference` must be an object with `averages(model, grid, t)`, since the models conserve different "
                         f"quantities: {', '.join(f'{label}: {rows}' for label, rows in names.items())}")


class PlannedRun(NamedTuple):
    """One line of a comparison before it is run: a model by its label, the problem by the number of cells, the scheme."""

    label: str
    problem_of: ProblemOf
    scheme: Scheme
    cells: int

    @property
    def series(self) -> tuple[ProblemOf, Scheme]:
        """What runs that differ only in the number of cells have in common."""
        return self.problem_of, self.scheme


def runs_of(problems: Sequence[tuple[str, ProblemOf, Problem]], schemes: Sequence[Scheme] | None, cells: tuple[int, ...]
            ) -> list[PlannedRun]:
    """Return the runs of each problem (its label, problem by the number of cells, and the problem on the first grid) with every
    scheme that serves it, the default ones where ``schemes`` is None.
    """
    runs: list[PlannedRun] = []
    refusals = ["there are none"]
    for label, problem_of, problem in problems:
        usual = [WavePropagation(solver) for solver in (Roe(), HLL(), Rusanov()) if solver.serves(problem.model)]
        for scheme in usual if schemes is None else schemes:
            try:
                validation.instance(scheme, "schemes", Scheme, "such as fv.MethodOfLines(fv.Roe())")
                scheme.parts(problem.model, problem.sources)
                check_axes(scheme, problem.grid)
            except ValueError as refusal:
                refusals.append(str(refusal))
            else:
                runs += [PlannedRun(label, problem_of, scheme, count) for count in cells]
    if not runs:
        raise ValueError(f"`schemes` serve none of the models: {refusals[:2][-1]}")
    return runs


def deviations(solution: Solution, averages: np.ndarray) -> dict[str, np.ndarray]:
    """Return abs(computed - reference) of each observable at the end of a run, {name: array of cells}."""
    wanted, found = observables(solution.model, solution.grid, averages, solution.aux), solution.observables()
    return {name: np.abs(found[name] - wanted[name]) for name in found}


@attrs.frozen
class Comparison:
    """What the runs of a comparison are measured against.

    Parameters
    ----------
    name : name of the problem or scene.
    full_model : label of the model of the reference.
    finest : () -> the problem of the reference's profile.
    reference : object with ``averages(model, grid, t)``, or a function of places and time; ``kind`` and ``detail`` describe it.
    deviations : what counts as the error of a run.
    remarks : () -> further information for the table, as for `Report`.
    """

    name: str
    full_model: str
    finest: Callable[[], Problem]
    reference: Any
    deviations: Deviations = deviations
    remarks: Callable[[], dict[str, Any]] = dict

    def measure(self, runs: Sequence[PlannedRun], repeats: int, backend: str, budget: float | None,
                tell: Callable[[str], None]) -> Report:
        """Run everything and report it; a KeyboardInterrupt carries the report of what is done as its ``result``."""
        seconds: list[list[float]] = [[] for _ in runs]
        solutions: list[Solution | None] = [None] * len(runs)

        def report(every: bool) -> Report:
            chosen = [k for k, times in enumerate(seconds) if times or every]
            return self._report([(runs[k], solutions[k], seconds[k]) for k in chosen])

        with keeping(lambda: report(every=False) if any(seconds) else None):
            _measure(runs, solutions, seconds, repeats, backend, budget, tell)
        return report(every=True)

    def _report(self, done: list[tuple[PlannedRun, Solution | None, list[float]]]) -> Report:
        machine, versions = environment("fvkit", "numpy", "scipy", "matplotlib", "attrs", "numba")
        finest = self.finest()
        b = finest.aux_averages.get("b")
        averages = averaging(self.reference)(finest.model, finest.grid, finest.t_end)
        profiles = {"reference": _profile(finest.grid, observables(finest.model, finest.grid, averages, finest.aux_averages))}
        rows = self._rows(done)
        kind, detail = getattr(self.reference, "kind", "exact"), getattr(self.reference, "detail", "a function")
        report = Report(self.name, {"kind": kind, "detail": detail}, rows, machine, versions, self.full_model, profiles,
                        (finest.grid.axes[0].centers, b) if b is not None and b.any() else None, self.remarks())
        solutions = {id(row): solution for row, (_, solution, _) in zip(rows, done, strict=True)}
        for label, series in report.series().items():
            last = [solution for row in series if (solution := solutions[id(row)]) is not None]
            if last:
                profiles[label] = _profile(last[-1].grid, last[-1].observables())
        return report

    def _rows(self, done: list[tuple[PlannedRun, Solution | None, list[float]]]) -> list[Row]:
        rows: list[Row] = []
        before: tuple[PlannedRun, Row] | None = None
        for run, solution, times in done:
            row = self._row(run, solution, times)
            coarser = before[1] if before is not None and before[0].series == run.series else None
            row["order_observed"] = observed_orders(coarser, row)
            row["backend"] = row["backend"] or (coarser or {}).get("backend")
            before = (run, row)
            rows.append(row)
        return rows

    def _row(self, run: PlannedRun, solution: Solution | None, times: list[float]) -> Row:
        named = {"model": run.label, **settings(run.scheme)}
        if solution is None:
            return {**named, "backend": None, "cells": run.cells, "steps": 0, "rejected": 0, "seconds": None,
                    "seconds_min": None, "ns_per_cell_step": None, "error": {}, "error_l2": {}, "error_max": {},
                    "mass_drift": {}, "status": Status.OVER_BUDGET.name.lower()}
        stats = solution.stats
        errors: dict[str, dict[str, float]] = {"error": {}, "error_l2": {}, "error_max": {}}
        if solution.success:
            wanted = averaging(self.reference)(solution.model, solution.grid, float(solution.t[-1]))
            for name, difference in self.deviations(solution, wanted).items():
                errors["error"][name] = float(solution.grid.cell_volume * difference.sum())
                errors["error_l2"][name] = float(np.sqrt(solution.grid.cell_volume * (difference**2).sum()))
                errors["error_max"][name] = float(difference.max())
        return {**named, "backend": stats.backend, "cells": run.cells, "steps": stats.steps, "rejected": stats.rejected,
                "seconds": median(times), "seconds_min": min(times),
                "ns_per_cell_step": 1e9 * median(times) / max(stats.cell_updates, 1), **errors,
                "mass_drift": stats.mass_drift, "status": solution.status.name.lower()}


def _profile(grid: Grid, seen: dict[str, np.ndarray]) -> FinalProfile:
    return FinalProfile(grid.axes[0].centers, seen, *(axis.centers for axis in grid.axes[1:]))


def _measure(runs: Sequence[PlannedRun], solutions: list[Solution | None], seconds: list[list[float]], repeats: int, backend: str,
             budget: float | None, tell: Callable[[str], None]) -> None:
    """Run everything ``repeats`` times, interleaved; note for each run its first solution, None if left out, and the times."""
    def solved(run: PlannedRun) -> Solution:
        return uninterrupted(solve(run.problem_of(run.cells), run.scheme, limits=Limits(seconds=budget), backend=backend,
                                   nonhyperbolic="ignore", throw=False))

    for series in dict.fromkeys(run.series for run in runs):
        solved(min((run for run in runs if run.series == series), key=lambda run: run.cells))
    for repeat in range(repeats):
        for k, run in enumerate(runs):
            tell(f"repeat {repeat + 1}/{repeats}, run {k + 1}/{len(runs)}: {run.label} {scheme_name(run.scheme)} N={run.cells}")
            known = solutions[k]
            if (known is None or not known.success) if repeat else _too_long(run, runs, solutions, budget):
                continue
            solution = solved(run)
            solutions[k] = known or solution
            seconds[k].append(solution.stats.seconds)


def _too_long(run: PlannedRun, runs: Sequence[PlannedRun], solutions: list[Solution | None], budget: float | None) -> bool:
    """Whether a run will exceed the budget, to judge by coarser ones of its series."""
    if budget is None:
        return False
    coarser = [solution for other, solution in zip(runs, solutions, strict=True)
               if other.series == run.series and other.cells < run.cells and solution is not None]
    if not coarser or any(solution.status is Status.OVER_BUDGET for solution in coarser):
        return bool(coarser)
    costs = [(solution.grid.axes[0].num_cells, solution.stats.seconds) for solution in coarser]
    return predicted(run.cells, costs, len(coarser[0].grid.axes)) > budget
