"""The same release on a mountain of revolution, turned by 0 to 345 degrees: run-out and area must not depend on the grid's axes.

    python -m tests.benchmarks.turned_releases [--cell 10] [--step 15] [--model shallow-water]

Mountain: b(r) = 500 (1 - r/1125)^2 m, level beyond r = 1125 m. Release: a disc of radius 60 m, 2 m thick, centred at r = 200 m. Friction:
Voellmy, mu = 0.155, xi = 2000 m/s^2, 90 s. The equations for steep slopes. Run-out: the farthest place from the top at which the largest depth,
linear between the centres of cells, is 0.1 m; area: where it is more. Exact: all alike. (No measurement, no other program's result.)
"""


import numpy as np
from scipy.interpolate import RegularGridInterpolator

import fvkit as fv
import fvkit_granular as gr
from fvkit_granular.models.registry import MODELS
from tests.benchmarks.chapter import asked

HALF, RADIUS, CENTRE, THRESHOLD = 1800.0, 60.0, 200.0, 0.1


def bottom(x, y):
    return 500.0 * np.maximum(1.0 - np.hypot(x, y) / 1125.0, 0.0) ** 2


def reach(angle, cell=10.0, model=gr.ShallowWater):
    """Return run-out, m, and area, m^2, of a release turned by an angle, degrees."""
    a = np.radians(angle)
    place = CENTRE * np.cos(a), CENTRE * np.sin(a)
    count = round(2.0 * HALF / cell)
    scene = gr.Scene(((-HALF, -HALF), (HALF, HALF)), 90.0,
                     lambda x, y: {"h": np.where(np.hypot(x - place[0], y - place[1]) < RADIUS, 2.0, 0.0), "phi": 0.6},
                     bottom=bottom, sources=(gr.Voellmy(0.155, 2000.0), gr.ConstantDrag(1.0)))
    problem = scene.problem(model, (count, count))
    maxima = gr.HazardMaps(threshold=THRESHOLD)
    fv.solve(problem, observers=maxima, nonhyperbolic="ignore")
    reached = maxima.maps["depth"] > THRESHOLD
    depth = RegularGridInterpolator([axis.centers for axis in problem.grid.axes], maxima.maps["depth"].T)
    r, beside = np.meshgrid(np.arange(CENTRE, HALF - cell, 0.02 * cell), a + np.radians(np.linspace(-30.0, 30.0, 121)))
    wet = depth((r * np.cos(beside), r * np.sin(beside))) > THRESHOLD
    return float(r[wet].max()), float(reached.sum() * cell**2)


def main():
    given = asked(__doc__, cell=10.0, step=15.0, model=("shallow-water", *MODELS))
    angles = np.arange(0.0, 360.0, given.step)
    found = np.array([reach(angle, given.cell, MODELS[given.model]) for angle in angles])
    for angle, (run_out, area) in zip(angles, found, strict=True):
        print(f"| {angle:.0f} | {run_out:.1f} | {area:.0f} |", flush=True)
    for name, unit, values, bound in (("run-out", "m", found[:, 0], given.cell), ("area", "m2", found[:, 1], 0.02 * found[:, 1].mean())):
        away = np.abs(values - values.mean()).max()
        print(f"{name} {values.mean():.1f} {unit}, at most {away:.1f} from the mean = {away / bound:.2f} of "
              f"{'one cell' if unit == 'm' else '2 %'}")


if __name__ == "__main__":
    main()
