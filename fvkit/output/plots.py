"""Plots of one solution: state, profile, space-time diagram, speeds, hyperbolicity margin; with two axes maps, vectors and cuts;
and animations."""

from collections.abc import Callable, Mapping
from math import ceil, hypot
from typing import Any

import numpy as np
from matplotlib.axes import Axes

from fvkit import validation
from fvkit.output.figures import COLORS, new_axes
from fvkit.output.results import Results
from fvkit.problem.answers import wave_speeds
from fvkit.problem.directions import quantities, speed_name, vectors
from fvkit.problem.grid import NAMES, Grid
from fvkit.problem.model import aux_rows

#: Fill colours of the layers above the bottom, lowest first.
SHADES = ("#C9A66B", "#8FC1E3", "#B9B9D9")

#: Arrows along the longer side of a map, and how many of their spacings the longest is long.
ARROWS, LONGEST = 25, 1.6

#: Height of the figure of a map, inches: of title and axes around the map, and the least and the largest.
AROUND, LOWEST, HIGHEST = 0.9, 2.4, 9.0

#: Distance of the key of the arrows above a map, pixels.
ABOVE = 12.0

#: A relief of more than so many largest depths hides the flow: depths are enlarged to about this share of it.
HIDES, SHARE = 20.0, 0.15

#: Share of such a relief that is drawn of the ground below it, however high it lies.
UNDER = 0.05

#: Share of a cell that a line may be longer than a whole number of them by rounding.
ROUNDING = 1e-9


def plot_state(solution: Results, ax: Axes | None = None, i: int = -1) -> Axes:
    """Plot every observable of a solution at output ``i`` over x, and the bottom if it is not zero; but neither bottom nor
    surface where the relief would hide all else, see `enlargement`."""
    target = ax if ax is not None else new_axes()[1][0]
    x, hidden = solution.grid.centers, enlargement(solution) > 1.0
    for k, (name, values) in enumerate(solution.observables(i).items()):
        if not (hidden and name == "surface"):
            target.plot(x, values, color=COLORS[k % len(COLORS)], label=name)
    bottom = None if hidden else solution.aux.get("b")
    if bottom is not None and np.any(bottom != 0.0):
        target.fill_between(x, bottom, min(0.0, float(bottom.min())), color="0.8", label="bottom", zorder=0)
    return _finish(target, solution, i, "")


def profile(solution: Results, ax: Axes | None = None, i: int = -1, enlarge: float | None = None) -> Axes:
    """Plot the layers above the bottom at output ``i``, one colour per entry of the model's ``thicknesses``.

    ``enlarge`` is a factor of the depths above the bottom, 1 for true ones; None for that of `enlargement`.
    """
    target, parts = ax if ax is not None else new_axes()[1][0], _thicknesses(solution, i, "profile")
    factor = enlargement(solution) if enlarge is None else validation.real(enlarge, "enlarge", above=0.0)
    _layers(target, solution.grid.centers, solution.aux.get("b", np.zeros(solution.grid.shape)), parts, factor)
    return _finish(target, solution, i, _height(factor))


def depth(solution: Results, ax: Axes | None = None, i: int = -1) -> Axes:
    """Plot the depth at output ``i`` over x, without the bottom: the layers of the model's ``thicknesses``, from 0."""
    target = ax if ax is not None else new_axes()[1][0]
    _layers(target, solution.grid.centers, np.zeros(solution.grid.shape), _thicknesses(solution, i, "depth"))
    return _finish(target, solution, i, "depth, m")


def _thicknesses(solution: Results, i: int, kind: str) -> Mapping[str, np.ndarray]:
    """Return the layers of a model at output ``i``; ValueError where it has none."""
    parts = solution.model.thicknesses(solution.observables(i))
    if not parts:
        raise ValueError(f"{type(solution.model).__name__} defines no `thicknesses`, so it has no {kind}: take kind='state'")
    return parts


def enlargement(solution: Results, cells: Any = ...) -> float:
    """Return the factor by which pictures enlarge depths above the relief of some cells, by their numbers, or all: 1 where it
    is at most 20 largest depths of all outputs high, else 1, 2 or 5 times a power of ten so that the flow can be seen.
    """
    bottom = solution.aux.get("b")
    if bottom is None:
        return 1.0
    layers = [list(solution.model.thicknesses(solution.observables(i)).values()) for i in range(len(solution.t))]
    deepest = max(float(np.max(np.sum(parts, axis=0).reshape(-1)[cells])) if parts else 0.0 for parts in layers)
    relief = float(np.ptp(bottom.reshape(-1)[cells]))
    if not deepest > 0.0 or relief <= HIDES * deepest:
        return 1.0
    wanted = SHARE * relief / deepest
    power = 10.0 ** np.floor(np.log10(wanted))
    return float(max(step * power for step in (1.0, 2.0, 5.0) if step * power <= wanted))


