"""Figures of a report: error versus time, error versus cells, profiles, and any column over any other."""

from collections.abc import Callable
from typing import Any

import numpy as np
from matplotlib.figure import Figure
from matplotlib.ticker import LogLocator, NullFormatter, StrMethodFormatter

from fvkit.output.figures import COLORS, legend_below, new_axes, plot_series, slope_guides, style
from fvkit.studies.report_data import ReportData, flat
from fvkit.studies.tables import ROUNDING


def _observables(report: ReportData) -> list[str]:
    """Return the first two observables with errors above round-off, else the first one."""
    largest: dict[str, float] = {}
    for row in report.rows:
        for name, error in row["error"].items():
            largest[name] = max(error, largest.get(name, 0.0))
    return [name for name, error in largest.items() if error > ROUNDING][:2] or list(largest)[:1]


def _series(report: ReportData, name: str) -> dict[str, list[dict[str, float]]]:
    """Return cells, times and errors per series, {label: rows}; an asterisk marks models other than the full model."""
    result = {}
    for label, rows in report.series().items():
        mark = "" if rows[0]["model"] == report.full_model else "*"
        result[label + mark] = [{"cells": row["cells"], "milliseconds": 1e3 * row["seconds"], "error": row["error"][name]}
                                for row in rows if row["error"].get(name, 0.0) > 0.0]
    return result


def _note(report: ReportData) -> str:
    others = any(row["model"] != report.full_model for row in report.rows)
    return f"scene {report.scene}, reference {report.reference['kind']}" + ("; * includes the model error" if others else "")


def error_against_time(report: ReportData) -> Figure:
    """Return a figure of the error over wall time, with the number of cells beside the markers."""
    names = _observables(report)
    figure, axes = new_axes(1, max(1, len(names)))
    for ax, name in zip(axes, names, strict=False):
        plot_series(ax, _series(report, name), "milliseconds", "error", note="cells")
        ax.xaxis.set_major_locator(LogLocator(subs=(1.0, 2.0, 5.0)))
        ax.xaxis.set_major_formatter(StrMethodFormatter("{x:g}"))
        ax.xaxis.set_minor_formatter(NullFormatter())
        ax.set(xlabel="wall time of the stepping, ms", ylabel=f"L1 error of {name}", title=f"error of {name} against time")
    _finish(figure, axes, report)
    return figure


def error_against_cells(report: ReportData) -> Figure:
    """Return a figure of the error over the number of cells, with reference slopes of order 1, 2 and the nominal orders."""
    names = _observables(report)
    figure, axes = new_axes(1, max(1, len(names)))
    for ax, name in zip(axes, names, strict=False):
        series = _series(report, name)
        plot_series(ax, series, "cells", "error")
        cells = sorted({row["cells"] for rows in series.values() for row in rows})
        first = [row["error"] for rows in series.values() for row in rows if row["cells"] == cells[0]] if cells else []
        orders = sorted({1, 2} | {row["order"] for row in report.rows})
        slope_guides(ax, cells, 0.7 * min(first, default=0.0), orders)
        ax.set(xlabel="cells", ylabel=f"L1 error of {name}", title=f"error of {name} against cells")
        ax.set_xticks(cells, [f"{count:g}" for count in cells])
        ax.minorticks_off()
    _finish(figure, axes, report)
    return figure


def any_columns(report: ReportData, x: str, y: str) -> Figure:
    """Return a figure of column ``y`` over column ``x``, one line per series; axes with positive values are logarithmic."""
    figure, axes = new_axes()
    ax, values = axes[0], []
    for k, (label, nested) in enumerate(report.series().items()):
        rows = [flat(row) for row in nested]
        points = [(row[x], row[y]) for row in rows if row.get(x) is not None and row.get(y) is not None]
        values += points
        mark = "" if rows[0]["model"] == report.full_model else "*"
        ax.plot(*np.array(points).reshape(-1, 2).T, **style(k), markersize=5, linewidth=1.6, label=label + mark)
    for scale, column in ((ax.set_xscale, 0), (ax.set_yscale, 1)):
        if min((point[column] for point in values), default=0.0) > 0.0:
            scale("log")
    ax.set(xlabel=x, ylabel=y, title=f"{y} over {x}")
    ax.grid(which="major", alpha=0.35)
    _finish(figure, axes, report)
    return figure


