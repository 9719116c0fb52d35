"""`Convergence`: errors and observed orders over the number of cells."""

import json
from pathlib import Path
from typing import TYPE_CHECKING, Any

import attrs
import numpy as np

from fvkit.files import write_whole
from fvkit.studies.tables import ROUNDING, plain, table
from fvkit.validation import Portable

if TYPE_CHECKING:
    from matplotlib.axes import Axes


class OrderError(Portable, AssertionError):
    """A scheme that does not show the expected order; the message holds the table.

    Parameters
    ----------
    message : the sentence and the table.
    convergence : the `Convergence`.
    """

    def __init__(self, message: str, convergence: "Convergence") -> None:
        super().__init__(message)
        self.convergence = convergence


def observed(errors: np.ndarray, cells: Any) -> np.ndarray:
    """Return log(E_k/E_{k+1})/log(N_{k+1}/N_k) along the first axis; NaN where errors are rounding."""
    with np.errstate(all="ignore"):
        ratios = np.log(errors[:-1] / errors[1:])
    steps = np.diff(np.log(np.asarray(cells, dtype=float))).reshape(-1, *[1] * (errors.ndim - 1))
    return np.where(np.minimum(errors[:-1], errors[1:]) > ROUNDING, ratios / steps, np.nan)


@attrs.frozen(eq=False)
class Convergence:
    """What `fvkit.convergence` found.

    Parameters
    ----------
    scheme, model : what was run, in words.
    kind : of the reference: ``"exact"``, ``"semi-exact"`` or ``"self-converged"``.
    norm : ``"l1"``, ``"l2"`` or ``"max"``.
    names : the conserved components.
    runs : numbers of cells that were run.
    errors : (rows, num_eqn); one row per run, or one less: then they are differences to the next grid.
    seconds : wall time of the stepping of each run.
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
        """Whether there was no reference: ``errors`` are differences to the next grid."""
        return len(self.errors) < len(self.runs)

    @property
    def cells(self) -> tuple[int, ...]:
        """Numbers of cells that have an error, one per row."""
        return self.runs[:len(self.errors)]

    @property
    def totals(self) -> np.ndarray:
        """Errors summed over the components, (rows,)."""
        return self.errors.sum(axis=1)

    @property
    def orders(self) -> np.ndarray:
        """Observed order of each component between successive rows, (rows - 1, num_eqn); NaN where errors are rounding."""
        return observed(self.errors, self.cells)

    @property
    def total_orders(self) -> np.ndarray:
        """Observed order of the sum of the components between successive rows, (rows - 1,)."""
        return observed(self.totals, self.cells)

    @property
    def finest_error(self) -> float | None:
        """Error of the finest run in the sum of components: measured, or |difference|/(r^p - 1) by Richardson.

        r is the factor between the grids and p the last observed order. None where the differences do not fall.
        """
        if not self.differences:
            return float(self.totals[-1])
        p = self.total_orders[-1]
        return float(self.totals[-1] / ((self.runs[-1] / self.runs[-2]) ** p - 1.0)) if p > 0.0 else None

    def check(self, expect: float) -> None:
        """Raise `OrderError` unless the sum of the components shows at least order ``expect`` in the last two rows."""
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

    def plot(self, ax: "Axes | None" = None) -> "Axes":
        """Draw errors over cells, log-log, with a guide of the observed order; returns the axes."""
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
        """Return everything as JSON."""
        rows = [{"cells": n, "seconds": s, "error": dict(zip(self.names, row, strict=True)), "total": total}
                for n, s, row, total in zip(self.cells, self.seconds, self.errors, self.totals, strict=False)]
        for row, orders, total in zip(rows[1:], self.orders, self.total_orders, strict=True):
            row |= {"order": dict(zip(self.names, orders, strict=True)), "total_order": total}
        return json.dumps(plain({"scheme": self.scheme, "model": self.model, "reference": self.kind, "norm": self.norm,
                                 "rows": rows, "finest_error": self.finest_error}), indent=1)

    def save(self, folder: str | Path) -> Path:
        """Write convergence.json and convergence.png into ``folder``, made where missing; return it."""
        target = Path(folder)
        target.mkdir(parents=True, exist_ok=True)
        write_whole(target / "convergence.json", lambda file: file.write(self.to_json().encode()))
        figure: Any = self.plot().figure
        write_whole(target / "convergence.png", lambda file: figure.savefig(file, format="png", dpi=130))
        return target
