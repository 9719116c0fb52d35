"""Saving solutions to ``.npz`` (NumPy alone) or netCDF files (with the extra ``io``)."""

import json
from pathlib import Path

from fvkit import validation
from fvkit.output.configuration import configuration_of
from fvkit.output.npz import FORMAT, write_archive
from fvkit.output.results import Results
from fvkit.problem.grid import NAMES


def save(solution: Results, path: str | Path) -> Path:
    """Write a solution to a ``.nc`` or ``.npz`` file and return its path, see `Solution.save`.

    Examples
    --------
    >>> import tempfile
    >>> import numpy as np
    >>> import fvkit as fv
    >>> problem = fv.Problem(fv.Advection(1.0), fv.Grid(0.0, 1.0, 20), lambda x: [x], 0.1, boundary=fv.Outflow())
    >>> solution = fv.solve(problem, backend="numpy")
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     again = fv.load(fv.save(solution, f"{folder}/advection.npz"))
    >>> bool(np.array_equal(again.q, solution.q))
    True
    """
    target = validation.file(path, "path")
    if target.suffix == ".nc":
        from fvkit.output.netcdf import write

        return write(solution, target)
    if target.suffix != ".npz":
        raise ValueError(f"`path` must end in .npz or .nc, got {target.name!r}")
    kept, axes = configuration_of(solution), solution.grid.axes
    return write_archive(target, {
        "format": FORMAT, "t": solution.t, "q": solution.q,
        **{name: axis.centers for name, axis in zip(NAMES, axes, strict=False)},
        **{"edges" if len(axes) == 1 else f"edges_{name}": axis.edges for name, axis in zip(NAMES, axes, strict=False)},
        **{f"aux_{name}": values for name, values in solution.aux.items()},
        "status": kept["status"], "message": kept["message"], "configuration": json.dumps(kept, allow_nan=False)})
