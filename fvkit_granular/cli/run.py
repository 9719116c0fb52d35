"""``fvkit run``: one scene with one model and solver."""

import argparse
import json
import sys
import warnings
import zipfile
from collections.abc import Callable
from functools import partial
from pathlib import Path
from shlex import quote
from typing import Any

import attrs
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from fvkit import Checkpoint, Grid, Solution, Status, Step, StopAtRest, load, resume, solve, validation
from fvkit.cli import FAILED, INTERRUPTED, SUCCESS, add_command
from fvkit.files import remove, usable_folder
from fvkit.output.configuration import build, model_and_grid, parsed
from fvkit.output.figures import FORMATS, new_axes, save_all
from fvkit.output.films import checked_film
from fvkit.output.npz import CHECKPOINT, Archive, expect_format
from fvkit.output.plots import KINDS, MAPS, enlargement, line_of, space_time
from fvkit.pointwise.part import public_name
from fvkit.studies.scheme_names import settings
from fvkit.studies.tables import plain
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
from fvkit_granular.models.registry import MODELS
from fvkit_granular.plots import slip
from fvkit_granular.scenes.reference import Reference
from fvkit_granular.scenes.scene import Scene
from fvkit_granular.scenes.slope import SteepSlopeWarning, deep, is_steep, said_of, steep_equations, steepest, within_reach
from fvkit_granular.scenes.toml.read import SCENE_HELP, find_scene, scene_label
from fvkit_granular.studies.compare import deviations
from fvkit_granular.studies.hazard_report import file_names, is_record, write_hazard
from fvkit_granular.studies.mass_balance import mass_balance
from fvkit_granular.studies.scene_run import CELLS
from fvkit_granular.studies.series import told_along, write_series

#: Key of the configuration that says which files a run wrote beside its solution.
FILES = "files"

#: Pictures of the end of a scene with one axis, by name, the first of every run and others on request; and with two axes, all of
#: every run.
PROFILE = "profile"
PLOTS: dict[str, Any] = {**KINDS, "slip": slip, "space-time": space_time}

#: What is printed of a run, in its folder.
SUMMARY = "run.txt"

#: How the names of pictures and films end.
PICTURES = (*(f".{name}" for name in FORMATS), ".gif", ".mp4")

#: Folder within that of the results for those of a run that did not succeed, where an earlier one did.
UNSUCCESSFUL = "unsuccessful"

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
                     help="continue the run of a checkpoint; give the SCENE too where the run recorded something at every step, "
                          "as those on a terrain do")
    run.add_argument("--dt", type=float, metavar="S", help="length of every step, s (default: what the Courant number allows)")
    run.add_argument("--dt-max", type=float, metavar="S", help="longest step, s")
    run.add_argument("--dt-initial", type=float, metavar="S", help="longest first step, s")
    run.add_argument("--stop-at-rest", type=float, metavar="SPEED",
                     help="end the run when every velocity is below SPEED, m/s, wherever the flow is deeper than 1 mm")
    run.add_argument("--plot", nargs="+", type=checked(str, validation.choice, known={**PLOTS, **MAPS}), default=[],
                     metavar="KIND",
                     help=f"extra figures KIND.png: at the final time {', '.join(KINDS)}, slip (vs - vf), where margin is the "
                          "distance to loss of hyperbolicity; space-time: depth over x and t. For scenes with one axis; with two "
                          f"every run writes {', '.join(MAPS)}, on a terrain those that are named here")
    run.add_argument("--gauges", type=place_of, nargs="+", metavar="X",
                     help="places x, m, with two axes X,Y, whose series gauges.csv has, in place of those of the scene")
    run.add_argument("--threshold", type=checked(float, validation.real, above=0.0), metavar="H",
                     help="depth, m, from which on the flow counts as arrived: writes front.csv and maxima.csv with one axis, "
                          "on a terrain it is that of the maps of arrival and duration (default: that of the scene)")
    run.add_argument("--rasters", choices=("asc", "tif"), default="asc",
                     help="format of the rasters of a scene on a terrain (tif: GeoTIFF, extra geo; default asc: ESRI ASCII)")
    run.add_argument("--netcdf", action="store_true",
                     help="write solution.nc too, CF netCDF with the CRS of the terrain (extra io)")
    run.add_argument("--save", type=Path, metavar="FILE",
                     help="write the solution to this file too: .npz, or .nc, CF netCDF (extra io)")
    run.add_argument("--line", type=float, nargs=4, metavar=("X0", "Y0", "X1", "Y1"),
                     help="with two axes the ends of the line of cut.png, m (default: along x through the middle)")
    run.add_argument("--animate", metavar="NAME",
                     help="write an animation with 60 frames to the output folder: NAME.gif, or NAME.mp4 with ffmpeg")
    common_options(run, "fvkit-run-SCENE")


