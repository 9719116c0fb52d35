"""netCDF after the CF conventions: what a dataset holds, written frame by frame, and read back."""

import json
import os
import re
from collections.abc import Iterable, Mapping
from hashlib import sha256
from importlib import import_module
from pathlib import Path
from types import TracebackType
from typing import TYPE_CHECKING, Any

import attrs
import numpy as np

from fvkit.files import Unreadable, temporary_beside
from fvkit.output.citation import VERSION
from fvkit.output.configuration import configuration_of, model_and_grid, parsed
from fvkit.output.hdf5_file import PatientFile
from fvkit.output.status import Results
from fvkit.problem.grid import Grid
from fvkit.problem.model import Model

if TYPE_CHECKING:
    from xarray import Dataset


#: A file may declare this many times its own size: packed by other tools, states shrink, but no further.
LARGEST_RATIO = 100

#: Names that coordinates and dimensions take.
TAKEN = ("time", "x", "x_bounds", "bounds")


@attrs.frozen
class Field:
    """A variable of a file: what a model calls ``original``, in which role, and its attributes.

    ``role`` is ``"conserved"``, ``"observable"`` (both over time and x) or ``"given"`` (the aux functions, over x).
    """

    name: str
    original: str
    role: str
    attributes: dict[str, str]

    @property
    def dims(self) -> tuple[str, ...]:
        """The dimensions of the variable."""
        return ("x",) if self.role == "given" else ("time", "x")


def fields(model: Model, q: np.ndarray, aux: Mapping[str, np.ndarray]) -> list[Field]:
    """Return the variables of a model; ``q`` (num_eqn, n) is any state. Observables that are rows of q are not repeated."""
    derived = [name for name, values in model.observables(q, aux).items()
               if not any(np.shares_memory(values, row) for row in q)]
    result, taken = [], set(TAKEN)
    for role, names in (("conserved", model.conserved), ("observable", derived), ("given", tuple(aux))):
        for original in names:
            name = base = re.sub(r"\W+", "_", original, flags=re.ASCII).strip("_") or "u"
            name = base = base if not base[0].isdigit() else f"q_{base}"
            for number in range(2, 1000):
                if name not in taken:
                    break
                name = f"{base}_{number}"
            taken.add(name)
            unit, meaning = model.quantities.get(original, ("", original))
            units = {"units": unit} if unit else {}
            result.append(Field(name, original, role, {**units, "long_name": meaning, "original_name": original, "role": role}))
    return result


def frame(model: Model, layout: list[Field], q: np.ndarray, aux: Mapping[str, np.ndarray]) -> dict[str, np.ndarray]:
    """Return the values over time and x of one state, {name: (n,)}."""
    values = {"conserved": dict(zip(model.conserved, q, strict=True)), "observable": model.observables(q, aux)}
    return {field.name: values[field.role][field.original] for field in layout if field.role in values}


def coordinates(grid: Grid) -> dict[str, tuple[tuple[str, ...], np.ndarray, dict[str, str]]]:
    """Return dimensions, values and attributes of the coordinates of a grid."""
    edges = grid.edges
    return {"x": (("x",), grid.centers, {"units": "m", "axis": "X", "long_name": "centre of the cell", "bounds": "x_bounds"}),
            "x_bounds": (("x", "bounds"), np.stack([edges[:-1], edges[1:]], axis=1), {})}


#: Attributes of the time.
TIME = {"units": "s", "axis": "T", "long_name": "time since the start of the clock"}


def global_attributes(kept: Mapping[str, Any]) -> dict[str, str]:
    """Return the attributes of a dataset with that configuration."""
    return {"Conventions": "CF-1.11", "title": f"{kept['model']['class']} on {kept['grid']['num_cells']} cells",
            "source": f"fvkit {VERSION}", "references": kept["citation"], "configuration": json.dumps(kept, allow_nan=False)}


def dataset(solution: Results) -> "Dataset":
    """Return a solution as an xarray.Dataset, see `Solution.to_xarray`."""
    xarray = _library("xarray", "to_xarray")
    model, aux = solution.model, solution.aux
    layout = fields(model, solution.q[0], aux)
    frames = [frame(model, layout, q, aux) for q in solution.q]
    variables = {field.name: (field.dims, aux[field.original] if field.role == "given"
                              else np.array([values[field.name] for values in frames]), field.attributes) for field in layout}
    coords = coordinates(solution.grid) | {"time": (("time",), solution.t, TIME)}
    result: Dataset = xarray.Dataset(variables, coords, global_attributes(configuration_of(solution)))
    return result


