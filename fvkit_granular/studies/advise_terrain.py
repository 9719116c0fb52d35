"""Advice for a scene on a terrain, as far as its files allow: phases, cell size, time, without predicted errors of
models, which were not validated there.

Exact: where all that flows has one solid fraction, starts at rest and has no friction at the bed, the three models have
the same solution, on any ground and with any drag. Where one of these fails the models differ, and by how much was validated
along one axis on level ground alone.
"""

from typing import Any

import attrs
import numpy as np

from fvkit import Problem
from fvkit.problem.fields import averages
from fvkit.run.progress import duration
from fvkit.studies.tables import filled
from fvkit_granular.models.slope import said_of, within_reach
from fvkit_granular.models.two_phase import TwoPhase
from fvkit_granular.scenes.scene import Scene
from fvkit_granular.studies.model_error_indicators import DRY, drag_of

#: Time of a step with two axes per cell where something flows, s; share of the relief's potential energy that speeds reach.
COST, SHARE = 2.5e-7, 0.5

#: Said of a source that does not say itself, as ``separates``, why the three models differ where it acts, "" where they do not.
UNKNOWN = "sources that are not known here"

#: Cell sizes that an advice considers, as multiples of that of the terrain.
COARSER = (1, 2, 4)


@attrs.frozen
class Effort:
    """What a run on a terrain will take, by the relief below the release: steps, the speed behind them, m/s, and cells."""

    steps: float
    speed: float
    cells: int

    def seconds(self, share: float) -> float:
        """Return the time of the stepping, compiled, s, where the flow covers this share of the cells."""
        return self.steps * COST * self.cells * share

    def __str__(self) -> str:
        return (f"about {float(f'{self.steps:.2g}'):g} steps ({self.speed:.2g} m/s); compiled about "
                f"{duration(self.seconds(0.1))} (a tenth wet) to {duration(self.seconds(1.0))} (all wet)")


def effort(scene: Scene, problem: Problem) -> Effort:
    """Return the expected cost of a run of a scene on a terrain."""
    model: Any = problem.model
    depth = model.depth(tuple(problem.q0[row] for row in problem.directions[0].rows))
    wet = depth > 0.0
    ground = problem.aux_averages["b"][wet] if wet.any() else scene.terrain.bottom
    relief = float(np.nanmax(ground) - np.nanmin(scene.terrain.bottom))
    speed = np.sqrt(2.0 * scene.g * SHARE * max(relief, 0.0)) + np.sqrt(scene.g * float(depth.max()))
    dx = min(axis.dx for axis in problem.grid.axes)
    return Effort(float(scene.t_end * max(speed, 1.0) / (0.9 * dx)), float(speed), problem.grid.size)


@attrs.frozen(eq=False)
class TerrainAdvice:
    """Advice for a scene on a terrain: phases, drag, slope, cells and cost, and the reasons why models differ.

    Parameters
    ----------
    scene : its name.
    model : ``"shallow-water"`` where the three models have the same solution, else ``"two-phase"``.
    same : whether the three models have the same solution.
    reasons : why they differ; empty where they do not.
    phi : smallest and largest solid fraction of the flow.
    damping : K T, drag times the run time at the start, see `Indicators`; 0 without drag.
    slope : the steepest slope in reach and the equations that a run takes, as a sentence.
    cell : length of a side of the cells of the terrain, m.
    across : square root of the area of the release over the length of a cell; NaN without one.
    grounds : for cells of 1, 2 and 4 times the length: {factor: (number of cells, how far averaging moves the ground, root mean
        square, m, expected time where the flow covers a tenth, s)}.
    thickness : largest depth at the start, m.
    effort : expected cost of a run.

    Examples
    --------
    >>> import numpy as np
    >>> import fvkit as fv, fvkit_granular as gr
    >>> terrain = gr.Terrain(fv.Grid((0.0, 0.0), (100.0, 60.0), (20, 12)), np.tile(np.linspace(30.0, 0.0, 20), (12, 1)))
    >>> square = {"type": "Polygon", "coordinates": [[[10, 20], [30, 20], [30, 40], [10, 40], [10, 20]]]}
    >>> release = gr.read_release(square, terrain, thickness=2.0, solid_fraction=0.6)
    >>> advice = gr.advise(gr.Scene(terrain=terrain, release=release, t_end=10.0, sources=gr.CoulombFriction(0.3)))
    >>> advice.model, advice.same, advice.phi, advice.cell, advice.thickness
    ('two-phase', False, (0.6, 0.6), 5.0, 2.0)
    """

    scene: str
    model: str
    same: bool
    reasons: tuple[str, ...]
    phi: tuple[float, float]
    damping: float
    slope: str
    cell: float
    across: float
    grounds: dict[int, tuple[int, float, float]]
    thickness: float
    effort: Effort

    def text(self) -> str:
        """Return the advice as lines of text."""
        lowest, highest = self.phi
        shown = f"{lowest:.3g}" if lowest == highest else f"{lowest:.3g} to {highest:.3g}"
        verdict = ("shallow water suffices: one solid fraction, at rest, without friction at the bed, for which the three models "
                   "have the same solution" if self.same else "take two phases; whether a cheaper model would do is not known")
        lines = [f"{self.scene or 'scene'}: {verdict}"]
        lines += [f"  the models differ here: {reason}" for reason in self.reasons]
        lines.append(f"  phi {shown}; drag K T = {self.damping:.3g}" + (
            "" if self.same else "; large K T keeps the phases together, small lets them part"))
        if not self.same:
            lines.append("  no model error is predicted: the prediction was validated along one axis on level ground, never on a "
                         "terrain. Run --model reduced beside --model two-phase on coarse cells, and compare the rasters")
        lines += [f"  {self.slope}", f"  cells of {self.cell:g} m, as the terrain has them: {self.effort}"]
        if np.isfinite(self.across):
            lines.append(f"  the release is {self.across:.3g} cells wide (root of its area), up to {self.thickness:.3g} m deep")
        lines += [f"  cell = {factor * self.cell:g}: {cells} cells, some {duration(time)}; averaging moves the ground by "
                  f"{moved:.2g} m (root mean square)" for factor, (cells, moved, time) in self.grounds.items() if factor > 1]
        lines.append("  no grid error is predicted: the rule for it was never validated on a terrain. Where the ground moves by "
                     "much less than the flow is deep, run with the coarser cells too: what changes is the error of the grid")
        return "\n".join(filled(line, "    ") for line in lines)

    def __str__(self) -> str:
        return self.text()


