"""Values that an argument must refuse, by what the argument is: (value, type of the error)."""

from collections import UserDict
from fractions import Fraction

import numpy as np

import fvkit as fv


class Unshowable:
    """An object that cannot even be shown."""

    def __repr__(self):
        raise RuntimeError("no")


class Series:
    """A column as pandas has it: array-like, without being an array."""

    ndim = 1

    def __init__(self, values):
        self.values = np.array(values)
        self.shape = self.values.shape

    def __array__(self, dtype=None, copy=None):
        return np.array(self.values, dtype=dtype)

    def __len__(self):
        return len(self.values)

    def __iter__(self):
        return iter(self.values)

    def __float__(self):
        return float(self.values[0])


HUGE = 10**400
NO_NUMBERS = ("1", "", b"1", True, np.True_, 1j, np.complex128(1.0), [1.0, 2.0], [[1.0], [1.0, 2.0]], np.ones(2), np.ones((1, 1)),
              np.array("1"), np.array(True), np.array(2j), {}, set(), object, Unshowable(), Series([1.0]), np.ma.masked,
              np.ma.array(1.0, mask=True), np.timedelta64(1, "s"), np.array(None, dtype=object), Ellipsis, slice(2))
NOT_FINITE = (np.nan, np.inf, -np.inf, np.float32("nan"), HUGE, -HUGE, np.array(np.nan))


def _is_row(value):
    """Whether a value is a row of real numbers, or more than one."""
    if isinstance(value, list):
        return all(isinstance(item, float) for item in value)
    return isinstance(value, Series) or (isinstance(value, np.ndarray) and value.ndim > 0)


def typed(*values):
    """Pair wrong types with TypeError."""
    return [(value, TypeError) for value in values]


def valued(*values):
    """Pair wrong values with ValueError."""
    return [(value, ValueError) for value in values]


NUMBER = typed(*NO_NUMBERS) + valued(*NOT_FINITE)
#: A field over the grid is a number too, or a row of them, or a function.
FIELD = [item for item in NUMBER if not _is_row(item[0])]
NONE = typed(None)
NOT_POSITIVE = valued(0.0, -0.0, -1.0, -5e-324, 0, -3, np.int64(-1), Fraction(-1, 3))
NEGATIVE = valued(-1.0, -5e-324, np.float32(-2.0))
NO_COUNTS = typed("5", 2.5, 5.0, True, np.True_, np.nan, np.inf, 1j, [5], (5,), np.array([5]), np.float64(3.0), {}, b"5", object,
                  Unshowable())
NO_FLAGS = typed("no", "", 0, 1, 2.0, None, [], [True], np.array([True]), Unshowable())
NO_NAMES = valued("nonsense", "", 7, None, True, np.nan, [], ["a"], np.array(["a", "b"]), {}, b"hll", object, Unshowable())
NO_PARTS = typed(None, 5, "roe", [], {}, np.ones(3), object, Unshowable(), fv.Grid, fv.Grid(0.0, 1.0, 2), lambda x: x)
NO_FUNCTIONS = typed(5, "sin", [], {}, np.ones(3), Unshowable())
NO_ARRAYS = typed("ab", b"12", ["1", "2"], [True, False], [None], np.array([1.0, None], dtype=object), [[1.0], [1.0, 2.0]], {},
                  np.ma.array([1.0, 2.0], mask=[True, False]), np.array([1j]), object, np.array(["2020"], dtype="M8[Y]"), Unshowable())
NO_FINITE_ARRAYS = valued([np.nan], [0.5, np.inf], [HUGE])
NO_FILES = typed(None, 5, 2.5, b"run.npz", [], np.ones(2), object) + valued("", "a\0b.npz")
NO_TEXTS = typed(None, 5, b"name", [], ["name"], Unshowable())
NO_PAIRS = valued(None, 5, "01", [], (1.0,), (0.0, 1.0, 2.0), np.zeros((2, 2)), {0: 1.0, 1: 2.0}, np.array(3.0), Unshowable(),
                  (1.0, 0.0), (1.0, 1.0), (0.0, np.inf), (np.nan, 1.0), (-np.inf, 0.0)) + typed(
                      ("0", "1"), (0.0, None), [[0.0], [1.0]], (True, 2.0))
NO_MAPPINGS = typed(None, 5, "h", [], ["h"], np.ones(2), Unshowable())
NO_LISTS = typed(5, "ab", b"ab", np.array(3.0), {}, 2.5, Unshowable())

