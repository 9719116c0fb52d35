"""``fvkit convergence``: the order that a scheme shows on one scene."""

import argparse
from functools import partial
from pathlib import Path
from typing import Any

from fvkit import OrderError, convergence, validation
from fvkit.backends import BACKENDS
from fvkit.cli import FAILED, INTERRUPTED, SUCCESS, add_command, done_so_far, progress_line
from fvkit.files import usable_folder
from fvkit.studies.convergence import NORMS
from fvkit_granular.cli.options import COUNT, add_scheme_options, checked, one_of, scheme_of
from fvkit_granular.models.registry import MODELS
from fvkit_granular.scenes.toml.read import SCENE_HELP, find_scene, scene_label


def register(commands: Any) -> None:
    """Add the command to the parser of ``fvkit``."""
    parser = add_command(commands, "convergence", _convergence, "measure the order of convergence of one scheme on one scene",
                         "fvkit convergence slip-over-bottom --riemann roe --reconstruction mp5 --integrator dp5 --expect 4.8")
    parser.add_argument("scene", metavar="SCENE", help=SCENE_HELP)
    one_of(parser, "--model", MODELS, "two-phase")
    add_scheme_options(parser, several=False)
    parser.add_argument("--cells", nargs="+", type=COUNT, default=[50, 100, 200, 400], metavar="N",
                        help="numbers of cells (default 50 100 200 400)")
    parser.add_argument("--norm", default="l1", help=f"one of {', '.join(NORMS)} (default l1)")
    parser.add_argument("--expect", type=checked(float, validation.real), metavar="P",
                        help="required order of convergence between the two finest grids; exit code 1 if it is not reached")
    one_of(parser, "--backend", BACKENDS, "auto")
    parser.add_argument("--out", type=Path, help="folder for convergence.json and convergence.png (default: nothing is written)")


def _convergence(options: argparse.Namespace) -> int:
    chosen = find_scene(options.scene)
    scheme = scheme_of(options)
    if options.out is not None:
        usable_folder(options.out, "--out", ("convergence.json", "convergence.png"))
    study = partial(convergence, partial(chosen.problem, options.model), scheme, options.cells, chosen.known_reference(),
                    norm=options.norm, backend=options.backend)
    found, stopped = done_so_far(study, progress_line())
    print(f"scene {scene_label(options.scene)}: {found}")
    if options.out is not None:
        print(f"written to {found.save(options.out)}/: convergence.json, convergence.png")
    if stopped:
        return INTERRUPTED
    if options.expect is None:
        return SUCCESS
    try:
        found.check(options.expect)
    except OrderError as missed:
        print(str(missed).splitlines()[0])
        return FAILED
    print(f"order {options.expect:g} is reached")
    return SUCCESS
