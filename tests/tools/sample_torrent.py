"""The made-up terrain and release of the sample `sample-torrent`.

    python -m tests.tools.sample_torrent [FOLDER]

Writes terrain.asc and release.geojson, those of fvkit_granular/scenes/samples/torrent without a FOLDER. A valley falls from west to
east along an exponential profile; its channel bends twice and ends at the apex of a fan, a cone of the same profile. 250 x 150 cells
of 10 m, elevations to 0.1 m. No place on Earth; licence: that of the project, BSD 3-Clause.
"""

import json
import sys
from pathlib import Path

import numpy as np

FOLDER = Path(__file__).parents[2] / "fvkit_granular" / "scenes" / "samples" / "torrent"

#: Cells along x and y, and their length, m; where the channel ends in a fan, m.
CELLS, CELL, APEX = (250, 150), 10.0, 1500.0

#: Corners of the release, m: a bowl at the head of the channel.
RELEASE = [(90, 760), (130, 790), (210, 800), (250, 770), (240, 720), (180, 700), (110, 715), (90, 760)]


def profile(distance):
    """Elevation along the channel, m: 35 degrees steep at its head, 2 degrees at the end."""
    return 380.0 + 25.0 * (1.0 - distance / 2500.0) + 480.0 * np.exp(-distance / 700.0)


def channel(x):
    """The y of the channel at x, m: two bends between its head and the fan."""
    return 750.0 + 170.0 * np.sin(2.0 * np.pi * (x - 350.0) / 1150.0) * smooth(x, 350.0, 550.0) * smooth(-x, -APEX, -1300.0)


def smooth(x, lower, upper):
    """0 below lower, 1 above upper, smooth between."""
    share = np.clip((x - lower) / (upper - lower), 0.0, 1.0)
    return share * share * (3.0 - 2.0 * share)


def elevation(x, y):
    """Elevation of the ground, m."""
    fan = smooth(x, APEX - 200.0, APEX + 200.0)
    beside = np.abs(y - channel(x))
    along = x + fan * (np.hypot(np.maximum(x - APEX, 0.0), y - 750.0) + np.minimum(x, APEX) - x)
    bed = 14.0 * smooth(beside, 15.0, 55.0) + 0.45 * np.maximum(beside - 55.0, 0.0) ** 0.93
    return profile(along) + (1.0 - fan) * np.minimum(bed, 150.0 + 0.1 * beside) + 3.0 * np.sin(x / 67.0) * np.sin(y / 53.0) * (1.0 - fan) \
        * smooth(beside, 40.0, 120.0)


def main(folder=FOLDER):
    nx, ny = CELLS
    x, y = np.meshgrid((np.arange(nx) + 0.5) * CELL, (np.arange(ny) + 0.5) * CELL)
    heights = elevation(x, y)[::-1]  # files begin in the north
    rows = "\n".join(" ".join(f"{height:.1f}" for height in row) for row in heights)
    (folder / "terrain.asc").write_text(f"ncols {nx}\nnrows {ny}\nxllcorner 0\nyllcorner 0\ncellsize {CELL:g}\nNODATA_value -9999\n{rows}\n")
    head = {"type": "Feature", "properties": {"name": "head of the channel", "thickness": 2.5, "phi": 0.55},
            "geometry": {"type": "Polygon", "coordinates": [RELEASE]}}
    (folder / "release.geojson").write_text(json.dumps({"type": "FeatureCollection", "features": [head]}, indent=1) + "\n")


if __name__ == "__main__":
    main(*map(Path, sys.argv[1:]))
