"""`Samples`: parameters of every member of a sweep."""

from collections.abc import Iterable, Mapping
from itertools import product
from typing import Any

import attrs
import numpy as np

from fvkit import validation


def _values(given: Any) -> dict[str, np.ndarray]:
    columns = {name: _column(given[name], name) for name in _names(given, "values")}
    lengths = {name: len(column) for name, column in columns.items()}
    if len(set(lengths.values())) > 1:
        raise ValueError("given samples need as many values of every parameter, got "
                         + ", ".join(f"{count} of {name}" for name, count in lengths.items())
                         + "; for all combinations use fv.Samples.grid")
    return columns


def _axes(given: Any) -> dict[str, np.ndarray]:
    if isinstance(given, Mapping) and not given:
        return {}
    return {name: _column(given[name], name) for name in _names(given, "axes")}


@attrs.frozen(eq=False, repr=False)
class Samples:
    """The parameters of every member of a sweep; made by `latin_hypercube`, `grid` or `given`.

    Parameters
    ----------
    values : {parameter: (members,)}, numbers or strings.
    axes : of a grid, {parameter: its values}, the last one fastest; empty for other samples.

    Examples
    --------
    >>> import fvkit as fv
    >>> samples = fv.Samples.grid({"gamma": [0.3, 0.5], "cells": [100, 200]})
    >>> len(samples), samples[3]
    (4, {'gamma': 0.5, 'cells': 200})
    """

    values: Mapping[str, np.ndarray] = attrs.field(converter=_values)
    axes: Mapping[str, np.ndarray] = attrs.field(factory=dict, converter=_axes)

    def __repr__(self) -> str:
        ranges = (f"{name} {np.min(values)} .. {np.max(values)}" if np.issubdtype(values.dtype, np.number) else
                  f"{name} {', '.join(dict.fromkeys(map(str, values)))}" for name, values in self.values.items())
        return f"<Samples: {len(self)} members{' of a grid' if self.axes else ''}; {'; '.join(ranges)}>"

    @classmethod
    def latin_hypercube(cls, ranges: Mapping[str, Any], members: int, seed: int = 0) -> "Samples":
        """Return random samples, one in each of ``members`` equally likely slices of every parameter.

        Parameters
        ----------
        ranges : {parameter: (lower, upper)} uniform between the two, (lower, upper, ``"log"``) uniform in the logarithm,
            or a distribution with a method ``ppf``, such as those of scipy.stats.
        members : number of samples, >= 1.
        seed : the same seed gives the same samples.

        Raises
        ------
        ValueError, TypeError
            For an invalid range.

        Notes
        -----
        Source: McKay, Beckman, Conover, Technometrics 21 (1979) 239-245; the code is scipy's.
        """
        from scipy.stats import qmc  # half a second that other imports of fvkit need not wait for

        names = _names(ranges, "ranges")
        count = validation.whole(members, "members", at_least=1)
        validation.fits_memory(count, 4 * len(names), "members")
        sampler = qmc.LatinHypercube(len(names), rng=np.random.default_rng(validation.whole(seed, "seed", at_least=0)))
        shares = sampler.random(count).T
        return cls({name: _spread(name, ranges[name], share) for name, share in zip(names, shares, strict=True)})

    @classmethod
    def grid(cls, axes: Mapping[str, Iterable[Any]]) -> "Samples":
        """Return every combination of the values {parameter: values}, the last parameter fastest."""
        known = {name: _column(axes[name], name) for name in _names(axes, "axes")}
        columns = zip(*product(*(column.tolist() for column in known.values())), strict=True)
        return cls({name: np.array(column) for name, column in zip(known, columns, strict=True)}, known)

    @classmethod
    def given(cls, values: Mapping[str, Iterable[Any]]) -> "Samples":
        """Return the samples {parameter: one value per member}."""
        return cls(values)

    def __len__(self) -> int:
        return len(next(iter(self.values.values())))

    def __getitem__(self, member: int) -> dict[str, Any]:
        """Return the parameters of one member, {name: value}."""
        return {name: column[member].item() for name, column in self.values.items()}


def _names(given: Any, argument: str) -> list[str]:
    if not isinstance(given, Mapping) or not given or not all(isinstance(name, str) for name in given):
        raise TypeError(f"`{argument}` must be a non-empty mapping of names of parameters, such as {{'gamma': [0.3, 0.5]}}, got "
                        f"{validation.shown(given)}")
    return list(given)


def _column(values: Any, name: str) -> np.ndarray:
    try:
        column = np.array([values] if isinstance(values, str) or not isinstance(values, Iterable) else list(values))
    except ValueError:  # rows of different lengths
        column = np.empty((0, 0))
    if column.ndim != 1 or not column.size or column.dtype.kind not in "biufU":
        raise TypeError(f"`{name}` must be a non-empty list of numbers or of names, got {validation.shown(values)}")
    if column.dtype.kind == "f":
        validation.array(column, name)
    return column


def _spread(name: str, given: Any, share: np.ndarray) -> np.ndarray:
    """The quantiles ``share`` of one range."""
    if callable(getattr(given, "ppf", None)):
        return np.asarray(given.ppf(share), dtype=float)
    if not isinstance(given, (tuple, list)) or len(given) not in (2, 3) or given[2:] not in ((), [], ("log",), ["log"]):
        raise ValueError(f"`{name}` must be (lower, upper), (lower, upper, 'log') or a distribution with a method ppf, "
                         f"got {validation.shown(given)}")
    log = len(given) == 3
    low = validation.real(given[0], f"{name}[0]", above=0.0 if log else None)
    high = validation.real(given[1], f"{name}[1]", above=low)
    return low * (high / low) ** share if log else low + (high - low) * share
