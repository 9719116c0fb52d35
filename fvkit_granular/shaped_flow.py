"""`ShapedFlow`: an initial state made of shapes."""

from typing import Any

import attrs
import numpy as np

from fvkit_granular.shapes import Shape, Uniform, as_shape

#: No velocity.
NONE = Uniform(0.0)


def _shape(value: Any) -> Shape | None:
    return None if value is None else as_shape(value)


@attrs.frozen
class ShapedFlow:
    """A function x -> {h, phi, vs, vf} made of shapes and numbers, as `Scene` takes it for ``initial``.

    Parameters
    ----------
    h : depth, m, >= 0; or None where ``surface`` is given.
    phi : solid fraction in [0, 1].
    vs, vf : velocities of solid and fluid, m/s.
    surface : level of the surface, m: the depth is max(surface - bottom, 0).
    bottom : height of the bottom below ``surface``, m: a number or a function of x, the one of the scene.
    """

    h: Shape | None = attrs.field(default=None, converter=_shape)
    phi: Shape = attrs.field(default=None, converter=_shape, kw_only=True)
    vs: Shape = attrs.field(default=NONE, converter=as_shape, kw_only=True)
    vf: Shape = attrs.field(default=NONE, converter=as_shape, kw_only=True)
    surface: Shape | None = attrs.field(default=None, converter=_shape, kw_only=True)
    bottom: Any = attrs.field(default=0.0, kw_only=True)

    def __attrs_post_init__(self) -> None:
        if (self.h is None) == (self.surface is None):
            raise ValueError("a flow of shapes takes either `h`, the depth, or `surface`, its level: give one of them")
        if self.phi is None:
            raise ValueError("a flow of shapes needs `phi`, the solid fraction")

    def __call__(self, x: np.ndarray) -> dict[str, np.ndarray]:
        return {"h": self.depth(x), "phi": self.phi(x), "vs": self.vs(x), "vf": self.vf(x)}

    def depth(self, x: np.ndarray) -> np.ndarray:
        """Return the depth h at points ``x``, m."""
        if self.surface is None:
            return self.h(x)  # type: ignore[misc]
        return np.maximum(self.surface(x) - (self.bottom(x) if callable(self.bottom) else self.bottom), 0.0)
