"""What must hold after a run: an invariant, its value and its bound."""

from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from fvkit import Problem, Solution
from fvkit_granular.scenes.reference import Reference
from fvkit_granular.scenes.scene import Scene


class JudgedRun(NamedTuple):
    """A finished or failed run; ``nominal`` are the steps that it would have taken with the length of its first one."""

    scene: Scene
    problem: Problem
    order: int
    solution: Solution
    nominal: float


class Check(NamedTuple):
    """An invariant: it holds where ``value <= bound``; NaN never does."""

    name: str
    value: float
    bound: float

    @property
    def passed(self) -> bool:
        """Whether it holds."""
        return bool(self.value <= self.bound)


Judge = Callable[[JudgedRun], Check]

#: Depths below this share of the largest are left out where velocities are read.
READABLE = 1e-6


def finished(run: JudgedRun) -> Check:
    """The run reached its end."""
    return Check(f"finished ({run.solution.status.name.lower()})", 0.0 if run.solution.success else 1.0, 0.0)


def never_negative(run: JudgedRun) -> Check:
    """No mass is negative in any output, not even by rounding."""
    return Check("most negative mass", max(0.0, -float(run.solution.q[:, list(run.problem.model.mass_rows())].min())), 0.0)


def masses_kept(run: JudgedRun) -> Check:
    """Masses change by what passes the boundaries alone."""
    return Check("mass drift", max(abs(drift) for drift in run.solution.stats.mass_drift.values()), 1e-13)


def steps_within(factor: float) -> Judge:
    """The time step does not collapse."""
    return lambda run: Check("steps / nominal", run.solution.stats.steps / run.nominal, factor)


def close_to_reference(first: float, second: float) -> Judge:
    """Depth is close to the scene's reference, in the relative L1 norm; one bound per order of the scheme."""
    def judge(run: JudgedRun) -> Check:
        reference = reference_of(run.scene)
        model, solution = run.problem.model, run.solution
        wanted = model.observables(reference.averages(model, solution.grid, solution.t[-1]), solution.aux)["h"]
        error = float(np.abs(solution.observables()["h"] - wanted).sum() / wanted.sum())
        return Check("error of h", error, (first, second)[run.order - 1])

    return judge


def reference_of(scene: Scene) -> Reference:
    """Return the scene's reference; ValueError where it has none."""
    reference = scene.known_reference()
    if reference is None:
        raise ValueError(f"the scene {scene.name} has no reference: a check of its error is a mistake in the list of cases")
    return reference


def speeds(run: JudgedRun, i: int = -1) -> np.ndarray:
    """Speeds of all velocities of the model where there is enough depth to read one, (any,)."""
    seen = run.solution.observables(i)
    rows = [run.solution.q[i][row] for row in run.problem.model.mass_rows()]
    deep = np.min(rows, axis=0) > READABLE * max(float(row.max()) for row in rows)
    found = [np.abs(seen[name][deep]) for name in ("vs", "vf", "v") if name in seen]
    return np.concatenate([np.zeros(1), *found])


def no_faster_than(bound: float) -> Judge:
    """No velocity exceeds its physical bound, m/s."""
    return lambda run: Check("fastest velocity", float(speeds(run).max()), bound)


def at_rest(run: JudgedRun) -> Check:
    """Nothing moves, m/s."""
    return Check("velocity at rest", float(speeds(run).max()), 1e-13)


def level_kept(run: JudgedRun) -> Check:
    """Depths do not change, m."""
    return Check("change of depth", float(np.abs(depth(run, -1) - depth(run, 0)).max()), 2e-15)


def depth(run: JudgedRun, i: int) -> np.ndarray:
    """Depth at an output, (n,)."""
    return run.solution.observables(i)["h"]


def exactly_still(run: JudgedRun) -> Check:
    """Not a bit changes."""
    return Check("change of any value", float(np.abs(run.solution.q[-1] - run.solution.q[0]).max()), 0.0)


def solid_still(run: JudgedRun) -> Check:
    """The first phase does not move, m/s."""
    seen = run.solution.observables()
    return Check("velocity of the solid", float(np.abs(seen["vs" if "vs" in seen else "v"]).max()), 0.0)


def stopped(run: JudgedRun) -> Check:
    """Every velocity is 0 at the end, exactly."""
    return Check("velocity after the stop", float(speeds(run).max()), 0.0)


def slip_below(bound: float) -> Judge:
    """Phases move together, m/s; models with one velocity always do."""
    def judge(run: JudgedRun) -> Check:
        seen = run.solution.observables()
        return Check("largest slip", float(np.abs(seen["vs"] - seen["vf"]).max()) if "vs" in seen else 0.0, bound)

    return judge


def energy_not_above_start(run: JudgedRun) -> Check:
    """The energy hs vs^2/2 + gamma hf vf^2/2 + g (hs + gamma hf) h/2 is not above its start; flat bottom, two phases."""
    def energy(i: int) -> float:
        seen = run.solution.observables(i)
        solid, fluid = seen["phi"] * seen["h"], run.scene.gamma * (1.0 - seen["phi"]) * seen["h"]
        moving = 0.5 * solid * seen["vs"] ** 2 + 0.5 * fluid * seen["vf"] ** 2
        return float((moving + 0.5 * run.scene.g * (solid + fluid) * seen["h"]).sum())

    return Check("energy / start", max(energy(i) for i in range(1, len(run.solution.t))) / energy(0), 1.0 + 1e-12)
