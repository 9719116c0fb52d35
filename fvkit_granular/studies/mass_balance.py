"""`MassBalance`: volumes of a run on a terrain, in each phase, through each side and by each source, with first contacts."""

from collections.abc import Mapping
from functools import partial
from typing import Any

import attrs
import numpy as np

from fvkit import Solution, validation
from fvkit.problem.directions import SIDES, component_names, mass_places
from fvkit.run.stepper import numbered
from fvkit.studies.tables import table
from fvkit_granular.observers.hazard import HazardMaps
from fvkit_granular.scenes.scene import Scene
from fvkit_granular.sources.rain import Drain

#: What the row of the cells without data is called.
GAPS = "cells without data"

#: The edge of a map (ny, nx) at each side.
EDGES: dict[str, Any] = {"west": np.s_[:, 0], "east": np.s_[:, -1], "south": np.s_[0], "north": np.s_[-1]}


@attrs.frozen(eq=False)
class MassBalance:
    """Mass balance of a run with two axes: initial volume, inflow and outflow by place, and final volume, m^3.

    Parameters
    ----------
    first, last : {phase: volume}, m^3, at the start and at the end: "hs" of the solid and "hf" of the fluid, or "h".
    entered : {place: {phase: net volume that came in}}, m^3, negative where more has left. Places are "west", "east", "south",
        "north", "cells without data" where these are an outlet, and each "hydrograph", "rain", "drain" or other source.
    contact : {side, or "cells without data": first time at which a cell beside it was deeper than ``threshold``}, s; infinite
        where there was none; empty without hazard maps.
    threshold : that depth, m; NaN without hazard maps.

    Attributes
    ----------
    error : dict
        {phase: last - first - sum of entered, relative to the initial volume and the inflow}; round-off in a correct run.

    Examples
    --------
    >>> import fvkit_granular as gr
    >>> balance = gr.MassBalance(first={"h": 2.0}, last={"h": 5.0}, entered={"west": {"h": 4.0}, "east": {"h": -1.0}}, contact={})
    >>> balance.error
    {'h': 0.0}
    """

    first: Mapping[str, float]
    last: Mapping[str, float]
    entered: Mapping[str, Mapping[str, float]]
    contact: Mapping[str, float]
    threshold: float = np.nan

    @property
    def error(self) -> dict[str, float]:
        """Relative error of each mass."""
        found = {}
        for mass, start in self.first.items():
            flows = [row[mass] for row in self.entered.values()]
            size = start + sum(flow for flow in flows if flow > 0.0)
            wrong = self.last[mass] - start - sum(flows)
            found[mass] = wrong / size if size > 0.0 else wrong
        return found

    def __str__(self) -> str:
        masses = list(self.first)
        several = ["together"] * (len(masses) > 1)

        def row(name: str, values: Mapping[str, float], when: str = "") -> list[str]:
            each = [values[mass] for mass in masses]
            return [name, *(f"{value:.6g}" for value in each + [sum(each)] * len(several)), when]

        rows = [["volume, m3", *masses, *several, "first contact"], row("at first", self.first)]
        for place, values in self.entered.items():
            time = self.contact.get(place)
            when = "" if time is None else f"{time:.4g} s" if np.isfinite(time) else "none"
            rows.append(row(f"in through the {place}" if place in EDGES else f"in by {place}", values, when))
        rows.append(row("at the end", self.last))
        rows.append(["error", *(f"{self.error[mass]:.1e}" for mass in masses), *[""] * len(several), ""])
        return table([line if self.contact else line[:-1] for line in rows], left=1)


