"""``fvkit check``: everything that a scene on a terrain reads, in words and one picture, before it is run."""

import argparse
import warnings
from itertools import chain
from pathlib import Path
from typing import Any

import numpy as np

from fvkit.cli import SUCCESS, add_command
from fvkit.files import usable_folder
from fvkit.output.figures import save_all
from fvkit.pointwise.part import public_name
from fvkit.problem.directions import SIDES
from fvkit_granular.cli.options import one_of
from fvkit_granular.models.registry import MODELS
from fvkit_granular.models.slope import SteepSlopeWarning, said_of, within_reach
from fvkit_granular.scenes.scene import Scene
from fvkit_granular.scenes.toml.read import SCENE_HELP, find_scene, scene_label
from fvkit_granular.sources.line_inflow import LineInflow
from fvkit_granular.studies.advise_terrain import effort
from fvkit_granular.terrain.hydrograph import series_of


def register(commands: Any) -> None:
    """Add the command to the parser of ``fvkit``."""
    check = add_command(commands, "check", _check, "check a scene on a terrain before a run: figure, volumes, slopes, run time",
                        "fvkit check torrent.toml --out check.png")
    check.add_argument("scene", metavar="SCENE", help=SCENE_HELP)
    one_of(check, "--model", MODELS, "two-phase")
    check.add_argument("--out", type=Path, metavar="FILE", help="figure, .png (default SCENE-check.png)")


def _check(options: argparse.Namespace) -> int:
    scene = find_scene(options.scene)
    label = scene_label(options.scene)
    if scene.terrain is None:
        raise ValueError(f"fvkit check is for scenes on a terrain, and {label} has none: for a profile run "
                         f"fvkit advise {options.scene}")
    picture = Path(f"{label}-check.png") if options.out is None else options.out
    if picture.suffix != ".png":
        raise ValueError(f"--out must end in .png, got {picture}")
    usable_folder(picture.parent, "--out")
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", SteepSlopeWarning)  # said below
        problem = scene.problem(options.model)
    scene.watch.observers(2)  # which warn of what looks like another unit
    print(scene.terrain.describe())
    if scene.release is not None:
        print(scene.release)
    slope = within_reach(problem, scene.g)
    print(f"{public_name(problem.model)}: {said_of(slope, problem.model)}; ground that the flow may reach")
    for source in problem.sources:
        print(f"source: {type(source).__name__}" + (f" in {len(cells)} cells" if (cells := source.acts_in()) is not None else "")
              + _brought(source, scene))
    print(f"{problem.grid.described} cells, {problem.t_end:g} s: {effort(scene, problem)}")
    save_all(picture.parent, {picture.name: _picture(scene)})
    print(f"written: {picture}")
    return SUCCESS


def _brought(source: Any, scene: Scene) -> str:
    """What a hydrograph brings in the time of the run, in words."""
    given = series_of(source)
    if given is None:
        return ""
    volume = scene.terrain.grid.cell_volume * given.brought(scene.t_end)
    said = f", a hydrograph: {volume:.6g} m3 by {scene.t_end:g} s, from {given.times[0]:g} to {given.times[-1]:g} s"
    if not isinstance(source, LineInflow):
        return said
    speed: Any = source.speed_x
    x, y = _direction(source)
    return f"{said}, at up to {speed.values.max():.4g} m/s towards {np.degrees(np.arctan2(x, y)) % 360.0:.0f} degrees " \
        "(90 is east)"


def _direction(source: Any) -> np.ndarray:
    """The mean direction of flow that comes in through a line, (x, y) of length 1."""
    mean = np.array([(along.shape * source.intensity.shape).sum() for along in (source.speed_x, source.speed_y)])
    return np.asarray(mean / np.hypot(*mean))


def _picture(scene: Scene) -> Any:
    """Return the figure of terrain, release, hydrographs, gauges and lines, with the conditions at the four sides."""
    from fvkit_granular.terrain.maps import draw_map

    released = None if scene.release is None else scene.release.thickness
    axes = draw_map(scene.terrain, released, "release, m (vertical)", release=scene.release)
    for source in filter(series_of, scene.sources):
        rows, columns = np.unravel_index(source.intensity.cells, scene.terrain.grid.shape)
        x, y = scene.terrain.grid.axes[0].centers[columns], scene.terrain.grid.axes[1].centers[rows]
        axes.plot(x, y, "s", color="#56B4E9", markeredgecolor="#0072B2", markersize=4)
        axes.annotate("hydrograph", (x[0], y[0]), xytext=(6, -10), textcoords="offset points", fontsize=9)
        if isinstance(source, LineInflow):
            axes.quiver(x.mean(), y.mean(), *_direction(source).tolist(), color="#0072B2", scale=12.0, width=0.008, zorder=3)
    for k, (x, y) in enumerate(scene.watch.gauges):
        axes.plot(x, y, "v", color="#0072B2", markeredgecolor="white", markersize=9)
        axes.annotate(f"gauge {k}", (x, y), xytext=(6, 4), textcoords="offset points", fontsize=9)
    for name, points in scene.watch.lines.items():
        axes.plot(*np.array(points).T, color="#009E73", linewidth=2.0)
        axes.annotate(name, points[0], xytext=(6, 4), textcoords="offset points", fontsize=9)
    if scene.watch.path:
        axes.plot(*np.array(scene.watch.path).T, color="#CC79A7", linewidth=1.5, linestyle="--")
        axes.annotate("path", scene.watch.path[0], xytext=(6, -10), textcoords="offset points", fontsize=9)
    axes.figure.supxlabel(", ".join(f"{side}: {public_name(condition)}" for side, condition in zip(
        chain.from_iterable(SIDES), scene.boundary, strict=True)), fontsize=8)
    return axes.figure
