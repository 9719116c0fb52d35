"""``fvkit compare``: models and schemes on one scene, error against time."""

import argparse
from functools import partial
from typing import Any

from fvkit import validation
from fvkit.cli import FAILED, INTERRUPTED, SUCCESS, add_command, done_so_far, progress_line
from fvkit.files import remove, usable_folder
from fvkit.output.figures import FORMATS, save_all
from fvkit.problem.directions import observables
from fvkit.studies.report_pictures import pictures
from fvkit.studies.tables import filled
from fvkit_granular.cli import options as common
from fvkit_granular.models.registry import COMPARED, MODELS
from fvkit_granular.scenes.scene import Scene
from fvkit_granular.scenes.toml.read import SCENE_HELP, find_scene, scene_label
from fvkit_granular.studies.compare import compare, compared

#: Columns of report.csv for --plot-axes; some are followed by a dot and a quantity.
AXES = ("order", "cells", "steps", "rejected", "seconds", "seconds_min", "ns_per_cell_step", "error", "error_l2", "error_max",
        "order_observed", "mass_drift")


#: Those that have a value for each quantity of the model.
BY_QUANTITY = ("error", "error_l2", "error_max", "order_observed")


def register(commands: Any) -> None:
    """Add the command to the parser of ``fvkit``."""
    study = add_command(commands, "compare", _compare, "compare models and solvers on one scene: error against time",
                        "fvkit compare riemann --cells 100 200 400\n"
                        "  fvkit compare two-phase-vortex --riemann roe relaxation --cells 25 50 100\n"
                        "  fvkit compare simple-wave --method wave-propagation method-of-lines --reconstruction mp5 weno5\n"
                        "  fvkit compare riemann --seconds 2 --plot-axes steps error.phi")
    study.add_argument("scene", metavar="SCENE", help=SCENE_HELP)
    study.add_argument("--models", nargs="+", type=common.named(MODELS), default=list(COMPARED.values()), metavar="M",
                       help=f"any of {', '.join(MODELS)} (default: {' '.join(COMPARED)})")
    common.add_scheme_options(study, several=True)
    study.add_argument("--cells", nargs="+", type=common.COUNT, metavar="N",
                       help="numbers of cells (default 100 200 400 800), with two axes along x (default 25 50 100)")
    study.add_argument("--repeats", type=common.COUNT, default=3, help="timed repeats of each run (default 3)")
    study.add_argument("--seconds", type=float, metavar="S",
                       help="time limit per run (s); runs expected to exceed it are skipped, others are stopped (default: none)")
    study.add_argument("--plot-axes", nargs=2, action="append", default=[], metavar=("X", "Y"),
                       help="extra figure: column Y of report.csv over column X, such as steps error.h")
    study.add_argument("--wide", action="store_true", help="print every column (default: a table of at most 100 columns)")
    common.common_options(study, "fvkit-compare-SCENE")


def _compare(options: argparse.Namespace) -> int:
    chosen = find_scene(options.scene)
    known = _columns(chosen, options.models) if options.plot_axes else ()
    for name in (name for pair in options.plot_axes for name in pair):
        validation.choice(name, "--plot-axes", known)
    always = [f"{name}.{options.format}" for name in pictures(len(chosen.axes))]
    asked = [f"{y}-over-{x}.{options.format}" for x, y in options.plot_axes]
    folder = usable_folder(common.results_folder(options, "compare", scene_label(options.scene)), "--out",
                           ("report.json", "report.csv", *always, *asked))
    study = partial(compare, chosen, options.models, cells=options.cells, repeats=options.repeats, backend=options.backend,
                    seconds=options.seconds, **_schemes(options))
    report, stopped = done_so_far(study, progress_line())
    report.save(folder, options.format)
    drawn = {} if stopped else {f"{y}-over-{x}.{options.format}": report.figure(x, y) for x, y in options.plot_axes}
    save_all(folder, drawn)
    known_pictures = [f"{name}.{kind}" for name in pictures(2) for kind in FORMATS]
    remove(folder, [*known_pictures, *(path.name for kind in FORMATS for path in folder.glob(f"*-over-*.{kind}")
                                       if _drawn_over(path.stem))], but=(*always, *drawn))
    print(report.table(options.wide))
    print(filled(f"written to {folder}/: {', '.join(['report.json', 'report.csv', *always, *drawn])}"))
    finished = all(row["status"] in ("finished", "over_budget") for row in report.rows)
    return INTERRUPTED if stopped else SUCCESS if finished else FAILED


def _columns(scene: Scene, models: list[Any]) -> list[str]:
    """Names that columns of report.csv will have: those of `AXES`, by quantity where there are several."""
    result = dict.fromkeys(name for name in AXES if name not in BY_QUANTITY and name != "mass_drift")
    for problem in (scene.problem(model, 10) for model in models):
        names = compared(observables(problem.model, problem.grid, problem.q0, problem.aux_averages))
        result |= dict.fromkeys(f"{column}.{name}" for column in BY_QUANTITY for name in names)
        result |= dict.fromkeys(f"mass_drift.{problem.model.conserved[row]}" for row in problem.model.mass_rows())
    return list(result)


def _drawn_over(name: str) -> bool:
    """Whether a picture has a name that --plot-axes gives."""
    return all(axis.partition(".")[0] in AXES for axis in name.split("-over-"))


def _schemes(options: argparse.Namespace) -> dict[str, Any]:
    """The schemes of a comparison; those of wave propagation alone are left to `compare`, which chooses per model."""
    if common.methods_of(options) != [common.WAVES]:
        return {"schemes": common.schemes_of(options)}
    riemann = None if options.riemann is None else common.parts_of(options, "riemann")
    return {"riemann": riemann, "limiter": common.parts_of(options, "limiter"), "order": options.order or [2],
            "cfl": 0.9 if options.cfl is None else options.cfl}
