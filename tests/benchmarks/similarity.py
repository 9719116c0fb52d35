"""Similarity solution of a parabolic cap on an inclined plane, two axes: semi-axes and centre by ordinary differential equations.

    python -m tests.benchmarks.similarity [--cells 80 160 320] [--model two-phase]

A cap h = h0 (1 - X^2/a^2 - Y^2/b^2), 4 m high, of semi-axes 80 m, slides down a plane of 35 degrees, at first with 20 m/s along the
ground. In the frame that slides with it the velocity is (X a'/a, Y b'/b), and with horizontal axes, h vertical, c = cos(35 degrees),
U the speed of the centre along the ground,

    a'' = 2 p g h0/a,   b'' = 2 c^2 g h0/b - nu c g b'/U,   h0 a b constant,   centre'' = c^2 g (tan(35 degrees) - nu).

* ``ours``: p = c^2, the equations for steep slopes solved here. Exact without friction.
* ``thin``: p = c^4, layers whose pressure is hydrostatic along the normal of the bed: Hutter, Siegel, Savage, Nohguchi, Acta Mech. 100
  (1993) 37-68, with K = 1. The distance to it is that of the equations, not of the scheme: their waves along the slope are faster by 1/c.
* ``hutter``: as thin, with friction along the slope alone, their assumption: without nu c g b'/U.

With friction the references are exact to first order in the angle between velocity and slope. L1 of the difference of h over the
volume at t = 12 s.
"""


import numpy as np
from scipy.integrate import solve_ivp

import fvkit as fv
import fvkit_granular as gr
from fvkit.problem.cell_averages import cell_averages
from fvkit_granular.models.registry import MODELS
from tests.benchmarks.chapter import asked

G, ANGLE, HEIGHT, HALF, START, T_END = 9.81, np.radians(35.0), 4.0, 80.0, 20.0, 12.0

#: {reference: power of the cosine in the pressure along the slope, share of the friction across it}.
REFERENCES = {"ours": (2, 1.0), "thin": (4, 1.0), "hutter": (4, 0.0)}


def cap(t, nu, power, across):
    """Return (x, y) -> depth, m, at time t."""
    c = np.cos(ANGLE)
    volume = HEIGHT * HALF * HALF

    def rate(_, s):
        a, b, da, db, _, u = s
        push = 2.0 * c**2 * G * volume / (a * b)
        return da, db, c ** (power - 2) * push / a, push / b - across * nu * c * c * G * db / u, u, c**2 * G * (np.tan(ANGLE) - nu)

    start = [HALF, HALF, 0.0, 0.0, 0.0, START * c]
    a, b, _, _, x0, _ = solve_ivp(rate, (0.0, t), start, rtol=1e-10, atol=1e-10).y[:, -1] if t > 0.0 else start
    return lambda x, y: volume / (a * b) * np.maximum(1.0 - ((x - x0) / a) ** 2 - (y / b) ** 2, 0.0)


def errors(nu, cells, model=gr.ShallowWater):
    """Return the differences to each reference, over the volume."""
    c = np.cos(ANGLE)
    end = START * c * T_END + 0.5 * c**2 * G * (np.tan(ANGLE) - nu) * T_END**2
    start = cap(0.0, 0.0, 2, 1.0)
    scene = gr.Scene(((-160.0, -240.0), (end + 240.0, 240.0)), T_END,
                     lambda x, y: {"h": start(x, y), "phi": 0.6, "vs_x": START * c, "vf_x": START * c},
                     bottom=lambda x, y: -np.tan(ANGLE) * x, sources=gr.CoulombFriction(nu) if nu else (), slope="steep")
    problem = scene.problem(model, (cells, round(cells * 480.0 / (end + 400.0))))
    solution = fv.solve(problem)
    h = solution.observables()["h"]
    result = []
    for power, across in REFERENCES.values():
        known = cap(T_END, nu, power, across)
        wanted = cell_averages(lambda x, y, known=known: known(x, y)[None], problem.grid, 1, "cap")[0]
        result.append(np.abs(h - wanted).sum() / wanted.sum())
    return result


def main():
    given = asked(__doc__, cells=[80, 160, 320], model=("shallow-water", *MODELS))
    print(f"| nu | cells | {' | '.join(REFERENCES)} |\n|---|---|---|---|---|")
    for nu in (0.0, 0.4):
        for cells in given.cells:
            found = errors(nu, cells, MODELS[given.model])
            print(f"| {nu:g} | {cells} | {' | '.join(f'{error:.4f}' for error in found)} |", flush=True)


if __name__ == "__main__":
    main()
