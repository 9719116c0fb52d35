"""Boundary conditions of shallow flow: hydrograph, fixed level, uniform slope, given flow."""

from collections.abc import Mapping
from pathlib import Path
from typing import Any, ClassVar

import attrs
import numpy as np

from fvkit import BoundaryCondition, Grid, Model, maximum, minimum, validation, where
from fvkit.pointwise import TINY, combine
from fvkit.problem.grid import Axis, Side
from fvkit.problem.open_ends import Continued, Given, beyond, slope_beyond
from fvkit.problem.slopes import end_slope
from fvkit_granular.csv_table import read_columns
from fvkit_granular.models.beyond_the_end import falling_share, gravity, mean_speed
from fvkit_granular.models.quantities import critical_depth


def check_tables(end: BoundaryCondition, times: tuple[float, ...], **tables: tuple[float, ...]) -> None:
    """Raise ValueError unless times ascend and each table has one entry per time or a single entry."""
    kind = type(end).__name__
    if (np.diff(times) <= 0.0).any():
        raise ValueError(f"`times` of a {kind} must ascend, got {list(times)}")
    for name, values in tables.items():
        if len(values) not in (1, len(times)):
            raise ValueError(f"`{name}` of a {kind} must have one entry for each of the {len(times)} times, or one for all, "
                             f"got {len(values)}")


def at_time(t: float, times: tuple[float, ...], values: tuple[float, ...]) -> float:
    """Return the value of a table at time t, by linear interpolation."""
    return values[0] if len(values) == 1 else float(np.interp(t, times, values))


def of_flow(model: Any, asking: BoundaryCondition, h: float, phi: float) -> tuple[list[float], list[float]]:
    """Return two lists of num_eqn values: the masses of a flow with other rows 0, and its momenta at 1 m/s with other rows 0.

    Raises
    ------
    ValueError
        For a model without a depth; the message contains the boundary condition ``asking``.
    """
    if not (model.phases and all(hasattr(model, name) for name in ("conserved_from", "depth", "g", "dry"))):
        raise ValueError(f"{type(asking).__name__} needs a model of flows with a depth, such as gr.TwoPhase, "
                         f"got {type(model).__name__}")
    rows = {momentum for _, momentum in model.phases}
    state = model.conserved_from(h, phi, 1.0, 1.0).tolist()
    return ([0.0 if row in rows else value for row, value in enumerate(state)],
            [value if row in rows else 0.0 for row, value in enumerate(state)])


