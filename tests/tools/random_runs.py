"""Random scenes with every model, solver and order, in bulk: each ends, with a name for how, and loses nothing."""

import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import ExitStack, contextmanager
from math import fsum
from typing import Any
from unittest.mock import patch

import attrs
import numpy as np

from fvkit import MethodOfLines, Model, Problem, Scheme, SolveError, Status, Stepper, WavePropagation
from fvkit.backends.compiled import numba_kernel, numba_sweeps
from fvkit.backends.compiled.numba_kernel import available
from fvkit.pointwise.part import unwrapped
from fvkit.run.interruption import keeping
from fvkit.run.progress import Progress, counter
from fvkit.studies.report import environment
from fvkit_granular.stress.checks import Check
from fvkit_granular.stress.suite import MODELS, SOLVERS, in_processes
from tests.tools.random_draws import FAMILIES, PLANE, SETTINGS, RandomScene, family_of, random_scene, setting_of
from tests.tools.random_limits import FEW, known_collapses
from tests.tools.random_report import RandomReport

#: Steps that a run would take with the length of its first one.
NOMINAL = 60

#: The order that stands for the method of lines.
HIGH = 5

#: A run collapsed where it needs this many times its nominal steps; it is then given up.
COLLAPSE = 20

#: A run is looked at after so many steps: its state is judged, what passed its ends, and its wall time.
LOOK = 8

#: Wall time after which a run is given up, s: thousands of times what one takes.
SECONDS = 20.0

#: Runs that one process makes in one go.
BLOCK = 1000

#: Masses below this lose digits in products: their drift is judged as if they were as large, m^2.
LEAST_MASS = 1e-290

EPS = float(np.finfo(float).eps)

#: A cell's mass is rounded three times in a sweep, at random: eps/2 of it, were all of the mass in that one cell. After n sweeps
#: the sum of such errors exceeds 8 of its standard deviations, eps sqrt(n)/2, by nothing but a mistake.
ROUNDING = 4.0 * EPS

#: What passed an end is added up step by step. A steady flow is rounded alike in every step: eps/2 of the sum, times the steps.
ADDING = 0.5 * EPS

#: Seconds for a problem, by order, and for a kernel that is not in the cache, on one core; for what `plan` says alone.
TYPICAL, COMPILING, UNCOMPILED = {1: 0.8e-3, 2: 1.2e-3, HIGH: 6e-3}, 3.0, 60.0

#: Seconds for a problem on a plane, of either order.
TYPICAL_PLANE = 0.06

#: Names of how a run may end. What is neither is broken.
ENDED, COLLAPSED = ("finished",), ("max_steps", "dt_too_small")


def scheme_of(riemann: str, order: int) -> Scheme:
    """Return the scheme of a solver's name and an order."""
    solver = SOLVERS[riemann]()
    return MethodOfLines(solver) if order == HIGH else WavePropagation(solver, order=order)


def run_random(model: str, riemann: str, order: int, seed: int, index: int, count: int,
               setting: str | None = None) -> dict[str, Any]:
    """Run the problems from ``index`` to ``index + count``, of one setting or of all; return what a report adds up."""
    scheme, kind = scheme_of(riemann, order), MODELS[model]
    settings = FAMILIES[family_of(setting)]
    wanted = [k for k in range(index, index + count) if setting in (None, setting_of(k, settings))]
    started = time.perf_counter()
    scenes = (random_scene(seed, k, settings) for k in wanted)
    if order == HIGH:  # the method of lines has no static friction, and refuses it
        scenes = (attrs.evolve(scene, nu=None) for scene in scenes)
    with code_kept():
        outcomes = [_run(kind, scheme, scene) | {"index": k} for k, scene in zip(wanted, scenes, strict=True)]
    return {"model": model, "riemann": riemann, "order": order, "problems": len(outcomes),
            "seconds": time.perf_counter() - started, "ratios": np.array([one["ratio"] for one in outcomes]),
            "drifts": np.array([one["drift"] for one in outcomes]), "shares": np.array([one["share"] for one in outcomes]),
            "lowest": min((one["lowest"] for one in outcomes), default=0.0), "lost": sum(one["lost"] for one in outcomes),
            "odd": [one for one in outcomes if one["status"] not in ENDED or one["share"] > 1.0 or not one["lowest"] >= 0.0]}


