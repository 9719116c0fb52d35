"""Wave speeds of a state on its grid, and what is wrong with a state that a step has left."""

from typing import Any

import numpy as np

from fvkit.output.status import Status
from fvkit.pointwise import CHUNK
from fvkit.problem import answers
from fvkit.problem.directions import Direction
from fvkit.problem.model import aux_rows
from fvkit.problem.problem import Problem

#: Tolerance when checking that `wave_speeds` returns (smallest, largest).
SWAPPED = 1e-9

#: A status, the cell that has it, and the state with that cell.
Found = tuple[Status, int, np.ndarray]


def largest_speed(problem: Problem, model: Any, direction: Direction) -> float:
    """Return the largest wave speed of the initial state along an axis, m/s."""
    q0, speed = problem.q0.reshape(len(problem.q0), -1), 0.0
    aux = tuple(row.reshape(-1) for row in problem.given)
    with np.errstate(all="ignore"):
        for first in range(0, q0.shape[1], CHUNK):
            q = tuple([q0[row, first:first + CHUNK] for row in direction.rows])
            given = tuple([row[first:first + CHUNK] for row in aux])
            low, high = answers.wave_speeds(model, q, given)
            here = float(np.max(np.maximum(np.abs(low), np.abs(high))))
            if np.any(low - high > SWAPPED * here):
                cell = first + int(np.argmax(np.broadcast_to(low - high, q0[0, first:first + CHUNK].shape)))
                raise ValueError(f"`wave_speeds` of {model} must return the smallest and the largest speed, in this order: "
                                 f"the first is above the second in cell {cell} ({problem.grid.located(cell)})")
            if answers.looks_between(model):
                sides = [tuple([row[cut] for row in rows]) for rows in (q, given) for cut in (slice(-1), slice(1, None))]
                here = max(here, *(float(np.max(np.abs(bound), initial=0.0)) for bound in answers.face_speeds(model, *sides)))
            speed = max(speed, here)
    return speed


def speeds(problem: Problem, q: np.ndarray) -> np.ndarray:
    """Return the bounds of the wave speeds of a state along each axis, (2 or 4, cells)."""
    with np.errstate(all="ignore"):
        aux = aux_rows(problem.model, problem.aux_averages)
        bounds = [bound for one in problem.directions
                  for bound in answers.wave_speeds(one.model, tuple(q[list(one.rows)]), aux)]
    return np.array([np.broadcast_to(bound, q.shape[1:]).reshape(-1) for bound in bounds])


def wrong_speed(problem: Problem, q: np.ndarray) -> Found | None:
    """Return the first cell with NaN or infinite speeds; None without such a cell."""
    finite = np.isfinite(speeds(problem, q)).all(axis=0)
    return None if finite.all() else (Status.WRONG_SPEED, int(np.argmin(finite)), q)


def diagnosis(problem: Problem, q: np.ndarray, trial: np.ndarray) -> Found:
    """Return what is wrong with the state ``trial`` that a step from q has left."""
    wrong = wrong_speed(problem, q)
    if wrong is not None:
        return wrong
    values = trial.reshape(len(trial), -1)
    finite = np.isfinite(values).all(axis=0)
    if not finite.all():
        return Status.NON_FINITE, int(np.argmin(finite)), trial
    lowest = [(values[row].min(), int(np.argmin(values[row]))) for row in problem.mass_rows]
    if lowest and min(lowest)[0] < 0.0:
        return Status.NEGATIVE_DEPTH, min(lowest)[1], trial
    if problem.model.defines("admissible"):
        for one in problem.directions:
            allowed = np.broadcast_to(one.model.admissible(tuple(values[list(one.rows)])), values.shape[1:])
            if not allowed.all():
                return Status.INADMISSIBLE, int(np.argmin(allowed)), trial
    return Status.NON_FINITE, -1, trial
