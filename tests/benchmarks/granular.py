"""Granular flow with Coulomb friction down planes: caps and dam breaks that slide, uniform flow, piles at rest, a block, a column.

    python -m tests.benchmarks.granular [caps models dams uniform rest column]

Axes along the slope: gravity g cos(slope), bottom -tan(slope) x. In a frame that slides with the acceleration of a block the
equations are those on level ground without friction (`fvkit_granular.exact.accelerated`).

* Cap: Savage and Hutter, J. Fluid Mech. 199 (1989) 177-215, with earth pressure coefficient 1: h = H (1 - y^2/L^2), H L constant,
  v = y L'/L, L'' = 2 g H/L: exact as long as all of it slides down.
* Dam break: Mangeney, Heinrich and Roche, Pure Appl. Geophys. 157 (2000), and Faccanoni and Mangeney (2013), its angles as in AvaFrame:
  Ritter's dam break in that frame.
"""

from typing import NamedTuple

import attrs
import numpy as np
from scipy.integrate import solve_ivp

import fvkit as fv
import fvkit_granular as gr
from fvkit_granular import exact
from tests.benchmarks.chapter import SCHEMES, G, command, falling, flow_means, l1, table

CELLS, SOLVERS = (200, 400, 800, 1600), ("Relaxation", "Roe", "HLL", "Rusanov")
MODELS = gr.ShallowWater, gr.Reduced, gr.TwoPhase
#: Density ratio of the models with grains: the fluid is all but absent. Friction is that of the weight in it.
AIR = 1e-3


# ---------------------------------------------------------------------- what slides

class Cap(NamedTuple):
    """A parabolic cap that spreads on level ground from rest: thickness H0, m, half length L0, m, gravity."""

    g: float
    height: float = 1.0
    half: float = 10.0
    kind: str = "exact"

    def size(self, t):
        """Half length, m, and its rate."""
        push = 2.0 * self.g * self.height * self.half
        run = solve_ivp(lambda _, s: (s[1], push / s[0] ** 2), (0.0, t), (self.half, 0.0), rtol=1e-12, atol=1e-12)
        return run.y[:, -1]

    def at(self, x, t):
        half, rate = self.size(t)
        h = np.where(np.abs(x) < half, self.height * self.half / half * (1.0 - (x / half) ** 2), 0.0)
        return {"h": h, "v": x * rate / half}


class Slide(NamedTuple):
    """Something that slides down a plane: slope and angle of friction in degrees, speed at first, time, interval."""

    slope: float
    friction: float
    start: float
    t: float
    interval: tuple
    of: str = "cap"

    @property
    def g(self):
        return G * np.cos(np.radians(self.slope))

    @property
    def tangents(self):
        return np.tan(np.radians(self.slope)), np.tan(np.radians(self.friction))

    @property
    def acceleration(self):
        return exact.sliding_acceleration(*self.tangents, self.g)

    def solution(self):
        """Return the exact solution, and where it has kinks at the time t."""
        moved = self.start * self.t + 0.5 * self.acceleration * self.t**2
        if self.of == "cap":
            inside = Cap(self.g)
            kinks = inside.size(self.t)[0] * np.array([-1.0, 1.0])
        else:
            inside = exact.shallow_water_riemann((1.0, 0.0), (0.0, 0.0), g=self.g)
            kinks = [speed * self.t for wave in inside.waves for speed in (wave.head, wave.tail)]
        return exact.accelerated(inside, self.acceleration, self.start), [moved + kink for kink in kinks]


CAPS = {"from rest, 40/20": Slide(40.0, 20.0, 0.0, 4.0, (-20.0, 60.0)), "slowing down, 20/30": Slide(20.0, 30.0, 12.0, 2.5, (-20.0, 60.0))}
DAMS = {"22/21": Slide(22.0, 21.0, 0.0, 5.0, (-60.0, 60.0), "dam"), "35/20": Slide(35.0, 20.0, 0.0, 3.0, (-60.0, 60.0), "dam")}


def slid(slide, scheme, cells, model=gr.ShallowWater):
    """Return the grid, the means of (h, h v) at the end, and those of the exact solution."""
    grid, (slope, nu) = fv.Grid(*slide.interval, cells), slide.tangents
    solved, kinks = slide.solution()
    h, q = flow_means(solved, 0.0, grid, (-10.0, 0.0, 10.0))
    made = model(g=slide.g) if model is gr.ShallowWater else model(g=slide.g, gamma=AIR)
    v = np.divide(q, h, out=np.zeros_like(q), where=h > 0.0)
    law = gr.CoulombFriction(nu if model is gr.ShallowWater else nu / (1.0 - AIR))
    problem = fv.Problem(made, grid, made.conserved_from(h, 1.0, v, v), slide.t, {"b": -slope * grid.centers}, (gr.UniformSlope(), fv.Outflow()), law)
    seen = fv.solve(problem, scheme).observables()
    found = np.stack([seen["h"], seen["h"] * np.nan_to_num(seen["v"])])
    return grid, found, flow_means(solved, slide.t, grid, kinks)


def cap_errors(slide, scheme, cells, model=gr.ShallowWater):
    """Return mean |h - exact|, m, mean |q - exact|, and by how much the centre of mass is ahead, m."""
    grid, found, wanted = slid(slide, scheme, cells, model)
    ahead = (grid.centers * (found[0] - wanted[0])).sum() / wanted[0].sum()
    return (*l1(found - wanted), ahead)


