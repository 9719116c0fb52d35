"""Work-precision: run time that each series of runs needs for a given error."""

import math
from collections.abc import Mapping, Sequence
from typing import Any

import attrs
import numpy as np

from fvkit.studies.tables import ROUNDING, preformatted, table

Row = dict[str, Any]


def time_to_reach(rows: Sequence[Row], observable: str, error: float) -> float | None:
    """Return the run time that a series needs for an error, s, interpolated in log-log; None if the error is not reached.

    If even the coarsest run is more accurate, the result is the time of that run.
    """
    points = sorted((row["error"][observable], row["seconds"]) for row in rows)
    errors, seconds = np.log([max(p[0], 1e-300) for p in points]), np.log([max(p[1], 1e-300) for p in points])
    if math.log(error) < errors[0] - 1e-9:
        return None
    return float(np.exp(np.interp(math.log(error), errors, seconds)))


@attrs.frozen
class WorkPrecision:
    """Run times of all series for given errors.

    Parameters
    ----------
    observable : observable of the L1 error.
    targets : errors, descending.
    seconds : {label of a series: time to reach each target, s, None if not reached}.
    easy : {label: for each target, whether even the coarsest run is more accurate, so that the time is an upper bound}.
    fastest : label of the fastest series of the full model for each target, None if no series reaches the target.

    Examples
    --------
    >>> from fvkit.studies.work_precision import WorkPrecision
    >>> seconds, easy = {"Roe": (0.001, 0.02), "HLL": (0.002, None)}, {"Roe": (True, False), "HLL": (False, False)}
    >>> print(WorkPrecision("h", (1e-2, 1e-3), seconds, easy, fastest=("Roe", "Roe")))
    ms to L1(h) =  1e-02  1e-03
    -------------  -----  -----
    Roe             [<1]   [20]
    HLL               2      -
    """

    observable: str
    targets: tuple[float, ...]
    seconds: Mapping[str, tuple[float | None, ...]]
    easy: Mapping[str, tuple[bool, ...]]
    fastest: tuple[str | None, ...]

    def table(self) -> str:
        """Return a text table of times in ms, one line per series, the fastest of the full model in brackets."""
        head = [f"ms to L1({self.observable}) =", *(f"{target:.0e}" for target in self.targets)]
        body = [[label, *(self._cell(label, k) for k in range(len(self.targets)))] for label in self.seconds]
        return table([head, *body], left=1)

    def _cell(self, label: str, k: int) -> str:
        seconds = self.seconds[label][k]
        if seconds is None:
            return "- "
        text = ("<" if self.easy[label][k] else "") + f"{1e3 * seconds:.3g}"
        return f"[{text}]" if self.fastest[k] == label else f"{text} "

    def __str__(self) -> str:
        return self.table()

    def _repr_html_(self) -> str:
        return preformatted(self.table())

    def as_dict(self) -> dict[str, Any]:
        """Return targets, times and the fastest series as a dictionary for JSON."""
        return {"targets": self.targets, "seconds": self.seconds, "coarsest_is_better": self.easy, "fastest": self.fastest}


def work_precision(series: Mapping[str, Sequence[Row]], observable: str, full: Sequence[str],
                   targets: Sequence[float] | None = None) -> WorkPrecision:
    """Return the run time of every series, {label: rows}, for every target error: None for the powers of ten within the range
    of errors of the runs. The fastest is that of the series in ``full``, those of the full model.
    """
    finished = {label: [row for row in rows if observable in row["error"]] for label, rows in series.items()}
    finished = {label: rows for label, rows in finished.items() if rows}
    errors = [row["error"][observable] for rows in finished.values() for row in rows if row["error"][observable] > ROUNDING]
    wanted = _decades(errors) if targets is None else tuple(sorted(map(float, targets), reverse=True))
    seconds = {label: tuple(time_to_reach(rows, observable, target) for target in wanted) for label, rows in finished.items()}
    easy = {label: tuple(target > max(row["error"][observable] for row in rows) for target in wanted)
            for label, rows in finished.items()}
    fastest = []
    for k in range(len(wanted)):
        times = {label: found for label in full if label in seconds and (found := seconds[label][k]) is not None}
        fastest.append(min(times, key=lambda label: times[label]) if times else None)
    return WorkPrecision(observable, wanted, seconds, easy, tuple(fastest))


def _decades(errors: Sequence[float]) -> tuple[float, ...]:
    if not errors:
        return ()
    first, last = math.floor(math.log10(max(errors)) + 1e-9), math.ceil(math.log10(min(errors)) - 1e-9)
    return tuple(float(f"1e{k}") for k in range(first, last - 1, -1))