@attrs.frozen
class Hydrograph(Continued):
    """Hydrograph: inflow with given discharge and solid fraction over time, linear between the entries.

    The mass fluxes through the end are exactly phi(t) Q(t) and (1 - phi(t)) Q(t), independent of the Riemann solver. The depth
    of the ghost cells, which determines the momentum, is that of the first cell, at least the critical depth (Q^2/g)^(1/3),
    at most ``depth`` if given. Solid and fluid enter with the same velocity. Time steps end at the entries, so that no rise is
    skipped.

    Parameters
    ----------
    times : times of the entries, s, ascending; values are constant before the first and after the last entry.
    discharge : discharge per width, m^2/s, >= 0 (inflow at either end): one value per time, or one for all.
    phi : solid fraction of the inflow, in [0, 1]: one value per time, or one for all.
    depth : depth of the inflow, m, needed for supercritical inflow: one value per time, or one for all. Subcritical inflow has
        it only as far as the flow inside backs it up; None for the rule above without it.
    slope : fall of the bottom per metre beyond the end, outwards, positive where it falls; None for that of the last two cells.

    Notes
    -----
    On ground that is dry everywhere at first the default of the model's ``dry`` is 1e-9 m; give a larger one for fewer steps.
    For supercritical inflow without ``depth`` the depth at the end is not controlled.

    Examples
    --------
    >>> import fvkit_granular as gr
    >>> flood = gr.Hydrograph(times=[0.0, 10.0, 60.0], discharge=[0.0, 2.0, 0.0], phi=[0.4, 0.5, 0.3])
    >>> tuple(map(float, flood.at(5.0)))
    (1.0, 0.45)
    """

    still: ClassVar[bool] = True

    times: tuple[float, ...] = validation.field(validation.row)
    discharge: tuple[float, ...] = validation.field(validation.row)
    phi: tuple[float, ...] = validation.field(validation.row)
    depth: tuple[float, ...] | None = validation.field(validation.row, None, optional=True)
    inward: float = attrs.field(default=1.0, init=False, repr=False)

    def __attrs_post_init__(self) -> None:
        depth = self.depth or (np.inf,)
        check_tables(self, self.times, discharge=self.discharge, phi=self.phi, depth=depth)
        if min(self.discharge) < 0.0:
            raise ValueError(f"`discharge` of a Hydrograph must be >= 0, which flows in, got {min(self.discharge):g}: "
                             "what flows out is for fv.Outflow or gr.FixedLevel")
        if not 0.0 <= min(self.phi) <= max(self.phi) <= 1.0:
            raise ValueError(f"`phi` of a Hydrograph must be in [0, 1] (a fraction: 60 % is 0.6), got {list(self.phi)}")
        if min(depth) < 0.0 or ((np.array(depth) == 0.0) & (np.array(self.discharge) > 0.0)).any():
            raise ValueError(f"`depth` of a Hydrograph must be > 0 where there is a discharge, >= 0 elsewhere, got {list(depth)}")

    @classmethod
    def read(cls, path: str | Path) -> "Hydrograph":
        """Return the hydrograph of a CSV file with columns ``t [s]`` (or min, h), ``discharge [m2/s]``, ``phi [-]`` (or %) and,
        optionally, ``depth [m]``.

        Raises
        ------
        ValueError
            For invalid data; the message contains file, line and column.
        FileNotFoundError
            If the file does not exist.
        """
        table = read_columns(path)
        times = table.ascending("t", "time", "for a jump put two rows close together")
        depth = table.column("depth", "length") if "depth" in table.values else None
        columns: tuple[Any, ...] = times, table.column("discharge", "discharge"), table.column("phi", "share"), depth
        return cls(*columns)

    @property
    def steady(self) -> bool:
        return len(self.times) == 1 or len(self.discharge) == len(self.phi) == len(self.depth or (0.0,)) == 1

    def breaks(self) -> tuple[float, ...]:
        return () if self.steady else self.times

    def placed(self, side: Side, model: Model, grid: Grid | Axis, aux: Mapping[str, np.ndarray]) -> "Hydrograph":
        result = super().placed(side, model, grid, aux)
        object.__setattr__(result, "inward", -side.outwards)
        return result

    def at(self, t: float) -> tuple[float, float]:
        """Return discharge per width, m^2/s, and solid fraction at time t, s."""
        return at_time(t, self.times, self.discharge), at_time(t, self.times, self.phi)

    def values(self, model: Any, t: float) -> tuple[float, ...]:
        discharge, phi = self.at(t)
        masses, momenta = of_flow(model, self, 1.0, phi)
        critical = critical_depth(discharge, gravity(model, self.ground[0] if self.ground else 0.0))
        most = np.inf if self.depth is None else at_time(t, self.times, self.depth)
        entering = discharge * self.inward
        moving, fluxes = [entering * value for value in momenta], [entering * masses[row] for row in model.mass_rows()]
        return (min(critical, most), most, *masses, *moving, *fluxes, *self.ground)

    def ghost(self, model, q, values):
        # Only a flow faster than its waves has its depth from upstream: deeper water than that inside would push it to a jet.
        h, rows = maximum(values[0], minimum(values[1], model.depth(q))), len(q)
        flow = combine(h, values[2:2 + rows], 1.0, values[2 + rows:2 + 2 * rows])
        return beyond(self, model, flow, values)

    def mass_fluxes(self, model, values):
        first = 2 + 2 * len(model.conserved)
        return values[first:first + len(model.mass_rows())]


def _level(value: Any) -> Any:
    return value if callable(value) and not isinstance(value, type) else validation.row(value, "level")


#: Inflow from a lake takes no velocity from a flow less than ``LOWER`` times as deep as the lake, and its full velocity from a
#: flow deeper than ``LOWER`` + 1/``STILL`` times the lake.
LOWER, STILL = 0.8, 7.0


