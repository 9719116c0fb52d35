"""Where the outputs of a run go: into memory, or to disk one by one."""

from abc import ABC, abstractmethod
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


class Snapshots(ABC):
    """Abstract collection of outputs: `add` one after the other, then `finish`; `t` and `q` are what the Solution gets."""

    @abstractmethod
    def add(self, t: float, q: np.ndarray) -> None:
        """Add the state (num_eqn, n) at a time."""

    @property
    @abstractmethod
    def t(self) -> np.ndarray:
        """Times, (k,)."""

    @property
    @abstractmethod
    def q(self) -> np.ndarray:
        """States, (k, num_eqn, n)."""

    @abstractmethod
    def finish(self, kept: Mapping[str, Any]) -> None:
        """Note the configuration of the whole run, at its end."""

    @abstractmethod
    def abandon(self) -> None:
        """Let go of what is open, after an error that has nothing to do with the run; what comes is kept in memory alone."""


class InMemory(Snapshots):
    """All outputs, in one array of the size that is needed in the end."""

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


class NetcdfStream(Snapshots):
    """Outputs in a netCDF file, of which only the first and the last stay in memory.

    Parameters
    ----------
    path : a name that ends in .nc; until the end the file is called NAME.part.nc.
    problem, scheme : of the run, for the configuration that a file cut off has.
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
        try:
            if not self._broken:
                self._writer = self._writer or self._open()
                self._writer.add(t, q)
        except OSError:
            self._broken = True  # what is in the file stays there; the run ends, with its last state in memory
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
        if self._writer is None or self._broken:
            return
        try:
            self._writer.finish(kept)
        except OSError:
            self.abandon()
            raise

    def abandon(self) -> None:
        self._broken = True
        if self._writer is not None:
            self._writer.close()


def _netcdf(value: Any) -> Path:
    path = validation.file(value, "path")
    if path.suffix != ".nc":
        raise ValueError(f"`path` must end in .nc, got {path.name!r}: snapshots are appended to a netCDF file")
    return path


@attrs.frozen
class Stream:
    """Outputs written to a netCDF file as the run makes them; needs the extra ``io``.

    Parameters
    ----------
    path : a name that ends in .nc. Until the run ends, well or not, the file is called NAME.part.nc; a run that is killed
        leaves that, readable.

    Raises
    ------
    ValueError, TypeError
        If ``path`` is no name of a file that ends in .nc.

    Examples
    --------
    >>> import fvkit as fv
    >>> fv.Stream("run.nc").path.name
    'run.nc'
    """

    path: Path = attrs.field(converter=_netcdf)

    def opened(self, problem: Problem, scheme: Scheme) -> Snapshots:
        """Return what takes the outputs of a run."""
        return NetcdfStream(self.path, problem, scheme)
