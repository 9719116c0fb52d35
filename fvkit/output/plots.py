"""Plots of one solution: state, profile, space-time diagram, speeds, hyperbolicity margin; and animations."""

import os
import tempfile
from collections.abc import Callable
from pathlib import Path

import numpy as np
from matplotlib.axes import Axes

from fvkit import validation
from fvkit.output.figures import COLORS, new_axes
from fvkit.output.status import Results
from fvkit.problem.answers import wave_speeds
from fvkit.problem.model import aux_rows

#: Fill colours of the layers above the bottom, lowest first.
SHADES = ("#C9A66B", "#8FC1E3", "#B9B9D9")


def plot_state(solution: Results, ax: Axes | None = None, i: int = -1) -> Axes:
    """Plot every observable of a solution at output ``i`` over x, and the bottom if it is not zero."""
    target = ax if ax is not None else new_axes()[1][0]
    x = solution.grid.centers
    for k, (name, values) in enumerate(solution.observables(i).items()):
        target.plot(x, values, color=COLORS[k % len(COLORS)], label=name)
    bottom = solution.aux.get("b")
    if bottom is not None and np.any(bottom != 0.0):
        target.fill_between(x, bottom, min(0.0, float(bottom.min())), color="0.8", label="bottom", zorder=0)
    target.set(xlabel="x, m", title=f"{type(solution.model).__name__}, t = {solution.t[i]:.4g}")
    target.grid(alpha=0.3)
    target.legend(fontsize="small")
    return target


def profile(solution: Results, ax: Axes | None = None, i: int = -1) -> Axes:
    """Plot the layers above the bottom at output ``i``, one colour per entry of the model's ``thicknesses``.

    Raises
    ------
    ValueError
        If the model defines no ``thicknesses``; use kind="state" then.
    """
    target = ax if ax is not None else new_axes()[1][0]
    x, below = solution.grid.centers, solution.aux.get("b", np.zeros(solution.grid.num_cells))
    parts = solution.model.thicknesses(solution.observables(i))
    if not parts:
        raise ValueError(f"{type(solution.model).__name__} defines no `thicknesses`, so it has no profile: take kind='state'")
    if np.any(below != 0.0):
        target.fill_between(x, below, min(0.0, float(below.min())), color="0.75", label="bottom", linewidth=0.0)
    for k, (name, thickness) in enumerate(parts.items()):
        target.fill_between(x, below, below + thickness, color=SHADES[k % len(SHADES)], label=name, linewidth=0.0)
        below = below + thickness
    target.plot(x, below, color=COLORS[0], linewidth=1.2)
    return _finish(target, solution, i, "height, m")


def _label(solution: Results, name: str) -> str:
    """Return the axis label of an observable: its name, with its unit if ``Model.quantities`` contains one."""
    unit, _ = solution.model.quantities.get(name, ("", ""))
    return f"{name}, {unit}" if unit not in ("", "1") else name


def space_time(solution: Results, ax: Axes | None = None, name: str | None = None) -> Axes:
    """Plot a space-time diagram of an observable, the first by default: colours over x and the output times."""
    target = ax if ax is not None else new_axes()[1][0]
    known = list(solution.observables(0))
    chosen = known[0] if name is None else validation.choice(name, "name", known)
    if len(solution.t) < 3:
        raise ValueError("a space-time diagram needs more than the start and the end: give `times` to fv.solve")
    values = np.array([solution.observables(i)[chosen] for i in range(len(solution.t))])
    mesh = target.pcolormesh(solution.grid.centers, solution.t, values, cmap="viridis", shading="nearest", rasterized=True)
    if target.figure is not None:
        target.figure.colorbar(mesh, ax=target, label=_label(solution, chosen))
    target.set(xlabel="x, m", ylabel="t, s", title=f"{type(solution.model).__name__}, {chosen}")
    return target


