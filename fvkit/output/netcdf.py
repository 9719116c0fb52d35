"""netCDF files after the CF conventions: layout of the variables, a writer that appends time levels, and a reader."""

import json
import os
import re
from collections.abc import Iterable, Mapping
from hashlib import sha256
from pathlib import Path
from types import TracebackType
from typing import TYPE_CHECKING, Any

import attrs
import numpy as np

from fvkit.files import Unreadable, temporary_beside
from fvkit.output.citation import VERSION, package
from fvkit.output.configuration import configuration_of, model_and_grid, parsed
from fvkit.output.hdf5_file import PatientFile
from fvkit.output.results import Results
from fvkit.problem.directions import component_names, observables, quantities
from fvkit.problem.grid import NAMES, Grid
from fvkit.problem.model import Model
from fvkit.validation import library

if TYPE_CHECKING:
    from xarray import Dataset


#: Largest accepted ratio of declared content to file size: files compressed by other tools are smaller than their content.
LARGEST_RATIO = 100

@attrs.frozen
class Field:
    """netCDF variable: its valid name, the name ``original`` of the model, its role, its dimensions and its attributes.

    ``role`` is ``"conserved"``, ``"observable"`` (both over time and the axes, the last first) or ``"given"`` (the aux functions,
    over the axes alone).
    """

    name: str
    original: str
    role: str
    dims: tuple[str, ...]
    attributes: dict[str, str]


def dimensions(grid: Grid) -> dict[str, int]:
    """Return the dimensions of an array of cells, {name: length}, the last axis first."""
    return dict(zip(NAMES[:len(grid.axes)][::-1], grid.shape, strict=True))


def fields(model: Model, grid: Grid, q: np.ndarray, aux: Mapping[str, np.ndarray]) -> list[Field]:
    """Return the variables of a model for any state ``q`` (num_eqn, *grid.shape), without observables that are rows of q."""
    derived = [name for name, values in observables(model, grid, q, aux).items()
               if not any(np.shares_memory(values, row) for row in q)]
    known, cells = quantities(model, grid), tuple(dimensions(grid))
    result, taken = [], {"time", "bounds", *coordinates(grid)}
    for role, names in (("conserved", component_names(model, grid)), ("observable", derived), ("given", tuple(aux))):
        for original in names:
            name = base = re.sub(r"\W+", "_", original, flags=re.ASCII).strip("_") or "u"
            name = base = base if not base[0].isdigit() else f"q_{base}"
            for number in range(2, 1000):
                if name not in taken:
                    break
                name = f"{base}_{number}"
            taken.add(name)
            unit, meaning = known.get(original, ("", original))
            units = {"units": unit} if unit else {}
            result.append(Field(name, original, role, cells if role == "given" else ("time", *cells),
                                {**units, "long_name": meaning, "original_name": original, "role": role}))
    return result


def frame(model: Model, grid: Grid, layout: list[Field], q: np.ndarray, aux: Mapping[str, np.ndarray]) -> dict[str, np.ndarray]:
    """Return conserved components and observables of one state, {name: grid.shape}."""
    values = {"conserved": dict(zip(component_names(model, grid), q, strict=True)),
              "observable": observables(model, grid, q, aux)}
    return {field.name: values[field.role][field.original] for field in layout if field.role in values}


def coordinates(grid: Grid) -> dict[str, tuple[tuple[str, ...], np.ndarray, dict[str, str]]]:
    """Return the coordinates of a grid, {name: (dimensions, values, attributes)}."""
    result: dict[str, tuple[tuple[str, ...], np.ndarray, dict[str, str]]] = {}
    for name, axis in zip(NAMES, grid.axes, strict=False):
        edges, bounds = axis.edges, f"{name}_bounds"
        result[name] = ((name,), axis.centers,
                        {"units": "m", "axis": name.upper(), "long_name": "centre of the cell", "bounds": bounds})
        result[bounds] = (name, "bounds"), np.stack([edges[:-1], edges[1:]], axis=1), {}
    return result


#: Attributes of the time coordinate.
TIME = {"units": "s", "axis": "T", "long_name": "time since the start of the clock"}


