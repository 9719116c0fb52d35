"""Maps of terrains: results over shaded relief, with contour lines, release, scale bar and north (`draw_map`)."""

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.colors import LightSource
from matplotlib.ticker import MaxNLocator
from mpl_toolkits.axes_grid1.anchored_artists import AnchoredSizeBar

from fvkit import Solution, validation
from fvkit.output.figures import new_axes
from fvkit.output.films import Film, write_film
from fvkit_granular.terrain.release import Release
from fvkit_granular.terrain.terrain import Terrain

#: Width of the figure of a map, of the map in it, least and largest height of the map, and space below and above it, inches.
WIDTH, MAP, LOWEST, HIGHEST, AROUND = 7.2, 5.7, 2.4, 10.0, 0.9

#: Height of the scale bar above a map, points.
ABOVE = 22.0

#: Direction of the light on maps: north-west, half-way up.
SUN = LightSource(azdeg=315.0, altdeg=45.0)

#: Most contour lines, and brightness of shadows and of the sunny side: 0 black, 1 white.
LINES, SHADOW, SUNNY = 14, 0.3, 0.95

#: Share of the width of a map that a scale bar has at most, and the lengths that it may have, times a power of ten.
BAR, LENGTHS = 0.25, (5.0, 2.0, 1.0)


def draw_map(terrain: Terrain, values: Any = None, label: str = "depth, m", *, release: Release | None = None, above: float = 0.0,
             highest: float | None = None, ax: Axes | None = None) -> Axes:
    """Draw a map of results, such as depths, over the shaded relief of a terrain (hillshade).

    Parameters
    ----------
    terrain : the terrain.
    values : (ny, nx) results on the terrain; None for the terrain alone.
    label : quantity and unit, beside the colour bar.
    release : whose outline is drawn; None for none.
    above : results up to this value are not drawn, nor is NaN.
    highest : value of the last colour; None for the largest one.
    ax : axes; None for a new figure.

    Returns
    -------
    matplotlib.axes.Axes
        ``ax.figure.savefig(path)`` writes the picture.

    Raises
    ------
    ValueError, TypeError
        If shapes differ, or an argument is of another kind.

    Examples
    --------
    >>> import numpy as np
    >>> import fvkit as fv, fvkit_granular as gr
    >>> x = np.linspace(0.0, 1.0, 40)
    >>> terrain = gr.Terrain(fv.Grid((0.0, 0.0), (400.0, 200.0), (40, 20)), 100.0 * x + np.zeros((20, 1)))
    >>> axes = gr.draw_map(terrain, np.exp(-30.0 * (x - 0.5) ** 2) + np.zeros((20, 1)), above=0.1)
    >>> axes.get_aspect()
    1.0
    """
    ground, named = validation.instance(terrain, "terrain", Terrain), validation.text(label, "label")
    least = validation.real(above, "above")
    last = None if highest is None else validation.real(highest, "highest", above=least)
    x, y = ground.grid.axes
    width, height = x.upper - x.lower, y.upper - y.lower
    tall = float(np.clip(MAP * height / width, LOWEST, HIGHEST)) + AROUND
    target = ax if ax is not None else new_axes(width=WIDTH, height=tall)[1][0]
    extent = (x.lower, x.upper, y.lower, y.upper)
    target.imshow(_shade(ground), cmap="gray", vmin=0.0, vmax=1.0, extent=extent, origin="lower", interpolation="none")
    _contours(target, ground)
    if values is not None:
        lay_over(target, ground, values, named, least, last)
    if release is not None:
        edge = validation.instance(release, "release", Release).thickness > 0.0
        target.contour(x.centers, y.centers, edge, levels=[0.5], colors="#D55E00", linewidths=1.6)
    _furnish(target, width)
    return target


def lay_over(target: Axes, terrain: Terrain, values: Any, label: str, above: float, highest: float | None = None) -> Any:
    """Draw results, see `draw_map`, over the relief of a terrain, and return their colour bar."""
    given = terrain.cells(values, "values")
    x, y = terrain.grid.axes
    seen = np.ma.masked_where(~(given > above) | terrain.missing, given)
    image = target.imshow(seen, cmap="viridis_r", vmin=above, vmax=highest, extent=(x.lower, x.upper, y.lower, y.upper),
                          origin="lower", interpolation="none", alpha=0.85)
    return target.figure.colorbar(image, ax=target, label=label, shrink=0.7,
                                  extend="max" if highest is not None and seen.max() > highest else "neither")


