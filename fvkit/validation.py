"""Checks of arguments, with one style of message: what was given, what is allowed, the usual fix."""

import copyreg
import os
import sys
from collections.abc import Callable, Iterable, Mapping
from difflib import get_close_matches
from importlib import import_module
from numbers import Real
from os import PathLike, fspath
from pathlib import Path
from typing import Any

import attrs
import numpy as np

#: Text types, never accepted as numbers or sequences.
TEXTS = (str, bytes, bytearray)

#: Largest integer N such that floats represent every integer up to N exactly.
MOST = 2**53

#: Names above which a message about a wrong one lists the known ones last.
MANY = 20

#: Characters of a value that a message shows.
LONGEST = 120


def shown(value: Any) -> str:
    """Return what a message says of a value: its ``repr`` on one line, cut where it is long."""
    try:
        text = " ".join(repr(value.item() if isinstance(value, np.generic) else value).split())
    except Exception as error:  # of an object whose own repr fails: a message is being made, nothing else may go wrong
        text = f"a {type(value).__name__} that cannot be shown ({type(error).__name__})"
    return cut(text)


def cut(text: str, longest: int = LONGEST) -> str:
    """Return what a message says of a text: all of it, or its beginning."""
    return text if len(text) <= longest else f"{text[:longest]}..."


def one_line(text: str) -> str:
    """Return a text of someone else's on one line, cut where it is long."""
    return cut("".join(character if character.isprintable() else " " for character in text[:LONGEST + 1]))


def real(value: Any, name: str, *, above: float | None = None, at_least: float | None = None,
         below: float | None = None, at_most: float | None = None, hint: str = "") -> float:
    """Return ``value`` as a finite float within the bounds, or raise naming ``name``."""
    plain = value.item() if isinstance(value, (np.ndarray, np.generic)) and value.ndim == 0 else value
    refused = isinstance(plain, (*TEXTS, bool)) or getattr(plain, "ndim", 0) != 0 or np.ma.is_masked(value)
    try:
        number = None if refused else float(plain)
    except OverflowError:
        number, hint = np.inf, hint or "too large for a number"
    except (TypeError, ValueError):
        number = None
    if number is None:
        raise TypeError(f"`{name}` must be a number, got {shown(value)}{_after(hint)}")
    rules = [("finite", np.isfinite(number))]
    rules += [(f"> {above:g}", number > above)] if above is not None else []
    rules += [(f">= {at_least:g}", number >= at_least)] if at_least is not None else []
    rules += [(f"< {below:g}", number < below)] if below is not None else []
    rules += [(f"<= {at_most:g}", number <= at_most)] if at_most is not None else []
    if not all(kept for _, kept in rules):
        raise ValueError(f"`{name}` must be {' and '.join(rule for rule, _ in rules)}, got {shown(value)}{_after(hint)}")
    return number


def whole(value: Any, name: str, *, at_least: int, at_most: int = MOST, hint: str = "") -> int:
    """Return ``value`` as an int within the bounds, or raise naming ``name``."""
    if isinstance(value, bool) or not isinstance(value, (int, np.integer)):
        raise TypeError(f"`{name}` must be a whole number, got {shown(value)}{_after(hint)}")
    if value < at_least:
        raise ValueError(f"`{name}` must be >= {at_least}, got {shown(value)}{_after(hint)}")
    if value > at_most:
        raise ValueError(f"`{name}` must be <= {at_most}, got {shown(value)}{_after(hint)}")
    return int(value)


def flag(value: Any, name: str) -> bool:
    """Return ``value`` if it is True or False, or raise naming ``name``: texts such as "no" would count as true."""
    if not isinstance(value, (bool, np.bool_)):
        raise TypeError(f"`{name}` must be True or False, got {shown(value)}")
    return bool(value)


def floats(value: Any, name: str) -> np.ndarray:
    """Return ``value`` as a new float array, finite or not, or raise naming ``name``; texts, flags and gaps are no numbers."""
    try:
        given = np.asanyarray(value)
    except (TypeError, ValueError) as error:  # rows of different lengths, or an object that refuses
        raise TypeError(f"`{name}` must be an array of numbers, got {shown(value)}: {error}") from None
    if np.ma.is_masked(given):
        raise TypeError(f"`{name}` must be an array of numbers without masked entries, got {shown(value)}")
    if given.dtype.kind == "O" and all(isinstance(item, Real) and not isinstance(item, bool) for item in given.flat):
        try:
            return np.array(given, dtype=float)
        except OverflowError:
            raise ValueError(f"`{name}` must be finite, got {shown(value)}: it is too large for a number") from None
    if given.dtype.kind not in "iuf":
        raise TypeError(f"`{name}` must be an array of numbers, got {shown(value)}")
    return np.array(given, dtype=float, subok=False)


