"""`advise`: which model, scheme and number of cells a scene needs, from its initial state alone."""


import attrs
import numpy as np

from fvkit import Inflow, _validate
from fvkit_granular.drag import ConstantDrag, Drag
from fvkit_granular.friction import BasalFriction
from fvkit_granular.given_flow import GivenFlow
from fvkit_granular.indicators import Indicators, indicators, sampled
from fvkit_granular.inflow import Hydrograph
from fvkit_granular.outflow import Stage
from fvkit_granular.resolution import MOST, resolution
from fvkit_granular.scene import Scene
from fvkit_granular.slope import is_steep, sentence, within_reach

#: Predictions are doubled before a cheaper model is recommended.
SAFETY = 2.0
#: Nanoseconds per cell and step, compiled, second order, N = 1000 (docs/speed.md): Roe, Relaxation.
NANOSECONDS = {"two-phase": (40.0, 24.0), "reduced": (14.0, 16.0), "shallow-water": (8.0, 12.0)}
#: The fifth-order method costs this many second-order steps of the same length in time: ten stages, Courant number 2.4.
COSTLIER = 7.5
#: Below this tolerance high order pays for smooth flow.
FINE = 1e-4


@attrs.frozen
class Advice:
    """What a scene needs for a tolerance of the mean error of the depth over the mean depth.

    Attributes
    ----------
    scene : name of the scene.
    tol : the tolerance.
    numbers : the `Indicators` of the scene.
    model : cheapest of ``"shallow-water"``, ``"reduced"``, ``"two-phase"`` whose doubled prediction is below ``tol``.
    scheme : the scheme, as it is written.
    cells : number of cells whose estimated error is ``tol``.
    grid_error : estimated error of that grid.
    seconds : expected run time, compiled, stepping only.
    jumps : whether the flow holds jumps, from the start or before the end.
    slope : steepest slope of the bottom that the flow may reach; above 15 degrees it is among the warnings.
    warnings : why the advice may fail; empty on the ground on which it was validated.
    """

    scene: str
    tol: float
    numbers: Indicators
    model: str
    scheme: str
    cells: int
    grid_error: float
    seconds: float
    jumps: bool
    slope: float
    warnings: tuple[str, ...]

    def text(self) -> str:
        """Return the advice as lines of text."""
        n = self.numbers
        needed = {"two-phase": "the full model is needed", "reduced": "the reduced model suffices",
                  "shallow-water": "shallow water suffices"}[self.model]
        lines = [f"{self.scene or 'scene'}: {needed} for an error of the depth of {self.tol:g} (mean, over the mean depth)",
                 f"  phi {n.phi:.3g}, varying by {n.phi_range:.2g}, spreads over {n.spread:.3g} m; drag K T = {n.damping:.3g}",
                 f"  Froude number up to {n.froude:.3g}; slip up to {n.slip:.2f} of 2 a beta; dry share {n.dry_share:.0%}",
                 f"  predicted model error, doubled to decide: reduced {n.reduced:.1e}, shallow water {n.shallow:.1e}",
                 f"  scheme: {self.scheme}, {self.cells} cells (estimated grid error {self.grid_error:.1e}, "
                 f"{'with jumps' if self.jumps else 'smooth'}), about {_duration(self.seconds)} compiled"]
        if self.slope > 0.0 and not is_steep(self.slope):
            lines.append(f"  {sentence(self.slope)}")
        return "\n".join(lines + [f"  caution: {warning}" for warning in self.warnings])

    def __str__(self) -> str:
        return self.text()


def _duration(seconds: float) -> str:
    return f"{seconds:.2g} s" if seconds >= 1.0 else f"{1e3 * seconds:.2g} ms"


