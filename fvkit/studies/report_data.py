"""Data of a report: settings, errors and times of the runs, grouped into series."""

from collections.abc import Mapping
from typing import Any, NamedTuple

import attrs
import numpy as np

from fvkit.studies.work_precision import Row


class FinalProfile(NamedTuple):
    """Observables over x at the end of a run, (n,); with two axes over x and y, (ny, nx)."""

    x: np.ndarray
    observables: dict[str, np.ndarray]
    y: np.ndarray | None = None


@attrs.frozen(eq=False)
class ReportData:
    """Data of a `fvkit.studies.Report`, which adds tables, figures and files; its documentation has the fields."""

    scene: str
    reference: dict[str, str] = attrs.field(repr=lambda given: given["kind"])
    rows: list[Row] = attrs.field(repr=lambda rows: f"<{len(rows)} runs>")
    machine: dict[str, Any] = attrs.field(repr=False)
    versions: dict[str, str] = attrs.field(repr=False)
    full_model: str
    profiles: dict[str, FinalProfile] = attrs.field(factory=dict, repr=False)
    bottom: tuple[np.ndarray, np.ndarray] | None = attrs.field(default=None, repr=False)
    remarks: Mapping[str, Mapping[str, Any] | None] = attrs.field(factory=dict, repr=False)

    @property
    def has_maps(self) -> bool:
        """Whether the scene has two axes."""
        return any(profile.y is not None for profile in self.profiles.values())

    def series(self) -> dict[str, list[Row]]:
        """Return the series of rows that differ only in the number of cells, {label: rows}; labels contain varying settings."""
        result: dict[str, list[Row]] = {}
        for row in self.rows:
            words = [row["model"], row["riemann"], row["limiter"] if self._varies("limiter") else ""]
            words += [f"order {row['order']}"] if self._varies("order", row) and row["integrator"] is None else []
            words += [row["integrator"] or ""] if self._varies("integrator", row) else []
            result.setdefault(" ".join(filter(None, [*words, row["options"] if self._varies("options") else ""])), []).append(row)
        return result

    def _varies(self, key: str, like: Row | None = None) -> bool:
        """Whether rows differ in a column; with ``like`` only among rows of the same scheme."""
        return len({row[key] for row in self.rows if like is None or row["scheme"] == like["scheme"]}) > 1


def flat(row: Mapping[str, Any]) -> dict[str, Any]:
    """Return a row as in report.csv, with columns such as ``error.h`` for nested values."""
    result: dict[str, Any] = {}
    for key, value in row.items():
        result |= {f"{key}.{name}": item for name, item in value.items()} if isinstance(value, Mapping) else {key: value}
    return result
