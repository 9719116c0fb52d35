"""Small terrains for the tests: made here, so that each number is known."""

import numpy as np

import fvkit as fv
import fvkit_granular as gr

#: WKT of EPSG:31287, as GDAL writes it.
LAMBERT = (
    'PROJCS["MGI / Austria Lambert",GEOGCS["MGI",DATUM["Militar-Geographische_Institut",SPHEROID["Bessel 1841",'
    '6377397.155,299.1528128,AUTHORITY["EPSG","7004"]],AUTHORITY["EPSG","6312"]],PRIMEM["Greenwich",0,'
    'AUTHORITY["EPSG","8901"]],UNIT["degree",0.0174532925199433,AUTHORITY["EPSG","9122"]],AUTHORITY["EPSG","4312"]],'
    'PROJECTION["Lambert_Conformal_Conic_2SP"],PARAMETER["latitude_of_origin",47.5],PARAMETER["central_meridian",'
    '13.3333333333333],PARAMETER["standard_parallel_1",49],PARAMETER["standard_parallel_2",46],'
    'PARAMETER["false_easting",400000],PARAMETER["false_northing",400000],UNIT["metre",1,AUTHORITY["EPSG","9001"]],'
    'AXIS["Northing",NORTH],AXIS["Easting",EAST],AUTHORITY["EPSG","31287"]]')


def ramp(nx=8, ny=6, cell=5.0, corner=(1000.0, 2000.0), slope=(-0.5, 0.25), missing=(), **more):
    """Return a plane of the given slope (b_x, b_y), 500 m high at its lower corner, without data in the cells (row, column)."""
    x0, y0 = corner
    grid = fv.Grid(corner, (x0 + nx * cell, y0 + ny * cell), (nx, ny))
    x, y = np.meshgrid(*(axis.centers for axis in grid.axes))
    bottom = 500.0 + slope[0] * (x - x0) + slope[1] * (y - y0)
    for where in missing:
        bottom[where] = np.nan
    return gr.Terrain(grid, bottom, **more)