def global_attributes(kept: Mapping[str, Any]) -> dict[str, str]:
    """Return the global attributes of a dataset, {name: text}."""
    cells = " x ".join(map(str, np.ravel(kept["grid"]["num_cells"])))
    return {"Conventions": "CF-1.11", "title": f"{kept['model']['class']} on {cells} cells",
            "source": f"fvkit {VERSION}", "references": kept.get("citation", package().sentence()),
            "configuration": json.dumps(kept, allow_nan=False)}


def dataset(solution: Results) -> "Dataset":
    """Return a solution as an ``xarray.Dataset``, see `Solution.to_xarray`."""
    xarray = library("xarray", "to_xarray", "io")
    model, grid, aux = solution.model, solution.grid, solution.aux
    layout = fields(model, grid, solution.q[0], aux)
    frames = [frame(model, grid, layout, q, aux) for q in solution.q]
    variables = {field.name: (field.dims, aux[field.original] if field.role == "given"
                              else np.array([values[field.name] for values in frames]), field.attributes) for field in layout}
    coords = coordinates(grid) | {"time": (("time",), solution.t, TIME)}
    result: Dataset = xarray.Dataset(variables, coords, global_attributes(configuration_of(solution)))
    return result


class Writer:
    """netCDF writer that appends one time level per call, under a temporary name until the file is complete.

    Parameters
    ----------
    path : final path of the file. Until `finish` it is ``NAME.part.nc`` in the same folder, which contains every time level
        added so far, even if the process is killed. A ValueError where another run is writing to it; an OSError names it.
    model, grid, aux : model, grid and aux values of the states.
    q : (num_eqn, *grid.shape) any state.
    kept : preliminary configuration; `finish` replaces it.
    part : another temporary path, used by this writer alone.
    """

    def __init__(self, path: Path, model: Model, grid: Grid, aux: Mapping[str, np.ndarray], q: np.ndarray,
                 kept: Mapping[str, Any], part: Path | None = None) -> None:
        h5netcdf, h5py = library("h5netcdf", "netCDF", "io"), library("h5py", "netCDF", "io")
        self.path, self.part = path, part or path.with_name(f"{path.stem}.part.nc")
        self._model, self._grid, self._aux, self._layout, self._count = model, grid, aux, fields(model, grid, q, aux), 0
        self._digest = _digest(aux.values())
        self._disk = PatientFile(self.part)
        self._raw = h5py.File(self._disk, "w", track_order=True)
        self._file = h5netcdf.File(self._raw, "w")
        try:
            self._fill(kept)
            self._check()
        except BaseException:
            self._remove()
            raise

    def _fill(self, kept: Mapping[str, Any]) -> None:
        """Write the time-independent variables."""
        grid = self._grid
        self._file.dimensions = {"time": None, **dimensions(grid), "bounds": 2}
        fixed = {name: np.bytes_(text) for name, text in TIME.items()}  # VTK, in ParaView, reads texts of fixed length alone
        self._add("time", ("time",), fixed, chunks=(512,))
        for name, (dims, values, attributes) in coordinates(grid).items():
            self._add(name, dims, attributes)[:] = values
        mapping = self._map(kept)
        for field in self._layout:
            chunks = {"chunks": (1, *grid.shape)} if "time" in field.dims else {}
            variable = self._add(field.name, field.dims, field.attributes | mapping, **chunks)
            if field.role == "given":
                variable[:] = self._aux[field.original]
        self._attributes(kept)

    def _map(self, kept: Mapping[str, Any]) -> dict[str, str]:
        """Write the coordinate reference system that the configuration names, and return the attribute that refers to it."""
        crs = kept.get("crs")
        if crs is None or len(self._grid.axes) != 2:
            return {}
        x, y = self._grid.axes
        named = {"crs_wkt": crs, "spatial_ref": crs} if "[" in crs else {"crs_name": crs}  # a name such as EPSG:31287 is no WKT
        self._file.create_variable("crs", (), "i4").attrs.update({
            "long_name": "coordinate reference system", **named,
            "GeoTransform": f"{x.lower!r} {x.dx!r} 0 {y.lower!r} 0 {y.dx!r}"})
        return {"grid_mapping": "crs"}

    def _check(self) -> None:
        """Raise the stored write error of the file, if there is one."""
        error = self._disk.error
        if error is not None:
            raise OSError(error.errno, f"{error.strerror}; the frames before are in the file", str(self.part)) from error

    def _add(self, name: str, dims: tuple[str, ...], attributes: Mapping[str, Any], **options: Any) -> Any:
        variable = self._file.create_variable(name, dims, float, **options)
        variable.attrs.update(attributes)
        return variable

    def _attributes(self, kept: Mapping[str, Any]) -> None:
        self._file.attrs.update(global_attributes(kept))
        self._file.flush()
        self._raw.flush()

    def add(self, t: float, q: np.ndarray) -> None:
        """Append the state at time ``t`` and flush; the time is written last, so an incomplete time level is detected."""
        k = self._count
        self._file.resize_dimension("time", k + 1)
        for name, values in frame(self._model, self._grid, self._layout, q, self._aux).items():
            self._file[name][k, ...] = values
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
        """Write the checksum of all values that `read` uses."""
        self._digest.update(self._file.attrs["configuration"].encode())
        self._file.attrs["checksum"] = self._digest.hexdigest()
        self._file.flush()
        self._raw.flush()

    def finish(self, kept: Mapping[str, Any]) -> Path:
        """Write the final configuration, close the file, rename it to its final path and return that."""
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
    """Write a solution to a netCDF file atomically and return its path."""
    kept, part = configuration_of(solution), temporary_beside(path)
    try:
        with Writer(path, solution.model, solution.grid, solution.aux, solution.q[0], kept, part) as writer:
            for t, q in zip(solution.t, solution.q, strict=True):
                writer.add(float(t), q)
            return writer.finish(kept)
    except OSError as error:
        cause = error.__cause__ if isinstance(error.__cause__, OSError) else error
        raise OSError(cause.errno, f"{cause.strerror}, so nothing was changed", str(path)) from error


