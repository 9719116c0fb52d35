"""Release of mass on a terrain: thickness by polygons, rasters or arrays (`Release`, `read_release`)."""

import warnings
from typing import Any, NamedTuple

import attrs
import numpy as np

from fvkit import validation
from fvkit.studies.tables import table
from fvkit_granular.sources.plausible import caution
from fvkit_granular.terrain import crs as systems
from fvkit_granular.terrain import features
from fvkit_granular.terrain.features import Feature, is_vector, read_features, separate
from fvkit_granular.terrain.rasters import cells_of
from fvkit_granular.terrain.terrain import SAME_CELLS, Terrain

#: Plausible thickness, m: more than of the largest rock avalanches.
THICKEST = 150.0

#: Largest plausible thickness over width, and, over the standard deviation of the elevation, the root mean square of thickness
#: less elevation below which the thickness is the elevation of a surface: 1 or more for any constant thickness.
THICK, ALIKE = 0.5, 0.3

#: Attributes of features, in any case: thickness, m, and solid fraction.
THICKNESS, SOLID = ("thickness", "d0", "h"), ("solid_fraction", "phi")

#: Share of the volume of a raster that may seem to lie beyond a terrain by rounding.
WHOLE = 1e-6

MEASURED = ("vertical", "normal")


def _cells(value: Any, name: str) -> np.ndarray:
    result = validation.array(value, name)
    result.flags.writeable = False
    return result


class ReleasedPart(NamedTuple):
    """A released feature: ``name``, ``area`` on the map, m^2, ``thickness`` as given, m, and ``volume`` on the terrain, m^3."""

    name: str
    area: float
    thickness: float
    volume: float


@attrs.frozen(repr=False)
class Release:
    """Release of mass on a terrain: vertical thickness of each cell. `read_release` makes it.

    Parameters
    ----------
    terrain : the terrain.
    thickness : (ny, nx) vertical thickness, the average of each cell, m, >= 0.
    phi : (ny, nx) solid fraction in [0, 1], 0 where nothing is released; None where it was not given.
    parts : what was released: ``name``, ``area``, ``thickness`` as given, ``volume`` on the terrain.
    measured : how the given thickness is measured, ``"vertical"`` or ``"normal"`` to the ground.

    Examples
    --------
    >>> import numpy as np
    >>> import fvkit as fv, fvkit_granular as gr
    >>> terrain = gr.Terrain(fv.Grid((0.0, 0.0), (20.0, 10.0), (2, 1)), np.zeros((1, 2)))
    >>> square = {"type": "Polygon", "coordinates": [[[0, 0], [10, 0], [10, 10], [0, 10], [0, 0]]]}
    >>> release = gr.read_release(square, terrain, thickness=2.0, solid_fraction=0.6)
    >>> release.thickness, release.phi, release.volume
    (array([[2., 0.]]), array([[0.6, 0. ]]), 200.0)
    """

    terrain: Any = validation.field(validation.instance, kind=Terrain)
    thickness: Any = validation.field(_cells, eq=SAME_CELLS)
    phi: Any = validation.field(_cells, None, optional=True, eq=SAME_CELLS)
    parts: tuple[ReleasedPart, ...] = ()
    measured: Any = validation.field(validation.choice, "vertical", known=MEASURED)

    def __attrs_post_init__(self) -> None:
        shape = self.terrain.grid.shape
        for name, values, most in (("thickness", self.thickness, np.inf), ("phi", self.phi, 1.0)):
            if values is not None and values.shape != shape:
                raise ValueError(f"`{name}` must have the shape of the terrain, {shape}, got {values.shape}")
            if values is not None and (values.min() < 0.0 or values.max() > most):
                raise ValueError(f"`{name}` must be >= 0{' and <= 1' if most == 1.0 else ' m'}, got {values.min():g} to "
                                 f"{values.max():g}")

    def warn_of_units(self) -> None:
        """Warn where the thickness looks like another unit, or like elevations."""
        released = self.thickness > 0.0
        h, b = self.thickness[released], self.terrain.bottom[released]
        if h.size and np.sqrt(((h - b) ** 2).mean()) < ALIKE * b.std():
            warnings.warn(f"`thickness` of Release, up to {h.max():.4g} m, follows the elevation of the ground: "
                          "give the height of a surface above it", UserWarning, stacklevel=validation.users_line())
            return
        width = np.sqrt(h.size * self.terrain.grid.cell_volume)
        caution(self, "thickness", 0.0, min(THICKEST, THICK * width), f"it is in m, and 200 cm are 2; the release is {width:.3g} "
                "m wide (root of its area), and shallow flow is much thinner than wide")

    @property
    def volume(self) -> float:
        """Released volume on the terrain, m^3."""
        return float(self.thickness.sum() * self.terrain.grid.cell_volume)

    def __repr__(self) -> str:
        return (f"Release({len(self.parts)} on {self.terrain.name!r}: {self.volume:.6g} m3, up to {self.thickness.max():.4g} m, "
                f"given {self.measured})")

    def __str__(self) -> str:
        header = ("released", "area on the map, m2", "thickness, m", "area x thickness, m3", "volume, m3")
        rows = [(part.name, f"{part.area:.6g}", f"{part.thickness:.4g}", f"{part.area * part.thickness:.6g}",
                 f"{part.volume:.6g}") for part in self.parts]
        total = sum(part.area for part in self.parts), sum(part.area * part.thickness for part in self.parts)
        rows.append(("all", f"{total[0]:.6g}", "", f"{total[1]:.6g}", f"{self.volume:.6g}"))
        how = ("vertically: the volume is area x thickness" if self.measured == "vertical"
               else "normal to the ground: the volume is larger by 1/cos of its slope in each cell")
        return f"{table([header, *rows], left=1)}\nthickness is measured {how}"


