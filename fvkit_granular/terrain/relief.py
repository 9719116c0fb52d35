"""Relief of a raster: gradient, steepness, depressions."""

from heapq import heapify, heappop, heappush

import attrs
import numpy as np

from fvkit.problem.grid import Grid

#: Angles, degrees, that a report of slopes counts from.
ANGLES = (10.0, 30.0, 45.0)


@attrs.frozen
class Slopes:
    """Steepness of a terrain, from central differences of cell averages.

    Parameters
    ----------
    steepest : largest angle, degrees.
    place : where that is, words such as "x = 2.5, y = 1".
    over : {angle, degrees: share of the cells with data that are steeper, 0 to 1}.
    """

    steepest: float
    place: str
    over: dict[float, float]

    def __str__(self) -> str:
        shares = ", ".join(f"{share:.1%} over {angle:g}" for angle, share in self.over.items())
        return f"steepest {self.steepest:.1f} degrees at {self.place}; {shares} degrees"


@attrs.frozen
class Depressions:
    """Depressions of a terrain: cells from which water cannot leave through their sides without rising first.

    Parameters
    ----------
    count : number of connected depressions.
    volume : water that fills all of them, m^3.
    deepest : largest depth of that water, m.
    """

    count: int
    volume: float
    deepest: float

    def __str__(self) -> str:
        return f"{self.count} depressions hold {self.volume:.4g} m3, up to {self.deepest:.3g} m deep"


def gradient(bottom: np.ndarray, grid: Grid) -> tuple[np.ndarray, np.ndarray]:
    """Return (b_x, b_y), each (ny, nx): central differences, one-sided beside cells without data and at edges.

    Cells without data are NaN in ``bottom`` and 0 in the result.
    """
    parts = []
    for number, axis in enumerate(grid.axes):
        along = 1 - number
        rise = np.diff(bottom, axis=along) / axis.dx
        none = np.full_like(np.take(bottom, [0], axis=along), np.nan)
        before, after = np.concatenate([none, rise], axis=along), np.concatenate([rise, none], axis=along)
        central = np.where(np.isnan(before), after, np.where(np.isnan(after), before, 0.5 * (before + after)))
        parts.append(np.nan_to_num(central))
    return parts[0], parts[1]


def slopes(bottom: np.ndarray, missing: np.ndarray, grid: Grid) -> Slopes:
    """Return how steep the cells with data are."""
    angles = np.degrees(np.arctan(np.hypot(*gradient(bottom, grid))))
    known = angles[~missing]
    cell = int(np.argmax(np.where(missing, -1.0, angles)))
    return Slopes(float(known.max()), grid.located(cell), {angle: float(np.mean(known > angle)) for angle in ANGLES})


def depressions(bottom: np.ndarray, missing: np.ndarray, grid: Grid) -> Depressions:
    """Return depressions; water leaves at the edge of the raster and into cells without data."""
    from scipy import ndimage  # not at the import of the package: it takes longer than all of that

    depth = np.where(missing, 0.0, spill_levels(bottom, missing) - bottom)
    return Depressions(int(ndimage.label(depth > 0.0)[1]), float(depth.sum() * grid.cell_volume), float(depth.max()))


def spill_levels(bottom: np.ndarray, missing: np.ndarray) -> np.ndarray:
    """Return the level (ny, nx) to which each cell fills before it spills, m: its bottom where it is in no depression.

    Source: priority flood, Barnes, Lehman and Mulla (2014), Computers & Geosciences 62; here through the four sides of cells.
    """
    padded = np.pad(missing, 1, constant_values=True)
    ground, seen, width = np.pad(bottom, 1).ravel().tolist(), padded.ravel().tolist(), padded.shape[1]
    beside_none = np.zeros_like(padded)
    beside_none[1:-1, 1:-1] = padded[:-2, 1:-1] | padded[2:, 1:-1] | padded[1:-1, :-2] | padded[1:-1, 2:]
    outlets = ~padded & beside_none
    heap = [(ground[cell], cell) for cell in np.flatnonzero(outlets).tolist()]
    for _, cell in heap:
        seen[cell] = True
    heapify(heap)
    while heap:
        level, cell = heappop(heap)
        for beside in (cell - 1, cell + 1, cell - width, cell + width):
            if not seen[beside]:
                seen[beside] = True
                ground[beside] = max(level, ground[beside])
                heappush(heap, (ground[beside], beside))
    return np.reshape(ground, padded.shape)[1:-1, 1:-1]