#: Content of a solution file: times, states, aux values, configuration, model, grid.
Pieces = tuple[np.ndarray, np.ndarray, dict[str, np.ndarray], dict[str, Any], Model, Grid]


def read(path: Path) -> Pieces:
    """Return the content of a solution from a netCDF file, see `fvkit.load`."""
    h5netcdf, h5py = library("h5netcdf", "netCDF", "io"), library("h5py", "netCDF", "io")
    if not path.exists():
        raise FileNotFoundError(f"there is no file {path}")
    try:
        # h5py opens the file first, since h5netcdf leaves it open when it fails to open it.
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
    bound, names = LARGEST_RATIO * path.stat().st_size, component_names(model, grid)

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
    declared = 8 * (k * (len(names) * grid.size + 1) + len(model.aux) * grid.size)
    if declared > bound:
        raise Unreadable(path, f"it declares {declared} bytes of content, more than {LARGEST_RATIO} times its size")
    t = values(file.variables["time"], "time", (k,))
    q = np.empty((k, len(names), *grid.shape))
    for row, name in enumerate(names):
        q[:, row] = values(found.get(("conserved", name)), name, (k, *grid.shape))
    aux = {name: values(found.get(("given", name)), name, grid.shape) for name in model.aux}
    _check(file.attrs.get("checksum"), t, q, aux, kept_text, path)
    while k > 1 and not t[k - 1] > t[k - 2]:  # drop an incomplete time level, whose time was not written
        k -= 1
    return t[:k], q[:k], aux, kept, model, grid


def _digest(aux: Iterable[np.ndarray]) -> Any:
    """Return a hash object of the aux values; the caller adds times, states and the configuration."""
    return sha256(b"".join(np.ascontiguousarray(values, dtype=float).tobytes() for values in aux))


def _check(checksum: Any, t: np.ndarray, q: np.ndarray, aux: Mapping[str, np.ndarray], kept: str, path: Path) -> None:
    """Raise `Unreadable` where the checksum differs from the values; the file of an interrupted run has no checksum."""
    if checksum is None:
        return
    found = _digest(aux.values())
    for time, state in zip(t, q, strict=True):
        found.update(time.tobytes() + state.tobytes())
    found.update(kept.encode())
    if found.hexdigest() != checksum:
        raise Unreadable(path, "its values are not those that were written: it is damaged, or was changed")
