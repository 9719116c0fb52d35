"""Slope of the ground, and the error of gravity in the mild-slope equations on it.

All models drive a layer by g b_x along x, depth measured upwards. Along a slope of angle theta a body is driven by
g sin(theta), which is g sin(theta) cos(theta) = g b_x/(1 + b_x^2) along x: the equations are too strong by the factor
1 + b_x^2, 7 % at 15 degrees, 33 % at 30, 3 times at 54.7.
"""

import warnings
from collections.abc import Mapping
from typing import Any

import numpy as np

from fvkit import Problem, validation
from fvkit.problem.directions import observables
from fvkit.problem.fields import on_grid
from fvkit.problem.model import aux_rows
from fvkit.problem.side import Section
from fvkit.problem.slopes import resolved_steps

#: Angle, degrees, above which a scene warns, and the share of the largest depth below which a cell is dry here.
MILD, DRY = 15.0, 1e-3

#: Angle, degrees, above which a scene takes the equations for steep ground.
STEEP = 10.0

#: Observables whose size is a speed.
SPEEDS = ("v", "vs", "vf", "speed", "speed_s", "speed_f")

#: Number of times at which ends and sources that change in time are evaluated.
INSTANTS = 17


class SteepSlopeWarning(UserWarning):
    """Warning: the ground is steeper than the range of the mild-slope equations, 15 degrees.

    Examples
    --------
    Stop a script where it would go on with a warning:

    >>> import warnings
    >>> import fvkit as fv, fvkit_granular as gr
    >>> grid, wet = fv.Grid(0.0, 100.0, 50), lambda x: [0.6 + 0.0 * x, 0.0 * x, 0.4 + 0.0 * x, 0.0 * x]
    >>> warnings.simplefilter("error", gr.SteepSlopeWarning)
    >>> fv.Problem(gr.TwoPhase(), grid, wet, 1.0, {"b": lambda x: -0.5 * x})
    Traceback (most recent call last):
    fvkit_granular.models.slope.SteepSlopeWarning: steepest slope 26.6 degrees: ...
    """


def steepest(b: Any, dx: Any, wet: Any) -> float:
    """Return the largest slope |grad b| of the bottom over two wet cells, three faces; a cliff, even inside a cell, is none.

    ``b`` are averages, m, and ``wet`` of its shape; ``dx`` is the length of a cell, m, with two axes that along x and along y.
    """
    heights, counting = np.asarray(b, dtype=float), np.asarray(wet)
    along = [np.moveaxis(_along_lines(np.moveaxis(heights, k, -1), np.moveaxis(counting, k, -1)), -1, k) / width
             for k, width in zip((-1, -2), np.atleast_1d(dx), strict=False)]
    return float(np.hypot.reduce(along).max(initial=0.0))


def _along_lines(b: np.ndarray, wet: np.ndarray) -> np.ndarray:
    """The step of the bottom between cells along the last axis, for each cell, as `steepest` counts it."""
    steps, inner = np.abs(resolved_steps(b)), wet[..., 1:-1]
    faces = np.where(inner[..., :-1] & inner[..., 1:], np.minimum(steps[..., :-1], steps[..., 1:]), 0.0)
    result = np.zeros(b.shape)
    if faces.shape[-1]:
        for part in (result[..., 1:-2], result[..., 2:-1]):
            np.maximum(part, faces, out=part)
    return result


def deep(h: np.ndarray) -> np.ndarray:
    """Return where a flow, an array of depths, is deeper than `DRY` of its largest depth."""
    return h > DRY * h.max(initial=0.0)


def within_reach(problem: Problem, g: float) -> float:
    """Return the steepest slope that a flow may reach: on ground below its highest total head h + b + v^2/(2g) at the start, that
    of flow which comes in at an end, or b + v^2/(2g) where a source brings mass to dry ground; 0 without a bottom or a depth.

    Conditions and sources that change in time are evaluated at `INSTANTS` times and at their breaks.
    """
    aux, grid = problem.aux_averages, problem.grid
    seen = observables(problem.model, grid, problem.q0, aux)
    if "b" not in aux or "h" not in seen:
        return 0.0
    changing = not (problem.steady_boundary and all(field.steady for field in problem.fields))
    times = {problem.t_start, *np.linspace(problem.t_start, problem.t_end, INSTANTS if changing else 1), *problem.breaks}
    levels = [_head(seen, aux["b"], g)]
    for t in times:
        levels += [*_entering(problem, t, g), _fed(problem, t, g)]
    return steepest(aux["b"], [axis.dx for axis in grid.axes], aux["b"] <= np.fmax.reduce(levels))


def _head(seen: Mapping[str, np.ndarray], b: np.ndarray, g: float) -> float:
    """The highest total head of a flow, m, from its observables and its bottom, with the speed of the faster phase."""
    return float((seen["h"] + b + _speed_head(seen, g))[deep(seen["h"])].max(initial=-np.inf))


