"""Built-in scenes by name; all of them have the equations for mild slopes, as their references and sources do."""

from collections.abc import Callable
from functools import wraps
from typing import Any

import attrs

from fvkit.validation import choice
from fvkit_granular.scenes.library.dry_and_extreme import HARD_SCENES
from fvkit_granular.scenes.library.friction import FRICTION_SCENES
from fvkit_granular.scenes.library.model_differences import MODEL_SCENES
from fvkit_granular.scenes.library.plane import PLANE_SCENES
from fvkit_granular.scenes.library.riemann import dam_break, dam_break_phi, perturbed_rest, phi_jump, rest, riemann, simple_wave
from fvkit_granular.scenes.library.steady_flow import MOVING_SCENES
from fvkit_granular.scenes.scene import Scene


def scene_names() -> tuple[str, ...]:
    """Names of the built-in scenes.

    Examples
    --------
    >>> import fvkit_granular as gr
    >>> gr.scene_names()[:3]
    ('riemann', 'dam-break-phi', 'phi-jump')
    """
    return tuple(_SCENES)


def scene(name: str) -> Scene:
    """Return a built-in scene.

    Parameters
    ----------
    name : one of `scene_names`.

    Raises
    ------
    ValueError
        For an unknown name, with the list and the nearest match.

    Examples
    --------
    >>> import fvkit_granular as gr
    >>> gr.scene("dam-break").interval
    (-5.0, 5.0)
    """
    return scene_factory(name)()


def scene_factory(name: str) -> Callable[..., Scene]:
    """Return the function that makes the built-in scene ``name``; its arguments, if any, are those of the scene."""
    made = _SCENES[choice(name, "scene", _SCENES)]

    @wraps(made)
    def mild(*arguments: Any, **named: Any) -> Scene:
        return attrs.evolve(made(*arguments, **named), slope="mild")

    return mild


_SCENES: dict[str, Callable[..., Scene]] = {
    "riemann": riemann, "dam-break-phi": dam_break_phi, "phi-jump": phi_jump, "dam-break": dam_break,
    "simple-wave": simple_wave, "rest": rest, "perturbed-rest": perturbed_rest,
} | HARD_SCENES | MODEL_SCENES | FRICTION_SCENES | MOVING_SCENES | PLANE_SCENES
