"""``fvkit scenes``: the built-in scenes."""

import argparse
from typing import Any

from fvkit.cli import SUCCESS, add_command
from fvkit_granular.scenes.library.catalogue import scene, scene_names
from fvkit_granular.scenes.toml.read import find_scene
from fvkit_granular.scenes.toml.write import scene_text


def register(commands: Any) -> None:
    """Add the command to the parser of ``fvkit``."""
    listed = add_command(commands, "scenes", _scenes, "list the built-in scenes, or show one as a TOML file",
                         "fvkit scenes --show riemann > mine.toml")
    listed.add_argument("--show", metavar="SCENE", help="print one as TOML: a file that runs to the same result, to the bit")


def _scenes(options: argparse.Namespace) -> int:
    if options.show is not None:
        print(scene_text(find_scene(options.show)), end="")
        return SUCCESS
    wide = max(map(len, scene_names()))
    for name in scene_names():
        shown = scene(name)
        print(f"{name:{wide}s}  {len(shown.axes)} {'axes' if len(shown.axes) > 1 else 'axis'}  {shown.description}")
    return SUCCESS
