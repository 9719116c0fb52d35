"""`compare`: one scene, every model and solver, error against time."""

from collections.abc import Callable, Iterable, Sequence
from statistics import median
from typing import Any, NamedTuple

import numpy as np

from fvkit import MC, Model, RiemannSolver, Roe, Solution, WavePropagation, _validate, solve
from fvkit.names import public_name
from fvkit.study.report import Profile, Report, Row, environment, observed_orders
from fvkit_granular.parts import RIEMANN
from fvkit_granular.reduced import Reduced
from fvkit_granular.scene import Reference, Scene, SelfConverged
from fvkit_granular.shallow_water import ShallowWater
from fvkit_granular.two_phase import TwoPhase

#: A self-converged reference has this many times the cells of the finest run.
REFINEMENT = 4

#: Share of the largest depth below which velocities and solid fractions are not compared.
DEEP = 1e-6


class _Run(NamedTuple):
    """One line of the comparison before it is run."""

    model: Model
    scheme: WavePropagation
    cells: int


def compare(scene: Scene, models: Sequence[Any] | None = None, riemann: Sequence[RiemannSolver] | None = None,
            cells: Sequence[int] = (100, 200, 400, 800), limiter: Any = None, order: int | Sequence[int] = 2,
            repeats: int = 3, reference: Reference | None = None, *, cfl: float = 0.9, backend: str = "auto",
            progress: Callable[[str], None] | None = None) -> Report:
    """Run a scene with every model, Riemann solver, limiter and order on every grid, and report error against time.

    Parameters
    ----------
    scene : the scene.
    models : instances, or classes that get the scene's g and gamma. Default: TwoPhase, Reduced, ShallowWater.
    riemann : solvers. Default: all that serve the first model, and their default for the others; if given, all pairs.
    cells : numbers of cells.
    limiter : one, or a list of them; default MC. (A tuple is one per wave family, as in `fvkit.WavePropagation`.)
    order : 1, 2, or a list of both.
    repeats : every run is repeated this often, interleaved, after a warm-up; the report holds median and minimum.
    reference : default: the scene's own, else the full model on 4 times the finest grid (self-converged): TwoPhase, or
        where that is not among the models the first of them with two phases.
    cfl, backend : as for `fvkit.WavePropagation` and `fvkit.solve`.
    progress : function that receives a line of text before each run.

    Returns
    -------
    fvkit.study.Report
        Errors of the cell averages: what a model makes of the reference flow, against what it computed. A run that
        fails is a row with its status.

    Raises
    ------
    ValueError, TypeError
        For bad input, or a pair of model and solver that cannot work.
    """
    counts = tuple(_validate.whole(count, "cells", at_least=1) for count in cells)
    repetitions = _validate.whole(repeats, "repeats", at_least=1)
    if not counts:
        raise ValueError("`cells` must not be empty")
    kinds = [scene.model(model) for model in (models or (TwoPhase, Reduced, ShallowWater))]
    runs = _runs(kinds, riemann, counts, limiter, order, cfl)
    tell = progress or (lambda line: None)
    known = reference or scene.known_reference()
    full = scene.model(TwoPhase) if known is not None else _full_model(scene, kinds)
    known = known or _self_converged(scene, full, max(counts), backend, tell)
    rows = _measure(scene, runs, known, repetitions, backend, tell)
    machine, versions = environment("fvkit", "numpy", "scipy", "matplotlib", "attrs", "numba")
    finest = scene.problem(full, max(counts))
    b = finest.aux_averages["b"]
    averages = known.averages(finest.model, finest.grid, scene.t_end)
    profiles = {"reference": Profile(finest.grid.centers, finest.model.observables(averages, finest.aux_averages))}
    report = Report(scene.name or "unnamed", {"kind": known.kind, "detail": known.detail}, [row for row, _ in rows], machine,
                    versions, public_name(full), profiles, (finest.grid.centers, b) if b.any() else None,
                    {"path_sensitivity": known.path_sensitivity()})
    solutions = {id(row): solution for row, solution in rows}
    for label, series in report.series().items():
        solution = solutions[id(series[-1])]
        profiles[label] = Profile(solution.grid.centers, solution.observables())
    return report


def _runs(models: list[Model], riemann: Sequence[RiemannSolver] | None, cells: tuple[int, ...], limiter: Any, order: Any,
          cfl: float) -> list[_Run]:
    limiters = limiter if isinstance(limiter, list) else [limiter or MC()]
    orders = order if isinstance(order, (list, tuple)) else [order]
    result = []
    for model in models:
        if riemann is not None:
            solvers: Iterable[RiemannSolver] = riemann
        elif model is models[0]:
            solvers = [kind() for kind in RIEMANN.values() if kind.serves(model)]
        else:
            solvers = (model.default_riemann(),)
        for solver in solvers:
            for chosen in limiters:
                for number in orders:
                    scheme = WavePropagation(solver, limiter=chosen, order=number, cfl=cfl)
                    scheme.parts(model, ())
                    result += [_Run(model, scheme, count) for count in cells]
    return result


