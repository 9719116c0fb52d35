"""Colima: TITAN2D's scene of two phases on a real volcano. No measurement, and no stored result: what runs, how long, and what is kept.

    python -m tests.benchmarks.colima FOLDER [--cell 5] [--t-end 60]

FOLDER holds colimafinemini.geotiff of titan2d/titan2d. Needs the extra ``geo``. A paraboloid of radius 55 m, 30 m high, 70 % grains, at
(644956, 2157970); bed friction 27 degrees on the grains; drag of Pitman and Le (terminal velocity 0.5 m/s, exponent 3: ours, TITAN2D's is not given).
"""

import time

import numpy as np

import fvkit as fv
import fvkit_granular as gr
from tests.benchmarks.chapter import asked

CENTRE, RADIUS, HEIGHT = (644956.0, 2157970.0), 55.0, 30.0


def main():
    given = asked(__doc__, folder=None, cell=5.0, t_end=60.0)
    terrain = gr.read_terrain(given.folder / "colimafinemini.geotiff", cell=None if given.cell <= 5.0 else given.cell)
    x, y = np.meshgrid(*(axis.centers for axis in terrain.grid.axes))
    cap = HEIGHT * np.maximum(1.0 - ((x - CENTRE[0]) ** 2 + (y - CENTRE[1]) ** 2) / RADIUS**2, 0.0)
    release = gr.read_release(cap, terrain, solid_fraction=0.7)
    sources = (gr.CoulombFriction(np.tan(np.radians(27.0))), gr.PitmanLeDrag(0.5, 3.0))
    scene = gr.Scene(terrain=terrain, release=release, t_end=given.t_end, gamma=0.4, sources=sources)
    print("| model | steps | CPU, s | speed, m/s | reached, m2 | lowest ground, m | mass drift | faces of complex speeds |\n" + "|---" * 8 + "|")
    for model in (gr.TwoPhase, gr.Reduced, gr.ShallowWater):
        hazard, started = gr.HazardMaps(threshold=0.1), time.process_time()
        solution = fv.solve(scene.problem(model), observers=hazard, nonhyperbolic="ignore")
        reached = hazard.maps["depth"] > 0.1
        print(f"| {model.__name__} | {solution.stats.steps} | {time.process_time() - started:.0f} | {hazard.maps['speed'].max():.1f} | "
              f"{reached.sum() * terrain.grid.cell_volume:.0f} | {terrain.bottom[reached].min():.0f} | "
              f"{max(map(abs, solution.stats.mass_drift.values())):.0e} | {solution.stats.nonhyperbolic_faces} |", flush=True)


if __name__ == "__main__":
    main()
