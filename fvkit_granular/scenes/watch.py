"""`Watch`: what a run of a scene records besides its outputs: gauges, cross-sections, hazard maps."""

import re
from collections.abc import Mapping
from typing import Any

import attrs

from fvkit import CrossSection, Gauge, Observer, validation
from fvkit_granular.observers.hazard import HazardMaps


def _places(value: Any) -> tuple[Any, ...]:
    """Return places of gauges: numbers x, or pairs (x, y)."""
    if not isinstance(value, (list, tuple)):
        raise TypeError(f"`gauges` must be a list of places x, or of pairs (x, y), got {validation.shown(value)}")
    Gauge(value) if value else None  # refuses what is no place
    return tuple(tuple(place) if isinstance(place, (list, tuple)) else place for place in value)


def _lines(value: Any) -> dict[str, Any]:
    """Return {name: points} of cross-sections, checked."""
    given = validation.mapping(value, "lines", '{"bridge": [(0.0, 5.0), (0.0, 9.0)]}')
    for name, line in given.items():
        if not re.fullmatch(r"[\w][\w .-]*", str(name)):
            raise ValueError("`lines` must have names of letters, digits, spaces, `.`, `-` and `_`, which files are named after, "
                             f"got {name!r}")
        try:
            CrossSection(line)
        except (ValueError, TypeError) as error:
            raise type(error)(f"`lines`, {name}: {error}") from None
    return {str(name): [tuple(point) for point in line] for name, line in given.items()}


@attrs.frozen
class Watch:
    """What a run records at every step: gauges at places, discharge through lines, and hazard maps.

    Parameters
    ----------
    gauges : places x, m, or pairs (x, y) with two axes.
    lines : {name: points (x, y)}, cross-sections, see `fvkit.CrossSection`; two axes alone.
    threshold, density, least : of `HazardMaps`, which are kept with two axes.
    """

    gauges: tuple[Any, ...] = attrs.field(default=(), converter=_places)
    lines: Mapping[str, Any] = attrs.field(factory=dict, converter=_lines)
    threshold: float = validation.number(0.1, above=0.0)
    density: float = validation.number(2000.0, above=0.0)
    least: float = validation.number(0.01, above=0.0)

    def observers(self, axes: int) -> dict[str, Observer]:
        """Return new observers for a run, {name: observer}: "gauges", "hazard", and each line by its name."""
        found: dict[str, Observer] = {"gauges": Gauge(list(self.gauges))} if self.gauges else {}
        if axes > 1:
            found["hazard"] = HazardMaps(self.threshold, self.density, self.least)
        return found | {f"line {name}": CrossSection(points) for name, points in self.lines.items()}
