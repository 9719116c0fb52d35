"""Random Riemann problems in a closed box, with steps of the bottom: classes from mild to absurd."""

from collections.abc import Callable, Sequence
from typing import Any, NamedTuple

import numpy as np

from fvkit import Grid, MethodOfLines, Model, Problem, Scheme, SolveError, Status, Stepper, Wall, WavePropagation
from fvkit_granular.stress.checks import Check
from fvkit_granular.stress.suite import MODELS, SOLVERS, in_processes

#: Cells of the box, and steps that a run would take with the length of its first one.
CELLS, NOMINAL = 60, 60

#: The order that stands for the method of lines.
HIGH = 5

#: No run takes longer, s: where nothing is deep enough to move, the first step is as long as it can be.
LONGEST = 100.0

#: A run collapsed where it needs this many times its nominal steps; it is then given up.
COLLAPSE = 20

#: The classes, drawn in turn. Depths in metres; half of all problems have a bottom step of up to 2 m.
CLASSES = {
    "generic": "depths 0.01 to 5, velocities up to 3 m/s", "thin": "depths down to 1e-12", "vanishing": "depths down to 1e-300",
    "one phase": "solid fraction 0, 1, 1e-12 or 1 - 1e-12", "fast": "Froude numbers up to 50",
    "slipping": "slip in and around the range of complex speeds", "dry side": "a side, or one of its phases, absent",
    "one velocity": "both phases move together",
}


class Draw(NamedTuple):
    """A Riemann problem: depth, solid fraction and velocities of both sides, and the height of the right bottom."""

    h: np.ndarray
    phi: np.ndarray
    vs: np.ndarray
    vf: np.ndarray
    step: float


def draw(seed: int, index: int, g: float = 9.81, gamma: float = 0.5) -> tuple[str, Draw]:
    """Return the class and the data of a problem; the same for the same seed and index."""
    rng = np.random.default_rng([seed, index])
    kind = list(CLASSES)[index % len(CLASSES)]
    h, phi, (vs, vf) = rng.uniform(0.01, 5.0, 2), rng.uniform(0.0, 1.0, 2), rng.uniform(-3.0, 3.0, (2, 2))
    if kind in ("thin", "vanishing"):
        h = 10.0 ** rng.uniform(-12.0 if kind == "thin" else -300.0, np.log10(5.0), 2)
    elif kind == "one phase":
        phi = rng.choice([0.0, 1.0, 1e-12, 1.0 - 1e-12], 2)
    elif kind == "fast":
        vs = rng.uniform(-50.0, 50.0, 2) * np.sqrt(g * h)
        vf = vs + rng.uniform(-0.5, 0.5, 2)
    elif kind == "slipping":
        beta = np.sqrt(0.5 * (1.0 - phi) * (1.0 - gamma))
        vs = vf + rng.choice([-1.0, 1.0], 2) * np.sqrt(g * h) * rng.uniform(1.6 * beta, 2.2)
    elif kind == "dry side":
        side = rng.integers(0, 2)
        what = rng.integers(0, 3)
        h[side], phi[side] = (0.0, 0.5) if what == 0 else (h[side], float(what - 1))
    elif kind == "one velocity":
        vf = vs.copy()
    return kind, Draw(h, phi, vs, vf, rng.uniform(-2.0, 2.0) if rng.random() < 0.5 else 0.0)


def run_random(model: str, riemann: str, order: int, seed: int, index: int, count: int) -> dict[str, Any]:
    """Run ``count`` problems from ``index`` on; return what a report adds up."""
    solver = SOLVERS[riemann]()
    scheme = MethodOfLines(solver) if order == HIGH else WavePropagation(solver, order=order)
    outcomes = [_run(MODELS[model](), scheme, seed, k) for k in range(index, index + count)]
    return {"model": model, "riemann": riemann, "order": order, "index": index, "outcomes": outcomes}


