"""`Part`: what every pluggable piece (model, solver, limiter, boundary, source) has in common."""

import re
from collections.abc import Iterable, Mapping
from functools import wraps
from inspect import get_annotations
from math import nan
from typing import Any, ClassVar

import attrs
import numpy as np

#: Types of the fields that are parameters of pointwise code.
_NUMBERS = (float, int, float | None, "float", "int", "float | None")


@attrs.frozen
class Part:
    """A frozen attrs class whose float fields are its parameters and whose methods are pointwise.

    Subclasses are abstract or final. Decorate yours with ``@attrs.frozen`` when it has parameters,
    and annotate each with ``float``: pointwise methods see these, their class and nothing else through ``self``.
    ``questions`` are the methods that other parts call, see `fvkit.problem.questions`.
    """

    #: Works to cite for results that the part has made, `fvkit.output.citation.Work`.
    cite: ClassVar[tuple[Any, ...]] = ()
    questions: ClassVar[tuple[Any, ...]] = ()

    def __new__(cls, *arguments: Any, **named: Any) -> Any:
        mine = {} if "__attrs_attrs__" in vars(cls) else get_annotations(cls)
        lost = [name for name, kind in mine.items() if kind in _NUMBERS]
        if lost:
            raise TypeError(f"{cls.__name__} has parameters ({', '.join(lost)}) but no decorator: write @attrs.frozen above it")
        return super().__new__(cls)

    @classmethod
    def parameter_names(cls) -> tuple[str, ...]:
        """Names of the numeric fields, in order."""
        fields: Any = attrs.fields(cls)
        return tuple(field.name for field in fields if field.type in _NUMBERS)

    def parameters(self) -> tuple[float, ...]:
        """Values of the numeric fields, in order; NaN for one that is left open (None) or varies, see `fvkit.problem.fields`."""
        return tuple(float(value) if isinstance(value, (float, int, np.number)) else nan
                     for value in map(self.__getattribute__, self.parameter_names()))

    def varying(self) -> tuple[tuple[str, bool], ...]:
        """Return the names of the fields that vary over the grid, and of each whether it has a row for every component of q."""
        return ()

    @classmethod
    def defines(cls, name: str) -> bool:
        """Whether this class answers ``name`` itself instead of leaving the default of its abstract base."""
        mine = getattr(cls, name, None)
        return mine is not None and not getattr(mine, "is_default", False)


def seen_as(part: Any, values: Mapping[str, Any]) -> Any:
    """Return a copy of a part with some of its fields replaced; no converter is called."""
    result: Any = object.__new__(type(part))
    for field in attrs.fields(type(part)):
        object.__setattr__(result, field.name, values[field.name] if field.name in values else getattr(part, field.name))
    return result


@attrs.frozen
class Wrapper:
    """A part seen through another: what a subclass does not answer itself, the part answers.

    Its numbers are those of the part, and so is what it `Part.defines`; a subclass that answers more says so.
    """

    part: Any

    def __getattr__(self, name: str) -> Any:
        if name.startswith("__") or name == "part":
            raise AttributeError(name)
        return getattr(self.part, name)

    def __repr__(self) -> str:
        return repr(self.part)


def unwrapped(part: Any) -> Any:
    """Return a part itself, of a `Wrapper` that which it wraps."""
    return unwrapped(part.part) if isinstance(part, Wrapper) else part


def default(method: Any) -> Any:
    """Mark a method of an abstract base as a default, which `Part.defines` does not count as defined."""
    method.is_default = True
    return method


def optional(method: Any) -> Any:
    """Mark a method of an abstract base that has no body as a default: nobody calls it where it is not defined."""
    @wraps(method)
    def missing(self: Any, *arguments: Any) -> Any:
        raise NotImplementedError(f"{type(self).__name__} defines no `{method.__name__}`")

    return default(missing)


def public_name(part: Any) -> str:
    """Return the name of a part (instance or class); a tuple of parts joins theirs with ``+``."""
    if isinstance(part, tuple):
        return "+".join(dict.fromkeys(public_name(item) for item in part)) if len(set(part)) == 1 else \
            "+".join(public_name(item) for item in part)
    kind = part if isinstance(part, type) else type(part)
    named = vars(kind).get("name")
    return named if isinstance(named, str) else re.sub(r"(?<=[a-z])(?=[A-Z])", "-", kind.__name__).lower()


def by_name(kinds: Iterable[type]) -> dict[str, type]:
    """Return {public name: class}."""
    return {public_name(kind): kind for kind in kinds}
