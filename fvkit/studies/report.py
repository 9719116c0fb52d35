"""`Report`: error versus run time for many runs of one scene, as table, files and figures."""

import json
import os
import platform
from collections.abc import Mapping, Sequence
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path
from typing import TYPE_CHECKING, Any

import attrs
import numpy as np

from fvkit import validation
from fvkit.files import csv_text
from fvkit.studies.orders import observed
from fvkit.studies.report_data import ReportData, flat
from fvkit.studies.tables import ROUNDING, WIDTH, filled, plain, preformatted, table
from fvkit.studies.work_precision import Row, WorkPrecision, time_to_reach, work_precision

if TYPE_CHECKING:
    from matplotlib.figure import Figure


#: Columns that identify the scheme of a run; the table shows those that differ between the runs.
SETTINGS = ("scheme", "limiter", "order", "integrator", "options")


def environment(*packages: str) -> tuple[dict[str, Any], dict[str, str]]:
    """Return (machine, versions), two dictionaries for a report: hardware, and versions of Python and the given packages."""
    machine = {"processor": _processor(), "cores": os.cpu_count(), "system": platform.platform()}
    versions = {"python": platform.python_version()}
    for name in packages:
        try:
            versions[name] = version(name)
        except PackageNotFoundError:
            continue
    return machine, versions


def _processor() -> str:
    try:
        lines = Path("/proc/cpuinfo").read_text(encoding="utf-8").splitlines()
    except OSError:
        return platform.processor() or platform.machine()
    names = [line.split(":", 1)[1].strip() for line in lines if line.startswith("model name")]
    return names[0] if names else platform.machine()