def _measure(scene: Scene, runs: list[_Run], reference: Reference, repeats: int, backend: str,
             tell: Callable[[str], None]) -> list[tuple[Row, Solution]]:
    """Run everything ``repeats`` times, interleaved; return a row and the last solution for each run."""
    for key in dict.fromkeys((run.model, run.scheme) for run in runs):
        coarse = min(run.cells for run in runs if (run.model, run.scheme) == key)
        solve(scene.problem(key[0], coarse), key[1], backend=backend, throw=False, nonhyperbolic="ignore")
    seconds: list[list[float]] = [[] for _ in runs]
    solutions: list[Solution] = []
    for repeat in range(repeats):
        for k, run in enumerate(runs):
            tell(f"repeat {repeat + 1}/{repeats}, run {k + 1}/{len(runs)}: {public_name(run.model)} "
                 f"{public_name(run.scheme.riemann)} N={run.cells}")
            if repeat and not solutions[k].success:
                continue
            problem = scene.problem(run.model, run.cells)
            solution = solve(problem, run.scheme, backend=backend, throw=False, nonhyperbolic="ignore")
            seconds[k].append(solution.stats.seconds)
            if repeat == 0:
                solutions.append(solution)
    rows: list[tuple[Row, Solution]] = []
    before: tuple[_Run, Row] | None = None
    for run, solution, times in zip(runs, solutions, seconds, strict=True):
        row = _row(scene, run, solution, times, reference)
        same = before is not None and before[0][:2] == run[:2]
        row["order_observed"] = observed_orders(before[1] if same and before is not None else None, row)
        before = (run, row)
        rows.append((row, solution))
    return rows


def _row(scene: Scene, run: _Run, solution: Solution, times: list[float], reference: Reference) -> Row:
    stats = solution.stats
    errors: dict[str, dict[str, float]] = {"error": {}, "error_l2": {}, "error_max": {}}
    if solution.success:
        for name, difference in deviations(solution, reference.averages(run.model, solution.grid, scene.t_end)).items():
            errors["error"][name] = float(solution.grid.dx * difference.sum())
            errors["error_l2"][name] = float(np.sqrt(solution.grid.dx * (difference**2).sum()))
            errors["error_max"][name] = float(difference.max())
    return {"model": public_name(run.model), "riemann": public_name(run.scheme.riemann),
            "limiter": public_name(run.scheme.limiter), "order": run.scheme.order, "backend": stats.backend,
            "cells": run.cells, "steps": stats.steps, "rejected": stats.rejected,
            "seconds": median(times), "seconds_min": min(times),
            "ns_per_cell_step": 1e9 * median(times) / max(stats.cell_updates, 1), **errors,
            "mass_drift": stats.mass_drift, "status": solution.status.name.lower()}


def deviations(solution: Solution, averages: np.ndarray) -> dict[str, np.ndarray]:
    """Return abs(computed - reference) of each observable at the end of a run, {name: (n,)}.

    Where the reference or the run is all but dry, what is not a depth has no meaning and counts as 0.

    Parameters
    ----------
    solution : the run.
    averages : cell averages (num_eqn, n) of the reference, for the model of the run.
    """
    wanted, found = solution.model.observables(averages, solution.aux), solution.observables()
    deep = np.minimum(found["h"], wanted["h"]) > DEEP * wanted["h"].max()
    return {name: np.abs(found[name] - wanted[name]) * (1.0 if name == "h" else deep)
            for name in found if name not in ("surface", "interface")}


def _full_model(scene: Scene, models: list[Model]) -> Model:
    """The model whose fine solution is the reference: TwoPhase where it takes part, or nothing else has two phases."""
    two = [model for model in models if len(model.phases) == 2]
    return scene.model(TwoPhase) if not two or any(isinstance(model, TwoPhase) for model in two) else two[0]


def _self_converged(scene: Scene, model: Model, finest: int, backend: str, tell: Callable[[str], None]) -> Reference:
    cells = REFINEMENT * finest
    solver = Roe() if model.defines("decompose") else model.default_riemann()
    name = type(solver).__name__
    tell(f"reference: {public_name(model)} {public_name(solver)} N={cells}")
    solution = solve(scene.problem(model, cells), WavePropagation(solver), backend=backend, nonhyperbolic="ignore")
    return SelfConverged("self-converged", f"the full model itself, {name}, MC, order 2, N = {cells}", solution=solution)
