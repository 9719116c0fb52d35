"""Internal shocks with and without in-cell shocks
===============================================

Speeds, plateaus and the choice of path.

The momentum equations of the two-phase model hold products that are no fluxes. A shock of the inner fields then depends on
the path across it, and on a grid also on the viscosity of the scheme: its speed stays some percent off, at any number of
cells. With ``in_cell_shocks=True`` it converges to the weak solution of the stated path, the segment in the depths.

Usage: python examples/internal_shocks.py [FOLDER [CELLS ...]]     (writes internal_shocks.png into FOLDER, default: the
current one; CELLS default to 200 500 1000), or --cost in place of all: what the option costs, measured in turns.
"""

import sys
from pathlib import Path
from statistics import median

import numpy as np

import fvkit as fv
import fvkit_granular as gr
from fvkit.output.figures import COLORS, new_axes
from fvkit.studies.tables import filled

NAMES = ("riemann", "dam-break-phi", "phi-jump")
SCENES = {name: gr.scene(name) for name in NAMES}
SCHEMES = {
    "Roe": fv.WavePropagation(fv.Roe()),
    "Roe, in-cell": fv.WavePropagation(fv.Roe(), in_cell_shocks=True),
    "Relaxation": fv.WavePropagation(gr.Relaxation()),
    "Relaxation, in-cell": fv.WavePropagation(gr.Relaxation(), in_cell_shocks=True),
}


def semi_exact(scene: gr.Scene) -> gr.exact.TwoPhaseRiemann:
    """The four waves of a Riemann scene."""
    flow = scene.initial(np.array([-1.0, 1.0]))
    left, right = ([float(flow[name][side]) for name in ("h", "phi", "vs", "vf")] for side in (0, 1))
    return gr.exact.two_phase_riemann(left, right, g=scene.g, gamma=scene.gamma)


def medians(solution: fv.Solution, exact: gr.exact.TwoPhaseRiemann) -> np.ndarray:
    """Medians of q over the middle half of the three plateaus between the waves, (3, 4)."""
    x, t, result = solution.grid.centers, solution.t[-1], []
    for before, after in zip(exact.waves, exact.waves[1:], strict=False):
        low, high = before.tail * t, after.head * t
        inside = np.abs(x - 0.5 * (low + high)) < 0.25 * (high - low)
        result.append(np.median(solution.q[-1][:, inside], axis=1))
    return np.array(result)


def plateau_errors(solution: fv.Solution, exact: gr.exact.TwoPhaseRiemann) -> np.ndarray:
    """Largest error of a component of q on each plateau, (3,)."""
    wanted = np.array([[s.hs, s.hs * s.vs, s.hf, s.hf * s.vf] for s in exact.states[1:4]])
    return np.abs(medians(solution, exact) - wanted).max(axis=1)


def mean_speed(x: np.ndarray, dx: float, values: np.ndarray, left: float, right: float, t: float) -> float:
    """Speed of the single jump from left to right that has the integral of the values."""
    first, last = x[0] - 0.5 * dx, x[-1] + 0.5 * dx
    return float((values.sum() * dx + left * first - right * last) / (left - right) / t)


def speed_error(solution: fv.Solution, exact: gr.exact.TwoPhaseRiemann) -> float:
    """Relative error of the mean speed of the 2-wave, by the integral of hs - hf from one plateau's middle to the next."""
    t, (_, second, third, _) = solution.t[-1], exact.waves
    low, high = 0.5 * (exact.waves[0].tail + second.head) * t, 0.5 * (second.tail + third.head) * t
    x, q = solution.grid.centers, solution.q[-1]
    inside = (x > low) & (x < high)
    sides = medians(solution, exact)[:2] @ np.array([1.0, 0.0, -1.0, 0.0])
    found = mean_speed(x[inside], solution.grid.dx, (q[0] - q[2])[inside], *sides, t)
    fine = np.linspace(low, high, 20_001)
    seen = exact.at(fine, t)
    wanted = mean_speed(fine, fine[1] - fine[0], (2.0 * seen["phi"] - 1.0) * seen["h"],
                        *(state.hs - state.hf for state in exact.states[1:3]), t)
    return (found - wanted) / abs(wanted)