@attrs.frozen(eq=False)
class Report(ReportData):
    """Result of a comparison: errors and run times of many runs of one scene.

    Parameters
    ----------
    scene : name of the scene.
    reference : {"kind": "exact" | "semi-exact" | "self-converged", "detail": sentence}.
    rows : one dict per run; a failed run is a row with its status.
    machine, versions : hardware and software of the measurement, see ``fvkit.studies.environment``.
    full_model : name of the model of the reference; errors of other models include a modelling error.
    profiles : {label: ``(x, observables, y)``} of the finest run of each series; the reference under ``"reference"``.
    bottom : (x, b) on the finest grid, b (n,) or (ny, nx); None if flat.
    remarks : further information on the reference, {name: dict with a line of ``text``, or None}, for the table and
        report.json.

    Examples
    --------
    >>> import fvkit as fv, fvkit_granular as gr
    >>> report = gr.compare(gr.scene("dam-break"), [gr.ShallowWater], [fv.Roe(), fv.HLL()], cells=(50, 100), backend="numpy")
    >>> report.reference["kind"], [(row["riemann"], row["cells"]) for row in report.rows]
    ('exact', [('roe', 50), ('roe', 100), ('hll', 50), ('hll', 100)])
    """

    def table(self, wide: bool = False) -> str:
        """Return the report as text of at most 100 columns: a header, one line per run, notes and the verdict.

        Parameters
        ----------
        wide : keep every column; else the least important ones are left out where the table is too wide, and listed below it.
        """
        columns = self._columns()
        left_out = [] if wide else _narrow(columns)
        others = sorted({row["model"] for row in self.rows} - {self.full_model})
        where = "x and y, cells = those along x" if self.has_maps else "x"
        notes = [f"L1 = integral of |error| over {where}, ord. = observed order; ms = median wall time of the stepping."]
        if left_out:
            notes.append(f"Left out: {', '.join(left_out)} (table(wide=True), fvkit compare --wide; report.csv has all).")
        if others:
            notes.append(f"* {', '.join(others)}: the error is a model error against the full model ({self.full_model}), with "
                         "the scheme's on top.")
        head = f"scene {self.scene} · reference {self.reference['kind']}: {self.reference['detail']}"
        fixed = ", ".join(f"{key} {self.rows[0][key]}" for key in (*SETTINGS, "backend")
                          if not self._varies(key) and self.rows[0][key])
        text = [filled(head), filled(fixed), "", table(_lines(columns)), "", *map(filled, notes)]
        reached = self.work_precision()
        if reached is not None and reached.targets:
            text += ["", reached.table(), "",
                     filled("Times interpolated between runs. [..] fastest for the full model; '<': even the coarsest grid is "
                            "more accurate; '-': accuracy not reached.")]
        text += [filled(remark["text"]) for remark in self.remarks.values() if remark is not None]
        return "\n".join([*text, filled("Verdict: " + self.verdict())])

    def _columns(self) -> dict[str, list[str]]:
        """Return the columns of the table, {heading: text of each run}."""
        observables = list(dict.fromkeys(name for row in self.rows for name in row["error"]))
        columns = {"model": [row["model"] + ("" if row["model"] == self.full_model else "*") for row in self.rows],
                   "riemann": [row["riemann"] for row in self.rows]}
        for name, key in [*((key, key) for key in SETTINGS[1:] if self._varies(key)), ("cells", "cells"), ("steps", "steps"),
                          ("rej.", "rejected")]:
            columns[name] = ["-" if row[key] in (None, "") else str(row[key]) for row in self.rows]
        for name, key, factor, digits in (("ms", "seconds", 1e3, 2), ("ms min", "seconds_min", 1e3, 2),
                                          ("ns/cell", "ns_per_cell_step", 1.0, 0)):
            columns[name] = ["-" if row[key] is None else f"{factor * row[key]:.{digits}f}" for row in self.rows]
        for name in observables:
            errors, orders = ([row[key].get(name) for row in self.rows] for key in ("error", "order_observed"))
            columns[f"L1 {name}"] = ["-" if error is None else f"{error:.2e}" for error in errors]
            columns[f"ord. {name}"] = ["-" if order is None else f"{order:.2f}" for order in orders]
        drifts = [max((abs(value) for value in row["mass_drift"].values()), default=None) for row in self.rows]
        if any(drift is not None for drift in drifts):
            columns["mass drift"] = ["-" if drift is None else f"{drift:.0e}" for drift in drifts]
        return columns | {"status": [row["status"] for row in self.rows]}

    def work_precision(self, observable: str | None = None, targets: Sequence[float] | None = None) -> WorkPrecision | None:
        """Return the run time that every series needs for given errors, interpolated in log-log.

        Parameters
        ----------
        observable : observable of the L1 error; default: the first one with an error above round-off.
        targets : errors; default: the powers of ten within the range of errors of the runs.

        Returns
        -------
        WorkPrecision
            Times to reach the errors; None if no run finished.
        """
        names = list(dict.fromkeys(name for row in self.rows for name in row["error"]))
        if not names:
            return None
        erring = [name for name in names if max(row["error"].get(name, 0.0) for row in self.rows) > ROUNDING]
        chosen = (erring or names)[0] if observable is None else validation.choice(observable, "observable", names)
        series = self.series()
        full = [label for label, rows in series.items() if rows[0]["model"] == self.full_model]
        return work_precision(series, chosen, full, targets)

    def columns(self) -> list[str]:
        """Return the names of the numeric columns of report.csv."""
        rows = [flat(row) for row in self.rows]
        return list(dict.fromkeys(key for row in rows for key, value in row.items() if isinstance(value, (int, float))))

    def figure(self, x: str = "seconds", y: str = "error.h") -> "Figure":
        """Return a figure of one column over another, one line per series.

        Parameters
        ----------
        x, y : columns of report.csv, such as ``"steps"``, ``"ns_per_cell_step"``, ``"error_l2.h"``, ``"mass_drift.hs"``.

        Raises
        ------
        ValueError
            For an unknown column; the message contains all columns and the nearest match.
        """
        from fvkit.studies.report_pictures import any_columns

        known = self.columns()
        names = [validation.choice(name, axis, known) for axis, name in (("x", x), ("y", y))]
        return any_columns(self, *names)

    def verdict(self) -> str:
        """Return the verdict as one line: the fastest solver of the full model at an error that all reach; errors of others."""
        full = {label: [row for row in rows if row["error"]] for label, rows in self.series().items()
                if rows[0]["model"] == self.full_model}
        full = {label: rows for label, rows in full.items() if rows}
        if not full:
            return "no run of the full model finished."
        name = next(iter(next(iter(full.values()))[0]["error"]))
        target = max(min(row["error"][name] for row in rows) for rows in full.values())
        if target < ROUNDING:
            return f"every finished solver of the full model keeps {name} to rounding ({target:.0e})."
        times = {label: seconds for label, rows in full.items()
                 if (seconds := time_to_reach(rows, name, target)) is not None}
        best = min(times, key=lambda label: times[label])
        slower = ", ".join(f"{label} x{times[label] / times[best]:.1f}" for label in sorted(times, key=lambda k: times[k])[1:])
        text = f"at L1({name}) = {target:.1e}, {best} is fastest: {1e3 * times[best]:.1f} ms"
        text += f" ({slower} the time)" if slower else ""
        floors = {label: min(row["error"][name] for row in rows if row["error"]) for label, rows in self.series().items()
                  if rows[0]["model"] != self.full_model and any(row["error"] for row in rows)}
        above = [f"{label} stays at {floor:.1e}" for label, floor in floors.items() if floor > 1.05 * target]
        reached = [f"{label} reaches it too" for label, floor in floors.items() if floor <= 1.05 * target]
        return "; ".join([text, *above, *reached]) + "."

    def plot(self) -> dict[str, "Figure"]:
        """Return the figures, {name: figure}: error versus time, error versus cells, profiles, and with two axes maps."""
        from fvkit.studies.report_pictures import pictures

        return {name: draw(self) for name, draw in pictures(2 if self.has_maps else 1).items()}

    def save(self, folder: str | Path, picture: str = "png") -> Path:
        """Write report.json, report.csv and the figures to ``folder``, created if missing, and return its path.

        Parameters
        ----------
        folder : of the files.
        picture : format of the figures: png, or of vectors pdf or svg.

        Raises
        ------
        ValueError
            For another format.
        """
        from fvkit.output.figures import FORMATS, save_all

        ending = validation.choice(picture, "picture", FORMATS)
        pictures = {f"{name}.{ending}": figure for name, figure in self.plot().items()}
        return save_all(folder, {"report.json": self.to_json(), "report.csv": self.to_csv(), **pictures})

    def _repr_html_(self) -> str:
        """Return the table as HTML for notebooks."""
        return preformatted(self.table())

    def to_json(self) -> str:
        """Return the report as JSON text; NaN and infinite numbers become null."""
        names = dict.fromkeys(name for row in self.rows for name in row["error"])
        reached = {name: found.as_dict() for name in names if (found := self.work_precision(name)) is not None}
        document = {"scene": self.scene, "reference": self.reference, "machine": self.machine, "versions": self.versions,
                    "rows": self.rows, "verdict": self.verdict(), "work_precision": reached, **self.remarks}
        return json.dumps(plain(document), indent=1, allow_nan=False)

    def to_csv(self) -> str:
        """Return the rows as CSV text, with columns such as ``error.h`` for nested values."""
        rows = [flat(row) for row in self.rows]
        columns = list(dict.fromkeys(key for row in rows for key in row))
        return csv_text(columns, ([row.get(name, "") for name in columns] for row in rows))