def array(value: Any, name: str, shape: tuple[int, ...] | None = None) -> np.ndarray:
    """Return ``value`` as a new float array, finite and of the given shape, or raise naming ``name``."""
    result = floats(value, name)
    if shape is not None and result.shape != shape:
        raise ValueError(f"`{name}` must have shape {shape}, got {result.shape}")
    if not np.isfinite(result).all():
        where = tuple(int(i) for i in np.argwhere(~np.isfinite(result))[0])
        raise ValueError(f"`{name}` must be finite, got {result[where]} at index {where}")
    return result


def per_axis(value: Any, name: str, each: Callable[..., Any], hint: str, **rules: Any) -> Any:
    """Return a number, or one number for each of two axes, checked by ``each``."""
    if not isinstance(value, (tuple, list)) or len(value) != 2:
        return each(value, name, hint=f"{hint}, or a pair (x, y) for a grid with two axes", **rules)
    return tuple(each(item, f"{name}[{k}]", hint=hint, **rules) for k, item in enumerate(value))


def is_single(value: Any) -> bool:
    """Whether a value is a single number, valid or not, rather than an array."""
    return not isinstance(value, (list, tuple)) and getattr(value, "ndim", 0) == 0


def row(value: Any, name: str) -> tuple[float, ...]:
    """Return a number, or an array of any shape, as finite floats in a row, not empty, or raise naming ``name``."""
    result = array(value, name)
    if not result.size:
        raise ValueError(f"`{name}` must be a number or a list of numbers, not empty, got {shown(value)}")
    return tuple(result.ravel().tolist())


def interval(value: Any, name: str) -> tuple[float, float]:
    """Return ``value`` as a pair of floats, lower < upper, or raise naming ``name``."""
    if not isinstance(value, (tuple, list, np.ndarray)) or getattr(value, "ndim", 1) != 1 or len(value) != 2:
        raise ValueError(f"`{name}` must be a pair (lower, upper), got {shown(value)}")
    lower = real(value[0], f"{name}[0]")
    return lower, real(value[1], f"{name}[1]", above=lower)


def instance(value: Any, name: str, kind: type, hint: str = "") -> Any:
    """Return ``value`` if it is an instance of ``kind``, or raise naming ``name``."""
    if isinstance(value, kind):
        return value
    if isinstance(value, type) and issubclass(value, kind):
        raise TypeError(f"`{name}` must be an instance of {kind.__name__}, got the class {value.__name__}: "
                        f"write {value.__name__}()")
    raise TypeError(f"`{name}` must be an instance of {kind.__name__}, got {shown(value)}{_after(hint)}")


def function(value: Any, name: str, hint: str) -> Any:
    """Return ``value`` if it can be called, or raise naming ``name``; ``hint`` says with what it is called."""
    if not callable(value):
        raise TypeError(f"`{name}` must be a function {hint}, got {shown(value)}")
    return value


def mapping(value: Any, name: str, example: str) -> Mapping[Any, Any]:
    """Return ``value`` if it is a mapping, or raise naming ``name``."""
    if not isinstance(value, Mapping):
        raise TypeError(f"`{name}` must be a mapping such as {example}, got {shown(value)}")
    return value


def text(value: Any, name: str) -> str:
    """Return ``value`` if it is a text, or raise naming ``name``."""
    if not isinstance(value, str):
        raise TypeError(f"`{name}` must be a text, got {shown(value)}")
    return value


def file(value: Any, name: str) -> Path:
    """Return ``value`` as a path, or raise naming ``name``."""
    if not isinstance(value, (str, PathLike)) or isinstance(fspath(value), bytes):
        raise TypeError(f"`{name}` must be the path of a file, a text or a pathlib.Path, got {shown(value)}")
    if not fspath(value) or "\0" in fspath(value):
        raise ValueError(f"`{name}` must be the path of a file, got {shown(value)}")
    return Path(value)


def listed(value: Any, name: str, example: str) -> list[Any]:
    """Return the items of a list, or raise naming ``name``; a text is none."""
    if isinstance(value, (*TEXTS, Mapping)) or not isinstance(value, Iterable) or getattr(value, "ndim", 1) == 0:
        raise TypeError(f"`{name}` must be a list such as {example}, got {shown(value)}")
    return list(value)


