"""Checks of arguments, with one style of message: what was given, what is allowed, the usual fix."""

from collections.abc import Iterable
from difflib import get_close_matches
from typing import Any

import attrs
import numpy as np


def real(value: Any, name: str, *, above: float | None = None, at_least: float | None = None,
         below: float | None = None, at_most: float | None = None, hint: str = "") -> float:
    """Return ``value`` as a finite float within the bounds, or raise naming ``name``."""
    if isinstance(value, (str, bytes, bool, np.bool_)) or (not np.isscalar(value) and np.ndim(value) != 0):
        raise TypeError(f"`{name}` must be a number, got {value!r}{_after(hint)}")
    try:
        number = float(value)
    except (TypeError, ValueError):
        raise TypeError(f"`{name}` must be a number, got {value!r}{_after(hint)}") from None
    rules = [("finite", np.isfinite(number))]
    rules += [(f"> {above:g}", number > above)] if above is not None else []
    rules += [(f">= {at_least:g}", number >= at_least)] if at_least is not None else []
    rules += [(f"< {below:g}", number < below)] if below is not None else []
    rules += [(f"<= {at_most:g}", number <= at_most)] if at_most is not None else []
    if not all(kept for _, kept in rules):
        raise ValueError(f"`{name}` must be {' and '.join(rule for rule, _ in rules)}, got {value!r}{_after(hint)}")
    return number


def whole(value: Any, name: str, *, at_least: int, hint: str = "") -> int:
    """Return ``value`` as an int not below ``at_least``, or raise naming ``name``."""
    if isinstance(value, bool) or not isinstance(value, (int, np.integer)):
        raise TypeError(f"`{name}` must be a whole number, got {value!r}{_after(hint)}")
    if value < at_least:
        raise ValueError(f"`{name}` must be >= {at_least}, got {value!r}{_after(hint)}")
    return int(value)


def array(value: Any, name: str, shape: tuple[int, ...] | None = None) -> np.ndarray:
    """Return ``value`` as a new float array, finite and of the given shape, or raise naming ``name``."""
    try:
        result = np.array(value, dtype=float)
    except (TypeError, ValueError) as error:
        raise TypeError(f"`{name}` must be an array of numbers: {error}") from None
    if shape is not None and result.shape != shape:
        raise ValueError(f"`{name}` must have shape {shape}, got {result.shape}")
    if not np.isfinite(result).all():
        where = tuple(int(i) for i in np.argwhere(~np.isfinite(result))[0])
        raise ValueError(f"`{name}` must be finite, got {result[where]} at index {where}")
    return result


def instance(value: Any, name: str, kind: type, hint: str = "") -> Any:
    """Return ``value`` if it is an instance of ``kind``, or raise naming ``name``."""
    if isinstance(value, kind):
        return value
    if isinstance(value, type) and issubclass(value, kind):
        raise TypeError(f"`{name}` must be an instance of {kind.__name__}, got the class {value.__name__}: "
                        f"write {value.__name__}()")
    raise TypeError(f"`{name}` must be an instance of {kind.__name__}, got {value!r}{_after(hint)}")


def choice(value: Any, name: str, known: Iterable[Any]) -> Any:
    """Return ``value`` if it is one of ``known``, or raise with the list and the nearest match."""
    options = list(known)
    if value in options:
        return value
    nearest = get_close_matches(str(value), [str(option) for option in options], n=1)
    raise ValueError(f"`{name}` must be one of {', '.join(map(str, options))}; got {value!r}"
                     + (f", did you mean {nearest[0]}?" if nearest else ""))


def within(*, hint: str = "", **bounds: float) -> Any:
    """Return the converter of a float field that keeps the bounds of `real`."""
    return attrs.Converter(lambda value, field: real(value, field.name, hint=hint, **bounds), takes_field=True)


def number(default: float, *, hint: str = "", **bounds: float) -> Any:
    """Declare a float field with a default, validated against the bounds of `real`."""
    return attrs.field(default=default, converter=within(hint=hint, **bounds))


def optional_number(*, hint: str = "", **bounds: float) -> Any:
    """Declare a float field that may be None, its default."""
    return attrs.field(default=None, converter=attrs.Converter(
        lambda value, field: None if value is None else real(value, field.name, hint=hint, **bounds), takes_field=True))


def _after(hint: str) -> str:
    return f" ({hint})" if hint else ""
