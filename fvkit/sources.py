"""Sources and how they alternate with the transport step."""

from abc import ABC, abstractmethod
from typing import Any, ClassVar

import attrs

from fvkit.model import Model
from fvkit.part import Part, default


@attrs.frozen
class Source(Part, ABC):
    """Abstract source term S(q, x) that acts within a cell. Contract:

    1. ``step(model, q, aux, dt)`` returns the state after dt under the source alone; pointwise. It is exact or
       unconditionally stable, so a time step never depends on its strength, and it returns q for dt = 0.
    2. ``rate(model, q, aux)`` returns dq/dt of the same source; pointwise. `fvkit.rhs` uses it.
    3. ``check(model)`` raises ValueError, with the reason, for a model it cannot act on.
    4. Masses are never touched.
    5. ``limit_jump(model, ql, qr, auxl, auxr, jump, dx)``, where defined, returns the jump of a face less what a static
       force of the source holds back; pointwise. It acts before the Riemann solver, which never knows: a slope below
       its angle of friction then stays at rest, exactly. Where a push is left, ``step`` is expected to take the same
       force from what moves, so the scheme gives back to the cells what that would count twice.
    6. ``between_phases = True`` says that it exchanges momentum between phases: it is refused where the model has
       fewer than two, and a scene that is run with such a model leaves it out.
    """

    between_phases: ClassVar[bool] = False

    def check(self, model: Model) -> None:
        """Raise ValueError, with the reason, if this source cannot act on ``model``."""
        if self.between_phases and len(model.phases) < 2:
            raise ValueError(f"{type(self).__name__} acts between two phases, {type(model).__name__} has one velocity: "
                             "leave it out of `sources`")

    @abstractmethod
    def step(self, model, q, aux, dt):
        """Return the state after a time dt under this source alone."""

    @default
    def limit_jump(self, model, ql, qr, auxl, auxr, jump, dx):
        """Return the jump that is left of a face between cells of length dx. Asked only where defined."""
        raise NotImplementedError(f"{type(self).__name__} defines no `limit_jump`: the jump stays as it is")

    @default
    def implicit_rate(self, model, q, aux, a):
        """Return S(y) at the state y = q + a S(y), a >= 0 a time: what an implicit stage needs. Asked only where defined."""
        raise NotImplementedError(f"{type(self).__name__} defines no `implicit_rate`: only splitting serves it")

    @abstractmethod
    def rate(self, model, q, aux):
        """Return dq/dt due to this source."""


@attrs.frozen
class Splitting(ABC):
    """Abstract splitting of a step of length dt into source and transport. Contract:

    1. ``before`` and ``after`` are the shares of dt for which the sources act before and after the transport;
       they add up to 1 (``total``; 0 where an integrator takes the sources itself), and a share of 0 costs nothing.
    2. Sources act in the given order before the transport and in reverse order after it.
    """

    before: ClassVar[float]
    after: ClassVar[float]
    total: ClassVar[float] = 1.0

    def check(self) -> None:
        """Raise ValueError where the sources would act for another time than the transport."""
        if self.before + self.after != self.total or min(self.before, self.after) < 0.0:
            raise ValueError(f"`before` and `after` of {type(self).__name__} must be >= 0 and add up to {self.total:g}, got "
                             f"{self.before:g} and {self.after:g}")

    def __new__(cls, *arguments: Any, **named: Any) -> Any:
        if not (hasattr(cls, "before") and hasattr(cls, "after")):
            raise TypeError(f"{cls.__name__} is abstract: take fv.Strang() or fv.Godunov(), or set `before` and `after`")
        return super().__new__(cls)


@attrs.frozen
class Godunov(Splitting):
    """Transport, then source: first order in time."""

    before: ClassVar[float] = 0.0
    after: ClassVar[float] = 1.0


@attrs.frozen
class Unsplit(Splitting):
    """No splitting: the integrator takes the sources into its stages."""

    before: ClassVar[float] = 0.0
    after: ClassVar[float] = 0.0
    total: ClassVar[float] = 0.0


@attrs.frozen
class Strang(Splitting):
    """Half the source, transport, half the source: second order, first order where the source is stiff."""

    before: ClassVar[float] = 0.5
    after: ClassVar[float] = 0.5
