"""GeoTIFF rasters through rasterio (extra ``geo``)."""

import warnings
from pathlib import Path
from typing import Any

import numpy as np

from fvkit import validation
from fvkit.files import Unreadable
from fvkit.problem.grid import Grid
from fvkit_granular.terrain.raster import NODATA, Raster, placed


def read(path: Path) -> Raster:
    """Return the raster of a GeoTIFF with one band, of any codec, with its CRS as WKT."""
    rasterio = validation.library("rasterio", f"{path}: a GeoTIFF", "geo")
    if not path.is_file():
        raise FileNotFoundError(f"there is no file {path}")
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", rasterio.errors.NotGeoreferencedWarning)  # told below, as a refusal
            with rasterio.open(path) as file:
                return _read(file, path)
    except rasterio.errors.RasterioError as error:
        raise Unreadable(path, f"it is damaged or no GeoTIFF ({' '.join(str(error).split())})") from None


def _read(file: Any, path: Path) -> Raster:
    turn = file.transform
    if file.count != 1:
        raise ValueError(f"{path}: the raster must have one band, got {file.count}: pick one, with "
                         "`gdal_translate -b 1` for example")
    if turn.is_identity:
        raise ValueError(f"{path}: the raster must have a place on the map, got none: a GeoTIFF has it inside, or in a "
                         ".tfw file beside it")
    if turn.b or turn.d or turn.a < 0.0:
        raise ValueError(f"{path}: rows and columns of the raster must run along the axes of its CRS, got {tuple(turn)[:6]}: "
                         "resample it to a raster that is not rotated, with `gdalwarp` for example")
    validation.fits_memory(file.width * file.height, 1, str(path))
    values = file.read(1, masked=True).astype(float).filled(np.nan)
    if (file.scales[0], file.offsets[0]) != (1.0, 0.0):
        values = values * file.scales[0] + file.offsets[0]
    if turn.e < 0.0:
        values = values[::-1]
    if np.isinf(values).any():
        raise ValueError(f"{path}: numbers must be finite, got {values[np.isinf(values)][0]}: mark what is no data as such")
    south = turn.f + min(turn.e, 0.0) * file.height
    grid = placed((turn.c, south), (turn.a, abs(turn.e)), values.shape)
    return Raster(path, grid, values, file.crs.to_wkt() if file.crs else None)


def content(values: np.ndarray, grid: Grid, crs: str | None) -> bytes:
    """Return a GeoTIFF of double precision, deflated: NaN is the code for no data."""
    rasterio = validation.library("rasterio", "a GeoTIFF", "geo")
    x, y = grid.axes
    rows, columns = values.shape
    with rasterio.Env(), rasterio.io.MemoryFile() as memory:
        with memory.open(driver="GTiff", width=columns, height=rows, count=1, dtype="float64", nodata=NODATA, compress="deflate",
                         predictor=3, crs=_known(crs),
                         transform=rasterio.Affine(x.dx, 0.0, x.lower, 0.0, -y.dx, y.upper)) as file:
            file.write(np.where(np.isnan(values), NODATA, values)[::-1], 1)
        return bytes(memory.read())


def _known(crs: str | None) -> Any:
    """Return a CRS as an object of rasterio, from WKT, also in ESRI's dialect, or a code."""
    from rasterio.crs import CRS
    from rasterio.errors import CRSError

    if crs is None:
        return None
    try:
        return CRS.from_user_input(crs, morph_from_esri_dialect='DATUM["D_' in crs)
    except CRSError as error:
        raise ValueError(f"the CRS of a GeoTIFF must be known to GDAL, got {validation.shown(crs)}: {error}") from None
