"""The commands on scenes: ``fvkit scenes``, ``fvkit run``, ``fvkit compare``, and those of `stress` and `advise_command`."""

import argparse
import sys
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

from fvkit import Checkpoint, Solution, Status, WavePropagation, _validate, resume, solve
from fvkit.backends import BACKENDS
from fvkit.cli import FAILED, INTERRUPTED, SUCCESS, add_command
from fvkit.configuration import build
from fvkit.io import write_whole
from fvkit.names import LIMITERS, public_name
from fvkit.plot import new_axes
from fvkit_granular import advise_command
from fvkit_granular.bench import bench
from fvkit_granular.compare import compare, deviations
from fvkit_granular.parts import COMPARED, MODELS, RIEMANN
from fvkit_granular.scene import Reference
from fvkit_granular.scenes import scene, scene_names
from fvkit_granular.stress import command as stress_command


def register(commands: Any) -> None:
    """Add the commands to the parser of ``fvkit``."""
    add_command(commands, "scenes", _scenes, "list the built-in scenes", "fvkit scenes")
    run = add_command(commands, "run", _run, "run one scene with one model and solver",
                      "fvkit run riemann --cells 800 --out result")
    run.add_argument("scene", metavar="SCENE", nargs="?", help="name of a built-in scene, see fvkit scenes")
    run.add_argument("--model", default="two-phase", help=f"one of {', '.join(MODELS)} (default two-phase)")
    run.add_argument("--riemann", default="relaxation", help=f"one of {', '.join(RIEMANN)} (default relaxation)")
    run.add_argument("--limiter", default="mc", help=f"one of {', '.join(LIMITERS)} (default mc)")
    run.add_argument("--order", type=int, default=2, help="1 or 2 (default 2)")
    run.add_argument("--cells", type=int, default=400, help="number of cells (default 400)")
    run.add_argument("--checkpoint", type=Path, metavar="FILE", help="file (.npz) to continue from, should the run be stopped")
    run.add_argument("--every", type=float, metavar="SECONDS", help="wall time between two checkpoints (default 60)")
    run.add_argument("--resume", type=Path, metavar="FILE", help="continue the run of a checkpoint, instead of a SCENE")
    _common(run, "fvkit-run-SCENE")
    study = add_command(commands, "compare", _compare, "compare models and solvers on one scene: error against time",
                        "fvkit compare riemann --cells 100 200 400")
    study.add_argument("scene", metavar="SCENE", help="name of a built-in scene, see fvkit scenes")
    study.add_argument("--models", nargs="+", default=list(COMPARED), metavar="M",
                       help=f"any of {', '.join(MODELS)} (default: {' '.join(COMPARED)})")
    study.add_argument("--riemann", nargs="+", metavar="R",
                       help=f"any of {', '.join(RIEMANN)} (default: all for the first model, relaxation for the others)")
    study.add_argument("--limiter", nargs="+", default=["mc"], metavar="L",
                       help=f"any of {', '.join(LIMITERS)} (default mc)")
    study.add_argument("--order", nargs="+", type=int, default=[2], metavar="P", help="1, 2 or both (default 2)")
    study.add_argument("--cells", nargs="+", type=int, default=[100, 200, 400, 800], metavar="N",
                       help="numbers of cells (default 100 200 400 800)")
    study.add_argument("--repeats", type=int, default=3, help="timed repeats of each run (default 3)")
    _common(study, "fvkit-compare-SCENE")
    speed = add_command(commands, "bench", _bench, "measure ns per cell and step for every model, solver, backend and order",
                        "fvkit bench --cells 1000 10000 --orders 2")
    speed.add_argument("--cells", nargs="+", type=int, default=[100, 1000, 10_000, 100_000], metavar="N",
                       help="numbers of cells (default 100 1000 10000 100000)")
    speed.add_argument("--orders", nargs="+", type=int, default=[1, 2], metavar="P", help="1, 2 or both (default both)")
    speed.add_argument("--backends", nargs="+", metavar="B", help="numba, numpy or both (default: what is installed)")
    speed.add_argument("--repeats", type=int, default=5, help="timed blocks of each case (default 5)")
    speed.add_argument("--out", type=Path, default=Path("fvkit-bench"), help="folder for the results (default fvkit-bench)")
    stress_command.register(commands, _teller)
    advise_command.register(commands, _teller)


def _common(parser: argparse.ArgumentParser, folder: str) -> None:
    parser.add_argument("--cfl", type=float, default=0.9, help="Courant number aimed at, in (0, 1] (default 0.9)")
    parser.add_argument("--backend", default="auto", help=f"one of {', '.join(BACKENDS)} (default auto)")
    parser.add_argument("--out", type=Path, help=f"folder for the results (default {folder})")


def _scenes(options: argparse.Namespace) -> int:
    for name in scene_names():
        print(f"{name:19s} {scene(name).description}")
    return SUCCESS


def _pick(names: list[str], argument: str, known: Mapping[str, type]) -> list[Any]:
    return [known[_validate.choice(name, argument, known)] for name in names]


