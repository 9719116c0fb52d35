"""``fvkit scenes``: the built-in scenes."""

import argparse
from functools import partial
from textwrap import fill
from typing import Any

from fvkit.cli import SUCCESS, add_command
from fvkit.studies.tables import WIDTH
from fvkit_granular.scenes.library.catalogue import scene, scene_names
from fvkit_granular.scenes.toml.read import SAMPLES, find_scene
from fvkit_granular.scenes.toml.table import toml_text
from fvkit_granular.scenes.toml.write import scene_text


def register(commands: Any) -> None:
    """Add the command to the parser of ``fvkit``."""
    listed = add_command(commands, "scenes", _scenes, "list the built-in scenes, or show one as a TOML file",
                         "fvkit scenes --show riemann > mine.toml")
    which = listed.add_mutually_exclusive_group()
    which.add_argument("scene", metavar="SCENE", nargs="?", help="the same as --show SCENE")
    which.add_argument("--show", metavar="SCENE", help="print SCENE as a TOML file, which gives bitwise the same result")


def _scenes(options: argparse.Namespace) -> int:
    name = options.scene if options.show is None else options.show
    if name in SAMPLES:
        print(f"# {SAMPLES[name]}: copy its folder to change it\n{toml_text(SAMPLES[name])}", end="")
        return SUCCESS
    if name is not None:
        print(scene_text(find_scene(name)), end="")
        return SUCCESS
    every = {name: partial(scene, name) for name in scene_names()} | {name: partial(find_scene, name) for name in SAMPLES}
    wide = max(map(len, every))
    for name, make in every.items():
        shown = make()
        start = f"{name:{wide}s}  {len(shown.axes)} {'axes' if len(shown.axes) > 1 else 'axis'}  "
        print(fill(shown.description, WIDTH, initial_indent=start, subsequent_indent=" " * len(start)))
    return SUCCESS
