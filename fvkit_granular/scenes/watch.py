"""`Watch`: records of a run of a scene besides its outputs: gauges, cross-sections, front, hazard maps."""

import re
from collections.abc import Mapping, Sequence
from typing import Any

import attrs
import numpy as np

from fvkit import CrossSection, Gauge, Observer, validation
from fvkit.problem.grid import NAMES
from fvkit.run.cross_section import cells_along
from fvkit_granular.observers.front import Front
from fvkit_granular.observers.hazard import HazardMaps
from fvkit_granular.observers.run_out import RunOut
from fvkit_granular.terrain.outline import compare_outline
from fvkit_granular.terrain.terrain import Terrain

#: Default depth, m, from which on hazard maps with two axes count a flow as arrived.
THRESHOLD = 0.1


def _places(value: Any) -> tuple[Any, ...]:
    """Return places of gauges: numbers x, or pairs (x, y)."""
    if not isinstance(value, (list, tuple)):
        raise TypeError(f"`gauges` must be a list of places x, or of pairs (x, y), got {validation.shown(value)}")
    try:
        Gauge(value) if value else None  # refuses what is no place
    except (ValueError, TypeError) as error:
        raise type(error)(str(error).replace("`x`", "`gauges`", 1)) from None
    return tuple(tuple(place) if isinstance(place, (list, tuple)) else place for place in value)


def _lines(value: Any) -> dict[str, Any]:
    """Return {name: points} of cross-sections, checked."""
    given = validation.mapping(value, "lines", '{"bridge": [(0.0, 5.0), (0.0, 9.0)]}')
    for name, line in given.items():
        if not re.fullmatch(r"\w[\w .-]*", str(name)):
            raise ValueError(f"`lines` must have names of letters, digits, blanks, points, - and _, for those of "
                             f"files, got {validation.shown(name)}")
        try:
            CrossSection(line)
        except (ValueError, TypeError) as error:
            raise type(error)(f"`lines`, {name}: {error}") from None
    return {str(name): [tuple(point) for point in line] if isinstance(line, (list, tuple)) else float(line)
            for name, line in given.items()}


def _path(value: Any) -> tuple[tuple[float, float], ...]:
    """Return the points of a path."""
    if value is None or (isinstance(value, (list, tuple)) and not value):
        return ()
    return tuple((x, y) for x, y in RunOut(value).path.tolist())


@attrs.frozen
class Watch:
    """Records of a run at every step: gauges, discharge through lines, run-out along a path, front, hazard maps.

    Parameters
    ----------
    gauges : places x, m, or pairs (x, y) with two axes.
    lines : {name: points (x, y)}, cross-sections, see `fvkit.CrossSection`; with one axis {name: place x}.
    threshold : depth, m, of `HazardMaps`, `RunOut` and `Front`. With one axis front and largest values are recorded where it is
        given; with two None is 0.1.
    density, least : of `HazardMaps`; with one axis ``density`` has no effect and is refused.
    path : points (x, y) of a path line, see `RunOut` and `read_path`; two axes alone.
    observed : observed outline, as for `compare_outline`, on a terrain: its score is in output and report.

    Examples
    --------
    >>> import fvkit_granular as gr
    >>> gr.Watch(gauges=(1.0, 2.0), threshold=0.05)
    Watch(gauges=(1.0, 2.0), lines={}, threshold=0.05, density=2000.0, least=0.01, path=())
    """

    gauges: tuple[Any, ...] = attrs.field(default=(), converter=_places)
    lines: Mapping[str, Any] = attrs.field(factory=dict, converter=_lines)
    threshold: float | None = validation.optional_number(above=0.0)
    density: float = validation.number(2000.0, above=0.0)
    least: float = validation.number(0.01, above=0.0)
    path: tuple[tuple[float, float], ...] = attrs.field(default=(), converter=_path)
    observed: Any = attrs.field(default=None, repr=False)

    def check(self, ends: Sequence[tuple[float, float]]) -> None:
        """Raise ValueError if a gauge or a line does not have one coordinate per axis, or lies outside the scene.

        Parameters
        ----------
        ends : (lower, upper) of each axis, m.
        """
        for key, instead in (("path", "front.csv of a `threshold` has the run-out"), ("density", "no pressure is written")):
            if len(ends) == 1 and getattr(self, key) != getattr(Watch(), key):
                raise ValueError(f"`{key}` is for scenes with two axes, and this one has one: {instead}, leave it out")
        if len(ends) == 1 and self.threshold is None and self.least != Watch().least:
            raise ValueError("`least` is of the largest speed, which a scene with one axis records with a `threshold`: give that")
        for name, line in self.lines.items():
            if isinstance(line, list) != (len(ends) > 1):
                wanted = "a list of points (x, y) in a scene with two axes" if len(ends) > 1 else "a place x in one with one axis"
                raise ValueError(f"`lines`, {name} must be {wanted}, got {validation.shown(line)}")
        points = [("gauges", "", place) for place in self.gauges]
        points += [("path", "", point) for point in self.path]
        points += [("lines", f", {name}", point) for name, line in self.lines.items()
                   for point in (line if isinstance(line, list) else [line])]
        for key, which, point in points:
            at = point if isinstance(point, tuple) else (point,)
            if len(at) != len(ends):
                raise ValueError(f"`{key}`{which} must have {len(ends)} coordinate{'s' * (len(ends) > 1)} for each place, got "
                                 f"{point}")
            for letter, value, (lower, upper) in zip(NAMES, at, ends, strict=False):
                if not lower <= value <= upper:
                    fits = len(ends) > 1 and all(a <= v <= b for v, (a, b) in zip(at[::-1], ends, strict=True))
                    hint = ": with x and y exchanged it would" if fits else ""
                    raise ValueError(f"`{key}`{which} must lie within the scene, {letter} from {lower:.10g} to {upper:.10g} m, "
                                     f"got {letter} = {value:.10g}{hint}")

    def check_on(self, terrain: Terrain) -> None:
        """Raise ValueError for gauges and lines where a terrain has no data, and for an observed outline that does not fit it."""
        if self.observed is not None:  # refused here, not after a run
            score = compare_outline(np.zeros(terrain.grid.shape), self.observed, terrain)
            if score.misses == 0.0:
                raise ValueError("`observed` must hold cells > 0, or polygons, where the terrain has data, got none")
        for place in self.gauges:
            if terrain.missing.flat[terrain.grid.cells_at([place], "`gauges`")].any():
                raise ValueError(f"`gauges` must lie where the terrain has data, got {place}: move it, or fill the gap")
        for name, line in self.lines.items():
            if terrain.missing.flat[cells_along(np.array(line), terrain.grid, "`lines`")[0]].all():
                raise ValueError(f"`lines`, {name} must cross cells where the terrain has data, got none such: move it, or fill "
                                 "the gap")

    def observers(self, axes: int) -> dict[str, Observer]:
        """Return new observers, {name: observer}: "gauges", "hazard", "front", "run-out", and each line by its name."""
        found: dict[str, Observer] = {"gauges": Gauge(list(self.gauges))} if self.gauges else {}
        deep = THRESHOLD if self.threshold is None else self.threshold
        if axes > 1 or self.threshold is not None:
            found["hazard"] = HazardMaps(deep, self.density, self.least)
        if axes == 1 and self.threshold is not None:
            found["front"] = Front(deep)
        if self.path:
            found["run-out"] = RunOut(self.path, deep)
        return found | {f"line {name}": CrossSection(points) for name, points in self.lines.items()}