@contextmanager
def code_kept() -> Iterator[None]:
    """Let problems of one scheme and the same kinds of parts share the code of the first and the check of their parts.

    Both take ten times a run.
    """
    def kinds(parts: Sequence[Any]) -> tuple[type, ...]:
        return tuple(type(unwrapped(part)) for part in parts)

    def kept(make: Callable[..., Any], key: Callable[..., Any]) -> Callable[..., Any]:
        found: dict[Any, Any] = {}

        def once(*given: Any) -> Any:
            what = key(*given)
            if what not in found:
                found[what] = make(*given)
            return found[what]

        return once

    def ends_of(problem: Problem) -> tuple[type, ...]:
        return kinds([*problem.ends, *(section.first for axis in problem.sides for side in axis for section in side)])

    with ExitStack() as stack:  # last of the arguments of both generators: which given functions are 0 everywhere
        for owner, name, key in (
                (numba_kernel, "generate", lambda problem, scheme, parts, *rest: (kinds(parts.every), ends_of(problem), *rest[-1])),
                (numba_sweeps, "generate_sweep", lambda direction, scheme, parts, *rest: (
                    direction.number, kinds(parts.every), parts.model.aux, *rest[-1])),
                (numba_sweeps, "module_of", lambda prefix, text, *rest: (prefix, text)),
                (Problem, "_check_contract", lambda problem: (
                    kinds([problem.model, *problem.sources]), ends_of(problem), len(problem.given)))):
            stack.enter_context(patch.object(owner, name, kept(getattr(owner, name), key)))
        yield


def _run(kind: type[Model], scheme: Scheme, scene: RandomScene) -> dict[str, Any]:
    named = {"class": scene.kind, "setting": scene.setting, "bottom": scene.bottom}
    empty = {"ratio": 0.0, "lowest": 0.0, "drift": 0.0, "share": 0.0, "lost": 0}
    try:
        stepper = Stepper(scene.problem(kind), scheme, nonhyperbolic="ignore")
        looks = Looks(stepper)
        status = _march(stepper, looks)
    except Exception as error:
        return named | empty | {"status": f"crashed: {type(error).__name__}: {error}"}
    drift, share = _drift(stepper, len(scheme.program.sweeps), looks.passed)
    return named | {"status": status, "ratio": stepper.steps / NOMINAL, "lowest": looks.lowest, "drift": drift, "share": share,
                    "lost": stepper.stats().nonhyperbolic_faces}


class Looks:
    """What was seen of a run: its lowest mass, -inf where a number was none, and the most of each mass that had passed each end."""

    def __init__(self, stepper: Stepper) -> None:
        self.stepper, self.lowest, self.passed = stepper, np.inf, np.zeros_like(passed_ends(stepper))
        self.look()

    def look(self) -> None:
        q, rows = self.stepper.q, list(self.stepper.problem.mass_rows)
        self.lowest = min(self.lowest, float(q[rows].min()) if np.isfinite(q).all() else -np.inf)
        self.passed = np.maximum(self.passed, np.abs(passed_ends(self.stepper)))


def passed_ends(stepper: Stepper) -> np.ndarray:
    """Return what has passed each end of each axis so far, along the axis, (ends, masses)."""
    return np.asarray(stepper.snapshot()["masses"][:2 * len(stepper.problem.grid.axes)])