def _run(options: argparse.Namespace) -> int:
    if options.scene is None and options.resume is None:
        raise ValueError("fvkit run takes a SCENE, or --resume FILE: give one of them (see fvkit run --help)")
    if options.every is not None and options.checkpoint is None:
        raise ValueError("--every SECONDS says how often --checkpoint FILE is written: give that too")
    folder = results_folder(options, "run", options.resume.stem if options.scene is None else scene_label(options.scene))
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
    if options.resume is not None:
        return _resumed(options, folder)
    chosen = _scene(options)
    cells = options.cells if options.cells is not None or chosen.terrain is not None else CELLS[len(chosen.axes)]
    _check_pictures(chosen.grid(cells), folder, options, chosen)
    watched = _watched(chosen)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", SteepSlopeWarning)  # the report says it
        problem = chosen.problem(options.model, cells)
    scheme = scheme_of(options)
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
    code = _show(scene_label(options.scene), solution, reference, options, within_reach(problem, chosen.g),
                 Recorded(chosen, watched, f".{options.rasters}", options.format), kept)
    if kept:
        print(f"  {kept}")
    return code


def _netcdf_or_refuse() -> None:
    """Raise ValueError where the extra io is missing: before a run, not after it."""
    try:
        for name in ("xarray", "h5netcdf"):
            validation.library(name, "netCDF", "io")
    except ImportError as error:
        raise ValueError(str(error)) from None


def _scene(options: argparse.Namespace) -> Scene:
    """Return the scene, with what the options record in place of what it says."""
    found = find_scene(options.scene)
    asked = {key: getattr(options, key) for key in ("gauges", "threshold") if getattr(options, key) is not None}
    if "threshold" in asked and len(found.axes) > 1 and found.terrain is None:
        raise ValueError("--threshold is of front and maxima along one axis, or of maps on a terrain, and this scene is a plane: "
                         "leave it out")
    return attrs.evolve(found, watch=attrs.evolve(found.watch, **asked)) if asked else found


def _recording(options: argparse.Namespace) -> str:
    """The options that record something, as they are typed: a run goes on with the same ones."""
    gauges = [",".join(map(str, place)) if isinstance(place, tuple) else str(place) for place in options.gauges or ()]
    deep = [] if options.threshold is None else ["--threshold", str(options.threshold)]
    return "".join(f"{word} " for word in (*(["--gauges", *gauges] if gauges else []), *deep))


