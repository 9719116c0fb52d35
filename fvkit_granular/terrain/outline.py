"""Scores of a computed area against an observed outline (`compare_outline`)."""

from pathlib import Path
from typing import Any

import attrs
import numpy as np

from fvkit import validation
from fvkit_granular.terrain.features import READERS, is_vector, read_features, separate
from fvkit_granular.terrain.rasters import cells_of
from fvkit_granular.terrain.terrain import Terrain


@attrs.frozen
class OutlineScore:
    """Score of a computed area against an observed one: areas on the map, m^2. `compare_outline` makes it.

    Parameters
    ----------
    hits : computed and observed.
    misses : observed, not computed.
    false_alarms : computed, not observed.
    beyond : observed outside of the terrain or where it has no data; it counts in none of the others.

    Examples
    --------
    >>> import fvkit_granular as gr
    >>> score = gr.OutlineScore(hits=600.0, misses=200.0, false_alarms=200.0)
    >>> score.hit_rate, score.false_alarm_ratio, score.critical_success_index
    (0.75, 0.25, 0.6)
    """

    hits: float
    misses: float
    false_alarms: float
    beyond: float = 0.0

    @property
    def hit_rate(self) -> float:
        """Share of what was observed that was computed, 0 to 1; NaN where nothing was observed."""
        return _share(self.hits, self.hits + self.misses)

    @property
    def false_alarm_ratio(self) -> float:
        """Share of what was computed that was not observed, 0 to 1; NaN where nothing was computed."""
        return _share(self.false_alarms, self.hits + self.false_alarms)

    @property
    def critical_success_index(self) -> float:
        """Hits over hits, misses and false alarms, 0 to 1, also called threat score; NaN where all are 0."""
        return _share(self.hits, self.hits + self.misses + self.false_alarms)

    def __str__(self) -> str:
        beyond = f"; {self.beyond:.6g} m2 were observed beyond the terrain" if self.beyond else ""
        return (f"hits {self.hits:.6g} m2, misses {self.misses:.6g} m2, false alarms {self.false_alarms:.6g} m2: hit rate "
                f"{self.hit_rate:.3f}, false alarm ratio {self.false_alarm_ratio:.3f}, critical success index "
                f"{self.critical_success_index:.3f}{beyond}")


def compare_outline(values: Any, observed: Any, terrain: Terrain, above: float = 0.1) -> OutlineScore:
    """Compare a computed area, where a map of results is above a threshold, with an observed outline: hits, misses, false alarms.

    Cells that the outline cuts count by the share of their area.

    Parameters
    ----------
    values : (ny, nx) results on the terrain, such as largest depths, m, or a raster of them on its grid, such as the
        ``max_depth.asc`` of a run; NaN and no data count as not reached.
    observed : polygons, as `read_release` takes them, without attributes; or a raster on the grid of the terrain or an array
        (ny, nx), observed where it is > 0.
    terrain : the terrain.
    above : threshold of ``values``, in their unit.

    Returns
    -------
    OutlineScore
        Areas and the usual ratios.

    Raises
    ------
    ValueError, TypeError
        If shapes, grids or CRS differ, or a file is damaged, as in `read_release`; polygons may reach beyond the terrain here,
        but not lie beyond it altogether.

    Examples
    --------
    >>> import numpy as np
    >>> import fvkit as fv, fvkit_granular as gr
    >>> terrain = gr.Terrain(fv.Grid((0.0, 0.0), (40.0, 10.0), (4, 1)), np.zeros((1, 4)))
    >>> outline = {"type": "Polygon", "coordinates": [[[5, 0], [30, 0], [30, 10], [5, 10], [5, 0]]]}
    >>> print(gr.compare_outline([[0.5, 0.5, 0.0, 0.3]], outline, terrain))
    hits 150 m2, misses 100 m2, false alarms 150 m2: hit rate 0.600, false alarm ratio 0.500, critical success index 0.375
    """
    ground = validation.instance(terrain, "terrain", Terrain)
    threshold = validation.real(above, "above")
    cells = cells_of(values, ground, "values")[1] if isinstance(values, (str, Path)) else ground.cells(values, "values")
    covered, total = _observed(observed, ground)
    if total > 0.0 and not covered.any():
        raise ValueError(f"`observed` must reach into the terrain, {ground.name!r}, got an outline that lies beyond it: look at "
                         "its coordinates and CRS")
    computed, known = np.nan_to_num(cells, nan=-np.inf) > threshold, ~ground.missing
    area = ground.grid.cell_volume
    hits, misses = (area * float(covered[known & where].sum()) for where in (computed, ~computed))
    false_alarms = area * float((1.0 - covered)[known & computed].sum())
    beyond = total - hits - misses
    return OutlineScore(hits, misses, false_alarms, beyond if beyond > 1e-9 * total else 0.0)


def _observed(observed: Any, terrain: Terrain) -> tuple[np.ndarray, float]:
    """Return the share of each cell that was observed, (ny, nx), and the whole observed area, m^2."""
    if not is_vector(observed):
        return cells_of(observed, terrain, "observed", tuple(READERS), lambda seen: np.where(seen > 0.0, 1.0, 0.0))[1:]
    covered, total = np.zeros(terrain.grid.shape), 0.0
    for feature, share in separate(read_features(observed, terrain), terrain):
        covered += share
        total += feature.area
    return np.minimum(covered, 1.0), total


def _share(part: float, whole: float) -> float:
    return part / whole if whole > 0.0 else float("nan")