def profiles(report: ReportData) -> Figure:
    """Return a figure of the final observables on the finest grids, with the reference and the bottom; with two axes along x
    through the middle."""
    lines = {label: profile._replace(observables={name: _middle(values) for name, values in profile.observables.items()}, y=None)
             for label, profile in report.profiles.items()}
    curves = {label: profile for label, profile in lines.items() if label != "reference"}
    names = list(dict.fromkeys(name for profile in lines.values() for name in profile.observables))
    if report.bottom is None:
        names = [name for name in names if name != "surface"]
    y = next((profile.y for profile in report.profiles.values() if profile.y is not None), None)
    figure, axes = new_axes((len(names) + 1) // 2 or 1, 2, height=3.0)
    for ax, name in zip(axes, names, strict=False):
        if name == "surface" and report.bottom is not None:
            x, b = report.bottom
            b = _middle(b)
            ax.fill_between(x, b, min(0.0, float(b.min())), color="0.85", zorder=0, label="bottom")
        reference = lines.get("reference")
        if reference is not None and name in reference.observables:
            ax.plot(reference.x, reference.observables[name], color="0.7", linewidth=4.0, label="reference", zorder=1)
        for k, (label, profile) in enumerate(curves.items()):
            if name in profile.observables:
                ax.plot(profile.x, profile.observables[name], color=COLORS[k % len(COLORS)], linewidth=1.2, label=label,
                        linestyle=("-", "--", "-.", ":")[k % 4])
        values = np.concatenate([profile.observables[name] for profile in lines.values() if name in profile.observables])
        if np.ptp(values) < 1e-9:
            ax.set_ylim(values.mean() - 0.5, values.mean() + 0.5)
        ax.set(xlabel="x" if y is None else f"x, at y = {_middle(y[:, None])[0]:.4g}", ylabel=name)
        ax.grid(alpha=0.3)
    for ax in axes[len(names):]:
        ax.set_visible(False)
    _finish(figure, axes, report)
    return figure


def _middle(values: np.ndarray) -> np.ndarray:
    """Values over x: of a map those of its middle row."""
    return values if values.ndim == 1 else values[len(values) // 2]


def maps(report: ReportData) -> Figure:
    """Return a figure of a scene with two axes: a map of the first observable of the reference, and what each series has more or
    less on its finest grid, all to one scale."""
    reference: Any = report.profiles["reference"]  # with y
    name = next(iter(reference.observables))
    wanted = reference.observables[name]
    apart = {label: profile.observables[name] - wanted for label, profile in report.profiles.items()
             if label != "reference" and profile.observables[name].shape == wanted.shape}
    largest = max((float(np.abs(values).max()) for values in apart.values()), default=0.0) or 1.0
    count = 1 + len(apart)
    ratio = float((reference.y[-1] - reference.y[0]) / max(reference.x[-1] - reference.x[0], 1e-300))
    figure, axes = new_axes(-(-count // 2), min(count, 2), height=min(max(1.2 + 4.6 * ratio, 2.2), 5.6))
    mesh = axes[0].pcolormesh(reference.x, reference.y, wanted, cmap="viridis", rasterized=True, shading="nearest")
    figure.colorbar(mesh, ax=axes[0], label=name)
    axes[0].set_title(f"reference: {name}", fontsize="medium")
    for ax, (label, values) in zip(axes[1:], apart.items(), strict=False):
        mesh = ax.pcolormesh(reference.x, reference.y, values, cmap="RdBu_r", vmin=-largest, vmax=largest, rasterized=True,
                             shading="nearest")
        figure.colorbar(mesh, ax=ax, label=f"{name} - reference")
        ax.set_title(label, fontsize="medium")
    for ax in axes[:count]:
        ax.set(xlabel="x", ylabel="y", aspect="equal")
    for ax in axes[count:]:
        ax.set_visible(False)
    figure.suptitle(_note(report), fontsize="medium")
    return figure


def _finish(figure: Figure, axes: list, report: ReportData) -> None:
    figure.suptitle(_note(report), fontsize="medium")
    legend_below(figure, axes, 3, "small")


#: {file name without extension: function of the report}; `pictures` adds what a scene with two axes has.
PICTURES: dict[str, Callable[[ReportData], Figure]] = {
    "error_time": error_against_time, "error_cells": error_against_cells, "profiles": profiles,
}


def pictures(axes: int) -> dict[str, Callable[[ReportData], Figure]]:
    """Return the pictures of a report of a scene with so many axes, {file name without extension: function of the report}."""
    return PICTURES | ({"maps": maps} if axes > 1 else {})
