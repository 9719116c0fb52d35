"""What a run on a terrain leaves in its folder: rasters, maps, series of gauges and lines, and a report of one page."""

import base64
import html
import io
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from fvkit import Solution
from fvkit.files import write_whole
from fvkit_granular.observers.hazard import HazardMaps
from fvkit_granular.observers.run_out import RunOut
from fvkit_granular.scenes.scene import Scene
from fvkit_granular.studies.mass_balance import EDGES, MassBalance
from fvkit_granular.studies.series import is_series, series_names, write_series
from fvkit_granular.terrain.layers import LAYERS, Layer, write_style
from fvkit_granular.terrain.outline import compare_outline
from fvkit_granular.terrain.rasters import write_raster
from fvkit_granular.terrain.terrain import Terrain

#: Speed from which on a flow still moves, m/s; share of all that is worth a word where it left through a side.
MOVES, LEFT = 0.1, 1e-3

#: Head of the report.
STYLE = ("body{font-family:sans-serif;max-width:60em;margin:2em auto;padding:0 1em}"
         "pre{background:#f4f4f4;padding:1em;overflow:auto}img{max-width:100%}")


def file_names(scene: Scene, ending: str, picture: str = "png") -> list[str]:
    """Return the names of all files that `write_hazard` writes, but those of ``.prj``."""
    series = series_names(scene)
    if scene.terrain is None:
        return series
    rasters = [f"{layer.name}{suffix}" for suffix in (ending, ".qml") for layer in LAYERS]
    return [*rasters, *(f"{layer.name}.{picture}" for layer in LAYERS if layer.least is not None), *series, "report.html"]


def is_record(name: str) -> bool:
    """Whether a name is one of those that `write_hazard` gives to its rasters, series and report."""
    stem, ending = Path(name).stem, Path(name).suffix
    if name != Path(name).name:
        return False
    raster = ending in (".asc", ".tif", ".qml") and stem in (layer.name for layer in LAYERS)
    return raster or name == "report.html" or is_series(name)


def write_hazard(folder: Path, scene: Scene, solution: Solution, watched: Mapping[str, Any], balance: MassBalance,
                 ending: str = ".asc", picture: str = "png") -> str:
    """Write rasters, maps, series and the report of a run on a terrain into an existing folder; return what is to be printed.

    The observers ``watched`` are those of `fvkit_granular.scenes.watch.Watch.observers`, the ``ending`` of rasters ``.asc`` or
    ``.tif``; ``picture`` is the format of the maps, which the report holds as PNG.
    """
    from fvkit_granular.terrain.maps import draw_map

    hazard: HazardMaps = watched["hazard"]
    maps, terrain = hazard.maps, scene.terrain
    pictures, relief = {}, draw_map(terrain, release=scene.release)  # drawn once for all maps
    for layer in LAYERS:
        seen = solution.observables()["h"] if layer.key is None else maps[layer.key]
        values = np.where(np.isfinite(seen), seen, np.nan)
        write_style(write_raster(folder / f"{layer.name}{ending}", values, terrain), layer)
        if layer.least is not None:
            drawn = _drawn(relief, terrain, values, layer, dict.fromkeys(("png", picture)))
            pictures[f"{layer.name}.png"] = drawn["png"]
            write_whole(folder / f"{layer.name}.{picture}", drawn[picture])
    write_series(folder, watched, solution)
    paths = [str(one) for one in watched.values() if isinstance(one, RunOut)]
    summary = "\n".join([summarised(scene, solution, hazard, balance), *paths])
    told = limits(solution, hazard, watched, balance)
    write_whole(folder / "report.html", _page(scene, solution, summary, told, pictures))
    return "\n".join([summary, *(f"caution: {text}" for text in told[1:])])


def limits(solution: Solution, hazard: HazardMaps, watched: Mapping[str, Any], balance: MassBalance) -> list[str]:
    """Return what limits the result of a run, as sentences: first the grid, then what was seen in this run."""
    seen, stats, dx = solution.observables(), solution.stats, solution.grid.axes[0].dx
    there = sum(balance.first.values()) + sum(max(sum(row.values()), 0.0) for row in balance.entered.values())
    lost = {side: -sum(balance.entered[side].values()) for side in EDGES}
    speed = float(np.hypot(seen["v_x"], seen["v_y"])[seen["h"] >= hazard.threshold].max(initial=0.0)) if "v_x" in seen else 0.0
    deep = stats.nonhyperbolic_faces - stats.nonhyperbolic_films
    found = [f"no error of the grid was estimated: a run with cell = {2.0 * dx:g} shows how much hangs on the cells of {dx:g} m"]
    if not solution.success:
        found.append(f"the run ended early, and maps are those until then: {solution.message}")
    if speed > MOVES:
        found.append(f"where it is deeper than {hazard.threshold:g} m the flow still moves at the end, with up to {speed:.3g} "
                     "m/s: run-out and deposit are not final")
    found += [f"{volume:.4g} m3, {volume / there:.1%} of all, left through the {side}: what they do beyond is not known"
              for side, volume in lost.items() if volume > LEFT * there]
    if deep:
        found.append(f"characteristic speeds were complex at {deep} pairs of face and step outside of films, up to "
                     f"{stats.deepest_nonhyperbolic:.3g} m deep: the problem is ill-posed there and does not converge")
    found += ["the flow reached the end of the path, which may be too short" for one in watched.values()
              if isinstance(one, RunOut) and one.reaches_end]
    return found


