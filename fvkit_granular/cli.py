"""The commands on scenes: ``fvkit scenes``, ``fvkit run``, ``fvkit compare``; others are registered here."""

import argparse
import json
import sys
import warnings
import zipfile
from collections.abc import Callable, Mapping
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from fvkit import Checkpoint, Solution, Status, StopAtRest, _validate, resume, solve
from fvkit.backends import BACKENDS
from fvkit.cli import FAILED, INTERRUPTED, SUCCESS, add_command, done_so_far
from fvkit.configuration import build
from fvkit.io import remove, usable_folder, write_whole
from fvkit.names import LIMITERS, public_name
from fvkit.pictures import KINDS, checked_film, space_time
from fvkit.plot import new_axes
from fvkit.study.pictures import PICTURES
from fvkit.study.settings import settings
from fvkit_granular import advise_command, convergence_command, sweep_command
from fvkit_granular.bench import ORDERS, bench
from fvkit_granular.compare import compare, compared, deviations
from fvkit_granular.parts import COMPARED, MODELS, RIEMANN
from fvkit_granular.pictures import slip
from fvkit_granular.scene import Reference, Scene
from fvkit_granular.scene_file import SCENE_HELP, find_scene, scene_label
from fvkit_granular.scene_text import scene_text
from fvkit_granular.scenes import scene, scene_names
from fvkit_granular.scheme_options import WAVES, add_scheme_options, methods_of, pick, scheme_of, schemes_of
from fvkit_granular.slope import SteepSlopeWarning, deep, is_steep, sentence, steepest
from fvkit_granular.stress import command as stress_command

#: What may stand on an axis of --plot-axes: columns of report.csv, of which some go on with a dot and a quantity.
AXES = ("order", "cells", "steps", "rejected", "seconds", "seconds_min", "ns_per_cell_step", "error", "error_l2", "error_max",
        "order_observed", "mass_drift")

#: Those that have a value for each quantity of the model.
BY_QUANTITY = ("error", "error_l2", "error_max", "order_observed")

#: Outputs of a film.
FRAMES = 60

#: Key of the configuration that says which files a run wrote beside its solution.
FILES = "files"


def register(commands: Any) -> None:
    """Add the commands to the parser of ``fvkit``."""
    listed = add_command(commands, "scenes", _scenes, "list the built-in scenes, or show one as a TOML file",
                         "fvkit scenes --show riemann > mine.toml")
    listed.add_argument("--show", metavar="SCENE", help="print one as TOML: a file that runs to the same result, to the bit")
    run = add_command(commands, "run", _run, "run one scene with one model and solver",
                      "fvkit run riemann --cells 800 --out result\n  fvkit run simple-wave --reconstruction mp5 --integrator dp5")
    run.add_argument("scene", metavar="SCENE", nargs="?", help=SCENE_HELP)
    run.add_argument("--model", default="two-phase", help=f"one of {', '.join(MODELS)} (default two-phase)")
    add_scheme_options(run, several=False)
    run.add_argument("--cells", type=int, default=400, help="number of cells (default 400)")
    run.add_argument("--checkpoint", type=Path, metavar="FILE", help="file (.npz) to continue from, should the run be stopped")
    run.add_argument("--every", type=float, metavar="SECONDS", help="wall time between two checkpoints (default 60)")
    run.add_argument("--resume", type=Path, metavar="FILE", help="continue the run of a checkpoint, instead of a SCENE")
    run.add_argument("--dt", type=float, metavar="S", help="length of every step, s (default: what the Courant number allows)")
    run.add_argument("--dt-max", type=float, metavar="S", help="longest step, s")
    run.add_argument("--dt-initial", type=float, metavar="S", help="longest first step, s")
    run.add_argument("--stop-at-rest", type=float, metavar="SPEED",
                     help="end the run when every velocity is below SPEED, m/s, wherever the flow is deeper than 1 mm")
    run.add_argument("--plot", nargs="+", default=[], metavar="KIND",
                     help=f"more pictures, KIND.png: any of {', '.join(KINDS)}, slip, of the end, and space-time, of the depth")
    run.add_argument("--animate", metavar="NAME", help="a film of 60 outputs in the folder: NAME.gif, or NAME.mp4 with ffmpeg")
    _common(run, "fvkit-run-SCENE")
    study = add_command(commands, "compare", _compare, "compare models and solvers on one scene: error against time",
                        "fvkit compare riemann --cells 100 200 400\n"
                        "  fvkit compare simple-wave --method wave-propagation method-of-lines --reconstruction mp5 weno5\n"
                        "  fvkit compare riemann --seconds 2 --plot-axes steps error.phi")
    study.add_argument("scene", metavar="SCENE", help=SCENE_HELP)
    study.add_argument("--models", nargs="+", default=list(COMPARED), metavar="M",
                       help=f"any of {', '.join(MODELS)} (default: {' '.join(COMPARED)})")
    add_scheme_options(study, several=True)
    study.add_argument("--cells", nargs="+", type=int, default=[100, 200, 400, 800], metavar="N",
                       help="numbers of cells (default 100 200 400 800)")
    study.add_argument("--repeats", type=int, default=3, help="timed repeats of each run (default 3)")
    study.add_argument("--seconds", type=float, metavar="S",
                       help="wall time that one run may take: slower ones stop, or are left out (default: no limit)")
    study.add_argument("--plot-axes", nargs=2, action="append", default=[], metavar=("X", "Y"),
                       help="draw one more picture, column Y of report.csv over column X, such as steps error.h")
    _common(study, "fvkit-compare-SCENE")
    speed = add_command(commands, "bench", _bench, "measure ns per cell and step for every model, solver, backend and order",
                        "fvkit bench --cells 1000 10000 --orders 2")
    speed.add_argument("--cells", nargs="+", type=int, default=[100, 1000, 10_000, 100_000], metavar="N",
                       help="numbers of cells (default 100 1000 10000 100000)")
    speed.add_argument("--orders", nargs="+", type=int, default=[1, 2], metavar="P",
                       help="any of 1, 2 and 5, which is a stage of MP5 (default 1 2)")
    speed.add_argument("--backends", nargs="+", metavar="B", help="numba, numpy or both (default: what is installed)")
    speed.add_argument("--repeats", type=int, default=5, help="timed blocks of each case (default 5)")
    speed.add_argument("--out", type=Path, default=Path("fvkit-bench"), help="folder for the results (default fvkit-bench)")
    stress_command.register(commands, _teller)
    advise_command.register(commands, _teller)
    convergence_command.register(commands, _teller)
    sweep_command.register(commands)


