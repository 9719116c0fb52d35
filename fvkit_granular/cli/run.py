"""``fvkit run``: one scene with one model and solver."""

import argparse
import sys
import warnings
from functools import partial
from pathlib import Path
from shlex import quote
from typing import Any

import attrs
import numpy as np

from fvkit import Checkpoint, Grid, Scheme, Status, Step, StopAtRest, resume, solve, validation
from fvkit.cli import add_command
from fvkit.files import usable_folder
from fvkit.output.configuration import model_and_grid, parsed, part
from fvkit.output.films import checked_film
from fvkit.output.npz import CHECKPOINT, Archive, expect_format
from fvkit.output.plots import KINDS, MAPS, cut_line
from fvkit.pointwise.part import public_name
from fvkit_granular.cli.options import (
    add_scheme_options,
    cells_of,
    checked,
    common_options,
    one_of,
    place_of,
    results_folder,
    scheme_of,
)
from fvkit_granular.cli.run_results import PLOTS, Recorded, ends, on_terrain, run_name, show, written
from fvkit_granular.models.registry import MODELS
from fvkit_granular.models.slope import SteepSlopeWarning, within_reach
from fvkit_granular.scenes.scene import Scene
from fvkit_granular.scenes.toml.read import SCENE_HELP, find_scene, scene_label
from fvkit_granular.studies.hazard_report import file_names
from fvkit_granular.studies.scene_run import CELLS

#: Outputs of a film.
FRAMES = 60


def register(commands: Any) -> None:
    """Add the command to the parser of ``fvkit``."""
    run = add_command(commands, "run", _run, "run one scene with one model and solver",
                      "fvkit run riemann --cells 800 --out result\n"
                      "  fvkit run simple-wave --reconstruction mp5 --integrator dp5\n"
                      "  fvkit run dam-break-island --cells 200 --line 0 5 20 5 --animate island.gif")
    run.add_argument("scene", metavar="SCENE", nargs="?", help=SCENE_HELP)
    one_of(run, "--model", MODELS, "two-phase")
    add_scheme_options(run, several=False)
    run.add_argument("--cells", type=cells_of, metavar="N",
                     help=f"number of cells (default {CELLS[1]}); with two axes along x, of nearly square cells (default "
                          f"{CELLS[2]}), or NXxNY, such as 80x40")
    run.add_argument("--checkpoint", type=Path, metavar="FILE",
                     help="write checkpoints to FILE (.npz) so that an interrupted run can be resumed")
    run.add_argument("--every", type=float, metavar="SECONDS", help="wall time between two checkpoints (default 60)")
    run.add_argument("--resume", type=Path, metavar="FILE",
                     help="continue the run of a checkpoint; give the SCENE as well if the run records gauges, front or maxima, "
                          "as every run on a terrain does")
    run.add_argument("--dt", type=float, metavar="S", help="constant time step, s (default: set by the Courant number)")
    run.add_argument("--dt-max", type=float, metavar="S", help="largest time step, s")
    run.add_argument("--dt-initial", type=float, metavar="S", help="largest first time step, s")
    run.add_argument("--stop-at-rest", type=float, metavar="SPEED",
                     help="end the run when every velocity is below SPEED, m/s, wherever the flow is deeper than 1 mm")
    run.add_argument("--plot", nargs="+", type=checked(str, validation.choice, known={**PLOTS, **MAPS}), default=[],
                     metavar="KIND",
                     help=f"extra figures KIND.png. One axis: {', '.join(KINDS)} and slip (vs - vf) at the final time, where "
                          "margin is the distance to loss of hyperbolicity, and space-time, the depth over x and t. Two axes: "
                          f"{', '.join(MAPS)}, which are written anyway except on a terrain")
    run.add_argument("--gauges", type=place_of, nargs="+", metavar="X",
                     help="positions of gauges, x in m, or X,Y with two axes; their time series go to gauges.csv (default: "
                          "those of the scene)")
    run.add_argument("--threshold", type=checked(float, validation.real, above=0.0), metavar="H",
                     help="depth, m, above which the flow has arrived (default: that of the scene); with one axis it writes "
                          "front.csv and maxima.csv, on a terrain it applies to the maps of arrival and duration")
    run.add_argument("--rasters", choices=("asc", "tif"), default="asc",
                     help="format of rasters, for a scene on a terrain: asc, ESRI ASCII (default), or tif, GeoTIFF (extra geo)")
    run.add_argument("--netcdf", action="store_true",
                     help="also write solution.nc, CF netCDF with the CRS of the terrain (extra io)")
    run.add_argument("--save", type=Path, metavar="FILE",
                     help="also save the solution to FILE: .npz, or .nc for CF netCDF (extra io)")
    run.add_argument("--line", type=float, nargs=4, metavar=("X0", "Y0", "X1", "Y1"),
                     help="end points, m, of the section in cut.png, for two axes (default: along x through the middle)")
    run.add_argument("--animate", metavar="NAME",
                     help="write an animation with 60 frames to the output folder: NAME.gif, or NAME.mp4 with ffmpeg")
    common_options(run, "fvkit-run-SCENE-MODEL-SOLVER")


