"""Boundary conditions: states of ghost cells, and mass fluxes that a boundary imposes."""

import warnings
from abc import ABC, abstractmethod
from collections.abc import Mapping
from typing import Any, ClassVar

import attrs
import numpy as np

from fvkit import validation
from fvkit.pointwise import multiply
from fvkit.pointwise.part import Part, default, optional
from fvkit.problem.grid import Axis, Grid, Side
from fvkit.problem.model import Model
from fvkit.problem.questions import BOUNDARY
from fvkit.problem.slopes import resolved_steps


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
    5. ``placed(side, model, grid, aux)`` returns a copy bound to one `fvkit.problem.grid.Side`, with the bathymetry that it
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

    def placed(self, side: Side, model: Model, grid: Grid | Axis, aux: Mapping[str, np.ndarray]) -> "BoundaryCondition":
        """Return this condition as it is at a side of a grid with cell averages ``aux``."""
        return self

    def layer(self, values, number):
        """Return the values that `ghost` receives for the ``number``-th ghost cell outwards."""
        return values

    @optional
    def mass_fluxes(self, model, values):
        """Return the flux of each mass through this end, per width, positive to the right."""

    def turned(self, direction: Any) -> "BoundaryCondition":
        """Return this condition as it is in sweeps along a `fvkit.problem.directions.Direction`."""
        return self

    def across(self, momenta: tuple[Any, ...], t: float) -> tuple[Any, ...]:
        """Return the momenta of ghost cells along the side, of each phase, from those at the velocities of the cells inside."""
        return tuple(0.0 * item for item in momenta) if self.still else momenta

    def breaks(self) -> tuple[float, ...]:
        """Return the times, s, at which a step must end."""
        return ()


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

    def placed(self, side: Side, model: Model, grid: Grid | Axis, aux: Mapping[str, np.ndarray]) -> "Periodic":
        drops = self._drops(model)
        result = attrs.evolve(self)
        object.__setattr__(result, "fall", tuple(side.outwards * drops.get(name, 0.0) for name in model.aux))
        for name in model.aux if not side.upper else ():
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
                      f"goes on for ever has that fall as `drop`: fv.Periodic(drop={{{name!r}: {fall:.6g}}}), in a scene file "
                      f"drop = {fall:.6g}; 0 says the cliff is meant",
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