def advise(scene: Scene, tol: float = 1e-3) -> Advice:
    """Return which model, scheme and grid a scene needs. Nothing is run.

    The model is the cheapest whose predicted error, doubled, is below the tolerance; how the prediction is made stands in
    `fvkit_granular.indicators`, how good it is in docs/model_choice.md. The number of cells is a rule of thumb: an error
    from the jumps and the curvature of the initial state, see `fvkit_granular.resolution`.

    Parameters
    ----------
    scene : the scene.
    tol : wanted mean error of the depth over the mean depth, in (0, 1).

    Returns
    -------
    Advice

    Raises
    ------
    ValueError
        If the scene is dry everywhere, or ``tol`` is out of range.
    """
    scene = _validate.instance(scene, "scene", Scene, "such as gr.scene('riemann')")
    tol = _validate.real(tol, "tol", above=0.0, below=1.0)
    state = sampled(scene)
    numbers = indicators(scene, state)
    model = decide(numbers.reduced, numbers.shallow, tol)
    grid = resolution(scene, state, numbers, two_phase=model == "two-phase")
    high = grid.smooth and tol < FINE
    cells = grid.cells(tol, high)
    error = grid.error(cells, high)
    relaxed = numbers.dry_share > 0.0 or bool((np.minimum(state["phi"], 1.0 - state["phi"]) <= 0.0).any())
    solver = "Relaxation" if relaxed else "Roe"
    scheme = f"MethodOfLines({solver}, MP5)" if high else f"WavePropagation({solver}, MC), order 2"
    speed = np.maximum(np.abs(state["vs"]), np.abs(state["vf"]))
    slope = within_reach(state["b"], state["x"][1] - state["x"][0], state["h"], speed, scene.g, scene.sides())
    steps = scene.t_end * (numbers.froude + 1.0) * numbers.speed * cells / (0.9 * grid.interval)
    seconds = 1e-9 * NANOSECONDS[model][int(relaxed)] * (COSTLIER if high else 1.0) * cells * steps
    return Advice(scene.name, tol, numbers, model, scheme, cells, error, seconds, grid.jump > 0.0,
                  slope, _warnings(scene, numbers, slope, error > 1.01 * tol))


def decide(reduced: float, shallow: float, tol: float) -> str:
    """Return the cheapest model whose predicted error, doubled, is below ``tol``."""
    if SAFETY * shallow < tol:
        return "shallow-water"
    return "reduced" if SAFETY * reduced < tol else "two-phase"


def _warnings(scene: Scene, numbers: Indicators, slope: float, coarse: bool) -> tuple[str, ...]:
    """Return why the advice may fail for this scene."""
    sources, sides = scene.given_sources(), scene.sides()
    reached = numbers.speed * (1.0 + numbers.froude) * scene.t_end / (scene.interval[1] - scene.interval[0])
    found: list[tuple[bool, str]] = [
        (numbers.slip > 0.8, "the slip comes near the range where speeds are complex and the problem is ill-posed"),
        (numbers.dry_share > 0.0 and numbers.phi_range > 0.3, "steep phi with dry ground: not validated"),
        (any(isinstance(source, BasalFriction) for source in sources),
         "friction at the bed: shallow water has no buoyancy, and predictions are rougher (docs/model_choice.md)"),
        (any(isinstance(source, Drag) and not isinstance(source, ConstantDrag) for source in sources),
         "variable drag: K is that of the mean state at the start"),
        (any(not isinstance(source, (Drag, BasalFriction)) for source in sources), "sources that the prediction does not know"),
        (any(side.closed for side in sides) and reached > 0.5, "waves come back from the walls: only their first "
         "run is predicted"),
        (any(side.reads == "opposite" for side in sides) and reached > 1.0, "waves pass the periodic interval more than once"),
        (any(isinstance(side, (Inflow, GivenFlow, Hydrograph, Stage)) for side in sides), "what the inflow brings is not in the "
         "prediction"),
        (is_steep(slope), f"{sentence(slope)}, which no model and no grid removes"),
        (coarse, f"the tolerance needs more than {MOST} cells"),
    ]
    return tuple(text for holds, text in found if holds)
