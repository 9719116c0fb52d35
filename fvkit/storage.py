"""Solutions in files: ``.npz`` with the hard dependencies alone, netCDF where its libraries are installed."""

import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from fvkit import _validate
from fvkit.archive import Archive, Unreadable, write_archive
from fvkit.checkpoint import FORMAT as CHECKPOINT
from fvkit.configuration import build, describe
from fvkit.grid import Grid
from fvkit.model import Model
from fvkit.solution import Solution, Stats, Status

#: What the first entry of a file says it is.
FORMAT = "fvkit solution 1"


def configuration_of(solution: Solution) -> dict[str, Any]:
    """Return the configuration that a file keeps: what the solution knows, and all that is needed to make it again."""
    return {**solution.configuration, "model": describe(solution.model), "grid": describe(solution.grid),
            "status": solution.status.name, "message": solution.message, "statistics": describe(solution.stats)}


def save(solution: Solution, path: str | Path) -> Path:
    """Write a solution to a ``.nc`` or ``.npz`` file, see `Solution.save`."""
    target = _validate.file(path, "path")
    if target.suffix == ".nc":
        from fvkit.netcdf import write

        return write(solution, target)
    if target.suffix != ".npz":
        raise ValueError(f"`path` must end in .npz or .nc, got {target.name!r}")
    kept = configuration_of(solution)
    return write_archive(target, {
        "format": FORMAT, "t": solution.t, "q": solution.q, "x": solution.grid.centers, "edges": solution.grid.edges,
        **{f"aux_{name}": values for name, values in solution.aux.items()},
        "status": kept["status"], "message": kept["message"], "configuration": json.dumps(kept, allow_nan=False)})


def load(path: str | Path) -> Solution:
    """Read a solution that `Solution.save` or ``solve(..., stream=...)`` wrote, bit for bit.

    Parameters
    ----------
    path : a ``.npz`` or ``.nc`` file.

    Returns
    -------
    Solution
        With everything that was saved: times, states, aux values, grid, model, status, statistics, configuration.

    Raises
    ------
    ValueError
        Naming the file and what is wrong: damaged, incomplete, shapes that do not fit, more declared than it holds, or a
        class of a model that is not loaded (import the module that defines it first). Nothing in a file is ever executed.
    ImportError
        For ``.nc`` without the extra ``io``.
    FileNotFoundError
        If there is no such file.
    """
    source = _validate.file(path, "path")
    if source.suffix == ".nc":
        from fvkit.netcdf import read

        return read(source)
    archive = Archive(source)
    expect_format(archive, FORMAT)
    kept = parsed(archive.text("configuration"), source)
    model, grid = model_and_grid(kept, source)
    t = archive.numbers("t", (None,))
    q = archive.numbers("q", (len(t), len(model.conserved), grid.num_cells))
    aux = {name: archive.numbers(f"aux_{name}", (grid.num_cells,)) for name in model.aux}
    return restored(t, q, aux, kept, model, grid, source)


def expect_format(archive: Archive, kind: str) -> None:
    """Refuse an archive that is something else, saying what reads it."""
    found = archive.text("format")
    if found != kind:
        other = {FORMAT: "fv.load reads it", CHECKPOINT: "fv.resume continues it"}.get(found, "nothing here reads it")
        raise archive.refused(f"it is no {kind!r} but {found!r}: {other}")


def parsed(text: str, source: Path) -> dict[str, Any]:
    """Return the configuration that a file holds as JSON."""
    try:
        result = json.loads(text)
    except (ValueError, RecursionError) as error:
        raise Unreadable(source, f"its configuration is no JSON ({error})") from None
    if not isinstance(result, dict):
        raise Unreadable(source, "its configuration is no mapping")
    return result


def part(kept: Mapping[str, Any], name: str, kind: type, source: Path) -> Any:
    """Make one part of a configuration again."""
    if name not in kept:
        raise Unreadable(source, f"its configuration has no {name!r}")
    try:
        return build(kept[name], kind, name)
    except ValueError as error:
        raise Unreadable(source, error) from None


def model_and_grid(kept: Mapping[str, Any], source: Path) -> tuple[Model, Grid]:
    """Make model and grid of a configuration again."""
    return part(kept, "model", Model, source), part(kept, "grid", Grid, source)


def restored(t: np.ndarray, q: np.ndarray, aux: dict[str, np.ndarray], kept: dict[str, Any], model: Model, grid: Grid,
             source: Path) -> Solution:
    """Return the solution of arrays and a configuration."""
    status, message = str(kept.get("status")), kept.get("message", "")
    if status not in Status.__members__:
        raise Unreadable(source, f"its status is {status!r}, not one of {', '.join(Status.__members__)}")
    return Solution(t, q, aux, grid, model, Status[status], part(kept, "statistics", Stats, source), str(message), kept)
