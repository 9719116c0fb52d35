"""`HazardMaps`: maxima of depth, speed and pressure, arrival and duration, for ``observers`` of `fvkit.solve`."""

from collections.abc import Mapping
from typing import Any

import attrs
import numpy as np

from fvkit import Observer, Problem
from fvkit.problem.directions import observables
from fvkit.problem.relief import Slopes
from fvkit.validation import number
from fvkit_granular.sources.plausible import caution

#: Slope, the tangent of 60 degrees, up to which a flow counts as following the ground: down a cliff it falls freely.
STEEPEST = 3.0**0.5

#: Plausible densities, kg/m^3: powder snow, and more than any rock.
LIGHTEST, HEAVIEST = 10.0, 10_000.0

#: Maps, with the value of a cell that no flow reached.
MAPS = {"depth": 0.0, "speed": 0.0, "pressure": 0.0, "phi": np.nan, "arrival": np.inf, "duration": 0.0}


@attrs.define(eq=False)
class HazardMaps(Observer):
    """Hazard maps: the largest depth, speed and dynamic pressure in each cell, first arrival and duration, at every step.

    Speed is that of the mass, (hs vs + gamma hf vf)/(hs + gamma hf) with two phases; with ``slope="steep"`` along the ground, its
    vertical part included, up to slopes of 60 degrees. Dynamic pressure is rho speed^2, with
    rho = density (phi + gamma (1 - phi)) of the mixture.

    Parameters
    ----------
    threshold : depth, m, above which the flow has arrived, for arrival and duration.
    density : of the solid, kg/m^3; of a model with one phase that of the flow.
    least : depth, m, below which speed and pressure are not recorded: films may be fast.

    Attributes
    ----------
    maps : dict
        {name: grid.shape}; empty before a run:

        * ``depth``: largest depth h, vertical, m; ``thickness``: largest depth normal to the ground, h cos, m, with
          ``slope="steep"``, else the same;
        * ``speed``: largest speed, m/s; ``pressure``: largest dynamic pressure, Pa;
        * ``phi``: solid fraction at the time of the largest depth; NaN where no flow came, and in models without one;
        * ``arrival``: first time with depth >= ``threshold``, s; infinite where there was none;
        * ``duration``: time with depth >= ``threshold``, s: the lengths of the steps at whose end it was.

    Raises
    ------
    ValueError
        When the run starts, for a model without a depth.

    Examples
    --------
    >>> import fvkit as fv
    >>> import fvkit_granular as gr
    >>> dam = gr.Scene((0.0, 10.0), 1.0, lambda x: {"h": (x < 5.0) * 1.0, "phi": 0.5})
    >>> hazard = gr.HazardMaps(threshold=0.05)
    >>> solution = fv.solve(dam.problem(gr.TwoPhase, 50), backend="numpy", observers=hazard)
    >>> print(f"{hazard.maps['depth'][0]:.6f} m; at the end {hazard.maps['arrival'][-1] > 0.8}")
    1.000000 m; at the end True
    """

    threshold: float = number(0.1, above=0.0)
    density: float = number(2000.0, above=0.0)
    least: float = number(0.01, above=0.0)
    _maps: dict[str, np.ndarray] = attrs.field(factory=dict, init=False, repr=False)
    _slopes: np.ndarray | None = attrs.field(default=None, init=False, repr=False)
    _last: float = attrs.field(default=np.nan, init=False, repr=False)

    def __attrs_post_init__(self) -> None:
        caution(self, "density", LIGHTEST, HEAVIEST, "it is in kg/m^3, and 2.5 g/cm^3 is 2500")

    def begin(self, problem: Problem) -> None:
        if not callable(getattr(problem.model, "depth", None)):
            raise ValueError(f"HazardMaps need a model with a depth, {type(problem.model).__name__} defines no `depth(q)`")
        self._maps = {name: np.full(problem.grid.shape, none) for name, none in MAPS.items()}
        relief = [field for field in problem.fields if isinstance(field, Slopes)]
        self._slopes = relief[0].at(problem.t_start)[:len(problem.grid.axes)] if relief else None  # without bends
        self._last = problem.t_start

    def see(self, problem: Problem, t: float, q: np.ndarray) -> None:
        box = _wet_box(problem, q)
        if box is not None:
            self._note({name: values[box] for name, values in self._maps.items()}, self._seen(problem, q, box), t)
        self._last = t

    def _seen(self, problem: Problem, q: np.ndarray, box: tuple[slice, ...]) -> dict[str, np.ndarray]:
        """Return depth, solid fraction, speed and pressure in a box of cells."""
        model: Any = problem.model
        aux = {name: values[box] for name, values in problem.aux_averages.items()}
        seen = observables(model, problem.grid, q[(slice(None), *box)], aux)
        h = seen["h"]
        velocity = [seen[name] for name in ("v", "v_x", "v_y") if name in seen]
        square = sum(v * v for v in velocity)
        if self._slopes is not None:
            falls = sum(v * slope[box] for v, slope in zip(velocity, self._slopes, strict=True)) ** 2
            square = square + np.minimum(falls, STEEPEST**2 * square)
        square = np.where(h >= self.least, square, 0.0)
        phi = seen.get("phi", np.full(h.shape, np.nan))
        share = np.where(np.isnan(phi), 1.0, phi + getattr(model, "gamma", 1.0) * (1.0 - phi))
        return {"depth": h, "phi": phi, "speed": np.sqrt(square), "pressure": self.density * share * square}

    def _note(self, maps: dict[str, np.ndarray], seen: dict[str, np.ndarray], t: float) -> None:
        """Write observables into views of the maps."""
        deepest = seen["depth"] > maps["depth"]
        maps["phi"][deepest] = seen["phi"][deepest]
        for name in ("depth", "speed", "pressure"):
            np.maximum(maps[name], seen[name], out=maps[name])
        there = seen["depth"] >= self.threshold
        maps["arrival"][there] = np.minimum(maps["arrival"][there], t)
        maps["duration"][there] += t - self._last

    def record(self) -> dict[str, np.ndarray]:
        return {**self._maps, "last": np.array([self._last])}

    def recall(self, problem: Problem, record: Mapping[str, np.ndarray]) -> None:
        for name in MAPS:
            if record[name].shape != problem.grid.shape:
                raise ValueError(f"HazardMaps have maps of {problem.grid.described} cells, got {name!r} of {record[name].shape}")
        self._maps = {name: record[name].copy() for name in MAPS}
        self._last = float(record["last"][0])

    @property
    def maps(self) -> dict[str, np.ndarray]:
        """All maps, {name: grid.shape}."""
        if not self._maps:
            return {}
        stretched = 1.0 if self._slopes is None else np.sqrt(1.0 + (self._slopes ** 2).sum(axis=0))
        return {**self._maps, "thickness": self._maps["depth"] / stretched}


def _wet_box(problem: Problem, q: np.ndarray) -> tuple[slice, ...] | None:
    """Return the smallest box of cells that holds all mass, as a slice along each axis; None on dry ground."""
    wet = np.logical_or.reduce([q[row] > 0.0 for row in problem.mass_rows])
    box = []
    for axis in range(wet.ndim):
        lines = np.flatnonzero(wet.any(axis=tuple(k for k in range(wet.ndim) if k != axis)))
        if not lines.size:
            return None
        box.append(slice(int(lines[0]), int(lines[-1]) + 1))
    return tuple(box)
