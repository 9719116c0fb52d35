"""`compare`: one scene, every model and solver, error against time."""

from collections.abc import Callable, Iterable, Sequence
from statistics import median
from typing import Any, NamedTuple

import numpy as np

from fvkit import MC, Limits, Model, Problem, RiemannSolver, Scheme, Solution, Status, WavePropagation, solve, validation
from fvkit.pointwise.part import public_name
from fvkit.problem.directions import directions, observables
from fvkit.problem.grid import Grid
from fvkit.run.interruption import keeping, uninterrupted
from fvkit.schemes.fitting import check_axes
from fvkit.schemes.riemann import default_riemann
from fvkit.studies.cost import predicted
from fvkit.studies.report import Profile, Report, Row, environment, observed_orders
from fvkit.studies.scheme_names import describe, settings
from fvkit_granular.models.reduced import Reduced
from fvkit_granular.models.registry import RIEMANN
from fvkit_granular.models.shallow_water import ShallowWater
from fvkit_granular.models.two_phase import TwoPhase
from fvkit_granular.scenes.reference import Reference
from fvkit_granular.scenes.scene import Scene
from fvkit_granular.studies.fine_grid_reference import fine_scheme, self_converged

#: Numbers of cells, along x, where none are given, by the number of axes.
CELLS = {1: (100, 200, 400, 800), 2: (25, 50, 100)}

#: Share of the largest depth below which velocities and solid fractions are not compared.
DEEP = 1e-6


class _Run(NamedTuple):
    """One line of the comparison before it is run."""

    model: Model
    scheme: Scheme
    cells: int


def compare(scene: Scene, models: Sequence[Any] | None = None, riemann: Sequence[RiemannSolver] | None = None,
            cells: Sequence[int] | None = None, limiter: Any = None, order: int | Sequence[int] = 2,
            repeats: int = 3, reference: Reference | None = None, *, schemes: Sequence[Scheme] | None = None, cfl: float = 0.9,
            backend: str = "auto", seconds: float | None = None, progress: Callable[[str], None] | None = None) -> Report:
    """Run a scene with every model, Riemann solver, limiter and order on every grid, and report error against time.

    Parameters
    ----------
    scene : the scene.
    models : instances, or classes that get the scene's g and gamma. Default: TwoPhase, Reduced, ShallowWater.
    riemann : solvers. Default: all that serve the first model, and their default for the others; if given, all pairs.
    cells : numbers of cells, with two axes along x. Default: 100, 200, 400, 800, with two axes 25, 50, 100.
    limiter : one, or a list of them; default MC. (A tuple is one per wave family, as in `fvkit.WavePropagation`.)
    order : 1, 2, or a list of both.
    repeats : every run is repeated this often, interleaved, after a warm-up; the report holds median and minimum.
    reference : default: the scene's own, else the full model on 4 times the finest grid (self-converged): TwoPhase, or
        where that is not among the models the first of them with two phases. Its detail estimates its own error.
    schemes : `fvkit.WavePropagation` and `fvkit.MethodOfLines` with all their settings, in place of ``riemann``,
        ``limiter``, ``order`` and ``cfl``; each is run with every model that it serves.
    cfl, backend : as for `fvkit.WavePropagation` and `fvkit.solve`.
    seconds : wall time that one run may take. Runs that would take longer, to judge by coarser ones, are left out,
        others stopped: rows with the status ``"over_budget"``. A self-converged reference may take 16 times that, with two
        axes 64 times.
    progress : function that receives a line of text before each run.

    Returns
    -------
    fvkit.studies.Report
        Errors of the cell averages: what a model makes of the reference flow, against what it computed. A run that
        fails is a row with its status.

    Raises
    ------
    ValueError, TypeError
        For bad input, or a pair of model and solver that cannot work.
    KeyboardInterrupt
        After Ctrl-C; its attribute ``result`` is the Report of the runs that are done, None where there are none.
    """
    scene = validation.instance(scene, "scene", Scene, "such as gr.scene('riemann')")
    for name, given, example in (("models", models, "[gr.TwoPhase]"), ("riemann", riemann, "[fv.HLL()]"),
                                 ("cells", cells, "[100, 200]"), ("schemes", schemes, "[fv.WavePropagation(fv.HLL())]")):
        if given is not None:
            validation.listed(given, name, example)
    counts = tuple(validation.whole(count, "cells", at_least=1) for count in (CELLS[len(scene.axes)] if cells is None else cells))
    repetitions = validation.whole(repeats, "repeats", at_least=1)
    if not counts:
        raise ValueError("`cells` must not be empty")
    kinds = [scene.model(model) for model in (models or (TwoPhase, Reduced, ShallowWater))]
    for kind in kinds:
        directions(kind, scene.grid(counts[0]))
    if schemes is None:
        runs = _runs(kinds, riemann, counts, limiter, order, cfl)
    elif riemann is not None or limiter is not None:
        raise ValueError("`schemes` name their own Riemann solver and limiter: leave `riemann` and `limiter` out")
    else:
        runs = _runs_of(scene, kinds, schemes, counts)
    budget = None if seconds is None else validation.real(seconds, "seconds", above=0.0)
    tell = (lambda line: None) if progress is None else validation.function(progress, "progress", "of a line of text")
    known = scene.known_reference() if reference is None else reference
    if known is not None:
        validation.instance(known, "reference", Reference, "such as gr.FunctionReference('exact', 'a sentence', at=flow)")
    full = scene.model(TwoPhase) if known is not None else _full_model(scene, kinds)
    if known is None:
        high = any(run.scheme.time_integrator is not None for run in runs)
        known = self_converged(scene, full, fine_scheme(full, high), counts, backend, budget, tell)
    seconds_of: list[list[float]] = [[] for _ in runs]
    solutions: list[Solution | None] = [None] * len(runs)

    def report(every: bool) -> Report:
        chosen = [k for k, times in enumerate(seconds_of) if times or every]
        rows = _rows(scene, [runs[k] for k in chosen], [solutions[k] for k in chosen], [seconds_of[k] for k in chosen], known)
        return _report(scene, full, max(counts), known, rows)

    with keeping(lambda: report(every=False) if any(seconds_of) else None):
        _measure(scene, runs, solutions, seconds_of, repetitions, backend, budget, tell)
    return report(every=True)


