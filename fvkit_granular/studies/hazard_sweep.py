"""Sweeps over a scene on a terrain: hazard maps of every member, and the probability of exceeding thresholds per cell."""

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import attrs
import numpy as np

from fvkit import solve, validation
from fvkit.sweeps import SweepResult
from fvkit_granular.scenes.scene import Scene
from fvkit_granular.studies.scene_run import SceneRun
from fvkit_granular.terrain.layers import PROBABILITY, write_style
from fvkit_granular.terrain.rasters import write_raster

#: Maps with thresholds, and the unit of each.
UNITS = {"depth": "m", "thickness": "m", "speed": "m/s", "pressure": "Pa", "duration": "s"}


def _thresholds(value: Any) -> dict[str, tuple[float, ...]]:
    """Return {map: thresholds}, checked."""
    result = {}
    for name, levels in validation.mapping(value, "thresholds", "{depth = [0.1, 0.5]}").items():
        validation.choice(name, "thresholds", UNITS)
        found = validation.series([levels] if validation.is_single(levels) else levels, f"thresholds.{name}", "[0.1, 0.5]")
        if (found <= 0.0).any():
            raise ValueError(f"`thresholds.{name}` must be > 0 {UNITS[name]}, got {validation.shown(levels)}")
        result[str(name)] = tuple(found.tolist())
    if not result:
        raise ValueError("`thresholds` must name a map, such as {depth = [0.1, 0.5]}")
    return result


@attrs.frozen
class HazardRun:
    """A function of parameters that runs a scene on a terrain and returns its hazard maps: what `fvkit.sweep` calls.

    Maps of `HazardMaps` that have ``thresholds``, {map: values}, are kept.
    """

    run: SceneRun
    thresholds: Mapping[str, tuple[float, ...]] = attrs.field(converter=_thresholds)

    def __call__(self, **parameters: Any) -> dict[str, Any]:
        """Run the scene with these parameters, see `SceneRun`; {map: (ny, nx)}, and the number of steps."""
        scene, problem, scheme = self.run.setup_of_scene(parameters)
        hazard: Any = scene.watch.observers(2)["hazard"]
        solution = solve(problem, scheme, backend=self.run.backend, nonhyperbolic="ignore", observers=hazard)
        return {**{name: hazard.maps[name] for name in self.thresholds}, "steps": solution.stats.steps}


def exceeded(result: SweepResult, thresholds: Mapping[str, tuple[float, ...]]) -> dict[str, np.ndarray]:
    """Return the share of finished members that reach each threshold in each cell, {"depth >= 0.1": (ny, nx)}."""
    members = np.flatnonzero(result.finished)
    if not members.size:
        raise ValueError("no member of the sweep finished: there is nothing to count")
    return {f"{name} >= {level:g}": np.mean([np.asarray(result.outputs[name][k]) >= level for k in members], axis=0)
            for name, levels in thresholds.items() for level in levels}


def write_exceeded(folder: Path, scene: Scene, found: Mapping[str, np.ndarray], ending: str = ".asc") -> list[str]:
    """Write probabilities as rasters on the terrain of a scene, and a map of each; return the names of the files."""
    from fvkit.output.figures import save_all
    from fvkit_granular.terrain.maps import draw_map, laid_over

    names, relief = [], draw_map(scene.terrain, release=scene.release)
    for what, share in found.items():
        name = "probability_" + what.replace(" >= ", "_")
        write_style(write_raster(folder / f"{name}{ending}", share, scene.terrain), PROBABILITY)
        label = f"probability of {what} {UNITS[what.split()[0]]}"
        figure: Any = relief.figure
        with laid_over(relief, scene.terrain, share, label, 0.0, highest=1.0):
            save_all(folder, {f"{name}.png": figure})
        names += [f"{name}{ending}", f"{name}.qml", f"{name}.png"]
    return names

