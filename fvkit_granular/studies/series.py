"""Series of a run as CSV files: gauges, discharge through lines, front, run-out, and largest values along one axis."""

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from fvkit import CrossSection, Gauge, Solution
from fvkit.files import csv_text, write_whole
from fvkit_granular.observers.front import Front
from fvkit_granular.observers.hazard import HazardMaps
from fvkit_granular.observers.run_out import RunOut
from fvkit_granular.scenes.scene import Scene

#: Files of one series each, and columns of maxima.csv besides x and bottom: {map of `HazardMaps`: unit}.
FILES = ("gauges.csv", "run-out.csv", "front.csv", "maxima.csv")
MAXIMA = {"depth": "m", "thickness": "m", "speed": "m/s", "phi": "-", "arrival": "s", "duration": "s"}


def series_names(scene: Scene) -> list[str]:
    """Return the names of the files that `write_series` writes for a scene."""
    watch, along = scene.watch, len(scene.axes) == 1 and scene.watch.threshold is not None
    there = {"gauges.csv": bool(watch.gauges), "run-out.csv": bool(watch.path), "front.csv": along, "maxima.csv": along}
    return [*(name for name in FILES if there[name]), *(f"line-{name}.csv" for name in watch.lines)]


def is_series(name: str) -> bool:
    """Whether a name is one that `write_series` gives."""
    return name in FILES or (name.startswith("line-") and name.endswith(".csv"))


def write_series(folder: Path, watched: Mapping[str, Any], solution: Solution) -> None:
    """Write what observers have recorded at every step; largest values with one axis alone, where they are no map."""
    for name, observer in watched.items():
        if isinstance(observer, Gauge):
            _write(folder / "gauges.csv", {"t": observer.t, **{
                f"{what} at {_place(place)}": column for what, values in observer.values.items()
                for place, column in zip(observer.x.tolist(), values.T, strict=True)}})
        if isinstance(observer, RunOut):
            _write(folder / "run-out.csv", {"t": observer.t, "distance": observer.distance})
        if isinstance(observer, CrossSection):
            _write(folder / f"line-{name.removeprefix('line ')}.csv",
                   {"t": observer.t, **{f"discharge {mass}": values for mass, values in observer.discharge.items()},
                    **{f"volume {mass}": values for mass, values in observer.volume.items()}})
        if isinstance(observer, Front):
            _write(folder / "front.csv", {"t": observer.t, "left": observer.left, "right": observer.right})
        if isinstance(observer, HazardMaps) and len(solution.grid.axes) == 1:
            _write(folder / "maxima.csv", {
                "x [m]": solution.grid.centers, "bottom [m]": solution.aux.get("b", np.zeros(solution.grid.shape)),
                **{f"{what} [{unit}]": observer.maps[what] for what, unit in MAXIMA.items()}})


def told_along(watched: Mapping[str, Any], solution: Solution) -> str:
    """Return the largest values along one axis, the reach of the front and when it came to each gauge, as text."""
    hazard: Any = watched.get("hazard")
    if hazard is None:
        return ""
    x, maps, over = solution.grid.centers, hazard.maps, f"deeper than {hazard.threshold:g} m"
    lines = [", ".join(f"largest {what} {maps[what].max():.4g} {MAXIMA[what]} at x = {x[maps[what].argmax()]:.6g} m"
                       for what in ("depth", "speed"))]
    reached = x[np.isfinite(maps["arrival"])]
    lines.append(f"{over} from x = {reached[0]:.6g} to {reached[-1]:.6g} m at any time" if reached.size else f"nowhere {over}")
    places = watched["gauges"].x if "gauges" in watched else np.empty(0)
    for place, cell in zip(places, solution.grid.cells_at(places, "`gauges`"), strict=True):
        when = maps["arrival"][cell]
        lines.append(f"at x = {place:.6g} m " + (f"first {over} at t = {when:.6g} s" if np.isfinite(when) else f"never {over}")
                     + f", largest depth {maps['depth'][cell]:.4g} m")
    return "\n".join(lines)


def _place(place: float | Sequence[float]) -> str:
    """Return a place as text without a comma, which would end a column."""
    return " ".join(f"{value:.10g}" for value in (place if isinstance(place, list) else [place]))


def _write(path: Path, columns: Mapping[str, np.ndarray]) -> None:
    """Write columns as CSV; NaN, such as the arrival where there was none, is left empty."""
    rows = zip(*(column.tolist() for column in columns.values()), strict=True)
    write_whole(path, csv_text(columns, ([value if np.isfinite(value) else "" for value in row] for row in rows)))
