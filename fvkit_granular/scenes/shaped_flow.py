"""`ShapedFlow`: the initial flow of a scene, made of shapes."""

from typing import Any

import attrs
import numpy as np

from fvkit import validation
from fvkit_granular.models.quantities import velocities
from fvkit_granular.scenes.shapes import NONE, as_shape


def _ground(value: Any, name: str) -> Any:
    is_function = callable(value) and not isinstance(value, type)
    return value if is_function else validation.real(value, name, hint="a number or a function of x")


@attrs.frozen
class ShapedFlow:
    """A function x -> {h, phi, vs, vf} made of shapes and numbers, as `Scene` takes it for ``initial``.

    Parameters
    ----------
    h : depth, m, >= 0; or None where ``surface`` is given.
    phi : solid fraction in [0, 1].
    vs, vf : velocities of solid and fluid, m/s, on one axis.
    surface : level of the surface, m: the depth is max(surface - bottom, 0), levelled in each cell, see `Scene`.
    bottom : height of the bottom below ``surface``, m: a number or a function of x; None for that of the scene.
    vs_x, vs_y, vf_x, vf_y : velocities with two axes, m/s, where ``vs`` and ``vf`` have no meaning.

    Examples
    --------
    >>> import fvkit_granular as gr
    >>> import numpy as np
    >>> flow = gr.ShapedFlow(h=gr.shapes.Hump(centre=5.0, half_width=2.0, height=1.0), phi=0.6)
    >>> flow(np.array([5.0, 9.0]))["h"].tolist()
    [1.0, 0.0]
    """

    h: Any = validation.field(as_shape, None, optional=True)
    phi: Any = validation.field(as_shape, None, optional=True, kw_only=True)
    vs: Any = validation.field(as_shape, NONE, kw_only=True)
    vf: Any = validation.field(as_shape, NONE, kw_only=True)
    surface: Any = validation.field(as_shape, None, optional=True, kw_only=True)
    bottom: Any = validation.field(_ground, None, optional=True, kw_only=True)
    vs_x: Any = validation.field(as_shape, NONE, kw_only=True, repr=False)
    vs_y: Any = validation.field(as_shape, NONE, kw_only=True, repr=False)
    vf_x: Any = validation.field(as_shape, NONE, kw_only=True, repr=False)
    vf_y: Any = validation.field(as_shape, NONE, kw_only=True, repr=False)

    def __attrs_post_init__(self) -> None:
        if (self.h is None) == (self.surface is None):
            raise ValueError("a flow of shapes takes either `h`, the depth, or `surface`, its level: give one of them")
        if self.phi is None:
            raise ValueError("a flow of shapes needs `phi`, the solid fraction")

    def __call__(self, *places: np.ndarray) -> dict[str, np.ndarray]:
        moving, others = (velocities(axes) for axes in (len(places), 3 - len(places)))
        for name in others:
            if getattr(self, name) != NONE:
                known = "two axes, got one with one" if len(places) == 1 else "one axis, got one with two"
                raise ValueError(f"`{name}` of a flow of shapes is for a scene with {known}: give {', '.join(moving)}")
        flow = {name: getattr(self, name)(*places) for name in ("phi", *moving)}
        if self.surface is not None:
            flow["surface"] = self.surface(*places)
        return flow if self.surface is not None and self.bottom is None else {"h": self.depth(*places)} | flow

    def depth(self, *places: np.ndarray) -> np.ndarray:
        """Return the depth h at points x, or x and y, m; ValueError for a ``surface`` without a bottom."""
        if self.surface is None:
            return self.h(*places)
        if self.bottom is None:
            raise ValueError("a flow of shapes with `surface` and no `bottom` has no depth: use `Scene.flow`")
        return np.maximum(self.surface(*places) - (self.bottom(*places) if callable(self.bottom) else self.bottom), 0.0)
