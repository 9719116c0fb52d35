"""Operator splitting of transport and sources: Godunov, Strang, none."""

from abc import ABC
from typing import Any, ClassVar

import attrs


@attrs.frozen
class Splitting(ABC):
    """Abstract operator splitting of a step of length dt into transport and sources. Contract:

    1. ``before`` and ``after`` are the fractions of dt for which the sources act before and after the transport;
       they add up to ``total``, which is 1, or 0 if a time integrator includes the sources. A fraction of 0 costs nothing.
    2. Sources act in the given order before the transport and in reverse order after the transport.

    Examples
    --------
    >>> from typing import ClassVar
    >>> import attrs
    >>> import fvkit as fv
    >>> @attrs.frozen
    ... class SourcesFirst(fv.Splitting):
    ...     before: ClassVar[float] = 1.0
    ...     after: ClassVar[float] = 0.0
    >>> fv.WavePropagation(fv.HLL(), splitting=SourcesFirst()).splitting
    SourcesFirst()
    """

    before: ClassVar[float]
    after: ClassVar[float]
    total: ClassVar[float] = 1.0

    def check(self) -> None:
        """Raise ValueError unless ``before`` and ``after`` are non-negative and add up to ``total``."""
        if self.before + self.after != self.total or min(self.before, self.after) < 0.0:
            raise ValueError(f"`before` and `after` of {type(self).__name__} must be >= 0 and add up to {self.total:g}, got "
                             f"{self.before:g} and {self.after:g}")

    def __new__(cls, *arguments: Any, **named: Any) -> Any:
        if not (hasattr(cls, "before") and hasattr(cls, "after")):
            raise TypeError(f"{cls.__name__} is abstract: take fv.Strang() or fv.Godunov(), or set `before` and `after`")
        return super().__new__(cls)


@attrs.frozen
class Godunov(Splitting):
    """Godunov splitting: transport, then sources; first order in time.

    Examples
    --------
    >>> import fvkit as fv
    >>> fv.Godunov().before, fv.Godunov().after
    (0.0, 1.0)
    """

    before: ClassVar[float] = 0.0
    after: ClassVar[float] = 1.0


@attrs.frozen
class Unsplit(Splitting):
    """No splitting: the time integrator includes the sources in its stages."""

    before: ClassVar[float] = 0.0
    after: ClassVar[float] = 0.0
    total: ClassVar[float] = 0.0


@attrs.frozen
class Strang(Splitting):
    """Strang splitting: half the source, transport, half the source; second order, first order for a stiff source.

    Examples
    --------
    >>> import fvkit as fv
    >>> fv.Strang().before, fv.Strang().after
    (0.5, 0.5)
    """

    before: ClassVar[float] = 0.5
    after: ClassVar[float] = 0.5