def _common(parser: argparse.ArgumentParser, folder: str) -> None:
    parser.add_argument("--backend", default="auto", help=f"one of {', '.join(BACKENDS)} (default auto)")
    parser.add_argument("--out", type=Path, help=f"folder for the results (default {folder})")


def _folder(options: argparse.Namespace, command: str, name: str) -> Path:
    """The folder of the results."""
    return options.out or Path(f"fvkit-{command}-{name}")


def _scenes(options: argparse.Namespace) -> int:
    if options.show is not None:
        print(scene_text(find_scene(options.show)), end="")
        return SUCCESS
    for name in scene_names():
        print(f"{name:19s} {scene(name).description}")
    return SUCCESS


def _run(options: argparse.Namespace) -> int:
    if (options.scene is None) == (options.resume is None):
        raise ValueError("fvkit run takes a SCENE, or --resume FILE: give one of them (see fvkit run --help)")
    if options.every is not None and options.checkpoint is None:
        raise ValueError("--every SECONDS says how often --checkpoint FILE is written: give that too")
    for kind in options.plot:
        _validate.choice(kind, "--plot", (*KINDS, "slip", "space-time"))
    folder = _folder(options, "run", options.resume.stem if options.scene is None else scene_label(options.scene))
    usable_folder(folder, "--out", _written(options))
    if options.animate is not None:
        usable_folder((folder / checked_film(options.animate)).parent, "--animate")
    if options.checkpoint is not None:
        usable_folder(options.checkpoint.parent, "--checkpoint")
    if options.resume is not None:
        for name in ("dt", "dt_max", "dt_initial", "stop_at_rest"):
            if getattr(options, name) is not None:
                raise ValueError(f"--{name.replace('_', '-')} is for a new run: --resume goes on as the run began")
        solution = resume(options.resume, progress=sys.stderr.isatty(), throw=False)
        return _show(options.resume.stem, solution, None, options)
    chosen = find_scene(options.scene)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", SteepSlopeWarning)  # the report says it
        problem = chosen.problem(pick([options.model], "--model", MODELS)[0], options.cells)
    scheme = scheme_of(options)
    many = options.animate is not None or "space-time" in options.plot
    times = _film_times(problem.t_end, chosen.times) if many else chosen.times
    checkpoint = None if options.checkpoint is None else \
        Checkpoint(options.checkpoint, 60.0 if options.every is None else options.every)
    stop = None if options.stop_at_rest is None else StopAtRest(options.stop_at_rest)
    solution = solve(problem, scheme, times, backend=options.backend, progress=sys.stderr.isatty(), throw=False,
                     checkpoint=checkpoint, stop=stop, dt=options.dt, dt_max=options.dt_max, dt_initial=options.dt_initial)
    reference = chosen.known_reference() if solution.status is Status.FINISHED else None
    kept = f"checkpoint {checkpoint.path}: fvkit run --resume {checkpoint.path}" \
        if checkpoint is not None and checkpoint.path.exists() else ""
    try:
        code = _show(scene_label(options.scene), solution, reference, options)
    except OSError as error:
        error.add_note(f"the run: {solution.message}")
        error.add_note(kept or "its result is lost: with --checkpoint FILE it can go on from there")
        raise
    if kept:
        print(f"  {kept}")
    return code