#: Every kind of argument. The letter ? at the end of a kind in the table of calls says that None is allowed too.
KINDS = {
    "number": NUMBER + NONE,
    "number or pair": [case for case in NUMBER + NONE if not (isinstance(case[0], list) and case[0] == [1.0, 2.0])],
    "positive": NUMBER + NONE + NOT_POSITIVE,
    "not negative": NUMBER + NONE + NEGATIVE,
    "field not negative": FIELD + NONE + NEGATIVE,
    "positive field": FIELD + NONE + NOT_POSITIVE,
    "share": NUMBER + NONE + NEGATIVE + valued(1.0 + 1e-15, 2, 50),
    "open share": NUMBER + NONE + NOT_POSITIVE + valued(1.0, 1, 2),
    "courant": NUMBER + NONE + NOT_POSITIVE + valued(1.01, 2),
    "count": NO_COUNTS + NONE + valued(0, -3, np.int64(-1), -HUGE, HUGE, 2**62, 2**63),
    "count from 0": NO_COUNTS + NONE + valued(-3, np.int64(-1), HUGE),
    "flag": NO_FLAGS,
    "name": NO_NAMES,
    "order": valued(0, 3, -1, "2", True, None, 1.5, np.nan, [3], {}),
    "part": NO_PARTS,
    "function": NO_FUNCTIONS + NONE,
    "array": NO_ARRAYS + NO_FINITE_ARRAYS,
    "file": NO_FILES,
    "text": NO_TEXTS,
    "pair": NO_PAIRS,
    "mapping": NO_MAPPINGS,
    "list": NO_LISTS,
    "times": NO_ARRAYS + NO_FINITE_ARRAYS
    + valued([], [0.2, 0.1], [0.1, 0.1], [-1.0], [9.0], np.zeros((2, 2))) + typed(UserDict()),
    "state of 4": typed(None, 5, "wet!", {}, Unshowable(), ("1", 0.5, 0.0, 0.0), (True, 0.5, 0.0, 0.0), (1j, 0.5, 0.0, 0.0))
    + valued((), (1.0, 0.5), (1.0, 0.5, 0.0, 0.0, 0.0), (np.nan, 0.5, 0.0, 0.0), (-1.0, 0.5, 0.0, 0.0), (1.0, 1.5, 0.0, 0.0), (1.0, 0.5, np.inf, 0.0),
             (HUGE, 0.5, 0.0, 0.0)),
    "state of 3": typed(None, 5, "wet", {}, Unshowable(), ("1", 0.5, 0.0))
    + valued((), (1.0, 0.5), (1.0, 0.5, 0.0, 0.0), (np.nan, 0.5, 0.0), (-1.0, 0.5, 0.0), (1.0, -0.5, 0.0), (1.0, 0.5, np.inf)),
    "state of 2": typed(None, 5, "ab", {}, Unshowable(), ("1", 0.5)) + valued((), (1.0,), (1.0, 0.5, 0.0), (np.nan, 0.5), (-1.0, 0.5), (1.0, np.inf)),
}

KINDS |= {
    "array or file": [(value, ValueError if isinstance(value, str) else error) for value, error in KINDS["array"]],  # a text is a path
    "grid": [(value, error) for value, error in NO_PARTS if not isinstance(value, fv.Grid)],
    "parts": typed(None, 5, "roe", np.ones(3), object, Unshowable(), fv.Grid, [None], ["drag"]),
    "side": typed(None, 5, "wall", object, Unshowable(), fv.Outflow, (None, None), ("wall", "wall")) + valued([], [fv.Outflow()] * 3, (fv.Periodic(), fv.Outflow())),
    "functions": typed(5, None, [5], [None], ["print"], Unshowable()),
    "names": typed(5, None, [5], [None], b"h", Unshowable()) + valued("biggest.h", "maxi.h"),
    "executor": typed(5, "threads", [], object(), Unshowable()),
    "values": [(value, error) for value, error in NO_ARRAYS + NO_FINITE_ARRAYS if value is not object] + valued(np.zeros((7, 2)), []),
    "ascending": NO_ARRAYS + NO_FINITE_ARRAYS + valued([], [0.2, 0.1], [0.1, 0.1], [-1.0], np.zeros((2, 2))),
    "widths": typed(None, 5, "wide", {}, ("1", 0.1, 0.1, 0.1), (True, 0.1, 0.1, 0.1)) + valued((), (0.1,), (-0.1, 0.1, 0.1, 0.1), (np.nan, 0.1, 0.1, 0.1)),
    "scene": typed(None, 5, [], {}, Unshowable(), np.ones(2)) + valued("riemannn", "", "a/b", "mine.tom"),
    "solution": typed(None, 5, "stoker", [], {}, object(), Unshowable()),
}


def wrong(kind):
    """Return the (value, type of the error) that an argument of this kind refuses; ``kind?`` takes None."""
    name = kind.removesuffix("?")
    return [(value, error) for value, error in KINDS[name] if not (kind.endswith("?") and value is None)]
