"""The commands of `fvkit` that serve granular flows."""

from typing import Any

from fvkit_granular.cli import advise, bench, check, compare, convergence, run, scenes, stress, sweep


def register(commands: Any) -> None:
    """Add the commands to the parser of ``fvkit``."""
    for command in (scenes, check, run, compare, bench, stress, advise, convergence, sweep):
        command.register(commands)
