"""`SweepResult`: result of a sweep, as arrays, a table, or an xarray Dataset."""

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import attrs
import numpy as np

from fvkit import validation
from fvkit.files import csv_text, write_whole
from fvkit.problem.grid import NAMES
from fvkit.sweeps.member import FINISHED, MemberResult
from fvkit.sweeps.samples import Samples

if TYPE_CHECKING:
    import xarray


@attrs.frozen(eq=False, repr=False)
class SweepResult:
    """Result of a sweep: parameters, outputs and status of every member.

    Parameters
    ----------
    samples : the parameters, `Samples`.
    outputs : {output: (members, ...)}, NaN where a member did not finish; an array of objects, None there, where
        the members returned arrays of different shapes.
    status : (members,) ``"finished"``, a `fvkit.Status` in small letters, ``"error"`` (the function raised), or
        ``"lost"`` (the executor failed, also in repetitions), or ``"interrupted"`` (by Ctrl-C).
    message : (members,) one sentence where a member did not finish.
    seconds : (members,) wall time of the function, s.
    elapsed : wall time of this sweep, s, without members read from a folder.

    Examples
    --------
    >>> import fvkit as fv
    >>> result = fv.sweep(pow, {"x": [1.0]}, workers=1)
    >>> result.success, result.status.tolist()
    (False, ['error'])
    """

    samples: Samples
    outputs: dict[str, np.ndarray]
    status: np.ndarray
    message: np.ndarray
    seconds: np.ndarray
    elapsed: float

    def __repr__(self) -> str:
        return (f"<SweepResult: {int(self.finished.sum())} of {len(self.samples)} members finished, {self.elapsed:.3g} s; "
                f"parameters {', '.join(self.samples.values)}; outputs {', '.join(self.outputs)}>")

    @classmethod
    def of(cls, samples: Samples, outcomes: Sequence[MemberResult], elapsed: float) -> "SweepResult":
        """Return the result of outcomes in the order of the members."""
        names = dict.fromkeys(name for outcome in outcomes for name in outcome.outputs)
        return cls(samples, {name: _stack([outcome.outputs.get(name) for outcome in outcomes]) for name in names},
                   np.array([outcome.status for outcome in outcomes]), np.array([outcome.message for outcome in outcomes]),
                   np.array([outcome.seconds for outcome in outcomes]), elapsed)

    @property
    def finished(self) -> np.ndarray:
        """Which members finished, (members,)."""
        return self.status == FINISHED

    @property
    def success(self) -> bool:
        """Whether all members finished."""
        return bool(self.finished.all())

    @property
    def table(self) -> dict[str, np.ndarray]:
        """One column per parameter, per output that is a number, and of the status, {name: (members,)}."""
        scalars = {name: values for name, values in self.outputs.items() if values.ndim == 1 and values.dtype != object}
        return {"member": np.arange(len(self.samples)), **self.samples.values, **scalars, "status": self.status,
                "seconds": self.seconds, "message": self.message}

    def to_xarray(self) -> "xarray.Dataset":
        """Return a Dataset: a dimension per parameter for grids, else one dimension ``member``.

        Cell values have the dimension ``x``, on grids with two axes ``y`` and ``x``, where all members share the cells.

        Raises
        ------
        ImportError
            Without xarray, naming the extra.
        ValueError
            For arrays of different shapes.
        """
        xarray = validation.library("xarray", "to_xarray", "io")
        ragged = [name for name, values in self.outputs.items() if values.dtype == object]
        if ragged:
            raise ValueError(f"{', '.join(ragged)} have different shapes in different members, which no Dataset holds: "
                             "keep numbers (such as max.h), or use as many cells in all members")
        axes, outputs = dict(self.samples.axes), dict(self.outputs)
        shape = tuple(map(len, axes.values())) if axes else (len(self.samples),)
        first = tuple(axes) if axes else ("member",)
        coordinates: dict[str, Any] = axes or {"member": np.arange(len(self.samples))} | {
            name: ("member", column) for name, column in self.samples.values.items()}
        cells = self._cells()
        coordinates |= cells
        for name in cells:
            del outputs[name]
        columns = outputs | {"status": self.status, "message": self.message, "seconds": self.seconds}
        data = {}
        for name, values in columns.items():
            lengths, rest = values.shape[1:], list(cells)
            if lengths != tuple(map(len, cells.values())):
                rest = [next((given for given in cells if count == len(cells[given])), f"{name}_{axis}")
                        for axis, count in enumerate(lengths)]
            if len(set(rest)) < len(rest):
                rest = [f"{name}_{axis}" for axis in range(len(rest))]
            data[name] = ((*first, *rest), values.reshape(*shape, *values.shape[1:]))
        return xarray.Dataset(data, coordinates, {"elapsed": self.elapsed})

    def _cells(self) -> dict[str, np.ndarray]:
        """The cell centres along the axes, the last first, if all finished members have the same; y where outputs are maps."""
        x, y = (self._shared(name) for name in NAMES)
        if x is None:
            return {}
        maps = y is not None and any(values.shape[1:] == (len(y), len(x)) for values in self.outputs.values())
        return {"y": y, "x": x} if y is not None and maps else {"x": x}

    def _shared(self, name: str) -> np.ndarray | None:
        """An output that is a row of numbers, the same in all finished members; else None."""
        rows = self.outputs.get(name)
        if rows is None or rows.ndim != 2 or rows.dtype == object or not self.finished.any() or name in self.samples.values:
            return None
        done = rows[self.finished]
        return done[0] if np.array_equal(done, np.broadcast_to(done[0], done.shape)) else None

    def to_csv(self) -> str:
        """Return `table` as CSV text."""
        return csv_text(self.table, zip(*(column.tolist() for column in self.table.values()), strict=True))

    def save(self, path: str | Path) -> Path:
        """Write the table to ``.csv``, or everything to ``.nc`` (netCDF, extra ``io``); a failure keeps an existing file."""
        target = Path(path)
        if target.suffix == ".csv":
            return write_whole(target, self.to_csv())
        if target.suffix != ".nc":
            raise ValueError(f"`path` must end in .csv or .nc, got {target.name!r}")
        validation.library("h5netcdf", "netCDF", "io")
        return write_whole(target, bytes(self.to_xarray().to_netcdf(engine="h5netcdf")))


def _stack(values: Sequence[np.ndarray | None]) -> np.ndarray:
    """One array of all members, NaN for those that have no value."""
    there = [value for value in values if value is not None]
    if len({value.shape for value in there}) > 1:
        result = np.empty(len(values), dtype=object)
        result[:] = list(values)
        return result
    if len(there) == len(values):
        return np.stack(there)
    kind = np.result_type(float, *(value.dtype for value in there))
    missing = np.full(there[0].shape, np.nan, dtype=kind)
    return np.stack([missing if value is None else value.astype(kind) for value in values])
