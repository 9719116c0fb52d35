"""Channels of SWASHES: steady flow over a bump, MacDonald's channels, dam breaks, and a basin that rocks. Shallow water, one axis.

    python -m tests.benchmarks.channels [bumps macdonald dams dressler basin]

Cases and data: Delestre and others, Int. J. Numer. Meth. Fluids 72 (2013) 269-300, DOI 10.1002/fld.3741. Solutions are programmed here
and in `fvkit_granular.exact`. Errors are means over the cells, of cell averages.
"""

from typing import NamedTuple

import numpy as np
from scipy.optimize import brentq

import fvkit as fv
import fvkit_granular as gr
from fvkit_granular import exact
from tests.benchmarks.chapter import SCHEMES, G, command, falling, flow_means, l1, means, order, table
from tests.benchmarks.macdonald import CHANNELS, RAINY, error

CELLS = (100, 200, 400, 800)
BUMP = gr.scenes.library.steady_flow.parabolic_bump
HEIGHT, CREST, FOOT = 0.2, 10.0, 12.0


# ---------------------------------------------------------------------- bumps

class Bump(NamedTuple):
    """A steady flow over the bump: depth(x), discharge, level at the outlet, kinks and jumps."""

    depth: object
    q: float
    level: float
    breaks: tuple


def bump(regime):
    """Return a steady flow over the bump of 0.2 m by Bernoulli's equation: ``subcritical``, ``transcritical`` or ``jump``."""
    q, level = {"subcritical": (4.42, 2.0), "transcritical": (1.53, 0.66), "jump": (0.18, 0.33)}[regime]
    critical = 1.5 * exact.critical_depth(q, G) + HEIGHT
    lower = q * q / (2.0 * G * level**2) + level

    def over(x):
        branches = [exact.bernoulli_depth(BUMP(x), q, critical, branch, G) for branch in ("subcritical", "supercritical")]
        return np.where(x < CREST, *branches)

    def below(x):
        return exact.bernoulli_depth(BUMP(x), q, lower, "subcritical", G)

    if regime == "subcritical":
        return Bump(below, q, level, (8.0, FOOT))
    if regime == "transcritical":
        return Bump(over, q, level, (8.0, CREST, FOOT))

    def imbalance(x):
        before, behind = (float(side(np.array([x]))[0]) for side in (over, below))
        return q * q / before + 0.5 * G * before**2 - q * q / behind - 0.5 * G * behind**2

    place = brentq(imbalance, 11.4, 11.95, xtol=1e-14)

    def depth(x):
        behind = x >= place
        return np.where(behind, below(np.where(behind, x, FOOT)), over(x))

    return Bump(depth, q, level, (8.0, CREST, place, FOOT))


def bump_missed(regime, scheme, cells, background=False, t=1000.0, still=True, backend="auto", length=25.0):
    """Return h - exact and q - exact of each cell at the time t, from water at rest or from the exact flow."""
    flow, grid = bump(regime), fv.Grid(0.0, length, cells)
    b = means(BUMP, grid.edges, (8.0, FOOT))
    wanted = np.stack([means(flow.depth, grid.edges, flow.breaks), np.full(cells, flow.q)])
    start = np.stack([flow.level - b, np.zeros(cells)]) if still else wanted
    ends = gr.Hydrograph([0.0], [flow.q], [0.0]), gr.FixedLevel(flow.level)
    problem = fv.Problem(gr.ShallowWater(g=G), grid, start, t, {"b": b}, ends, background=wanted if background else None)
    return fv.solve(problem, scheme, backend=backend).q[-1] - wanted


def bump_errors(*case, **options):
    """Return mean |h - exact| and |q - exact|, and the largest |q - exact|, of `bump_missed`."""
    missed = bump_missed(*case, **options)
    return (*l1(missed), np.abs(missed[1]).max())


def bumps():
    rows = []
    for regime in ("subcritical", "transcritical", "jump"):
        for name in ("Relaxation", "Roe", "MP5"):
            h, q, most = np.array([bump_errors(regime, SCHEMES[name], cells) for cells in CELLS]).T
            rows.append([*falling([regime, name], list(h)), *q[[0, -1]], most[-1]])
    table(["flow", "scheme", *(f"h, {n} cells" for n in CELLS), "order", "q, 100", "q, 800", "largest, 800"], rows)
    rows = []
    for regime in ("subcritical", "transcritical", "jump"):
        found = [(*bump_errors(regime, SCHEMES[name], 100, background=True, t=10.0, still=False)[:2],
                  *bump_errors(regime, SCHEMES[name], 100, background=True)[:2]) for name in ("Relaxation", "Roe", "MP5")]
        rows.append([regime, *np.max(found, axis=0)])
    table(["worst scheme, background=", "h kept", "q kept", "h from rest", "q from rest"], rows)


# ---------------------------------------------------------------------- channels with friction

