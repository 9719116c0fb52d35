"""A Riemann problem of gas dynamics with two axes
===============================================

Your own model in the plane: four states that meet at a point, with a shock between each two neighbours.

The Euler equations are a model of four components without phases. A sweep along an axis sees the velocity u along it and v
across; ``vectors = ((1, 2),)`` says that the momenta in rows 1 and 2 are the components of one vector, so a sweep along y sees
them exchanged. Nothing else in the model depends on the number of axes.

The problem is its own mirror image about the diagonal x = y. Sweeps along x and y take turns, so the solution is that up to the
error of the splitting alone; the script prints by how much it is not.

Source of the states: remembered as configuration 3 of Lax and Liu, SIAM J. Sci. Comput. 19 (1998) 319-340; the script prints by
how much they miss the jump conditions of four shocks.

Usage: python examples/gas_in_the_plane.py [FOLDER [CELLS]]     (writes gas_in_the_plane.png there; default: the current folder,
100 cells along each axis)
"""

import sys
from pathlib import Path
from typing import ClassVar

import attrs
import numpy as np

import fvkit as fv


@attrs.frozen
class Gas(fv.Model):
    """Euler equations of an ideal gas, q = (rho, rho u, rho v, E): u is the velocity along a sweep, v that across."""

    conserved: ClassVar[tuple[str, ...]] = ("rho", "rho u", "rho v", "E")
    vectors: ClassVar[tuple[tuple[int, ...], ...]] = ((1, 2),)

    kappa: float = 1.4

    def pressure(self, q):
        rho, m, n, e = q
        return (self.kappa - 1.0) * (e - 0.5 * (m * m + n * n) / rho)

    def flux(self, q):
        rho, m, n, e = q
        u, p = m / rho, self.pressure(q)
        return m, m * u + p, n * u, (e + p) * u

    def wave_speeds(self, q):
        u, c = q[1] / q[0], np.sqrt(self.kappa * self.pressure(q) / q[0])
        return u - c, u + c


MODEL, CORNER = Gas(), 0.8


def states(x, y):
    """Return the four states: gas at rest north-east of the corner, which the others move towards."""
    west, south = x < CORNER, y < CORNER
    beyond = west.astype(int) + south.astype(int)
    rho, p = np.array([1.5, 0.5323, 0.138])[beyond], np.array([1.5, 0.3, 0.029])[beyond]
    u, v = np.where(west, 1.206, 0.0), np.where(south, 1.206, 0.0)
    return [rho, rho * u, rho * v, p / (MODEL.kappa - 1.0) + 0.5 * rho * (u * u + v * v)]


def misses(x, y, towards):
    """Return by how much the shock between two places misses its jump conditions, over the largest jump of the flux."""
    ends = [np.array(states(np.array(a), np.array(b))) for a, b in ((x, y), towards)]
    along = [q if x != towards[0] else q[[0, 2, 1, 3]] for q in ends]
    change, push = along[1] - along[0], np.subtract(MODEL.flux(along[1]), MODEL.flux(along[0]))
    speed = push[0] / change[0]
    return float(np.abs(push - speed * change).max() / np.abs(push).max())


def main(folder: Path, cells: int) -> None:
    corners = [(0.9, 0.9), (0.1, 0.9), (0.1, 0.1), (0.9, 0.1)]
    worst = max(misses(*here, there) for here, there in zip(corners, corners[1:] + corners[:1], strict=True))
    print(f"the four shocks miss their jump conditions by {worst:.0e}")
    grid = fv.Grid((0.0, 0.0), (1.0, 1.0), (cells, cells))
    solution = fv.solve(fv.Problem(MODEL, grid, states, 0.8), fv.WavePropagation(fv.HLL()))
    print(f"{solution.status.value}: t = {solution.t[-1]:g}, {solution.stats.steps} steps")
    rho = solution.q[-1][0]
    asymmetry = np.abs(rho - rho.T).mean() / rho.mean()
    print(f"mean distance of rho from its mirror image about the diagonal, over its mean: {asymmetry:.1e}")
    axes = solution.plot(kind="map", name="rho")
    x, y = grid.axes
    axes.contour(x.centers, y.centers, rho, levels=30, colors="white", linewidths=0.4)
    folder.mkdir(parents=True, exist_ok=True)
    axes.figure.savefig(folder / "gas_in_the_plane.png", dpi=100)


if __name__ == "__main__":
    main(Path(sys.argv[1] if len(sys.argv) > 1 else "."), int(sys.argv[2]) if len(sys.argv) > 2 else 100)
