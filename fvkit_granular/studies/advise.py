"""`advise`: model, scheme and number of cells for a scene, from its initial state."""

import warnings
from typing import Any

import attrs
import numpy as np

from fvkit import Outflow, Periodic, Problem, Wall, validation
from fvkit.run.progress import duration
from fvkit.studies.tables import filled, preformatted
from fvkit_granular.models.slope import SteepSlopeWarning, is_steep, sentence, within_reach
from fvkit_granular.models.two_phase import TwoPhase
from fvkit_granular.scenes.scene import Scene
from fvkit_granular.sources.friction import BasalFriction
from fvkit_granular.studies.advise_terrain import TerrainAdvice, advise_on_terrain
from fvkit_granular.studies.grid_error_estimate import MOST, resolution
from fvkit_granular.studies.model_error_indicators import Indicators, indicators, sampled

#: Predictions are doubled before a cheaper model is recommended.
SAFETY = 2.0
#: Nanoseconds per cell and step, compiled, second order, N = 1000 (docs/speed.md): Roe, Relaxation.
NANOSECONDS = {"two-phase": (40.0, 24.0), "reduced": (14.0, 16.0), "shallow-water": (8.0, 12.0)}
#: The fifth-order method costs this many second-order steps of the same length in time: ten stages, Courant number 2.4.
COSTLIER = 7.5
#: Below this tolerance high order pays for smooth flow.
FINE = 1e-4
#: The ground of the validation: relief over the mean depth, Froude number at the start, density ratios.
UNEVEN, FAST, LIGHT, HEAVY = 0.5, 1.0, 0.2, 0.8


