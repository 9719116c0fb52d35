"""Relief: equations over a steep bottom. Its slopes are rows behind the aux values; sources act in its tangent plane.

On a steep bottom only a part of gravity acts in its tangent plane, and friction acts against the velocity along it. Waves and
push see the equations of `Model.on_slope`, at a face with the mean slopes of both sides. For sources momenta are stretched by
sqrt(1 + s^2) along the slope s and left alone across it: they are then those along the bottom, in which friction has no
preferred direction. A level bottom leaves every bit. Derived here.
"""

from functools import cached_property, reduce
from typing import Any, ClassVar

import attrs
import numpy as np

from fvkit.pointwise import TINY, combine, maximum, minimum, subtract
from fvkit.pointwise.part import Wrapper
from fvkit.problem.grid import Grid
from fvkit.problem.questions import aux_places


@attrs.frozen(eq=False)
class Slopes:
    """Slopes of an aux function along each axis, from its cell averages: a field of the problem, like those of its sources.

    Of its one-sided differences a and b a cell has a b (a + b)/(a^2 + b^2) (van Albada): their mean where they are alike, the
    smaller one beside a cliff, which is a wall and no slope, and 0 at a crest or in a pit.

    Where it ``bends`` second derivatives follow the slopes: b_xx, with two axes b_xx, b_xy, b_yy, of slopes that are smoothed
    by the weights 1/4, 1/2, 1/4 along each axis, since those of a raster are noise. Of five differences in a row they have
    the median: it leaves out a cliff of one or two faces, and keeps the whole turn of a kink.
    """

    values: np.ndarray
    grid: Grid
    bends: bool = False
    source: ClassVar[None] = None
    steady: ClassVar[bool] = True

    @property
    def size(self) -> int:
        """The number of rows."""
        return len(self.grid.axes) + (len(SECOND[len(self.grid.axes)]) if self.bends else 0)

    def breaks(self) -> tuple[float, ...]:
        """Return no times: it is steady."""
        return ()

    def at(self, t: float) -> np.ndarray:
        """Return the slopes along each axis, and second derivatives behind them, (size, *grid.shape)."""
        return self._rows

    @cached_property
    def _rows(self) -> np.ndarray:
        axes, last = self.grid.axes, len(self.grid.axes) - 1
        rows = [_limited(self.values, last - k, axis.dx) for k, axis in enumerate(axes)]
        if self.bends:
            first = [_averaged(_without_cliffs(self.values, last - k, axis.dx)) for k, axis in enumerate(axes)]
            rows += [0.5 * (_derivative(first[i], last - j, axes[j].dx) + _derivative(first[j], last - i, axes[i].dx))
                     for i, j in SECOND[len(axes)]]
        return np.array(rows)


#: Axes of the second derivatives, by the number of axes.
SECOND = {1: ((0, 0),), 2: ((0, 0), (0, 1), (1, 1))}

#: Speed, m/s, beyond which no flow is turned more: its square, times a curvature of 0, stays a number.
FASTEST = 1e6


def _averaged(values: np.ndarray) -> np.ndarray:
    """Cell averages with the weights 1/4, 1/2, 1/4 along each axis."""
    for axis in range(values.ndim):
        edges = [(1, 1) if k == axis else (0, 0) for k in range(values.ndim)]
        behind, ahead = (np.pad(values, edges, mode="reflect" if values.shape[axis] > 1 else "edge").take(
            range(first, first + values.shape[axis]), axis=axis) for first in (0, 2))
        values = 0.5 * values + 0.25 * (behind + ahead)
    return values


