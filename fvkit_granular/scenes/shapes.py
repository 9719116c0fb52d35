"""Shapes: functions of x that are data, for depths, levels, solid fractions, velocities and bottoms.

A shape is a frozen object that is called with points x, m, and returns values of the same shape. It can be compared, sent to
another process and written to a scene file, which a function cannot. A sum of shapes is `Sum`, or ``shape + shape``.

With two axes a shape is called with x and y, and varies over x alone, over y alone (``over="y"``), or over the distance from a
point (``over=(x, y)``): a `Block` over a point is a disc, a `Gaussian` a bell.

Examples
--------
>>> import numpy as np
>>> from fvkit_granular import shapes
>>> release = shapes.Hump(centre=10.0, half_width=4.0, height=2.0) + shapes.Step(at=20.0, left=0.0, right=0.5)
>>> release(np.array([10.0, 12.0, 16.0, 30.0]))
array([2. , 1. , 0. , 0.5])
>>> shapes.Block(centre=0.0, half_width=5.0, height=1.0, over=(30.0, 40.0))(33.0, 43.0)
array(1.)
"""

from abc import ABC, abstractmethod
from typing import Any

import attrs
import numpy as np

from fvkit import validation
from fvkit.pointwise.part import by_name


def _over(value: Any) -> Any:
    """Return None for x, "y", or a point (x, y), checked."""
    if value is None or isinstance(value, str):
        return None if value in (None, "x") else validation.choice(value, "over", ("x", "y"))
    if not isinstance(value, (tuple, list)) or len(value) != 2:
        raise TypeError(f'`over` must be "x", "y", or a point (x, y) whose distance counts, got {validation.shown(value)}')
    return tuple(validation.real(place, f"over[{k}]") for k, place in enumerate(value))


@attrs.frozen
class Shape(ABC):
    """Abstract function of x, or of x and y, m, made of numbers.

    With two axes it varies ``over`` the coordinate "x" (None), "y", or the distance from a point (x, y), m.
    """

    over: Any = attrs.field(default=None, kw_only=True, converter=_over)

    def __call__(self, x: Any, *y: Any) -> np.ndarray:
        """Return the values at the points x, or x and y."""
        if self.over is None:
            return self.values_at(x)
        if not y:
            raise ValueError(f"`over` = {self.over!r} of {type(self).__name__} needs a scene with two axes, got one with one: "
                             "leave it out, or give `interval` two corners")
        return self.values_at(y[0] if self.over == "y" else np.hypot(x - self.over[0], y[0] - self.over[1]))

    @abstractmethod
    def values_at(self, x: Any) -> np.ndarray:
        """Return the values at coordinates ``x``, m, see ``over``."""

    def __add__(self, other: Any) -> "Sum":
        return Sum((*_terms(self), *_terms(as_shape(other))))


def _terms(shape: Shape) -> tuple[Shape, ...]:
    return shape.terms if isinstance(shape, Sum) else (shape,)


def as_shape(value: Any, name: str = "value") -> Shape:
    """Return a shape as it is, and the uniform shape of a number."""
    return value if isinstance(value, Shape) else Uniform(validation.real(value, name, hint="a number or a shape"))


@attrs.frozen
class Uniform(Shape):
    """The same ``value`` everywhere."""

    value: float = validation.number()

    def values_at(self, x: Any) -> np.ndarray:
        return np.full(np.shape(x), self.value)


@attrs.frozen
class Step(Shape):
    """``left`` for x < ``at``, m, and ``right`` from there on."""

    at: float = validation.number()
    left: float = validation.number()
    right: float = validation.number()

    def values_at(self, x: Any) -> np.ndarray:
        return np.where(np.asarray(x) < self.at, self.left, self.right)


def _numbers(value: Any, name: str, *more: int) -> np.ndarray:
    """Return a list of numbers, or of rows of them, as an array."""
    if not isinstance(value, (list, tuple, np.ndarray)) or not len(value):
        raise TypeError(f"`{name}` must be a list, not empty, got {validation.shown(value)}")
    return validation.array(value, name, (len(value), *more))


def _ascending(places: np.ndarray, name: str) -> None:
    if (np.diff(places) <= 0.0).any():
        raise ValueError(f"`{name}`: x must ascend, got {', '.join(f'{x:g}' for x in places)}")


def _places(value: Any) -> tuple[float, ...]:
    places = _numbers(value, "at")
    _ascending(places, "at")
    return tuple(places.tolist())


