"""Plotting helpers: figures, colour-blind-safe styles, log-log series and convergence slopes on given axes."""

from collections.abc import Iterable, Mapping, Sequence
from functools import partial
from io import BytesIO
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from fvkit.files import write_whole

#: Okabe-Ito colour-blind-safe palette, darkest first.
COLORS = ("#0072B2", "#D55E00", "#009E73", "#CC79A7", "#E69F00", "#56B4E9", "#000000")
MARKERS = ("o", "s", "^", "D", "v", "P", "X")

#: Formats of pictures in files: pixels, and two of vectors.
FORMATS = ("png", "pdf", "svg")


class Picture(Figure):
    """A matplotlib figure outside pyplot: needs no display, and notebooks show it."""

    def _repr_png_(self) -> bytes:
        buffer = BytesIO()
        self.savefig(buffer, format="png")
        return buffer.getvalue()


class PictureAxes(Axes):
    """Axes of a `Picture`: what draws one returns them, and notebooks show the picture that they are part of."""

    def _repr_png_(self) -> bytes | None:
        return self.figure._repr_png_() if isinstance(self.figure, Picture) else None


def new_axes(rows: int = 1, columns: int = 1, width: float = 6.4, height: float = 4.2) -> tuple[Figure, list[Axes]]:
    """Return a `Picture` and the list of its rows x columns axes."""
    figure = Picture(figsize=(width * columns, height * rows), layout="constrained")
    axes = figure.subplots(rows, columns, squeeze=False, subplot_kw={"axes_class": PictureAxes})
    return figure, list(axes.ravel())


def save_all(folder: str | Path, contents: Mapping[str, str | Figure]) -> Path:
    """Write texts and figures, {name of the file: content}, each whole, into a folder, made if missing; return its path.

    The ending of its name is the format of a figure, one of `FORMATS`.
    """
    target = Path(folder)
    target.mkdir(parents=True, exist_ok=True)
    for name, content in contents.items():
        drawn = partial(content.savefig, format=Path(name).suffix[1:], dpi=130) if isinstance(content, Figure) else content
        write_whole(target / name, drawn)
    return target


def legend_below(figure: Figure, axes: Iterable[Axes], columns: int, size: str) -> None:
    """Draw one legend below all axes, each label once."""
    handles = {label: handle for ax in axes for handle, label in zip(*ax.get_legend_handles_labels(), strict=True)}
    if handles:
        figure.legend(handles.values(), handles.keys(), loc="outside lower center", ncols=columns, fontsize=size, frameon=False)


def style(index: int) -> dict[str, Any]:
    """Return colour, marker and line style of curve number ``index`` as keyword arguments of matplotlib."""
    return {"color": COLORS[index % len(COLORS)], "marker": MARKERS[index % len(MARKERS)],
            "linestyle": ("-", "--", ":", "-.")[index // len(COLORS) % 4]}


def plot_series(ax: Axes, series: Mapping[str, Sequence[Mapping[str, float]]], x: str, y: str, note: str | None = None) -> None:
    """Draw one log-log line per series: column ``y`` over column ``x``, markers annotated with column ``note``."""
    for k, (label, rows) in enumerate(series.items()):
        points = [(row[x], row[y], row.get(note) if note else None) for row in rows if row[x] > 0.0 and row[y] > 0.0]
        if not points:
            continue
        ax.loglog([p[0] for p in points], [p[1] for p in points], **style(k), markersize=5, linewidth=1.6, label=label)
        for px, py, text in points:
            if text is not None:
                ax.annotate(f"{text:g}", (px, py), textcoords="offset points", xytext=(4, 4), fontsize=6.5,
                            color=style(k)["color"])
    ax.grid(which="major", alpha=0.35)
    ax.grid(which="minor", alpha=0.12)


def slope_guides(ax: Axes, cells: Sequence[float], start: float, orders: Iterable[int] = (1, 2)) -> None:
    """Draw dashed reference slopes of the given orders of accuracy, from the error ``start`` on the coarsest grid."""
    if len(cells) < 2 or not start > 0.0:
        return
    ends = np.array([min(cells), max(cells)], dtype=float)
    for order in orders:
        values = start * (ends / ends[0]) ** -order
        ax.loglog(ends, values, color="0.45", linestyle="--", linewidth=0.9, zorder=0)
        ax.annotate(f"order {order}", (ends[1], values[1]), textcoords="offset points", xytext=(-4, -9), ha="right",
                    fontsize=7, color="0.35")
