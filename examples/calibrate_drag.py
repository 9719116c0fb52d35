"""Drag and friction from one gauge
================================

A fit with scipy.optimize.least_squares.

The scene `debris-slope` with known drag (settling velocity 2 m/s) and friction (0.53) gives depths at a gauge at x = 6, with a
noise of 2 mm. From these 40 numbers the fit finds both parameters again, and how well they are known: standard deviations from
the Jacobian at the optimum. The parameters are varied in their logarithms, so they stay positive; `fv.sweep` runs the
neighbours that the Jacobian needs, at once where there are processors (--workers).

Usage: python examples/calibrate_drag.py [FOLDER] [--workers N]     (writes calibrate_drag.png there)
"""

import argparse
from pathlib import Path

import numpy as np
from scipy.optimize import least_squares

import fvkit as fv
import fvkit_granular as gr
from fvkit.output.figures import COLORS, new_axes

NAMES, TRUE, START = ("sources.v_T", "sources.nu"), np.array([2.0, 0.53170943]), np.array([0.5, 0.3])
GAUGE, NOISE, TIMES = 6.0, 0.002, np.linspace(0.05, 2.0, 40)
RUN = gr.SceneRun("debris-slope", cells=120, times=tuple(TIMES))

#: Relative step of the differences: below it, limiters and the switch of friction make the depth rough.
STEP = 1e-2


def gauge(solution):
    """Depth at the gauge over time, m, between the centres of the cells."""
    depths = [solution.observables(i)["h"] for i in range(1, len(solution.t))]
    return {"h": np.array([np.interp(GAUGE, solution.grid.centers, h) for h in depths])}


def depths(rows, workers):
    """The gauge's series for rows of parameters, (rows, times)."""
    result = fv.sweep(RUN, dict(zip(NAMES, np.transpose(rows), strict=True)), workers=workers, keep=gauge)
    if not result.success:
        raise RuntimeError(f"a run failed: {result.message[~result.finished][0]}")
    return result.outputs["h"]


def fit(measured, workers):
    """Return the parameters, their standard deviations and the number of runs."""
    runs = 0

    def residuals(logs):
        nonlocal runs
        runs += 1
        return (depths([np.exp(logs)], 1)[0] - measured) / NOISE

    def jacobian(logs):
        nonlocal runs
        steps = STEP * np.eye(len(logs))
        rows = np.exp(np.concatenate([logs + steps, logs - steps]))
        runs += len(rows)
        ahead, behind = np.split(depths(rows, workers) / NOISE, 2)
        return ((ahead - behind) / (2.0 * STEP)).T

    found = least_squares(residuals, np.log(START), jacobian, x_scale="jac", xtol=1e-6, ftol=1e-6)
    covariance = np.linalg.inv(found.jac.T @ found.jac)
    return np.exp(found.x), np.exp(found.x) * np.sqrt(np.diag(covariance)), runs


def main():
    parser = argparse.ArgumentParser(description="Drag and friction from one gauge.")
    parser.add_argument("folder", nargs="?", type=Path, default=Path())
    parser.add_argument("--workers", type=int, default=1, help="processes (default 1: a start takes longer than a run)")
    options = parser.parse_args()
    exact = depths([TRUE], 1)[0]
    measured = exact + NOISE * np.random.default_rng(7).standard_normal(len(TIMES))
    found, deviation, runs = fit(measured, options.workers)
    for name, true, start, value, error in zip(NAMES, TRUE, START, found, deviation, strict=True):
        print(f"{name}: {value:.4f} +- {error:.4f} (true {true:.4f}, started at {start:g})")
    print(f"{runs} runs")
    first, last = depths([START, found], 1)
    figure, (ax,) = new_axes()
    ax.plot(TIMES, measured, ".", color="0.4", label="gauge, noise 2 mm")
    ax.plot(TIMES, exact, color=COLORS[2], linewidth=3.0, alpha=0.4, label="true parameters")
    ax.plot(TIMES, first, color=COLORS[1], linestyle="--", label="start of the fit")
    ax.plot(TIMES, last, color=COLORS[0], label=f"fit: v_T = {found[0]:.2f} m/s, nu = {found[1]:.3f}")
    ax.set(xlabel="t, s", ylabel=f"depth at x = {GAUGE:g} m, m")
    ax.grid(alpha=0.3)
    ax.legend(fontsize="small")
    options.folder.mkdir(parents=True, exist_ok=True)
    figure.savefig(options.folder / "calibrate_drag.png", dpi=110)
    print(f"written: {options.folder / 'calibrate_drag.png'}")


if __name__ == "__main__":
    main()