def _without_cliffs(values: np.ndarray, axis: int, dx: float) -> np.ndarray:
    """The slope of cell averages along an array axis, of medians of five differences in a row: without cliffs, but with kinks."""
    if values.shape[axis] == 1:
        return np.zeros(values.shape)
    one_sided = np.diff(values, axis=axis) / dx
    row = min(5, one_sided.shape[axis])
    medians = np.median(np.lib.stride_tricks.sliding_window_view(one_sided, row, axis=axis), axis=-1)
    edges = [((row + 1) // 2, row // 2 + 1) if k == axis else (0, 0) for k in range(values.ndim)]
    if medians.shape[axis] > 1:  # straight on at the ends: a wall at the edge is no slope either
        medians = np.pad(medians, edges, mode="reflect", reflect_type="odd")
    else:
        medians = np.pad(medians, edges, mode="edge")
    behind, ahead = (medians.take(range(first, first + values.shape[axis]), axis=axis) for first in (0, 1))
    return np.asarray(0.5 * (behind + ahead))


def _derivative(values: np.ndarray, axis: int, dx: float) -> np.ndarray:
    """The central difference along an array axis, one-sided at the ends."""
    return np.asarray(np.gradient(values, dx, axis=axis)) if values.shape[axis] > 1 else np.zeros(values.shape)


def _limited(values: np.ndarray, axis: int, dx: float) -> np.ndarray:
    """The limited slope of cell averages along an array axis; at both ends with the difference one further in."""
    if values.shape[axis] == 1:
        return np.zeros(values.shape)
    one_sided = np.diff(values, axis=axis) / dx
    inner = min(1, one_sided.shape[axis] - 1)  # one further in: a wall at the edge is no slope either
    first, last = (np.take(one_sided, [k], axis=axis) for k in (inner, -1 - inner))
    behind = np.concatenate([first, one_sided], axis=axis)
    ahead = np.concatenate([one_sided, last], axis=axis)
    product, squares = behind * ahead, behind * behind + ahead * ahead
    return np.asarray(np.where(product > 0.0, product * (behind + ahead) / np.where(squares > 0.0, squares, 1.0), 0.0))


@attrs.frozen(repr=False)
class OverSlopes(Wrapper):
    """A model that finds the slopes of its bottom, that its `Model.relief` names, behind its own aux values.

    ``axes`` is the number of axes of the grid, ``number`` that of the axis of the sweep; where it ``bends`` second derivatives
    follow the slopes.
    """

    axes: int
    number: int
    bends: bool

    @property
    def aux(self) -> tuple[str, ...]:
        """Names of the aux values, slopes and second derivatives among them."""
        return (*self.part.aux, *("slope along x", "slope along y")[:self.axes],
                *(f"second derivative {row}" for row in self._second))

    @property
    def slope_rows(self) -> tuple[int, ...]:
        """Rows of the slopes along a sweep and across it."""
        own = len(self.part.aux)
        return (own,) if self.axes == 1 else (own + self.number, own + 1 - self.number)

    @property
    def bend_rows(self) -> tuple[int, ...]:
        """Rows of the second derivatives: along a sweep, mixed, and across it."""
        return self._second if self.number == 0 else self._second[::-1]

    @property
    def _second(self) -> tuple[int, ...]:
        first = len(self.part.aux) + self.axes
        return tuple(range(first, first + len(SECOND[self.axes]))) if self.bends else ()

    @property
    def takes_aux(self) -> frozenset[str]:
        """All questions that may take aux values: they do, since slopes are among these."""
        return frozenset(one.name for one in self.part.questions if one.also and self.part.defines(one.name))

    def beyond(self, q, slopes, distance):
        """Return what the equations over the slope of the ground beyond an end say, see `fvkit.Model.beyond`."""
        ground = self.part.aux.index(self.part.relief())
        return self.part.on_slope(stretching(slopes[ground:ground + 1])).beyond(q, slopes, distance)

    def cross(self, ql, qr, auxl, auxr):
        """Return the cross term of the equations on the slope, less A_a da G, the change of their matrix with the slope."""
        own, jump = len(self.part.aux), self.jump(ql, qr, auxl, auxr)
        here, left, right = (self.part.on_slope(stretching(slopes_at(self, aux)))
                             for aux in (combine(0.5, auxl, 0.5, auxr), auxl, auxr))
        face = (ql, qr, auxl[:own], auxr[:own])
        change = subtract(right.matrix_product(*face, jump), left.matrix_product(*face, jump))
        return subtract(here.cross(*face), change)

    def __getattr__(self, name: str) -> Any:
        answer = Wrapper.__getattr__(self, name)
        places = aux_places(self.part.questions).get(name) if callable(answer) else None
        if places is None or not self.part.defines(name):
            return answer
        drops, own = name in self.takes_aux and name not in self.part.takes_aux, len(self.part.aux)

        def on_slope(*arguments: Any) -> Any:
            given = [arguments[k] for k in places]
            steepness = stretching(slopes_at(self, given[0] if len(given) == 1 else combine(0.5, given[0], 0.5, given[1])))
            rest = [item[:own] if k in places else item for k, item in enumerate(arguments) if not (drops and k in places)]
            return getattr(self.part.on_slope(steepness), name)(*rest)

        return on_slope


def slopes_at(model, aux):
    """Return the slopes of the bottom along the sweep and across it; () without relief, and where it is level everywhere."""
    slopes = tuple([aux[row] for row in model.slope_rows])
    return () if all(type(slope) is float and slope == 0.0 for slope in slopes) else slopes


def turnings(model, before, after, aux):
    """Return u . Hess(b) u of each phase, m/s^2, with its mean velocity u of two states: how much a curved bottom turns it.

    () where nothing bends.
    """
    second, own, result = [aux[row] for row in model.bend_rows], len(model.conserved), []
    if not second:
        return ()
    for k, phase in enumerate(model.phases):
        row, rows = phase.masses[-1], (phase.momentum, own + k)[:1 if len(before) == own else 2]
        u = [(before[place] + after[place]) / (before[row] + after[row] + TINY) for place in rows]
        u = [maximum(minimum(one, FASTEST), -FASTEST) for one in u]  # on dry ground a step may leave momenta
        if len(u) == 1:
            result.append(second[0] * u[0] * u[0])
        else:
            result.append(second[0] * u[0] * u[0] + 2.0 * second[1] * u[0] * u[1] + second[2] * u[1] * u[1])
    return tuple(result)


def turned_aside(model, state, slopes, root, turning, bearing, dt):
    """Return a stretched state after dt of the force of a curved bottom, -turning/root times its slopes, on each phase.

    It acts on the mass that bears the drive, as friction does; on that of a film that is left at most twice.
    """
    result, own = list(state), len(model.conserved)
    for k, (phase, much) in enumerate(zip(model.phases, turning, strict=True)):
        push = dt * minimum(bearing[k], 2.0 * state[phase.masses[-1]]) * much / root
        for row, slope in zip((phase.momentum, own + k)[:1 if len(state) == own else 2], slopes, strict=False):
            result[row] = result[row] - push * slope
    return tuple(result)


def stretching(slopes):
    """Return 1 + s^2 of the steepest slope s: the square of the length of the bottom over its length on the map."""
    return reduce(lambda total, slope: total + slope * slope, slopes, 1.0)


def stretched(model, state, slopes, root):
    """Return a state with its momenta along the bottom, those across behind it if there are any; ``root`` of `stretching`."""
    return _turned_up(model, state, slopes, 1.0 / (root + 1.0))


def unstretched(model, state, slopes, root):
    """Return the state that `stretched` has made this one of."""
    return _turned_up(model, state, slopes, -1.0 / (root * (root + 1.0)))


def _turned_up(model, state, slopes, share):
    """Add to each momentum its component along the slopes, times the slopes and a share."""
    result, own = list(state), len(model.conserved)
    for k, phase in enumerate(model.phases):
        rows = (phase.momentum, own + k)[:1 if len(state) == own else 2]
        along = share * sum(state[row] * slope for row, slope in zip(rows, slopes, strict=False))
        for row, slope in zip(rows, slopes, strict=False):
            result[row] = state[row] + along * slope
    return tuple(result)