def _drawn(relief: Any, terrain: Terrain, values: np.ndarray, layer: Layer, formats: Iterable[str]) -> dict[str, bytes]:
    """Return pictures of a layer over the relief, {format: content}, and take the layer away again."""
    from fvkit_granular.terrain.maps import laid_over

    found = {}
    with laid_over(relief, terrain, values / layer.unit, layer.shows, (layer.least or 0.0) / layer.unit):
        for kind in formats:
            target = io.BytesIO()
            options = {"pil_kwargs": {"compress_level": 3}} if kind == "png" else {}
            relief.figure.savefig(target, format=kind, dpi=120, **options)
            found[kind] = target.getvalue()
    return found


def summarised(scene: Scene, solution: Solution, hazard: HazardMaps, balance: MassBalance) -> str:
    """Return the volumes of a run, its largest values and reach, as text."""
    grid, model, maps = solution.grid, solution.model, hazard.maps
    wet = maps["depth"] >= hazard.threshold
    area = float(np.count_nonzero(wet) * grid.cell_volume)
    heights = np.where(wet, scene.terrain.bottom, np.nan)
    lines = [str(balance), f"first contact: a cell beside it is deeper than {hazard.threshold:g} m",
             f"area deeper than {hazard.threshold:g} m at any time: {area:.6g} m2"]
    if wet.any():
        lines.append(f"it reaches from {np.nanmax(heights):.5g} down to {np.nanmin(heights):.5g} m of elevation")
    lines.append(f"largest depth {maps['depth'].max():.4g} m, speed {maps['speed'].max():.4g} m/s, dynamic pressure "
                 f"{maps['pressure'].max() / 1e3:.4g} kPa")
    if scene.watch.observed is not None:
        score = compare_outline(maps["depth"], scene.watch.observed, scene.terrain, hazard.threshold)
        lines.append(f"deeper than {hazard.threshold:g} m against what was observed: {score}")
    lines.append(f"equations for {getattr(model, 'slope', 'mild')} slopes")
    return "\n".join(lines)


def _computed_with(scene: Scene, solution: Solution) -> str:
    """Return model and sources as text, with the range of what varies over the ground in place of its cells."""
    lines = [str(solution.model)]
    for source in scene.sources:
        told = []
        for name in source.parameter_names():
            value = getattr(source, name)
            several = np.ndim(value) > 0
            told.append(f"{name}={np.min(value):.6g} to {np.max(value):.6g}, by cell" if several else f"{name}={value}")
        lines.append(f"{type(source).__name__}({', '.join(told)})")
    return "\n".join(lines)


def _page(scene: Scene, solution: Solution, summary: str, told: Sequence[str], pictures: Mapping[str, bytes]) -> str:
    """Return the report as one HTML page with its pictures inside."""
    kept = solution.configuration
    versions = ", ".join(f"{name} {version}" for name, version in kept["versions"].items())
    parts = [f"<h1>{html.escape(scene.name or scene.terrain.name)}</h1>", f"<p>{html.escape(scene.description)}</p>",
             f"<p>{html.escape(solution.message)}; t = {solution.t[-1]:.6g} s; {solution.stats.steps} steps in "
             f"{solution.stats.seconds:.3g} s.</p>", f"<pre>{html.escape(summary)}</pre>", "<h2>What limits the result</h2>",
             "<ul>" + "".join(f"<li>{html.escape(text)}</li>" for text in told) + "</ul>"]
    for name, content in pictures.items():
        picture = base64.b64encode(content).decode()
        parts.append(f'<figure><img alt="{name}" src="data:image/png;base64,{picture}"><figcaption>{name}</figcaption></figure>')
    parts += [f"<h2>Terrain</h2><pre>{html.escape(scene.terrain.describe())}</pre>",
              f"<h2>Release</h2><pre>{html.escape(str(scene.release))}</pre>",
              f"<h2>Computed with</h2><pre>{html.escape(_computed_with(scene, solution))}</pre>",
              f"<p>{html.escape(versions)}. {html.escape(kept['citation'])}</p>"]
    head = f'<meta charset="utf-8"><title>{html.escape(scene.name or "report")}</title><style>{STYLE}</style>'
    return f'<!DOCTYPE html><html lang="en"><head>{head}</head><body>' + "\n".join(parts) + "</body></html>\n"
