"""`Convergence`: errors and observed orders of a grid refinement study."""

import json
from pathlib import Path
from typing import TYPE_CHECKING, Any

import attrs
import numpy as np

from fvkit.studies.tables import ROUNDING, plain, preformatted, table
from fvkit.validation import Portable

if TYPE_CHECKING:
    from matplotlib.axes import Axes


class OrderError(Portable, AssertionError):
    """Exception for an observed order below the expected one; the message contains the table.

    Parameters
    ----------
    message : a sentence and the table.
    convergence : the `Convergence`.

    Examples
    --------
    >>> import fvkit as fv
    >>> wave = lambda x, t: 1.0 * (x[None] > 0.5 + t)
    >>> problem = lambda n: fv.Problem(fv.Advection(1.0), fv.Grid(0.0, 1.0, n), lambda x: wave(x, 0.0), 0.2)
    >>> found = fv.convergence(problem, None, (50, 100), wave, backend="numpy")
    >>> found.check(2.0)  # doctest: +IGNORE_EXCEPTION_DETAIL
    Traceback (most recent call last):
    fvkit.studies.orders.OrderError: expected order 2 between 50 and 100 cells, observed 0.77
    """

    def __init__(self, message: str, convergence: "Convergence") -> None:
        super().__init__(message)
        self.convergence = convergence


def observed(errors: np.ndarray, cells: Any) -> np.ndarray:
    """Return the observed orders log(E_k/E_{k+1})/log(N_{k+1}/N_k) along the first axis; NaN where errors are round-off."""
    with np.errstate(all="ignore"):
        ratios = np.log(errors[:-1] / errors[1:])
    steps = np.diff(np.log(np.asarray(cells, dtype=float))).reshape(-1, *[1] * (errors.ndim - 1))
    return np.where(np.minimum(errors[:-1], errors[1:]) > ROUNDING, ratios / steps, np.nan)