def _march(stepper: Stepper, looks: Looks) -> str:
    """Run to the end of a scene; return how it ended."""
    started = time.perf_counter()
    try:
        first = stepper.step()
        looks.look()
        target = min(NOMINAL * first, stepper.problem.t_end)
        while stepper.t < target:
            if stepper.steps >= COLLAPSE * NOMINAL:
                return Status.MAX_STEPS.name.lower()
            if time.perf_counter() - started > SECONDS:
                return Status.OVER_BUDGET.name.lower()
            stepper.run(target, min(LOOK, COLLAPSE * NOMINAL - stepper.steps))
            looks.look()
    except SolveError as error:
        looks.look()
        return error.status.name.lower()
    return Status.FINISHED.name.lower()


def _drift(stepper: Stepper, sweeps: int, most: np.ndarray) -> tuple[float, float]:
    """Return the largest change of a mass that its boundary fluxes do not explain, and its share of what rounding may do.

    Relative to the mass at the start and the ``most`` that had passed the ends: what came in may have left by the same end since.
    """
    problem, drift, share = stepper.problem, 0.0, 0.0
    axes, volume = len(problem.grid.axes), problem.grid.cell_volume
    for row, passed, through in zip(problem.mass_rows, passed_ends(stepper).T, most.sum(axis=0), strict=False):
        start, end = (fsum(q[row].flat) * volume for q in (problem.q0, stepper.q))
        size, change = max(start + through, LEAST_MASS), abs(end - start - (passed[::2] - passed[1::2]).sum())
        allowed = ROUNDING * np.sqrt(max(stepper.steps, 1) * sweeps * axes) * size + ADDING * stepper.steps * through
        drift, share = max(drift, change / size), max(share, change / allowed)
    return drift, share


def pairs(models: Sequence[str] | None = None, riemann: Sequence[str] | None = None,
          settings: Mapping[str, str] = SETTINGS) -> list[tuple[str, str]]:
    """Return the pairs of a model and a solver that serves it, of the names given, all where None; for a plane of what serves one.

    Raises
    ------
    ValueError
        Where no solver given serves a model given.
    """
    known = [model for model in models or MODELS if settings is not PLANE or MODELS[model].dimensions > 1]
    found = [(model, solver) for model in known for solver in riemann or SOLVERS if SOLVERS[solver].serves(MODELS[model])]
    if not known:
        raise ValueError(f"`models` on a plane must be of what serves two axes, got {', '.join(models or ())}")
    if not found:
        fitting = ", ".join(name for name, solver in SOLVERS.items() if any(solver.serves(MODELS[m]) for m in known))
        raise ValueError(f"`riemann` must serve a model: {', '.join(riemann or ())} does not serve {', '.join(models or ())}; "
                         f"solvers that do: {fitting}")
    return found