def _film_times(t_end: float, asked: tuple[float, ...] | None) -> tuple[float, ...]:
    """Output times of a film, those of the scene among them, none twice by rounding."""
    wanted, even = np.array(asked or (t_end,)), np.linspace(0.0, t_end, FRAMES + 1)[1:]
    near = np.isclose(even[:, None], wanted, rtol=0.0, atol=1e-9 * t_end).any(axis=1)
    return tuple(np.union1d(even[~near], wanted).tolist())


def _show(name: str, solution: Solution, reference: Reference | None, options: argparse.Namespace) -> int:
    """Write the files of a run, print what is to be said, and return the exit code."""
    folder = _folder(options, "run", name)
    folder.mkdir(parents=True, exist_ok=True)
    earlier, written = _earlier(folder), _written(options)
    solution.configuration[FILES] = written
    solution.save(folder / written[0])
    for picture, kind in ({"profile": "state"} | {kind: kind for kind in options.plot}).items():
        _draw(solution, kind, folder / f"{picture}.png")
    if options.animate is not None:
        film = folder / checked_film(options.animate)
        film.parent.mkdir(parents=True, exist_ok=True)
        solution.animate(film, "profile")
    remove(folder, earlier, but=written)
    stats, grid, t_end = solution.stats, solution.grid, solution.configuration["t_end"]
    named = settings(build(solution.configuration["scheme"]))
    print(", ".join([f"{name}: {public_name(solution.model)}", named["riemann"], *_method(named), f"{grid.num_cells} cells",
                     stats.backend]))
    print(f"  {solution.message}; t = {solution.t[-1]:.6g} of {t_end:g} s")
    print(f"  {stats.steps} steps ({stats.rejected} rejected), {stats.seconds:.3g} s, "
          f"{stats.ns_per_cell_step:.0f} ns per cell and step, largest Courant number {stats.max_cfl:.3f}")
    print("  mass drift " + ", ".join(f"{mass} {drift:.1e}" for mass, drift in stats.mass_drift.items())
          + f"; faces with complex speeds: {stats.nonhyperbolic_faces}"
          + (f", {stats.nonhyperbolic_films} of them in films below 5 cm, the deepest {stats.deepest_nonhyperbolic:.3g} m"
             if stats.nonhyperbolic_faces else ""))
    slope = _slope(solution)
    if slope > 0.0:
        print(f"  {'caution: ' if is_steep(slope) else ''}{sentence(slope)}")
    if reference is not None:
        found = deviations(solution, reference.averages(solution.model, grid, float(solution.t[-1])))
        errors = {quantity: grid.dx * float(difference.sum()) for quantity, difference in found.items()}
        print("  L1 error " + ", ".join(f"{quantity} {error:.3e}" for quantity, error in errors.items()) + f" ({reference.kind})")
    print(f"  written to {folder}/: {', '.join(written)}")
    return SUCCESS if solution.success else INTERRUPTED if solution.status is Status.INTERRUPTED else FAILED


def _slope(solution: Solution) -> float:
    """The steepest slope of the bottom where the flow was, at any output; 0 where there is none."""
    h = np.array([solution.observables(k)["h"] for k in range(len(solution.t))])
    return steepest(solution.aux["b"], solution.grid.dx, deep(h).any(axis=0))
def _written(options: argparse.Namespace) -> list[str]:
    """Names of the files that ``fvkit run`` writes, the solution first."""
    films = [] if options.animate is None else [options.animate]
    return ["solution.npz", *dict.fromkeys(f"{picture}.png" for picture in ("profile", *options.plot)), *films]


def _earlier(folder: Path) -> list[str]:
    """Names of the pictures that an earlier ``fvkit run`` wrote into its folder, as its solution says; none outside."""
    try:
        with np.load(folder / "solution.npz", allow_pickle=False) as kept:
            names = list(json.loads(str(kept["configuration"]))[FILES])
    except (OSError, ValueError, KeyError, TypeError, zipfile.BadZipFile):
        return []
    return [name for name in names if isinstance(name, str) and Path(name).suffix in (".png", ".gif", ".mp4")
            and (folder / name).resolve().is_relative_to(folder.resolve())]


