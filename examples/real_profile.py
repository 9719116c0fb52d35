"""Debris in a channel from a CSV file
===================================

How far does a debris volume come? A scene file, end to end.

real_profile.toml describes the run: the interval, 900 m^2 of debris (per metre of width) released near the top, Voellmy's
friction, Pitman and Le's drag, the output times, and channel.csv, the distance and elevation of a torrent with check dams, a fan
and a valley floor. Profile, volume and constants are made up. ``fvkit run real_profile.toml``
runs the same; put your own survey in place of channel.csv.

The fluid of the two-phase model has no dry friction and drags the grains: the deposit creeps on for a while, and a film of
some centimetres stays in the channel.

Usage: python examples/real_profile.py [FOLDER] [--cells N]
Prints the front at every output and the deposit at the end; writes real_profile.png.
"""

import argparse
import sys
from pathlib import Path

import numpy as np

import fvkit as fv
import fvkit_granular as gr
from fvkit.output.figures import COLORS, new_axes

#: Depth that counts as debris, m, speed of grains that counts as deposited, m/s, and how much the picture stretches depths.
THRESHOLD, SLOW, STRETCH = 0.1, 0.5, 8.0


def front(solution: fv.Solution, output: int) -> float:
    """Right edge of the last cell that is deeper than the threshold, m."""
    deep = np.flatnonzero(solution.observables(output)["h"] > THRESHOLD)
    return float(solution.grid.edges[deep[-1] + 1])


def tell(solution: fv.Solution) -> None:
    """Print the position of the front at every output, and the deposit at the end."""
    print("  t, s   front, m   largest depth, m   at x, m   fastest grains, m/s")
    x, dx = solution.grid.centers, solution.grid.dx
    for output, t in enumerate(solution.t):
        seen = solution.observables(output)
        top = int(np.argmax(seen["h"]))
        fastest = np.abs(seen["vs"][seen["h"] > THRESHOLD]).max()
        print(f"{t:6.0f} {front(solution, output):10.1f} {seen['h'][top]:18.2f} {x[top]:9.1f} {fastest:21.2f}")
    end = solution.observables()
    slow = (np.abs(end["vs"]) < SLOW) & (end["h"] > THRESHOLD)
    volume = dx * end["h"]
    print(f"deposit (deeper than {THRESHOLD:g} m, grains slower than {SLOW:g} m/s): {volume[slow].sum():.0f} of "
          f"{volume.sum():.0f} m^2, from x = {x[slow].min():.0f} to {x[slow].max():.0f} m, {end['h'][slow].mean():.2f} m deep,\n"
          f"creeping at {np.median(np.abs(end['vs'][slow])):.2f} m/s in the median")
    stats = solution.stats
    print(f"complex speeds at {stats.nonhyperbolic_faces} faces and steps, {stats.nonhyperbolic_films} of them in films; the "
          f"deepest is {stats.deepest_nonhyperbolic:.2f} m deep")


def draw(solution: fv.Solution, path: Path) -> None:
    """The debris over the channel, depths stretched, and the depth alone."""
    figure, (channel, depth) = new_axes(2, 1, width=9.0, height=3.6)
    x, b = solution.grid.centers, solution.aux["b"]
    channel.fill_between(x, b, b.min() - 10.0, color="0.85")
    channel.plot(x, b, color="0.35", linewidth=1.2, label="channel")
    shown = [0, 2, 4, len(solution.t) - 1]
    for color, output in zip(COLORS, shown, strict=False):
        h = solution.observables(output)["h"]
        deep = h > 0.02
        channel.fill_between(x, b, b + STRETCH * h, where=deep, color=color, alpha=0.75, linewidth=0.0,
                             label=f"t = {solution.t[output]:.0f} s")
        depth.plot(x, np.where(deep, h, np.nan), color=color, label=f"t = {solution.t[output]:.0f} s")
    depth.axvline(front(solution, -1), color="0.35", linewidth=0.9, linestyle="--")
    channel.set(ylabel="elevation, m", title=f"debris in the channel, depth drawn {STRETCH:g} times")
    depth.set(xlabel="distance, m", ylabel="depth, m", ylim=(0.0, None), title="depth; dashed: front at the end")
    for axes in (channel, depth):
        axes.set_xlim(*solution.grid.edges[[0, -1]])
        axes.grid(alpha=0.3)
        axes.legend(fontsize="small")
    figure.savefig(path, dpi=100)


def main() -> None:
    parser = argparse.ArgumentParser(description="Debris in a channel from a CSV file.")
    parser.add_argument("folder", nargs="?", type=Path, default=Path())
    parser.add_argument("--cells", type=int, default=350)
    options = parser.parse_args()
    scene = gr.load_scene(Path(sys.argv[0]).with_name("real_profile.toml"))
    solution = fv.solve(scene.problem(gr.TwoPhase, options.cells), times=scene.times, nonhyperbolic="ignore")  # told below
    tell(solution)
    options.folder.mkdir(parents=True, exist_ok=True)
    draw(solution, options.folder / "real_profile.png")
    print(f"written: {options.folder / 'real_profile.png'}")


if __name__ == "__main__":
    main()