def _run(options: argparse.Namespace) -> int:
    if options.scene is None and options.resume is None:
        raise ValueError("fvkit run needs a SCENE or --resume FILE (see fvkit run --help)")
    if options.every is not None and options.checkpoint is None:
        raise ValueError("--every SECONDS is the interval of --checkpoint FILE: give that too")
    if options.resume is not None:
        return _resumed(options)
    chosen, scheme = _scene(options), scheme_of(options)
    folder = _usable(options, run_name(scene_label(options.scene), options.model, scheme))
    cells = options.cells if options.cells is not None or chosen.terrain is not None else CELLS[len(chosen.axes)]
    _check_pictures(chosen.grid(cells), folder, options, chosen)
    watched = _watched(chosen)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", SteepSlopeWarning)  # the report says it
        problem = chosen.problem(options.model, cells)
    many = options.animate is not None or "space-time" in options.plot
    times = _film_times(problem.t_end, chosen.times) if many else chosen.times
    checkpoint = None if options.checkpoint is None else \
        Checkpoint(options.checkpoint, 60.0 if options.every is None else options.every)
    until = None if options.stop_at_rest is None else StopAtRest(options.stop_at_rest)
    solution = solve(problem, scheme, times, step=Step(options.dt, options.dt_max, options.dt_initial), until=until,
                     checkpoint=checkpoint, observers=tuple(watched.values()), backend=options.backend,
                     progress=sys.stderr.isatty(), throw=False)
    reference = chosen.known_reference() if solution.status is Status.FINISHED else None
    again = f"{quote(options.scene)} {_recording(options)}" if watched else ""
    kept = f"checkpoint {checkpoint.path}: fvkit run {again}--resume {quote(str(checkpoint.path))}" \
        if checkpoint is not None and checkpoint.path.exists() else ""
    code = show(folder, scene_label(options.scene), solution, reference, options, within_reach(problem, chosen.g),
                 Recorded(chosen, watched, f".{options.rasters}", options.format), kept)
    if kept:
        print(f"  {kept}")
    return code


def _usable(options: argparse.Namespace, name: str) -> Path:
    """Return the folder of the results of a run with this name, after a check that all of its files can be written."""
    folder = results_folder(options, "run", name)
    usable_folder(folder, "--out")
    if options.animate is not None:
        usable_folder((folder / checked_film(options.animate)).parent, "--animate")
    if options.save is not None:
        if options.save.suffix not in (".npz", ".nc") or options.save.is_dir():
            raise ValueError(f"`--save` must be a file that ends in .npz or .nc, got {str(options.save)!r}")
        usable_folder(options.save.parent, "--save")
    if options.netcdf or (options.save is not None and options.save.suffix == ".nc"):
        _netcdf_or_refuse()
    if options.checkpoint is not None:
        usable_folder(options.checkpoint.parent, "--checkpoint")
    return folder


def _netcdf_or_refuse() -> None:
    """Raise ValueError where the extra io is missing: before a run, not after it."""
    try:
        for name in ("xarray", "h5netcdf"):
            validation.library(name, "netCDF", "io")
    except ImportError as error:
        raise ValueError(str(error)) from None


def _scene(options: argparse.Namespace) -> Scene:
    """Return the scene, with the records that the options ask for in place of its own."""
    found = find_scene(options.scene)
    asked = {key: getattr(options, key) for key in ("gauges", "threshold") if getattr(options, key) is not None}
    if "threshold" in asked and len(found.axes) > 1 and found.terrain is None:
        raise ValueError("--threshold serves scenes with one axis and scenes on a terrain, and this one is a plane: leave it out")
    return attrs.evolve(found, watch=attrs.evolve(found.watch, **asked)) if asked else found