def _draw(solution: Solution, kind: str, path: Path) -> None:
    """Write one picture of the end."""
    figure, axes = new_axes(width=8.0, height=4.5)
    if kind == "slip":
        slip(solution, axes[0])
    elif kind == "space-time":
        space_time(solution, axes[0])
    else:
        solution.plot(axes[0], kind=kind)
    write_whole(path, lambda file: figure.savefig(file, format="png", dpi=130))


def _method(named: Mapping[str, Any]) -> list[str]:
    """A few words on the method of a run."""
    return [named["limiter"], named["integrator"]] if named["integrator"] else [f"order {named['order']}"]


def _bench(options: argparse.Namespace) -> int:
    for count in options.cells:
        _validate.whole(count, "--cells", at_least=10)
    for name in options.backends or ():
        _validate.choice(name, "--backends", BACKENDS[1:])
    _validate.whole(options.repeats, "--repeats", at_least=1)
    for order in options.orders:
        _validate.choice(order, "--orders", ORDERS)
    usable_folder(options.out, "--out", ("bench.json", "bench.png"))
    result, stopped = done_so_far(partial(bench, options.cells, options.orders, options.backends, options.repeats,
                                          progress=_teller()))
    folder = result.save(options.out)
    print(result.table())
    print(f"written to {folder}/: bench.json, bench.png")
    return INTERRUPTED if stopped else SUCCESS


def _teller() -> Callable[[str], None] | None:
    """A function that shows one changing line on a terminal; None where stderr is none."""
    if not sys.stderr.isatty():
        return None
    return lambda line: print(f"\r\033[K{line}", end="", file=sys.stderr, flush=True)


def _compare(options: argparse.Namespace) -> int:
    chosen = find_scene(options.scene)
    models = pick(options.models, "--models", MODELS)
    for name in (name for pair in options.plot_axes for name in pair):
        _validate.choice(name.partition(".")[0], "--plot-axes", AXES)
        _validate.choice(name, "--plot-axes", _columns(chosen, models))
    pictures = [f"{y}-over-{x}.png" for x, y in options.plot_axes]
    folder = usable_folder(_folder(options, "compare", scene_label(options.scene)), "--out",
                           ("report.json", "report.csv", *(f"{name}.png" for name in PICTURES), *pictures))
    tell = _teller()
    report, stopped = done_so_far(partial(compare, chosen, models, cells=options.cells, repeats=options.repeats,
                                          backend=options.backend, seconds=options.seconds, progress=tell, **_schemes(options)))
    if tell is not None:
        tell("")
    report.save(folder)
    for x, y in () if stopped else options.plot_axes:
        write_whole(folder / f"{y}-over-{x}.png", partial(report.figure(x, y).savefig, format="png", dpi=130))
    remove(folder, [path.name for path in folder.glob("*-over-*.png") if _drawn_over(path.stem)], but=() if stopped else pictures)
    table = report.table().splitlines()
    print("\n".join(table[:-1]))
    print(f"written to {folder}/: report.json, report.csv, " + ", ".join(sorted(path.name for path in folder.glob("*.png"))))
    print(table[-1])
    finished = all(row["status"] in ("finished", "over_budget") for row in report.rows)
    return INTERRUPTED if stopped else SUCCESS if finished else FAILED


def _columns(scene: Scene, models: list[Any]) -> list[str]:
    """Names that columns of report.csv will have: those of `AXES`, by quantity where there are several."""
    result = dict.fromkeys(name for name in AXES if name not in BY_QUANTITY and name != "mass_drift")
    for problem in (scene.problem(model, 10) for model in models):
        names = compared(problem.model.observables(problem.q0, problem.aux_averages))
        result |= dict.fromkeys(f"{column}.{name}" for column in BY_QUANTITY for name in names)
        result |= dict.fromkeys(f"mass_drift.{problem.model.conserved[row]}" for row in problem.model.mass_rows())
    return list(result)


def _drawn_over(name: str) -> bool:
    """Whether a picture has a name that --plot-axes gives."""
    return all(axis.partition(".")[0] in AXES for axis in name.split("-over-"))


def _schemes(options: argparse.Namespace) -> dict[str, Any]:
    """The schemes of a comparison; those of wave propagation alone are left to `compare`, which chooses per model."""
    if methods_of(options) != [WAVES]:
        return {"schemes": schemes_of(options)}
    riemann = None if options.riemann is None else [kind() for kind in pick(options.riemann, "--riemann", RIEMANN)]
    limiters = [kind() for kind in pick(options.limiter or ["mc"], "--limiter", LIMITERS)]
    return {"riemann": riemann, "limiter": limiters, "order": options.order or [2],
            "cfl": 0.9 if options.cfl is None else options.cfl}
