"""Scenes as TOML text for `load_scene`, to the bit."""

import re
from collections.abc import Mapping
from typing import Any

import attrs
import numpy as np

from fvkit import Along
from fvkit.problem.problem import SIDES as ENDS
from fvkit.validation import instance, shown
from fvkit_granular.scenes.library.catalogue import scene as built_in_scene
from fvkit_granular.scenes.library.catalogue import scene_names
from fvkit_granular.scenes.profile import Profile
from fvkit_granular.scenes.scene import Scene
from fvkit_granular.scenes.shaped_flow import ShapedFlow
from fvkit_granular.scenes.shapes import NONE, SHAPES, Shape, Sum, Uniform
from fvkit_granular.scenes.toml.by_name import BuiltInBottom, BuiltInFlow, BuiltInReference, differences
from fvkit_granular.scenes.toml.read import ALL_SIDES, ALONG, BOUNDARIES, FLOW, SOURCES, WATCH
from fvkit_granular.scenes.watch import Watch


def scene_text(scene: Scene) -> str:
    """Return the TOML text of a scene, which `load_scene` turns into the same scene, to the bit.

    Shapes, columns of CSV files (named by their absolute path), boundary conditions and sources by name are written as such. What
    is a function in a built-in scene is written as the name of that scene.

    Raises
    ------
    ValueError
        For values that no file can contain: functions and user-defined parts.

    Examples
    --------
    >>> import fvkit_granular as gr
    >>> print(gr.scene_text(gr.scene("dam-break")).splitlines()[0])
    name = "dam-break"
    """
    instance(scene, "scene", Scene, "such as gr.scene('riemann')")
    lines = [f"{key} = {_value(value)}" for key, value in (
        ("name", scene.name), ("description", scene.description), ("interval", scene.interval), ("t_end", scene.t_end),
        ("g", scene.g), ("gamma", scene.gamma), ("slope", scene.slope)) if value not in ("", "auto")]
    same = _same_as_built_in(scene)
    if scene.reference is not None:
        lines.append(f"reference = {_value(_reference(scene))}")
    bottom = _bottom(scene, same)
    if bottom:
        lines.append(f"bottom = {bottom}")
    lines += ["", "[initial]", *_initial(scene, same)]
    every, names = ("both", ENDS) if len(scene.axes) == 1 else ("all", ALL_SIDES)
    same_all = all(side == scene.boundary[0] for side in scene.boundary)
    sides = {every: scene.boundary[0]} if same_all else dict(zip(names, scene.boundary, strict=True))
    lines += ["", "[boundary]", *(f"{key} = {_side(side)}" for key, side in sides.items())]
    for source in scene.sources:
        lines += ["", "[[sources]]", *_lines(_part(source, "type", SOURCES))]
    asked = {"times": scene.times, **{key: getattr(scene.watch, key) for key in WATCH}}
    outputs = {key: _value(value) for key, value in asked.items() if value not in (None, getattr(Watch(), key, None))}
    if outputs:
        lines += ["", "[outputs]", *_lines(outputs)]
    return "\n".join(lines) + "\n"


def _same_as_built_in(scene: Scene) -> set[str]:
    """Which of initial state and bottom are those of the built-in scene of the same name."""
    if scene.name not in scene_names():
        return set()
    changed = set(differences(scene, built_in_scene(scene.name)))
    return set() if "interval" in changed else {"initial", "bottom"} - changed


def _reference(scene: Scene) -> str:
    if isinstance(scene.reference, BuiltInReference):
        return scene.reference.name
    if scene.name not in scene_names():
        raise ValueError("`reference` can be written for built-in scenes alone: take it off, attrs.evolve(scene, reference=None)")
    BuiltInReference(scene.name).check(scene)
    return scene.name