def read_release(source: Any, terrain: Terrain, thickness: float | None = None, solid_fraction: float | None = None,
                 measured: str = "vertical") -> Release:
    """Read a release of mass, the starting zone, from polygons, a raster or an array, and put it on the cells of a terrain.

    Cells that a polygon covers in part get that part of its thickness, exactly: the volume is area times thickness to rounding.

    Parameters
    ----------
    source : a path: GeoJSON (``.geojson``, ``.json``), a shapefile (``.shp``, extra ``geo``), or a raster of thickness on the
        grid of the terrain or of its file (``.asc``, ``.txt``, ``.tif``), where no data means nothing; or GeoJSON as a mapping;
        or an array (ny, nx) of thickness, m. Polygons may have holes and many parts.
    terrain : where it lies.
    thickness : m, > 0, of every polygon; None for their attributes ``thickness``, ``d0`` or ``h``, in any case.
    solid_fraction : in [0, 1], of all; None for the attributes ``solid_fraction`` or ``phi``, or none.
    measured : how thickness is measured: ``"vertical"``, or ``"normal"`` to the ground; then h = thickness / cos(slope).

    Returns
    -------
    Release
        ``print`` shows each feature with area, thickness and volume.

    Raises
    ------
    ValueError, TypeError
        If a file is damaged, a feature is empty, crosses itself, lies outside of the terrain, where it has no data or on another
        feature, thickness or solid fraction are missing or out of bounds, or a CRS or grid is not that of the terrain.
    FileNotFoundError
        If there is no such file.
    ImportError
        For a shapefile or a GeoTIFF without the extra ``geo``.

    Examples
    --------
    >>> import numpy as np
    >>> import fvkit as fv, fvkit_granular as gr
    >>> terrain = gr.Terrain(fv.Grid((0.0, 0.0), (40.0, 30.0), (4, 3)), np.zeros((3, 4)))
    >>> square = {"type": "Polygon", "coordinates": [[[5, 5], [20, 5], [20, 25], [5, 25], [5, 5]]]}
    >>> release = gr.read_release(square, terrain, thickness=2.0)
    >>> release.thickness
    array([[0.5, 1. , 0. , 0. ],
           [1. , 2. , 0. , 0. ],
           [0.5, 1. , 0. , 0. ]])
    >>> print(release)
    released   area on the map, m2  thickness, m  area x thickness, m3  volume, m3
    ---------  -------------------  ------------  --------------------  ----------
    feature 1                  300             2                   600         600
    all                        300                                 600         600
    thickness is measured vertically: the volume is area x thickness
    """
    ground = validation.instance(terrain, "terrain", Terrain)
    how = validation.choice(measured, "measured", MEASURED)
    given = None if thickness is None else validation.real(thickness, "thickness", above=0.0)
    solid = None if solid_fraction is None else validation.real(solid_fraction, "solid_fraction", at_least=0.0, at_most=1.0,
                                                                hint="60 % is 0.6")
    b_x, b_y = ground.gradient
    stretch = np.sqrt(1.0 + b_x**2 + b_y**2) if how == "normal" else np.ones(ground.grid.shape)
    if is_vector(source):
        return _of_features(read_features(source, ground), ground, given, solid, how, stretch)
    where, values = _depths(source, ground)
    if given is not None:
        raise ValueError(f"`thickness` must be None where {where} is the thickness of each cell, got {given:g}")
    h = values * stretch
    covered = np.count_nonzero(values) * ground.grid.cell_volume
    part = ReleasedPart(where, covered, float(values[values > 0.0].mean()), float(h.sum() * ground.grid.cell_volume))
    return Release(ground, h, None if solid is None else np.where(h > 0.0, solid, 0.0), (part,), how)


