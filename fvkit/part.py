"""`Part`: what every pluggable piece (model, solver, limiter, boundary, source) has in common."""

from typing import Any

import attrs


@attrs.frozen
class Part:
    """A frozen attrs class whose float fields are its parameters and whose methods are pointwise.

    Subclasses are abstract or final. Decorate yours with ``@attrs.frozen`` when it has parameters,
    and annotate each with ``float``: pointwise methods see these, and nothing else, through ``self``.
    """

    @classmethod
    def parameter_names(cls) -> tuple[str, ...]:
        """Names of the numeric fields, in order."""
        fields: Any = attrs.fields(cls)
        return tuple(field.name for field in fields if field.type in (float, int, "float", "int"))

    def parameters(self) -> tuple[float, ...]:
        """Values of the numeric fields, in order."""
        return tuple(float(getattr(self, name)) for name in self.parameter_names())

    @classmethod
    def defines(cls, name: str) -> bool:
        """Whether this class answers ``name`` itself instead of leaving the default of its abstract base."""
        mine = getattr(cls, name, None)
        return mine is not None and not getattr(mine, "is_default", False)


def default(method: Any) -> Any:
    """Mark a method of an abstract base as the default, so that `Part.defines` can tell."""
    method.is_default = True
    return method
