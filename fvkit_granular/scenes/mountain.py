"""A scene on a terrain: its ground, what leaves through cells without data, and the flow of a release."""

from typing import Any

import attrs
import numpy as np

from fvkit import validation
from fvkit_granular.sources.rain import Drain
from fvkit_granular.terrain.release import Release
from fvkit_granular.terrain.terrain import Terrain

#: What cells without data are: an outlet, which takes all that reaches it, or a wall.
GAPS = ("outlet", "wall")

#: Height of a wall above the highest ground, m; rate at which an outlet empties its cells, 1/s.
WALL, EMPTYING = 1000.0, 1e9

#: Width of the outlet along its edge, cells: the distance that a step can cross.
REACH = 2


class Corners(tuple[Any, ...]):
    """Corners that a scene has taken from its terrain: `attrs.evolve` takes them anew."""


class Ground(np.ndarray):
    """A bottom that a scene has taken from its terrain: `attrs.evolve` takes it anew."""


def corners(terrain: Terrain) -> Corners:
    """Return the corners ((x0, y0), (x1, y1)) of a terrain, m."""
    x, y = terrain.grid.axes
    return Corners(((x.lower, y.lower), (x.upper, y.upper)))


def ground(terrain: Terrain, gaps: str) -> Ground:
    """Return the bottom of a scene on a terrain, see `heights`."""
    return heights(terrain, gaps).view(Ground)


def heights(terrain: Terrain, gaps: str) -> np.ndarray:
    """Return the elevation of every cell, (ny, nx), m: without data that of the nearest cell with data, or the top of a wall.

    Cells of an outlet have the lowest of their neighbours with data, so that mirror images stay mirror images.
    """
    if not terrain.missing.any():
        return np.asarray(terrain.bottom)
    if gaps == "wall":
        return np.where(terrain.missing, terrain.range[1] + WALL, terrain.bottom)
    from scipy.ndimage import distance_transform_edt

    known = np.where(terrain.missing, np.inf, terrain.bottom)
    for _ in range(REACH + 1):
        known = np.where(np.isinf(known), _lowest_beside(known), known)
    nearest = distance_transform_edt(np.isinf(known), return_distances=False, return_indices=True)
    return np.asarray(known[tuple(nearest)])


def _lowest_beside(values: np.ndarray) -> np.ndarray:
    """The lowest of the four neighbours of each cell."""
    wide = np.pad(values, 1, constant_values=np.inf)
    return np.minimum(np.minimum(wide[2:, 1:-1], wide[:-2, 1:-1]), np.minimum(wide[1:-1, 2:], wide[1:-1, :-2]))


def outlet(terrain: Terrain, gaps: str) -> tuple[Drain, ...]:
    """Return the drain of the cells without data beside those with data; none without such cells, or if they are walls."""
    if gaps == "wall" or not terrain.missing.any():
        return ()
    from scipy.ndimage import binary_dilation

    beside = binary_dilation(~terrain.missing, np.ones((3, 3)), REACH) & terrain.missing
    rate: Any = np.where(beside, EMPTYING, 0.0)
    return (Drain(rate),)


def no_flow(x: np.ndarray, y: np.ndarray) -> dict[str, Any]:
    """Dry ground."""
    return {"h": 0.0 * (x + y), "phi": 0.0}


@attrs.frozen(eq=False)
class ReleasedFlow:
    """The flow of a `Release` at rest: its thickness, and its solid fraction or else ``phi``, anywhere on its terrain."""

    release: Release
    phi: float | None

    def __attrs_post_init__(self) -> None:
        if self.release.phi is None and self.phi is None:
            raise ValueError("`phi`, the solid fraction of the release, must be given: gr.Scene(..., phi=0.6), or "
                             "`solid_fraction` of gr.read_release; 1 is dry, 0 is water")

    def __call__(self, x: np.ndarray, y: np.ndarray) -> dict[str, Any]:
        here = self.release.terrain.grid.index(x, y)
        phi = self.phi if self.release.phi is None else self.release.phi[here]
        return {"h": self.release.thickness[here], "phi": phi}


def check_release(release: Any, terrain: Terrain) -> Release:
    """Return a release, or raise where it is not one on the cells of the terrain."""
    given: Release = validation.instance(release, "release", Release, "such as gr.read_release(\"release.geojson\", terrain)")
    if given.terrain.grid != terrain.grid:
        raise ValueError(f"`release` must lie on the terrain of the scene, {terrain!r}, got one on {given.terrain!r}: read it "
                         "again with this terrain")
    return given
