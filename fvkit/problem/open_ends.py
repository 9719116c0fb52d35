"""Open ends: outflow, inflow and their base classes; what lies beyond an end goes on from the last cells."""

import warnings
from abc import ABC, abstractmethod
from collections.abc import Callable, Mapping
from copy import copy
from typing import Any, ClassVar

import attrs
import numpy as np

from fvkit import validation
from fvkit.pointwise.part import default
from fvkit.problem import answers
from fvkit.problem.boundary import BoundaryCondition
from fvkit.problem.grid import Axis, Grid, Side
from fvkit.problem.model import Model
from fvkit.problem.slopes import end_slope, end_step

#: Largest slope of the ground beyond an end, the tangent of 80 degrees: more is an angle in degrees.
STEEPEST = 5.67


def slope_beyond(value: Any, hint: str) -> float:
    """Return the slope of the ground beyond an end, checked."""
    return validation.real(value, "slope", at_least=-STEEPEST, at_most=STEEPEST,
                           hint=f"fall of the bottom per metre outwards, of 5 degrees tan(5 deg) = 0.087; {hint}")


@attrs.frozen
class Continued(BoundaryCondition, ABC):
    """Abstract end beyond which the aux functions continue, for models that define ``beyond``. Contract:

    1. ``ground`` holds, once `placed`, the slopes of the aux functions beyond the end, per metre to the right, and how far
       outside the first ghost cell lies, m, positive to the right. () for a model that defines no `Model.beyond`: all is level.
       It is the last of ``values``.
    2. ``goes_on(values)`` returns how much lower an aux function goes on, per cell outwards, from its cell averages, from the end
       inwards.
    3. `beyond` returns the state of a flow there.

    Parameters
    ----------
    slope : fall of the bottom per metre beyond the end, outwards, positive where it falls; None for that of ``goes_on``: by
        default that of the last two cells, where they lie on a slope and at no cliff.
    """

    slope: float | None = attrs.field(default=None, kw_only=True, converter=attrs.converters.optional(
        lambda value: slope_beyond(value, "None: as in the last cells")))
    ground: Any = attrs.field(default=(), init=False, repr=False, eq=False)

    def goes_on(self, values: np.ndarray) -> float:
        return end_step(values)

    def placed(self, side: Side, model: Model, grid: Grid | Axis, aux: Mapping[str, np.ndarray]) -> Any:
        known, outwards = model.defines("beyond"), side.outwards
        if self.slope is not None and not (known and len(model.aux) == 1):
            raise ValueError(f"`slope` of {type(self).__name__} needs a model that defines `beyond` and has one aux function, "
                             f"its bottom; {type(model).__name__} has {', '.join(model.aux) or 'none'}: leave `slope` out")
        falls = [self.goes_on(side.inwards(aux[name])) / grid.dx if self.slope is None else self.slope for name in model.aux]
        result = attrs.evolve(self)
        if known:
            object.__setattr__(result, "ground", (*(-outwards * fall for fall in falls), outwards * grid.dx))
        return result

    @default
    def values(self, model: Model, t: float) -> tuple[float, ...]:
        return self.ground

    def ghost_aux(self, model: Model, aux: np.ndarray, distance: np.ndarray) -> np.ndarray:
        if not self.ground:
            return aux
        return aux + np.array(self.ground[:-1]).reshape(-1, 1) * np.copysign(distance, self.ground[-1])

    def layer(self, values, number):
        return (*values[:-1], number * values[-1]) if self.ground else values


def beyond(end, model, q, values):
    """Return the state of a flow with state q in the ghost cells of a `Continued` end, from its values."""
    return model.beyond(q, values[-len(end.ground):-1], values[-1]) if end.ground else q


@attrs.frozen
class Outflow(Continued):
    """Open end: the flow continues as in the last cell, a lake at its level, a river at its depth (models with ``beyond``).

    Ground that falls outwards continues to fall, at the median of its last five steps; ground that rises continues level, so that
    no river runs in from above. Keeps rest over any bottom; reflects a little when a shock leaves.

    Examples
    --------
    >>> import fvkit as fv
    >>> import numpy as np
    >>> ends = (fv.Inflow([2.0]), fv.Outflow())
    >>> problem = fv.Problem(fv.Advection(1.0), fv.Grid(0.0, 1.0, 20), lambda x: [0.0 * x], 3.0, boundary=ends)
    >>> bool(abs(fv.solve(problem, backend="numpy").q[-1] - 2.0).max() < 1e-9)
    True
    """

    def goes_on(self, values: np.ndarray) -> float:
        return max(end_slope(values), 0.0) if len(values) > 1 else 0.0

    def placed(self, side: Side, model: Model, grid: Grid | Axis, aux: Mapping[str, np.ndarray]) -> Any:
        if self.slope is None and isinstance(grid, Grid) and model.defines("beyond"):
            for name in model.aux:
                _warn_of_rough_end(name, side.inwards(aux[name]), grid.dx)
        return super().placed(side, model, grid, aux)

    def ghost(self, model, q, values):
        return beyond(self, model, q, values)


#: Cells at an end over which its ground has a slope; its last five steps have lost that slope below the share ``LOST`` of it, and
#: not smoothly, as the end of a valley does, where their second differences exceed the share ``BENT``.
REACH, LOST, BENT = 10, 0.25, 0.5