def _initial(scene: Scene, same: set[str]) -> list[str]:
    flow: Any = scene.initial
    if isinstance(flow, BuiltInFlow):
        return [f"flow = {_value(flow.name)}"]
    if not isinstance(flow, ShapedFlow):
        return [f"flow = {_value(_known(scene, 'initial', same))}"]
    if flow.surface is not None and flow.bottom is not None and flow.bottom != scene.bottom:
        raise ValueError("`surface` of the initial state lies over another bottom than that of the scene: no file can say that")
    parts = {key: getattr(flow, key) for key in FLOW}
    return [f"{key} = {_shape(shape)}" for key, shape in parts.items()
            if shape is not None and not (FLOW[key] == "speed" and shape == NONE)]


def _bottom(scene: Scene, same: set[str]) -> str:
    """The bottom, nothing where it is 0."""
    bottom = scene.bottom
    if isinstance(bottom, Shape):
        # A uniform shape and a number are averaged over cells in different ways: the last bit may differ.
        return f"[{_value(bottom.value)}]" if isinstance(bottom, Uniform) else _shape(bottom)
    if callable(bottom):
        return _inline({"from": _value(bottom.name if isinstance(bottom, BuiltInBottom) else _known(scene, "bottom", same))})
    if np.ndim(bottom):
        raise ValueError("a bottom given as cell averages belongs to one grid, and no file can hold it: give a shape")
    return "" if bottom == 0.0 else _value(bottom)


def _known(scene: Scene, part: str, same: set[str]) -> str:
    if part not in same:
        raise ValueError(f"`{part}` is a function, which no file can hold: make it of shapes (gr.shapes), or of a CSV file "
                         "(gr.Profile.read)")
    return scene.name


def _side(side: Any) -> str:
    if isinstance(side, Along):
        return _inline({"type": _value(ALONG), "lower": _value(side.lower), "upper": _value(side.upper),
                        "condition": _side(side.condition), "otherwise": _side(side.otherwise)})
    entries = _part(side, "type", BOUNDARIES)
    return entries["type"] if len(entries) == 1 else _inline(entries)


def _shape(shape: Shape) -> str:
    if isinstance(shape, Uniform):
        return _value(shape.value)
    if isinstance(shape, Sum):
        return f"[{', '.join(_shape(term) for term in shape.terms)}]"
    return _inline(_entries(shape))


def _entries(shape: Shape) -> dict[str, str]:
    if isinstance(shape, Profile):
        return {"file": _value(shape.path.resolve().as_posix()), "column": _value(shape.column), "along": _value(shape.along),
                "interpolation": _value(shape.interpolation)} | ({} if shape.over is None else {"over": _value(shape.over)})
    return _part(shape, "shape", SHAPES)


def _part(part: Any, word: str, kinds: Mapping[str, type]) -> dict[str, str]:
    """The name and the fields of a part as keys and values of TOML."""
    kind: Any = type(part)
    for name, known in kinds.items():
        if kind is known:
            fields = {field.alias: getattr(part, field.name) for field in attrs.fields(kind) if field.init}
            return {word: _value(name), **{key: _value(value) for key, value in fields.items() if value is not None}}
    raise ValueError(f"{kind.__name__} has no name in scene files: known are {', '.join(kinds)}")


def _lines(entries: Mapping[str, str]) -> list[str]:
    return [f"{key} = {value}" for key, value in entries.items()]


def _inline(entries: Mapping[str, str]) -> str:
    return "{" + ", ".join(_lines(entries)) + "}"


def _value(value: Any) -> str:
    """A text, a number, or a list or table of them in TOML; numbers to the bit."""
    if isinstance(value, str):
        plain = value.replace("\\", "\\\\").replace('"', '\\"')
        return '"' + re.sub(r"[\x00-\x1f\x7f]", lambda found: f"\\u{ord(found[0]):04x}", plain) + '"'
    if isinstance(value, (tuple, list)):
        return f"[{', '.join(_value(item) for item in value)}]"
    if isinstance(value, dict):
        return _inline({_value(key): _value(item) for key, item in value.items()})
    if isinstance(value, (int, float, np.number)) and not isinstance(value, bool):
        return repr(float(value))
    raise ValueError(f"{shown(value)} has no form in a scene file")