@attrs.frozen(eq=False)
class Convergence:
    """Result of `fvkit.convergence`: errors and observed orders.

    Parameters
    ----------
    scheme, model : names of the scheme and the model.
    kind : kind of the reference: ``"exact"``, ``"semi-exact"`` or ``"self-converged"``.
    norm : ``"l1"``, ``"l2"`` or ``"max"``.
    names : names of the conserved components.
    runs : number of cells of each run.
    errors : (rows, num_eqn) errors, one row per run; without a reference one row less, with differences to the next grid.
    seconds : wall time of the stepping of each run, s.

    Examples
    --------
    >>> import fvkit as fv
    >>> import numpy as np
    >>> wave = lambda x, t: np.sin(2.0 * np.pi * (x - t))[None]
    >>> ring = lambda n: fv.Problem(fv.Advection(1.0), fv.Grid(0.0, 1.0, n), lambda x: wave(x, 0.0), 0.2, boundary=fv.Periodic())
    >>> found = fv.convergence(ring, fv.WavePropagation(fv.Roe(), order=1), (100, 200, 400), wave, backend="numpy")
    >>> found.cells, bool(found.total_orders[-1] > 0.9)
    ((100, 200, 400), True)
    """

    scheme: str
    model: str
    kind: str
    norm: str
    names: tuple[str, ...]
    runs: tuple[int, ...]
    errors: np.ndarray
    seconds: tuple[float, ...]

    @property
    def differences(self) -> bool:
        """Whether ``errors`` are differences to the next grid, since there was no reference."""
        return len(self.errors) < len(self.runs)

    @property
    def cells(self) -> tuple[int, ...]:
        """Number of cells for each row of ``errors``."""
        return self.runs[:len(self.errors)]

    @property
    def totals(self) -> np.ndarray:
        """Errors summed over the components, (rows,)."""
        return self.errors.sum(axis=1)

    @property
    def orders(self) -> np.ndarray:
        """Observed order of each component between successive rows, (rows - 1, num_eqn); NaN where errors are round-off."""
        return observed(self.errors, self.cells)

    @property
    def total_orders(self) -> np.ndarray:
        """Observed order of the sum of the components between successive rows, (rows - 1,)."""
        return observed(self.totals, self.cells)

    @property
    def finest_error(self) -> float | None:
        """Error of the finest run, summed over the components: measured, or by Richardson extrapolation |difference|/(r^p - 1).

        r is the refinement factor and p the last observed order. None if the differences do not decrease.
        """
        if not self.differences:
            return float(self.totals[-1])
        p = self.total_orders[-1]
        return float(self.totals[-1] / ((self.runs[-1] / self.runs[-2]) ** p - 1.0)) if p > 0.0 else None

    def check(self, expect: float) -> None:
        """Raise `OrderError` unless the observed order of the sum of the components in the last two rows is >= ``expect``."""
        last = self.total_orders[-1]
        if last >= expect:
            return
        found = f"observed {last:.2f}" if np.isfinite(last) else "errors are rounding: no order can be seen, take fewer cells"
        raise OrderError(f"expected order {expect:g} between {self.cells[-2]} and {self.cells[-1]} cells, {found}\n\n"
                         + self.table(), self)

    def table(self) -> str:
        """Return errors and orders as text, one line per number of cells."""
        what = "difference to the next grid" if self.differences else "error"
        columns = self.names if len(self.names) == 1 else (*self.names, "sum")
        head = ["cells", "ms"] + [text for name in columns for text in (name, "ord.")]
        errors, orders = self.errors, self.orders
        if len(self.names) > 1:
            errors = np.column_stack([errors, self.totals])
            orders = np.column_stack([orders, self.total_orders])
        body = []
        for k, (count, row) in enumerate(zip(self.cells, errors, strict=True)):
            shown = orders[k - 1] if k else np.full(len(row), np.nan)
            body.append([str(count), f"{1e3 * self.seconds[k]:.2f}", *(text for error, order in zip(row, shown, strict=True)
                         for text in (f"{error:.2e}", "-" if np.isnan(order) else f"{order:.2f}"))])
        lines = [f"{self.model}, {self.scheme} · reference {self.kind} · {self.norm} {what}", "", table([head, *body], left=0)]
        if self.differences:
            found = self.finest_error
            lines += ["", f"error of the run with {self.runs[-1]} cells: "
                      + (f"about {found:.1e} (Richardson)" if found is not None else "unknown, the differences do not fall")]
        return "\n".join(lines)

    def __str__(self) -> str:
        return self.table()

    def _repr_html_(self) -> str:
        return preformatted(self.table())

    def plot(self, ax: "Axes | None" = None) -> "Axes":
        """Plot errors over the number of cells, log-log, with a reference slope of the observed order; return the axes."""
        from fvkit.output.figures import new_axes, plot_series, slope_guides

        target = ax if ax is not None else new_axes()[1][0]
        columns = dict(zip(self.names, self.errors.T, strict=True)) | ({"sum": self.totals} if len(self.names) > 1 else {})
        plot_series(target, {name: [{"cells": n, "error": e} for n, e in zip(self.cells, column, strict=True)]
                             for name, column in columns.items()}, "cells", "error")
        p = self.total_orders[-1] if len(self.cells) > 1 else np.nan
        if p > 0.5:
            slope_guides(target, self.cells, 1.4 * float(self.totals[0]), (round(float(p)),))
        target.set(xlabel="cells", ylabel=f"{self.norm} error", title=f"{self.model}, {self.scheme}")
        target.set_xticks(self.cells, [str(count) for count in self.cells])
        target.minorticks_off()
        target.legend(fontsize="small")
        return target

    def to_json(self) -> str:
        """Return errors and orders as JSON text."""
        rows = [{"cells": n, "seconds": s, "error": dict(zip(self.names, row, strict=True)), "total": total}
                for n, s, row, total in zip(self.cells, self.seconds, self.errors, self.totals, strict=False)]
        for row, orders, total in zip(rows[1:], self.orders, self.total_orders, strict=True):
            row |= {"order": dict(zip(self.names, orders, strict=True)), "total_order": total}
        return json.dumps(plain({"scheme": self.scheme, "model": self.model, "reference": self.kind, "norm": self.norm,
                                 "rows": rows, "finest_error": self.finest_error}), indent=1)

    def save(self, folder: str | Path) -> Path:
        """Write convergence.json and convergence.png to ``folder``, created if missing, and return its path."""
        from fvkit.output.figures import save_all

        figure: Any = self.plot().figure
        return save_all(folder, {"convergence.json": self.to_json(), "convergence.png": figure})
