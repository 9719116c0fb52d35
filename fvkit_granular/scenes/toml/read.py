"""Scenes from TOML files: data only, nothing in a file is evaluated."""

from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import Any

import attrs
import numpy as np

from fvkit import Along, Outflow, Periodic, Wall, validation
from fvkit.problem.directions import SIDES
from fvkit.problem.grid import NAMES
from fvkit_granular.boundaries import FixedLevel, GivenFlow, Hydrograph, UniformSlope
from fvkit_granular.models.quantities import velocities
from fvkit_granular.scenes.library.catalogue import scene_factory, scene_names
from fvkit_granular.scenes.profile import Profile
from fvkit_granular.scenes.scene import Scene
from fvkit_granular.scenes.shaped_flow import ShapedFlow
from fvkit_granular.scenes.shapes import SHAPES, Shape, Sum
from fvkit_granular.scenes.toml.by_name import BuiltInBottom, BuiltInFlow, BuiltInReference
from fvkit_granular.scenes.toml.table import Table, read_toml
from fvkit_granular.scenes.toml.terrain import gaps_of, hydrographs_of, release_of, terrain_of, with_rasters
from fvkit_granular.scenes.watch import Watch
from fvkit_granular.sources.curvature import Curvature
from fvkit_granular.sources.drag_laws import ConstantDrag, PitmanLeDrag, VelocityDrag
from fvkit_granular.sources.friction_laws import CoulombFriction, Manning, Voellmy
from fvkit_granular.terrain.path import read_path
from fvkit_granular.terrain.terrain import Terrain

#: Extension of scene files, and the help of the argument SCENE.
SUFFIX = ".toml"
SCENE_HELP = "built-in scene (fvkit scenes lists them) or scene file (.toml)"

#: Samples of the package by name: scene files with all that they read.
SAMPLES = {f"sample-{path.parent.name}": path
           for path in sorted((Path(__file__).parents[1] / "samples").glob("*/scene.toml"))}

#: Boundary conditions and sources by their names in files. Their fields are the other keys of a table: a new class is one line.
BOUNDARIES: dict[str, type] = {"outflow": Outflow, "wall": Wall, "periodic": Periodic, "inflow": GivenFlow,
                               "hydrograph": Hydrograph, "fixed-level": FixedLevel, "uniform-slope": UniformSlope}
SOURCES: dict[str, type] = {"constant-drag": ConstantDrag, "velocity-drag": VelocityDrag, "pitman-le-drag": PitmanLeDrag,
                            "coulomb": CoulombFriction, "voellmy": Voellmy, "manning": Manning, "curvature": Curvature}


#: Sides of a scene with two axes, and the type of a part of one, which has conditions of its own.
ALL_SIDES = tuple(name for pair in SIDES for name in pair)
ALONG = "along"

#: Keys of a file, of `initial`, and what those of a flow measure.
TOP = ("name", "description", "interval", "terrain", "release", "phi", "t_end", "g", "gamma", "slope", "reference", "initial",
       "bottom", "boundary", "friction", "hydrograph", "sources", "outputs")
PLAIN = ("interval", "t_end", "g", "gamma", "slope", "phi")

#: Keys of [outputs] besides the times: those of `Watch`.
WATCH = ("gauges", "lines", "path", "threshold", "density", "least", "observed")
FLOW = {"h": "length", "surface": "length", "phi": "share", **dict.fromkeys((*velocities(1), *velocities(2)), "speed")}

#: Keys of a table that takes a column of a CSV file.
COLUMN = ("file", "column", "along", "interpolation", "over")

#: Points at which a flow is looked at when its file is read, and most outputs.
POINTS, MOST_OUTPUTS = 2001, 100_000


def find_scene(text: str) -> Scene:
    """Return a built-in scene or a sample by its name, such as sample-torrent, or that of a file that ends in ``.toml``.

    A ValueError for an unknown name or a mistake in the file, with the key.
    """
    return find_factory(text)()


def find_factory(text: str) -> Callable[..., Scene]:
    """Return the function that makes the scene of `find_scene`; its arguments, if any, are those of a built-in scene."""
    if text.endswith(SUFFIX):
        return partial(load_scene, text)
    if text in SAMPLES:
        return partial(load_scene, SAMPLES[text])
    if text not in scene_names() and ("/" in text or "\\" in text or Path(text).is_file()):
        raise ValueError(f"`scene` must be the name of a built-in scene or a file that ends in {SUFFIX}, got {text!r}")
    return scene_factory(validation.choice(text, "scene", (*scene_names(), *SAMPLES)))


def scene_label(text: str) -> str:
    """Return what reports and folders call the scene of `find_scene`: its name, or that of the file without its ending."""
    return Path(text).stem if text.endswith(SUFFIX) else text