def _of_features(found: list[Feature], terrain: Terrain, thickness: float | None, solid: float | None, measured: str,
                 stretch: np.ndarray) -> Release:
    h, solids, parts = np.zeros(terrain.grid.shape), np.zeros(terrain.grid.shape), []
    fractions = [_solid(feature) if solid is None else solid for feature in found]
    if None in fractions and any(fraction is not None for fraction in fractions):
        raise ValueError(f"{found[fractions.index(None)].where}: solid_fraction must be given for every feature or for none: "
                         "give it, or the argument `solid_fraction`")
    for (feature, share), fraction in zip(separate(found, terrain, _share), fractions, strict=True):
        depth = _thickness(feature) if thickness is None else thickness
        own = share * depth * stretch
        h += own
        solids += own * (fraction or 0.0)
        parts.append(ReleasedPart(feature.name, feature.area, depth, float(own.sum() * terrain.grid.cell_volume)))
    phi = None if None in fractions else np.divide(solids, h, out=np.zeros_like(h), where=h > 0.0)
    return Release(terrain, h, phi, tuple(parts), measured)


def _thickness(feature: Feature) -> float:
    value = feature.number(THICKNESS)
    if value is None:
        raise ValueError(f"{feature.where} must have an attribute {' or '.join(THICKNESS)}, got "
                         f"{validation.one_line(', '.join(feature.attributes)) or 'none'}: give it, or the argument `thickness`")
    if not (np.isfinite(value) and value > 0.0):
        raise ValueError(f"{feature.where}: thickness must be finite and > 0 m, got {value:g}")
    return value


def _solid(feature: Feature) -> float | None:
    value = feature.number(SOLID)
    if value is not None and not 0.0 <= value <= 1.0:
        raise ValueError(f"{feature.where}: solid_fraction must be in [0, 1], got {value:g}: 60 % is 0.6")
    return value


def _share(feature: Feature, terrain: Terrain) -> np.ndarray:
    """Return the share of each cell that a feature covers, or raise ValueError where it is outside or on no data."""
    check_inside(feature, terrain)
    share = feature.shares(terrain)
    check_known(share, terrain, feature.where)
    return share


def area_shares(found: list[Feature], terrain: Terrain) -> np.ndarray:
    """Return the share of each cell, (ny, nx), that features cover; see `read_release` for mistakes in them."""
    return np.sum([share for _, share in separate(found, terrain, _share)], axis=0)


def check_inside(feature: Feature, terrain: Terrain) -> None:
    """Raise ValueError, saying by how much, where a feature reaches beyond a terrain."""
    points = np.concatenate([points for polygon in feature.polygons for points in polygon])
    low, high = points.min(axis=0), points.max(axis=0)
    x, y = terrain.grid.axes
    beyond = {"west": x.lower - low[0], "east": high[0] - x.upper, "south": y.lower - low[1], "north": high[1] - y.upper}
    outside = [f"{distance:.6g} m {side}" for side, distance in beyond.items() if distance > 0.0]
    if not outside:
        return
    hint = ""
    if _within(1000.0 * low, 1000.0 * high, terrain):
        hint = "; these look like kilometres: all lengths are in m"
    elif _within(0.001 * low, 0.001 * high, terrain):
        hint = "; the terrain looks like kilometres: all lengths are in m"
    elif (np.abs(points) <= [180.0, 90.0]).all():
        hint = "; these look like degrees: reproject it"
    elif _within(low[::-1], high[::-1], terrain):
        hint = "; with x and y exchanged it would lie within"
    raise ValueError(f"{feature.where} must lie within the terrain, x {x.lower:.10g} to {x.upper:.10g} m, y {y.lower:.10g} to "
                     f"{y.upper:.10g} m, got x {low[0]:.10g} to {high[0]:.10g}, y {low[1]:.10g} to {high[1]:.10g}: it reaches "
                     f"{', '.join(outside)} of it, in the terrain's CRS ({systems.named(terrain.crs)}){hint}")


def _within(low: np.ndarray, high: np.ndarray, terrain: Terrain) -> bool:
    """Whether a box lies within a terrain."""
    x, y = terrain.grid.axes
    return bool((low >= [x.lower, y.lower]).all() and (high <= [x.upper, y.upper]).all())


def check_known(covered: np.ndarray, terrain: Terrain, where: str) -> None:
    """Raise ValueError where something covers cells, (ny, nx), without data."""
    lost = np.where(terrain.missing, covered, 0.0)
    if lost.any():
        raise ValueError(f"{where} must lie where the terrain has data, got {(lost > 0.0).sum()} cells without, the first at "
                         f"{terrain.grid.located(int(np.flatnonzero(lost)[0]))}: move it, or fill holes, `terrain.filled()`")


def _depths(source: Any, terrain: Terrain) -> tuple[str, np.ndarray]:
    """Return what messages call a raster or an array of thickness, and its values (ny, nx), 0 where there is none."""
    where, values, total = cells_of(source, terrain, "source", tuple(features.READERS), np.nan_to_num)
    if (values < 0.0).any() or not values.any():
        raise ValueError(f"{where}: thickness must be >= 0 m, and > 0 somewhere, got {values.min():g} to {values.max():g}")
    within = float(values.sum()) * terrain.grid.cell_volume
    if total - within > WHOLE * total:
        raise ValueError(f"{where} must lie within the terrain, got {total - within:.6g} of its {total:.6g} m3 beyond it: give "
                         "the terrain a larger `window`, or no release there")
    check_known(values, terrain, where)
    return where, values
