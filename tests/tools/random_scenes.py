"""Random scenes with every model, solver and order: ``python -m tests.tools.random_scenes 20000`` from the top of a checkout."""

import argparse
import os
import sys
from collections.abc import Sequence
from functools import partial
from pathlib import Path

from fvkit.cli import FAILED, INTERRUPTED, SUCCESS, done_so_far
from fvkit_granular.stress.suite import MODELS, SOLVERS
from tests.tools.random_draws import INFLOWS, PLANE, SETTINGS
from tests.tools.random_runs import HIGH, pairs, plan, random_stress


def main(arguments: Sequence[str] | None = None) -> int:
    """Run what the command line says, print and save the report, return the exit code."""
    parser = argparse.ArgumentParser(prog="python -m tests.tools.random_scenes", description="Run random scenes, and judge each run.")
    parser.add_argument("count", type=int, metavar="N", help="scenes for each model, solver and order")
    parser.add_argument("--seed", type=int, default=1, help="seed of the scenes (default 1)")
    parser.add_argument("--first", type=int, default=0, metavar="K", help="index of the first scene (default 0)")
    parser.add_argument("--models", nargs="+", metavar="M", choices=MODELS, help=f"any of {', '.join(MODELS)} (default: all)")
    parser.add_argument("--riemann", nargs="+", metavar="R", choices=SOLVERS, help=f"any of {', '.join(SOLVERS)} (default: all)")
    parser.add_argument("--orders", nargs="+", type=int, default=[1, 2], metavar="P", choices=(1, 2, HIGH),
                        help=f"any of 1, 2 and {HIGH}, the method of lines (default 1 2)")
    kind = parser.add_mutually_exclusive_group()
    kind.add_argument("--inflow", dest="settings", action="store_const", const=INFLOWS, default=SETTINGS,
                      help="scenes with an inflow and friction on a slope")
    kind.add_argument("--plane", dest="settings", action="store_const", const=PLANE, help="scenes on a plane, orders 1 and 2")
    parser.add_argument("--workers", type=int, default=os.cpu_count() or 1, help="processes (default: one per processor)")
    parser.add_argument("--out", type=Path, default=Path("random-scenes"), help="folder for the results (default random-scenes)")
    options = parser.parse_args(arguments)
    if options.count < 1 or options.seed < 0 or options.first < 0 or options.workers < 1:
        parser.error("N and --workers must be >= 1, --seed and --first >= 0")
    if options.settings is PLANE and HIGH in options.orders:
        parser.error(f"--orders on a plane must be 1 or 2: {HIGH}, the method of lines, serves a line alone")
    try:
        chosen = pairs(options.models, options.riemann, options.settings)
    except ValueError as error:
        parser.error(str(error))
    print(plan(options.count, chosen, options.orders, options.workers, options.settings), flush=True)
    report, stopped = done_so_far(partial(random_stress, options.count, options.seed, options.models, options.riemann, options.orders,
                                          first=options.first, workers=options.workers, settings=options.settings,
                                          progress=sys.stderr.isatty()))
    folder = report.save(options.out)
    print(report.summary())
    print(f"written to {folder}/: report.json, report.csv, report.png")
    return INTERRUPTED if stopped else SUCCESS if report.success else FAILED


if __name__ == "__main__":
    sys.exit(main())
