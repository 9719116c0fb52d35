"""Small terrains for the tests: made here, so that each number is known."""

import numpy as np

import fvkit as fv
import fvkit_granular as gr

#: The end of a WKT that names EPSG:31287, of which no test needs more.
LAMBERT = 'PROJCS["MGI / Austria Lambert",UNIT["metre",1],AUTHORITY["EPSG","31287"]]'


def ramp(nx=8, ny=6, cell=5.0, corner=(1000.0, 2000.0), slope=(-0.5, 0.25), missing=(), **more):
    """Return a plane of the given slope (b_x, b_y), 500 m high at its lower corner, without data in the cells (row, column)."""
    x0, y0 = corner
    grid = fv.Grid(corner, (x0 + nx * cell, y0 + ny * cell), (nx, ny))
    x, y = np.meshgrid(*(axis.centers for axis in grid.axes))
    bottom = 500.0 + slope[0] * (x - x0) + slope[1] * (y - y0)
    for where in missing:
        bottom[where] = np.nan
    return gr.Terrain(grid, bottom, **more)
