"""Boundary conditions: states of ghost cells, and mass fluxes that a boundary imposes."""

import warnings
from abc import ABC, abstractmethod
from collections.abc import Callable, Mapping
from copy import copy
from typing import Any, ClassVar

import attrs
import numpy as np

from fvkit import validation
from fvkit.pointwise import multiply
from fvkit.pointwise.part import Part, default
from fvkit.problem import answers
from fvkit.problem.grid import Axis, Grid
from fvkit.problem.model import Model
from fvkit.problem.questions import BOUNDARY
from fvkit.problem.slopes import end_slope, end_step, resolved_steps


@attrs.frozen
class BoundaryCondition(Part, ABC):
    """Abstract boundary condition. Contract:

    1. ``reads`` says which cell a ghost cell looks at: ``"nearest"`` (the last cell inside), ``"mirror"`` (the
       cell as far inside as the ghost is outside) or ``"opposite"`` (wrapped round, needed on both sides).
       ``closed = True`` says that no mass passes, to the last bit.
    2. ``ghost(model, q, values)`` returns the ghost state from that cell's state; pointwise.
    3. ``values(model, t)`` returns the floats that ``ghost`` receives: anything computed in plain Python, once
       where ``steady`` is True, else for each step: at its middle, or at its stages for a scheme with a time integrator.
       It raises ValueError when the boundary cannot serve the model.
    4. ``ghost_aux(model, aux, distance)`` returns the aux rows of the ghost cells from those of the cells that they look
       at, and how far outside of these they lie: unchanged by default. Plain NumPy, once.
    5. ``placed(left, model, grid, aux)`` returns a copy bound to one end of a grid, with the bathymetry that it
       needs there. Itself by default.
    6. ``mass_fluxes(model, values)`` returns what passes the end of each mass of the model, positive to the right: a part of
       ``values``. Where it is not defined, (), or NaN, the Riemann solver decides, from the ghost cells.
    7. ``layer(values, number)`` returns the values that ``ghost`` receives for the ghost cell that is the ``number``-th outwards,
       from 1: ``values`` by default.
    8. ``across(momenta, t)`` returns the momenta along the side that ghost cells have, from those at the velocities of the cells
       that they look at; ``still = True`` says 0: what enters comes straight in. ``turned(direction)`` returns the condition as
       it is in sweeps along one axis. Both on grids with two axes alone.
    9. ``breaks()`` returns the times at which ``values`` has a kink or a jump: steps end there. None by default.

    Examples
    --------
    >>> import fvkit as fv
    >>> import numpy as np
    >>> class Still(fv.BoundaryCondition):
    ...     def ghost(self, model, q, values):
    ...         return (0.0 * q[0],)
    >>> problem = fv.Problem(fv.Advection(1.0), fv.Grid(0.0, 1.0, 20), np.ones((1, 20)), 2.0, boundary=(Still(), fv.Outflow()))
    >>> bool(abs(fv.solve(problem, backend="numpy").q[-1]).max() < 1e-12)
    True
    """

    questions = BOUNDARY
    reads: ClassVar[str] = "nearest"
    closed: ClassVar[bool] = False
    still: ClassVar[bool] = False

    @property
    def steady(self) -> bool:
        """Whether `values` is the same at all times."""
        return True

    @default
    def values(self, model: Model, t: float) -> tuple[float, ...]:
        """Return the floats that `ghost` receives at time t; none by default."""
        return ()

    @abstractmethod
    def ghost(self, model, q, values):
        """Return the state of a ghost cell that looks at a cell with state q."""

    def ghost_aux(self, model: Model, aux: np.ndarray, distance: np.ndarray) -> np.ndarray:
        """Return the aux rows (num_aux, k) of k ghost cells from those of the cells they look at, ``distance`` (k,), m, away."""
        return aux

    def placed(self, left: bool, model: Model, grid: Grid | Axis, aux: Mapping[str, np.ndarray]) -> "BoundaryCondition":
        """Return this condition as it is at the left or right end of a grid with cell averages ``aux``."""
        return self

    def layer(self, values, number):
        """Return the values that `ghost` receives for the ``number``-th ghost cell outwards."""
        return values

    @default
    def mass_fluxes(self, model, values):
        """Return the flux of each mass through this end, per width, positive to the right."""
        raise NotImplementedError(f"{type(self).__name__} defines no `mass_fluxes`: the Riemann solver decides")

    def turned(self, direction: Any) -> "BoundaryCondition":
        """Return this condition as it is in sweeps along a `fvkit.problem.directions.Direction`."""
        return self

    def across(self, momenta: tuple[Any, ...], t: float) -> tuple[Any, ...]:
        """Return the momenta of ghost cells along the side, of each phase, from those at the velocities of the cells inside."""
        return tuple(0.0 * item for item in momenta) if self.still else momenta

    def breaks(self) -> tuple[float, ...]:
        """Return the times, s, at which a step must end."""
        return ()


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
    2. ``goes_on(values, left)`` returns how much lower an aux function with cell averages ``values`` goes on, per cell outwards.
    3. `beyond` returns the state of a flow there.

    Parameters
    ----------
    slope : fall of the bottom per metre beyond the end, outwards, positive where it falls; None for that of the last two cells,
        where they lie on a slope and at no cliff.
    """

    slope: float | None = attrs.field(default=None, kw_only=True, converter=attrs.converters.optional(
        lambda value: slope_beyond(value, "None: as in the last cells")))
    ground: Any = attrs.field(default=(), init=False, repr=False, eq=False)

    def goes_on(self, values: np.ndarray, left: bool) -> float:
        return end_step(values, left)

    def placed(self, left: bool, model: Model, grid: Grid | Axis, aux: Mapping[str, np.ndarray]) -> Any:
        known, outwards = model.defines("beyond"), -1.0 if left else 1.0
        if self.slope is not None and not (known and len(model.aux) == 1):
            raise ValueError(f"`slope` of {type(self).__name__} needs a model that defines `beyond` and has one aux function, "
                             f"its bottom; {type(model).__name__} has {', '.join(model.aux) or 'none'}: leave `slope` out")
        falls = [self.goes_on(aux[name], left) / grid.dx if self.slope is None else self.slope for name in model.aux]
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
    no river runs in from above.
    Keeps rest over any bottom; reflects a little when a shock leaves.

    Examples
    --------
    >>> import fvkit as fv
    >>> import numpy as np
    >>> ends = (fv.Inflow([2.0]), fv.Outflow())
    >>> problem = fv.Problem(fv.Advection(1.0), fv.Grid(0.0, 1.0, 20), lambda x: [0.0 * x], 3.0, boundary=ends)
    >>> bool(abs(fv.solve(problem, backend="numpy").q[-1] - 2.0).max() < 1e-9)
    True
    """

    def goes_on(self, values: np.ndarray, left: bool) -> float:
        return max(end_slope(values, left), 0.0) if len(values) > 1 else 0.0

    def placed(self, left: bool, model: Model, grid: Grid | Axis, aux: Mapping[str, np.ndarray]) -> Any:
        if self.slope is None and isinstance(grid, Grid) and model.defines("beyond"):
            for name in model.aux:
                _warn_of_rough_end(name, aux[name] if left else aux[name][::-1], grid.dx)
        return super().placed(left, model, grid, aux)

    def ghost(self, model, q, values):
        return beyond(self, model, q, values)


