"""Solitary wave on a conical island: laboratory run-up around the island, shallow water with two axes. Measured.

    python -m tests.benchmarks.conical_island FOLDER [--cell 0.05]

FOLDER holds the public benchmark (Briggs, Synolakis, Harkins, Green, Pure Appl. Geophys. 144, 1995, 569-593), as in
GeoscienceAustralia/ptha (BP06): run2a.txt, run2b.txt, run2c.txt, of water 0.32 m deep and waves of measured heights 0.045, 0.096, 0.181
of the depth. The wave starts as an exact solitary wave half a wavelength before the foot of the island; Manning 0.01; 15 s.

Score of that repository: largest run-up anywhere, at most 20 % above the measured one, in B and C; its README: published run-up of A differs
by 30 to 50 % between sources, and the waves are dispersive, which shallow water is not. Mean: mean |error| over the angles, over the
mean of the measured run-up.
"""


import numpy as np

import fvkit as fv
import fvkit_granular as gr
from tests.benchmarks.chapter import asked

DEPTH, CENTRE, FOOT, TOP, SLOPE, HEIGHTS = 0.32, (12.96, 13.80), 3.6, 1.1, 0.25, {"a": 0.045, "b": 0.096, "c": 0.181}

#: Water that reached a cell at least this deep, m, ran up to its ground.
FILM = 1e-3


def bottom(x, y):
    return -DEPTH + SLOPE * np.clip(FOOT - np.hypot(x - CENTRE[0], y - CENTRE[1]), 0.0, FOOT - TOP)


def run_up(case, cell, angles):
    """Return the run-up at angles, m: 0 at the side of larger y, 270 degrees where the wave comes from."""
    height = HEIGHTS[case] * DEPTH
    k, c = np.sqrt(0.75 * height / DEPTH**3), np.sqrt(9.81 * (DEPTH + height))
    crest = CENTRE[0] - FOOT - np.arccosh(np.sqrt(20.0)) / k

    def start(x, y):
        level = height / np.cosh(k * (x - crest)) ** 2
        return {"surface": level, "phi": 0.0, "vf_x": c * level / (DEPTH + level), "vs_x": c * level / (DEPTH + level)}

    wall = fv.Wall()
    scene = gr.Scene(((0.0, 0.0), (25.9, 27.6)), 15.0, start, bottom=bottom, boundary=(fv.Outflow(), fv.Outflow(), wall, wall),
                     sources=gr.Manning(0.01), slope="steep")
    problem = scene.problem(gr.ShallowWater, (round(25.9 / cell), round(27.6 / cell)))
    hazard = gr.HazardMaps(threshold=FILM)
    print(fv.solve(problem, observers=hazard), flush=True)
    x, y = np.meshgrid(*(axis.centers for axis in problem.grid.axes))
    place = np.degrees(np.arctan2(x - CENTRE[0], y - CENTRE[1])) % 360.0
    island = (hazard.maps["depth"] > FILM) & (np.hypot(x - CENTRE[0], y - CENTRE[1]) < FOOT)
    ground = np.where(island, bottom(x, y), -np.inf)
    width = np.degrees(cell / (FOOT - DEPTH / SLOPE))
    return np.array([ground[np.abs((place - angle + 180.0) % 360.0 - 180.0) < width].max() for angle in angles])


def main():
    given = asked(__doc__, folder=None, cell=0.05)
    lines = ["| case | largest run-up, cm | measured | difference | in front | measured | behind | measured | mean |", "|---" * 9 + "|"]
    for case in HEIGHTS:
        rows = [line.split() for line in (given.folder / f"run2{case}.txt").read_text(encoding="utf-8").splitlines()]
        angles, measured = np.array([[float(row[1]), float(row[2])] for row in rows if len(row) == 4 and row[0][0].isdigit()]).T
        found = 100.0 * run_up(case, given.cell, angles)
        front, back = (int(np.argmin(np.abs(angles - angle))) for angle in (270.0, 90.0))
        lines.append(f"| {case.upper()} | {found.max():.1f} | {measured.max():.1f} | {found.max() / measured.max() - 1.0:+.0%} | {found[front]:.1f} | "
                     f"{measured[front]:.1f} | {found[back]:.1f} | {measured[back]:.1f} | {np.abs(found - measured).mean() / measured.mean():.0%} |")
    print("\n".join(lines))


if __name__ == "__main__":
    main()