def _warn_of_rough_end(name: str, values: np.ndarray, dx: float) -> None:
    """Warn where the last steps of the ground, from ``values[0]`` on, have lost the slope of its reach, but not smoothly."""
    steps = np.diff(values[:REACH])  # positive where the ground falls outwards
    if len(steps) < REACH - 1:
        return
    fall, last = float(np.median(steps)), end_slope(values)
    scatter = np.abs(values[:REACH] - values[:REACH].mean() - fall * (np.arange(REACH) - 0.5 * (REACH - 1))).max()
    bend = np.abs(np.diff(steps[:6], 2)).max()
    if REACH * fall > 2.0 * scatter and last < LOST * fall and bend > BENT * fall:
        warnings.warn(f"Outflow: `{name}` falls by {fall:.3g} per cell over the last {REACH} cells, but by {last:.3g} over the "
                      "last five, and goes on from that beyond the end: subcritical flow piles up there. Give the slope beyond "
                      f"the end, fv.Outflow(slope={fall / dx:.3g}), gr.FixedLevel, or smooth the last cells",
                      UserWarning, stacklevel=2)


def _state(value: Any) -> Any:
    return value if callable(value) and not isinstance(value, type) else validation.row(value, "state")


@attrs.frozen
class Given(Continued, ABC):
    """Abstract end with a given state. Contract: ``given(model, t)`` returns the conserved values, as floats."""

    still: ClassVar[bool] = True

    @abstractmethod
    def given(self, model: Model, t: float) -> tuple[float, ...]:
        """Return the conserved values at time t, s."""

    def values(self, model: Model, t: float) -> tuple[float, ...]:
        state = self.given(model, t)
        return (*state, *(self._entering(model, state) if self.ground else ()), *self.ground)

    def _entering(self, model: Model, state: tuple[float, ...]) -> tuple[float, ...]:
        """The fluxes of the masses of a state that is faster than its waves, else NaN: nothing inside can hold those back, but
        a solver that sees water fall from the ghost cells to dry ground lets in more."""
        inwards, aux = -np.sign(self.ground[-1]), [0.0] * len(model.aux)
        for row, slope in zip(model.slope_rows[:1], self.ground, strict=False):
            aux[row] = slope
        if min(inwards * speed for speed in answers.wave_speeds(model, state, tuple(aux))) <= 0.0:
            return (np.nan,) * len(model.mass_rows())
        flux = answers.mass_flux(model, state)
        return tuple(float(flux[row]) for row in model.mass_rows())

    def ghost(self, model, q, values):
        return beyond(self, model, values[:len(q)], values)

    def mass_fluxes(self, model, values):
        return values[len(model.conserved):len(values) - len(self.ground)]


@attrs.frozen
class Inflow(Given):
    """A given conserved state at the end; the Riemann solver lets in what travels inwards.

    Parameters
    ----------
    state : (num_eqn,) conserved values, or a function t -> (num_eqn,); on a grid with two axes with the momenta along both.
    slope : see `Continued`.

    Notes
    -----
    The ghost cells have the state, over a bottom that continues. Standing water has its level there: its depth is that over the
    bottom of the first cell. Of a flow with a depth that is faster than its waves exactly h v enters; of one that varies in time
    that of the middle of each step.

    Examples
    --------
    >>> import fvkit as fv
    >>> import numpy as np
    >>> ends = {"left": fv.Inflow(lambda t: [np.sin(t)]), "right": fv.Outflow()}
    >>> problem = fv.Problem(fv.Advection(1.0), fv.Grid(0.0, 1.0, 100), lambda x: [0.0 * x], 2.0, boundary=ends)
    >>> found = fv.solve(problem, backend="numpy").q[-1, 0]
    >>> bool(abs(found - np.sin(2.0 - problem.grid.centers)).max() < 1e-3)
    True
    """

    state: Any = attrs.field(converter=_state)
    sweep: Any = attrs.field(default=None, init=False, repr=False, eq=False)

    @property
    def steady(self) -> bool:
        return not callable(self.state)

    def whole(self, model: Model, t: float) -> tuple[float, ...]:
        """Return the state at time t, of all components."""
        if self.steady:
            given = self.state
        else:
            state: Callable[[float], Any] = self.state
            given = validation.row(state(t), f"Inflow state at t = {t:g}")
        wanted = model.conserved if self.sweep is None else self.sweep.names
        if len(given) != len(wanted):
            raise ValueError(f"`state` of Inflow must have {len(wanted)} components ({', '.join(wanted)}), got {len(given)}")
        return given

    def given(self, model: Model, t: float) -> tuple[float, ...]:
        whole = self.whole(model, t)
        return whole if self.sweep is None else tuple(whole[row] for row in self.sweep.rows)

    def turned(self, direction: Any) -> "Inflow":
        result = copy(self)
        object.__setattr__(result, "sweep", direction)
        return result

    def across(self, momenta: tuple[Any, ...], t: float) -> tuple[Any, ...]:
        whole = self.whole(self.sweep.model, t)
        return tuple(whole[row] + 0.0 * item for row, item in zip(self.sweep.across + self.sweep.still, momenta, strict=True))
