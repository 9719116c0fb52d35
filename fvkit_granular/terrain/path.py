"""Path lines along which a flow runs out, such as a thalweg, from GeoJSON and shapefiles (`read_path`)."""

from pathlib import Path
from typing import Any

import numpy as np

from fvkit import validation
from fvkit_granular.terrain.features import READERS, is_vector, read_geometries
from fvkit_granular.terrain.terrain import Terrain


def read_path(source: Any, terrain: Terrain) -> tuple[tuple[float, float], ...]:
    """Read a path line, such as a thalweg, for `RunOut`: its points in the direction of the flow.

    Parameters
    ----------
    source : path of GeoJSON (``.geojson``, ``.json``) or of a shapefile (``.shp``, extra ``geo``), or GeoJSON as a mapping; it
        holds one line (LineString).
    terrain : on which it lies, and whose CRS it must have.

    Returns
    -------
    tuple
        Points (x, y), m; heights are left out.

    Raises
    ------
    ValueError
        For a file that is damaged, holds no line or several, or has another CRS; the message names the file.
    FileNotFoundError
        If there is no such file.

    Examples
    --------
    >>> import numpy as np
    >>> import fvkit as fv, fvkit_granular as gr
    >>> terrain = gr.Terrain(fv.Grid((0.0, 0.0), (20.0, 10.0), (4, 2)), np.zeros((2, 4)))
    >>> gr.read_path({"type": "LineString", "coordinates": [[1, 5], [12, 5, 310.0], [19, 8]]}, terrain)
    ((1.0, 5.0), (12.0, 5.0), (19.0, 8.0))
    """
    validation.instance(terrain, "terrain", Terrain)
    if not is_vector(source):
        raise ValueError(f"`path` must be a list of points (x, y), GeoJSON or a file {', '.join(READERS)}, got "
                         f"{source if isinstance(source, Path) else validation.shown(source)}")
    return points_of(*read_geometries(source, terrain))


def points_of(where: str, given: list[tuple[Any, Any]]) -> tuple[tuple[float, float], ...]:
    """Return the points of the one line in what `fvkit_granular.terrain.features.read_geometries` has read."""
    lines = [part for geometry, _ in given for part in _lines(geometry, where)]
    if len(lines) != 1:
        raise ValueError(f"{where} must hold one line, got {len(lines)}: join them, in the direction of the flow")
    try:
        points = np.array([point[:2] for point in lines[0]], dtype=float)
    except (TypeError, ValueError):
        points = np.empty(0)
    if points.ndim != 2 or points.shape[1] != 2 or len(np.unique(points, axis=0)) < 2 or not np.isfinite(points).all():
        raise ValueError(f"{where}: a line must have two points (x, y) or more, got {validation.shown(lines[0])}")
    kept = np.concatenate([[True], (np.diff(points, axis=0) != 0.0).any(axis=1)])  # digitised twice
    return tuple((x, y) for x, y in points[kept].tolist())


def _lines(geometry: Any, where: str) -> list[Any]:
    """Return the lines of a geometry, lists of points."""
    kind = geometry.get("type") if isinstance(geometry, dict) else None
    parts = geometry.get("coordinates") if kind in ("LineString", "MultiLineString") else None
    if not isinstance(parts, (list, tuple)):
        raise ValueError(f"{where} must hold a LineString, got {validation.shown(kind)}")
    return list(parts) if kind == "MultiLineString" else [parts]