def _height(factor: float) -> str:
    """Label of heights with depths that are enlarged."""
    return "height, m" if factor == 1.0 else f"height, m; depth {factor:g} times enlarged"


def _layers(target: Axes, x: np.ndarray, below: np.ndarray, parts: Mapping[str, np.ndarray], factor: float = 1.0) -> None:
    """Draw layers, {name: thickness (n,)}, times a factor, above the bottom (n,), from below."""
    if np.any(below != 0.0):
        floor = min(0.0, float(below.min())) if factor == 1.0 else float(below.min() - UNDER * np.ptp(below))
        target.fill_between(x, below, floor, color="0.75", label="bottom", linewidth=0.0)
    for k, (name, thickness) in enumerate(parts.items()):
        target.fill_between(x, below, below + factor * thickness, color=SHADES[k % len(SHADES)], label=name, linewidth=0.0)
        below = below + factor * thickness
    target.plot(x, below, color=COLORS[0], linewidth=1.2)


def _label(solution: Results, name: str) -> str:
    """Return the axis label of an observable: its name, with its unit if ``Model.quantities`` contains one."""
    unit, _ = quantities(solution.model, solution.grid).get(name, ("", ""))
    return f"{name}, {unit}" if unit not in ("", "1") else name


def _chosen(solution: Results, name: str | None) -> str:
    """Return the name of an observable, the first by default, checked."""
    known = list(solution.observables(0))
    return known[0] if name is None else validation.choice(name, "name", known)


def space_time(solution: Results, ax: Axes | None = None, name: str | None = None) -> Axes:
    """Plot a space-time diagram of an observable, the first by default: colours over x and the output times."""
    target, chosen = ax if ax is not None else new_axes()[1][0], _chosen(solution, name)
    if len(solution.grid.axes) > 1:
        raise ValueError("a space-time diagram needs a grid with one axis, got one with two: take kind='map', or `animate`")
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


def plot_map(solution: Results, ax: Axes | None = None, i: int = -1, name: str | None = None) -> Axes:
    """Plot a map of an observable at output ``i``, the first by default, with contours of the bottom; both axes to one scale."""
    chosen, (x, y) = _chosen(solution, name), solution.grid.axes
    height = min(max(AROUND + 5.0 * (y.upper - y.lower) / (x.upper - x.lower), LOWEST), HIGHEST)
    target = ax if ax is not None else new_axes(height=height)[1][0]
    mesh = target.pcolormesh(x.edges, y.edges, solution.observables(i)[chosen], cmap="viridis", rasterized=True)
    if target.figure is not None:
        target.figure.colorbar(mesh, ax=target, label=_label(solution, chosen))
    bottom = solution.aux.get("b")
    if bottom is not None and min(bottom.shape) > 1 and np.ptp(bottom) > 0.0:
        target.contour(x.centers, y.centers, bottom, levels=8, colors="white", linewidths=0.7, alpha=0.8)
    target.set(xlabel="x, m", ylabel="y, m", title=_title(solution, i), aspect="equal")
    return target


