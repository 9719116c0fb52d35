"""Which runs the suite makes, and making them."""

import os
import time
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import Future, ProcessPoolExecutor, as_completed
from itertools import product
from typing import Any

from fvkit import Limits, SolveError, Stepper, WavePropagation, solve
from fvkit.backends.compiled.numba_kernel import available
from fvkit.run.interruption import keeping, uninterrupted
from fvkit.studies.covering import covering
from fvkit.studies.report import environment
from fvkit.sweeps.workers import begin_worker, end_processes
from fvkit_granular.models.registry import MODELS
from fvkit_granular.models.registry import RIEMANN as SOLVERS
from fvkit_granular.scenes.toml.read import find_scene
from fvkit_granular.stress.cases import CASES, case_of
from fvkit_granular.stress.checks import Check, JudgedRun, finished, masses_kept, never_negative
from fvkit_granular.stress.known_limits import LIMITS
from fvkit_granular.stress.report import StressReport

#: A run is given up after this many times its nominal steps.
GIVE_UP = 100

#: Steps after which a run is given up if it has no nominal number of steps.
MOST_STEPS = 1_000_000

AXES = ("scene", "model", "riemann", "order", "backend")

Tell = Callable[[str], None]


def fits(choice: dict[str, Any]) -> bool:
    """Whether a combination makes sense: the scene is for the model, and the solver serves it."""
    models = case_of(choice["scene"]).models if "scene" in choice else tuple(MODELS)
    if choice.get("model", models[0]) not in models:
        return False
    return "riemann" not in choice or "model" not in choice or SOLVERS[choice["riemann"]].serves(MODELS[choice["model"]])


def choices(full: bool, scenes: Sequence[str], backends: Sequence[str]) -> list[dict[str, Any]]:
    """The runs: all that make sense, or so many that every pair of settings of two axes occurs."""
    settings = product(scenes, MODELS, SOLVERS, (1, 2), backends)
    every = [choice for items in settings if fits(choice := dict(zip(AXES, items, strict=True)))]
    return every if full else [dict(choice) for choice in covering(every)]


def stress(full: bool = False, scenes: Sequence[str] | None = None, *, backends: Sequence[str] | None = None,
           workers: int | None = None, progress: Tell | None = None) -> StressReport:
    """Run the hard scenes with models, solvers, orders and backends, and judge each run.

    Parameters
    ----------
    full : every combination; else so few that every pair of settings occurs.
    scenes : names of hard scenes, and scene files (.toml); all hard scenes by default.
    backends : ``"numba"`` and ``"numpy"``; default: those installed.
    workers : processes; default: one per processor.
    progress : function that receives a line of text after each run.

    Returns
    -------
    StressReport
        ``.success`` where only runs with a known limit failed.

    Raises
    ------
    KeyboardInterrupt
        After Ctrl-C; its attribute ``result`` is the StressReport of the runs that are done, None where there are none.
    """
    chosen = backends or (("numba", "numpy") if available() else ("numpy",))
    wanted = choices(full, scenes or tuple(CASES), chosen)
    started = time.perf_counter()
    rows: list[dict[str, Any]] = []

    def report() -> StressReport:
        ordered = sorted(rows, key=lambda row: wanted.index({key: row[key] for key in AXES}))
        return StressReport(ordered, *environment("fvkit", "numpy", "numba"), time.perf_counter() - started)

    with keeping(lambda: report() if rows else None):
        for row in in_processes(run_case, wanted, workers, progress or (lambda line: None)):
            rows.append(row)
    return report()


def in_processes(work: Callable[..., dict[str, Any]], wanted: Sequence[dict[str, Any]], workers: int | None,
                 tell: Tell) -> Iterator[dict[str, Any]]:
    """Yield the results of ``work(**item)``, in the order in which they end."""
    count, complete = workers or os.cpu_count() or 1, False
    pool = ProcessPoolExecutor(min(count, max(len(wanted), 1)), initializer=begin_worker)
    try:
        pending: list[Future[dict[str, Any]]] = [pool.submit(work, **item) for item in wanted]
        for done, future in enumerate(as_completed(pending), start=1):
            row = future.result()
            tell(f"{done}/{len(wanted)} {row.get('verdict', '')} " + " ".join(str(row[key]) for key in AXES if key in row))
            yield row
        complete = True
    finally:
        end_processes(pool, at_once=not complete)


def run_case(scene: str, model: str, riemann: str, order: int, backend: str) -> dict[str, Any]:
    """Make one run and judge it."""
    choice = {"scene": scene, "model": model, "riemann": riemann, "order": order, "backend": backend}
    run = make_run(choice)
    further = case_of(scene).every_judge() if run.solution.success else ()
    checks = [judge(run) for judge in (finished, never_negative, masses_kept, *further)]
    stats = run.solution.stats
    return {**choice, "cells": case_of(scene).cells, "status": run.solution.status.name.lower(), "steps": stats.steps,
            "nominal": run.nominal, "seconds": stats.seconds, "nonhyperbolic_faces": stats.nonhyperbolic_faces,
            "checks": [{**check._asdict(), "passed": check.passed} for check in checks], "verdict": verdict(choice, checks)}


def make_run(choice: dict[str, Any]) -> JudgedRun:
    """Solve the scene of a combination."""
    chosen, case = find_scene(choice["scene"]), case_of(choice["scene"])
    problem = chosen.problem(MODELS[choice["model"]], case.cells)
    scheme = WavePropagation(SOLVERS[choice["riemann"]](), order=choice["order"])
    stepper = Stepper(problem, scheme, choice["backend"], nonhyperbolic="ignore")
    try:
        first = stepper.step()
    except SolveError:
        first = problem.t_end - problem.t_start  # `solve` below fails alike, and says how
    nominal = (problem.t_end - problem.t_start) / first
    solution = uninterrupted(solve(problem, scheme, backend=choice["backend"], throw=False, nonhyperbolic="ignore",
                                   limits=Limits(steps=MOST_STEPS if case.steps is None else int(GIVE_UP * nominal) + 100)))
    return JudgedRun(chosen, problem, choice["order"], solution, nominal)


def verdict(choice: dict[str, Any], checks: Sequence[Check]) -> str:
    """Return "pass", "expected" (fails as known), "FAIL", or "BETTER" (a known failure that passes)."""
    known = [limit for limit in LIMITS if limit.matches(choice)]
    for check in checks:
        if not check.passed and not any(check.name.startswith(limit.check) for limit in known):
            return "FAIL"
    if any(not any(check.name.startswith(limit.check) and not check.passed for check in checks) for limit in known):
        return "BETTER"
    return "expected" if known else "pass"