def plan(count: int, chosen: Sequence[tuple[str, str]], orders: Sequence[int], workers: int,
         settings: Mapping[str, str] = SETTINGS) -> str:
    """Return what will be run, and about how long it takes."""
    slower, axes = "" if available() else ", without numba", 2 if settings is PLANE else 1
    kernels = axes * len(chosen) * len(orders) * min(len(settings), -(-count // 8))
    seconds = len(chosen) * count * (sum(TYPICAL[order] for order in orders) if axes == 1 else len(orders) * TYPICAL_PLANE)
    running = seconds * (1.0 if available() else UNCOMPILED) / workers
    text = f"{count} random scenes x {len(chosen)} pairs of model and solver x order {', '.join(map(str, orders))}: "
    text += f"{count * len(chosen) * len(orders)} runs, about {_spoken(running)} on {workers} core{'s' * (workers > 1)}{slower}"
    return text + (f", plus {_spoken(COMPILING * kernels / workers)} to compile {kernels} kernels once" if available() else "")


def _spoken(seconds: float) -> str:
    if seconds < 90.0:
        return f"{seconds:.0f} s"
    return f"{seconds / 60.0:.0f} min" if seconds < 5400.0 else f"{seconds / 3600.0:.1f} h"


def random_stress(count: int, seed: int = 1, models: Sequence[str] | None = None, riemann: Sequence[str] | None = None,
                  orders: Sequence[int] = (1, 2), *, first: int = 0, workers: int | None = None,
                  settings: Mapping[str, str] = SETTINGS, progress: Progress = False) -> RandomReport:
    """Run random scenes with models, solvers and orders, and judge every run.

    Parameters
    ----------
    count : scenes for each model, solver and order: classes, settings and bottoms in turn, see `random_draws`.
    seed : the same seed gives the same scenes.
    models, riemann : names; all by default. Pairs that do not fit are left out.
    orders : any of 1, 2 and 5, which is `fvkit.MethodOfLines` as it comes.
    first : index of the first scene of the seed.
    workers : processes; default: one per processor.
    settings : `random_draws.SETTINGS`, `random_draws.INFLOWS`, or `random_draws.PLANE`.
    progress : True shows progress on stderr; or a function that receives the share done, 0 to 1.

    Returns
    -------
    RandomReport
        ``.success`` where every run ended with a name, lost nothing, and no more collapsed than `random_limits.COLLAPSES` knows.

    Raises
    ------
    KeyboardInterrupt
        After Ctrl-C; its attribute ``result`` is the RandomReport of the runs that are done, None where there are none.
    """
    chosen = pairs(models, riemann, settings)
    size = min(BLOCK, count)
    # The first blocks of all kernels come first, so that no two processes compile the same one.
    wanted = [{"model": model, "riemann": solver, "order": order, "seed": seed, "index": start, "setting": setting,
               "count": min(size * len(settings), first + count - start)}
              for start in range(first, first + count, size * len(settings))
              for model, solver in chosen for order in orders for setting in settings]
    found: dict[tuple[str, str, int], list[dict[str, Any]]] = {(*pair, order): [] for pair in chosen for order in orders}
    started, done = time.perf_counter(), 0

    def report() -> RandomReport:
        return RandomReport([_row(key, parts) for key, parts in found.items() if parts], seed, first, count,
                            *environment("fvkit", "numpy", "numba"), time.perf_counter() - started)

    with keeping(lambda: report() if done else None), counter(progress, count * len(found), "run") as show:
        for part in in_processes(run_random, wanted, workers, lambda line: None):
            found[part["model"], part["riemann"], part["order"]].append(part)
            done += part["problems"]
            show(done)
    return report()


def _row(key: tuple[str, str, int], parts: list[dict[str, Any]]) -> dict[str, Any]:
    """Add up the runs of a model, a solver and an order."""
    ratios, drifts, shares = (np.concatenate([part[name] for part in parts]) for name in ("ratios", "drifts", "shares"))
    odd = sorted((one for part in parts for one in part["odd"]), key=lambda one: one["index"])
    collapsed = [one for one in odd if one["status"] in COLLAPSED]
    broken = [one for one in odd if one["status"] not in (*ENDED, *COLLAPSED)]
    p50, p99, p999 = (float(value) for value in np.quantile(ratios, [0.5, 0.99, 0.999]))
    checks = [Check("broken or unnamed ends", len(broken), 0),
              Check("most negative mass", max(0.0, -min(part["lowest"] for part in parts)), 0.0),
              Check("mass drift / rounding", float(shares.max()), 1.0)]
    if len(ratios) >= FEW:
        known = known_collapses(*key[:2])
        checks += [Check("steps / nominal, 99 %", p99, known.steps),
                   Check("collapses, share", len(collapsed) / len(ratios), known.share)]
    return {"model": key[0], "riemann": key[1], "order": key[2], "problems": len(ratios),
            "finished": len(ratios) - len(collapsed) - len(broken), "collapses": len(collapsed), "broken": len(broken),
            "p50": p50, "p99": p99, "p99.9": p999, "max": float(ratios.max()), "drift": float(drifts.max()),
            "drift/rounding": float(shares.max()), "nonhyperbolic_faces": sum(part["lost"] for part in parts),
            "seconds": sum(part["seconds"] for part in parts), "odd": odd,
            "checks": [{**check._asdict(), "passed": check.passed} for check in checks]}