class Writer:
    """A netCDF file that grows by a frame at a time, under a temporary name until it is whole.

    Parameters
    ----------
    path : where the file shall stand; until `finish` it is ``NAME.part.nc`` in the same folder, which holds every frame
        added so far, whatever becomes of the process.
    model, grid, aux : whose states they are.
    q : (num_eqn, n) any of them.
    kept : configuration, to be replaced by that of the end.
    part : another temporary name, which no one else uses.

    Raises
    ------
    ValueError
        If another run writes a file of that temporary name now.
    OSError
        Where the disk is full or fails, naming the temporary file, which keeps the frames before.
    """

    def __init__(self, path: Path, model: Model, grid: Grid, aux: Mapping[str, np.ndarray], q: np.ndarray,
                 kept: Mapping[str, Any], part: Path | None = None) -> None:
        h5netcdf, h5py = _library("h5netcdf", "netCDF"), _library("h5py", "netCDF")
        self.path, self.part = path, part or path.with_name(f"{path.stem}.part.nc")
        self._model, self._aux, self._layout, self._count = model, aux, fields(model, q, aux), 0
        self._digest = _digest(aux.values())
        self._disk = PatientFile(self.part)
        self._raw = h5py.File(self._disk, "w", track_order=True)
        self._file = h5netcdf.File(self._raw, "w")
        try:
            self._fill(grid, kept)
            self._check()
        except BaseException:
            self._remove()
            raise

    def _fill(self, grid: Grid, kept: Mapping[str, Any]) -> None:
        """Write what does not hang on time."""
        n = grid.num_cells
        self._file.dimensions = {"time": None, "x": n, "bounds": 2}
        self._add("time", ("time",), TIME, chunks=(512,))
        for name, (dims, values, attributes) in coordinates(grid).items():
            self._add(name, dims, attributes)[:] = values
        for field in self._layout:
            chunks = {"chunks": (1, n)} if "time" in field.dims else {}
            variable = self._add(field.name, field.dims, field.attributes, **chunks)
            if field.role == "given":
                variable[:] = self._aux[field.original]
        self._attributes(kept)

    def _check(self) -> None:
        """Raise what the disk has refused."""
        error = self._disk.error
        if error is not None:
            raise OSError(error.errno, f"{error.strerror}; the frames before are in the file", str(self.part)) from error

    def _add(self, name: str, dims: tuple[str, ...], attributes: Mapping[str, str], **options: Any) -> Any:
        variable = self._file.create_variable(name, dims, float, **options)
        variable.attrs.update(attributes)
        return variable

    def _attributes(self, kept: Mapping[str, Any]) -> None:
        self._file.attrs.update(global_attributes(kept))
        self._file.flush()
        self._raw.flush()

    def add(self, t: float, q: np.ndarray) -> None:
        """Add the state at a time; the time comes last, and then everything goes to disk."""
        k = self._count
        self._file.resize_dimension("time", k + 1)
        for name, values in frame(self._model, self._layout, q, self._aux).items():
            self._file[name][k, :] = values
        self._file["time"][k] = t
        self._digest.update(np.array(t, dtype=float).tobytes() + np.ascontiguousarray(q).tobytes())
        self._count = k + 1
        self._raw.flush()
        self._check()

    def close(self) -> None:
        """Close the file under its temporary name."""
        self._file.close()
        self._raw.close()
        self._disk.close()

    def _seal(self) -> None:
        """Note the checksum of everything that `read` takes from the file."""
        self._digest.update(self._file.attrs["configuration"].encode())
        self._file.attrs["checksum"] = self._digest.hexdigest()
        self._file.flush()
        self._raw.flush()

    def finish(self, kept: Mapping[str, Any]) -> Path:
        """Write the configuration of the end, close the file and give it its name."""
        self._attributes(kept)
        self._seal()
        self.close()
        self._check()
        os.replace(self.part, self.path)
        return self.path

    def __enter__(self) -> "Writer":
        return self

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None) -> None:
        if kind is not None:
            self._remove()

    def _remove(self) -> None:
        self.close()
        self.part.unlink(missing_ok=True)


