"""Energy of a thin release with the equations for steep slopes, with and without curvature, and with those for mild ones.

    python -m tests.benchmarks.mountain [--cells 400]

A point mass that slides with Coulomb friction nu on a straight slope loses nu g per length on the map: its energy head
z + v^2/(2g), v along the ground, falls along a line of slope nu. On a curved one it presses with g + b_xx v_x^2 in place of g, and
the line falls by nu (1 + b_xx v_x^2/g). Both are exact for a point and the references here, the second as an ODE; a release of some
length is compared by its mass averages. Two profiles: a plane of 34 degrees, and the parabola b = C (1 - x/f)^2, C = 1000 m,
f = 2250 m, level beyond f. Shallow water with friction along x: model against exact, no measurement, no other program's result.

Without friction a bead on b = 300 exp(-x/250) + 40 sin(x/90) cos(y/70), m, keeps its energy. A heap of 0.1 m and 20 m radius slides from
(0, 5) for 12 s on 300 x 100 cells; its energy less that of the start, over the fall of its potential energy so far.
"""

import numpy as np
from scipy.integrate import solve_ivp

import fvkit as fv
import fvkit_granular as gr
from tests.benchmarks.chapter import asked

G, NU = 9.81, 0.3

#: Equations: slope, and whether the bottom's curvature acts.
EQUATIONS = {"steep + curvature": ("steep", True), "steep": ("steep", False), "mild": ("mild", False)}

#: {name: (bottom, end of the line, m, end time, s)}.
PROFILES = {
    "plane": (lambda x: -np.tan(np.radians(34.0)) * x, 1500.0, 18.0),
    "parabola": (lambda x: 1000.0 * np.maximum(1.0 - x / 2250.0, 0.0) ** 2, 3000.0, 40.0),
}


def energy_slope(profile, slope, curved=False, cells=400):
    """Return the slope of the energy line, and that of a point, for the mass averages of a hump of 1 m over 100 m, least squares over 20 times."""
    bottom, end, t_end = PROFILES[profile]
    scene = gr.Scene((0.0, end), t_end, lambda x: {"h": np.where(abs(x - 200.0) < 50.0, np.cos((x - 200.0) * np.pi / 100.0) ** 2, 0.0),
                                                   "phi": 1.0},
                     bottom=bottom, sources=(gr.CoulombFriction(NU), *(gr.Curvature(),) * curved), slope=slope)
    problem = scene.problem(gr.ShallowWater(slope=slope), cells)
    solution = fv.solve(problem, times=np.linspace(0.25, 1.0, 20) * t_end)
    x, b = solution.grid.centers, solution.aux["b"]
    rise = np.gradient(b, x)
    heads = []
    for k in range(len(solution.t)):
        seen = solution.observables(k)
        mass = seen["h"] / seen["h"].sum()
        head = b + (1.0 + rise**2) * seen["v"] ** 2 / (2.0 * G)
        heads.append(((mass * x).sum(), (mass * head).sum()))
    place, head = np.array(heads[1:]).T
    return -float(np.polyfit(place, head, 1)[0]), -float(np.polyfit(place, _point(bottom, place, head[0]), 1)[0])


def _point(bottom, place, head):
    """The energy head of a point at places, from that at the first."""
    step = 1e-2

    def fall(x, e):
        rise = (bottom(x + step) - bottom(x - step)) / (2.0 * step)
        bend = (bottom(x + step) - 2.0 * bottom(x) + bottom(x - step)) / step**2
        return -NU * (1.0 + bend * 2.0 * (e - bottom(x)) / (1.0 + rise**2))

    return solve_ivp(fall, (place[0], place[-1]), [head], t_eval=place, rtol=1e-8, max_step=10.0).y[0]


def hillside(x, y):
    """Return the bottom of the bead, m, and its slopes."""
    fall, waves = 300.0 * np.exp(-x / 250.0), 40.0 * np.sin(x / 90.0)
    return (fall + waves * np.cos(y / 70.0), 40.0 / 90.0 * np.cos(x / 90.0) * np.cos(y / 70.0) - fall / 250.0,
            -waves / 70.0 * np.sin(y / 70.0))


def energy_left(slope, curved, t_end=12.0):
    """Return the largest change of the energy of a bead without friction over the fall of its potential energy, once a second."""
    def heap(x, y):
        r = np.hypot(x, y - 5.0)
        return [np.where(r < 20.0, 0.1 * np.cos(r * np.pi / 40.0) ** 2, 0.0), 0.0 * x, 0.0 * x]

    grid = fv.Grid((-60.0, -100.0), (540.0, 100.0), (300, 100))
    problem = fv.Problem(gr.ShallowWater(slope=slope), grid, heap, t_end, aux={"b": lambda x, y: hillside(x, y)[0]},
                         sources=(gr.Curvature(),) * curved)
    solution = fv.solve(problem, times=np.arange(1.0, t_end + 0.5))
    b, slope_x, slope_y = hillside(*np.meshgrid(*(axis.centers for axis in grid.axes)))
    potential, energy = [], []
    for k in range(len(solution.t)):
        seen = solution.observables(k)
        mass, up = seen["h"] / seen["h"].sum(), seen["v_x"] * slope_x + seen["v_y"] * slope_y
        potential.append(G * (mass * (b + 0.5 * seen["h"])).sum())
        energy.append(potential[-1] + 0.5 * (mass * (seen["v_x"] ** 2 + seen["v_y"] ** 2 + up**2)).sum())
    change = (np.array(energy[1:]) - energy[0]) / np.maximum.accumulate(potential[0] - np.array(potential[1:]))
    return float(change[np.argmax(np.abs(change))])


def main():
    cells = asked(__doc__, cells=400).cells
    names = " | ".join(f"{name} | error, %" for name in EQUATIONS)
    print(f"| profile | nu | point | {names} |\n{'|---' * (3 + 2 * len(EQUATIONS))}|")
    for profile in PROFILES:
        found, exact = zip(*(energy_slope(profile, *equations, cells) for equations in EQUATIONS.values()), strict=True)
        print(f"| {profile} | {NU:g} | {exact[0]:.4f} | " + " | ".join(
            f"{value:.4f} | {100.0 * (value / point - 1.0):+.1f}" for value, point in zip(found, exact, strict=True)) + " |", flush=True)
    print("\n| bead without friction | " + " | ".join(EQUATIONS) + f" |\n{'|---' * (1 + len(EQUATIONS))}|")
    print("| energy, % of the fall | " + " | ".join(f"{100.0 * energy_left(*equations):+.1f}" for equations in EQUATIONS.values()) + " |")


if __name__ == "__main__":
    main()
