"""Recording of outputs: in memory, or streamed to a netCDF file."""

from collections.abc import Mapping
from functools import partial
from pathlib import Path
from typing import Any

import attrs
import numpy as np

from fvkit import validation
from fvkit.output.configuration import effective
from fvkit.output.status import Stats, Status
from fvkit.problem.problem import Problem
from fvkit.schemes.scheme import Scheme


class InMemory:
    """Outputs in memory, in one preallocated array: times `t` and states `q`, (k, num_eqn, *grid.shape), those of a Solution."""

    def __init__(self, count: int, q0: np.ndarray) -> None:
        self._t: list[float] = []
        self._q = np.empty((count, *q0.shape))

    def add(self, t: float, q: np.ndarray) -> None:
        self._q[len(self._t)] = q
        self._t.append(t)

    @property
    def t(self) -> np.ndarray:
        return np.array(self._t)

    @property
    def q(self) -> np.ndarray:
        return self._q[:len(self._t)]

    def finish(self, kept: Mapping[str, Any]) -> None:
        pass

    def abandon(self) -> None:
        pass


class NetcdfStream:
    """Outputs streamed to a netCDF file; only the first and the last state stay in memory.

    Until the end of the run the file is called NAME.part.nc, and has the configuration of problem and scheme before a run.
    """

    def __init__(self, path: Path, problem: Problem, scheme: Scheme) -> None:
        from fvkit.output.netcdf import Writer

        nothing = Stats(0, 0, 0, 0.0, 0.0, 0.0, "none", 0, {})
        kept = effective(problem, scheme, nothing, Status.INTERRUPTED, "the process ended before the run did")
        self._open = partial(Writer, path, problem.model, problem.grid, problem.aux_averages, problem.q0, kept)
        self._writer: Writer | None = None
        self._broken = False
        self._ends: list[tuple[float, np.ndarray]] = []

    def add(self, t: float, q: np.ndarray) -> None:
        """Append a state at a time."""
        try:
            if not self._broken:
                self._writer = self._writer or self._open()
                self._writer.add(t, q)
        except OSError:
            self._broken = True  # the file keeps its outputs; the run ends with its last state in memory
            self._keep(t, q)
            raise
        self._keep(t, q)

    def _keep(self, t: float, q: np.ndarray) -> None:
        self._ends = [*self._ends[:1], (t, q.copy())]

    @property
    def t(self) -> np.ndarray:
        return np.array([t for t, _ in self._ends])

    @property
    def q(self) -> np.ndarray:
        return np.array([q for _, q in self._ends])

    def finish(self, kept: Mapping[str, Any]) -> None:
        """Store the final configuration of the run."""
        if self._writer is None or self._broken:
            return
        try:
            self._writer.finish(kept)
        except OSError:
            self.abandon()
            raise

    def abandon(self) -> None:
        """Close without finishing, after an unrelated error; later outputs stay in memory."""
        self._broken = True
        if self._writer is not None:
            self._writer.close()


#: Outputs of a run.
Snapshots = InMemory | NetcdfStream


def _netcdf(value: Any) -> Path:
    path = validation.file(value, "path")
    if path.suffix != ".nc":
        raise ValueError(f"`path` must end in .nc, got {path.name!r}: snapshots are appended to a netCDF file")
    return path


@attrs.frozen
class Stream:
    """Streaming of outputs to a netCDF file during the run; needs the extra ``io``.

    Parameters
    ----------
    path : path that ends in .nc. During the run the file is called NAME.part.nc; a killed run leaves that file, which
        `fvkit.load` reads.

    Raises
    ------
    ValueError, TypeError
        If ``path`` is not a file name that ends in .nc.

    Examples
    --------
    >>> import fvkit as fv
    >>> fv.Stream("run.nc").path.name
    'run.nc'
    """

    path: Path = attrs.field(converter=_netcdf)

    def opened(self, problem: Problem, scheme: Scheme) -> Snapshots:
        """Return the `Snapshots` of a run, which write to this file."""
        return NetcdfStream(self.path, problem, scheme)