def _run(model: Model, scheme: Scheme, seed: int, index: int) -> dict[str, Any]:
    kind, drawn = draw(seed, index)
    side = (np.arange(CELLS) >= CELLS // 2).astype(int)
    q = model.conserved_from(*(values[side] for values in drawn[:4]))  # type: ignore[attr-defined]
    problem = Problem(model, Grid(0.0, 1.0, CELLS), q, LONGEST, aux={"b": drawn.step * side}, boundary=Wall())
    stepper = Stepper(problem, scheme, nonhyperbolic="ignore")
    status = Status.FINISHED
    try:
        first = stepper.step()
        target = min(NOMINAL * first, LONGEST)
        if stepper.t < target:
            stepper.run(target, COLLAPSE * NOMINAL)
        status = Status.FINISHED if stepper.t >= target else Status.MAX_STEPS
    except SolveError as error:
        status = error.status
    rows = list(problem.model.mass_rows())
    total = problem.q0[rows].sum() or 1.0
    return {"index": index, "class": kind, "status": status.name.lower(), "ratio": stepper.steps / NOMINAL,
            "lowest": float(stepper.q[rows].min()), "drift": float(np.abs(stepper.q[rows].sum(axis=1)
                                                                          - problem.q0[rows].sum(axis=1)).max() / total)}


def random_stress(count: int, seed: int = 1, models: Sequence[str] = ("two-phase",), riemann: Sequence[str] = ("relaxation",),
                  orders: Sequence[int] = (1, 2), *, workers: int | None = None,
                  progress: Callable[[str], None] | None = None) -> list[dict[str, Any]]:
    """Run random problems; return one row for each model, solver and order.

    Parameters
    ----------
    count : problems, drawn from the `CLASSES` in turn.
    seed : the same seed gives the same problems.
    models, riemann, orders : names and numbers; order 5 is `fvkit.MethodOfLines` as it comes.
    workers : processes; default: one per processor.
    progress : function that receives a line of text now and then.

    Returns
    -------
    list of dict
        Counts, quantiles of steps over nominal steps, worst mass drift, the problems that failed, and ``checks``.
    """
    size = max(1, min(250, count // 8))
    wanted = [{"model": model, "riemann": solver, "order": order, "seed": seed, "index": first, "count": min(size, count - first)}
              for model in models for solver in riemann for order in orders for first in range(0, count, size)]
    found: dict[tuple[str, str, int], list[dict[str, Any]]] = {}
    for part in in_processes(run_random, wanted, workers, progress or (lambda line: None)):
        found.setdefault((part["model"], part["riemann"], part["order"]), []).extend(part["outcomes"])
    return [_row(key, sorted(outcomes, key=lambda one: one["index"]), seed) for key, outcomes in sorted(found.items())]


def _row(key: tuple[str, str, int], outcomes: list[dict[str, Any]], seed: int) -> dict[str, Any]:
    ratios = np.array([one["ratio"] for one in outcomes])
    failed = [one for one in outcomes if one["status"] != "finished"]
    broken = [one for one in failed if one["status"] != "max_steps"]
    p50, p99, p999 = (float(value) for value in np.quantile(ratios, [0.5, 0.99, 0.999]))
    few = 5e-4 if SOLVERS[key[1]].positive else 2e-3
    checks = [Check("ended with NaN, negative or no step", len(broken), 0),
              Check("most negative mass", max(0.0, -min(one["lowest"] for one in outcomes)), 0.0),
              Check("steps / nominal, 99 %", p99, 4.0), Check("collapses, share", len(failed) / len(outcomes), few),
              Check("mass drift", max(one["drift"] for one in outcomes), 1e-14)]
    return {"model": key[0], "riemann": key[1], "order": key[2], "problems": len(outcomes), "seed": seed, "p50": p50, "p99": p99,
            "p99.9": p999, "max": float(ratios.max()), "collapses": len(failed) - len(broken), "failed": failed[:20],
            "checks": [{**check._asdict(), "passed": check.passed} for check in checks]}