@attrs.frozen
class FixedLevel(Continued):
    """Fixed level: a lake or sea of given surface level at the end; the ghost cells have the depth level - bottom.

    The difference of levels determines inflow or outflow. Supercritical outflow is not affected by the level, unless the lake
    is so deep that a jump travels inwards. A river at the end has the given level at the face. Into a flow less than 0.8 times
    as deep as the lake, or onto dry ground, the lake discharges from rest, as in a dam break.

    Parameters
    ----------
    level : height of the free surface, m, over the same datum as the bottom: a number, one value per entry of ``times``
        (linear between them), or a function of time, s.
    phi : solid fraction of the inflow, in [0, 1]; 0, clear water, by default.
    times : times of the levels, s, ascending; the level is constant before the first and after the last entry.
    slope : fall of the bottom per metre beyond the end, outwards, positive where it falls; None for that of the last two cells.

    Examples
    --------
    >>> import fvkit_granular as gr
    >>> tide = gr.FixedLevel(level=[0.0, 1.0, 0.0], times=[0.0, 3600.0, 7200.0])
    >>> float(tide.at(1800.0))
    0.5
    """

    still: ClassVar[bool] = True

    level: Any = attrs.field(converter=_level)
    phi: float = validation.number(0.0, at_least=0.0, at_most=1.0, hint="solid fraction: 60 % is 0.6")
    times: tuple[float, ...] = validation.field(validation.row, (0.0,))
    bottom: float = attrs.field(default=0.0, init=False, repr=False)
    inward: float = attrs.field(default=1.0, init=False, repr=False)

    def __attrs_post_init__(self) -> None:
        check_tables(self, self.times, level=(0.0,) if callable(self.level) else self.level)

    @property
    def steady(self) -> bool:
        return not callable(self.level) and len(self.level) == 1

    def breaks(self) -> tuple[float, ...]:
        return () if self.steady or callable(self.level) else self.times

    def placed(self, side: Side, model: Model, grid: Grid | Axis, aux: Mapping[str, np.ndarray]) -> "FixedLevel":
        result = super().placed(side, model, grid, aux)
        object.__setattr__(result, "bottom", float(side.inwards(aux["b"])[0]) if "b" in aux else 0.0)
        object.__setattr__(result, "inward", -side.outwards)
        return result

    def at(self, t: float) -> float:
        """Return the level at time t (s), m."""
        if callable(self.level):
            return validation.real(self.level(t), f"level of a FixedLevel at t = {t:g}")
        return at_time(t, self.times, self.level)

    def values(self, model: Model, t: float) -> tuple[float, ...]:
        masses, momenta = of_flow(model, self, 1.0, self.phi)
        slope, distance = self.ground or (0.0, 0.0)
        return (self.at(t) - self.bottom, slope, 0.5 * distance, *masses, *momenta, *self.ground)

    def ghost(self, model, q, values):
        level, slope, rows, distance = values[0], values[1], len(q), values[len(values) - 1]
        h, v = model.depth(q), mean_speed(model, q)
        wet, out = h > model.dry, -self.inward * v
        surface = level + falling_share(model, q, slope) * slope * (distance - values[2])
        depth = maximum(surface - slope * distance, 0.0)
        ratio = depth / where(wet, h, 1.0)
        pull = gravity(model, slope)
        # Speed of inward waves; that of a hydraulic jump if the lake is deeper.
        unfelt = wet & (out > np.sqrt(pull * h * maximum(1.0, 0.5 * ratio * (ratio + 1.0))))
        flow = beyond(self, model, q, values)
        has = model.depth(flow)
        # The velocity beyond is that of the simple wave that leads to the level: else this would hold a cell farther out, and a
        # tide would be late by the time of a wave over a cell.
        alike = minimum(maximum(STILL * (minimum(depth, has) / (maximum(depth, has) + TINY) - LOWER), 0.0), 1.0)
        rise = where(unfelt, 0.0, 2.0 * self.inward * alike * (np.sqrt(pull * depth) - np.sqrt(pull * has)))
        # A river enters with the velocity of the first cell. Into a much shallower flow the lake discharges from rest, since its
        # level is its total head.
        enters = (v + rise) * minimum(maximum(STILL * (h - LOWER * depth), 0.0), depth)
        leaves, scale = wet & (out >= 0.0) & (has > 0.0), where(unfelt, 1.0, depth / where(has > 0.0, has, 1.0))
        masses = {momentum: rows[-1] for rows, momentum in model.phases}
        return tuple([where(leaves, scale * (flow[k] + (rise * flow[masses[k]] if k in masses else 0.0)),
                            depth * values[3 + k] + enters * values[3 + rows + k]) for k in range(rows)])


