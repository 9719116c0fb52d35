"""`compare`: one scene, every model and solver, error against time."""

import warnings
from collections.abc import Callable, Iterable, Sequence
from functools import partial
from typing import Any

import numpy as np

from fvkit import MC, Model, Problem, RiemannSolver, Scheme, Solution, WavePropagation, validation
from fvkit.pointwise.part import public_name
from fvkit.problem.directions import directions, observables
from fvkit.schemes.riemann import default_riemann
from fvkit.studies.compare import CELLS, SCHEMES, Comparison, PlannedRun, limits_of, runs_of
from fvkit.studies.fine_grid_reference import fine_grid_reference, fine_scheme
from fvkit.studies.report import Report
from fvkit_granular.models.reduced import Reduced
from fvkit_granular.models.registry import RIEMANN
from fvkit_granular.models.shallow_water import ShallowWater
from fvkit_granular.models.two_phase import TwoPhase
from fvkit_granular.scenes.reference import Reference, SelfConverged
from fvkit_granular.scenes.scene import Scene

#: Share of the largest depth below which velocities and solid fractions are not compared.
DEEP = 1e-6


def compare(scene: Scene, models: Sequence[Any] | None = None, riemann: Sequence[RiemannSolver] | None = None,
            cells: Sequence[int] | None = None, limiter: Any = None, order: int | Sequence[int] = 2,
            repeats: int = 3, reference: Reference | None = None, *, schemes: Sequence[Scheme] | None = None, cfl: float = 0.9,
            backend: str = "auto", seconds: float | None = None, progress: Callable[[str], None] | None = None) -> Report:
    """Compare models, Riemann solvers, limiters and orders on one scene and several grids: error against run time.

    Parameters
    ----------
    scene : the scene.
    models : instances, or classes that get the scene's g and gamma. Default: TwoPhase, Reduced, ShallowWater.
    riemann : solvers. Default: all that serve the first model, and their default for the others; if given, all pairs.
    cells : numbers of cells, with two axes along x. Default: 100, 200, 400, 800, with two axes 25, 50, 100.
    limiter : one, or a list of them; default MC. (A tuple is one per wave family, as in `fvkit.WavePropagation`.)
    order : 1, 2, or a list of both.
    repeats : number of repeats of each run, interleaved, after a warm-up; the report has median and minimum.
    reference : default: the scene's own, else the full model on 4 times the finest grid (self-converged): TwoPhase, or
        where that is not among the models the first of them with two phases. Its detail estimates its own error.
    schemes : `fvkit.WavePropagation` and `fvkit.MethodOfLines` with all their settings, in place of ``riemann``,
        ``limiter``, ``order`` and ``cfl``; each is run with every model that it serves.
    cfl, backend : as for `fvkit.WavePropagation` and `fvkit.solve`.
    seconds : time limit per run, s. Runs expected to take longer, from coarser ones, are skipped,
        others are stopped: rows with the status ``"over_budget"``. A self-converged reference may take 16 times that, with two
        axes 64 times.
    progress : function that receives a line of text before each run.

    Returns
    -------
    fvkit.studies.Report
        Errors of the cell averages: those of the reference flow, in the variables of a model, against the computed ones. A
        failed run is a row with its status.

    Raises
    ------
    ValueError, TypeError
        For bad input, or a pair of model and solver that cannot work.
    KeyboardInterrupt
        After Ctrl-C; its attribute ``result`` is the Report of the runs that are done, None where there are none.

    Examples
    --------
    >>> import fvkit as fv
    >>> import fvkit_granular as gr
    >>> scene = gr.scene("riemann")
    >>> report = gr.compare(scene, [gr.ShallowWater], [fv.HLL()], cells=[20], repeats=1, backend="numpy")
    >>> [(row['model'], row['cells'], row['status']) for row in report.rows]
    [('shallow-water', 20, 'finished')]
    """
    scene = validation.instance(scene, "scene", Scene, "such as gr.scene('riemann')")
    for name, given, example in (("models", models, "[gr.TwoPhase]"), ("riemann", riemann, "[fv.HLL()]"),
                                 ("schemes", schemes, SCHEMES)):
        if given is not None:
            validation.listed(given, name, example)
    counts, repetitions, budget, tell = limits_of(CELLS[len(scene.axes)] if cells is None else cells, repeats, seconds, progress)
    kinds = [scene.model(model) for model in (models or (TwoPhase, Reduced, ShallowWater))]
    for kind in kinds:
        directions(kind, scene.grid(counts[0]))
    if schemes is not None and (riemann is not None or limiter is not None):
        raise ValueError("`schemes` name their own Riemann solver and limiter: leave `riemann` and `limiter` out")
    if schemes is None:
        runs = _runs(scene, kinds, riemann, counts, limiter, order, cfl)
    else:
        problems = [(public_name(kind), partial(_silently, scene, kind), _silently(scene, kind, counts[0])) for kind in kinds]
        runs = runs_of(problems, schemes, counts)
    known = scene.known_reference() if reference is None else reference
    if known is not None:
        validation.instance(known, "reference", Reference, "such as gr.FunctionReference('exact', 'a sentence', at=flow)")
    for kind in kinds:
        scene.problem(kind, counts[0])  # gives the warnings, which other grids would repeat
    full = scene.model(TwoPhase) if known is not None else _full_model(scene, kinds)
    problem_of = partial(_silently, scene, full)
    if known is None:
        high = any(run.scheme.time_integrator is not None for run in runs)
        found = fine_grid_reference(problem_of, fine_scheme(full, high), counts, backend, budget, tell)
        known = SelfConverged(found.kind, found.detail, solution=found.solution)
    comparison = Comparison(scene.name or "unnamed", public_name(full), partial(problem_of, max(counts)), known, deviations,
                            lambda: {"path_sensitivity": known.path_sensitivity()})
    return comparison.measure(runs, repetitions, backend, budget, tell)


def _silently(scene: Scene, model: Model, cells: Any) -> Problem:
    """Return the problem of a model, without warnings."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        return scene.problem(model, cells)


def _runs(scene: Scene, models: list[Model], riemann: Sequence[RiemannSolver] | None, cells: tuple[int, ...], limiter: Any,
          order: Any, cfl: float) -> list[PlannedRun]:
    if isinstance(limiter, list) and not limiter:
        raise TypeError("`limiter` must be a limiter or a list of them, not empty, got []")
    limiters = limiter if isinstance(limiter, list) else [MC() if limiter is None else limiter]
    orders = order if isinstance(order, (list, tuple)) else [order]
    result = []
    for model in models:
        problem_of = partial(_silently, scene, model)
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
                    result += [PlannedRun(public_name(model), problem_of, scheme, count) for count in cells]
    return result


def deviations(solution: Solution, averages: np.ndarray) -> dict[str, np.ndarray]:
    """Return abs(computed - reference) of each observable at the end of a run, {name: array of cells}.

    ``averages`` of the reference have the shape of a state of the run's model. Where the reference or the run is almost dry only
    depths are compared; other differences are 0.
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
