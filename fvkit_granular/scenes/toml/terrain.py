"""Scenes on a terrain from TOML files: [terrain], [release], [[hydrograph]] and friction from rasters."""

from typing import Any

from fvkit import validation
from fvkit_granular.scenes.mountain import GAPS
from fvkit_granular.scenes.toml.table import Table
from fvkit_granular.sources.rain import Rain
from fvkit_granular.terrain.hydrograph import read_hydrograph
from fvkit_granular.terrain.parameter import read_parameter
from fvkit_granular.terrain.rasters import read_terrain
from fvkit_granular.terrain.release import Release, read_release
from fvkit_granular.terrain.terrain import Terrain

#: Keys of each table.
TERRAIN = ("file", "window", "cell", "fill", "gaps")
RELEASE = ("file", "thickness", "phi", "measured")
HYDROGRAPH = ("file", "area")
ZONES = ("file", "attribute", "elsewhere")


def terrain_of(top: Table) -> Terrain:
    """Return the terrain of a file; ``fill = true`` fills its holes."""
    table = top.inner("terrain").only(TERRAIN)
    with table.located("file"):
        path = table.path.parent / table.text("file")
    fill = table.data.get("fill", False)
    if not isinstance(fill, bool):
        raise table.error(f"`fill` must be true or false, got {fill!r}", "fill")
    with table.located():
        terrain = read_terrain(path, table.data.get("window"), table.data.get("cell"))
        return terrain.filled() if fill else terrain


def gaps_of(top: Table) -> str:
    """Return what cells without data are."""
    table = top.inner("terrain")
    return table.choice("gaps", GAPS) if "gaps" in table.data else GAPS[0]


def release_of(top: Table, terrain: Terrain) -> Release | None:
    """Return the release of a file; None without one."""
    if "release" not in top.data:
        return None
    table = top.inner("release").only(RELEASE)
    phi = table.data.get("phi")
    with table.located():
        if phi is not None:
            validation.real(phi, "phi", at_least=0.0, at_most=1.0, hint="60 % is 0.6")
        return read_release(table.path.parent / table.text("file"), terrain, table.data.get("thickness"), phi,
                            table.text("measured", "vertical"))


def hydrographs_of(top: Table, terrain: Terrain) -> tuple[Rain, ...]:
    """Return the sources that the hydrographs of a file make."""
    given = top.data.get("hydrograph", [])
    if not isinstance(given, list):
        raise top.error("`hydrograph` must be a list of tables: write [[hydrograph]]", "hydrograph")
    found = []
    for k in range(len(given)):
        table = top.inner("hydrograph", k).only(HYDROGRAPH)
        folder = table.path.parent
        with table.located():
            found.append(read_hydrograph(folder / table.text("file"), folder / table.text("area"), terrain))
    return tuple(found)


def with_rasters(table: Table, terrain: Terrain | None) -> Table:
    """Return a table of a source whose values {file = "..."} are replaced by the cells of that raster, or of those zones."""
    values: dict[str, Any] = dict(table.data)
    for key, value in table.data.items():
        if not isinstance(value, dict):
            continue
        inner = table.inner(key).only(ZONES)
        if terrain is None:
            raise table.error(f"`{key}` must be a number: a raster or zones need a [terrain]", key)
        with inner.located():
            attribute = inner.text("attribute") if "attribute" in inner.data else None
            values[key] = read_parameter(table.path.parent / inner.text("file"), terrain, attribute, inner.data.get("elsewhere"))
    return Table(table.path, table.place, values)