def plot_vectors(solution: Results, ax: Axes | None = None, i: int = -1, name: str | None = None,
                 vector: str | None = None) -> Axes:
    """Plot a map with arrows of a vector at some of the cells, the first of the model by default, such as the velocity v.

    Arrows have one scale at all outputs. Cells without a velocity have none.
    """
    known = vectors(solution.model)
    if not known:
        raise ValueError(f"{type(solution.model).__name__} has no observable that is a vector: take kind='map'")
    chosen = known[0] if vector is None else validation.choice(vector, "vector", known)
    x, y = solution.grid.axes
    spacing = max(x.upper - x.lower, y.upper - y.lower) / ARROWS
    columns, rows = (slice(step // 2, None, step) for step in (max(1, round(spacing / axis.dx)) for axis in (x, y)))
    sizes = np.array([solution.observables(k)[speed_name(chosen)] for k in range(len(solution.t))])
    largest = float(sizes[np.isfinite(sizes)].max(initial=0.0)) or 1.0
    target, seen = plot_map(solution, ax, i, name), solution.observables(i)
    along, across = (np.where(sizes[i] > 0.0, seen[f"{chosen}_{axis}"], np.nan)[rows, columns] for axis in NAMES)
    arrows = target.quiver(x.centers[columns], y.centers[rows], along, across, color="white", edgecolor="black", linewidth=0.4,
                           units="xy", width=0.12 * spacing, angles="xy", scale_units="xy", scale=largest / (LONGEST * spacing))
    shown, unit = float(f"{largest:.1g}"), quantities(solution.model, solution.grid)[speed_name(chosen)][0]
    target.quiverkey(arrows, 0.5, 1.0 + ABOVE / target.bbox.height, shown, f"{chosen} = {shown:g} {unit}", labelpos="E",
                     fontproperties={"size": "small"})
    target.set_title(f"{_title(solution, i)}\n")  # the key of the arrows is in its second line
    return target


def plot_cut(solution: Results, ax: Axes | None = None, i: int = -1, name: str | None = None, line: Any = None,
             enlarge: float | None = None) -> Axes:
    """Plot what lies along a line at output ``i``: the layers above the bottom, or an observable (None: the first one of a
    model without ``thicknesses``), averages of the cells that the line meets.

    ``line`` has its ends ((x0, y0), (x1, y1)), m, within the grid; None is the middle of the grid, along x. ``enlarge`` as for
    `profile`.
    """
    target = ax if ax is not None else new_axes()[1][0]
    (start, end), shares, cells = _along(solution.grid, line)
    along = hypot(*(end - start)) * shares
    seen = {key: values.reshape(-1)[cells] for key, values in solution.observables(i).items()}
    parts, factor = solution.model.thicknesses(seen) if name is None else {}, 1.0
    if parts:
        bottom = solution.aux.get("b")
        factor = enlargement(solution, cells) if enlarge is None else validation.real(enlarge, "enlarge", above=0.0)
        _layers(target, along, np.zeros(len(cells)) if bottom is None else bottom.reshape(-1)[cells], parts, factor)
    else:
        target.plot(along, seen[_chosen(solution, name)], color=COLORS[0], label=_chosen(solution, name))
    return _finish(target, solution, i, _height(factor) if parts else _label(solution, _chosen(solution, name)),
                   f"distance from ({start[0]:g}, {start[1]:g}) towards ({end[0]:g}, {end[1]:g}), m")


def _along(grid: Grid, line: Any) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return the ends of a line, shares of its length at even distances, about a cell apart, and the cells there."""
    start, end = cut_line(grid, line, "line")
    count = max(1, ceil(np.max(np.abs(end - start) / [axis.dx for axis in grid.axes]) - ROUNDING))
    shares = (np.arange(count) + 0.5) / count
    return np.array([start, end]), shares, grid.cells_at(start + shares[:, None] * (end - start), "`line`")


def enlarged(solution: Results, kind: str | None, line: Any = None, **options: Any) -> dict[str, float]:
    """Return the options that all frames of a film share: the factor of depths over a relief, where a kind has one."""
    if drawing(solution, kind) is profile:
        return {"enlarge": enlargement(solution)}
    if drawing(solution, kind) is plot_cut and options.get("name") is None:
        return {"enlarge": enlargement(solution, _along(solution.grid, line)[2])}
    return {}


def cut_line(grid: Grid, line: Any, name: str) -> np.ndarray:
    """Return both ends of a line within a grid with two axes, (2, 2), checked; those of its middle along x for None."""
    x, y = grid.axes
    middle = 0.5 * (y.lower + y.upper)
    ends = validation.array(((x.lower, middle), (x.upper, middle)) if line is None else line, name, (2, 2))
    if not (ends[0] != ends[1]).any():
        raise ValueError(f"`{name}` must have two ends that differ, ((x0, y0), (x1, y1)), got {validation.shown(line)}")
    grid.cells_at(ends, f"`{name}`")
    return ends


def _title(solution: Results, i: int) -> str:
    return f"{type(solution.model).__name__}, t = {solution.t[i]:.4g}"


def _finish(target: Axes, solution: Results, i: int, label: str, along: str = "x, m") -> Axes:
    target.set(xlabel=along, ylabel=label, title=_title(solution, i))
    target.grid(alpha=0.3)
    target.legend(fontsize="small")
    return target


#: Plot functions of `Solution.plot`, by kind: those of a grid with one axis, and with two.
KINDS: dict[str, Callable[..., Axes]] = {"state": plot_state, "profile": profile, "depth": depth, "speeds": speeds,
                                         "margin": margin}
MAPS: dict[str, Callable[..., Axes]] = {"map": plot_map, "vectors": plot_vectors, "cut": plot_cut}


def drawing(solution: Results, kind: str | None) -> Callable[..., Axes]:
    """Return the plot function of a kind; None for the first that serves the grid, ValueError for one that does not."""
    known = KINDS if len(solution.grid.axes) == 1 else MAPS
    return known[next(iter(known)) if kind is None else validation.choice(kind, "kind", known)]
