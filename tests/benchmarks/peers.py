"""Peers' own pinned numbers at equal degrees of freedom: Trixi's manufactured solutions, PyClaw's dam break and sill.

    python -m tests.benchmarks.peers [shallow layers moving step dam sill]

* TrixiShallowWater.jl, commit df6d8be (MIT): what its tests pin for elixir_shallowwater_source_terms.jl and
  elixir_shallowwater_twolayer_convergence.jl, 8 elements of degree 3, for elixir_shallowwater_moving_water_subsonic.jl, _transonic.jl
  and _shock.jl, 128 elements, and for elixir_shallowwater_twolayer_dam_break.jl, 32 elements; rms over the domain.
* PyClaw, commit c9b889b (BSD-3): depths that its tests of examples/shallow_1d pin, 500 cells; their errors were computed here once.
  Nothing of either is in this project, nor runs here.

The source of the manufactured solutions is a `fvkit.Forcing`. At fifth order SciPy's DOP853 integrates it with `fvkit.rhs`: `Forcing`
acts once in a step, at second order in time.
"""

from typing import NamedTuple

import attrs
import numpy as np
from scipy.integrate import solve_ivp

import fvkit as fv
import fvkit_granular as gr
from fvkit_granular import exact
from tests.benchmarks.channels import bump_missed
from tests.benchmarks.chapter import SCHEMES, command, flow_means, means, order, table

#: The waves of both manufactured solutions have this number: the interval is [0, sqrt(2)], periodic.
WAVE, LENGTH = 2.0 * np.pi * np.sqrt(2.0), np.sqrt(2.0)
WIDTH = 1e-3


class Manufactured(NamedTuple):
    """A flow that is not one of the equations: model, state(x, t) and bottom(x), end time, what the peer pins (L2 of each component)."""

    model: object
    state: object
    bottom: object
    t: float
    peer: tuple


def shallow_state(x, t):
    h = 7.0 + np.cos(WAVE * x) * np.cos(2.0 * np.pi * t) - shallow_bottom(x)
    return np.stack([h, 0.5 * h])


def shallow_bottom(x):
    return 2.0 + 0.5 * np.sin(0.5 * WAVE * x)


def layers_state(x, t):
    """Lower layer, 1 m/s, and upper layer, 0.9 m/s."""
    interface, surface = 2.0 + 0.1 * np.sin(WAVE * x + t), 4.0 + 0.1 * np.cos(WAVE * x + t)
    lower, upper = interface - layers_bottom(x), surface - interface
    return np.stack([lower, lower, upper, 0.9 * upper])


def layers_bottom(x):
    return 1.0 + 0.1 * np.cos(2.0 * WAVE * x)


SHALLOW = Manufactured(gr.ShallowWater(g=9.81), shallow_state, shallow_bottom, 0.025, (0.0022363707, 0.0157679998))
#: Trixi's order is upper, lower; here lower, upper.
LAYERS = Manufactured(gr.TwoLayer(g=10.0, gamma=0.9), layers_state, layers_bottom, 0.25,
                      (0.0050492714, 0.0024633067, 0.0050120099, 0.0020910353))


def source(case, x, t):
    """Return what the equations leave of the manufactured flow, by central differences of sixth order of its closed form."""
    weights = ((1, 0.75), (2, -0.15), (3, 1.0 / 60.0))

    def slope(function, place):
        return sum(w * (function(place + k * WIDTH) - function(place - k * WIDTH)) for k, w in weights) / WIDTH

    model, q = case.model, case.state(x, t)
    rate = slope(lambda when: case.state(x, when), t)
    flux = slope(lambda where: np.stack(np.broadcast_arrays(*model.flux(tuple(case.state(where, t))))), x)
    gradient, bed = slope(lambda where: case.state(where, t), x), slope(case.bottom, x)
    push = np.zeros_like(q)
    push[1] = model.g * q[0] * bed
    if len(q) == 4:
        push[1] += model.g * model.gamma * q[0] * gradient[2]
        push[3] = model.g * q[2] * (bed + gradient[0])
    return rate + flux + push