@attrs.frozen
class Advice:
    """Advice for a scene and a tolerance: model, scheme, cells and run time, from `advise`.

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
    jumps : whether the flow has jumps, from the start or before the end.
    slope : steepest slope of the bottom that the flow may reach; above 15 degrees it is among the warnings.
    warnings : reasons why the advice may fail; empty within its validated range.
    valid : whether model errors are predicted: False outside the validated range; then the model is the full one, and
        ``numbers.reduced`` and ``numbers.shallow`` are meaningless.

    Examples
    --------
    >>> import fvkit_granular as gr
    >>> advice = gr.advise(gr.scene("dam-break"), tol=1e-2)
    >>> advice.model, advice.cells, advice.jumps, advice.valid
    ('shallow-water', 100, True, True)
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
    valid: bool

    def text(self) -> str:
        """Return the advice as lines of text."""
        n = self.numbers
        needed = {"two-phase": "the full model is needed", "reduced": "the reduced model suffices",
                  "shallow-water": "shallow water suffices"}[self.model]
        predicted = (f"predicted model error: reduced {n.reduced:.1e}, shallow water {n.shallow:.1e} (recommended: below "
                     "half the tolerance)" if self.valid else
                     "predicted model error: not valid here, see the cautions; `fvkit advise SCENE --check` measures it")
        needed = needed if self.valid else "the full model (no valid prediction)"
        drag = " (>> 1: phases move together)" if n.damping > 100.0 else ""
        lines = [f"{self.scene or 'scene'}: {needed} for a mean error of {self.tol:g} of the mean depth",
                 f"  solid fraction {n.phi:.3g} ({f'range {n.phi_range:.2g}' if n.phi_range else 'uniform'}); mixing length "
                 f"{n.spread:.3g} m; drag strength K T = {n.damping:.3g}{drag}",
                 f"  Froude number up to {n.froude:.3g}; slip up to {n.slip:.2f} of the limit 2 a beta; {n.dry_share:.0%} dry",
                 f"  {predicted}",
                 f"  scheme: {self.scheme}, {self.cells} cells; run time compiled about {duration(self.seconds)}",
                 f"  estimated grid error {self.grid_error:.1e} ({'with jumps' if self.jumps else 'smooth'})"]
        if self.slope > 0.0 and not any("steepest slope" in warning for warning in self.warnings):
            lines.append(f"  {sentence(self.slope)}")
        return "\n".join(filled(line, "    ") for line in (*lines, *(f"  caution: {warning}" for warning in self.warnings)))

    def __str__(self) -> str:
        return self.text()

    def _repr_html_(self) -> str:
        return preformatted(self.text())


def advise(scene: Scene, tol: float = 1e-3) -> Advice | TerrainAdvice:
    """Estimate which model, scheme and grid a scene needs, without running it.

    The model is the cheapest whose predicted error, doubled, is below the tolerance; the formulas are in
    `fvkit_granular.studies.model_error_indicators`, how good it is in docs/model_choice.md. The number of cells is a rule of
    thumb: an error from the jumps and the curvature of the initial state, see `fvkit_granular.studies.grid_error_estimate`.

    Parameters
    ----------
    scene : the scene.
    tol : wanted mean error of the depth over the mean depth, in (0, 1); on a terrain nothing depends on it.

    Returns
    -------
    Advice
        For a scene on a terrain a `TerrainAdvice`: phases, cells and time as far as they are known, without predicted errors.

    Raises
    ------
    ValueError
        If the scene is dry everywhere, or ``tol`` is out of range.

    Examples
    --------
    >>> import fvkit_granular as gr
    >>> advice = gr.advise(gr.scene("dam-break"), tol=1e-2)
    >>> advice.model
    'shallow-water'
    """
    scene = validation.instance(scene, "scene", Scene, "such as gr.scene('riemann')")
    tol = validation.real(tol, "tol", above=0.0, below=1.0)
    if scene.terrain is not None:
        return advise_on_terrain(scene)
    state = sampled(scene)
    numbers = indicators(scene, state)
    slope = _slope(scene, state) if np.ptp(state["b"]) > 0.0 else 0.0
    beyond, rougher = _warnings(scene, state, numbers, slope)
    model = "two-phase" if beyond else decide(numbers.reduced, numbers.shallow, tol)
    grid = resolution(scene, state, numbers, two_phase=model == "two-phase")
    high = grid.smooth and tol < FINE
    cells = grid.cells(tol, high)
    error = grid.error(cells, high)
    relaxed = numbers.dry_share > 0.0 or bool((np.minimum(state["phi"], 1.0 - state["phi"]) <= 0.0).any())
    solver = "Relaxation" if relaxed else "Roe"
    scheme = f"MethodOfLines({solver}, MP5)" if high else f"WavePropagation({solver}, MC), order 2"
    steps = scene.t_end * (numbers.froude + 1.0) * numbers.speed * cells / (0.9 * grid.interval)
    seconds = 1e-9 * NANOSECONDS[model][int(relaxed)] * (COSTLIER if high else 1.0) * cells * steps
    coarse = (f"the tolerance needs more than {MOST} cells",) if error > 1.01 * tol else ()
    return Advice(scene.name, tol, numbers, model, scheme, cells, error, seconds, grid.jump > 0.0, slope,
                  beyond + rougher + coarse, not beyond)


def decide(reduced: float, shallow: float, tol: float) -> str:
    """Return the cheapest model whose predicted error, doubled, is below ``tol``."""
    if SAFETY * shallow < tol:
        return "shallow-water"
    return "reduced" if SAFETY * reduced < tol else "two-phase"


def _slope(scene: Scene, state: dict[str, np.ndarray]) -> float:
    """The steepest slope that the flow of a scene may reach."""
    model: Any = scene.model(TwoPhase)
    q = model.conserved_from(*(state[name] for name in ("h", "phi", "vs", "vf")))
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", SteepSlopeWarning)  # among the cautions of the advice
        problem = Problem(model, scene.grid(len(state["x"])), q, scene.t_end, {"b": state["b"]}, scene.boundary, scene.sources)
    return within_reach(problem, scene.g)


def _warnings(scene: Scene, state: dict[str, np.ndarray], numbers: Indicators,
              slope: float) -> tuple[tuple[str, ...], tuple[str, ...]]:
    """Return what takes the ground away on which the prediction was validated, and what only makes it rougher."""
    sources, sides = scene.sources, scene.boundary
    friction = [source for source in sources if isinstance(source, BasalFriction)]
    reached = numbers.speed * (1.0 + numbers.froude) * scene.t_end / (scene.interval[1] - scene.interval[0])
    uneven = float(np.ptp(state["b"])) / numbers.depth
    differ = bool(friction) or numbers.reduced > 0.0 or numbers.shallow > 0.0
    beyond = [
        (numbers.slip > 0.8, "the slip is close to the loss of hyperbolicity, where the problem is ill-posed"),
        (numbers.dry_share > 0.0 and numbers.phi_range > 0.3, "steep phi with dry ground"),
        (bool(friction) and (uneven > 0.0 or not all(law.proportional for law in friction)),
         "friction at the bed other than Coulomb's on level ground"),
        (any(source.between_phases and not getattr(source, "constant", False) for source in sources),
         "variable drag: K is that of the mean state at the start"),
        (any(source not in friction and not source.between_phases for source in sources),
         "sources that are not part of the prediction"),
        (any(side.closed for side in sides) and reached > 0.5, "waves return from the walls; the prediction covers "
         "their first passage only"),
        (any(side.reads == "opposite" for side in sides) and reached > 1.0, "waves pass the periodic interval more than once"),
        (not all(isinstance(side, (Outflow, Wall, Periodic)) for side in sides), "the prediction ignores inflow and all ends "
         "that are neither walls, periodic nor fv.Outflow()"),
        (differ and uneven > UNEVEN, f"a bottom that varies by more than {UNEVEN:g} of the mean depth"),
        (differ and numbers.froude > FAST, f"a flow that starts with a Froude number above {FAST:g}"),
        (differ and not LIGHT <= scene.gamma <= HEAVY, f"a density ratio gamma outside {LIGHT:g} to {HEAVY:g}"),
    ]
    steep = scene.equations == "steep"
    ground = f"steepest slope {np.degrees(np.arctan(slope)):.3g} degrees"
    beyond.append((steep and differ, f"{ground}: runs use the equations for steep ground"))
    rougher = [(is_steep(slope) and not steep, f"{sentence(slope)}, which slope=\"steep\" removes"),
               (bool(friction), "friction at the bed: shallow water has no buoyancy, so predictions are less "
                                "accurate (docs/model_choice.md)")]
    first = tuple(text for holds, text in beyond if holds)
    return first, tuple(text for holds, text in rougher if holds and not any(known.startswith("friction") for known in first))