@contextmanager
def laid_over(target: Axes, terrain: Terrain, values: Any, label: str, above: float,
              highest: float | None = None) -> Iterator[None]:
    """Let results lie over the relief of a terrain, see `lay_over`, and take them away afterwards."""
    bar = lay_over(target, terrain, values, label, above, highest)
    yield
    bar.remove()
    bar.mappable.remove()


def film_map(solution: Solution, terrain: Terrain, path: str | Path, release: Release | None = None, above: float = 0.01,
             fps: int = 12) -> Film:
    """Write an animation of the depth over the shaded relief of a terrain, one frame per output; see `draw_map`.

    Parameters
    ----------
    solution : a run on the grid of the terrain.
    terrain, release, above : see `draw_map`; ``above`` in m.
    path : a .gif, or with ffmpeg an .mp4 file.
    fps : frames per second.

    Raises
    ------
    ValueError, TypeError
        If the grids differ, or an argument is of another kind.
    """
    if solution.grid != terrain.grid:
        raise ValueError(f"`solution` must be on the grid of the terrain, {terrain.grid}, got {solution.grid}")
    depths = [solution.observables(i)["h"] for i in range(len(solution.t))]
    relief, deepest = draw_map(terrain, release=release), max(float(h.max()) for h in depths)

    def frames() -> Iterator[None]:
        for t, h in zip(solution.t, depths, strict=True):
            relief.set_title(f"t = {t:.4g} s", fontsize=9, pad=ABOVE)
            with laid_over(relief, terrain, h, "depth, m", above, max(deepest, above)):
                yield

    return write_film(path, relief.figure.figure, frames(), fps)


def _shade(terrain: Terrain) -> np.ma.MaskedArray:
    """Return the brightness of the ground, (ny, nx), 0 to 1, masked where there is no data."""
    b_x, b_y = terrain.gradient
    normals = np.stack([-b_x, -b_y, np.ones_like(b_x)], axis=-1) / np.sqrt(1.0 + b_x**2 + b_y**2)[..., None]
    return np.ma.masked_where(terrain.missing, SHADOW + (SUNNY - SHADOW) * np.clip(normals @ SUN.direction, 0.0, 1.0))


def _contours(target: Axes, terrain: Terrain) -> None:
    low, high = terrain.range
    x, y = terrain.grid.axes
    if low < high and min(terrain.grid.shape) > 1:
        levels = MaxNLocator(LINES, steps=[1, 2, 2.5, 5, 10]).tick_values(low, high)
        ground = np.ma.masked_invalid(terrain.bottom)
        lines = target.contour(x.centers, y.centers, ground, levels=levels, colors="0.25", linewidths=0.4)
        target.clabel(lines, levels[::2], fontsize=6, fmt="%g")


def _furnish(target: Axes, width: float) -> None:
    """Add north arrow, and a scale bar above the map, where it hides nothing; number the axes in full metres."""
    power = 10.0 ** np.floor(np.log10(BAR * width))
    length = next(power * one for one in LENGTHS if power * one <= BAR * width)
    text = f"{length / 1000.0:g} km" if length >= 1000.0 else f"{length:g} m"
    target.add_artist(AnchoredSizeBar(target.transData, length, text, "lower left", pad=0.3, borderpad=0.0, sep=3, frameon=False,
                                      size_vertical=length / 40.0, bbox_to_anchor=(0.0, 1.0), bbox_transform=target.transAxes))
    target.annotate("N", (0.95, 0.97), (0.0, -28.0), "axes fraction", "offset points", ha="center", va="center", weight="bold",
                    arrowprops={"arrowstyle": "-|>", "lw": 1.4}, bbox={"boxstyle": "round,pad=0.15", "fc": "white", "ec": "none"})
    target.ticklabel_format(style="plain", useOffset=False)
    target.tick_params(labelsize=7)
    target.tick_params(axis="y", labelrotation=90)
    target.set_xlabel("x, m")
    target.set_ylabel("y, m")
