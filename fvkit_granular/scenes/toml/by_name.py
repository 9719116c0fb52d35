"""Parts of built-in scenes by name: how a scene file speaks of an initial state, a bottom or a reference that is computed."""

from collections.abc import Callable
from functools import lru_cache
from typing import Any

import attrs
import numpy as np

from fvkit.validation import choice, field
from fvkit_granular.models.quantities import flow_names
from fvkit_granular.scenes.library.catalogue import scene, scene_names
from fvkit_granular.scenes.reference import Reference
from fvkit_granular.scenes.scene import Scene

#: Points at which two scenes are compared.
POINTS = 1001

_made = lru_cache(maxsize=8)(scene)


@attrs.frozen
class OfBuiltIn:
    """A part of the built-in scene of a name."""

    name: str = field(choice, known=scene_names())


class BuiltInFlow(OfBuiltIn):
    """The initial state of a built-in scene, a function of x, or of x and y."""

    def __call__(self, *places: np.ndarray) -> Any:
        return _made(self.name).initial(*_all(self.name, places))


class BuiltInBottom(OfBuiltIn):
    """The bottom of a built-in scene, a function of x, or of x and y."""

    def __call__(self, *places: np.ndarray) -> Any:
        return height(_made(self.name), *_all(self.name, places))


def _all(name: str, places: tuple[np.ndarray, ...]) -> tuple[np.ndarray, ...]:
    """The places, as many as the built-in scene has axes; ValueError for others."""
    axes = _made(name).axes
    if len(axes) != len(places):
        raise ValueError(f"the built-in scene {name} has the axes {' and '.join(axes)}, and this one {len(places)}: take "
                         "another, or its `interval`")
    return places


class BuiltInReference(OfBuiltIn):
    """The reference of a built-in scene, for a scene that is the same flow up to the same time or an earlier one."""

    def __call__(self, scene: Scene) -> Reference:
        """Return the reference, unless the scene is another flow, of which the built-in solution says nothing."""
        given = self.check(scene)
        return given if isinstance(given, Reference) else given(scene)

    def check(self, scene: Scene) -> Reference | Callable[[Scene], Reference]:
        """Return the reference of the built-in scene, or raise ValueError where it does not hold for ``scene``."""
        built_in = _made(self.name)
        if built_in.reference is None:
            raise ValueError(f"the built-in scene {self.name} has no reference: leave `reference` out")
        changed = differences(scene, built_in)
        if scene.t_end > built_in.t_end:
            changed.append("t_end")
        if changed:
            raise ValueError(f"`reference` is the solution of {self.name}, and this is another flow: {', '.join(changed)} "
                             f"{'differs' if len(changed) == 1 else 'differ'}; leave `reference` out")
        return built_in.reference


def differences(one: Scene, other: Scene) -> list[str]:
    """Return which parts of the physics of two scenes differ, judged at ``POINTS`` points; times and names do not count."""
    found = [name for name in ("interval", "g", "gamma", "boundary", "sources") if getattr(one, name) != getattr(other, name)]
    if "interval" not in found:
        places = one.sampled(POINTS)
        found += [] if np.array_equal(height(one, *places), height(other, *places)) else ["bottom"]
        found += [] if np.array_equal(_states(one, places), _states(other, places)) else ["initial"]
    return found


def _states(scene: Scene, places: tuple[np.ndarray, ...]) -> np.ndarray:
    given = scene.flow(*places)
    return np.array([np.broadcast_to(given[name], places[0].shape) for name in flow_names(len(places))])


def height(scene: Scene, *places: np.ndarray) -> np.ndarray:
    """Return the bottom of a scene at points x, or x and y, m; a ValueError for cell averages, which belong to one grid."""
    if not callable(scene.bottom) and np.ndim(scene.bottom):
        raise ValueError("a bottom given as cell averages belongs to one grid: give a function, a shape or a number")
    return scene.height(*places)
