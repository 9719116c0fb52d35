"""CSV tables: named columns with units."""

import csv
from pathlib import Path
from typing import NamedTuple

import numpy as np

from fvkit import validation

#: Conversion factors to SI, {quantity: {unit: factor}}.
UNITS: dict[str, dict[str, float]] = {
    "length": {"m": 1.0, "km": 1000.0, "cm": 0.01, "mm": 0.001},
    "speed": {"m/s": 1.0, "km/h": 1.0 / 3.6},
    "share": {"-": 1.0, "%": 0.01},
    "time": {"s": 1.0, "min": 60.0, "h": 3600.0},
    "discharge": {"m2/s": 1.0},
    "volume rate": {"m3/s": 1.0, "l/s": 1e-3},
}


#: Largest accepted size of a file, bytes.
LARGEST = 10_000_000

#: Range of heights on Earth, m.
EARTH = (-12_000.0, 9_000.0)

#: Codes that programs write for missing values, and the absolute value from which every number counts as such a code.
CODES = (-999.0, -32768.0, -32767.0, 32767.0, *(sign * (10.0**digits - 1.0) for digits in range(4, 11) for sign in (-1.0, 1.0)))
HUGE = 1e19

#: Height over length of a profile that is implausible, as when its columns have the wrong unit: below or above these.
FLAT, STEEP = 1e-3, 2.0

#: Lengths from which a ground that is all but flat is noticed, and the highest number that may be kilometres, m.
LONG, HIGH = 100.0, 9.0


class Columns(NamedTuple):
    """Columns of a CSV file: {column: its unit}, {column: (rows,) numbers in that unit}, and (rows,) line numbers in the file."""

    path: Path
    units: dict[str, str]
    values: dict[str, np.ndarray]
    lines: list[int]

    def ascending(self, name: str, measures: str, otherwise: str) -> np.ndarray:
        """Return a strictly ascending column in SI units, (rows,). A ValueError, as of `in_si` and for a row that does not
        ascend, with its line number and the advice ``otherwise``.
        """
        values = self.in_si(name, measures)
        falls = np.flatnonzero(np.diff(values) <= 0.0)
        if falls.size:
            row = int(falls[0]) + 1
            unit = next(iter(UNITS[measures]))
            raise ValueError(f"{self.path}, line {self.lines[row]}, column `{name}`: {name} must ascend, got {values[row]:.10g} "
                             f"{unit} after {values[row - 1]:.10g} {unit}; {otherwise}")
        return values

    def in_si(self, name: str, measures: str) -> np.ndarray:
        """Return a column in SI units, (rows,); a ValueError for a missing one, or one in a unit of another quantity."""
        if name not in self.values:
            validation.choice(name, f"column of {self.path}", self.values)
        known = UNITS[measures]
        if self.units[name] not in known:
            raise ValueError(f"{self.path}: column `{name}` must be a {measures} in "
                             f"{'one of ' * (len(known) > 1)}{', '.join(known)}; got "
                             f"{name} [{self.units[name]}]")
        return self.values[name] * known[self.units[name]]

    def column(self, name: str, measures: str) -> np.ndarray:
        """Return a column of values in SI units, (rows,): as `in_si`, and a ValueError for a code for a missing value."""
        result, given = self.in_si(name, measures), self.values[name]
        strange = missing(given)
        if measures == "length":
            strange |= (result < EARTH[0]) | (result > EARTH[1])
        if strange.any():
            row = int(np.argmax(strange))
            raise ValueError(f"{self.path}, line {self.lines[row]}, column `{name}`: {given[row]:.10g} looks like a code for a "
                             f"missing value, not like a {measures} in {self.units[name]}: leave the row out, or fill the gap")
        return result


def missing(values: np.ndarray) -> np.ndarray:
    """Return a mask (rows,) of codes for missing values: known codes farther from other values than the range of these."""
    known = np.isin(values, CODES) | (np.abs(values) >= HUGE)
    others = values[~known]
    if not (known.any() and others.size):
        return known
    gap = np.maximum(others.min() - values, values - others.max())
    return known & (gap > np.ptp(others)) & (gap > 0.0)


def implausible(heights: np.ndarray, length: float) -> str:
    """Return what a ground of these heights, m, over a length, m, looks like in the wrong unit: "steep", "flat", or ""."""
    height = float(np.ptp(heights))
    if height > STEEP * length:
        return "steep"
    return "flat" if length >= LONG and 0.0 < height < FLAT * length and np.abs(heights).max() <= HIGH else ""


def text_of(path: Path, largest: int = LARGEST) -> str:
    """Return the text of a UTF-8 file of at most ``largest`` bytes, or raise ValueError or OSError."""
    if not path.is_file():
        raise FileNotFoundError(f"there is no file {path}")
    if path.stat().st_size > largest:
        raise ValueError(f"{path} is larger than {largest / 1e6:g} MB")
    data = path.read_bytes()
    try:
        return data.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        line = data.count(b"\n", 0, error.start) + 1
        raise ValueError(f"{path}, line {line}: this is not UTF-8: save the file in that encoding") from None


def read_columns(path: str | Path) -> Columns:
    """Read the columns of a CSV file, UTF-8, at most 10 MB: commas, decimal points, and a header with units such as
    ``x [m], h [m], phi [-]``. Empty lines and lines that start with ``#`` are ignored.

    A ValueError for an invalid file has file, line and column.
    """
    place = validation.file(path, "path")
    lines = [(number, line) for number, line in enumerate(text_of(place).splitlines(), start=1)
             if line.strip() and not line.lstrip().startswith("#")]
    if len(lines) < 2:
        raise ValueError(f"{place}: a header such as `x [m], phi [-]` and rows of numbers are needed, got "
                         f"{len(lines)} lines")
    units = _header(place, *lines[0])
    names, rows = list(units), []
    for number, line in lines[1:]:
        cells = _cells(place, number, line)
        if len(cells) != len(names):
            raise ValueError(f"{place}, line {number}: {len(names)} values are needed ({', '.join(names)}), got {len(cells)}; "
                             "columns are separated by commas, decimals by points")
        rows.append([_number(cell, f"{place}, line {number}, column `{name}`")
                     for cell, name in zip(cells, names, strict=True)])
    values = np.array(rows).T
    return Columns(place, units, dict(zip(names, values, strict=True)), [number for number, _ in lines[1:]])


def _cells(path: Path, number: int, line: str) -> list[str]:
    try:
        return next(csv.reader([line]))
    except csv.Error as error:
        raise ValueError(f"{path}, line {number}: this is no CSV: {error}") from None


def _header(path: Path, number: int, line: str) -> dict[str, str]:
    units: dict[str, str] = {}
    for cell in _cells(path, number, line):
        name, bracket, rest = cell.strip().partition("[")
        name, unit = name.strip(), rest.strip().removesuffix("]").strip()
        if not name or not bracket or ";" in cell or not rest.strip().endswith("]"):
            raise ValueError(f"{path}, line {number}: a header names columns and units, such as `x [m], phi [-]`, separated by "
                             f"commas; got {validation.shown(cell.strip())}")
        if name in units:
            raise ValueError(f"{path}, line {number}: the column `{name}` is there twice")
        units[name] = unit
    return units


def _number(cell: str, where: str) -> float:
    try:
        value = float(cell)
    except ValueError:
        raise ValueError(f"{where}: this is no number: {validation.shown(cell.strip())}") from None
    if not np.isfinite(value):
        raise ValueError(f"{where}: a finite number is needed, got {validation.shown(cell.strip())}")
    return value