def load_scene(path: str | Path) -> Scene:
    """Return the scene that a TOML file describes; docs/scene_files.md has every key.

    Parameters
    ----------
    path : the file, UTF-8, at most 1 MB. CSV files that it names are relative to its folder.

    Raises
    ------
    ValueError
        For a mistake, with file, key and nearest match.
    FileNotFoundError
        Where there is no such file.

    Examples
    --------
    >>> import pathlib, tempfile
    >>> import fvkit_granular as gr
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     path = pathlib.Path(folder, "dam.toml")
    ...     _ = path.write_text(gr.scene_text(gr.scene("dam-break")), encoding="utf-8")
    ...     scene = gr.load_scene(path)
    >>> scene.interval
    (-5.0, 5.0)
    """
    top = read_toml(path).only(TOP)
    on_terrain = "terrain" in top.data
    for key in ("t_end",) if on_terrain else ("interval", "t_end", "initial"):
        top.need(key)
    for key in ("interval", "bottom") if on_terrain else ("release", "hydrograph", "phi"):
        if key in top.data:
            raise top.error(f"`{key}` and [terrain] exclude each other" if on_terrain else f"`{key}` needs a [terrain]", key)
    terrain = terrain_of(top) if on_terrain else None
    given: dict[str, Any] = {key: top.data[key] for key in PLAIN if key in top.data}
    if terrain is not None:
        given |= {"terrain": terrain, "gaps": gaps_of(top), "release": release_of(top, terrain)}
    initial = _initial(top.inner("initial"), _axes(top)) if "initial" in top.data else None
    reference = BuiltInReference(top.choice("reference", scene_names())) if "reference" in top.data else None
    boundary, sources = _boundary(top), _sources(top, terrain)
    name, description = top.text("name", Path(path).stem), top.text("description", "")
    with top.located():
        scene = Scene(initial=initial, bottom=_bottom(top), boundary=boundary, sources=sources, reference=reference, name=name,
                      description=description, times=_times(top), **given)
    if "outputs" in top.data:
        with top.inner("outputs").located():
            scene = attrs.evolve(scene, watch=_watch(top, terrain))
    _check(top, scene)
    return scene


def _quantity(table: Table, key: str, measures: str, *inside: int) -> Any:
    """Return a number as a float, a table as a shape or a column, and a list as their sum."""
    value: Any = table.data[key]
    for step in inside:
        value = value[step]
    if isinstance(value, list) and not inside:
        if not value:
            raise table.error(f"`{key}` must not be an empty list", key)
        return Sum([_quantity(table, key, measures, k) for k in range(len(value))])
    if not isinstance(value, dict):
        with table.located(key, *inside):
            return validation.real(value, key, hint="a number, a table with `shape` or `file`, or a list of them")
    inner = table.inner(key, *inside)
    if "file" in inner.data:
        return _column(inner, "b" if key == "bottom" else key, measures)
    if "shape" not in inner.data:
        raise inner.error(f"`{key}` needs `shape`, one of {', '.join(SHAPES)}, or `file`, a CSV file; got "
                          f"{', '.join(inner.data) or 'nothing'}")
    return inner.part("shape", SHAPES)


def _column(table: Table, name: str, measures: str) -> Profile:
    table.only(COLUMN)
    file, column, along = table.text("file"), table.text("column", name), table.text("along", "x")
    with table.located():
        return Profile.read(table.path.parent / file, column, table.text("interpolation"), along, measures,
                            table.data.get("over"))


def _bottom(top: Table) -> Any:
    if "bottom" not in top.data:
        return 0.0
    given = top.data["bottom"]
    if isinstance(given, dict) and "from" in given:
        return BuiltInBottom(top.inner("bottom").only(("from",)).choice("from", scene_names()))
    return _quantity(top, "bottom", "length")


def _initial(table: Table, axes: int) -> ShapedFlow | BuiltInFlow:
    if "flow" in table.data:
        return BuiltInFlow(table.only(("flow",)).choice("flow", scene_names()))
    table.only(("h", "surface", "phi", *velocities(axes), "flow"))
    parts = {key: _quantity(table, key, measures) for key, measures in FLOW.items() if key in table.data}
    with table.located():
        return ShapedFlow(**parts)


def _axes(top: Table) -> int:
    """How many axes the scene of a file has: two where its interval has corners."""
    given = top.data.get("interval")
    return 2 if given is None or (isinstance(given, list) and any(isinstance(end, list) for end in given)) else 1


def _boundary(top: Table) -> Any:
    if "boundary" not in top.data:
        return Outflow()
    table = top.inner("boundary")
    if _axes(top) > 1:
        if "all" in table.data:
            return _side(table.only(("all",)), "all")
        return {side: _side(table, side) for side in table.only((*ALL_SIDES, "all")).data}
    if "both" in table.data:
        return _side(table.only(("both",)), "both")
    table.only(("left", "right", "both"))
    for side in ("left", "right"):
        table.need(side)
    pair = _side(table, "left"), _side(table, "right")
    if isinstance(pair[0], Periodic) != isinstance(pair[1], Periodic):
        raise table.error('a periodic boundary needs both sides: write `both = "periodic"`', "left")
    return pair


