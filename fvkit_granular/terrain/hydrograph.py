"""Hydrographs on a terrain: a discharge over time that comes in through polygons or a line (`read_hydrograph`)."""

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import attrs
import numpy as np

from fvkit import validation
from fvkit.run.cross_section import cells_along
from fvkit_granular.csv_table import read_columns
from fvkit_granular.sources.rain import Rain
from fvkit_granular.terrain.features import LINES, Feature, read_geometries
from fvkit_granular.terrain.path import read_path
from fvkit_granular.terrain.release import area_shares, check_inside, check_known
from fvkit_granular.terrain.terrain import Terrain


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

    def averages(self, t: float) -> np.ndarray:
        """Return the map at time t, (ny, nx)."""
        return np.asarray(self.shape * np.interp(t, self.times, self.values, left=0.0, right=0.0))

    def __call__(self, x: Any, y: Any, t: float) -> np.ndarray:
        """Cell averages alone are known: see `averages`."""
        raise TypeError("an OverTime is a map of cell averages: use `averages(t)`")


def read_hydrograph(path: str | Path, area: Any, terrain: Terrain) -> Rain:
    """Read a hydrograph that comes in through an area of a terrain, or a line: a source of mass, spread evenly over either.

    It brings no momentum. Linear between its times; nothing before the first and after the last. Time
    steps end at its times, so the volume is exact where phi is constant.

    Parameters
    ----------
    path : CSV file with columns ``t [s]`` (or min, h), ``discharge [m3/s]`` (or l/s) and ``phi [-]`` (or %).
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
    discharge, phi = table.column("discharge", "volume rate"), table.column("phi", "share")
    for name, values, highest in (("discharge", discharge, np.inf), ("phi", phi, 1.0)):
        wrong = np.flatnonzero((values < 0.0) | (values > highest))
        if wrong.size:
            raise ValueError(f"{path}, line {table.lines[wrong[0]]}: {name} must be >= 0" + " and <= 1" * (highest == 1.0)
                             + f", got {values[wrong[0]]:g}")
    shares = _line_shares(area, ground) if _is_line(area, ground) else area_shares(area, ground)
    spread: Any = OverTime(shares / (shares.sum() * ground.grid.cell_volume), times, discharge)
    solid: Any = float(phi[0]) if (phi == phi[0]).all() else OverTime(np.ones(ground.grid.shape), times, phi)
    return Rain(spread, solid)


def _is_line(area: Any, terrain: Terrain) -> bool:
    """Whether all features are lines."""
    kinds = [geometry.get("type") for geometry, _ in read_geometries(area, terrain)[1] if isinstance(geometry, Mapping)]
    return bool(kinds) and set(kinds) <= set(LINES)


def _line_shares(area: Any, terrain: Terrain) -> np.ndarray:
    """Return the length of a line in each cell, (ny, nx), m."""
    called = f"{area if isinstance(area, (str, Path)) else 'GeoJSON'}, line"
    points = np.array(read_path(area, terrain))
    check_inside(Feature("line", called, [[points]], {}), terrain)
    cells, normals = cells_along(points, terrain.grid, called)
    shares = np.zeros(terrain.grid.shape)
    np.add.at(shares.reshape(-1), cells, np.hypot(*normals))
    check_known(shares, terrain, called)
    return shares
