"""Boundary conditions: what a ghost cell holds."""

from abc import ABC, abstractmethod
from collections.abc import Callable, Mapping
from typing import Any, ClassVar

import attrs
import numpy as np

from fvkit import _validate
from fvkit.grid import Grid
from fvkit.model import Model
from fvkit.part import Part, default
from fvkit.pointwise import multiply


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
    5. ``placed(left, model, grid, aux)`` returns the condition as it is at one end of a grid: what it needs to know of the
       ground there is noted in it. Itself by default.
    6. ``mass_fluxes(model, values)`` returns what passes the end of each mass of the model, positive to the right: a part of
       ``values``. Where it is not defined the Riemann solver decides, from the ghost cells.
    7. ``breaks()`` returns the times at which ``values`` has a kink or a jump: steps end there. None by default.
    """

    reads: ClassVar[str] = "nearest"
    closed: ClassVar[bool] = False

    @property
    def steady(self) -> bool:
        """Whether `values` is the same at all times."""
        return True

    def values(self, model: Model, t: float) -> tuple[float, ...]:
        """Return the floats that `ghost` receives at time t; none by default."""
        return ()

    @abstractmethod
    def ghost(self, model, q, values):
        """Return the state of a ghost cell that looks at a cell with state q."""

    def ghost_aux(self, model: Model, aux: np.ndarray, distance: np.ndarray) -> np.ndarray:
        """Return the aux rows (num_aux, k) of k ghost cells from those of the cells they look at, ``distance`` (k,), m, away."""
        return aux

    def placed(self, left: bool, model: Model, grid: Grid, aux: Mapping[str, np.ndarray]) -> "BoundaryCondition":
        """Return this condition as it is at the left or right end of a grid with cell averages ``aux``."""
        return self

    @default
    def mass_fluxes(self, model, values):
        """Return the flux of each mass through this end, per width, positive to the right."""
        raise NotImplementedError(f"{type(self).__name__} defines no `mass_fluxes`: the Riemann solver decides")

    def breaks(self) -> tuple[float, ...]:
        """Return the times, s, at which a step must end."""
        return ()


@attrs.frozen
class Outflow(BoundaryCondition):
    """Zero-order extrapolation. Keeps rest over any bottom; reflects a little when a shock leaves."""

    def ghost(self, model, q, values):
        return q


@attrs.frozen
class Periodic(BoundaryCondition):
    """The domain closes on itself. Give it on both sides."""

    reads: ClassVar[str] = "opposite"

    def ghost(self, model, q, values):
        return q


@attrs.frozen
class Wall(BoundaryCondition):
    """A solid wall: the mirrored state with reversed momentum, over the mirrored bottom."""

    reads: ClassVar[str] = "mirror"
    closed: ClassVar[bool] = True

    def values(self, model: Model, t: float) -> tuple[float, ...]:
        return model.wall_signs()

    def ghost(self, model, q, values):
        return multiply(values, q)


def _state(value: Any) -> Any:
    return value if callable(value) and not isinstance(value, type) else _validate.row(value, "state")


@attrs.frozen
class Inflow(BoundaryCondition):
    """A given conserved state in the ghost cells; the Riemann solver lets in what travels inwards.

    Parameters
    ----------
    state : (num_eqn,) conserved values, or a function t -> (num_eqn,).
    """

    state: Any = attrs.field(converter=_state)

    @property
    def steady(self) -> bool:
        return not callable(self.state)

    def values(self, model: Model, t: float) -> tuple[float, ...]:
        if self.steady:
            given = self.state
        else:
            state: Callable[[float], Any] = self.state
            given = _validate.row(state(t), f"Inflow state at t = {t:g}")
        if len(given) != len(model.conserved):
            raise ValueError(f"`state` of Inflow must have {len(model.conserved)} components "
                             f"({', '.join(model.conserved)}), got {len(given)}")
        return given

    def ghost(self, model, q, values):
        return values