def _side(table: Table, key: str) -> Any:
    """Return a boundary condition, given by its name alone or as a table with its type and fields."""
    if isinstance(table.need(key), dict):
        inner = table.inner(key)
        if inner.data.get("type") == ALONG:
            inner.only(("type", "lower", "upper", "condition", "otherwise"))
            rest = _side(inner, "otherwise") if "otherwise" in inner.data else None
            with inner.located():
                return Along(inner.need("lower"), inner.need("upper"), _side(inner, "condition"), rest)
        if "file" in inner.data and inner.choice("type", BOUNDARIES) == "hydrograph":
            inner.only(("type", "file"))
            with inner.located("file"):
                return Hydrograph.read(inner.path.parent / inner.text("file"))
        return inner.part("type", BOUNDARIES)
    kind = BOUNDARIES[table.choice(key, BOUNDARIES)]
    with table.located(key):
        try:
            return kind()
        except TypeError:
            raise ValueError(f"`{key}` needs a table with fields, such as {{type = \"{table.data[key]}\", ...}}") from None


def _sources(top: Table, terrain: Terrain | None) -> tuple[Any, ...]:
    given = top.data.get("sources", [])
    if not isinstance(given, list):
        raise top.error("`sources` must be a list of tables: write [[sources]]", "sources")
    tables = [top.inner("sources", k) for k in range(len(given))]
    tables += [top.inner("friction")] if "friction" in top.data else []
    found = tuple(with_rasters(table, terrain).part("type", SOURCES) for table in tables)
    return found if terrain is None else found + hydrographs_of(top, terrain)


def _watch(top: Table, terrain: Terrain | None) -> Watch:
    table = top.inner("outputs")
    given = {key: table.data[key] for key in WATCH if key in table.data}
    if isinstance(given.get("path"), str):
        if terrain is None:
            raise table.error("`path` must be a list of points (x, y): a file needs a [terrain]", "path")
        with table.located("path"):
            given["path"] = read_path(table.path.parent / given["path"], terrain)
    if "observed" in given:
        given["observed"] = table.path.parent / table.text("observed")
    with table.located():
        return Watch(**given)


def _times(top: Table) -> tuple[float, ...] | None:
    if "outputs" not in top.data:
        return None
    table = top.inner("outputs").only(("times", "count", *WATCH))
    chosen = table.data.keys() & {"times", "count"}
    if not chosen:
        return None
    if len(chosen) != 1:
        raise table.error("[outputs] takes either `times`, a list, or `count`, a number of equal intervals up to the end")
    with top.located("t_end"):
        t_end = validation.real(top.data["t_end"], "t_end", above=0.0)
    if "count" in table.data:
        with table.located("count"):
            count = validation.whole(table.data["count"], "count", at_least=1, at_most=MOST_OUTPUTS)
        return tuple(np.linspace(0.0, t_end, count + 1)[1:].tolist())
    with table.located("times"):
        times = validation.array(table.data["times"], "times")
        if times.ndim != 1 or not times.size or times[0] <= 0.0 or times[-1] > t_end or (np.diff(times) <= 0.0).any():
            raise ValueError(f"`times` must be a list that ascends within (0, t_end = {t_end:g}], got {table.data['times']!r}")
    return tuple(times.tolist())


def _check(top: Table, scene: Scene) -> None:
    """Raise where the flow or the bottom has no meaning somewhere on the interval, or the reference is not that of the flow."""
    places = scene.sampled(POINTS)
    with np.errstate(all="ignore"):
        if isinstance(scene.bottom, Shape):
            with top.located("bottom"):
                validation.array(scene.bottom(*places), "bottom")
        if isinstance(scene.initial, ShapedFlow):
            table, flow = top.inner("initial"), scene.initial
            for key in table.data:
                with table.located(key):
                    _in_range(key, places, getattr(flow, key)(*places))
    if isinstance(scene.reference, BuiltInReference):
        with top.located("reference"):
            scene.reference.check(scene)


def _in_range(key: str, places: tuple[np.ndarray, ...], values: np.ndarray) -> None:
    validation.array(values, key)
    lowest, highest = {"h": (0.0, np.inf), "phi": (0.0, 1.0)}.get(key, (-np.inf, np.inf))
    wrong = np.flatnonzero((values < lowest) | (values > highest))
    if wrong.size:
        bounds = f">= {lowest:g}" + (f" and <= {highest:g}" if np.isfinite(highest) else "")
        where = ", ".join(f"{name} = {one.flat[wrong[0]]:.6g}" for name, one in zip(NAMES, places, strict=False))
        raise ValueError(f"`{key}` must be {bounds}, got {values.flat[wrong[0]]:.6g} at {where}")
