"""Sources and how they alternate with the transport step."""

from abc import ABC, abstractmethod
from typing import Any, ClassVar

import attrs
import numpy as np

from fvkit.model import Model
from fvkit.part import Part, default
from fvkit.pointwise import add, maximum, minimum, subtract


@attrs.frozen
class Source(Part, ABC):
    """Abstract source term S(q, x) that acts within a cell. Contract:

    1. ``step(model, q, aux, dt)`` returns the state after dt under the source alone; pointwise. It is exact or
       unconditionally stable, so a time step never depends on its strength, and it returns q for dt = 0.
    2. ``rate(model, q, aux)`` returns dq/dt of the same source; pointwise. `fvkit.rhs` uses it.
    3. ``check(model)`` raises ValueError, with the reason, for a model it cannot act on.
    4. Masses are never touched.
    5. ``driven(model, before, after, bearing, aux, dt)``, where defined, returns the state after dt under a constant drive, which
       alone takes ``before`` to ``after``, and the source; pointwise, with the masses of ``after``. ``bearing`` holds, for each
       phase, the mass that the drive has acted on. Where drive and source
       balance it returns the momenta of ``before``, to rounding. Wave propagation then lets source and transport act
       together, in cells and at faces: see `acted` and `fvkit.schemes.driven`. A source without it acts beside the transport,
       as the ``splitting`` of the scheme says.
    6. ``static = True`` says that it may hold at rest what is pushed.
    7. ``between_phases = True`` says that it exchanges momentum between phases: it is refused where the model has
       fewer than two, and a scene that is run with such a model leaves it out.
    8. Sources act on the cells of the grid alone: a boundary condition gives its ghost cells their state.
    """

    between_phases: ClassVar[bool] = False
    static: ClassVar[bool] = False

    def check(self, model: Model) -> None:
        """Raise ValueError, with the reason, if this source cannot act on ``model``."""
        if self.between_phases and len(model.phases) < 2:
            raise ValueError(f"{type(self).__name__} acts between two phases, {type(model).__name__} has one velocity: "
                             "leave it out of `sources`")

    @abstractmethod
    def step(self, model, q, aux, dt):
        """Return the state after a time dt under this source alone."""

    @default
    def driven(self, model, before, after, bearing, aux, dt):
        """Return the state after dt under this source and a drive that alone takes ``before`` to ``after``."""
        raise NotImplementedError(f"{type(self).__name__} defines no `driven`: it acts beside the transport")

    @default
    def implicit_rate(self, model, q, aux, a):
        """Return S(y) at the state y = q + a S(y), a >= 0 a time: what an implicit stage needs. Asked only where defined."""
        raise NotImplementedError(f"{type(self).__name__} defines no `implicit_rate`: only splitting serves it")

    @abstractmethod
    def rate(self, model, q, aux):
        """Return dq/dt due to this source."""


def acted(sources, model, before, after, bearing, aux, dt):
    """Return the state after dt under a drive that alone takes ``before`` to ``after``, and under all sources, each `driven`.

    A source is driven by the transport and by the others: by those that went ahead of it as they have acted, by those that
    follow as their rates at ``before`` have it, within the momenta at hand. Where all of them balance the state stays, and
    the whole is of second order.
    """
    shares, pushed = [], after
    for source in sources if len(sources) > 1 else ():
        shares.append(expected(source, model, before, pushed, aux, dt))
        pushed = add(pushed, shares[-1])
    for k, source in enumerate(sources):
        pushed = after
        for share in shares[k + 1:]:
            pushed = add(pushed, share)
        after = add(after, subtract(source.driven(model, before, pushed, bearing, aux, dt), pushed))
    return after


def expected(source, model, before, after, aux, dt):
    """Return what the rate of a source at ``before`` adds to each momentum in dt, at most its own size and that of its drive."""
    rates, result = source.rate(model, before, aux), [0.0] * len(before)
    for _, momentum in model.phases:
        most = np.abs(before[momentum]) + np.abs(after[momentum] - before[momentum])
        result[momentum] = maximum(minimum(dt * rates[momentum], most), -most)
    return tuple(result)


@attrs.frozen
class Splitting(ABC):
    """Abstract splitting of a step of length dt into transport and the sources that act beside it. Contract:

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