def speeds(solution: Results, ax: Axes | None = None, i: int = -1) -> Axes:
    """Plot the characteristic speeds at output ``i``: all of them if the model defines ``eigenvalues``, else their bounds.

    Dotted lines show the real part of complex speeds.
    """
    target = ax if ax is not None else new_axes()[1][0]
    x, q = solution.grid.centers, solution.q[i]
    rows = solution.model.mass_rows()
    present = (q[list(rows)] > 0.0).all(axis=0) if rows else np.ones(q.shape[1], dtype=bool)
    values = np.full((2, q.shape[1]), np.nan, dtype=complex)
    if hasattr(solution.model, "eigenvalues"):
        values = np.full((q.shape[0], q.shape[1]), np.nan, dtype=complex)
        values[:, present] = solution.model.eigenvalues(q[:, present])
    else:
        bounds = wave_speeds(solution.model, tuple(q), aux_rows(solution.model, solution.aux))
        values[:] = [np.broadcast_to(bound, q.shape[1]) for bound in bounds]
    lost = np.abs(values.imag) > 0.0
    for k, row in enumerate(values):
        target.plot(x, np.where(lost[k], np.nan, row.real), color=COLORS[k % len(COLORS)], label=f"speed {k + 1}")
        target.plot(x, np.where(lost[k], row.real, np.nan), ":", color=COLORS[k % len(COLORS)])
    return _finish(target, solution, i, "characteristic speed")


def margin(solution: Results, ax: Axes | None = None, i: int = -1) -> Axes:
    """Plot the hyperbolicity margin at output ``i``; cells with complex speeds are shaded."""
    target = ax if ax is not None else new_axes()[1][0]
    values = solution.hyperbolicity_margin(i)
    target.plot(solution.grid.centers, np.where(np.isfinite(values), values, np.nan), color=COLORS[0], label="margin")
    target.axhline(0.0, color="0.4", linewidth=0.8)
    target.fill_between(solution.grid.centers, 0.0, 1.0, where=values < 0.0, transform=target.get_xaxis_transform(),
                        color=COLORS[1], alpha=0.25, linewidth=0.0, label="complex speeds")
    return _finish(target, solution, i, "hyperbolicity margin")


def _finish(target: Axes, solution: Results, i: int, label: str) -> Axes:
    target.set(xlabel="x, m", ylabel=label, title=f"{type(solution.model).__name__}, t = {solution.t[i]:.4g}")
    target.grid(alpha=0.3)
    target.legend(fontsize="small")
    return target


#: Plot functions of `Solution.plot`, by kind.
KINDS: dict[str, Callable[[Results, Axes | None, int], Axes]] = {
    "state": plot_state, "profile": profile, "speeds": speeds, "margin": margin}


def animate(solution: Results, path: str | Path, kind: str = "state", fps: int = 12, ax: Axes | None = None) -> Path:
    """Write an animation with one frame per output to a ``.gif`` file, or to ``.mp4`` if ffmpeg is installed.

    Raises
    ------
    ValueError
        For another file extension, or for .mp4 without ffmpeg.
    """
    from matplotlib.animation import AbstractMovieWriter, FFMpegWriter, PillowWriter

    draw = KINDS[validation.choice(kind, "kind", KINDS)]
    rate, target = validation.whole(fps, "fps", at_least=1), checked_film(path)
    axes = ax if ax is not None else new_axes()[1][0]
    figure = None if axes.figure is None else axes.figure.figure  # the top-level figure, also for axes in a subfigure
    if figure is None:
        raise ValueError("`ax` must be in a figure")
    limits = _limits(solution, draw)
    writer: AbstractMovieWriter = FFMpegWriter(fps=rate) if target.suffix == ".mp4" else PillowWriter(fps=rate)
    with tempfile.TemporaryDirectory(dir=target.parent) as folder:
        whole = Path(folder) / target.name
        with writer.saving(figure, str(whole), dpi=100):
            for i in range(len(solution.t)):
                axes.clear()
                draw(solution, axes, i)
                axes.set_ylim(*limits)
                writer.grab_frame()
        os.replace(whole, target)
    return target


def checked_film(path: str | Path) -> Path:
    """Return the path of an animation, or raise ValueError if its format cannot be written."""
    from matplotlib.animation import FFMpegWriter

    target = Path(path)
    if target.suffix not in (".gif", ".mp4"):
        raise ValueError(f"a film must end in .gif or .mp4, got {validation.shown(target.name)}")
    if target.suffix == ".mp4" and not FFMpegWriter.isAvailable():
        raise ValueError("an .mp4 needs the program ffmpeg, which is not installed: install it, or write a .gif")
    return target


def _limits(solution: Results, draw: Callable[[Results, Axes | None, int], Axes]) -> tuple[float, float]:
    """Return limits of the y axis that contain every frame, (low, high)."""
    seen = [draw(solution, None, i).get_ylim() for i in range(len(solution.t))]
    return min(low for low, _ in seen), max(high for _, high in seen)
