"""How many cells a scene needs: a rule of thumb for the grid error of the depth, from the initial state alone.

With J the sum of all jumps (of the surface over the mean depth h, of velocities over a = sqrt(g h), of phi and the slip) and C
the mean curvature of the rest, second-order f-waves on N cells of width dx are taken to err, in the mean over the mean depth, by

    0.4 J/N + 0.13 C dx^2,

and the fifth-order method of lines, for smooth flow of length l, by 5 C dx^4/l^2. Where a simple wave overtakes itself before
the end, all that varies counts as a jump. The numbers are fitted to scenes that last for some passages of their waves; it
overrates flows that go to and fro, and underrates transonic fans and flow down slopes. `fvkit advise SCENE --check` measures it.
"""

import attrs
import numpy as np

from fvkit_granular.scenes.scene import Scene
from fvkit_granular.studies.model_error_indicators import DRY, Indicators

#: The numbers above.
FIRST, SECOND, FOURTH = 0.4, 0.13, 5.0
#: What curvature of phi and of the slip counts for in the depth.
ASIDE = 0.3
#: What moving shores count for, as a jump.
SHORE = 0.5
#: Numbers of cells that are recommended.
FEWEST, MOST = 100, 1_000_000
#: A step that makes half of the change of this many samples on both sides is a jump.
WINDOW = 5


@attrs.frozen
class Resolution:
    """What the grid error of a scene depends on.

    Attributes
    ----------
    interval : length of the scene, m.
    jump : sum of jumps J.
    curvature : mean curvature C, m^-2.
    length : l, m.
    smooth : whether flow and bottom are smooth.
    """

    interval: float
    jump: float
    curvature: float
    length: float
    smooth: bool

    def error(self, cells: int, high: bool = False) -> float:
        """Return the estimated mean error of the depth over the mean depth; ``high``: of the fifth-order method."""
        dx = self.interval / cells
        if high:
            return FOURTH * self.curvature * dx**2 * (dx / self.length) ** 2
        return FIRST * self.jump / cells + SECOND * self.curvature * dx**2

    def cells(self, tol: float, high: bool = False) -> int:
        """Return the number of cells, a multiple of ten, with which the error is ``tol``, in [``FEWEST``, ``MOST``]."""
        if high:
            needed = (FOURTH * self.curvature * self.interval**4 / self.length**2 / tol) ** 0.25
        else:
            first, second = FIRST * self.jump, SECOND * self.curvature * self.interval**2
            needed = (first + np.sqrt(first * first + 4.0 * tol * second)) / (2.0 * tol)
        return int(10 * np.ceil(min(max(needed, FEWEST), MOST) / 10.0))


def resolution(scene: Scene, state: dict[str, np.ndarray], numbers: Indicators, two_phase: bool = True) -> Resolution:
    """Return the quantities that determine the grid error of a scene, from its samples and indicators, see
    `fvkit_granular.studies.model_error_indicators`. Unless ``two_phase`` phi and the slip do not count: they move no depths.
    """
    b = state["b"]
    dx = state["x"][1] - state["x"][0]
    interval = scene.interval[1] - scene.interval[0]
    jump = SHORE if numbers.dry_share > 0.0 and np.ptp(b) > 0.0 else 0.0
    curvature, varied = 0.0, 0.0
    gentle = []
    for step, weight in _steps(state, numbers, two_phase):
        sharp = _sharp(np.abs(step))
        jump += float(np.abs(step[sharp]).sum())
        bend = np.where(sharp[1:] | sharp[:-1], 0.0, np.abs(np.diff(step)))
        curvature += weight * float(bend.sum()) / (dx * interval)
        gentle.append(np.where(sharp, 0.0, step))
        varied += float(np.abs(gentle[-1]).sum())
    if scene.t_end * _overtaking(state["h"], gentle[0], gentle[1], dx, numbers) > 1.0:
        jump += varied
    smooth = not (jump > 0.0 or _sharp(np.abs(np.diff(b))).any() or _sharp(np.abs(np.diff(b, 2))).any())
    return Resolution(interval, jump, curvature, varied / (curvature * interval) if curvature > 0.0 else interval, smooth)


def _steps(state: dict[str, np.ndarray], numbers: Indicators, two_phase: bool) -> list[tuple[np.ndarray, float]]:
    """Return the steps between samples of surface, velocity, phi and slip, scaled, and what their curvature counts for."""
    h, b, phi = state["h"], state["b"], state["phi"]
    wet = h > DRY * h.max()
    touched = wet[1:] | wet[:-1]
    # neither still water over a bottom nor a uniform layer on a slope is a wave
    surface = np.where(np.abs(np.diff(h + b)) < np.abs(np.diff(h)), np.diff(h + b), np.diff(h)) / numbers.depth
    v = np.where(wet, phi * state["vs"] + (1.0 - phi) * state["vf"], 0.0) / numbers.speed
    slip = np.where(wet, state["vf"] - state["vs"], 0.0) / numbers.speed
    steps = [(surface, 1.0), (np.diff(v), 1.0)]
    if two_phase:
        steps += [(np.diff(np.where(wet, phi, numbers.phi)), ASIDE), (np.diff(slip), ASIDE)]
    return [(np.where(touched, step, 0.0), weight) for step, weight in steps]


def _overtaking(h: np.ndarray, surface: np.ndarray, v: np.ndarray, dx: float, numbers: Indicators) -> float:
    """Return how fast simple waves steepen, 1/s: their speeds v +- a fall by 3/4 of those of v +- 2 a."""
    deep = np.sqrt(numbers.depth / np.maximum(0.5 * (h[1:] + h[:-1]), 0.1 * numbers.depth))
    return max(float((-0.75 * numbers.speed * (v + sign * deep * surface) / dx).max()) for sign in (1.0, -1.0))


def _sharp(step: np.ndarray) -> np.ndarray:
    """Return where a step makes more than half of the change in its neighbourhood: jumps of the sampled function."""
    nearby = np.convolve(step, np.ones(2 * WINDOW + 1), mode="same")
    return (step > 0.5 * nearby) & (step > 1e-9 * max(float(step.max()), 1e-3))
