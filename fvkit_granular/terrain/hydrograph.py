"""Hydrographs on a terrain: a flow over time that comes in through polygons or a line (`read_hydrograph`)."""

import warnings
from collections.abc import Mapping
from pathlib import Path
from typing import Any, NamedTuple

import attrs
import numpy as np

from fvkit import validation
from fvkit.run.cross_section import cells_along
from fvkit_granular.csv_table import Columns, read_columns
from fvkit_granular.sources.line_inflow import LineInflow
from fvkit_granular.sources.plausible import caution_values
from fvkit_granular.sources.rain import Rain
from fvkit_granular.terrain.features import LINES, Feature, features_of, read_geometries
from fvkit_granular.terrain.path import points_of
from fvkit_granular.terrain.release import THICKEST, area_shares, check_inside, check_known
from fvkit_granular.terrain.terrain import Terrain

#: Largest plausible speed, m/s, and discharge per width, m^2/s: more than of the fastest rock avalanches.
FASTEST, STRONGEST = 150.0, 1000.0


@attrs.frozen(eq=False)
class OverTime:
    """A map times a series: linear between its times, 0 before the first and after the last.

    Parameters
    ----------
    shape : (ny, nx) the map where the series is 1.
    times : s, ascending.
    values : one for each time.
    """

    shape: np.ndarray = attrs.field(repr=False)
    times: np.ndarray
    values: np.ndarray

    @property
    def cells(self) -> np.ndarray:
        """Numbers of the cells where the map is not 0."""
        return np.flatnonzero(self.shape)

    def breaks(self) -> tuple[float, ...]:
        """Return the times between which it is linear: steps end there, so that no rise is skipped."""
        return tuple(self.times.tolist())

    def brought(self, until: float) -> float:
        """Return the integral of the sum of the map from the first time to another, s."""
        inside = np.union1d(self.times[self.times <= until], min(max(until, self.times[0]), self.times[-1]))
        rates = np.interp(inside, self.times, self.values)
        return float(self.shape.sum() * (0.5 * np.diff(inside) * (rates[1:] + rates[:-1])).sum())

    def warn_of_times(self, t_end: float) -> None:
        """Warn where nothing comes in by the end of a run, s."""
        if self.values.max() > 0.0 and self.brought(t_end) == 0.0:
            warnings.warn(f"a hydrograph brings nothing by `t_end` = {t_end:g} s: its times are {self.times[0]:g} to "
                          f"{self.times[-1]:g} s; count them from the start of the run, or raise `t_end`", UserWarning,
                          stacklevel=validation.users_line())

    def averages(self, t: float) -> np.ndarray:
        """Return the map at time t, (ny, nx)."""
        return np.asarray(self.shape * np.interp(t, self.times, self.values, left=0.0, right=0.0))

    def __call__(self, x: Any, y: Any, t: float) -> np.ndarray:
        """Cell averages alone are known: see `averages`."""
        raise TypeError("an OverTime is a map of cell averages: use `averages(t)`")


def series_of(source: Any) -> OverTime | None:
    """Return the map times a series of discharges that a source brings, None for another source."""
    found = getattr(source, "intensity", None)
    return found if isinstance(found, OverTime) else None


