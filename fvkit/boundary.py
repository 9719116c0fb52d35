"""Boundary conditions: what a ghost cell holds."""

from abc import ABC, abstractmethod
from collections.abc import Callable
from typing import Any, ClassVar

import attrs
import numpy as np

from fvkit import _validate
from fvkit.model import Model
from fvkit.part import Part
from fvkit.pointwise import multiply


@attrs.frozen
class BoundaryCondition(Part, ABC):
    """Abstract boundary condition. Contract:

    1. ``reads`` says which cell a ghost cell looks at: ``"nearest"`` (the last cell inside), ``"mirror"`` (the
       cell as far inside as the ghost is outside) or ``"opposite"`` (wrapped round, needed on both sides).
       The aux values of the ghost cell are those of that cell, unchanged.
       ``closed = True`` says that no mass passes, to the last bit.
    2. ``ghost(model, q, values)`` returns the ghost state from that cell's state; pointwise.
    3. ``values(model, t)`` returns the floats that ``ghost`` receives: anything computed in plain Python, once
       per step where ``steady`` is False. It raises ValueError when the boundary cannot serve the model.
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
    return value if callable(value) else tuple(_validate.array(np.atleast_1d(value), "state").tolist())


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
            given = tuple(_validate.array(np.atleast_1d(state(t)), f"Inflow state at t = {t:g}").tolist())
        if len(given) != len(model.conserved):
            raise ValueError(f"`state` of Inflow must have {len(model.conserved)} components "
                             f"({', '.join(model.conserved)}), got {len(given)}")
        return given

    def ghost(self, model, q, values):
        return values