def line(solution: fv.Solution, exact: gr.exact.TwoPhaseRiemann) -> tuple[float, str]:
    """Largest plateau error, and all that is measured, as text."""
    plateaus = plateau_errors(solution, exact)
    seen = exact.at(solution.grid.centers, solution.t[-1])
    l1 = np.abs(solution.q[-1][0] - seen["phi"] * seen["h"]).sum() * solution.grid.dx
    drift = max(map(abs, solution.stats.mass_drift.values()))
    return plateaus.max(), (f"{100.0 * speed_error(solution, exact):+11.2f} %   "
                            + "  ".join(f"{value:7.1e}" for value in plateaus) + f"   {l1:7.1e}  {drift:6.0e}")


def main(folder: Path, cells: list[int]) -> None:
    figure, (profile, error) = new_axes(1, 2)
    print(f"{'scene':14} {'scheme':20} {'cells':>5}  2-wave speed   plateaus: left, middle, right  L1(hs)   mass drift")
    for name, scene in SCENES.items():
        exact = semi_exact(scene)
        for color, (label, scheme) in zip(COLORS, SCHEMES.items(), strict=False):
            solutions = [fv.solve(scene.problem(gr.TwoPhase, count), scheme) for count in cells]
            measured = [line(solution, exact) for solution in solutions]
            for count, (_, text) in zip(cells, measured, strict=True):
                print(f"{name:14} {label:20} {count:5d} {text}")
            if scene is SCENES["dam-break-phi"]:
                error.loglog(cells, [worst for worst, _ in measured], color=color, marker="o", markersize=4, label=label)
                profile.plot(solutions[-1].grid.centers, solutions[-1].q[-1][0], color=color, label=label)
        print(filled(scene.known_reference().path_sensitivity()["text"]) + "\n")
    scene = SCENES["dam-break-phi"]
    exact, x = semi_exact(scene), np.linspace(-0.5, 2.0, 1001)
    seen = exact.at(x, scene.t_end)
    profile.plot(x, seen["phi"] * seen["h"], color="0.35", linestyle="--", label="semi-exact, segment path")
    middle = exact.states[2].hs
    profile.set(xlabel="x, m", ylabel="solid depth hs, m", xlim=(-0.4, 1.5), ylim=(middle - 0.01, middle + 0.015),
                title=f"dam-break-phi: middle plateau, {cells[-1]} cells")
    error.set_xticks(cells, labels=cells)
    error.minorticks_off()
    error.set(xlabel="cells", ylabel="largest error of q on a plateau", title="dam-break-phi")
    for axes in (profile, error):
        axes.grid(alpha=0.3)
        axes.legend(fontsize="small")
    folder.mkdir(parents=True, exist_ok=True)
    figure.savefig(folder / "internal_shocks.png", dpi=100)


def cost() -> None:
    """Print the time per cell and step without and with the option, and their ratio, run in turns."""
    labels = list(SCHEMES)
    for plain, marked in zip(labels[::2], labels[1::2], strict=True):
        for count, repeats in ((1000, 15), (10_000, 3)):
            problem = SCENES["dam-break-phi"].problem(gr.TwoPhase, count)
            stats = [[fv.solve(problem, SCHEMES[label]).stats for label in (plain, marked)] for _ in range(repeats)]
            without, with_it = (median(1e9 * pair[k].seconds / pair[k].cell_updates for pair in stats) for k in (0, 1))
            print(f"{plain:10} {count:6d} cells: {without:6.1f} -> {with_it:6.1f} ns, x {with_it / without:.2f}")


if __name__ == "__main__":
    if sys.argv[1:] == ["--cost"]:
        cost()
        sys.exit()
    main(Path(sys.argv[1] if len(sys.argv) > 1 else "."), [int(count) for count in sys.argv[2:]] or [200, 500, 1000])