#: Cells at an end over which its ground has a mean slope; its last five steps have lost that slope below this share of it.
REACH, LOST = 10, 0.25


def _warn_of_rough_end(name: str, values: np.ndarray, dx: float) -> None:
    """Warn where the last steps of the ground, from ``values[0]`` on, have lost the slope of its reach, but not smoothly."""
    steps = np.diff(values[:REACH])  # positive where the ground falls outwards
    if len(steps) < REACH - 1:
        return
    place = np.arange(REACH) - 0.5 * (REACH - 1)
    fall = float(place @ values[:REACH] / (place @ place))
    scatter = np.abs(values[:REACH] - values[:REACH].mean() - fall * place).max()
    bend, last = np.abs(np.diff(steps[:6], 2)).max(), end_slope(values, left=True)
    if REACH * fall > 2.0 * scatter and last < LOST * fall and bend > fall:
        warnings.warn(f"Outflow: `{name}` falls by {fall:.3g} per cell over the last {REACH} cells, but by {last:.3g} over the "
                      "last five, and goes on from that beyond the end: subcritical flow piles up there. Give the slope beyond "
                      f"the end, fv.Outflow(slope={fall / dx:.3g}), gr.FixedLevel, or smooth the last cells",
                      UserWarning, stacklevel=2)


def _drop(value: Any) -> Any:
    if isinstance(value, Mapping) and value:
        return {name: validation.real(number, f"drop[{name!r}]") for name, number in value.items()}
    return None if value is None else validation.real(value, "drop", hint="a number, or {name of an aux function: number}")