def dam_errors(slide, scheme, cells):
    """Return mean |h - exact|, m, on the lower three quarters, and the relative error of the speed of the reservoir, 10 m above its edge."""
    grid, found, wanted = slid(slide, scheme, cells)
    near = grid.centers > -30.0
    at = np.searchsorted(grid.centers, slide.solution()[1][0] - 10.0)
    return l1((found - wanted)[:, near])[0], found[1, at] / found[0, at] / (slide.acceleration * slide.t) - 1.0


def caps():
    rows = []
    for name, slide in CAPS.items():
        for scheme in SOLVERS:
            h, _, ahead = np.array([cap_errors(slide, SCHEMES[scheme], cells) for cells in CELLS]).T
            rows.append([*falling([name, scheme], list(h)), f"{ahead[-1]:+.1e}"])
    table(["cap, degrees", "solver", *(f"h, {n} cells" for n in CELLS), "order", "centre ahead, m"], rows)


def models():
    rows = [[name, *(cap_errors(slide, SCHEMES["Relaxation"], 400, model)[0] for model in MODELS)] for name, slide in CAPS.items()]
    table(["cap, 400 cells", "shallow water", "reduced", "two-phase"], rows)


def dams():
    rows = []
    for name, slide in DAMS.items():
        for scheme in SOLVERS:
            h, speed = np.array([dam_errors(slide, SCHEMES[scheme], cells) for cells in CELLS]).T
            rows.append([*falling([name, scheme], list(h)), f"{speed[0]:+.0e}", f"{speed[-1]:+.0e}"])
    table(["dam, degrees", "solver", *(f"h, {n} cells" for n in CELLS), "order", "speed, 200", "speed, 1600"], rows)


# ---------------------------------------------------------------------- uniform flow, rest, a block, a column

#: law, slope, acceleration from rest, k of dv/dt = a - k v^2 for a layer of 1 m.
LAWS = {"Voellmy 0.2, 400": (gr.Voellmy(0.2, 400.0), 0.5, G * 0.3, G / 400.0), "Manning 0.05": (gr.Manning(0.05), 0.05, G * 0.05, G * 0.05**2),
        "Coulomb 0.2": (gr.CoulombFriction(0.2), 0.5, G * 0.3, 0.0)}


def speed_error(name, cells, t=6.0):
    """Return the relative error of the speed of a layer of 1 m that starts from rest, after 6 s."""
    law, slope, a, k = LAWS[name]
    grid = fv.Grid(0.0, 100.0, cells)
    ends = gr.UniformSlope(-slope), gr.UniformSlope(slope)
    problem = fv.Problem(gr.ShallowWater(g=G), grid, np.stack([np.ones(cells), np.zeros(cells)]), t, {"b": -slope * grid.centers}, ends, law)
    h, q = fv.solve(problem).q[-1][:, cells // 2]
    return abs(q / h / (np.sqrt(a / k) * np.tanh(np.sqrt(a * k) * t) if k else a * t) - 1.0)


def uniform():
    cells = (50, 100, 200, 400)
    table(["layer from rest", *(f"v/v - 1, {n} cells" for n in cells), "order"],
          [falling([name], [speed_error(name, n) for n in cells]) for name in LAWS])


def moved(name, model, scheme):
    """Largest change of a built-in scene that rests, of 200 cells."""
    return np.abs(np.diff(fv.solve(gr.scene(name).problem(model, 200), scheme).q[[0, -1]], axis=0)).max()


def rest():
    rows = [[name, *(max(moved(name, model, SCHEMES[scheme]) for scheme in SOLVERS) for model in MODELS)] for name in ("pile", "toe")]
    rows.append(["submerged-pile", "-", "-", max(moved("submerged-pile", gr.TwoPhase, SCHEMES[scheme]) for scheme in ("Relaxation", "Roe"))])
    table(["largest change of q", "shallow water", "reduced", "two-phase"], rows)
    scene = gr.scene("block-stop")
    solution = fv.solve(scene.problem(gr.ShallowWater, 10), times=[0.1, 0.2, 0.3, 0.4, 0.5])
    known = exact.block_stop(2.0, 0.5, np.array(solution.t), scene.g)
    print(f"\nblock: largest error of its speed {np.abs(solution.q[:, 1] - known[:, None]).max():.0e} m/s, at the end {solution.q[-1, 1].max():g} m/s")


def run_out(aspect, cells, nu=0.6):
    """Run-out of a column beyond its foot over its half width, at rest, and its height over the half width."""
    scene = attrs.evolve(gr.scene("column-collapse"), interval=(-8.0 - 12.0 * aspect, 8.0 + 12.0 * aspect), t_end=60.0,
                         initial=gr.ShapedFlow(gr.shapes.Block(0.0, 1.0, aspect), phi=1.0), sources=gr.CoulombFriction(nu))
    solution = fv.solve(scene.problem(gr.ShallowWater, cells), until=fv.StopAtRest(after=0.5))
    h = solution.observables()["h"]
    return solution.grid.centers[h > 1e-3 * aspect].max() - 1.0, h.max()


def column():
    rows = []
    for aspect in (0.5, 1.0, 2.0, 4.0, 8.0):
        (coarse, fine), law = (run_out(aspect, cells) for cells in (1000, 2000)), 1.2 * aspect if aspect < 1.8 else 1.9 * aspect ** (2.0 / 3.0)
        rows.append([f"{aspect:g}", f"{coarse[0]:.2f}", f"{fine[0]:.2f}", f"{law:.2f}", f"{fine[0] / law:.2f}", f"{fine[1]:.2f}"])
    table(["height/half width", "run-out, 1000 cells", "2000 cells", "Lube's law", "ratio", "height left"], rows)


if __name__ == "__main__":
    command(__doc__, {part.__name__: part for part in (caps, models, dams, uniform, rest, column)})
