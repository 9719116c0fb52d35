"""`advise`: which model, scheme and number of cells a scene needs, from its initial state alone."""

from typing import Any

import attrs
import numpy as np

from fvkit import Inflow, Periodic, Wall, _validate
from fvkit_granular.drag import ConstantDrag, Drag
from fvkit_granular.friction import BasalFriction
from fvkit_granular.indicators import DRY, Indicators, given_sources, indicators, sampled
from fvkit_granular.scene import Scene

#: Predictions are doubled before a cheaper model is recommended.
SAFETY = 2.0
#: Grid error of the depth: FIRST J/N from jumps J, SECOND C dx^2 from curvature C of smooth flow, second-order f-waves.
FIRST, SECOND = 0.4, 0.13
#: The same of the fifth-order method of lines (SSPRK104): FOURTH C dx^2 (dx/l)^2 with the length l of the flow.
FOURTH = 5.0
#: What curvature of phi and of the slip counts for in the depth.
ASIDE = 0.3
#: What moving shores count for, as a jump.
SHORE = 0.5
#: Nanoseconds per cell and step, compiled, second order, N = 1000 (docs/speed.md): Roe, Relaxation.
NANOSECONDS = {"two-phase": (40.0, 24.0), "reduced": (14.0, 16.0), "shallow-water": (8.0, 12.0)}
#: The fifth-order method costs this many second-order steps of the same length in time: ten stages, Courant number 2.4.
COSTLIER = 7.5
#: Numbers of cells that are recommended.
FEWEST, MOST = 100, 1_000_000
#: Smoothness is judged on this many samples beside a step: a step that makes half of their change is a jump.
WINDOW = 5
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
    warnings: tuple[str, ...]

    def text(self) -> str:
        """Return the advice as lines of text."""
        n = self.numbers
        needed = {"two-phase": "the full model is needed", "reduced": "the reduced model suffices",
                  "shallow-water": "shallow water suffices"}[self.model]
        lines = [f"{self.scene or 'scene'}: {needed} for an error of the depth of {self.tol:g} (mean, over the mean depth)",
                 f"  phi {n.phi:.3g}, varying by {n.phi_range:.2g}; drag K T = {n.damping:.3g}; phi spreads over X = {n.spread:.3g} m",
                 f"  Froude number up to {n.froude:.3g}; slip up to {n.slip:.2f} of 2 a beta; dry share {n.dry_share:.0%}",
                 f"  predicted model error, doubled to decide: reduced {n.reduced:.1e}, shallow water {n.shallow:.1e}",
                 f"  scheme: {self.scheme}, {self.cells} cells (estimated grid error {self.grid_error:.1e}, "
                 f"{'with jumps' if self.jumps else 'smooth'}), about {_duration(self.seconds)} compiled"]
        return "\n".join(lines + [f"  caution: {warning}" for warning in self.warnings])

    def __str__(self) -> str:
        return self.text()


def _duration(seconds: float) -> str:
    return f"{seconds:.2g} s" if seconds >= 1.0 else f"{1e3 * seconds:.2g} ms"