def _resumed(options: argparse.Namespace, folder: Path) -> int:
    """Go on with the run of a checkpoint, with what its scene records where that is given, and show it."""
    for name in ("dt", "dt_max", "dt_initial", "stop_at_rest", "cells", "checkpoint"):
        if getattr(options, name) is not None:
            raise ValueError(f"--{name.replace('_', '-')} is for a new run: --resume goes on as the run began")
    for name in ("gauges", "threshold"):
        if options.scene is None and getattr(options, name) is not None:
            raise ValueError(f"--{name} needs the SCENE of the run too: fvkit run SCENE --{name} ... --resume {options.resume}")
    archive = Archive(options.resume)
    expect_format(archive, CHECKPOINT)
    model, grid = model_and_grid(parsed(archive.text("configuration"), archive.path), archive.path)
    chosen = None if options.scene is None else _scene(options)
    _check_pictures(grid, folder, options, chosen)
    go_on = partial(resume, options.resume, progress=sys.stderr.isatty(), throw=False)
    if chosen is None:
        noted = parsed(archive.text("plan"), archive.path).get("observers", [])
        if isinstance(noted, list) and noted:
            raise ValueError(f"{options.resume} is of a run that recorded something at every step, which its scene describes: "
                             f"give that too, fvkit run SCENE --resume {options.resume}")
        return _show(options.resume.stem, go_on(), None, options)
    watched = _watched(chosen)
    if not callable(getattr(model, "conserved_from", None)):
        raise ValueError(f"--resume {options.resume} is of a run of {public_name(model)}, which no scene has made: leave "
                         "SCENE out")
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", SteepSlopeWarning)  # the report says it
        problem = chosen.problem(model, grid.num_cells)
    solution = go_on(problem=problem, observers=tuple(watched.values()))
    reference = chosen.known_reference() if solution.status is Status.FINISHED else None
    return _show(scene_label(options.scene), solution, reference, options, within_reach(problem, chosen.g),
                 Recorded(chosen, watched, f".{options.rasters}", options.format))


def _check_pictures(grid: Grid, folder: Path, options: argparse.Namespace, scene: Scene | None) -> None:
    """Refuse pictures that cannot be drawn or written, or are of the other number of axes, before anything is computed."""
    axes, records = len(grid.axes), [] if scene is None else file_names(scene, f".{options.rasters}", options.format)
    wrong = [kind for kind in options.plot if kind not in (PLOTS if axes == 1 else MAPS)]
    if wrong and axes > 1:
        raise ValueError(f"--plot {wrong[0]} draws over one axis, and this scene has two: leave it out, "
                         + (f"maps are written anyway, and {', '.join(MAPS)} with --plot" if on_terrain(scene) else
                            f"{', '.join(f'{kind}.png' for kind in MAPS)} are written anyway, the last along --line"))
    if wrong:
        raise ValueError(f"--plot {wrong[0]} draws over a plane, and this scene has one axis: take {', '.join(PLOTS)}")
    usable_folder(folder, "--out", (*_written(axes, options, on_terrain(scene)), *records))
    if options.line is None:
        return
    if axes == 1:
        raise ValueError("--line is the line of a cut through a plane, and this scene has one axis: leave it out")
    line_of(grid, _ends(options), "--line")


def on_terrain(scene: Scene | None) -> bool:
    """Whether a scene is known and lies on a terrain: its maps are those of `write_hazard`."""
    return scene is not None and scene.terrain is not None


def _ends(options: argparse.Namespace) -> Any:
    """The ends of the line of a cut, None for the middle."""
    return None if options.line is None else (options.line[:2], options.line[2:])


def _film_times(t_end: float, asked: tuple[float, ...] | None) -> tuple[float, ...]:
    """Output times of a film, those of the scene among them, none twice by rounding."""
    wanted, even = np.array(asked or (t_end,)), np.linspace(0.0, t_end, FRAMES + 1)[1:]
    near = np.isclose(even[:, None], wanted, rtol=0.0, atol=1e-9 * t_end).any(axis=1)
    return tuple(np.union1d(even[~near], wanted).tolist())


@attrs.frozen(eq=False)
class Recorded:
    """What a run has recorded at every step, the scene that asked for it, and the formats of its rasters and of its maps."""

    scene: Scene
    watched: dict[str, Any]
    ending: str
    picture: str

    @property
    def files(self) -> list[str]:
        """Names of the files that `write` makes."""
        return file_names(self.scene, self.ending, self.picture)

    def write(self, folder: Path, solution: Solution) -> str:
        """Write the files, and return what is to be printed."""
        if self.scene.terrain is not None:
            return write_hazard(folder, self.scene, solution, self.watched, self.ending, self.picture)
        write_series(folder, self.watched, solution)
        return told_along(self.watched, solution)


def _watched(scene: Scene) -> dict[str, Any]:
    """Return the observers of a run of a scene, by name; no hazard maps where a plane has no terrain to draw them on."""
    found = scene.watch.observers(len(scene.axes))
    drawn = scene.terrain is not None or len(scene.axes) == 1
    return found if drawn else {name: one for name, one in found.items() if name != "hazard"}