def manufactured_errors(case, scheme, cells):
    """Return the rms error of each component, of cell averages."""
    grid = fv.Grid(0.0, LENGTH, cells)
    start = means(lambda x: case.state(x, 0.0), grid.edges)
    problem = fv.Problem(case.model, grid, start, case.t, {"b": means(case.bottom, grid.edges)}, fv.Periodic())
    found = _at_high_order(case, problem, scheme) if isinstance(scheme, fv.MethodOfLines) else _forced(case, problem, scheme)
    missed = found - means(lambda x: case.state(x, case.t), grid.edges)
    return rms(missed)


def _forced(case, problem, scheme):
    forcing = fv.Forcing(lambda x, t: source(case, x, t))
    return fv.solve(attrs.evolve(problem, sources=forcing), scheme).q[-1]


def _at_high_order(case, problem, scheme):
    rate = fv.rhs(problem, scheme)

    def with_source(t, flat):
        return rate(t, flat) + means(lambda x: source(case, x, t), problem.grid.edges).ravel()

    run = solve_ivp(with_source, (0.0, case.t), problem.q0.ravel(), method="DOP853", rtol=1e-10, atol=1e-12)
    return run.y[:, -1].reshape(problem.q0.shape)


def manufactured(case, names):
    rows = []
    for scheme in ("MP5", "MUSCL", "Roe"):
        chosen = fv.MethodOfLines(gr.Relaxation(), fv.MUSCL(), fv.SSPRK3()) if scheme == "MUSCL" else SCHEMES[scheme]
        for cells in (32, 64, 128) if scheme == "MP5" else (32,):
            errors = manufactured_errors(case, chosen, cells)
            rows.append([scheme, str(cells), *errors])
    rows.append(["Trixi, degree 3", "32", *case.peer])
    table(["scheme", "cells or nodes", *names], rows)
    print(f"\norder of MP5 from 64 to 128 cells: {order([row[2] for row in rows[:3]]):.1f}")


def shallow():
    manufactured(SHALLOW, ("h", "h v"))


def layers():
    manufactured(LAYERS, ("lower h", "lower h v", "upper h", "upper h v"))


#: What Trixi pins for steady flow over a bump, 128 elements of degree 3, after 0.25 s: rms of h and of h v.
MOVING = {"subcritical": (8.417e-8, 1.219e-7), "transcritical": (1.435e-8, 2.718e-8), "jump": (5.085e-3, 3.519e-3)}


def rms(missed):
    """Root mean square of each component."""
    return np.sqrt((missed**2).mean(axis=-1))


def moving():
    rows = []
    for regime, peer in MOVING.items():
        for name in ("Roe", "Relaxation", "MP5"):
            found = [rms(bump_missed(regime, SCHEMES[name], 512, background, t=0.25, still=False, length=32.0)) for background in (False, True)]
            rows.append([regime, name, *found[0], *found[1]])
        rows.append([regime, "Trixi, degree 3", *peer, "", ""])
    table(["flow", "scheme, 512 cells or nodes", "h", "h v", "h, background=", "h v, background="], rows)


#: What Trixi pins for two layers that break over a step of the bottom: rms of the state, whose exact one it takes for the first one.
STEP = (0.0876424, 0.4541231, 0.1000775, 0.5670693)


def step_change(scheme, cells=128):
    """Return the rms of the change of the lower and the upper layer, h and h v each, in 0.25 s."""
    grid = fv.Grid(0.0, 20.0, cells)
    left = grid.centers < 10.0
    b, lower, upper = (np.where(left, *sides) for sides in ((0.0, 0.5), (2.0, 1.0), (2.0, 1.5)))
    start = np.stack([lower, 0.0 * b, upper, 0.0 * b])
    problem = fv.Problem(gr.TwoLayer(g=9.81, gamma=0.9), grid, start, 0.25, {"b": b}, fv.Wall())
    return rms(fv.solve(problem, scheme).q[-1] - start)


