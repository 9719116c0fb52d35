"""Coordinate reference systems (CRS) as texts: kept as they are given, compared, never converted."""

import re
from pathlib import Path

from fvkit.files import write_whole

#: Texts of geographic systems: WKT, old .prj files, EPSG's and OGC's names of WGS 84.
DEGREES = re.compile(r"^\s*(?:COMP\w+\[[^\[]*)?(?:GEOGCS|GEOGCRS|GEODCRS)\b|^\s*projection\s+geographic\b|"
                     r"\bEPSG:{1,2}4326\b|\bCRS84\b", re.IGNORECASE)
FEET = re.compile(r'UNIT\["[^"]*(foot|feet)', re.IGNORECASE)
CODE = re.compile(r'\bEPSG:(?:[\w.]*:)?(\d+)\s*$|(?:AUTHORITY|ID)\["EPSG",\s*"?(\d+)"?\]\s*\]\s*$', re.IGNORECASE)


def read_beside(path: Path) -> str | None:
    """Return the text of the .prj file beside a file, or None where there is none."""
    place = path.with_suffix(".prj")
    return place.read_text(encoding="utf-8", errors="replace").strip() or None if place.is_file() else None


def in_metres(crs: str | None, where: object) -> str | None:
    """Return a CRS, or raise ValueError where its coordinates are degrees or feet; ``where`` names what has it."""
    if crs is not None and (unit := _unit(crs)):
        raise ValueError(f"{where} must have coordinates in metres, got {unit} ({named(crs)}): reproject it, to UTM "
                         "for example, with `gdalwarp -t_srs EPSG:32632` or QGIS")
    return crs


def _unit(crs: str) -> str:
    """Return the unit of a CRS that is not metres, or "": as its text says, of a code as GDAL does where it is installed."""
    if DEGREES.search(crs):
        return "degrees"
    if FEET.search(crs):
        return "feet"
    if "[" in crs:
        return ""
    try:
        from rasterio import Env
        from rasterio.crs import CRS
        from rasterio.errors import CRSError
    except ImportError:
        return ""
    try:
        with Env():  # which keeps what GDAL says off the terminal
            system = CRS.from_user_input(crs)
            unit, factor = system.units_factor
    except CRSError:
        return ""
    return "degrees" if system.is_geographic else "" if factor == 1.0 else str(unit)


def named(crs: str | None) -> str:
    """Return the short name of a CRS: of a WKT its first name, else its text."""
    if crs is None:
        return "no CRS given"
    found = re.search(r'\["([^"]+)"', crs)
    return found[1] if found else " ".join(crs.split())[:60]


def epsg(crs: str) -> str | None:
    """Return the EPSG code at the end of a CRS, or None."""
    found = CODE.search(crs)
    return found[1] or found[2] if found else None


def check_same(crs: str | None, of_terrain: str | None, where: object) -> None:
    """Raise ValueError unless two CRS are the same, or one is not given; ``where`` names what has the first."""
    if crs is None or of_terrain is None or "".join(crs.split()) == "".join(of_terrain.split()):
        return
    codes = epsg(crs), epsg(of_terrain)
    if None in codes:
        same, advice = _same_to_gdal(crs, of_terrain)
    else:
        same, advice = codes[0] == codes[1], ""
    if not same:
        raise ValueError(f"{where} must have the CRS of the terrain, {named(of_terrain)}, got {named(crs)}: reproject it with "
                         f"`ogr2ogr -t_srs` or `gdalwarp -t_srs`{advice}")


def _same_to_gdal(one: str, other: str) -> tuple[bool, str]:
    """Return whether GDAL takes two texts for the same CRS, and advice where it cannot decide or is missing."""
    advice = "; if they are the same, write both in the same words"
    try:
        from rasterio import Env
        from rasterio.crs import CRS
        from rasterio.errors import CRSError
    except ImportError:
        return False, f"{advice}, or let GDAL compare them: pip install 'fvkit[geo]'"
    try:
        with Env():  # which keeps what GDAL says off the terminal
            first, second = CRS.from_user_input(one), CRS.from_user_input(other)
            code = first.to_epsg()
            return first == second or (code is not None and code == second.to_epsg()), ""
    except CRSError:
        return False, advice


def write_beside(path: Path, crs: str | None) -> None:
    """Write the ``.prj`` file beside a raster, or remove an older one where there is no CRS."""
    place = path.with_suffix(".prj")
    if crs is None:
        place.unlink(missing_ok=True)
    else:
        write_whole(place, crs)