def advise(scene: Scene, tol: float = 1e-3) -> Advice:
    """Return which model, scheme and grid a scene needs. Nothing is run.

    The model is the cheapest whose predicted error, doubled, is below the tolerance; how the prediction is made stands in
    `fvkit_granular.indicators`, how good it is in docs/model_choice.md. The number of cells is a rule of thumb: an error
    0.4 J/N from jumps of sum J (of the surface over the mean depth, of phi, of velocities over sqrt(g h)), and 0.13 C dx^2
    from smooth flow of mean curvature C over the mean depth; fitted, mostly good to a factor 2.

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
    jump, curvature, length, smooth_bed = _shape(scene, state, numbers, model)
    interval = scene.interval[1] - scene.interval[0]
    high = jump == 0.0 and smooth_bed and tol < FINE
    relaxed = numbers.dry_share > 0.0 or bool((np.minimum(state["phi"], 1.0 - state["phi"]) <= 0.0).any())

    def error(cells: float) -> float:
        width = interval / cells
        if high:
            return FOURTH * curvature * width**2 * (width / length) ** 2
        return FIRST * jump / cells + SECOND * curvature * width**2

    cells = FEWEST
    while error(cells) > tol and cells < MOST:
        cells = min(2 * cells, MOST)
    low = cells // 2
    while cells > FEWEST and cells - low > 5 and error(cells) <= tol:
        middle = (low + cells) // 2
        low, cells = (low, middle) if error(middle) <= tol else (middle, cells)
    cells = -(-cells // 10) * 10
    solver = "Relaxation" if relaxed else "Roe"
    scheme = f"MethodOfLines({solver}, MP5)" if high else f"WavePropagation({solver}, MC), order 2"
    fastest = (numbers.froude + 1.0) * numbers.speed
    steps = scene.t_end * fastest * cells / (0.9 * interval)
    seconds = 1e-9 * NANOSECONDS[model][int(relaxed)] * (COSTLIER if high else 1.0) * cells * steps
    return Advice(scene.name, tol, numbers, model, scheme, cells, error(cells), seconds, jump > 0.0,
                  _warnings(scene, numbers, cells, error(cells) > 1.01 * tol))


def decide(reduced: float, shallow: float, tol: float) -> str:
    """Return the cheapest model whose predicted error, doubled, is below ``tol``."""
    if SAFETY * shallow < tol:
        return "shallow-water"
    return "reduced" if SAFETY * reduced < tol else "two-phase"


def _shape(scene: Scene, state: dict[str, np.ndarray], numbers: Indicators, model: str) -> tuple[float, float, float, bool]:
    """Return the sum of all jumps, the mean curvature of the rest, its length, and whether the bottom is smooth.

    Smooth flow that steepens into a shock before the end counts as jumps as a whole.
    """
    h, b, phi = state["h"], state["b"], state["phi"]
    dx = state["x"][1] - state["x"][0]
    wet = h > DRY * h.max()
    touched = wet[1:] | wet[:-1]
    # neither still water over a bottom nor a uniform layer on a slope is a wave
    surface = np.where(np.abs(np.diff(h + b)) < np.abs(np.diff(h)), np.diff(h + b), np.diff(h)) / numbers.depth
    v = np.where(wet, phi * state["vs"] + (1.0 - phi) * state["vf"], 0.0) / numbers.speed
    steps, weights = [surface, np.diff(v)], [1.0, 1.0]
    if model != "shallow-water":
        slip = np.where(wet, state["vf"] - state["vs"], 0.0) / numbers.speed
        steps += [np.diff(np.where(wet, phi, numbers.phi)), np.diff(slip)]
        weights += [ASIDE, ASIDE]
    jump = SHORE if numbers.dry_share > 0.0 and np.ptp(b) > 0.0 else 0.0
    amount, curvature = np.zeros(touched.size), 0.0
    gentle = []
    for signed, weight in zip(steps, weights, strict=True):
        step = np.where(touched, signed, 0.0)
        sharp = _sharp(np.abs(step))
        jump += float(np.abs(step[sharp]).sum())
        bend = np.where(sharp[1:] | sharp[:-1], 0.0, np.abs(np.diff(step)))
        curvature += weight * float(bend.sum()) / dx
        gentle.append(np.where(sharp, 0.0, step))
        amount += np.abs(gentle[-1])
    # speeds of simple waves, v +- a, fall by 3/4 d(v +- 2 a): where that overtakes itself before the end, a shock forms
    deep = np.sqrt(numbers.depth / np.maximum(0.5 * (h[1:] + h[:-1]), 0.1 * numbers.depth))
    for sign in (1.0, -1.0):
        falling = -0.75 * numbers.speed * (gentle[1] + sign * deep * gentle[0]) / dx
        if scene.t_end * float(falling.max()) > 1.0:
            jump += float(amount.sum())
            break
    length = float(amount.sum()) / curvature if curvature > 0.0 else 1.0
    smooth_bed = not (_sharp(np.abs(np.diff(b))).any() or _sharp(np.abs(np.diff(b, 2))).any())
    return jump, curvature / (state["x"][-1] - state["x"][0]), length, smooth_bed


def _sharp(step: np.ndarray) -> np.ndarray:
    """Return where a step makes more than half of the change in its neighbourhood: jumps of the sampled function."""
    nearby = np.convolve(step, np.ones(2 * WINDOW + 1), mode="same")
    return (step > 0.5 * nearby) & (step > 1e-9 * max(float(step.max()), 1e-3))


def _warnings(scene: Scene, numbers: Indicators, cells: int, coarse: bool) -> tuple[str, ...]:
    """Return why the advice may fail for this scene."""
    sources, boundary = given_sources(scene), scene.boundary
    sides: tuple[Any, ...] = tuple(boundary) if isinstance(boundary, (tuple, list)) else (boundary,)
    reached = numbers.speed * (1.0 + numbers.froude) * scene.t_end / (scene.interval[1] - scene.interval[0])
    found = [
        (numbers.slip > 0.8, "the slip comes near the range where speeds are complex and the problem is ill-posed"),
        (numbers.dry_share > 0.0 and numbers.phi_range > 0.3, "steep phi with dry ground: not validated"),
        (any(isinstance(source, BasalFriction) for source in sources),
         "friction at the bed: shallow water has no buoyancy, and predictions are rougher (docs/model_choice.md)"),
        (any(isinstance(source, Drag) and not isinstance(source, ConstantDrag) for source in sources),
         "variable drag: K is that of the mean state at the start"),
        (any(not isinstance(source, (Drag, BasalFriction)) for source in sources), "sources that the prediction does not know"),
        (any(isinstance(side, Wall) for side in sides) and reached > 0.5, "waves come back from the walls: only their first "
         "run is predicted"),
        (any(isinstance(side, Periodic) for side in sides) and reached > 1.0, "waves pass the periodic interval more than once"),
        (any(isinstance(side, Inflow) for side in sides), "what the inflow brings is not in the prediction"),
        (coarse, f"the tolerance needs more than {MOST} cells"),
    ]
    return tuple(text for holds, text in found if holds)
