"""Results of ``fvkit run``: solution, pictures and records in a folder, and the printed summary."""

import argparse
import json
import zipfile
from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import Any

import attrs
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from fvkit import Scheme, Solution, Status, load
from fvkit.cli import FAILED, INTERRUPTED, SUCCESS
from fvkit.files import remove
from fvkit.output.configuration import build
from fvkit.output.figures import FORMATS, new_axes, save_all
from fvkit.output.films import checked_film
from fvkit.output.plots import KINDS, MAPS, enlargement, space_time
from fvkit.pointwise.part import public_name
from fvkit.studies.scheme_names import settings
from fvkit.studies.tables import plain
from fvkit_granular.cli.options import DEFAULTS
from fvkit_granular.models.slope import deep, is_steep, said_of, steep_equations, steepest
from fvkit_granular.plots import slip
from fvkit_granular.scenes.reference import Reference
from fvkit_granular.scenes.scene import Scene
from fvkit_granular.studies.compare import deviations
from fvkit_granular.studies.hazard_report import file_names, is_record, write_hazard
from fvkit_granular.studies.mass_balance import MassBalance, mass_balance
from fvkit_granular.studies.series import told_along, write_series

#: Key of the configuration with the names of the files that a run wrote beside its solution.
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


@attrs.frozen(eq=False)
class Recorded:
    """Records of a run at every step, with its scene and the formats of its rasters and maps."""

    scene: Scene
    watched: dict[str, Any]
    ending: str
    picture: str

    @property
    def files(self) -> list[str]:
        """Names of the files that `write` makes."""
        return file_names(self.scene, self.ending, self.picture)

    def balance(self, solution: Solution) -> MassBalance | None:
        """The mass balance of a run on a terrain, None of others."""
        return None if self.scene.terrain is None else mass_balance(self.scene, solution, self.watched["hazard"])

    def write(self, folder: Path, solution: Solution, balance: MassBalance | None) -> str:
        """Write the files, and return what is to be printed."""
        if balance is not None:
            return write_hazard(folder, self.scene, solution, self.watched, balance, self.ending, self.picture)
        write_series(folder, self.watched, solution)
        return told_along(self.watched, solution)


def on_terrain(scene: Scene | None) -> bool:
    """Whether a scene is known and lies on a terrain: its maps are those of `write_hazard`."""
    return scene is not None and scene.terrain is not None


def ends(options: argparse.Namespace) -> Any:
    """The ends of the line of a cut, None for the middle."""
    return None if options.line is None else (options.line[:2], options.line[2:])


def run_name(scene: str, model: Any, scheme: Scheme) -> str:
    """Return scene, model and Riemann solver joined by hyphens, and the parts of the scheme that are not the default ones."""
    parts = settings(scheme)
    words = [parts["limiter"], parts["integrator"]] if parts["integrator"] else \
        [f"order-{parts['order']}"] if parts["order"] == 1 else [parts["limiter"]] * (parts["limiter"] != DEFAULTS["limiter"])
    return "-".join([scene, public_name(model), parts["riemann"], *words])


def show(folder: Path, name: str, solution: Solution, reference: Reference | None, options: argparse.Namespace,
         reached: float = 0.0, recorded: Recorded | None = None, again: str = "") -> int:
    """Write the files of a run, print its summary, and return the exit code.

    ``again`` is the command that continues the run where its result cannot be written.
    """
    kept = not solution.success and _succeeded(folder)
    folder = folder / UNSUCCESSFUL if kept else folder
    folder.mkdir(parents=True, exist_ok=True)
    axes, scene = len(solution.grid.axes), None if recorded is None else recorded.scene
    title = name if scene is None else scene.name or name
    names = written(axes, options, on_terrain(scene)) + ([] if recorded is None else recorded.files)
    earlier = _earlier(folder)
    solution.configuration.update({FILES: names, "scene": title})
    balance = None if recorded is None else recorded.balance(solution)
    if recorded is not None and balance is not None:
        solution.configuration.update({"crs": recorded.scene.terrain.crs, "mass_balance": plain(attrs.asdict(balance))})
    saved: list[Path] = []
    try:
        for file in [folder / "solution.npz", *([folder / "solution.nc"] if options.netcdf else []),
                     *([] if options.save is None else [options.save])]:
            file.parent.mkdir(parents=True, exist_ok=True)
            saved.append(solution.save(file))
        summary = _write_beside(folder, solution, options, recorded, balance)
        text = "\n  ".join(_told(title, solution, max(reached, _slope(solution)), summary, reference))
        save_all(folder, {SUMMARY: text + "\n"})
    except OSError as error:
        error.add_note(f"the run: {solution.message}")
        error.add_note(f"its result is kept in {saved[0]}, without all of the files beside it" if saved else
                       again or "its result is lost: with --checkpoint FILE it can go on from there")
        raise
    remove(folder, earlier, but=(*names, *(str(Path(name).with_suffix(".prj")) for name in names)))
    print(text)
    extra = "" if options.save is None else f", {options.save}"
    older = f"; {folder.parent}/ keeps the result of an earlier run" if kept else ""
    print(f"  written to {folder}/: {', '.join(names)}{extra}{older}")
    return SUCCESS if solution.success else INTERRUPTED if solution.status is Status.INTERRUPTED else FAILED


def _write_beside(folder: Path, solution: Solution, options: argparse.Namespace, recorded: Recorded | None,
                  balance: MassBalance | None) -> str:
    """Write pictures, film and what was recorded beside a solution, and return what is to be printed of the latter."""
    axes = len(solution.grid.axes)
    pictures = _pictures(axes, options, on_terrain(None if recorded is None else recorded.scene))
    save_all(folder, {f"{picture}.{options.format}": draw(solution) for picture, draw in pictures.items()})
    if options.animate is not None:
        film = folder / checked_film(options.animate)
        film.parent.mkdir(parents=True, exist_ok=True)
        if recorded is not None and on_terrain(recorded.scene):
            from fvkit_granular.terrain.maps import film_map

            film_map(solution, recorded.scene.terrain, film, recorded.scene.release)
        else:
            solution.animate(film, PROFILE if axes == 1 else "map")
    return "" if recorded is None else recorded.write(folder, solution, balance)


def _told(title: str, solution: Solution, slope: float, summary: str, reference: Reference | None) -> list[str]:
    """Return the lines of the summary of a run: scene, model and scheme, status, slopes, results and errors."""
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
    if len(grid.axes) == 1:
        lines += [f"in through the {side}: " + ", ".join(f"{mass} {volume:.6g}" for mass, volume in masses.items()) + " m2"
                  for side, masses in stats.entered.items() if any(masses.values())]
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
    """Pictures of the end, {name: function of the solution}; on a terrain only those of the options."""
    if axes > 1:
        lines = {"cut": {"line": ends(options)}}
        asked = {*options.plot, *["cut"] * (options.line is not None)} if terrain else set(MAPS)
        return {kind: partial(_drawn, draw, **lines.get(kind, {})) for kind, draw in MAPS.items() if kind in asked}
    return {PROFILE: partial(_drawn, _first)} | {kind: partial(_drawn, PLOTS[kind]) for kind in options.plot}


def _first(solution: Solution, ax: Axes) -> Axes:
    """Plot the state of one axis, or the profile where the relief would hide it."""
    return PLOTS["profile" if enlargement(solution) > 1.0 else "state"](solution, ax)


def written(axes: int, options: argparse.Namespace, terrain: bool) -> list[str]:
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
    """Names of the files of an earlier ``fvkit run`` in the folder, from its solution; none outside the folder."""
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