def observed_orders(before: Row | None, row: Row) -> dict[str, float | None]:
    """Return the observed order of each error between two rows of a series, {name: order, None if undefined}."""
    if before is None or row["cells"] == before["cells"]:
        return dict.fromkeys(row["error"])
    errors = np.array([[before["error"].get(name, 0.0), error] for name, error in row["error"].items()]).reshape(-1, 2).T
    orders = observed(errors, (before["cells"], row["cells"]))[0]
    return {name: None if np.isnan(order) else float(order) for name, order in zip(row["error"], orders, strict=True)}


#: Columns that a narrow table leaves out, the first ones first; orders are those of all observables but the first.
_DROPPED = ("ms min", "rej.", "mass drift", "orders", "ns/cell", "status", "steps")


def _narrow(columns: dict[str, list[str]]) -> list[str]:
    """Take columns out of a table until it is at most `WIDTH` wide, and return the names of those."""
    left_out = []
    for name in _DROPPED:
        if max(map(len, table(_lines(columns)).splitlines())) <= WIDTH:
            break
        keys = [key for key in columns if key.startswith("ord. ")][1:] if name == "orders" else [name]
        if name == "status" and set(columns[name]) != {"finished"}:
            continue
        if [columns.pop(key) for key in keys if key in columns]:
            left_out.append(name)
    return left_out


def _lines(columns: Mapping[str, list[str]]) -> list[list[str]]:
    heads = ["ord." if name.startswith("ord. ") else name for name in columns]
    return [heads, *map(list, zip(*columns.values(), strict=True))]
