"""Parameters that vary over a terrain, such as friction, from a raster or from zones (`read_parameter`)."""

from typing import Any

import numpy as np

from fvkit import validation
from fvkit_granular.terrain.features import READERS, is_vector, read_features, separate
from fvkit_granular.terrain.rasters import cells_of
from fvkit_granular.terrain.release import check_inside
from fvkit_granular.terrain.terrain import Terrain

#: What a cell may lack to count as covered, by rounding.
WHOLE = 1e-9


def read_parameter(source: Any, terrain: Terrain, attribute: str | None = None, elsewhere: float | None = None) -> np.ndarray:
    """Read a parameter of the ground, such as a friction coefficient, from a raster or from an attribute of polygons (zones).

    A cell that a zone covers in part gets the mean by area.

    Parameters
    ----------
    source : a raster on the grid of the terrain or of its file (``.asc``, ``.txt``, ``.tif``), an array (ny, nx), or polygons
        as for `read_release`.
    terrain : where it lies.
    attribute : name of the attribute of the polygons, in any case; for polygons alone.
    elsewhere : value where the raster has no data, or beyond the polygons; None where there is none such but cells in which the
        terrain has no data either.

    Returns
    -------
    numpy.ndarray
        (ny, nx), for a field of a source: ``gr.CoulombFriction(gr.read_parameter(...))``.

    Raises
    ------
    ValueError, TypeError
        For a mistake in a file, with the feature, or cells without a value.
    FileNotFoundError
        If there is no such file.
    ImportError
        For a shapefile or a GeoTIFF without the extra ``geo``.

    Examples
    --------
    >>> import numpy as np
    >>> import fvkit as fv, fvkit_granular as gr
    >>> terrain = gr.Terrain(fv.Grid((0.0, 0.0), (40.0, 10.0), (4, 1)), np.zeros((1, 4)))
    >>> forest = {"type": "Feature", "properties": {"nu": 0.6},
    ...           "geometry": {"type": "Polygon", "coordinates": [[[5, 0], [20, 0], [20, 10], [5, 10], [5, 0]]]}}
    >>> gr.read_parameter(forest, terrain, attribute="nu", elsewhere=0.2)
    array([[0.4, 0.6, 0.2, 0.2]])
    """
    ground: Terrain = validation.instance(terrain, "terrain", Terrain)
    other = None if elsewhere is None else validation.real(elsewhere, "elsewhere")
    if is_vector(source):
        where, values, known = _of_zones(source, ground, attribute)
    elif attribute is not None:
        raise ValueError(f"`attribute` is for polygons, got {attribute!r} with a raster: leave it out")
    else:
        where, values, _ = cells_of(source, ground, "source", tuple(READERS))
        values, known = np.nan_to_num(values), np.where(np.isnan(values), 0.0, 1.0)
    lost = (known < 1.0) & ~ground.missing
    if other is None and lost.any():
        raise ValueError(f"{where}: {int(lost.sum())} cells have no value, the first at "
                         f"{ground.grid.located(int(np.flatnonzero(lost)[0]))}: give `elsewhere`")
    rest = float(values.sum() / max(known.sum(), 1.0)) if other is None else other
    return np.asarray(values + (1.0 - known) * rest)


def _of_zones(source: Any, terrain: Terrain, attribute: str | None) -> tuple[str, np.ndarray, np.ndarray]:
    """Return what messages call polygons, their attribute times the share of each cell that they cover, and that share."""
    name = validation.text(attribute, "attribute").lower()
    covered, total, where = np.zeros(terrain.grid.shape), np.zeros(terrain.grid.shape), ""
    found = read_features(source, terrain)
    for feature, share in separate(found, terrain):
        value = feature.number((name,))
        if value is None or not np.isfinite(value):
            raise ValueError(f"{feature.where} must have a finite attribute {name!r}, got "
                             f"{value or ', '.join(feature.attributes) or 'none'}: give it, or another `attribute`")
        covered += share
        total += share * value
        where = where or feature.where
    if not covered.any():
        check_inside(found[0], terrain)
    covered = np.where(covered > 1.0 - WHOLE, 1.0, covered)
    return where, total, covered
