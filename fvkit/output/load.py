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
from fvkit.problem.directions import component_names
from fvkit.problem.grid import Grid
from fvkit.problem.model import Model


def load(path: str | Path) -> Solution:
    """Load a solution file written by `Solution.save` or ``solve(..., record=fvkit.Stream(path))``, bit for bit.

    Parameters
    ----------
    path : a ``.npz`` or ``.nc`` file.

    Returns
    -------
    Solution
        Times, states, aux values, grid, model, status, statistics and configuration.

    Raises
    ------
    ValueError
        For a file that is damaged, incomplete or has inconsistent shapes, and for a model whose class is not loaded (import
        its module first); the message contains the file and the reason. Nothing in a file is executed.
    ImportError
        For ``.nc`` without the extra ``io``.
    FileNotFoundError
        If the file does not exist.

    Examples
    --------
    >>> import fvkit as fv
    >>> import fvkit_granular as gr
    >>> import numpy as np
    >>> from tempfile import TemporaryDirectory
    >>> solution = fv.solve(gr.scene("dam-break").problem(gr.ShallowWater, 50), backend="numpy")
    >>> with TemporaryDirectory() as folder:
    ...     again = fv.load(solution.save(f"{folder}/run.npz"))
    >>> np.array_equal(again.q, solution.q), again.model == solution.model
    (True, True)
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
    q = archive.numbers("q", (len(t), len(component_names(model, grid)), *grid.shape))
    aux = {name: archive.numbers(f"aux_{name}", grid.shape) for name in model.aux}
    return restored(t, q, aux, kept, model, grid, source)


def restored(t: np.ndarray, q: np.ndarray, aux: dict[str, np.ndarray], kept: dict[str, Any], model: Model, grid: Grid,
             source: Path) -> Solution:
    """Return the `Solution` made of arrays and a configuration read from ``source``."""
    status, message = str(kept.get("status")), kept.get("message", "")
    if status not in Status.__members__:
        raise Unreadable(source, f"its status is {status!r}, not one of {', '.join(Status.__members__)}")
    return Solution(t, q, aux, grid, model, Status[status], part(kept, "statistics", Stats, source), str(message), kept)