@attrs.frozen
class UniformSlope(BoundaryCondition):
    """Uniform slope: outflow over a bottom that continues at a slope; uniform flow leaves without reflection.

    The ghost cells have the state of the last cell, over a bottom that continues at the slope. Water at rest is not an
    equilibrium at this end, since it flows off; `fvkit.Outflow` preserves it.

    Parameters
    ----------
    slope : fall of the bottom per metre beyond the end, outwards, positive where it falls; None for the median of the last five
        steps from cell to cell.

    Examples
    --------
    >>> import fvkit as fv
    >>> import fvkit_granular as gr
    >>> import numpy as np
    >>> slope, q = 0.02, 1.5
    >>> depth = (0.03 * q / slope**0.5) ** 0.6
    >>> river = fv.Problem(gr.ShallowWater(), fv.Grid(0.0, 100.0, 50), lambda x: [0.0 * x + depth, 0.0 * x + q], 10.0,
    ...                    {"b": lambda x: -slope * x}, (gr.Hydrograph([0.0], [q], [0.0], [depth]), gr.UniformSlope()),
    ...                    gr.Manning(0.03))
    >>> bool(abs(fv.solve(river, backend="numpy").q[-1] - river.q0).max() < 1e-12)
    True
    """

    slope: float | None = attrs.field(default=None, converter=attrs.converters.optional(
        lambda value: slope_beyond(value, "None: that of the last cells")))

    def placed(self, side: Side, model: Model, grid: Grid | Axis, aux: Mapping[str, np.ndarray]) -> "UniformSlope":
        if "b" not in model.aux:
            raise ValueError(f"UniformSlope needs a model with a bottom `b`, such as gr.TwoPhase, got {type(model).__name__}")
        if self.slope is not None:
            return self
        if grid.num_cells < 2:
            raise ValueError("UniformSlope needs two cells to see the slope of the bottom: give `slope`")
        return attrs.evolve(self, slope=end_slope(side.inwards(aux["b"])) / grid.dx)

    def ghost_aux(self, model: Model, aux: np.ndarray, distance: np.ndarray) -> np.ndarray:
        result = np.array(aux)
        result[model.aux.index("b")] -= (self.slope or 0.0) * distance
        return result

    def ghost(self, model, q, values):
        return q


@attrs.frozen
class GivenFlow(Given):
    """Given flow: constant state at the end, like `fvkit.Inflow`, but in primitive variables, for every model.

    The Riemann solver selects the incoming waves, so a subcritical state is imposed only in part.

    Parameters
    ----------
    h : depth, m, >= 0.
    phi : solid fraction in [0, 1].
    vs, vf : velocities of solid and fluid, m/s, positive to the right.
    slope : fall of the bottom per metre beyond the end, outwards, positive where it falls; None for that of the last two cells.

    Examples
    --------
    >>> import fvkit as fv
    >>> import fvkit_granular as gr
    >>> import numpy as np
    >>> inflow = gr.GivenFlow(h=1.0, phi=0.4, vs=5.0, vf=5.0)
    >>> channel = fv.Problem(gr.TwoPhase(), fv.Grid(0.0, 1.0, 20), np.zeros((4, 20)), 1.0, boundary=(inflow, fv.Outflow()))
    >>> fv.solve(channel, backend="numpy").observables()["h"].round(6).max().item()
    1.0
    """

    # Annotated Any, not float: float fields are parameters of pointwise code, but only `values`, plain Python, reads these.
    h: Any = validation.number(at_least=0.0, hint="depth in m")
    phi: Any = validation.number(at_least=0.0, at_most=1.0, hint="solid fraction: 60 % is 0.6")
    vs: Any = validation.number(0.0, hint="velocity in m/s")
    vf: Any = validation.number(0.0, hint="velocity in m/s")

    def given(self, model, t):
        if not callable(getattr(model, "conserved_from", None)):
            raise ValueError(f"GivenFlow needs a model with h, phi, vs, vf; {type(model).__name__} has no `conserved_from`")
        return tuple(float(value) for value in model.conserved_from(self.h, self.phi, self.vs, self.vf))