def mass_balance(scene: Scene, solution: Solution, hazard: HazardMaps | None = None) -> MassBalance:
    """Return the mass balance of a run of a scene with two axes.

    Parameters
    ----------
    scene, solution : the scene and the solution of its run.
    hazard : the hazard maps of the run, for the times of first contact; None for none.

    Returns
    -------
    MassBalance
        ``print`` shows it as a table; ``error`` is rounding.

    Raises
    ------
    ValueError
        For a solution with one axis, or of a model without masses.

    Examples
    --------
    >>> import numpy as np
    >>> import fvkit as fv, fvkit_granular as gr
    >>> dam = lambda x, y: {"h": 1.0 * (x < 5.0), "phi": 0.5}
    >>> scene = gr.Scene(((0.0, 0.0), (10.0, 4.0)), 4.0, dam, boundary={"east": fv.Outflow(), "west": fv.Wall()})
    >>> solution = fv.solve(scene.problem(gr.ShallowWater, (20, 8)), backend="numpy")
    >>> balance = gr.mass_balance(scene, solution)
    >>> balance.entered["east"]["h"] < -1.0, abs(balance.error["h"]) < 1e-13
    (True, True)
    """
    validation.instance(scene, "scene", Scene, "that was run")
    grid, model = validation.instance(solution, "solution", Solution, "of fv.solve").grid, solution.model
    if hazard is not None:
        validation.instance(hazard, "hazard", HazardMaps, "that observed the run")
    if len(grid.axes) != 2 or not solution.stats.entered:
        raise ValueError("a mass balance is that of a run with two axes and a model with masses: with one axis see "
                         "`solution.stats.entered`")
    every, rows = component_names(model, grid), list(mass_places(model, grid))
    of_phases = partial(_phases, model)
    first, last = (of_phases({every[row]: float(solution.q[k][row].sum() * grid.cell_volume) for row in rows}) for k in (0, -1))
    gaps = scene.terrain is not None and scene.gaps == "outlet" and bool(scene.terrain.missing.any())
    contact = {} if hazard is None else _contacts(scene, hazard.maps["arrival"], gaps)
    places = {place: of_phases(row) for place, row in _places(scene, solution, gaps).items()}
    return MassBalance(first, last, places, contact, np.nan if hazard is None else hazard.threshold)


def _phases(model: Any, masses: Mapping[str, float]) -> dict[str, float]:
    """Return volumes of the phases from those that a model conserves: its own, or solid and fluid of a depth and a mass."""
    nothing = tuple(np.zeros(1) for _ in model.conserved)
    if len(masses) != 2 or not callable(getattr(model, "poured", None)):
        return dict(masses)
    made = np.column_stack([np.ravel(model.poured(nothing, solid, fluid)) for solid, fluid in ((1.0, 0.0), (0.0, 1.0))])
    if (made == np.eye(2)).all():
        return dict(masses)
    return dict(zip(("hs", "hf"), (np.linalg.solve(made, list(masses.values())) + 0.0).tolist(), strict=True))


def _places(scene: Scene, solution: Solution, gaps: bool) -> dict[str, dict[str, float]]:
    """Return what came in, by the names of places; sources that moved no mass are left out, but for hydrographs and outlets."""
    entered = solution.stats.entered
    found = {side: entered[side] for pair in SIDES for side in pair}
    drains = [key for key in entered if key.split()[0] == Drain.__name__]
    if gaps:
        found[GAPS] = entered[drains[-1]]  # a scene puts its own behind the others
    given = [(key, source) for key, source in zip(numbered([type(one).__name__ for one in scene.sources]), scene.sources,
                                                   strict=True) if key in entered]
    named = [(key, getattr(source, "noun", type(source).__name__)) for key, source in given
             if any(entered[key].values()) or hasattr(source, "brings")]
    return found | {name: entered[key] for name, (key, _) in zip(numbered([noun for _, noun in named]), named, strict=True)}


def _contacts(scene: Scene, arrival: np.ndarray, gaps: bool) -> dict[str, float]:
    """Return the first arrival beside each side, and beside cells without data."""
    found = {side: float(arrival[edge].min()) for side, edge in EDGES.items()}
    if gaps:
        from scipy.ndimage import binary_dilation

        missing = scene.terrain.missing
        found[GAPS] = float(arrival[binary_dilation(missing, np.ones((3, 3))) & ~missing].min(initial=np.inf))
    return found
