"""Shapes: functions of x that are data, for depths, levels, solid fractions, velocities and bottoms.

A shape is a frozen object that is called with points x, m, and returns values of the same shape. It can be compared, sent to
another process and written to a scene file, which a function cannot. A sum of shapes is `Sum`, or ``shape + shape``.
"""

from abc import ABC, abstractmethod
from typing import Any

import attrs
import numpy as np

from fvkit import _validate
from fvkit.names import by_name


@attrs.frozen
class Shape(ABC):
    """Abstract function of x, m, made of numbers."""

    @abstractmethod
    def __call__(self, x: Any) -> np.ndarray:
        """Return the values at the points ``x``."""

    def __add__(self, other: Any) -> "Sum":
        return Sum((*_terms(self), *_terms(as_shape(other))))


def _terms(shape: Shape) -> tuple[Shape, ...]:
    return shape.terms if isinstance(shape, Sum) else (shape,)


def as_shape(value: Any, name: str = "value") -> Shape:
    """Return a shape as it is, and the uniform shape of a number."""
    return value if isinstance(value, Shape) else Uniform(_validate.real(value, name, hint="a number or a shape"))


@attrs.frozen
class Uniform(Shape):
    """The same ``value`` everywhere."""

    value: float = attrs.field(converter=_validate.within())  # type: ignore[misc]

    def __call__(self, x: Any) -> np.ndarray:
        return np.full(np.shape(x), self.value)


@attrs.frozen
class Step(Shape):
    """``left`` for x < ``at``, m, and ``right`` from there on."""

    at: float = attrs.field(converter=_validate.within())  # type: ignore[misc]
    left: float = attrs.field(converter=_validate.within())  # type: ignore[misc]
    right: float = attrs.field(converter=_validate.within())  # type: ignore[misc]

    def __call__(self, x: Any) -> np.ndarray:
        return np.where(np.asarray(x) < self.at, self.left, self.right)


def _numbers(value: Any, name: str, *more: int) -> np.ndarray:
    """Return a list of numbers, or of rows of them, as an array."""
    if not isinstance(value, (list, tuple, np.ndarray)) or not len(value):
        raise TypeError(f"`{name}` must be a list, not empty, got {_validate.shown(value)}")
    return _validate.array(value, name, (len(value), *more))


def _ascending(places: np.ndarray, name: str) -> None:
    if (np.diff(places) <= 0.0).any():
        raise ValueError(f"`{name}`: x must ascend, got {', '.join(f'{x:g}' for x in places)}")


def _places(value: Any) -> tuple[float, ...]:
    places = _numbers(value, "at")
    _ascending(places, "at")
    return tuple(places.tolist())


def _row(value: Any) -> tuple[float, ...]:
    return tuple(_numbers(value, "values").tolist())


@attrs.frozen
class Steps(Shape):
    """``values[k]`` between the places ``at[k-1]`` <= x < ``at[k]``, m; one value more than places."""

    at: tuple[float, ...] = attrs.field(converter=_places)
    values: tuple[float, ...] = attrs.field(converter=_row)

    def __attrs_post_init__(self) -> None:
        if len(self.values) != len(self.at) + 1:
            raise ValueError(f"`values` must be one more than `at`, got {len(self.values)} and {len(self.at)}")

    def __call__(self, x: Any) -> np.ndarray:
        return np.array(self.values)[np.searchsorted(self.at, x, side="right")]


@attrs.frozen
class Block(Shape):
    """``height`` where abs(x - centre) < ``half_width``, m, and 0 elsewhere."""

    centre: float = attrs.field(converter=_validate.within())  # type: ignore[misc]
    half_width: float = attrs.field(converter=_validate.within(above=0.0))  # type: ignore[misc]
    height: float = attrs.field(converter=_validate.within())  # type: ignore[misc]

    def __call__(self, x: Any) -> np.ndarray:
        return np.where(np.abs(x - self.centre) < self.half_width, self.height, 0.0)


@attrs.frozen
class Hump(Shape):
    """A cosine bump: height/2 (1 + cos(pi (x - centre)/half_width)) where abs(x - centre) < half_width, m, 0 elsewhere."""

    centre: float = attrs.field(converter=_validate.within())  # type: ignore[misc]
    half_width: float = attrs.field(converter=_validate.within(above=0.0))  # type: ignore[misc]
    height: float = attrs.field(converter=_validate.within())  # type: ignore[misc]

    def __call__(self, x: Any) -> np.ndarray:
        phase = (x - self.centre) / self.half_width
        return np.where(np.abs(phase) < 1.0, 0.5 * self.height * (1.0 + np.cos(np.pi * phase)), 0.0)


@attrs.frozen
class Gaussian(Shape):
    """A bell: height exp(-((x - centre)/width)^2), width in m."""

    centre: float = attrs.field(converter=_validate.within())  # type: ignore[misc]
    width: float = attrs.field(converter=_validate.within(above=0.0))  # type: ignore[misc]
    height: float = attrs.field(converter=_validate.within())  # type: ignore[misc]

    def __call__(self, x: Any) -> np.ndarray:
        return self.height * np.exp(-(((x - self.centre) / self.width) ** 2))


@attrs.frozen
class Cosine(Shape):
    """Waves: mean + amplitude cos(2 pi (x - crest)/wavelength), crest and wavelength in m."""

    mean: float = attrs.field(converter=_validate.within())  # type: ignore[misc]
    amplitude: float = attrs.field(converter=_validate.within())  # type: ignore[misc]
    wavelength: float = attrs.field(converter=_validate.within(above=0.0))  # type: ignore[misc]
    crest: float = _validate.number(0.0)

    def __call__(self, x: Any) -> np.ndarray:
        return self.mean + self.amplitude * np.cos(2.0 * np.pi * (x - self.crest) / self.wavelength)


@attrs.frozen
class Plane(Shape):
    """A straight line: level + slope (x - at), at in m."""

    slope: float = attrs.field(converter=_validate.within())  # type: ignore[misc]
    at: float = _validate.number(0.0)
    level: float = _validate.number(0.0)

    def __call__(self, x: Any) -> np.ndarray:
        return self.level + self.slope * (x - self.at)


def _points(value: Any) -> tuple[tuple[float, float], ...]:
    points = _numbers(value, "points", 2)
    _ascending(points[:, 0], "points")
    return tuple((float(x), float(y)) for x, y in points)


@attrs.frozen
class PiecewiseLinear(Shape):
    """Straight lines between the points (x, value), x ascending, m; the first and last value beyond them."""

    points: tuple[tuple[float, float], ...] = attrs.field(converter=_points)

    def __call__(self, x: Any) -> np.ndarray:
        places, values = np.array(self.points).T
        return np.interp(x, places, values)


def _shapes(value: Any) -> tuple[Shape, ...]:
    if not isinstance(value, (list, tuple)) or not value:
        raise TypeError(f"`terms` must be a non-empty list of shapes and numbers, got {_validate.shown(value)}")
    return tuple(as_shape(term, "terms") for term in value)


@attrs.frozen
class Sum(Shape):
    """The sum of shapes, added in their order."""

    terms: tuple[Shape, ...] = attrs.field(converter=_shapes)

    def __call__(self, x: Any) -> np.ndarray:
        total = self.terms[0](x)
        for term in self.terms[1:]:
            total = total + term(x)
        return total


#: Shapes by their names in scene files, where a number is a `Uniform` and a list a `Sum`.
SHAPES: dict[str, type[Shape]] = by_name((Step, Steps, Block, Hump, Gaussian, Cosine, Plane, PiecewiseLinear))
