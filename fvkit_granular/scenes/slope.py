"""How steep the ground is, and what that costs: gravity of the mild-slope equations on a slope.

All models drive a layer by g b_x along x, depth measured upwards. Along a slope of angle theta a body is driven by
g sin(theta), which is g sin(theta) cos(theta) = g b_x/(1 + b_x^2) along x: the equations are too strong by the factor
1 + b_x^2, 7 % at 15 degrees, 33 % at 30, 3 times at 54.7.
"""

import warnings
from collections.abc import Mapping
from typing import Any

import numpy as np

from fvkit import Problem
from fvkit.problem.fields import on_grid
from fvkit.problem.model import aux_rows
from fvkit.problem.slopes import resolved_steps

#: Angle, degrees, above which a scene warns, and the share of the largest depth below which a cell is dry here.
MILD, DRY = 15.0, 1e-3

#: Times at which ends and sources that change are asked for what they bring.
INSTANTS = 17


class SteepSlopeWarning(UserWarning):
    """The ground is steeper than the mild-slope equations are made for."""


def steepest(b: Any, dx: float, wet: Any) -> float:
    """Return the largest slope |b_x| of the bottom over two wet cells, three faces; a wall or cliff, even inside a cell, is none.

    Parameters
    ----------
    b : (n,) cell averages of the bottom, m.
    dx : length of a cell, m.
    wet : (n,) which cells count.
    """
    steps, inner = np.abs(resolved_steps(np.asarray(b, dtype=float))), np.asarray(wet)[1:-1]
    return float(np.minimum(steps[:-1], steps[1:])[inner[:-1] & inner[1:]].max(initial=0.0)) / dx


def deep(h: np.ndarray) -> np.ndarray:
    """Return where a flow, (n,) or (outputs, n), is deeper than `DRY` of its largest depth."""
    return h > DRY * h.max(initial=0.0)


def within_reach(problem: Problem, g: float) -> float:
    """Return the steepest slope that a flow may reach: on ground below its highest total head h + b + v^2/(2g) at the start, that
    of flow which comes in at an end, or the highest ground on which a source brings mass; 0 without a bottom or a depth.

    Parameters
    ----------
    problem : the problem; conditions and sources that change are asked at `INSTANTS` times, and where they have breaks.
    g : gravity, m/s^2.
    """
    aux = problem.aux_averages
    if "b" not in aux or "h" not in problem.model.observables(problem.q0, aux):
        return 0.0
    changing = not all([side.steady for side in problem.ends] + [field.steady for field in problem.fields])
    times = {problem.t_start, *np.linspace(problem.t_start, problem.t_end, INSTANTS if changing else 1),
             *(t for side in problem.ends for t in side.breaks())}
    levels = [_head(problem, problem.q0, aux, g)]
    for t in times:
        levels += [_entering(problem, left, t, g) for left in (True, False)] + [_fed(problem, t)]
    return steepest(aux["b"], problem.grid.dx, aux["b"] <= np.fmax.reduce(levels))


def _head(problem: Problem, q: np.ndarray, aux: Mapping[str, np.ndarray], g: float) -> float:
    """The highest total head of states q (num_eqn, n), m, with the speed of the faster phase."""
    seen = problem.model.observables(q, aux)
    speed = np.max(np.abs([seen[name] for name in ("v", "vs", "vf") if name in seen]), axis=0, initial=0.0)
    return float((seen["h"] + aux["b"] + speed * speed / (2.0 * g))[deep(seen["h"])].max(initial=-np.inf))


def _entering(problem: Problem, left: bool, t: float, g: float) -> float:
    """The total head beyond an end at time t, m; none where the end is closed or repeats the flow inside."""
    side, model, cell = problem.ends[0 if left else 1], problem.model, slice(0, 1) if left else slice(-1, None)
    if side.closed or not side.defines("values"):
        return -np.inf
    ghost = side.ghost(model, tuple(problem.q0[:, cell]), side.layer(side.values(model, t), 1))
    near = np.array([problem.aux_averages[name][cell] for name in model.aux])
    beyond = side.ghost_aux(model, near, np.array([problem.grid.dx]))
    return _head(problem, np.array([np.broadcast_to(row, (1,)) for row in ghost]), dict(zip(model.aux, beyond, strict=True)), g)


def _fed(problem: Problem, t: float) -> float:
    """The highest dry ground on which a source brings mass at time t, m."""
    model, aux = problem.model, problem.aux_averages
    dry = tuple(np.zeros_like(problem.q0))
    given = (*aux_rows(model, aux), *(row for field in problem.fields for row in field.at(t)))
    with np.errstate(all="ignore"):
        made = [source.step(model, dry, given, problem.t_end - problem.t_start)
                for source in on_grid(problem.sources, problem.fields, len(model.aux))]
    wet = [np.broadcast_to(state[row] > 0.0, aux["b"].shape) for state in made for row in model.mass_rows()]
    return float(aux["b"][np.any(wet, axis=0)].max(initial=-np.inf)) if wet else -np.inf


def sentence(slope: float) -> str:
    """Return what is to be said of a slope: its angle, and the error of the driving force."""
    return (f"steepest slope {np.degrees(np.arctan(slope)):.3g} degrees: there the driving force of the mild-slope equations is "
            f"too large by {float(f'{100.0 * slope * slope:.2g}'):.15g} %")


def is_steep(slope: float) -> bool:
    """Return whether a slope is above `MILD` degrees."""
    return bool(slope > np.tan(np.radians(MILD)))


def warn_of_steep_ground(problem: Problem, g: float) -> None:
    """Warn where the flow of a problem may reach ground above `MILD` degrees."""
    slope = within_reach(problem, g)
    if is_steep(slope):
        warnings.warn(f"{sentence(slope)}, by b_x^2; they are made for slopes up to {MILD:g} degrees, and here speed and runout "
                      "come out too large", SteepSlopeWarning, stacklevel=3)