def step():
    rows = [[name, *(f"{value:.4f}" for value in step_change(SCHEMES[name]))] for name in ("Roe", "Relaxation", "HLL", "Rusanov", "MP5")]
    rows.append(["Trixi, degree 3", *(f"{value:.4f}" for value in STEP)])
    table(["change in 0.25 s, 128 cells or nodes", "lower h", "lower h v", "upper h", "upper h v"], rows)


#: L1 of the depth times the length, of PyClaw's pinned depths: against Stoker's solution, and against MP5 on 4000 cells.
PYCLAW_DAM = {"PyClaw, classic, Roe": 1.150e-2, "PyClaw, classic, HLLE": 2.107e-2, "PyClaw, SharpClaw, Roe": 1.69e-2, "PyClaw, SharpClaw, HLLE": 1.72e-2}
PYCLAW_SILL = {"PyClaw, f-waves, van Leer": 2.0e-5}


def dam_error(scheme, cells=500):
    """Return L1 of the depth, m^2: 3 m | 1 m, g = 1, t = 2 s."""
    solved, grid = exact.shallow_water_riemann((3.0, 0.0), (1.0, 0.0), g=1.0), fv.Grid(-5.0, 5.0, cells)
    fronts = [speed * 2.0 for wave in solved.waves for speed in (wave.head, wave.tail)]
    problem = fv.Problem(gr.ShallowWater(g=1.0), grid, flow_means(solved, 0.0, grid, (0.0,)), 2.0)
    return np.abs(fv.solve(problem, scheme).q[-1, 0] - flow_means(solved, 2.0, grid, fronts)[0]).sum() * grid.dx


def dam():
    ours = {"Roe, MC": SCHEMES["Roe"], "Roe, van Leer": fv.WavePropagation(fv.Roe(), limiter=fv.VanLeer()), "Relaxation, MC": SCHEMES["Relaxation"],
            "HLL, MC": SCHEMES["HLL"], "MP5, Roe": SCHEMES["MP5"]}
    table(["dam break, 500 cells", "L1 of h, m²"], [[name, f"{value:.2e}"] for name, value in
                                                    (PYCLAW_DAM | {name: dam_error(scheme) for name, scheme in ours.items()}).items()])


def sill_depth(scheme, cells):
    """Return the depth after 1 s of a hump of 0.1 m that passes a sill of 0.8 m in water of 1 m."""
    grid = fv.Grid(-1.0, 1.0, cells)
    b = means(lambda x: 0.8 * np.exp(-((x / 0.2) ** 2)) - 1.0, grid.edges)
    h = means(lambda x: 0.1 * np.exp(-(((x + 0.4) / 0.2) ** 2)), grid.edges) - b
    problem = fv.Problem(gr.ShallowWater(g=9.8), grid, np.stack([h, 0.0 * h]), 1.0, {"b": b})
    return fv.solve(problem, scheme).q[-1, 0]


def sill_error(scheme, cells, reference):
    """Return L1 of the depth, m^2, against that of a finer grid."""
    return np.abs(sill_depth(scheme, cells) - reference.reshape(cells, -1).mean(axis=1)).sum() * 2.0 / cells


def sill():
    reference = sill_depth(SCHEMES["Roe"], 4000)
    ours = {name: sill_error(SCHEMES[name], 500, reference) for name in ("Roe", "Relaxation", "HLL", "MP5")}
    table(["sill, 500 cells", "L1 of h, m²"], [[name, value] for name, value in (PYCLAW_SILL | ours).items()])
    own, other = (sill_error(SCHEMES[name], cells, reference) for name, cells in (("Roe", 2000), ("MP5", 4000)))
    print(f"\nthe reference, Roe on 4000 cells, is {own:.0e} m² from 2000 cells and {other:.0e} m² from MP5 on 4000")


if __name__ == "__main__":
    command(__doc__, {part.__name__: part for part in (shallow, layers, moving, step, dam, sill)})
