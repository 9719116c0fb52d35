"""The tables of docs/theory/two_axes.md: `python -m tests.tools.two_axes_tables NAME`."""

import argparse
from collections.abc import Callable

import numpy as np

import fvkit as fv
import fvkit_granular as gr
from tests.plane.problems import CLOSED, square, state, vortex


def vortices() -> None:
    """Errors of both momenta of a vortex that stands, or is carried along the diagonal with 1 m/s along each axis."""
    for drift, t_end in ((0.0, 0.5), (1.0, 1.0)):
        for n in (50, 100, 200):
            problem, exact = vortex(n, drift, t_end)
            error = np.abs(fv.solve(problem).q[-1] - exact)[1:].mean(axis=(1, 2)).sum()
            print(f"drift {drift:g}, {n:3d} x {n:3d} cells: {error:.2e}")


def scenes() -> None:
    """Mean error of the depth over the mean depth, two phases, Relaxation, second order."""
    for name in ("vortex", "travelling-vortex", "two-phase-vortex", "thacker-rotating", "thacker-paraboloid", "radial-dam-break",
                 "radial-dam-break-dry"):
        errors = []
        for cells in (25, 50, 100):
            scene = gr.scene(name)
            problem = scene.problem(gr.TwoPhase, cells)
            h = fv.solve(problem, nonhyperbolic="ignore").observables()["h"]
            wanted = scene.known_reference().averages(problem.model, problem.grid, scene.t_end)
            errors.append(np.abs(h - wanted[0] - wanted[3]).mean() / h.mean())
        print(name, *(f"{error:.1e}" for error in errors))


def symmetry() -> None:
    """A circular dam break and its mirror images: along an axis and about the diagonal."""
    def dam(x, y):
        return [np.where(np.hypot(x - 5.0, y - 5.0) < 2.5, 2.0, 0.5), 0.0 * x, 0.0 * x]

    for n in (50, 100, 200):
        h = fv.solve(fv.Problem(gr.ShallowWater(), square(n), dam, 0.5, boundary=CLOSED)).q[-1][0]
        print(f"{n:3d} cells: |h - transposed h| mean {np.abs(h - h.T).mean():.1e}, largest {np.abs(h - h.T).max():.1e} m; "
              f"|h - mirrored h| {np.abs(h - h[::-1]).max():.0e}")


def along_the_front(froude: float, riemann: fv.RiemannSolver) -> float:
    """Return the largest speed along a front that stands on a grid line, over that of the flow before it."""
    ratio, v = 0.5 * (np.sqrt(1.0 + 8.0 * froude**2) - 1.0), froude * np.sqrt(9.81)
    grid, model = fv.Grid((0.0, 0.0), (80.0, 20.0), (80, 20)), gr.ShallowWater()
    q = fv.Problem(model, grid, lambda x, y: [np.where(x < 40.0, 1.0, ratio), v + 0.0 * x, 0.0 * x], 1.0).q0
    q = q * (1.0 + 1e-6 * np.random.default_rng(0).uniform(-1.0, 1.0, q.shape))
    sides = {"west": fv.Inflow([1.0, v, 0.0]), "east": fv.Inflow([ratio, v, 0.0]), "south": fv.Periodic(), "north": fv.Periodic()}
    solution = fv.solve(fv.Problem(model, grid, q, 600.0 / v, boundary=sides), fv.WavePropagation(riemann))
    return float(np.abs(solution.observables()["v_y"]).max() / v)


def carbuncle() -> None:
    """A standing jump on a grid line, disturbed by 1e-6, after the flow has passed 600 cells."""
    for froude in (2.0, 5.0, 10.0, 30.0):
        print(froude, *(f"{along_the_front(froude, riemann):.0e}" for riemann in (gr.Relaxation(), fv.Roe(), fv.HLL())))


def rough() -> None:
    """Largest speed of water over random ground in a closed box, which starts with 1 cm/s, after 20, 40 and 80 s."""
    grid, model = square(40), gr.ShallowWater()
    b = 0.5 * np.random.default_rng(0).uniform(size=grid.shape)
    problem = fv.Problem(model, grid, state(model, 1.0 - b, 1.0, (1e-2, 1e-2)), 80.0, aux={"b": b}, boundary=CLOSED)
    for order, riemann in ((1, gr.Relaxation()), (2, gr.Relaxation()), (1, fv.Roe())):
        found = fv.solve(problem, fv.WavePropagation(riemann, order=order), times=[20.0, 40.0, 80.0])
        print(order, riemann, *(f"{found.observables(i)['speed'].max():.0e}" for i in (1, 2, 3)))


TABLES: dict[str, Callable[[], None]] = {table.__name__: table for table in (vortices, scenes, symmetry, carbuncle, rough)}

if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("name", choices=TABLES)
    TABLES[parser.parse_args().name]()
