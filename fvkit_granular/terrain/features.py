"""Features of vector files: polygons with their attributes from GeoJSON, and from shapefiles (extra ``geo``)."""

import json
import logging
import struct
import warnings
from collections.abc import Callable, Iterable, Iterator, Mapping
from contextlib import contextmanager
from os import PathLike
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from fvkit import validation
from fvkit.files import Unreadable
from fvkit_granular.csv_table import text_of
from fvkit_granular.terrain import crs as systems
from fvkit_granular.terrain.polygons import Polygon, area, crossing, ring, shares, signed_area
from fvkit_granular.terrain.terrain import Terrain

#: Largest accepted size of a GeoJSON file, bytes.
LARGEST = 100_000_000

#: Share of a cell by which rings may overlap by rounding, and below which a share is nothing but rounding.
ROUNDING, NOTHING = 1e-6, 1e-12

TYPES, LINES = ("Polygon", "MultiPolygon"), ("LineString", "MultiLineString")

REPAIR = "repair it, with QGIS' \"fix geometries\" for example"


class Feature(NamedTuple):
    """Polygons with attributes.

    Parameters
    ----------
    name : its attribute ``name``, or its number.
    where : what messages call it: its file and name.
    polygons : the polygons of the feature.
    attributes : {name in small letters: value}.
    """

    name: str
    where: str
    polygons: list[Polygon]
    attributes: dict[str, Any]

    @property
    def area(self) -> float:
        """Area on the map, m^2."""
        return sum(area(polygon) for polygon in self.polygons)

    def number(self, names: tuple[str, ...]) -> float | None:
        """Return the first attribute of these names that is there, as a number, or None."""
        for name in names:
            value = self.attributes.get(name)
            if value is not None and value != "":
                try:
                    if isinstance(value, bool):
                        raise TypeError
                    return float(value.replace(",", ".") if isinstance(value, str) else value)
                except (TypeError, ValueError):
                    raise ValueError(f"{self.where}: attribute `{name}` must be a number, got "
                                     f"{validation.shown(value)}") from None
        return None

    def shares(self, terrain: Terrain) -> np.ndarray:
        """Return the share of each cell of a terrain that the feature covers, (ny, nx); ValueError where its rings overlap."""
        total = sum((shares(polygon, terrain.grid) for polygon in self.polygons), np.zeros(terrain.grid.shape))
        if total.min() < -ROUNDING or total.max() > 1.0 + ROUNDING:
            raise ValueError(f"{self.where}: rings must not overlap, and holes must lie within their ring: {REPAIR}")
        return np.where(total < NOTHING, 0.0, np.minimum(total, 1.0))


def is_vector(source: Any) -> bool:
    """Whether a source is a mapping of GeoJSON, or the path of a vector file."""
    if isinstance(source, (str, PathLike)):
        return Path(source).suffix.lower() in READERS
    return isinstance(source, Mapping) or hasattr(source, "__geo_interface__")


def read_features(source: Any, terrain: Terrain) -> list[Feature]:
    """Return the features of a vector file or of GeoJSON as a mapping, or raise ValueError naming file and feature.

    Its CRS must be that of the terrain, where both are known.
    """
    return features_of(*read_geometries(source, terrain))


def features_of(where: str, given: list[tuple[Any, Any]]) -> list[Feature]:
    """Return the features of what `read_geometries` has read, or raise as `read_features` does."""
    features = [_feature(where, number, geometry, attributes) for number, (geometry, attributes) in enumerate(given, 1)]
    if not features:
        raise ValueError(f"{where} must have a feature, got none")
    return features


def read_geometries(source: Any, terrain: Terrain) -> tuple[str, list[tuple[Any, Any]]]:
    """Return what messages call a source, and pairs of its geometries (GeoJSON) and their attributes; see `read_features`."""
    if isinstance(source, (str, PathLike)):
        if Path(source).suffix.lower() not in READERS:
            raise ValueError(f"{source} must be a vector file, which ends in {', '.join(READERS)}")
        where, given, crs = READERS[Path(source).suffix.lower()](validation.file(source, "source"))
    else:
        where, given, crs = _collection(getattr(source, "__geo_interface__", source), "GeoJSON")
    systems.in_metres(crs, where)
    systems.check_same(crs, terrain.crs, where)
    return where, given


def separate(features: Iterable[Feature], terrain: Terrain,
             shares_of: Callable[[Feature, Terrain], np.ndarray] = Feature.shares) -> Iterator[tuple[Feature, np.ndarray]]:
    """Give each feature with the share of each cell that it covers, (ny, nx), or raise ValueError where features overlap."""
    covered = np.zeros(terrain.grid.shape)
    for feature in features:
        share = shares_of(feature, terrain)
        covered += share
        if covered.max() > 1.0 + ROUNDING:
            raise ValueError(f"{feature.where}: features must not overlap, got one before it at "
                             f"{terrain.grid.located(int(np.argmax(covered)))}: merge or cut them")
        yield feature, share


