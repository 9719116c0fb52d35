"""``fvkit bench``: the cost of a step, beside peers that are installed."""

import argparse
from functools import partial
from pathlib import Path
from typing import Any

from fvkit import validation
from fvkit.backends import BACKENDS
from fvkit.cli import INTERRUPTED, SUCCESS, add_command, done_so_far, progress_line
from fvkit.files import usable_folder
from fvkit_granular.cli.options import COUNT, checked, named
from fvkit_granular.studies.bench import ORDERS, bench


def register(commands: Any) -> None:
    """Add the command to the parser of ``fvkit``."""
    speed = add_command(commands, "bench", _bench, "measure ns per cell and step for every model, solver, backend and order",
                        "fvkit bench --cells 1000 10000 --orders 2")
    speed.add_argument("--cells", nargs="+", type=checked(int, validation.whole, at_least=10),
                       default=[100, 1000, 10_000, 100_000], metavar="N", help="numbers of cells (default 100 1000 10000 100000)")
    speed.add_argument("--orders", nargs="+", type=checked(int, validation.choice, known=ORDERS), default=[1, 2],
                       metavar="P", help="any of 1, 2 and 5, one stage of the method of lines with MP5 (default 1 2)")
    speed.add_argument("--backends", nargs="+", type=named(BACKENDS[1:]), metavar="B",
                       help="numba, numpy or both (default: what is installed)")
    speed.add_argument("--plane", nargs="*", type=checked(int, validation.whole, at_least=10), default=[300], metavar="N",
                       help="numbers of cells along each axis of the runs with two axes (default 300; without a "
                            "number: no such runs)")
    speed.add_argument("--repeats", type=COUNT, default=5, help="timed repeats of each case (default 5)")
    speed.add_argument("--out", type=Path, default=Path("fvkit-bench"), help="folder for the results (default fvkit-bench)")


def _bench(options: argparse.Namespace) -> int:
    usable_folder(options.out, "--out", ("bench.json", "bench.png"))
    result, stopped = done_so_far(partial(bench, options.cells, options.orders, options.backends, options.repeats,
                                          plane=options.plane), progress_line())
    folder = result.save(options.out)
    print(result.table())
    print(f"written to {folder}/: bench.json, bench.png")
    return INTERRUPTED if stopped else SUCCESS