def _speed_head(seen: Mapping[str, np.ndarray], g: float) -> np.ndarray:
    """The speed head v^2/(2g) of the faster phase, m, from observables."""
    speed = np.max(np.abs([seen[name] for name in SPEEDS if name in seen]), axis=0, initial=0.0)
    return np.asarray(speed * speed / (2.0 * g))


def _entering(problem: Problem, t: float, g: float) -> list[float]:
    """The total head beyond each section of each side at time t, m, of flow across it; none where it is closed or repeats the
    flow inside."""
    ends = tuple((Section(slice(0, 1), (end,)),) for end in problem.ends)
    result = []
    for direction, sides in zip(problem.directions, problem.sides or (ends,), strict=True):
        model, dx = direction.model, np.array([problem.grid.axes[direction.number].dx])
        q, ground = (np.moveaxis(rows, -1 - direction.number, 1) for rows in (
            problem.q0[list(direction.rows)], np.array([problem.aux_averages[name] for name in model.aux])))
        for cell, side in zip((0, -1), sides, strict=True):
            for section in side:
                end, lanes = section.first, section.lanes
                if end.closed or not end.defines("values"):
                    continue
                near, below = (rows[:, cell].reshape(len(rows), -1)[:, lanes] for rows in (q, ground))
                ghost = np.array([np.broadcast_to(row, near.shape[1:]) for row in end.ghost(
                    model, tuple(near), end.layer(section.values(model, t), 1))])
                beyond = np.concatenate([np.asarray(one.ghost_aux(model, below[:, k:k + 1], dx))
                                         for k, one in enumerate(section.ends)], axis=1)
                seen = model.observables(ghost, dict(zip(model.aux, beyond, strict=True)))
                result.append(_head(seen, beyond[model.aux.index("b")], g))
    return result


def _fed(problem: Problem, t: float, g: float) -> float:
    """The highest total head at which a source brings mass to dry ground at time t, m: without the depth, which it spreads."""
    model, aux = problem.model, problem.aux_averages
    given = (*aux_rows(model, aux), *(row for field in problem.fields for row in field.at(t)))
    heads = [-np.inf]
    for source in on_grid(problem.sources, problem.fields, len(model.aux)):
        rows, masses = (len(model.conserved), model.mass_rows()) if source.turns else (len(problem.q0), problem.mass_rows)
        dry = tuple(np.zeros((rows, *problem.grid.shape)))
        with np.errstate(all="ignore"):
            made = np.array([np.broadcast_to(row, aux["b"].shape)
                             for row in source.step(model, dry, given, problem.t_end - problem.t_start)])
            moving = 0.0 if source.turns else _speed_head(observables(model, problem.grid, made, aux), g)
        heads.append((aux["b"] + moving)[(made[list(masses)] > 0.0).any(axis=0)].max(initial=-np.inf))
    return float(max(heads))


def sentence(slope: float) -> str:
    """Return the sentence about a slope: its angle, and the error of the driving force."""
    return (f"steepest slope {np.degrees(np.arctan(slope)):.3g} degrees: there the driving force of the mild-slope equations is "
            f"too large by {float(f'{100.0 * slope * slope:.2g}'):.15g} %")


def steep_equations(model: Any) -> bool:
    """Return whether a model has the equations for steep ground."""
    return getattr(model, "slope", "mild") == "steep"


def said_of(slope: float, model: Any) -> str:
    """Return the sentence about a slope for a model: its angle, and the equations or their error."""
    if steep_equations(model):
        return f"steepest slope {np.degrees(np.arctan(slope)):.3g} degrees: computed with the equations for steep ground"
    return sentence(slope)


def is_steep(slope: float) -> bool:
    """Return whether a slope is above `MILD` degrees."""
    return bool(slope > np.tan(np.radians(MILD)))


def needs_steep(slope: float) -> bool:
    """Return whether a slope is above `STEEP` degrees, where scenes take the equations for steep ground."""
    return bool(slope > np.tan(np.radians(STEEP)))


def warn_of_steep_ground(problem: Problem, g: float) -> None:
    """Warn where a flow with the mild-slope equations may reach a slope above `MILD` degrees, see `within_reach`."""
    b, dx = problem.aux_averages["b"], [axis.dx for axis in problem.grid.axes]
    if is_steep(steepest(b, dx, np.full(b.shape, True))) and is_steep(slope := within_reach(problem, g)):
        warnings.warn(f"{sentence(slope)}, by b_x^2; they are made for slopes up to {MILD:g} degrees, and here speed and runout "
                      "come out too large: take slope=\"steep\"", SteepSlopeWarning, stacklevel=validation.users_line())
