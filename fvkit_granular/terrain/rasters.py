"""Raster files of elevation and results (DEM): `read_terrain` and `write_raster`, ESRI ASCII and GeoTIFF."""

from collections.abc import Callable
from os import PathLike
from pathlib import Path
from typing import Any

import numpy as np

from fvkit import validation
from fvkit.files import write_whole
from fvkit_granular.terrain import ascii_grid, geotiff
from fvkit_granular.terrain import crs as systems
from fvkit_granular.terrain.raster import NODATA, Raster
from fvkit_granular.terrain.terrain import Terrain

#: Readers by the end of a file's name.
READERS: dict[str, Callable[[Path], Raster]] = {".asc": ascii_grid.read, ".txt": ascii_grid.read,
                                                **dict.fromkeys((".tif", ".tiff", ".geotiff"), geotiff.read)}


def read_raster(path: Any, name: str = "path", besides: tuple[str, ...] = ()) -> Raster:
    """Return the raster of a file, by the end of its name; ``name`` is that of the argument in messages, see `cells_of`."""
    place = validation.file(path, name)
    if place.suffix.lower() not in READERS:
        raise ValueError(f"`{name}` must be a file that ends in {', '.join((*besides, *READERS))}, got {str(place)!r}")
    raster = READERS[place.suffix.lower()](place)
    systems.in_metres(raster.crs, place)
    return raster


def cells_of(source: Any, terrain: Terrain, name: str, besides: tuple[str, ...] = (),
             of: Callable[[np.ndarray], np.ndarray] = np.asarray) -> tuple[str, np.ndarray, float]:
    """Return what messages call a raster or an array, its values on the cells of a terrain, NaN for no data, and their integral.

    ``of`` are the values that are wanted, of those of the file, before averages are taken over larger cells. The integral is over
    all of the raster, no data is 0. ValueError where grid or CRS of a raster are not those of the terrain, see
    `Terrain.averages`; ``besides`` are other endings that would do.
    """
    if not isinstance(source, (str, bytes, PathLike)):
        values = of(validation.array(source, name, terrain.grid.shape))
        return "the array", values, float(np.nansum(values)) * terrain.grid.cell_volume
    raster = read_raster(source, name, besides)
    systems.check_same(raster.crs, terrain.crs, raster.path)
    values = of(raster.values)
    total = float(np.nansum(values)) * raster.grid.cell_volume
    return str(raster.path), terrain.averages(values, raster.grid, raster.path), total


def read_terrain(path: Any, window: Any = None, cell: float | None = None) -> Terrain:
    """Read a terrain, a digital elevation model (DEM), from an ESRI ASCII raster or a GeoTIFF.

    Cells without data are masked, not numbers. The CRS is the text of the file, or of the ``.prj`` file beside
    it, and is never converted. Elevations and sizes that look like another unit than m are warned of.

    Parameters
    ----------
    path : ``.asc`` or ``.txt``: ESRI ASCII, any case and order of keys, corner or center, decimal points or commas; cells are
        square; without ``NODATA_value`` -9999 means no data. ``.tif``: GeoTIFF of any codec, one band (extra ``geo``).
    window : part to keep, ((x0, y0), (x1, y1)), m, see `Terrain.window`; None for all.
    cell : length of a side of larger cells, m, see `Terrain.coarser`; None for those of the file.

    Returns
    -------
    Terrain
        Named after the file.

    Raises
    ------
    ValueError
        If the file is damaged or no terrain; the message names the file, and the line or key.
    FileNotFoundError
        If there is no such file.
    ImportError
        For a GeoTIFF without the extra ``geo``.

    Examples
    --------
    >>> import pathlib, tempfile
    >>> import fvkit_granular as gr
    >>> path = pathlib.Path(tempfile.mkdtemp(), "ramp.asc")
    >>> _ = path.write_text("NCOLS 3\\nNROWS 2\\nXLLCORNER 0\\nYLLCORNER 0\\nCELLSIZE 10\\n8,5 5 -9999\\n9,5 6 2,5")
    >>> terrain = gr.read_terrain(path)
    >>> terrain.bottom
    array([[9.5, 6. , 2.5],
           [8.5, 5. , nan]])
    """
    raster = read_raster(path)
    try:
        terrain = Terrain(raster.grid, raster.values, crs=raster.crs, name=raster.path.stem)
        if window is not None:
            terrain = terrain.window(*_corners(window))
    except ValueError as error:
        raise ValueError(f"{raster.path}: {error}") from None
    if cell is not None:
        terrain = terrain.coarser(cell)
    terrain.warn_of_units()
    return terrain


def _corners(window: Any) -> list[Any]:
    corners = validation.listed(window, "window", "((x0, y0), (x1, y1))")
    if len(corners) != 2 or any(np.shape(corner) != (2,) for corner in corners):
        raise ValueError(f"`window` must be two corners ((x0, y0), (x1, y1)), got {validation.shown(window)}")
    return corners


def write_raster(path: Any, values: Any, terrain: Terrain) -> Path:
    """Write a raster of results on the grid and CRS of a terrain: ESRI ASCII, or GeoTIFF; whole or not at all.

    Numbers read back to the same bits. No data is -9999, in the cells without data of the terrain and where ``values`` is NaN.
    The CRS of an ESRI ASCII raster is in a ``.prj`` file beside it.

    Parameters
    ----------
    path : ``.asc`` or ``.txt`` for ESRI ASCII, which has square cells; ``.tif`` for GeoTIFF (extra ``geo``).
    values : (ny, nx), such as depths, m; rows ascend in y as everywhere in fvkit, the file has them from the north.
    terrain : whose cells they are.

    Returns
    -------
    pathlib.Path
        ``path``.

    Raises
    ------
    ValueError, TypeError
        If the values are not those of the cells, infinite or -9999, or the format cannot hold them.
    OSError
        If the disk is full or fails; an older file is as it was.
    ImportError
        For a GeoTIFF without the extra ``geo``.

    Examples
    --------
    >>> import pathlib, tempfile
    >>> import numpy as np
    >>> import fvkit as fv, fvkit_granular as gr
    >>> terrain = gr.Terrain(fv.Grid((0.0, 0.0), (20.0, 10.0), (4, 2)), np.zeros((2, 4)))
    >>> path = gr.write_raster(pathlib.Path(tempfile.mkdtemp(), "depth.asc"), [[0.1, 0, 0, 0], [0, 0, 0, 0.3]], terrain)
    >>> print(path.read_text().splitlines()[-2:])
    ['0.0 0.0 0.0 0.3', '0.1 0.0 0.0 0.0']
    """
    place, ground = validation.file(path, "path"), validation.instance(terrain, "terrain", Terrain)
    if place.suffix.lower() not in READERS:
        raise ValueError(f"`path` must end in {', '.join(READERS)}, got {str(place)!r}")
    cells = ground.cells(values, "values")
    if np.isinf(cells).any() or (cells == NODATA).any():
        raise ValueError(f"`values` must be finite, and not {NODATA:g}, which means no data: write NaN for that")
    cells = np.where(ground.missing, np.nan, cells)
    if READERS[place.suffix.lower()] is geotiff.read:
        return write_whole(place, geotiff.content(cells, ground.grid, ground.crs))
    write_whole(place, ascii_grid.text_of_raster(cells, ground.grid))
    systems.write_beside(place, ground.crs)
    return place