#: What a reader returns: what messages call it, pairs of geometry (GeoJSON) and attributes, CRS.
Given = tuple[str, list[tuple[Any, Any]], str | None]


def _geojson(path: Path) -> Given:
    text = text_of(path, LARGEST)
    try:
        read = json.loads(text)
    except json.JSONDecodeError as error:
        raise ValueError(f"{path}, line {error.lineno}: this is no JSON, or the file ends too early: {error.msg}") from None
    except ValueError:  # an integer of more digits than Python reads
        raise ValueError(f"{path}: a number has thousands of digits; coordinates and attributes have a few") from None
    except RecursionError:
        raise ValueError(f"{path}: lists are nested too deeply for GeoJSON") from None
    return _collection(read, str(path))


def _collection(read: Any, where: str) -> Given:
    kind = read.get("type") if isinstance(read, Mapping) else None
    if kind in (*TYPES, *LINES):
        return where, [(read, {})], None
    members = read.get("features") if kind == "FeatureCollection" else [read] if kind == "Feature" else None
    if not isinstance(members, (list, tuple)) or not all(isinstance(one, Mapping) for one in members):
        raise ValueError(f"{where} must be GeoJSON: a FeatureCollection, a Feature, a Polygon or a MultiPolygon, got type "
                         f"{validation.shown(kind)}")
    return where, [(one.get("geometry"), one.get("properties")) for one in members], _named_crs(read.get("crs"), where)


def _named_crs(member: Any, where: str) -> str | None:
    """Return the name in GeoJSON's old member ``crs``, or None."""
    if member is None:
        return None
    properties = member.get("properties") if isinstance(member, Mapping) else None
    name = properties.get("name") if isinstance(properties, Mapping) else None
    if not isinstance(name, str):
        raise ValueError(f"{where}: `crs` must name a system, such as {{'type': 'name', 'properties': {{'name': "
                         f"'EPSG:31287'}}}}, got {validation.shown(member)}")
    return name


def _shapefile(path: Path) -> Given:
    shapefile = validation.library("shapefile", f"{path}: a shapefile", "geo")
    if not path.is_file():
        raise FileNotFoundError(f"there is no file {path}")
    try:
        with warnings.catch_warnings(), _silent(shapefile.__name__):
            warnings.simplefilter("error", getattr(shapefile, "PossiblyCorruptFileHeader", UserWarning))
            with shapefile.Reader(str(path), encodingErrors="replace") as file:
                given = [(one.shape.__geo_interface__ if one.shape.shapeType else None, one.record.as_dict())
                         for one in file.iterShapeRecords()]
                if len(given) != file.numRecords:  # pyshp ends where a truncated .shx does
                    raise ValueError(f"its .shx has {len(given)} shapes, its .dbf {file.numRecords} records")
    except (shapefile.ShapefileException, Warning, OSError, struct.error, LookupError, TypeError, ValueError) as error:
        said = " ".join(str(error).split())
        raise Unreadable(path, f"it is damaged or no shapefile, or its .dbf is missing ({said})") from None
    return str(path), given, systems.read_beside(path)


@contextmanager
def _silent(logger: str) -> Iterator[None]:
    """Let a logger say nothing: pyshp remarks on rings in the other direction, which are read all the same."""
    log = logging.getLogger(logger)
    before, log.disabled = log.disabled, True
    try:
        yield
    finally:
        log.disabled = before


READERS = {".geojson": _geojson, ".json": _geojson, ".shp": _shapefile}


def _feature(where: str, number: int, geometry: Any, attributes: Any) -> Feature:
    known = {str(key).lower(): value for key, value in attributes.items()} if isinstance(attributes, Mapping) else {}
    name = validation.one_line(str(known.get("name") or f"feature {number}"))
    place = f"{where}, {name if name.startswith('feature ') else f'feature {name!r}'}"
    polygons = list(_polygons(geometry, place))
    for polygon in polygons:
        corner = crossing(polygon)
        if corner is not None:
            raise ValueError(f"{place}: rings must not cross themselves or each other, got a side from x = {corner[0]:.10g}, "
                             f"y = {corner[1]:.10g} that does: {REPAIR}")
        if any(signed_area(points) == 0.0 for points in polygon):
            raise ValueError(f"{place}: a ring must enclose an area, got points on a line: remove it")
    return Feature(name, place, polygons, known)


def _polygons(geometry: Any, where: str) -> Iterator[Polygon]:
    kind = geometry.get("type") if isinstance(geometry, Mapping) else None
    if geometry is not None and kind not in TYPES:
        raise ValueError(f"{where} must be a Polygon or MultiPolygon, got {validation.shown(kind)}")
    parts = None if geometry is None else geometry.get("coordinates")
    if not isinstance(parts, (list, tuple)) or not parts:
        raise ValueError(f"{where} must have a polygon, got an empty one: remove it")
    for rings in parts if kind == "MultiPolygon" else [parts]:
        if not isinstance(rings, (list, tuple)) or not rings:
            raise ValueError(f"{where} must have a list of rings, got {validation.shown(rings)}")
        yield [ring(points, where) for points in rings]
