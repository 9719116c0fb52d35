"""The hard scenes and what must hold in each.

Bounds of errors are for 100 cells and the most diffusive solver, measured and rounded up by a tenth or so: they catch a
scheme that has changed, not one that could be better.
"""

import attrs
import numpy as np

from fvkit.validation import choice
from fvkit_granular.scenes.library.dry_and_extreme import ABSENT
from fvkit_granular.scenes.library.plane import PLANE_SCENES
from fvkit_granular.scenes.toml.read import SUFFIX, find_scene
from fvkit_granular.stress import checks

#: Models with a slip between phases.
SLIPPING = ("two-phase", "pitman-le")

#: Every model.
EVERY = (*SLIPPING, "reduced", "shallow-water", "two-layer")

#: Models for which solutions of shallow water with uniform phi and one velocity are exact.
SINGLE = (*SLIPPING, "reduced", "shallow-water")


@attrs.frozen
class Case:
    """A hard scene.

    Parameters
    ----------
    judges : what must hold beside what must always: finished, no negative mass, masses kept.
    models : names of the models it is for.
    cells : number of cells.
    steps : bound of steps over nominal steps; None where the first step is not representative, as for inflow onto dry ground.
    """

    judges: tuple[checks.Judge, ...] = ()
    models: tuple[str, ...] = EVERY
    cells: int = 100
    steps: float | None = 4.0

    def every_judge(self) -> tuple[checks.Judge, ...]:
        """The judges, steps included."""
        return self.judges if self.steps is None else (*self.judges, checks.steps_within(self.steps))


def _fastest(depth: float) -> float:
    """Speed of the front of a dam break of that depth onto dry ground, m/s."""
    return float(2.0 * np.sqrt(9.81 * depth))


CASES: dict[str, Case] = {
    "rest": Case((checks.at_rest, checks.level_kept), SINGLE),
    "island": Case((checks.at_rest, checks.level_kept), SINGLE),
    "island-step": Case((checks.at_rest, checks.level_kept), SINGLE),
    "two-layer-rest": Case((checks.at_rest, checks.level_kept), ("two-layer",)),
    "dry-dam-break": Case((checks.close_to_reference(0.033, 0.017), checks.no_faster_than(_fastest(1.0))), SINGLE),
    "tiny-depth": Case((checks.close_to_reference(0.033, 0.017), checks.no_faster_than(_fastest(1.0))), SINGLE),
    "double-rarefaction": Case((checks.close_to_reference(0.075, 0.036), checks.no_faster_than(8.0 + 1e-9)), SINGLE),
    "thacker": Case((checks.close_to_reference(0.18, 0.03),), SINGLE, steps=8.0),
    "transonic": Case((checks.close_to_reference(0.0625, 0.025),), SINGLE),
    "expansion-shock": Case((checks.close_to_reference(0.03, 0.01),), SINGLE),
    "froude-50": Case((checks.close_to_reference(0.2, 0.08),), SINGLE),
    # The slip that the transport drives against D K, up to 2e-8 m/s; sources beside the transport would leave none.
    "stiff-drag": Case((checks.close_to_reference(0.03, 0.012), checks.slip_below(1e-7)), (*SLIPPING, "reduced")),
    "lost-hyperbolicity": Case((checks.energy_not_above_start,), SLIPPING, steps=8.0),
    "pile": Case((checks.exactly_still,), SINGLE),
    "toe": Case((checks.exactly_still,), SINGLE),
    "submerged-pile": Case((checks.solid_still,), ("two-phase", "reduced")),
    "block-stop": Case((checks.stopped,), SINGLE),
    "column-collapse": Case((checks.stopped,), SINGLE),
    "sliding-dam-break": Case((checks.close_to_reference(0.06, 0.036),), ("two-phase", "reduced")),
    "debris-slope": Case((), SINGLE, steps=8.0),
    "pitman-le": Case((), SLIPPING),
    "internal-jump": Case((), ("two-layer",)),
    "internal-dam-break": Case((), ("two-layer",)),
    "two-layer-step": Case((), ("two-layer",)),
    **{name: Case((), EVERY, steps=40.0) for name in ABSENT},
}


def case_of(scene: str) -> Case:
    """Return the hard scene of that name, or refuse with the nearest match; of a scene file only general checks are made."""
    if scene in PLANE_SCENES or (scene.endswith(SUFFIX) and len(find_scene(scene).axes) > 1):
        raise ValueError(f"`scene` must have one axis for stress, got {scene}, which has two and nothing that judges its runs: "
                         "take `fvkit compare`")
    if scene.endswith(SUFFIX):
        return Case((), SINGLE, steps=None)
    return CASES[choice(scene, "scene", CASES)]