def _report(scene: Scene, full: Model, cells: int, known: Reference, rows: list[tuple[Row, Solution | None]]) -> Report:
    """The report of runs; ``cells`` is the number of cells of the reference's profile."""
    machine, versions = environment("fvkit", "numpy", "scipy", "matplotlib", "attrs", "numba")
    finest = scene.problem(full, cells)
    b = finest.aux_averages["b"]
    averages = known.averages(finest.model, finest.grid, scene.t_end)
    profiles = {"reference": _profile(finest.grid, observables(finest.model, finest.grid, averages, finest.aux_averages))}
    report = Report(scene.name or "unnamed", {"kind": known.kind, "detail": known.detail}, [row for row, _ in rows], machine,
                    versions, public_name(full), profiles, (finest.grid.axes[0].centers, b) if b.any() else None,
                    {"path_sensitivity": known.path_sensitivity()})
    solutions = {id(row): solution for row, solution in rows}
    for label, series in report.series().items():
        done = [solution for row in series if (solution := solutions[id(row)]) is not None]
        if done:
            profiles[label] = _profile(done[-1].grid, done[-1].observables())
    return report


def _profile(grid: Grid, seen: dict[str, np.ndarray]) -> Profile:
    return Profile(grid.axes[0].centers, seen, *(axis.centers for axis in grid.axes[1:]))


def _runs(models: list[Model], riemann: Sequence[RiemannSolver] | None, cells: tuple[int, ...], limiter: Any, order: Any,
          cfl: float) -> list[_Run]:
    if isinstance(limiter, list) and not limiter:
        raise TypeError("`limiter` must be a limiter or a list of them, not empty, got []")
    limiters = limiter if isinstance(limiter, list) else [MC() if limiter is None else limiter]
    orders = order if isinstance(order, (list, tuple)) else [order]
    result = []
    for model in models:
        if riemann is not None:
            solvers: Iterable[RiemannSolver] = riemann
        elif model is models[0]:
            solvers = [kind() for kind in RIEMANN.values() if kind.serves(model)]
        else:
            solvers = (default_riemann(model),)
        for solver in solvers:
            for chosen in limiters:
                for number in orders:
                    scheme = WavePropagation(solver, limiter=chosen, order=number, cfl=cfl)
                    scheme.parts(model, ())
                    result += [_Run(model, scheme, count) for count in cells]
    return result


def _runs_of(scene: Scene, models: list[Model], schemes: Sequence[Scheme], cells: tuple[int, ...]) -> list[_Run]:
    """Every scheme with every model that it serves."""
    result, refusals = [], []
    for model in models:
        sources = scene.problem(model, cells[0]).sources
        for scheme in schemes:
            try:
                validation.instance(scheme, "schemes", Scheme, "such as fv.MethodOfLines(fv.Roe())").parts(model, sources)
                check_axes(scheme, scene.grid(cells[0]))
            except ValueError as refusal:
                refusals.append(str(refusal))
            else:
                result += [_Run(model, scheme, count) for count in cells]
    if not result:
        raise ValueError("`schemes` serve none of the models: " + (refusals[0] if refusals else "there are none"))
    return result


