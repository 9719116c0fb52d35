"""How steep the ground is, and what that costs: gravity of the mild-slope equations on a slope.

All models drive a layer by g b_x along x, depth measured upwards. Along a slope of angle theta a body is driven by
g sin(theta), which is g sin(theta) cos(theta) = g b_x/(1 + b_x^2) along x: the equations are too strong by the factor
1 + b_x^2, 7 % at 15 degrees, 33 % at 30, 3 times at 54.7.
"""

import warnings
from typing import Any

import numpy as np

from fvkit import Problem
from fvkit.problem.slopes import resolved_steps

#: Angle, degrees, above which a scene warns, and the share of the largest depth below which a cell is dry here.
MILD, DRY = 15.0, 1e-3


class SteepSlopeWarning(UserWarning):
    """The ground is steeper than the mild-slope equations are made for."""


def steepest(b: Any, dx: float, wet: Any) -> float:
    """Return the largest resolved slope |b_x| of the bottom in wet cells; a wall or cliff, one face high, is none.

    Parameters
    ----------
    b : (n,) cell averages of the bottom, m.
    dx : length of a cell, m.
    wet : (n,) which cells count.
    """
    slopes = np.abs(resolved_steps(np.asarray(b, dtype=float))[np.asarray(wet)[1:-1]]) / dx
    return float(slopes.max(initial=0.0))


def deep(h: np.ndarray) -> np.ndarray:
    """Return where a flow, (n,) or (outputs, n), is deeper than `DRY` of its largest depth."""
    return h > DRY * h.max(initial=0.0)


def within_reach(b: np.ndarray, dx: float, h: np.ndarray, speed: np.ndarray, g: float, sides: tuple[Any, Any]) -> float:
    """Return the steepest resolved slope that a flow may reach: on ground below its highest total head h + b + v^2/(2g), or below
    an end where flow comes in.

    Parameters
    ----------
    b, h, speed : (n,) bottom and depth, m, and the speed of the faster phase, m/s, at the start.
    dx : their distance, m.
    g : gravity, m/s^2.
    sides : boundary conditions (left, right); one that gives values to its ghosts, and is no wall, lets flow in.
    """
    ends = [level for side, level in zip(sides, (b[0], b[-1]), strict=True)
            if not side.closed and side.defines("values")]
    head = (h + b + speed * speed / (2.0 * g))[deep(h)]
    return steepest(b, dx, b <= max([*head, *ends], default=-np.inf))


def sentence(slope: float) -> str:
    """Return what is to be said of a slope: its angle, and the error of the driving force."""
    return (f"steepest slope {np.degrees(np.arctan(slope)):.3g} degrees: there the driving force of the mild-slope equations is "
            f"too large by {float(f'{100.0 * slope * slope:.2g}'):.15g} %")


def is_steep(slope: float) -> bool:
    """Return whether a slope is above `MILD` degrees."""
    return bool(slope > np.tan(np.radians(MILD)))


def warn_of_steep_ground(problem: Problem, g: float) -> None:
    """Warn where the flow of a problem may reach ground above `MILD` degrees."""
    seen, b = problem.model.observables(problem.q0, problem.aux_averages), problem.aux_averages["b"]
    speed = np.max(np.abs([seen[name] for name in ("v", "vs", "vf") if name in seen]), axis=0, initial=0.0)
    slope = within_reach(b, problem.grid.dx, seen["h"], speed, g, problem.ends) if "h" in seen else 0.0
    if is_steep(slope):
        warnings.warn(f"{sentence(slope)}, by b_x^2; they are made for slopes up to {MILD:g} degrees, and here speed and runout "
                      "come out too large", SteepSlopeWarning, stacklevel=3)
