"""How far may the debris come?
============================

An ensemble over drag, density ratio, friction and release volume, and its exceedance curve.

A block of debris, half grains and half water, is released on a dry slope of 3:10 that runs out on level ground. What is not
known of it varies as a Latin hypercube: release volume 4 to 12 m^2 (per metre of width), settling velocity of the grains
(drag) 0.1 to 10 m/s, density ratio fluid/solid 0.35 to 0.55, tangent of the bed's friction angle about 0.45. The front is the
last place with more than a centimetre of grains at 3 s; the curve is the share of members whose front gets there.
Flow and ranges are made up: it is the way that is shown. (With 60 members the curve is known to some 6 %.)

Usage: python examples/hazard_ensemble.py [FOLDER] [--members N] [--cells N] [--workers N] [--quiet]
Writes hazard_ensemble.png and hazard_ensemble.csv there. Members are kept in a folder there: a run that was stopped goes on.
"""

import argparse
from pathlib import Path

import numpy as np
from scipy import stats

import fvkit as fv
import fvkit_granular as gr
from fvkit.output.figures import COLORS, new_axes

RANGES = {"volume": (4.0, 12.0), "sources.v_T": (0.1, 10.0, "log"), "gamma": (0.35, 0.55),
          "sources.nu": stats.truncnorm(-2.5, 2.5, 0.45, 0.05)}
LABELS = {"volume": "release volume, m$^2$", "sources.v_T": "settling velocity, m/s", "gamma": "density ratio fluid/solid",
          "sources.nu": "bed friction, tangent"}


def bottom(x):
    return np.maximum(0.0, 0.3 * (10.0 - x))


def release(volume=8.0):
    """A level-topped block of debris on 0 < x < 4 on dry ground."""
    return gr.Scene((-2.0, 38.0), 3.0, lambda x: {"h": np.where((x > 0.0) & (x < 4.0), volume / 4.0, 0.0), "phi": 0.5},
                    bottom=bottom, sources=(gr.CoulombFriction(0.45), gr.PitmanLeDrag(1.0, 3.0)), name="release")


def front(solution):
    """The place of the front, m, and the largest depth, m."""
    seen = solution.observables()
    there = np.flatnonzero(seen["h"] * seen["phi"] > 0.01)
    return {"front": solution.grid.edges[there[-1] + 1], "depth": seen["h"].max()}


def draw(result, axes):
    """The exceedance curve, and the front over every parameter."""
    fronts = result.outputs["front"]
    far = np.sort(fronts[result.finished])
    axes[0].step(far, 1.0 - np.arange(len(far)) / len(far), where="post", color=COLORS[0])
    for share in (0.5, 0.1):
        place = np.quantile(far, 1.0 - share)
        axes[0].plot([place, place, far[0]], [0.0, share, share], color=COLORS[1], linewidth=0.9, linestyle="--")
        axes[0].annotate(f"{100 * share:.0f} % beyond {place:.1f} m", (far[0], share), textcoords="offset points", xytext=(0, 3),
                         fontsize="small")
    axes[0].set(xlabel="x, m", ylabel="share of fronts that get there", ylim=(0.0, 1.0))
    for ax, (name, label) in zip(axes[1:], LABELS.items(), strict=True):
        values = result.samples.values[name]
        ax.plot(values, fronts, ".", color=COLORS[0], markersize=4)
        rank = stats.spearmanr(values, fronts, nan_policy="omit").statistic
        ax.set(xlabel=label, ylabel="front, m", title=f"rank correlation {rank:+.2f}")
        if name == "sources.v_T":
            ax.set_xscale("log")
    for ax in axes:
        ax.grid(alpha=0.3)


def main():
    parser = argparse.ArgumentParser(description="An ensemble of releases, and how far they come.")
    parser.add_argument("folder", nargs="?", type=Path, default=Path())
    parser.add_argument("--members", type=int, default=60)
    parser.add_argument("--cells", type=int, default=160)
    parser.add_argument("--workers", type=int)
    parser.add_argument("--quiet", action="store_true", help="no progress bar")
    options = parser.parse_args()
    run = gr.SceneRun(release, cells=options.cells)
    samples = fv.Samples.latin_hypercube(RANGES, options.members, seed=1)
    options.folder.mkdir(parents=True, exist_ok=True)
    result = fv.sweep(run, samples, workers=options.workers, keep=front, progress=not options.quiet,
                      folder=options.folder / f"members-{options.members}-{options.cells}")
    far = result.outputs["front"]
    print(f"{int(result.finished.sum())} of {options.members} members in {result.elapsed:.1f} s; front from {np.nanmin(far):.1f} "
          f"to {np.nanmax(far):.1f} m, 10 % beyond {np.nanquantile(far, 0.9):.1f} m")
    figure, axes = new_axes(2, 3, width=3.6, height=3.6)
    axes.pop().remove()
    draw(result, axes)
    figure.savefig(options.folder / "hazard_ensemble.png", dpi=110)
    print(f"written: {options.folder / 'hazard_ensemble.png'}, {result.save(options.folder / 'hazard_ensemble.csv')}")


if __name__ == "__main__":
    main()