def write(solution: Results, path: Path) -> Path:
    """Write a solution to a netCDF file, whole or not at all."""
    kept, part = configuration_of(solution), temporary_beside(path)
    try:
        with Writer(path, solution.model, solution.grid, solution.aux, solution.q[0], kept, part) as writer:
            for t, q in zip(solution.t, solution.q, strict=True):
                writer.add(float(t), q)
            return writer.finish(kept)
    except OSError as error:
        cause = error.__cause__ if isinstance(error.__cause__, OSError) else error
        raise OSError(cause.errno, f"{cause.strerror}, so nothing was changed", str(path)) from error


#: Of a solution in a file: times, states, aux values, configuration, model, grid.
Pieces = tuple[np.ndarray, np.ndarray, dict[str, np.ndarray], dict[str, Any], Model, Grid]


def read(path: Path) -> Pieces:
    """Read what a netCDF file holds of a solution, see `fvkit.load`."""
    h5netcdf, h5py = _library("h5netcdf", "netCDF"), _library("h5py", "netCDF")
    if not path.exists():
        raise FileNotFoundError(f"there is no file {path}")
    try:
        # Opened by h5py first: h5netcdf cannot close what it could not open.
        with h5py.File(path, "r") as raw, h5netcdf.File(raw, "r") as file:
            return _read(file, path)
    except Unreadable:
        raise
    except (OSError, KeyError, RuntimeError, AttributeError, TypeError, ValueError, IndexError, MemoryError) as error:
        raise Unreadable(path, f"it is damaged or no netCDF file ({' '.join(str(error).split())})") from None


def _read(file: Any, path: Path) -> Pieces:
    kept_text = file.attrs.get("configuration")
    if not isinstance(kept_text, str):
        raise Unreadable(path, "it has no attribute 'configuration', so fvkit did not write it")
    kept = parsed(kept_text, path)
    model, grid = model_and_grid(kept, path)
    found = {(variable.attrs.get("role"), variable.attrs.get("original_name")): variable
             for variable in file.variables.values()}
    bound, n = LARGEST_RATIO * path.stat().st_size, grid.num_cells

    def values(variable: Any, name: str, shape: tuple[int, ...]) -> np.ndarray:
        if variable is None:
            raise Unreadable(path, f"it has no {name!r}")
        if variable.shape != shape or variable.dtype != np.dtype(float):
            raise Unreadable(path, f"{name!r} must be float64 of shape {shape}, got {variable.dtype} of shape "
                             f"{variable.shape}")
        return np.array(variable[...])

    if "time" not in file.variables:
        raise Unreadable(path, "it has no 'time'")
    k = int(np.prod(file.variables["time"].shape))
    declared = 8 * (k * (len(model.conserved) * n + 1) + len(model.aux) * n)
    if declared > bound:
        raise Unreadable(path, f"it declares {declared} bytes of content, more than {LARGEST_RATIO} times its size")
    t = values(file.variables["time"], "time", (k,))
    q = np.empty((k, len(model.conserved), n))
    for row, name in enumerate(model.conserved):
        q[:, row] = values(found.get(("conserved", name)), name, (k, n))
    aux = {name: values(found.get(("given", name)), name, (n,)) for name in model.aux}
    _check(file.attrs.get("checksum"), t, q, aux, kept_text, path)
    while k > 1 and not t[k - 1] > t[k - 2]:  # a frame that was cut off: its time comes last
        k -= 1
    return t[:k], q[:k], aux, kept, model, grid


def _digest(aux: Iterable[np.ndarray]) -> Any:
    """Start a checksum: of the aux values, to which times and states, frame by frame, and the configuration are added."""
    return sha256(b"".join(np.ascontiguousarray(values, dtype=float).tobytes() for values in aux))


def _check(checksum: Any, t: np.ndarray, q: np.ndarray, aux: Mapping[str, np.ndarray], kept: str, path: Path) -> None:
    """Refuse values that are not those that were written; a run that was cut off has left no checksum."""
    if checksum is None:
        return
    found = _digest(aux.values())
    for time, state in zip(t, q, strict=True):
        found.update(time.tobytes() + state.tobytes())
    found.update(kept.encode())
    if found.hexdigest() != checksum:
        raise Unreadable(path, "its values are not those that were written: it is damaged, or was changed")


def _library(name: str, what: str) -> Any:
    try:
        return import_module(name)
    except ImportError:
        raise ImportError(f"{what} needs {name}: pip install 'fvkit[io]'") from None
