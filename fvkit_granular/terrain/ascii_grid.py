"""ESRI ASCII rasters (``.asc``): reading with a sentence for each mistake, and writing that keeps every bit."""

import re
from math import isnan
from pathlib import Path

import numpy as np

from fvkit import validation
from fvkit.problem.grid import Grid
from fvkit_granular.csv_table import text_of
from fvkit_granular.terrain import crs
from fvkit_granular.terrain.raster import NODATA, Raster, placed, without

#: Largest accepted size of a file, bytes.
LARGEST = 2_000_000_000

KEYS = ("ncols", "nrows", "xllcorner", "xllcenter", "yllcorner", "yllcenter", "cellsize", "dx", "dy", "nodata_value", "nodata")
HEADER = re.compile(r"\s*(?!nan\b|inf)([a-z_]\w*)[^\S\n]+(\S+)[^\S\n]*(?:\n|$)", re.IGNORECASE)
EXAMPLE = "ncols, nrows, xllcorner, yllcorner, cellsize and NODATA_value, each with its number on a line"


def read(path: Path) -> Raster:
    """Return the raster of an ESRI ASCII file, and the CRS of the ``.prj`` file beside it.

    Keys may have any case and order; decimals points or commas. ValueError names file and line, or key.
    """
    text = text_of(path, LARGEST)
    header, end = _header(path, text)
    shape = (_count(path, header, "nrows"), _count(path, header, "ncols"))
    size = _cell(path, header)
    corner = tuple(_corner(path, header, letter, size) for letter in "xy")
    values = _numbers(path, text, end, shape)
    code = next((_real(path, header, key) for key in ("nodata_value", "nodata") if key in header), NODATA)
    strange = np.isinf(values) if isnan(code) else ~np.isfinite(values)
    if strange.any():
        which = int(np.argmax(strange))
        raise ValueError(f"{path}, line {_line(text, end, which)}: numbers must be finite, got {values[which]}: for no "
                         "data, write the number that NODATA_value names")
    values = without(values, code)
    grid = placed((corner[0], corner[1]), (size, size), shape)
    return Raster(path, grid, values.reshape(shape)[::-1], crs.read_beside(path))


def _header(path: Path, text: str) -> tuple[dict[str, str], int]:
    """Return the header, {key in small letters: text}, and where it ends."""
    header: dict[str, str] = {}
    end = 0
    while found := HEADER.match(text, end):
        key = found[1].lower()
        line = text.count("\n", 0, found.start(1)) + 1
        if key not in KEYS:
            raise ValueError(f"{path}, line {line}: a header has {EXAMPLE}, got the key {validation.shown(found[1])}")
        if key in header:
            raise ValueError(f"{path}, line {line}: the key {key} must be there once, got it again")
        header[key], end = found[2], found.end()
    return header, end


def _real(path: Path, header: dict[str, str], key: str, among: str = "") -> float:
    if key not in header:
        raise ValueError(f"{path}: the header must have {among or key}, got {', '.join(header) or 'no header'}: an ESRI ASCII "
                         f"raster begins with {EXAMPLE}")
    try:
        value = float(header[key].replace(",", "."))
    except ValueError:
        raise ValueError(f"{path}: {key} must be a number, got {validation.shown(header[key])}") from None
    if not np.isfinite(value) and not key.startswith("nodata"):
        raise ValueError(f"{path}: {key} must be finite, got {header[key]}")
    return value


def _count(path: Path, header: dict[str, str], key: str) -> int:
    value = _real(path, header, key)
    if value != int(value) or not 1 <= value <= validation.MOST:
        raise ValueError(f"{path}: {key} must be a whole number >= 1, got {validation.shown(header[key])}")
    return int(value)


def _cell(path: Path, header: dict[str, str]) -> float:
    if "cellsize" in header:
        size = other = _real(path, header, "cellsize")
    else:
        size, other = (_real(path, header, key, "cellsize") for key in ("dx", "dy"))
    if not (size > 0.0 and other > 0.0):
        raise ValueError(f"{path}: cellsize must be > 0, got {min(size, other):g}")
    if abs(size - other) > 1e-6 * size:
        raise ValueError(f"{path}: cells of an ESRI ASCII raster must be square, got dx = {size:.10g} and dy = {other:.10g}: "
                         "resample it, with `gdalwarp -tr` for example, or give it as a GeoTIFF")
    return size


def _corner(path: Path, header: dict[str, str], letter: str, size: float) -> float:
    corner, center = f"{letter}llcorner", f"{letter}llcenter"
    if corner in header and center in header:
        raise ValueError(f"{path}: the header must have one of {corner} and {center}, got both")
    if center in header:
        return _real(path, header, center) - 0.5 * size
    return _real(path, header, corner, f"{corner} or {center}")


def _numbers(path: Path, text: str, end: int, shape: tuple[int, int]) -> np.ndarray:
    body = text[end:]
    if "," in body:
        if "." in body:
            raise ValueError(f"{path}: decimals must have points or commas, got both: remove separators of thousands")
        body = body.replace(",", ".")
    tokens, needed = body.split(), shape[0] * shape[1]
    try:
        values = np.array(tokens, dtype=float)
    except ValueError:
        bad = next(k for k, token in enumerate(tokens) if not _is_number(token))
        where = f"{path}, line {_line(text, end, bad)}"
        raise ValueError(f"{where}: a number is needed, got {validation.shown(tokens[bad])}") from None
    if len(values) != needed:
        line = _line(text, end, min(len(values), needed))
        said = "the file ends too early, at" if len(values) < needed else "more numbers follow in"
        raise ValueError(f"{path}: nrows x ncols = {shape[0]} x {shape[1]} = {needed} numbers are needed, got {len(values)}: "
                         f"{said} line {line}")
    lines = [line for line in body.split("\n") if line.strip()]
    if shape[0] != shape[1] and len(lines) == shape[1] and len(lines[0].split()) == len(lines[-1].split()) == shape[0]:
        raise ValueError(f"{path}: ncols x nrows must be the shape of the numbers, got {shape[1]} x {shape[0]} for {len(lines)} "
                         f"lines of {shape[0]} numbers: exchange ncols and nrows")
    return values


def _is_number(token: str) -> bool:
    try:
        float(token)
    except ValueError:
        return False
    return True


def _line(text: str, end: int, which: int) -> int:
    """Return the line of the number ``which``, counted from 0 after the header, or the last line of the file."""
    start, last = text.count("\n", 0, end) + 1, 0
    for number, line in enumerate(text[end:].rstrip().split("\n"), start):
        which -= len(line.split())
        last = number
        if which < 0:
            break
    return last


def text_of_raster(values: np.ndarray, grid: Grid) -> str:
    """Return an ESRI ASCII file as a text: y descending, NaN as the code for no data, numbers that read back to the same bits."""
    x, y = grid.axes
    if abs(x.dx - y.dx) > 1e-6 * x.dx:
        raise ValueError(f"cells of an ESRI ASCII raster must be square, got {x.dx:.10g} x {y.dx:.10g} m: write a GeoTIFF")
    code = f"{NODATA:g}"
    rows = (" ".join([code if value != value else repr(value) for value in row]) for row in values[::-1].tolist())
    return "\n".join([f"ncols {x.num_cells}", f"nrows {y.num_cells}", f"xllcorner {x.lower!r}", f"yllcorner {y.lower!r}",
                      f"cellsize {x.dx!r}", f"NODATA_value {code}", *rows, ""])
