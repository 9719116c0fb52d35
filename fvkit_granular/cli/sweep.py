"""``fvkit sweep``: a sweep over a scene, written down in a TOML file."""

import argparse
import sys
from collections.abc import Iterator
from concurrent.futures import Executor
from contextlib import contextmanager
from functools import partial
from pathlib import Path
from typing import Any

from fvkit import Keep, Samples, Scheme, sweep, validation
from fvkit.cli import FAILED, INTERRUPTED, SUCCESS, add_command, done_so_far
from fvkit.files import remove, usable_folder
from fvkit.problem.directions import observables
from fvkit.schemes.fitting import check_axes
from fvkit.sweeps import SweepResult
from fvkit_granular.cli.options import COUNT, scheme_of
from fvkit_granular.models.registry import MODELS
from fvkit_granular.scenes.toml.read import SUFFIX
from fvkit_granular.scenes.toml.table import read_toml
from fvkit_granular.studies.hazard_sweep import HazardRun, exceeded, write_exceeded
from fvkit_granular.studies.scene_run import SceneRun

#: Keys of a file; those without a default must be there.
DEFAULTS: dict[str, Any] = {"model": "two-phase", "cells": None, "scheme": {}, "samples": "latin-hypercube", "members": 100,
                            "seed": 0, "outputs": None, "thresholds": None, "backend": "auto"}

#: Default outputs, by the number of axes.
OUTPUTS = {1: ["max.h", "front.h"], 2: ["max.h", "mean.h"]}
REQUIRED = ("scene", "parameters")

#: Kinds of samples.
KINDS = ("latin-hypercube", "grid", "given")

#: Keys of the table ``scheme``.
SCHEME = ("method", "riemann", "limiter", "order", "reconstruction", "integrator", "cfl")


def register(commands: Any) -> None:
    """Add the command."""
    parser = add_command(commands, "sweep", _sweep, "run a parameter sweep described in a TOML file",
                         "fvkit sweep drag.toml --workers 4\n\ndrag.toml:\n" + EXAMPLE)
    parser.add_argument("file", metavar="FILE", type=Path, help="TOML file of the sweep")
    parser.add_argument("--workers", type=COUNT, metavar="N",
                        help="processes (default: one per processor); with --dask the cluster decides")
    parser.add_argument("--dask", metavar="ADDRESS", help="run on the Dask cluster whose scheduler has this address")
    parser.add_argument("--out", type=Path,
                        help="folder for the results; a sweep that was stopped resumes there (default fvkit-sweep-FILE)")


EXAMPLE = """  scene = "debris-slope"
  members = 200
  outputs = ["max.h", "mean.phi"]
  [parameters]
  gamma = [0.3, 0.6]
  "sources.v_T" = [0.1, 10.0, "log"]"""


def _sweep(options: argparse.Namespace) -> int:
    run, keep, samples = read(options.file)
    on_terrain = run if isinstance(run, HazardRun) else None
    folder = options.out or Path(f"fvkit-sweep-{options.file.stem}")
    usable_folder(folder, "--out", ("sweep.csv", "sweep.nc"))
    with _executor(options.dask) as executor:
        result, stopped = done_so_far(partial(sweep, run, samples, executor, workers=options.workers, keep=keep,
                                              folder=folder / "members", progress=sys.stderr.isatty()))
    written = ["members/", result.save(folder / "sweep.csv").name, *_netcdf(result, folder)]
    count = int(result.finished.sum())
    if on_terrain is not None and count:
        scene = on_terrain.run.scene_of(samples[0])
        written += write_exceeded(folder, scene, exceeded(result, on_terrain.thresholds))
    remove(folder, ("sweep.nc",), but=written)
    print(f"{options.file.name}: {count} of {len(samples)} members finished, {result.elapsed:.3g} s")
    for name, values in result.table.items():
        if name in result.outputs and count:
            done = values[result.finished]
            print(f"  {name}: {done.min():.6g} to {done.max():.6g}, mean {done.mean():.6g}")
    for status in sorted(set(result.status[~result.finished])):
        first = int((result.status == status).argmax())
        print(f"  {status}: {int((result.status == status).sum())} members, the first is {first}: {result.message[first]}")
    print(f"  written to {folder}/: {', '.join(written)}")
    return INTERRUPTED if stopped else SUCCESS if result.success else FAILED


