"""The command ``fvkit advise``."""

import argparse
from typing import Any

import numpy as np

from fvkit import WavePropagation, solve
from fvkit.backends import BACKENDS
from fvkit.cli import SUCCESS, add_command
from fvkit.schemes.riemann import default_riemann
from fvkit.studies.tables import table
from fvkit_granular.cli.options import one_of
from fvkit_granular.models.reduced import Reduced
from fvkit_granular.models.registry import MODELS
from fvkit_granular.models.shallow_water import ShallowWater
from fvkit_granular.models.two_phase import TwoPhase
from fvkit_granular.scenes.scene import Scene
from fvkit_granular.scenes.toml.read import SCENE_HELP, find_scene
from fvkit_granular.studies.advise import Advice, advise
from fvkit_granular.studies.advise_terrain import TerrainAdvice
from fvkit_granular.studies.grid_error_estimate import resolution
from fvkit_granular.studies.model_error_indicators import sampled

#: Cells of the runs that check an advice, how many times as many measure their grid error, and how often time is taken.
CHECKED, FINER, REPEATS = 200, 8, 4


def register(commands: Any) -> None:
    """Add the command to the parser of ``fvkit``."""
    parser = add_command(commands, "advise", _advise,
                         "estimate which model, scheme and resolution a scene needs, without running it",
                         "fvkit advise dam-break-phi --tol 1e-3 --check")
    parser.add_argument("scene", metavar="SCENE", help=SCENE_HELP)
    parser.add_argument("--tol", type=float, default=1e-3,
                        help="tolerance: mean error of the depth over the mean depth (default 1e-3)")
    parser.add_argument("--check", action="store_true",
                        help=f"run the models on {CHECKED} cells and print measured next to predicted errors")
    one_of(parser, "--backend", BACKENDS, "auto")


def _advise(options: argparse.Namespace) -> int:
    chosen = find_scene(options.scene)
    if options.check and chosen.terrain is not None:
        raise ValueError("--check runs the models along one axis, and this scene lies on a terrain: leave it out, and run "
                         "--model reduced beside --model two-phase")
    advice = advise(chosen, options.tol)
    print(advice)
    if isinstance(advice, TerrainAdvice):
        return SUCCESS
    if options.check:
        print(_checked(chosen, advice, options.backend))
    return SUCCESS


def model_errors(scene: Scene, cells: int, backend: str = "auto") -> tuple[tuple[float, float], tuple[float, float, float]]:
    """Run a scene with the full model and its two limits, each with its default solver at second order.

    Returns
    -------
    The mean |difference| of the depth to the full model over the mean depth, of the reduced model and of shallow water; and
    the seconds of all three.
    """
    depths, seconds = [], []
    for model in (TwoPhase, Reduced, ShallowWater):
        problem = scene.problem(model, cells)
        solution = solve(problem, WavePropagation(default_riemann(problem.model)), backend=backend, nonhyperbolic="ignore")
        depths.append(solution.observables()["h"])
        seconds.append(solution.stats.seconds)
    full, reduced, shallow = depths
    mean = full.mean()
    return ((float(np.abs(reduced - full).mean() / mean), float(np.abs(shallow - full).mean() / mean)),
            (seconds[0], seconds[1], seconds[2]))


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
    return (f"mean difference of the depth to the full model over the mean depth, {CHECKED} cells:\n{table(lines, left=1)}\n"
            f"grid error of {advice.model} on these cells, second order: estimated {grid.error(CHECKED):.1e}, measured "
            f"{found:.1e} (against {FINER * CHECKED} cells)")
