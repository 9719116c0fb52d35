"""The reduced model as the limit of strong drag
=============================================

Measured and predicted, for a dam break with a jump of phi.

For large D the slip is w = vf - vs = g (1-gamma)(1-phi) h phi_x/(2 D rho) (Chapman-Enskog), so phi diffuses:

    (h phi)_t + (h phi v)_x = (kappa h phi_x)_x,   kappa = g (1-gamma) h phi (1-phi)^2/(2 D rho).

The full model differs from the reduced one by a contact that is smeared over sqrt(4 kappa t): an error like D^(-1/2).
Where the grid smears the contact more than that, stronger drag makes no difference. That floor is higher than the error of
the reduced model on the same grid, most likely because transport, between two steps of drag, parts the contact into waves.

Usage: python examples/drag_limit.py [FOLDER]     (writes drag_limit.png there; default: the current folder)
"""

import sys
from pathlib import Path

import attrs
import numpy as np
from scipy.integrate import cumulative_trapezoid, solve_ivp, trapezoid

import fvkit as fv
import fvkit_granular as gr
from fvkit.output.figures import COLORS, new_axes

SCENE = gr.scene("dam-break-phi")
LIMIT = gr.exact.reduced_riemann((3.0, 0.7, 0.0), (2.0, 0.4, 0.0), g=SCENE.g, gamma=SCENE.gamma)
DRAGS = np.geomspace(1e-1, 1e5, 13)


def predicted_contact(drag: float, points: int = 201) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return x, phi and slip about the diffused contact at the end of the scene.

    With the mass coordinate m, dm = h dx, the equation above is phi_t = (kappa h^2 phi_m)_m; rho h^2 is uniform, for the
    pressure is.
    """
    first, last, g, gamma, t = LIMIT.star_left, LIMIT.star_right, SCENE.g, SCENE.gamma, SCENE.t_end
    pressure = first.h**2 * (first.phi + gamma * (1.0 - first.phi))

    def depth(phi):
        return np.sqrt(pressure / (phi + gamma * (1.0 - phi)))

    def slip_per_slope(phi):
        return g * (1.0 - gamma) * (1.0 - phi) * depth(phi) / (2.0 * drag * (phi + gamma * (1.0 - phi)))

    def kappa(phi):
        return phi * (1.0 - phi) * slip_per_slope(phi)

    m = np.linspace(-1.0, 1.0, points) * 6.0 * np.sqrt(4.0 * kappa(0.5) * t) * first.h
    dm = m[1] - m[0]

    def diffusion(_, phi):
        middle = 0.5 * (phi[1:] + phi[:-1])
        flux = kappa(middle) * depth(middle) ** 2 * np.diff(phi) / dm
        return np.concatenate([[0.0], np.diff(flux) / dm, [0.0]])

    start = np.where(m < 0.0, first.phi, np.where(m > 0.0, last.phi, 0.5 * (first.phi + last.phi)))
    phi = solve_ivp(diffusion, (0.0, t), start, method="LSODA", lband=1, uband=1, rtol=1e-6, atol=1e-8).y[:, -1]
    x = cumulative_trapezoid(1.0 / depth(phi), m, initial=0.0)
    x += first.v * t - x[points // 2]
    return x, phi, slip_per_slope(phi) * np.gradient(phi, x)


def distance(x: np.ndarray, phi: np.ndarray) -> float:
    """L1 distance of phi from the reduced solution."""
    away = np.abs(phi - LIMIT.at(x, SCENE.t_end)["phi"])
    return float(trapezoid(away, x))


def run(model: type, drag: float, cells: int) -> tuple[np.ndarray, dict[str, np.ndarray]]:
    """Return x and the observables of a model at the end of the scene."""
    problem = attrs.evolve(SCENE, sources=gr.ConstantDrag(drag)).problem(model, cells)
    return problem.grid.centers, fv.solve(problem, fv.WavePropagation(fv.Roe())).observables()


def main(folder: Path) -> None:
    figure, (error, profile) = new_axes(1, 2)
    predicted = [distance(*predicted_contact(drag)[:2]) for drag in DRAGS]
    error.loglog(DRAGS, predicted, color="0.35", linestyle="--", label="predicted: diffused contact")
    print("   D, 1/s   predicted   ", end="")
    measured = {}
    for color, cells in zip(COLORS, (400, 1200), strict=False):
        print(f"{cells:5d} cells", end="  ")
        runs = [run(gr.TwoPhase, drag, cells) for drag in DRAGS]
        measured[cells] = [distance(x, seen["phi"]) for x, seen in runs]
        largest = [np.abs(seen["vs"] - seen["vf"]).max() for _, seen in runs]
        error.loglog(DRAGS, measured[cells], color=color, marker="o", markersize=4, label=f"full model, {cells} cells")
        x, seen = run(gr.Reduced, 0.0, cells)
        error.axhline(distance(x, seen["phi"]), color=color, linewidth=0.9, linestyle=":", label=f"reduced model, {cells} cells")
    print("largest slip, m/s")
    for row in zip(DRAGS, predicted, *measured.values(), largest, strict=True):
        print("{:9.3g}   {:9.2e}   {:9.2e}  {:9.2e}   {:9.2e}".format(*row))
    error.set(xlabel="D, 1/s", ylabel="L1 distance of phi from the reduced solution, m", ylim=(1e-3, 1.5))
    for color, drag in zip(COLORS, (30.0, 100.0, 300.0), strict=False):
        x, seen = run(gr.TwoPhase, drag, 1200)
        profile.plot(x, seen["vf"] - seen["vs"], color=color, label=f"D = {drag:g} 1/s")
        x, _, slip = predicted_contact(drag)
        profile.plot(x, slip, color=color, linestyle="--")
    profile.plot([], [], color="0.35", linestyle="--", label="predicted")
    profile.set(xlabel="x, m", ylabel="slip vf - vs, m/s", xlim=(-0.1, 1.3))
    for axes in (error, profile):
        axes.grid(alpha=0.3)
        axes.legend(fontsize="small")
    folder.mkdir(parents=True, exist_ok=True)
    figure.savefig(folder / "drag_limit.png", dpi=130)


if __name__ == "__main__":
    main(Path(sys.argv[1] if len(sys.argv) > 1 else "."))