def _netcdf(result: SweepResult, folder: Path) -> list[str]:
    """Write sweep.nc where the extra is installed; otherwise print a message."""
    try:
        return [result.save(folder / "sweep.nc").name]
    except (ImportError, ValueError) as error:
        print(f"  no sweep.nc: {error}")
        return []


@contextmanager
def _executor(address: str | None) -> Iterator[Executor | None]:
    """The executor of a Dask cluster; None, for processes, without an address."""
    if address is None:
        yield None
        return
    try:
        from distributed import Client
    except ImportError:
        raise ValueError("--dask needs Dask: pip install fvkit[cluster]") from None
    with Client(address, timeout="10s", set_as_default=False) as client:  # nothing of the process changes
        yield client.get_executor()


def read(path: Path) -> tuple[SceneRun | HazardRun, Keep, Samples]:
    """Return the run, outputs and samples of a file, checked on the first member.

    Raises
    ------
    ValueError
        For a mistake in the file: one sentence.
    """
    top = read_toml(path)
    with top.located():
        for key in top.data:
            validation.choice(key, "key", (*REQUIRED, *DEFAULTS))
        plan = {**DEFAULTS, **{key: top.need(key) for key in REQUIRED}, **top.data}
        scene, model = plan["scene"], MODELS[validation.choice(plan["model"], "model", MODELS)]
        if isinstance(scene, str) and scene.endswith(SUFFIX):
            scene = str(path.parent / scene)
        run = SceneRun(scene, model, _scheme(plan["scheme"]), plan["cells"], backend=plan["backend"])
        kind, parameters = validation.choice(plan["samples"], "samples", KINDS), _flat(plan["parameters"])
        samples = Samples.latin_hypercube(parameters, plan["members"], plan["seed"]) if kind == "latin-hypercube" else \
            getattr(Samples, kind)(parameters)
        problem, scheme = run.setup(samples[0])
        if scheme is not None:
            check_axes(scheme, problem.grid)
        if plan["thresholds"] is not None:
            return _hazard(run, samples, plan), Keep(), samples
        axes = len(problem.grid.axes)
        keep = Keep(OUTPUTS[axes] if plan["outputs"] is None else plan["outputs"])
        keep.check(observables(problem.model, problem.grid, problem.q0, problem.aux_averages), axes)
    return run, keep, samples


def _hazard(run: SceneRun, samples: Samples, plan: dict[str, Any]) -> HazardRun:
    """Return the run that keeps hazard maps; ValueError without a terrain, or with outputs as well."""
    if run.scene_of(samples[0]).terrain is None:
        raise ValueError("`thresholds` need a scene on a terrain: give `outputs` such as [\"max.h\"]")
    if plan["outputs"] is not None:
        raise ValueError("`outputs` and `thresholds` exclude each other: give either values at the end or hazard maps")
    return HazardRun(run, plan["thresholds"])


def _flat(parameters: Any, prefix: str = "") -> dict[str, Any]:
    """Parameters with dotted names, which TOML reads as nested tables where they are not in quotes."""
    validation.mapping(parameters, "parameters", "{gamma = [0.3, 0.6]}")
    result: dict[str, Any] = {}
    for name, value in parameters.items():
        result |= _flat(value, f"{prefix}{name}.") if isinstance(value, dict) else {prefix + name: value}
    return result


def _scheme(given: Any) -> Scheme | None:
    if not isinstance(given, dict):
        raise ValueError(f"`scheme` must be a table with any of {', '.join(SCHEME)}, got {given!r}")
    for key in given:
        validation.choice(key, "key of scheme", SCHEME)
    return scheme_of(argparse.Namespace(**{key: given.get(key) for key in SCHEME})) if given else None
