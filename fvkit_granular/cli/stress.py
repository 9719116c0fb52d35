"""The command ``fvkit stress``."""

import argparse
from functools import partial
from pathlib import Path
from typing import Any

from fvkit.backends import BACKENDS
from fvkit.cli import FAILED, INTERRUPTED, SUCCESS, add_command, done_so_far, progress_line
from fvkit.files import usable_folder
from fvkit_granular.cli.options import COUNT, named
from fvkit_granular.scenes.toml.read import find_scene
from fvkit_granular.stress.cases import CASES, case_of
from fvkit_granular.stress.suite import stress

#: What the command writes.
WRITTEN = ("stress.json", "stress.txt", "stress.png")


def register(commands: Any) -> None:
    """Add the command to the parser of ``fvkit``."""
    parser = add_command(commands, "stress", _stress,
                         "run the hard test scenes with models, solvers, orders and backends, and check each run",
                         "fvkit stress island dry-dam-break\n  fvkit stress mine.toml --full")
    parser.add_argument("scene", metavar="SCENE", nargs="*", help="hard scenes or scene files (.toml; default: all hard scenes)")
    parser.add_argument("--full", action="store_true", help="run all combinations (default: a pairwise covering of the settings)")
    parser.add_argument("--scenes", nargs="+", metavar="S", help=f"same as SCENE; the hard scenes are {', '.join(CASES)}")
    parser.add_argument("--backends", nargs="+", type=named(BACKENDS[1:]), metavar="B",
                        help="numba, numpy or both (default: what is installed)")
    parser.add_argument("--workers", type=COUNT, help="processes (default: one per processor)")
    parser.add_argument("--out", type=Path, default=Path("fvkit-stress"), help="folder for the results (default fvkit-stress)")


def _stress(options: argparse.Namespace) -> int:
    scenes = [*options.scene, *(options.scenes or ())]
    for name in scenes:
        case_of(name)
        find_scene(name)
    usable_folder(options.out, "--out", WRITTEN)
    report, stopped = done_so_far(partial(stress, options.full, scenes or None, backends=options.backends,
                                          workers=options.workers), progress_line())
    folder = report.save(options.out)
    print(report.summary())
    print(f"written to {folder}/: {', '.join(WRITTEN)}")
    return INTERRUPTED if stopped else SUCCESS if report.success else FAILED