def series(value: Any, name: str, example: str) -> np.ndarray:
    """Return numbers in a row as a float array (n,), n > 0, finite, or raise naming ``name``."""
    result = array(value if hasattr(value, "ndim") and not is_single(value) else listed(value, name, example), name)
    if result.ndim != 1 or not result.size:
        raise ValueError(f"`{name}` must be a list of numbers such as {example}, not empty, got {shown(value)}")
    return result


def choice(value: Any, name: str, known: Iterable[Any]) -> Any:
    """Return ``value`` if it is one of ``known``, or raise with the list and the nearest match."""
    options = list(known)
    if np.isscalar(value) and not isinstance(value, (bool, np.bool_)) and value in options:
        return value
    near = isinstance(value, str) and len(value) <= LONGEST
    nearest = get_close_matches(value, [str(option) for option in options], n=1) if near else []
    meant = f", did you mean {nearest[0]}?" if nearest else ""
    if len(options) > MANY:  # what was given comes first: the list may be cut
        raise ValueError(f"`{name}` must be a known name, got {shown(value)}{meant or ';'} known: {', '.join(map(str, options))}")
    raise ValueError(f"`{name}` must be one of {', '.join(map(str, options))}; got {shown(value)}{meant}")


def field(check: Callable[..., Any], default: Any = attrs.NOTHING, *, optional: bool = False, kw_only: bool = False,
          repr: bool = True, eq: Any = None, **rules: Any) -> Any:
    """Declare a field that is ``check(value, its name, **rules)``; where it is ``optional``, None stays."""
    return attrs.field(default=default, kw_only=kw_only, repr=repr, eq=eq, converter=attrs.Converter(
        lambda value, field: None if optional and value is None else check(value, field.name, **rules), takes_field=True))


def number(default: Any = attrs.NOTHING, *, hint: str = "", **bounds: Any) -> Any:
    """Declare a float field, validated against the bounds of `real`."""
    return field(real, default, hint=hint, **bounds)


def integer(default: Any = attrs.NOTHING, *, at_least: int, hint: str = "", kw_only: bool = False) -> Any:
    """Declare an int field, validated against the bounds of `whole`."""
    return field(whole, default, kw_only=kw_only, at_least=at_least, hint=hint)


def switch(default: bool) -> Any:
    """Declare a field that is True or False."""
    return field(flag, default)


def words(default: str) -> Any:
    """Declare a field that is a text."""
    return field(text, default)


def optional_number(*, hint: str = "", **bounds: Any) -> Any:
    """Declare a float field that may be None, its default."""
    return field(real, None, optional=True, hint=hint, **bounds)


def _after(hint: str) -> str:
    return f" ({hint})" if hint else ""


def library(name: str, what: str, extra: str) -> Any:
    """Return the module ``name``, which ``what`` needs, or raise ImportError naming the extra of fvkit that installs it."""
    try:
        return import_module(name)
    except ImportError:
        raise ImportError(f"{what} needs {name}: pip install 'fvkit[{extra}]'") from None


def physical() -> float:
    """Return the memory of this machine, bytes; infinite where the system does not report it."""
    try:
        return float(os.sysconf("SC_PHYS_PAGES") * os.sysconf("SC_PAGE_SIZE"))
    except (AttributeError, ValueError, OSError):  # not on every system
        return float("inf")


def cores() -> int:
    """Return how many processor cores this process may use."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


def users_line() -> int:
    """Return the ``stacklevel`` of a warning that points to the first caller outside of fvkit and its plug-ins."""
    frame, level = sys._getframe(1), 1
    while frame.f_back is not None and frame.f_globals.get("__name__", "fvkit").startswith(("fvkit", "attr")):
        frame, level = frame.f_back, level + 1
    return level


def fits_memory(count: int, floats: int, name: str) -> None:
    """Raise ValueError where ``count`` items of so many floats, requested by the argument ``name``, exceed the memory."""
    needed, there = 8.0 * floats * count, physical()
    if needed > there:
        raise ValueError(f"`{name}` must fit into memory: {count} need about {needed / 1e9:.3g} GB, this machine has "
                         f"{there / 1e9:.3g} GB")


class Portable:
    """Exception that pickling and copying keep whatever its ``__init__`` takes: it is made again of ``args`` and attributes.

    Python's own way calls the class with ``args``, and an error in unpickling loses every result of a pool of processes.
    """

    args: tuple[Any, ...]

    def __reduce__(self) -> tuple[Any, ...]:
        return copyreg.__newobj__, (type(self), *self.args), self.__dict__  # type: ignore[attr-defined]  # as pickle does it