def macdonald():
    rows = []
    for name, channel in (CHANNELS | RAINY).items():
        for scheme in ("Relaxation", "Roe"):
            h, q = np.array([error(channel, SCHEMES[scheme].riemann, cells) for cells in CELLS]).T
            rows.append([*falling([name, scheme], list(h)), q[-1], f"{order(q):.1f}"])
    table(["channel", "solver", *(f"h, {n} cells" for n in CELLS), "order", "q/q, 800", "order"], rows)


# ---------------------------------------------------------------------- dam breaks

def dam_errors(right, scheme, cells):
    """Return mean |h - exact|, m, and |q - exact| of 5 mm of water that break into ``right`` metres, after 6 s."""
    solved, grid, t = exact.shallow_water_riemann((0.005, 0.0), (right, 0.0), g=G), fv.Grid(-5.0, 5.0, cells), 6.0
    fronts = [speed * t for wave in solved.waves for speed in (wave.head, wave.tail)]
    problem = fv.Problem(gr.ShallowWater(g=G), grid, flow_means(solved, 0.0, grid, (0.0,)), t)
    return l1(fv.solve(problem, scheme).q[-1] - flow_means(solved, t, grid, fronts))


def dams():
    rows = [falling([name, scheme], [dam_errors(right, SCHEMES[scheme], cells)[0] for cells in CELLS])
            for name, right in (("onto 1 mm (Stoker)", 0.001), ("onto dry ground (Ritter)", 0.0))
            for scheme in ("Relaxation", "Roe", "HLL")]
    table(["5 mm of water break", "scheme", *(f"h, {n} cells" for n in CELLS), "order"], rows)


class Dressler(NamedTuple):
    """Dressler's dam break onto dry ground with the friction g v^2/C^2: a perturbation in g/C^2, right to its first order behind the tip."""

    h: float = 6.0
    chezy: float = 40.0

    def at(self, x, t):
        c = np.sqrt(G * self.h)
        s = np.clip(2.0 - x / (t * c), 1e-9, None)
        rough = t * G**2 / self.chezy**2
        root = 2.0 / 3.0 * c - x / (3.0 * t) + rough * (6.0 / (5.0 * s) - 2.0 / 3.0 + 4.0 * np.sqrt(3.0) / 135.0 * s**1.5)
        v = 2.0 / 3.0 * (c + x / t) + rough * (12.0 / s - 8.0 / 3.0 + 8.0 * np.sqrt(3.0) / 189.0 * s**1.5 - 108.0 / (7.0 * s**2))
        still = x <= -c * t
        return {"h": np.where(still, self.h, root**2 / G), "v": np.where(still, 0.0, v)}

    def tip(self, t):
        """Where the tip begins, m: there the velocity of the perturbation is largest, and it has lost its meaning beyond."""
        c = np.sqrt(G * self.h)
        x = np.linspace(-c * t, 2.0 * c * t, 100_001)[:-1]
        return float(x[self.at(x, t)["v"].argmax()])


def dressler_error(scheme, cells, t=40.0):
    """Return mean |h - exact| behind the tip, m."""
    solved, grid = Dressler(), fv.Grid(-1000.0, 1000.0, cells)
    start = np.stack([means(lambda x: np.where(x < 0.0, solved.h, 0.0), grid.edges, (0.0,)), np.zeros(cells)])
    problem = fv.Problem(gr.ShallowWater(g=G), grid, start, t, sources=gr.Voellmy(0.0, solved.chezy**2))
    missed = fv.solve(problem, scheme).q[-1] - flow_means(solved, t, grid, (-np.sqrt(G * solved.h) * t,))
    return np.abs(missed[0, grid.edges[1:] < solved.tip(t)]).mean()


def dressler():
    rows = [falling([name], [dressler_error(SCHEMES[name], cells) for cells in CELLS]) for name in ("Relaxation", "Roe", "HLL")]
    table(["6 m of water, C = 40", *(f"h, {n} cells" for n in CELLS), "order"], rows)


# ---------------------------------------------------------------------- a basin that rocks

def basin_errors(scheme, cells, periods=5, backend="auto"):
    """Return mean |h - exact|, m, and |q - exact| of Thacker's plane after some periods."""
    solved, grid = exact.thacker_basin(), fv.Grid(0.0, 4.0, cells)
    t = periods * solved.period
    start = flow_means(solved, 0.0, grid, solved.shores(0.0))
    problem = fv.Problem(gr.ShallowWater(g=G), grid, start, t, {"b": means(solved.bottom, grid.edges)}, fv.Wall())
    return l1(fv.solve(problem, scheme, backend=backend).q[-1] - flow_means(solved, t, grid, solved.shores(t)))


def basin():
    rows = [falling([name], [basin_errors(SCHEMES[name], cells)[0] for cells in CELLS]) for name in ("Relaxation", "Roe", "HLL", "MP5")]
    table(["Thacker's plane, 5 periods", *(f"h, {n} cells" for n in CELLS), "order"], rows)


if __name__ == "__main__":
    command(__doc__, {part.__name__: part for part in (bumps, macdonald, dams, dressler, basin)})
