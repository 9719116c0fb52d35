"""Loading solutions from ``.npz`` and netCDF files."""

from pathlib import Path
from typing import Any

import numpy as np

from fvkit import validation
from fvkit.files import Unreadable
from fvkit.output.configuration import model_and_grid, parsed, part
from fvkit.output.npz import FORMAT, Archive, expect_format
from fvkit.output.solution import Solution
from fvkit.output.status import Stats, Status
from fvkit.problem.grid import Grid
from fvkit.problem.model import Model


def load(path: str | Path) -> Solution:
    """Read a solution that `Solution.save` or ``solve(..., record=fvkit.Stream(path))`` wrote, bit for bit.

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
    source = validation.file(path, "path")
    if source.suffix == ".nc":
        from fvkit.output.netcdf import read

        return restored(*read(source), source)
    archive = Archive(source)
    expect_format(archive, FORMAT)
    kept = parsed(archive.text("configuration"), source)
    model, grid = model_and_grid(kept, source)
    t = archive.numbers("t", (None,))
    q = archive.numbers("q", (len(t), len(model.conserved), grid.num_cells))
    aux = {name: archive.numbers(f"aux_{name}", (grid.num_cells,)) for name in model.aux}
    return restored(t, q, aux, kept, model, grid, source)


def restored(t: np.ndarray, q: np.ndarray, aux: dict[str, np.ndarray], kept: dict[str, Any], model: Model, grid: Grid,
             source: Path) -> Solution:
    """Return the solution of arrays and a configuration."""
    status, message = str(kept.get("status")), kept.get("message", "")
    if status not in Status.__members__:
        raise Unreadable(source, f"its status is {status!r}, not one of {', '.join(Status.__members__)}")
    return Solution(t, q, aux, grid, model, Status[status], part(kept, "statistics", Stats, source), str(message), kept)
