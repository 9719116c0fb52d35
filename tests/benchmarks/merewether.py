"""Merewether: flood of 2007 in a suburb, houses and roads on a terrain of 1 m, steady inflow. Measured levels at five places.

    python -m tests.benchmarks.merewether FOLDER [--cell 1] [--t-end 900]

FOLDER holds what GeoscienceAustralia/ptha (BSD-3) has of the case of Smith and Wasko (Australian Rainfall and Runoff, project 15, 2012):
topography1.tif, houses/*.csv, RoadPolygon.csv, point_observations.csv. Needs the extra ``geo``. Set-up as there: 19.7 m^3/s fall on a circle of
15 m, houses stand 3 m above their ground, Manning 0.02 on the road and 0.04 elsewhere, walls but in the east. TUFLOW's levels stand in
the file of observations (another program's result).
"""

import csv

import numpy as np
from matplotlib.path import Path as Path2D

import fvkit as fv
import fvkit_granular as gr
from tests.benchmarks.chapter import asked

DISCHARGE, CENTRE, RADIUS, HOUSE, ROAD, ELSEWHERE = 19.7, (382300.0, 6354290.0), 15.0, 3.0, 0.02, 0.04


def inside(path, x, y):
    """Return which centres of cells are in the polygon of a CSV file."""
    return Path2D(np.loadtxt(path, delimiter=",")).contains_points(np.stack([x.ravel(), y.ravel()], axis=1)).reshape(x.shape)


def levels(folder, cell, t_end):
    """Return the gauge of the observed places."""
    terrain = gr.read_terrain(folder / "topography1.tif", cell=None if cell <= 1.0 else cell)
    axes = terrain.grid.axes
    x, y = np.meshgrid(*(axis.centers for axis in axes))
    bottom = np.where(terrain.missing, np.nanmax(terrain.bottom) + 10.0, terrain.bottom)  # along the upper edge
    for path in sorted((folder / "houses").glob("*.csv")):
        bottom = bottom + HOUSE * inside(path, x, y)
    road = inside(folder / "RoadPolygon.csv", x, y)
    wet = np.hypot(x - CENTRE[0], y - CENTRE[1]) < RADIUS
    rain = gr.Rain(np.where(wet, DISCHARGE / (wet.sum() * terrain.grid.cell_volume), 0.0), phi=0.0)
    wall = fv.Wall()
    scene = gr.Scene(((axes[0].lower, axes[1].lower), (axes[0].upper, axes[1].upper)), t_end, lambda x, y: {"h": 0.0 * x, "phi": 0.0},
                     bottom=bottom, boundary=(wall, fv.Outflow(), wall, wall), slope="mild",
                     sources=(rain, gr.Manning(np.where(road, ROAD, ELSEWHERE))))
    rows = places(folder)
    gauge = fv.Gauge([place for place, _ in rows.values()], dt=10.0)
    solution = fv.solve(scene.problem(gr.ShallowWater, terrain.grid.shape[::-1]), observers=gauge)
    print(solution, flush=True)
    return gauge, rows


def places(folder):
    """Return {number of the place: ((x, y), levels {name: m})}."""
    with open(folder / "point_observations.csv", newline="", encoding="utf-8") as file:
        return {row["ID"]: ((float(row["x"]), float(row["y"])), {name: float(row[name]) for name in row if name not in ("x", "y", "ID")})
                for row in csv.DictReader(file)}


def main():
    given = asked(__doc__, folder=None, cell=1.0, t_end=900.0)
    gauge, rows = levels(given.folder, given.cell, given.t_end)
    print("| place | level, m | observed | difference | TUFLOW 1 m | its difference |\n|---|---|---|---|---|---|")
    errors = []
    for k, (name, (_, known)) in enumerate(rows.items()):
        level, observed, other = gauge.values["surface"][-1, k], known["Observed"], known["TUFLOW_1m_Table9"]
        errors.append((abs(level - observed), abs(other - observed)))
        print(f"| {name} | {level:.2f} | {observed:.2f} | {level - observed:+.2f} | {other:.2f} | {other - observed:+.2f} |")
    own, other = np.mean(errors, axis=0)
    last = gauge.values["surface"][-min(6, len(gauge.t)):].std(axis=0).max()
    print(f"mean |difference| {own:.3f} m (TUFLOW {other:.3f} m); levels of the last minute vary by {last:.3f} m")


if __name__ == "__main__":
    main()