def _measure(scene: Scene, runs: list[_Run], solutions: list[Solution | None], seconds: list[list[float]], repeats: int,
             backend: str, budget: float | None, tell: Callable[[str], None]) -> None:
    """Run everything ``repeats`` times, interleaved; note for each run its first solution, None if left out, and the times."""
    def solved(problem: Problem, scheme: Scheme) -> Solution:
        return uninterrupted(solve(problem, scheme, limits=Limits(seconds=budget), backend=backend, nonhyperbolic="ignore",
                                   throw=False))

    for key in dict.fromkeys((run.model, run.scheme) for run in runs):
        coarse = min(run.cells for run in runs if (run.model, run.scheme) == key)
        solved(scene.problem(key[0], coarse), key[1])
    for repeat in range(repeats):
        for k, run in enumerate(runs):
            tell(f"repeat {repeat + 1}/{repeats}, run {k + 1}/{len(runs)}: {public_name(run.model)} "
                 f"{describe(run.scheme)} N={run.cells}")
            known = solutions[k]
            if (known is None or not known.success) if repeat else \
                    _too_long(run, runs, solutions, budget, len(scene.axes)):
                continue
            solution = solved(scene.problem(run.model, run.cells), run.scheme)
            solutions[k] = known or solution
            seconds[k].append(solution.stats.seconds)


def _too_long(run: _Run, runs: list[_Run], solutions: list[Solution | None], budget: float | None, axes: int) -> bool:
    """Whether a run will exceed the budget, to judge by coarser ones of its series."""
    if budget is None:
        return False
    coarser = [(other.cells, solution) for other, solution in zip(runs, solutions, strict=True)
               if other[:2] == run[:2] and other.cells < run.cells and solution is not None]
    stopped = any(solution.status is Status.OVER_BUDGET for _, solution in coarser)
    costs = [(cells, solution.stats.seconds) for cells, solution in coarser]
    return stopped or predicted(run.cells, costs, axes) > budget


def _rows(scene: Scene, runs: list[_Run], solutions: list[Solution | None], seconds: list[list[float]],
          reference: Reference) -> list[tuple[Row, Solution | None]]:
    rows: list[tuple[Row, Solution | None]] = []
    before: tuple[_Run, Row] | None = None
    for run, solution, times in zip(runs, solutions, seconds, strict=True):
        row = _row(scene, run, solution, times, reference)
        coarser = before[1] if before is not None and before[0][:2] == run[:2] else None
        row["order_observed"] = observed_orders(coarser, row)
        row["backend"] = row["backend"] or (coarser or {}).get("backend")
        before = (run, row)
        rows.append((row, solution))
    return rows


def _row(scene: Scene, run: _Run, solution: Solution | None, times: list[float], reference: Reference) -> Row:
    named = {"model": public_name(run.model), **settings(run.scheme)}
    if solution is None:
        return {**named, "backend": None, "cells": run.cells, "steps": 0, "rejected": 0, "seconds": None, "seconds_min": None,
                "ns_per_cell_step": None, "error": {}, "error_l2": {}, "error_max": {}, "mass_drift": {},
                "status": Status.OVER_BUDGET.name.lower()}
    stats = solution.stats
    errors: dict[str, dict[str, float]] = {"error": {}, "error_l2": {}, "error_max": {}}
    if solution.success:
        for name, difference in deviations(solution, reference.averages(run.model, solution.grid, scene.t_end)).items():
            errors["error"][name] = float(solution.grid.cell_volume * difference.sum())
            errors["error_l2"][name] = float(np.sqrt(solution.grid.cell_volume * (difference**2).sum()))
            errors["error_max"][name] = float(difference.max())
    return {**named, "backend": stats.backend, "cells": run.cells, "steps": stats.steps, "rejected": stats.rejected,
            "seconds": median(times), "seconds_min": min(times),
            "ns_per_cell_step": 1e9 * median(times) / max(stats.cell_updates, 1), **errors,
            "mass_drift": stats.mass_drift, "status": solution.status.name.lower()}


def deviations(solution: Solution, averages: np.ndarray) -> dict[str, np.ndarray]:
    """Return abs(computed - reference) of each observable at the end of a run, {name: array of cells}.

    Where the reference or the run is all but dry, what is not a depth has no meaning and counts as 0.

    Parameters
    ----------
    solution : the run.
    averages : cell averages of the reference, of the shape of a state, for the model of the run.
    """
    wanted, found = observables(solution.model, solution.grid, averages, solution.aux), solution.observables()
    deep = np.minimum(found["h"], wanted["h"]) > DEEP * wanted["h"].max()
    return {name: np.abs(found[name] - wanted[name]) * (1.0 if name == "h" else deep)
            for name in compared(found)}


def compared(names: Iterable[str]) -> list[str]:
    """Return the observables that have an error of their own: heights are depths over the bottom, speeds sizes of velocities."""
    return [name for name in names if name not in ("surface", "interface") and not name.startswith("speed")]


def _full_model(scene: Scene, models: list[Model]) -> Model:
    """The model whose fine solution is the reference: TwoPhase where it takes part, or nothing else has two phases."""
    two = [model for model in models if len(model.phases) == 2]
    return scene.model(TwoPhase) if not two or any(isinstance(model, TwoPhase) for model in two) else two[0]
