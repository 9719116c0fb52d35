"""Splittings: where the source steps stand beside the transport."""

from abc import ABC
from typing import Any, ClassVar

import attrs


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