@attrs.frozen
class Steps(Shape):
    """``values[k]`` between the places ``at[k-1]`` <= x < ``at[k]``, m; one value more than places."""

    at: tuple[float, ...] = attrs.field(converter=_places)
    values: tuple[float, ...] = attrs.field(converter=lambda value: tuple(_numbers(value, "values").tolist()))

    def __attrs_post_init__(self) -> None:
        if len(self.values) != len(self.at) + 1:
            raise ValueError(f"`values` must be one more than `at`, got {len(self.values)} and {len(self.at)}")

    def values_at(self, x: Any) -> np.ndarray:
        return np.array(self.values)[np.searchsorted(self.at, x, side="right")]


@attrs.frozen
class Block(Shape):
    """``height`` where abs(x - centre) < ``half_width``, m, and 0 elsewhere."""

    centre: float = validation.number()
    half_width: float = validation.number(above=0.0)
    height: float = validation.number()

    def values_at(self, x: Any) -> np.ndarray:
        return np.where(np.abs(x - self.centre) < self.half_width, self.height, 0.0)


@attrs.frozen
class Hump(Shape):
    """A cosine bump: height/2 (1 + cos(pi (x - centre)/half_width)) where abs(x - centre) < half_width, m, 0 elsewhere."""

    centre: float = validation.number()
    half_width: float = validation.number(above=0.0)
    height: float = validation.number()

    def values_at(self, x: Any) -> np.ndarray:
        phase = (x - self.centre) / self.half_width
        return np.where(np.abs(phase) < 1.0, 0.5 * self.height * (1.0 + np.cos(np.pi * phase)), 0.0)


@attrs.frozen
class Gaussian(Shape):
    """A bell: height exp(-((x - centre)/width)^2), width in m."""

    centre: float = validation.number()
    width: float = validation.number(above=0.0)
    height: float = validation.number()

    def values_at(self, x: Any) -> np.ndarray:
        return self.height * np.exp(-(((x - self.centre) / self.width) ** 2))


@attrs.frozen
class Cosine(Shape):
    """Waves: mean + amplitude cos(2 pi (x - crest)/wavelength), crest and wavelength in m."""

    mean: float = validation.number()
    amplitude: float = validation.number()
    wavelength: float = validation.number(above=0.0)
    crest: float = validation.number(0.0)

    def values_at(self, x: Any) -> np.ndarray:
        return self.mean + self.amplitude * np.cos(2.0 * np.pi * (x - self.crest) / self.wavelength)


@attrs.frozen
class Plane(Shape):
    """A straight line: level + slope (x - at), at in m."""

    slope: float = validation.number()
    at: float = validation.number(0.0)
    level: float = validation.number(0.0)

    def values_at(self, x: Any) -> np.ndarray:
        return self.level + self.slope * (x - self.at)


def _points(value: Any) -> tuple[tuple[float, float], ...]:
    points = _numbers(value, "points", 2)
    _ascending(points[:, 0], "points")
    return tuple((float(x), float(y)) for x, y in points)


@attrs.frozen
class PiecewiseLinear(Shape):
    """Straight lines between the points (x, value), x ascending, m; the first and last value beyond them."""

    points: tuple[tuple[float, float], ...] = attrs.field(converter=_points)

    def values_at(self, x: Any) -> np.ndarray:
        places, values = np.array(self.points).T
        return np.interp(x, places, values)


def _shapes(value: Any) -> tuple[Shape, ...]:
    if not isinstance(value, (list, tuple)) or not value:
        raise TypeError(f"`terms` must be a non-empty list of shapes and numbers, got {validation.shown(value)}")
    return tuple(as_shape(term, "terms") for term in value)


@attrs.frozen
class Sum(Shape):
    """The sum of shapes, added in their order."""

    terms: tuple[Shape, ...] = attrs.field(converter=_shapes)

    def __call__(self, x: Any, *y: Any) -> np.ndarray:
        total = self.terms[0](x, *y)
        for term in self.terms[1:]:
            total = total + term(x, *y)
        return total

    def values_at(self, x: Any) -> np.ndarray:
        return self(x)


#: Shapes by their names in scene files, where a number is a `Uniform` and a list a `Sum`.
SHAPES: dict[str, type[Shape]] = by_name((Step, Steps, Block, Hump, Gaussian, Cosine, Plane, PiecewiseLinear))

#: No velocity.
NONE = Uniform(0.0)