def _show(name: str, solution: Solution, reference: Reference | None, options: argparse.Namespace, reached: float = 0.0,
          recorded: Recorded | None = None, again: str = "") -> int:
    """Write the files of a run, print what is to be said, and return the exit code.

    ``again`` says how the run goes on where its result cannot be written.
    """
    folder = results_folder(options, "run", name)
    kept = not solution.success and _succeeded(folder)
    folder = folder / UNSUCCESSFUL if kept else folder
    folder.mkdir(parents=True, exist_ok=True)
    axes, scene = len(solution.grid.axes), None if recorded is None else recorded.scene
    title = name if scene is None else scene.name or name
    written = _written(axes, options, on_terrain(scene)) + ([] if recorded is None else recorded.files)
    earlier = _earlier(folder)
    solution.configuration.update({FILES: written, "scene": title})
    if recorded is not None and on_terrain(scene):
        solution.configuration["crs"] = recorded.scene.terrain.crs
        balance = attrs.asdict(mass_balance(recorded.scene, solution, recorded.watched["hazard"]))
        solution.configuration["mass_balance"] = plain(balance)
    saved: list[Path] = []
    try:
        for file in [folder / "solution.npz", *([folder / "solution.nc"] if options.netcdf else []),
                     *([] if options.save is None else [options.save])]:
            file.parent.mkdir(parents=True, exist_ok=True)
            saved.append(solution.save(file))
        summary = _write_beside(folder, solution, options, recorded)
        text = "\n  ".join(_told(title, solution, max(reached, _slope(solution)), summary, reference))
        save_all(folder, {SUMMARY: text + "\n"})
    except OSError as error:
        error.add_note(f"the run: {solution.message}")
        error.add_note(f"its result is kept in {saved[0]}, without all of the files beside it" if saved else
                       again or "its result is lost: with --checkpoint FILE it can go on from there")
        raise
    remove(folder, earlier, but=(*written, *(str(Path(name).with_suffix(".prj")) for name in written)))
    print(text)
    extra = "" if options.save is None else f", {options.save}"
    older = f"; {folder.parent}/ keeps the result of an earlier run" if kept else ""
    print(f"  written to {folder}/: {', '.join(written)}{extra}{older}")
    return SUCCESS if solution.success else INTERRUPTED if solution.status is Status.INTERRUPTED else FAILED


def _write_beside(folder: Path, solution: Solution, options: argparse.Namespace, recorded: Recorded | None) -> str:
    """Write pictures, film and what was recorded beside a solution, and return what is to be printed of the latter."""
    axes = len(solution.grid.axes)
    pictures = _pictures(axes, options, on_terrain(None if recorded is None else recorded.scene))
    save_all(folder, {f"{picture}.{options.format}": draw(solution) for picture, draw in pictures.items()})
    if options.animate is not None:
        film = folder / checked_film(options.animate)
        film.parent.mkdir(parents=True, exist_ok=True)
        solution.animate(film, PROFILE if axes == 1 else "map")
    return "" if recorded is None else recorded.write(folder, solution)