def _recording(options: argparse.Namespace) -> str:
    """The options for records, as they are typed: a continued run needs the same ones."""
    gauges = [",".join(map(str, place)) if isinstance(place, tuple) else str(place) for place in options.gauges or ()]
    deep = [] if options.threshold is None else ["--threshold", str(options.threshold)]
    return "".join(f"{word} " for word in (*(["--gauges", *gauges] if gauges else []), *deep))


def _resumed(options: argparse.Namespace) -> int:
    """Go on with the run of a checkpoint, with what its scene records where that is given, and show it."""
    for name in ("dt", "dt_max", "dt_initial", "stop_at_rest", "cells", "checkpoint"):
        if getattr(options, name) is not None:
            raise ValueError(f"--{name.replace('_', '-')} is for a new run: --resume goes on as the run began")
    for name in ("gauges", "threshold"):
        if options.scene is None and getattr(options, name) is not None:
            raise ValueError(f"--{name} needs the SCENE of the run: fvkit run SCENE --{name} ... --resume {options.resume}")
    archive = Archive(options.resume)
    expect_format(archive, CHECKPOINT)
    configuration = parsed(archive.text("configuration"), archive.path)
    model, grid = model_and_grid(configuration, archive.path)
    label = options.resume.stem if options.scene is None else scene_label(options.scene)
    folder = _usable(options, run_name(label, model, part(configuration, "scheme", Scheme, archive.path)))
    chosen = None if options.scene is None else _scene(options)
    _check_pictures(grid, folder, options, chosen)
    go_on = partial(resume, options.resume, progress=sys.stderr.isatty(), throw=False)
    if chosen is None:
        noted = parsed(archive.text("plan"), archive.path).get("observers", [])
        if isinstance(noted, list) and noted:
            raise ValueError(f"{options.resume} is of a run with gauges, front or maxima, which its scene describes: give the "
                             f"scene too, fvkit run SCENE --resume {options.resume}")
        return show(folder, label, go_on(), None, options)
    watched = _watched(chosen)
    if not callable(getattr(model, "conserved_from", None)):
        raise ValueError(f"--resume {options.resume} is of a run of {public_name(model)}, which no scene has made: leave "
                         "SCENE out")
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", SteepSlopeWarning)  # the report says it
        problem = chosen.problem(model, grid.num_cells)
    solution = go_on(problem=problem, observers=tuple(watched.values()))
    reference = chosen.known_reference() if solution.status is Status.FINISHED else None
    return show(folder, label, solution, reference, options, within_reach(problem, chosen.g),
                 Recorded(chosen, watched, f".{options.rasters}", options.format))


def _check_pictures(grid: Grid, folder: Path, options: argparse.Namespace, scene: Scene | None) -> None:
    """Refuse pictures that cannot be drawn or written, or are of the other number of axes, before anything is computed."""
    axes, records = len(grid.axes), [] if scene is None else file_names(scene, f".{options.rasters}", options.format)
    wrong = [kind for kind in options.plot if kind not in (PLOTS if axes == 1 else MAPS)]
    if wrong and axes > 1:
        raise ValueError(f"--plot {wrong[0]} needs a scene with one axis, and this one has two: leave it out, "
                         + (f"maps are written anyway, and {', '.join(MAPS)} with --plot" if on_terrain(scene) else
                            f"{', '.join(f'{kind}.png' for kind in MAPS)} are written anyway, the last along --line"))
    if wrong:
        raise ValueError(f"--plot {wrong[0]} needs a scene with two axes, and this one has one: take {', '.join(PLOTS)}")
    usable_folder(folder, "--out", (*written(axes, options, on_terrain(scene)), *records))
    if options.line is None:
        return
    if axes == 1:
        raise ValueError("--line needs a scene with two axes, and this one has one: leave it out")
    cut_line(grid, ends(options), "--line")


def _film_times(t_end: float, asked: tuple[float, ...] | None) -> tuple[float, ...]:
    """Output times of a film, those of the scene among them, none twice by rounding."""
    wanted, even = np.array(asked or (t_end,)), np.linspace(0.0, t_end, FRAMES + 1)[1:]
    near = np.isclose(even[:, None], wanted, rtol=0.0, atol=1e-9 * t_end).any(axis=1)
    return tuple(np.union1d(even[~near], wanted).tolist())


def _watched(scene: Scene) -> dict[str, Any]:
    """Return the observers of a run of a scene, by name; no hazard maps where a plane has no terrain to draw them on."""
    found = scene.watch.observers(len(scene.axes))
    drawn = scene.terrain is not None or len(scene.axes) == 1
    return found if drawn else {name: one for name, one in found.items() if name != "hazard"}