def read_hydrograph(path: str | Path, area: Any, terrain: Terrain) -> Rain:
    """Read a hydrograph that comes in through an area of a terrain, or a line: a source of mass, spread evenly over either.

    Linear between its times; nothing before the first and after the last. Time steps end at its times, so the volume is exact
    where phi is constant. A discharge brings no momentum. Thickness and speed, through a line alone, are a discharge: in each
    row their product times the length of the line. It comes in with that speed, at right angles to the line and downhill, on
    level ground from left to right as seen along it; the pressure of the flow behind the line is left out.

    Parameters
    ----------
    path : CSV file with columns ``t [s]`` (or min, h), ``phi [-]`` (or %) and either ``discharge [m3/s]`` (or l/s) or
        ``thickness [m]``, normal to the ground, and ``speed [m/s]`` (or km/h), along it.
    area : polygons as for `read_release`, or one line (LineString), such as that across a channel: a path of GeoJSON or a
        shapefile, or GeoJSON as a mapping.
    terrain : where it lies.

    Returns
    -------
    Rain
        For ``sources`` of a `Scene` on this terrain. What it brings is in ``entered_by_sources`` of `fvkit.Stats`.

    Raises
    ------
    ValueError
        For a mistake in the table, with file, line and column, or in polygons or a line, with the feature.
    FileNotFoundError
        Where there is no such file.

    Examples
    --------
    >>> import numpy as np
    >>> from pathlib import Path
    >>> from tempfile import TemporaryDirectory
    >>> import fvkit as fv, fvkit_granular as gr
    >>> terrain = gr.Terrain(fv.Grid((0.0, 0.0), (40.0, 30.0), (8, 6)), np.zeros((6, 8)))
    >>> gully = {"type": "Polygon", "coordinates": [[[10, 10], [20, 10], [20, 20], [10, 20], [10, 10]]]}
    >>> with TemporaryDirectory() as folder:
    ...     table = Path(folder) / "inflow.csv"
    ...     _ = table.write_text("t [s],discharge [m3/s],phi [%]\\n0,0,50\\n10,20,50\\n")
    ...     source = gr.read_hydrograph(table, gully, terrain)
    >>> scene = gr.Scene(terrain=terrain, t_end=10.0, sources=(source, gr.ConstantDrag(10.0)))
    >>> solution = fv.solve(scene.problem(gr.TwoPhase), backend="numpy", step=fv.Step(dt_initial=0.1))
    >>> {name: f"{volume:.6g} m3" for name, volume in solution.stats.entered_by_sources.items()}
    {'hs': '50 m3', 'hf': '50 m3'}
    """
    ground: Terrain = validation.instance(terrain, "terrain", Terrain)
    table = read_columns(Path(path))
    times = table.ascending("t", "time", "for a jump put two rows close together")
    if len(times) < 2:
        raise ValueError(f"{path}: a hydrograph must have two rows or more, since nothing comes in before the first and after "
                         "the last, got 1: for a steady inflow put the end time into a second row")
    where, given = read_geometries(area, ground)
    line = _line(where, given, ground) if _is_line(given) else None
    phi = _checked(table, "phi", "share", 1.0)
    solid: Any = float(phi[0]) if (phi == phi[0]).all() else OverTime(np.ones(ground.grid.shape), times, phi)
    shares = area_shares(features_of(where, given), ground) if line is None else line.lengths
    over_area = shares / (shares.sum() * ground.grid.cell_volume)
    if not _has_speed(table):
        discharge = _checked(table, "discharge", "volume rate")
        width = shares.sum() if line else np.sqrt(shares.sum() * ground.grid.cell_volume)
        caution_values(discharge, f"{table.path}: discharge", 0.0, STRONGEST * width,
                       f"through {width:.3g} m of width, in m3/s, and 1000 l/s are 1")
        return Rain(OverTime(over_area, times, discharge), solid)  # type: ignore[arg-type]
    if line is None:
        raise ValueError(f"{table.path}: thickness and speed must come in through a line, got polygons in {where}, which have no "
                         "width across the flow: draw a line across the channel, or give the column discharge [m3/s]")
    speed, thickness = _checked(table, "speed", "speed"), _checked(table, "thickness", "length")
    caution_values(speed, f"{table.path}: speed", 0.0, FASTEST, "in m/s, and 36 km/h are 10")
    caution_values(thickness, f"{table.path}: thickness", 0.0, THICKEST, "in m, and 200 cm are 2")
    discharge = thickness * speed * shares.sum()
    along: Any = [OverTime(part, times, speed) for part in line.directions]
    return LineInflow(OverTime(over_area, times, discharge), solid, *along)  # type: ignore[arg-type]


def _has_speed(table: Columns) -> bool:
    """Whether a table has thickness and speed in place of a discharge; ValueError where it has both."""
    found = [name for name in ("thickness", "speed") if name in table.values]
    if found and "discharge" in table.values:
        raise ValueError(f"{table.path} must have a column discharge, or thickness and speed, which make one, got discharge and "
                         f"{' and '.join(found)}: leave out either")
    return bool(found)


def _checked(table: Columns, name: str, measures: str, highest: float = np.inf) -> np.ndarray:
    """Return a column in SI units, (rows,), or raise ValueError, with the line, where it lies outside of 0..highest."""
    values = table.column(name, measures)
    if name != "phi" and not values.any():
        raise ValueError(f"{table.path}: {name} must be > 0 somewhere, got 0 in every line: nothing would come in")
    wrong = np.flatnonzero((values < 0.0) | (values > highest))
    if wrong.size:
        raise ValueError(f"{table.path}, line {table.lines[wrong[0]]}: {name} must be >= 0" + " and <= 1" * (highest == 1.0)
                         + f", got {values[wrong[0]]:g}")
    return values


def _is_line(given: list[tuple[Any, Any]]) -> bool:
    """Whether all geometries are lines."""
    kinds = [geometry.get("type") for geometry, _ in given if isinstance(geometry, Mapping)]
    return bool(kinds) and set(kinds) <= set(LINES)


class _Line(NamedTuple):
    """A line: its length in each cell, (ny, nx), m, and a speed of 1 m/s along the ground across it on the map, (2, ny, nx)."""

    lengths: np.ndarray
    directions: np.ndarray


def _line(where: str, given: list[tuple[Any, Any]], terrain: Terrain) -> _Line:
    called = f"{where}, line"
    points = np.array(points_of(where, given))
    check_inside(Feature("line", called, [[points]], {}), terrain)
    cells, normals = cells_along(points, terrain.grid, called)
    lengths, directions = np.zeros(terrain.grid.size), np.zeros((2, terrain.grid.size))
    pieces, slopes = np.hypot(*normals), np.array(terrain.gradient).reshape(2, -1)[:, cells]
    np.add.at(lengths, cells, pieces)
    check_known(lengths.reshape(terrain.grid.shape), terrain, called)
    rises = (normals * slopes).sum(axis=0)
    downhill = -1.0 if rises.sum() > 0.0 else 1.0
    for row, normal in zip(directions, normals, strict=True):
        np.add.at(row, cells, downhill * normal / (lengths[cells] * np.sqrt(1.0 + (rises / pieces) ** 2)))
    return _Line(lengths.reshape(terrain.grid.shape), directions.reshape(2, *terrain.grid.shape))
