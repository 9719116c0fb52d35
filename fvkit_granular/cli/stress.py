"""The command ``fvkit stress``."""

import argparse
import os
import sys
from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import Any

from fvkit import validation
from fvkit.backends import BACKENDS
from fvkit.cli import FAILED, INTERRUPTED, SUCCESS, add_command, done_so_far
from fvkit.files import remove, usable_folder
from fvkit_granular.cli.options import teller
from fvkit_granular.scenes.toml.read import find_scene
from fvkit_granular.stress.cases import CASES, case_of
from fvkit_granular.stress.random_runs import HIGH, pairs, plan, random_stress
from fvkit_granular.stress.suite import MODELS, SOLVERS, stress

#: What the command writes: of hard scenes, or of random ones.
JUDGED, RANDOM = ("stress.json", "stress.txt", "stress.png"), ("report.json", "report.csv", "report.png")


def register(commands: Any) -> None:
    """Add the command to the parser of ``fvkit``."""
    parser = add_command(commands, "stress", lambda options: _stress(options, teller()),
                         "run every hard scene with models, solvers, orders and backends, and judge each run",
                         "fvkit stress island dry-dam-break\n  fvkit stress mine.toml --full\n  fvkit stress --random 20000")
    parser.add_argument("scene", metavar="SCENE", nargs="*", help="hard scenes, or scene files that end in .toml (default: all "
                        "hard scenes)")
    parser.add_argument("--full", action="store_true", help="run all combinations (default: a pairwise covering of the settings)")
    parser.add_argument("--scenes", nargs="+", metavar="S", help=f"the same, as an option: hard scenes are {', '.join(CASES)}")
    parser.add_argument("--backends", nargs="+", metavar="B", help="numba, numpy or both (default: what is installed)")
    parser.add_argument("--random", type=int, metavar="N", help="run N random scenes with every model, solver and order instead")
    parser.add_argument("--seed", type=int, default=1, help="with --random: seed of the scenes (default 1)")
    parser.add_argument("--first", type=int, default=0, metavar="K", help="with --random: index of the first scene (default 0)")
    parser.add_argument("--models", nargs="+", metavar="M", help=f"with --random: any of {', '.join(MODELS)} (default: all)")
    parser.add_argument("--riemann", nargs="+", metavar="R", help=f"with --random: any of {', '.join(SOLVERS)} (default: all)")
    parser.add_argument("--orders", nargs="+", type=int, default=[1, 2], metavar="P",
                        help="with --random: any of 1, 2 and 5, the method of lines (default 1 2)")
    parser.add_argument("--workers", type=int, help="processes (default: one per processor)")
    parser.add_argument("--out", type=Path, default=Path("fvkit-stress"), help="folder for the results (default fvkit-stress)")


def _stress(options: argparse.Namespace, tell: Callable[[str], None] | None) -> int:
    scenes = [*options.scene, *(options.scenes or ())]
    for name in scenes:
        case_of(name)
        find_scene(name)
    for names, argument, known in ((options.backends, "--backends", BACKENDS[1:]),
                                   (options.models, "--models", MODELS), (options.riemann, "--riemann", SOLVERS)):
        for name in names or ():
            validation.choice(name, argument, known)
    for order in options.orders:
        validation.choice(order, "--orders", (1, 2, HIGH))
    if options.workers is not None:
        validation.whole(options.workers, "--workers", at_least=1)
    usable_folder(options.out, "--out", (*JUDGED, *RANDOM))
    if options.random is not None:
        return _random(options)
    report, stopped = done_so_far(partial(stress, options.full, scenes or None, backends=options.backends,
                                          workers=options.workers, progress=tell))
    folder = report.save(options.out)
    remove(folder, RANDOM)
    if tell is not None:
        tell("")
    print(report.summary())
    print(f"written to {folder}/: stress.json, stress.txt, stress.png")
    return INTERRUPTED if stopped else SUCCESS if report.success else FAILED


def _random(options: argparse.Namespace) -> int:
    count, seed = validation.whole(options.random, "--random", at_least=1), validation.whole(options.seed, "--seed", at_least=0)
    first = validation.whole(options.first, "--first", at_least=0)
    print(plan(count, pairs(options.models, options.riemann), options.orders, options.workers or os.cpu_count() or 1), flush=True)
    report, stopped = done_so_far(partial(random_stress, count, seed, options.models, options.riemann, options.orders,
                                          first=first, workers=options.workers, progress=sys.stderr.isatty()))
    folder = report.save(options.out)
    remove(folder, JUDGED)
    print(report.summary())
    print(f"written to {folder}/: report.json, report.csv, report.png")
    return INTERRUPTED if stopped else SUCCESS if report.success else FAILED