def advise_on_terrain(scene: Scene) -> TerrainAdvice:
    """Return the advice for a scene on a terrain; nothing is run. `gr.advise` calls it."""
    terrain, x, y = scene.terrain, *np.meshgrid(*(axis.centers for axis in scene.terrain.grid.axes))
    flow = scene.flow(x, y)
    h = np.broadcast_to(flow["h"], x.shape)
    wet = h > DRY * h.max(initial=0.0)
    rains = [source for source in scene.sources if hasattr(source, "brings")]
    if not wet.any() and not rains:
        raise ValueError(f"the scene {scene.name or ''} is dry everywhere: there is nothing to advise on")
    problem = scene.problem(TwoPhase)
    shares = np.concatenate([np.broadcast_to(flow["phi"], x.shape)[wet],
                             *(_values(source, source.brings, problem) for source in rains)])
    ends = float(shares.min()), float(shares.max())
    moving = any(np.any(np.broadcast_to(flow[name], x.shape)[wet]) for name in flow if name.startswith("v"))
    reasons = [text for holds, text in (
        (ends[0] < ends[1], f"the solid fraction varies from {ends[0]:.3g} to {ends[1]:.3g}"),
        (moving, "the flow starts with a velocity"),
        (any((_values(source, "intensity", problem) < 0.0).any() for source in rains), "infiltration takes fluid alone"),
        *((True, text) for text in dict.fromkeys(getattr(source, "separates", UNKNOWN) for source in scene.sources) if text),
    ) if holds]
    if reasons and any(source.between_phases and not getattr(source, "constant", False) for source in scene.sources):
        reasons.append("the drag varies with the flow: K is that of the start, without slip")
    whole, dx = effort(scene, problem), terrain.grid.axes[0].dx
    area = float(wet.sum()) * terrain.grid.cell_volume
    return TerrainAdvice(
        scene.name, "two-phase" if reasons else "shallow-water", not reasons, tuple(reasons), ends,
        drag_of(scene, float(shares.mean()), 0.0) * scene.t_end, said_of(within_reach(problem, scene.g), problem.model), dx,
        np.sqrt(area) / dx if wet.any() else np.nan, _coarser(terrain, whole), float(h.max()), whole)


def _values(source: Any, name: str, problem: Problem) -> np.ndarray:
    """Return the values of a field of a source: of a table in time all of them, of another function those at the start."""
    given = getattr(source, name)
    given = getattr(given, "values", given)
    if callable(given):
        given = averages([field for field in problem.fields
                          if field.source is source and getattr(field, "name", "") == name], problem.t_start)
    return np.ravel(given)


def _coarser(terrain: Any, whole: Effort) -> dict[int, tuple[int, float, float]]:
    """Return what larger cells would be, as far as the terrain is wide enough."""
    found = {}
    for factor in COARSER:
        if factor > 1 and min(terrain.grid.shape) < 4 * factor:
            continue
        ny, nx = (count // factor for count in terrain.grid.shape)
        b = terrain.bottom[:ny * factor, :nx * factor].reshape(ny, factor, nx, factor)
        moved = float(np.sqrt(np.nanmean((b - b.mean(axis=(1, 3), keepdims=True)) ** 2)))
        found[factor] = nx * ny, moved, whole.seconds(0.1) / factor**3
    return found
