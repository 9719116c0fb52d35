"""What the benchmarks of the validation chapter share: schemes, means over cells, errors, and tables.

    python -m tests.benchmarks.channels | granular | peers
"""

import argparse
from pathlib import Path

import numpy as np
from numpy.polynomial.legendre import leggauss

import fvkit as fv
import fvkit_granular as gr

G = 9.81
SCHEMES = {"Relaxation": fv.WavePropagation(gr.Relaxation()), "Roe": fv.WavePropagation(fv.Roe()), "HLL": fv.WavePropagation(fv.HLL()),
           "Rusanov": fv.WavePropagation(fv.Rusanov()), "MP5": fv.MethodOfLines(fv.Roe())}
NODES, WEIGHTS = leggauss(8)


def means(function, edges, breaks=()):
    """Return the means of a function of x over the cells between ``edges``; cells are cut at kinks and jumps."""
    cuts = np.union1d(edges, [place for place in breaks if edges[0] < place < edges[-1]])
    left, right = cuts[:-1, None], cuts[1:, None]
    x = 0.5 * (left + right) + 0.5 * (right - left) * NODES
    values = np.asarray(function(x.ravel()))
    pieces = values.reshape(*values.shape[:-1], *x.shape) @ (0.5 * WEIGHTS) * np.diff(cuts)
    return np.add.reduceat(pieces, np.searchsorted(cuts, edges[:-1]), axis=-1) / np.diff(edges)


def flow_means(solution, t, grid, breaks=()):
    """Return the means of h and h v of a solution with ``at(x, t)``."""
    def state(x):
        seen = solution.at(x, t)
        return np.stack([seen["h"], seen["h"] * seen["v"]])

    return means(state, grid.edges, breaks)


def l1(difference):
    """Mean over the cells of the size of each component."""
    return np.abs(difference).mean(axis=-1)


def order(errors):
    """Observed order between the last two of the errors, whose cells double."""
    return float(np.log2(errors[-2] / errors[-1]))


def table(head, rows):
    """Print a table in Markdown, numbers with two digits."""
    print(f"\n| {' | '.join(head)} |\n|{'---|' * len(head)}")
    for row in rows:
        print(f"| {' | '.join(cell if isinstance(cell, str) else f'{cell:.1e}' for cell in row)} |", flush=True)


def falling(name, errors):
    """Row of a table: errors on grids of doubled cells, and their order, which rounding has none of."""
    return [*name, *errors, f"{order(errors):.1f}" if errors[-1] > 1e-14 else "-"]


def asked(description, **options):
    """Return what the command line asks of a benchmark. Options have a default: a number, a list, False for a flag, a tuple of words of
    which one is chosen; ``folder`` is a place."""
    parser = parser_of(description)
    for name, default in options.items():
        if name == "folder":
            parser.add_argument(name, type=Path, help="the data, see above")
        elif isinstance(default, bool):
            parser.add_argument(f"--{name}", action="store_true")
        elif isinstance(default, tuple):
            parser.add_argument(f"--{name}", choices=default, default=default[0], help=f"default {default[0]}")
        else:
            several = isinstance(default, list)
            parser.add_argument(f"--{name.replace('_', '-')}", type=type(default[0] if several else default), default=default,
                                nargs="+" if several else None, help=f"default {default}")
    return parser.parse_args()


def parser_of(description):
    return argparse.ArgumentParser(description=description, formatter_class=argparse.RawDescriptionHelpFormatter)


def command(description, parts):
    """Run the parts of a benchmark that the command line names, or all."""
    parser = parser_of(description)
    parser.add_argument("parts", nargs="*", metavar="PART", help=f"any of {', '.join(parts)} (default: all)")
    given = parser.parse_args()
    if unknown := set(given.parts) - set(parts):
        parser.error(f"no part {', '.join(sorted(unknown))}: choose from {', '.join(parts)}")
    for name in given.parts or parts:
        parts[name]()