def _told(title: str, solution: Solution, slope: float, summary: str, reference: Reference | None) -> list[str]:
    """Return the lines that are said of a run: scene, model and scheme, how it went, its slopes, results and errors."""
    stats, grid, scheme = solution.stats, solution.grid, settings(build(solution.configuration["scheme"]))
    method = [scheme["limiter"], scheme["integrator"]] if scheme["integrator"] else [f"order {scheme['order']}"]
    lines = [", ".join([f"{title}: {public_name(solution.model)}", scheme["riemann"], *method, f"{grid.described} cells",
                        stats.backend]),
             f"{solution.message}; t = {solution.t[-1]:.6g} of {solution.configuration['t_end']:g} s",
             f"{stats.steps} steps ({stats.rejected} rejected), {stats.seconds:.3g} s, "
             f"{stats.ns_per_cell_step:.0f} ns per cell and step, largest Courant number {stats.max_cfl:.3f}",
             "mass drift " + ", ".join(f"{mass} {drift:.1e}" for mass, drift in stats.mass_drift.items())
             + f"; non-hyperbolic faces: {stats.nonhyperbolic_faces}"
             + (f", {stats.nonhyperbolic_films} of them where h < 0.05 m, largest depth {stats.deepest_nonhyperbolic:.3g} m"
                if stats.nonhyperbolic_faces else "")]
    if slope > 0.0:
        wrong = is_steep(slope) and not steep_equations(solution.model)
        lines.append(f"{'caution: ' if wrong else ''}{said_of(slope, solution.model)}")
    lines += summary.splitlines()
    if reference is not None:
        found = deviations(solution, reference.averages(solution.model, grid, float(solution.t[-1])))
        errors = {quantity: grid.cell_volume * float(difference.sum()) for quantity, difference in found.items()}
        lines.append("L1 error " + ", ".join(f"{quantity} {error:.3e}" for quantity, error in errors.items())
                     + f" ({reference.kind})")
    return lines


def _slope(solution: Solution) -> float:
    """The steepest slope of the bottom where the flow was, at any output; 0 where there is none."""
    h = np.array([solution.observables(k)["h"] for k in range(len(solution.t))])
    return steepest(solution.aux["b"], [axis.dx for axis in solution.grid.axes], deep(h).any(axis=0))


def _pictures(axes: int, options: argparse.Namespace, terrain: bool) -> dict[str, Callable[[Solution], Figure]]:
    """Pictures of the end, {name: function of the solution}; on a terrain those alone that are asked for."""
    if axes > 1:
        lines = {"cut": {"line": _ends(options)}}
        asked = {*options.plot, *["cut"] * (options.line is not None)} if terrain else set(MAPS)
        return {kind: partial(_drawn, draw, **lines.get(kind, {})) for kind, draw in MAPS.items() if kind in asked}
    return {PROFILE: partial(_drawn, _first)} | {kind: partial(_drawn, PLOTS[kind]) for kind in options.plot}


def _first(solution: Solution, ax: Axes) -> Axes:
    """Plot the state of one axis, or the profile where the relief would hide it."""
    return PLOTS["profile" if enlargement(solution) > 1.0 else "state"](solution, ax)


def _written(axes: int, options: argparse.Namespace, terrain: bool) -> list[str]:
    """Names of the files that ``fvkit run`` writes, the solution first."""
    films = [] if options.animate is None else [options.animate]
    solutions = ["solution.npz", *(["solution.nc"] if options.netcdf else [])]
    return [*solutions, SUMMARY, *(f"{picture}.{options.format}" for picture in _pictures(axes, options, terrain)), *films]


def _succeeded(folder: Path) -> bool:
    """Whether a folder holds the solution of a run that succeeded."""
    try:
        return load(folder / "solution.npz").success
    except (OSError, ValueError):
        return False


def _earlier(folder: Path) -> list[str]:
    """Names of what an earlier ``fvkit run`` wrote into its folder beside its solution, as that says; none outside."""
    try:
        with np.load(folder / "solution.npz", allow_pickle=False) as kept:
            names = list(json.loads(str(kept["configuration"]))[FILES])
    except (OSError, ValueError, KeyError, TypeError, zipfile.BadZipFile):
        return []
    found = [name for name in names if isinstance(name, str) and (Path(name).suffix in PICTURES or is_record(name)
             or name == "solution.nc") and (folder / name).resolve().is_relative_to(folder.resolve())]
    return found + [str(Path(name).with_suffix(".prj")) for name in found if name.endswith(".asc")]


def _drawn(draw: Callable[..., Axes], solution: Solution, **more: Any) -> Figure:
    """Return one picture of the end; a map chooses its own size."""
    if draw in MAPS.values() and draw is not MAPS["cut"]:
        found: Any = draw(solution, **more).figure
        return found
    figure, axes = new_axes(width=8.0, height=4.5)
    draw(solution, axes[0], **more)
    return figure
