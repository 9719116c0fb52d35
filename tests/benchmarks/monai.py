"""Monai valley: laboratory run-up of a tsunami, 1:400, shallow water with two axes. Measured.

    python -m tests.benchmarks.monai FOLDER [--cell 0.014] [--manning 0.01]

FOLDER holds the public benchmark of the Third International Workshop on Long-Wave Run-up Models (Matsuyama and Tanaka, 2001), as in
GeoscienceAustralia/ptha (BP07): Monai_bathymetry.tif, Benchmark_2_input.txt, output_ch5-7-9.csv, OBS_RUNUP.txt. Needs the extra ``geo``.

Water at rest at level 0, the measured level at the west side, walls elsewhere, 22.5 s. Score of that repository: mean |error| over the
range of the observation at each gauge, at most 0.1; largest run-up near three places inside the spread of six experiments.
"""


import numpy as np

import fvkit as fv
import fvkit_granular as gr
from tests.benchmarks.chapter import asked

GAUGES = {"5": (4.521, 1.196), "7": (4.521, 1.696), "9": (4.521, 2.196)}

#: Water that reached a cell at least this deep, m, ran up to its ground; within this distance, m, of a place.
DEPTH, NEAR = 1e-3, 0.06


def run(folder, cell, manning, slope):
    """Return gauges {name: (t, level)}, ground and largest depth of the cells, and the grid."""
    terrain = gr.read_terrain(folder / "Monai_bathymetry.tif", cell=None if cell <= 0.014 else cell)
    times, levels = np.loadtxt(folder / "Benchmark_2_input.txt", skiprows=1).T
    walls = fv.Wall()
    axes = terrain.grid.axes
    scene = gr.Scene(((axes[0].lower, axes[1].lower), (axes[0].upper, axes[1].upper)), 22.5,
                     lambda x, y: {"surface": 0.0 * x, "phi": 0.0}, bottom=terrain.bottom, slope=slope,
                     boundary=(gr.FixedLevel(levels, times=times), walls, walls, walls), sources=gr.Manning(manning) if manning else ())
    problem = scene.problem(gr.ShallowWater, terrain.grid.shape[::-1])
    gauge, hazard = fv.Gauge(list(GAUGES.values()), dt=0.05), gr.HazardMaps(threshold=DEPTH)
    print(fv.solve(problem, observers=[gauge, hazard]), flush=True)
    return gauge, terrain.bottom, hazard.maps["depth"], terrain.grid


def run_up(ground, deepest, grid, place):
    """Return the highest ground near a place that water reached."""
    x, y = np.meshgrid(*(axis.centers for axis in grid.axes))
    near = (np.hypot(x - place[0], y - place[1]) < NEAR) & (deepest > DEPTH)
    return float(ground[near].max()) if near.any() else float("nan")


def experiments(path):
    """Return {place: run-up of the experiments}, from lines of eight numbers."""
    rows = [line.split() for line in path.read_text(encoding="utf-8").splitlines()]
    found = [row for row in rows if len(row) == 8 and row[0].replace(".", "").isdigit()]
    return {(float(row[0]), float(row[1])): [float(word) for word in row[2:]] for row in found}


def main():
    given = asked(__doc__, folder=None, cell=0.014, manning=0.01, slope=("steep", "mild"))
    gauge, ground, deepest, grid = run(given.folder, given.cell, given.manning, given.slope)
    measured = np.loadtxt(given.folder / "output_ch5-7-9.csv", delimiter=",", skiprows=1).T
    print("| gauge | mean error over range | largest level, cm | measured |\n|---|---|---|---|")
    for k, name in enumerate(GAUGES):
        wanted, found = measured[k + 1], 100.0 * np.interp(measured[0], gauge.t, gauge.values["surface"][:, k])
        until = measured[0] <= gauge.t[-1]
        error = np.abs(found - wanted)[until].mean() / np.ptp(wanted[until])
        print(f"| {name} | {error:.3f} | {found[until].max():.2f} | {wanted[until].max():.2f} |")
    print("| place | run-up, cm | experiments |\n|---|---|---|")
    for place, known in experiments(given.folder / "OBS_RUNUP.txt").items():
        found = 100.0 * run_up(ground, deepest, grid, place)
        print(f"| {place[0]:g}, {place[1]:g} | {found:.2f} | {100.0 * min(known):.2f} to {100.0 * max(known):.2f} |")


if __name__ == "__main__":
    main()