@attrs.frozen
class Periodic(BoundaryCondition):
    """Periodic boundary, on both sides of an axis: the domain closes on itself.

    Parameters
    ----------
    drop : fall of the aux functions over the length of the domain, for an endless slope: {"b": 2.0}, or a
        number for a model with one aux function. They continue lower by it beyond the upper end, and higher beyond the lower one.
        None for functions that are periodic: a step at the seam that is much larger than those next to it then gives a
        warning, which 0.0 switches off.

    Examples
    --------
    >>> import fvkit as fv
    >>> import fvkit_granular as gr
    >>> import numpy as np
    >>> slope = dict(aux={"b": lambda x: -0.1 * x}, boundary=fv.Periodic(drop=2.0))
    >>> problem = fv.Problem(gr.ShallowWater(), fv.Grid(0.0, 20.0, 40), lambda x: [0.0 * x + 1.0, 0.0 * x], 1.0, **slope)
    >>> print(f"{fv.solve(problem, backend='numpy').observables()['v'].max():.6f} m/s after 1 s")
    0.981000 m/s after 1 s
    """

    reads: ClassVar[str] = "opposite"

    # No floats, which would be parameters of pointwise code: only plain Python reads them.
    drop: Any = attrs.field(default=None, converter=_drop, hash=False)
    fall: Any = attrs.field(default=(), init=False, repr=False, eq=False)

    def placed(self, left: bool, model: Model, grid: Grid | Axis, aux: Mapping[str, np.ndarray]) -> "Periodic":
        drops = self._drops(model)
        result = attrs.evolve(self)
        object.__setattr__(result, "fall", tuple((-1.0 if left else 1.0) * drops.get(name, 0.0) for name in model.aux))
        for name in model.aux if left else ():
            if drops.get(name) != 0.0:
                _warn_of_cliff(name, aux[name], drops.get(name, 0.0))
        return result

    def _drops(self, model: Model) -> dict[str, float]:
        if self.drop is None:
            return {}
        if isinstance(self.drop, Mapping):
            return {validation.choice(name, "drop", model.aux): number for name, number in self.drop.items()}
        if len(model.aux) != 1:
            raise ValueError(f"`drop` of Periodic must say which aux function of {type(model).__name__} falls, {{name: number}}; "
                             f"it has {', '.join(model.aux) or 'none'}, got {self.drop:g}")
        return {model.aux[0]: self.drop}

    def ghost_aux(self, model: Model, aux: np.ndarray, distance: np.ndarray) -> np.ndarray:
        return aux - np.array(self.fall).reshape(-1, 1)

    def ghost(self, model, q, values):
        return q


#: The step at a seam is a cliff where none of so many neighbours on each side reaches its size over this factor.
NEIGHBOURS, CLIFF = 3, 3.0


def _warn_of_cliff(name: str, values: np.ndarray, drop: float) -> None:
    """Warn where an aux function has a cliff at the seam that makes up for slopes inside: for a fall that goes on, as a rule."""
    steps, seam = np.diff(values), values[0] - drop - values[-1]
    near = min(NEIGHBOURS, len(steps) // 2)
    around = np.abs([*steps[:near], *steps[-near:]]).max() if near else np.inf
    cliff = abs(seam) > CLIFF * around + 1e-12 * np.abs(values).max()
    if cliff and abs(resolved_steps(values).sum() + values[0] - values[-1]) < 0.5 * abs(seam):
        fall = values[0] - values[-1] - 0.5 * (steps[0] + steps[-1])
        warnings.warn(f"Periodic: `{name}` has a cliff of {abs(seam):.6g} at the seam, from {values[-1]:.6g} in the last cell to "
                      f"{values[0] - drop:.6g} in the first, where cells next to it differ by {around:.3g} at most. A slope that "
                      f"goes on for ever is fv.Periodic(drop={{{name!r}: {fall:.6g}}}); drop=0.0 says the cliff is meant",
                      UserWarning, stacklevel=validation.users_line())


@attrs.frozen
class Wall(BoundaryCondition):
    """A solid wall: the mirrored state with reversed momentum, over the mirrored bottom.

    Examples
    --------
    >>> import fvkit as fv
    >>> import fvkit_granular as gr
    >>> box = fv.Problem(gr.ShallowWater(), fv.Grid(0.0, 1.0, 20), lambda x: [1.0 + x, 0.0 * x], 0.5, boundary=fv.Wall())
    >>> abs(fv.solve(box, backend="numpy").stats.mass_drift["h"]) < 1e-14
    True
    """

    reads: ClassVar[str] = "mirror"
    closed: ClassVar[bool] = True

    def values(self, model: Model, t: float) -> tuple[float, ...]:
        return model.wall_signs()

    def ghost(self, model, q, values):
        return multiply(values, q)


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
        slower = min(inwards * speed for speed in answers.wave_speeds(model, state, tuple(aux))) <= 0.0
        return tuple(np.nan if slower else float(answers.mass_flux(model, state)[row]) for row in model.mass_rows())

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
