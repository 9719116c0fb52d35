"""`Profile`: a column of a CSV file as a shape."""

import warnings
from pathlib import Path
from typing import Any

import attrs
import numpy as np

from fvkit import validation
from fvkit_granular.csv_table import UNITS, implausible, read_columns
from fvkit_granular.scenes.shapes import Shape

INTERPOLATIONS = ("linear", "constant")


@attrs.frozen
class Profile(Shape):
    """Profile from a CSV file: one column over another, as a shape. `Profile.read` makes it.

    Parameters
    ----------
    path : the file.
    column : name of the column.
    along : name of the column of x.
    interpolation : ``"linear"``: straight lines between rows; ``"constant"``: the value of a row holds up to the next one.
    x : (rows,) ascending, m.
    values : (rows,) in SI units.

    Examples
    --------
    >>> import fvkit_granular as gr
    >>> valley = gr.Profile("valley.csv", "elevation", "distance", "linear", x=[0.0, 100.0], values=[50.0, 20.0])
    >>> valley([0.0, 50.0, 75.0])
    array([50. , 35. , 27.5])
    """

    path: Path
    column: str
    along: str
    interpolation: str = attrs.field(converter=lambda value: validation.choice(value, "interpolation", INTERPOLATIONS))
    x: np.ndarray = attrs.field(repr=False, eq=attrs.cmp_using(eq=np.array_equal))
    values: np.ndarray = attrs.field(repr=False, eq=attrs.cmp_using(eq=np.array_equal))

    @classmethod
    def read(cls, path: str | Path, column: str, interpolation: str, along: str = "x", measures: str = "length",
             over: Any = None) -> "Profile":
        """Return the profile of a CSV file.

        Parameters
        ----------
        path : the file, UTF-8, at most 10 MB: commas, points in decimals, a header such as ``x [m], b [m]``.
        column : name of the column, without its unit.
        interpolation : ``"linear"`` or ``"constant"``.
        along : name of the column of x, ascending.
        measures : quantity of the column: ``"length"``, ``"speed"`` or ``"share"``.
        over : with two axes the coordinate that it varies over, see ``gr.shapes.Shape``.

        Raises
        ------
        ValueError
            With file, line and column.
        FileNotFoundError
            Where there is no such file.
        """
        table = read_columns(path)
        x = table.ascending(along, "length", "for a jump put two rows close together")
        values = table.column(column, validation.choice(measures, "measures", UNITS))
        return cls(table.path, column, along, interpolation, x, values, over=over)

    def warn_of_units(self, interval: tuple[float, float] | None = None) -> None:
        """Warn if the values of a bottom suggest another unit than that of the header, or its length that of an interval."""
        if interval is not None and 500.0 * (interval[1] - interval[0]) < np.ptp(self.x):
            warnings.warn(f"{self.path}: the profile is {np.ptp(self.x):.4g} m long and `interval` "
                          f"{interval[1] - interval[0]:.4g} m: if that is in kilometres, give it in m",
                          RuntimeWarning, stacklevel=2)
        length, height = float(np.ptp(self.x)), float(np.ptp(self.values))
        looks = implausible(self.values, length)
        if looks == "steep":
            advice, header = f"if {self.along} is in kilometres, or `{self.column}` in centimetres or millimetres", self.along
        elif looks == "flat":
            advice, header = f"if `{self.column}` is in kilometres", self.column
        else:
            return
        warnings.warn(f"{self.path}: the bottom `{self.column}` varies by {height:.4g} m over {length:.4g} m of {self.along}: "
                      f"{advice}, say so in the header, such as `{header} [km]`", RuntimeWarning, stacklevel=2)

    def values_at(self, x: Any) -> np.ndarray:
        points = np.asarray(x, dtype=float)
        if points.size and (points.min() < self.x[0] or points.max() > self.x[-1]):
            raise ValueError(f"{self.path}: column `{self.column}` covers {self.along} from {self.x[0]:.10g} to "
                             f"{self.x[-1]:.10g} m, but x from {points.min():.10g} to {points.max():.10g} m is needed: add "
                             "rows, or shorten `interval`")
        if self.interpolation == "linear":
            return np.interp(points, self.x, self.values)
        return self.values[np.searchsorted(self.x, points, side="right") - 1]
