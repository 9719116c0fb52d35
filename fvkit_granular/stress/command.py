"""The command ``fvkit stress``."""

import argparse
import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

from fvkit import _validate
from fvkit.backends import BACKENDS
from fvkit.cli import FAILED, SUCCESS, add_command
from fvkit.io import usable_folder, write_whole
from fvkit.study.layout import plain, table
from fvkit_granular.scene_file import find_scene
from fvkit_granular.stress.cases import CASES, case_of
from fvkit_granular.stress.randomly import HIGH, random_stress
from fvkit_granular.stress.suite import MODELS, SOLVERS, stress


def register(commands: Any, teller: Callable[[], Callable[[str], None] | None]) -> None:
    """Add the command; ``teller`` gives the function that shows progress."""
    parser = add_command(commands, "stress", lambda options: _stress(options, teller()),
                         "run every hard scene with models, solvers, orders and backends, and judge each run",
                         "fvkit stress island dry-dam-break\n  fvkit stress mine.toml --full\n"
                         "  fvkit stress --random 10000 --riemann relaxation roe")
    parser.add_argument("scene", metavar="SCENE", nargs="*", help="hard scenes, or scene files that end in .toml (default: all "
                        "hard scenes)")
    parser.add_argument("--full", action="store_true", help="every combination (default: every pair of settings)")
    parser.add_argument("--scenes", nargs="+", metavar="S", help=f"the same, as an option: hard scenes are {', '.join(CASES)}")
    parser.add_argument("--backends", nargs="+", metavar="B", help="numba, numpy or both (default: what is installed)")
    parser.add_argument("--random", type=int, metavar="N", help="run N random Riemann problems in a box instead")
    parser.add_argument("--seed", type=int, default=1, help="seed of the random problems (default 1)")
    parser.add_argument("--models", nargs="+", default=["two-phase"], metavar="M",
                        help=f"with --random: any of {', '.join(MODELS)} (default two-phase)")
    parser.add_argument("--riemann", nargs="+", default=["relaxation"], metavar="R",
                        help=f"with --random: any of {', '.join(SOLVERS)} (default relaxation)")
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
            _validate.choice(name, argument, known)
    for order in options.orders:
        _validate.choice(order, "--orders", (1, 2, HIGH))
    if options.workers is not None:
        _validate.whole(options.workers, "--workers", at_least=1)
    usable_folder(options.out, "--out")
    if options.random is not None:
        return _random(options, tell)
    report = stress(options.full, scenes or None, backends=options.backends, workers=options.workers, progress=tell)
    folder = report.save(options.out)
    if tell is not None:
        tell("")
    print(report.summary())
    print(f"written to {folder}/: stress.json, stress.txt, stress.png")
    return SUCCESS if report.success else FAILED


def _random(options: argparse.Namespace, tell: Callable[[str], None] | None) -> int:
    count, seed = _validate.whole(options.random, "--random", at_least=8), _validate.whole(options.seed, "--seed", at_least=0)
    rows = random_stress(count, seed, options.models, options.riemann, options.orders, workers=options.workers, progress=tell)
    if tell is not None:
        tell("")
    lines = [["model", "solver", "order", "problems", "p50", "p99", "p99.9", "max", "collapses", "broken", "mass drift"]]
    lines += [[row["model"], row["riemann"], str(row["order"]), str(row["problems"]),
               *(f"{row[name]:.2f}" for name in ("p50", "p99", "p99.9", "max")), str(row["collapses"]),
               str(row["checks"][0]["value"]), f"{row['checks'][-1]['value']:.1e}"] for row in rows]
    print(table(lines))
    print("steps over nominal steps: quantiles and largest; a collapse needs more than 20 times its nominal steps")
    for row in rows:
        for check in row["checks"]:
            if not check["passed"]:
                print(f"FAIL: {row['model']} {row['riemann']} order {row['order']}: {check['name']} {check['value']:.3g}, "
                      f"bound {check['bound']:g}")
        for one in row["failed"]:
            print(f"  {one['status']}: problem {one['index']} of seed {row['seed']}, class {one['class']}")
    options.out.mkdir(parents=True, exist_ok=True)
    write_whole(options.out / "random.json", lambda file: file.write(json.dumps(plain({"rows": rows}), indent=1).encode()))
    print(f"written to {options.out}/: random.json")
    return SUCCESS if all(check["passed"] for row in rows for check in row["checks"]) else FAILED