def _run(options: argparse.Namespace) -> int:
    if (options.scene is None) == (options.resume is None):
        raise ValueError("fvkit run takes a SCENE, or --resume FILE: give one of them (see fvkit run --help)")
    if options.every is not None and options.checkpoint is None:
        raise ValueError("--every SECONDS says how often --checkpoint FILE is written: give that too")
    if options.resume is not None:
        solution = resume(options.resume, progress=sys.stderr.isatty(), throw=False)
        return _show(options.resume.stem, solution, None, options.out)
    chosen = scene(options.scene)
    model, limiter = (_pick([getattr(options, name)], f"--{name}", known)[0]
                      for name, known in (("model", MODELS), ("limiter", LIMITERS)))
    problem = chosen.problem(model, options.cells)
    solver = options.riemann or ("roe" if model.defines("decompose") else "hll")
    riemann = _pick([solver], "--riemann", RIEMANN)[0]
    scheme = WavePropagation(riemann(), limiter=limiter(), order=options.order, cfl=options.cfl)
    checkpoint = None if options.checkpoint is None else \
        Checkpoint(options.checkpoint, 60.0 if options.every is None else options.every)
    solution = solve(problem, scheme, backend=options.backend, progress=sys.stderr.isatty(), throw=False, checkpoint=checkpoint)
    code = _show(options.scene, solution, chosen.known_reference() if solution.success else None, options.out)
    if checkpoint is not None:
        print(f"  checkpoint {checkpoint.path}: fvkit run --resume {checkpoint.path}")
    return code


def _show(name: str, solution: Solution, reference: Reference | None, out: Path | None) -> int:
    """Write the files of a run, print what is to be said, and return the exit code."""
    folder = out or Path(f"fvkit-run-{name}")
    folder.mkdir(parents=True, exist_ok=True)
    solution.save(folder / "solution.npz")
    figure, axes = new_axes(width=8.0, height=4.5)
    solution.plot(axes[0])
    write_whole(folder / "profile.png", lambda file: figure.savefig(file, format="png", dpi=130))
    stats, grid, t_end = solution.stats, solution.grid, solution.configuration["t_end"]
    scheme = build(solution.configuration["scheme"])
    order = f"order {scheme.order}" if isinstance(scheme, WavePropagation) else type(scheme).__name__
    print(f"{name}: {public_name(solution.model)}, {public_name(scheme.riemann)}, {order}, {grid.num_cells} cells, "
          f"{stats.backend}")
    print(f"  {solution.message}; t = {solution.t[-1]:.6g} of {t_end:g} s")
    print(f"  {stats.steps} steps ({stats.rejected} rejected), {stats.seconds:.3g} s, "
          f"{stats.ns_per_cell_step:.0f} ns per cell and step, largest Courant number {stats.max_cfl:.3f}")
    print("  mass drift " + ", ".join(f"{mass} {drift:.1e}" for mass, drift in stats.mass_drift.items())
          + f"; faces with complex speeds: {stats.nonhyperbolic_faces}")
    if reference is not None:
        found = deviations(solution, reference.averages(solution.model, grid, t_end))
        errors = {quantity: grid.dx * float(difference.sum()) for quantity, difference in found.items()}
        print("  L1 error " + ", ".join(f"{quantity} {error:.3e}" for quantity, error in errors.items()) + f" ({reference.kind})")
    print(f"  written to {folder}/: solution.npz, profile.png")
    return SUCCESS if solution.success else INTERRUPTED if solution.status is Status.INTERRUPTED else FAILED


def _bench(options: argparse.Namespace) -> int:
    for count in options.cells:
        _validate.whole(count, "--cells", at_least=10)
    for name in options.backends or ():
        _validate.choice(name, "--backends", BACKENDS[1:])
    _validate.whole(options.repeats, "--repeats", at_least=1)
    result = bench(options.cells, options.orders, options.backends, options.repeats, progress=_teller())
    folder = result.save(options.out)
    print(result.table())
    print(f"written to {folder}/: bench.json, bench.png")
    return SUCCESS


def _teller() -> Callable[[str], None] | None:
    """A function that shows one changing line on a terminal; None where stderr is none."""
    if not sys.stderr.isatty():
        return None
    return lambda line: print(f"\r\033[K{line}", end="", file=sys.stderr, flush=True)


def _compare(options: argparse.Namespace) -> int:
    chosen = scene(options.scene)
    models = _pick(options.models, "--models", MODELS)
    riemann = None if options.riemann is None else [kind() for kind in _pick(options.riemann, "--riemann", RIEMANN)]
    limiters = [kind() for kind in _pick(options.limiter, "--limiter", LIMITERS)]
    tell = _teller()
    report = compare(chosen, models, riemann, options.cells, limiters, options.order, options.repeats, cfl=options.cfl,
                     backend=options.backend, progress=tell)
    if tell is not None:
        tell("")
    folder = report.save(options.out or Path(f"fvkit-compare-{options.scene}"))
    table = report.table().splitlines()
    print("\n".join(table[:-1]))
    print(f"written to {folder}/: report.json, report.csv, " + ", ".join(sorted(path.name for path in folder.glob("*.png"))))
    print(table[-1])
    return SUCCESS if all(row["status"] == "finished" for row in report.rows) else FAILED
