"""The command ``fvkit advise``."""

import argparse
from collections.abc import Callable
from functools import partial
from typing import Any

import numpy as np

from fvkit import solve, validation
from fvkit.backends import BACKENDS
from fvkit.cli import INTERRUPTED, SUCCESS, add_command, done_so_far
from fvkit.studies.tables import table
from fvkit_granular.cli.options import teller
from fvkit_granular.models.registry import MODELS
from fvkit_granular.scenes.scene import Scene
from fvkit_granular.scenes.toml.read import SCENE_HELP, find_scene
from fvkit_granular.studies.advice_validation import model_errors, report, validate
from fvkit_granular.studies.advise import Advice, advise
from fvkit_granular.studies.grid_error_estimate import resolution
from fvkit_granular.studies.model_error_indicators import sampled

#: Cells of the runs that check an advice, how many times as many measure their grid error, and how often time is taken.
CHECKED, FINER, REPEATS = 200, 8, 4


def register(commands: Any) -> None:
    """Add the command to the parser of ``fvkit``."""
    parser = add_command(commands, "advise", lambda options: _advise(options, teller()),
                         "estimate which model, scheme and resolution a scene needs, without running it",
                         "fvkit advise dam-break-phi --tol 1e-3 --check\n  fvkit advise --validate 100 --seed 1")
    parser.add_argument("scene", nargs="?", metavar="SCENE", help=SCENE_HELP)
    parser.add_argument("--tol", type=float, default=1e-3,
                        help="tolerance: mean error of the depth over the mean depth (default 1e-3)")
    parser.add_argument("--check", action="store_true",
                        help=f"run the models on {CHECKED} cells and print measured and predicted errors")
    parser.add_argument("--validate", type=int, metavar="N", help="compare predictions with runs on N random scenes")
    parser.add_argument("--seed", type=int, default=1, help="seed of the random scenes (default 1)")
    parser.add_argument("--cells", type=int, default=400, help="with --validate: cells of the coarser runs (default 400)")
    parser.add_argument("--backend", default="auto", help=f"one of {', '.join(BACKENDS)} (default auto)")


def _advise(options: argparse.Namespace, tell: Callable[[str], None] | None) -> int:
    if (options.scene is None) == (options.validate is None):
        raise ValueError("give a SCENE, or --validate N, such as fvkit advise riemann")
    if options.validate is not None:
        count = validation.whole(options.validate, "--validate", at_least=4)
        seed = validation.whole(options.seed, "--seed", at_least=0)
        cells = validation.whole(options.cells, "--cells", at_least=10)
        rows, stopped = done_so_far(partial(validate, count, seed, cells, options.backend, progress=tell))
        if tell is not None:
            tell("")
        print(report(rows))
        return INTERRUPTED if stopped else SUCCESS
    chosen = find_scene(options.scene)
    advice = advise(chosen, options.tol)
    print(advice)
    if options.check:
        print(_checked(chosen, advice, options.backend))
    return SUCCESS


def _checked(chosen: Scene, advice: Advice, backend: str) -> str:
    """Return a table of predicted and measured errors and run times of the models on a coarse grid, and its own error."""
    runs = [model_errors(chosen, CHECKED, backend) for _ in range(REPEATS)]
    errors, seconds = runs[0][0], [min(times) for times in zip(*(times for _, times in runs), strict=True)]
    predicted = [f"{error:.1e}" if advice.valid else "not valid" for error in (advice.numbers.reduced, advice.numbers.shallow)]
    lines = [["model", "predicted", "measured", "ms", "times faster"], ["two-phase", "-", "-", f"{1e3 * seconds[0]:.3g}", "1.0"]]
    lines += [[name, one, f"{other:.1e}", f"{1e3 * spent:.3g}", f"{seconds[0] / spent:.1f}"]
              for name, one, other, spent in zip(("reduced", "shallow-water"), predicted, errors, seconds[1:], strict=True)]
    lines = [[f"{line[0]} (advised)" if line[0] == advice.model else line[0], *line[1:]] for line in lines]
    fine, coarse = (solve(chosen.problem(MODELS[advice.model], cells), backend=backend, nonhyperbolic="ignore").observables()["h"]
                    for cells in (FINER * CHECKED, CHECKED))
    found = np.abs(coarse - fine.reshape(CHECKED, FINER).mean(axis=1)).mean() / fine.mean()
    grid = resolution(chosen, sampled(chosen), advice.numbers, advice.model == "two-phase")
    return (f"on {CHECKED} cells, errors of the depth against the full model over the mean depth:\n{table(lines, left=1)}\n"
            f"grid error of {advice.model} there, second order: estimated {grid.error(CHECKED):.1e}, measured {found:.1e} "
            f"(against {FINER * CHECKED} cells)")
