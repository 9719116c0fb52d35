"""`ShapedFlow`: an initial state made of shapes."""

from typing import Any

import attrs
import numpy as np

from fvkit import _validate
from fvkit_granular.shapes import Shape, Uniform, as_shape

#: No velocity.
NONE = Uniform(0.0)


#: Converters of the fields: a number becomes the uniform shape, and an error names the field.
_SHAPE: Any = attrs.Converter(lambda value, field: as_shape(value, field.name), takes_field=True)
_OPTIONAL: Any = attrs.Converter(lambda value, field: None if value is None else as_shape(value, field.name), takes_field=True)
_GROUND: Any = attrs.Converter(lambda value, field: value if value is None or (callable(value) and not isinstance(value, type))
                               else _validate.real(value, field.name, hint="a number or a function of x"), takes_field=True)


@attrs.frozen
class ShapedFlow:
    """A function x -> {h, phi, vs, vf} made of shapes and numbers, as `Scene` takes it for ``initial``.

    Parameters
    ----------
    h : depth, m, >= 0; or None where ``surface`` is given.
    phi : solid fraction in [0, 1].
    vs, vf : velocities of solid and fluid, m/s.
    surface : level of the surface, m: the depth is max(surface - bottom, 0), levelled in each cell, see `Scene`.
    bottom : height of the bottom below ``surface``, m: a number or a function of x; None for that of the scene.
    """

    h: Shape | None = attrs.field(default=None, converter=_OPTIONAL)  # type: ignore[misc]
    phi: Shape = attrs.field(default=None, converter=_OPTIONAL, kw_only=True)  # type: ignore[misc]
    vs: Shape = attrs.field(default=NONE, converter=_SHAPE, kw_only=True)  # type: ignore[misc]
    vf: Shape = attrs.field(default=NONE, converter=_SHAPE, kw_only=True)  # type: ignore[misc]
    surface: Shape | None = attrs.field(default=None, converter=_OPTIONAL, kw_only=True)  # type: ignore[misc]
    bottom: Any = attrs.field(default=None, converter=_GROUND, kw_only=True)  # type: ignore[misc]

    def __attrs_post_init__(self) -> None:
        if (self.h is None) == (self.surface is None):
            raise ValueError("a flow of shapes takes either `h`, the depth, or `surface`, its level: give one of them")
        if self.phi is None:
            raise ValueError("a flow of shapes needs `phi`, the solid fraction")

    def __call__(self, x: np.ndarray) -> dict[str, np.ndarray]:
        flow = {"phi": self.phi(x), "vs": self.vs(x), "vf": self.vf(x)}
        if self.surface is not None:
            flow["surface"] = self.surface(x)
        return flow if self.surface is not None and self.bottom is None else {"h": self.depth(x)} | flow

    def depth(self, x: np.ndarray) -> np.ndarray:
        """Return the depth h at points ``x``, m; ValueError where only the scene knows the bottom."""
        if self.surface is None:
            return self.h(x)  # type: ignore[misc]
        if self.bottom is None:
            raise ValueError("a flow of shapes with `surface` and no `bottom` has no depth of its own: ask `Scene.flow`")
        return np.maximum(self.surface(x) - (self.bottom(x) if callable(self.bottom) else self.bottom), 0.0)
