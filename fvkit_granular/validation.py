"""How good the indicators of `fvkit_granular.indicators` are: random scenes, predicted against measured model errors."""

from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np

from fvkit import Outflow, Wall, WavePropagation, solve
from fvkit_granular.drag import ConstantDrag
from fvkit_granular.friction import CoulombFriction
from fvkit_granular.indicators import indicators
from fvkit_granular.reduced import Reduced
from fvkit_granular.scene import Scene
from fvkit_granular.shallow_water import ShallowWater
from fvkit_granular.two_phase import TwoPhase

#: Kinds of scenes for which the indicators are meant, and others, to know how they fail.
MEANT, BEYOND = ("dam", "rest", "hump", "hump+slip"), ("dam+slip", "friction", "dry")

Random = np.random.Generator


def blob(x: np.ndarray, centre: float, width: float) -> np.ndarray:
    """Return exp(-((x - centre)/width)^2)."""
    return np.exp(-(((x - centre) / width) ** 2))


def _drag(rng: Random) -> float:
    """Drag coefficient, 1/s: none in one case of four, else 1e-2 to 1e3."""
    return 0.0 if rng.random() < 0.25 else float(10.0 ** rng.uniform(-2.0, 3.0))


def _constants(rng: Random) -> dict[str, Any]:
    return {"gamma": float(rng.uniform(0.2, 0.8)), "sources": ConstantDrag(_drag(rng)), "boundary": Outflow()}


def dam(rng: Random, slip: float = 0.0) -> Scene:
    """A dam break with a smeared jump of phi, from rest or with a slip on one side."""
    hl, hr = rng.uniform(1.5, 3.0), rng.uniform(0.8, 1.5)
    left, right = rng.uniform(0.2, 0.75, 2)
    place, width, w = rng.uniform(-1.5, 1.5), 10.0 ** rng.uniform(-1.3, 0.0), slip * rng.uniform(-0.8, 0.8)

    def flow(x: np.ndarray) -> dict[str, Any]:
        return {"h": np.where(x < 0.0, hl, hr), "phi": right + 0.5 * (left - right) * (1.0 - np.tanh((x - place) / width)),
                "vf": np.where(x < 0.0, w, 0.0)}

    return Scene((-5.0, 5.0), float(rng.uniform(0.2, 0.6)), flow, name="dam", **_constants(rng))


def rest(rng: Random) -> Scene:
    """A step of the surface over a bump, with a wavy phi."""
    step, wave, mean = rng.uniform(0.02, 0.1), 10.0 ** rng.uniform(-2.5, -0.7), rng.uniform(0.35, 0.65)
    number, shift, high = rng.integers(1, 4), rng.uniform(0.0, 2.0 * np.pi), rng.uniform(0.1, 0.4)

    def bottom(x: np.ndarray) -> np.ndarray:
        return high * blob(x, 0.6, 0.1)

    def flow(x: np.ndarray) -> dict[str, Any]:
        surface = 1.0 + np.where((x > 0.15) & (x < 0.3), step, 0.0)
        return {"h": surface - bottom(x), "phi": mean + wave * np.sin(2.0 * np.pi * number * x + shift)}

    return Scene((0.0, 1.0), float(rng.uniform(0.05, 0.2)), flow, bottom=bottom, name="rest", **_constants(rng))


def hump(rng: Random, slip: float = 0.0) -> Scene:
    """A moving hump of the depth with a blob of phi, and perhaps slip."""
    high, width, place = rng.uniform(0.05, 0.5), rng.uniform(0.5, 1.2), rng.uniform(-2.0, 2.0)
    phi, more, wide, v = rng.uniform(0.3, 0.55), 10.0 ** rng.uniform(-2.0, -0.7), rng.uniform(0.4, 1.5), rng.uniform(-1.0, 1.0)
    w, spot = slip * rng.uniform(-0.8, 0.8), rng.uniform(-2.0, 2.0)

    def flow(x: np.ndarray) -> dict[str, Any]:
        return {"h": 1.0 + high * blob(x, 0.0, width), "phi": phi + more * blob(x, place, wide), "vs": v,
                "vf": v + w * blob(x, spot, 1.0)}

    return Scene((-5.0, 5.0), float(rng.uniform(0.2, 0.8)), flow, name="hump", **_constants(rng))


def friction(rng: Random) -> Scene:
    """A dam break that slides with Coulomb friction."""
    scene, nu = dam(rng), rng.uniform(0.05, 0.4)
    return Scene(scene.interval, scene.t_end, scene.initial, boundary=Outflow(), gamma=scene.gamma, name="friction",
                 sources=(scene.sources, CoulombFriction(float(nu))))


def dry(rng: Random) -> Scene:
    """A dam break onto dry ground with a blob of phi behind the dam."""
    depth, phi, more, place = rng.uniform(0.5, 2.0), rng.uniform(0.3, 0.5), rng.uniform(-0.2, 0.2), rng.uniform(-2.0, 0.0)

    def flow(x: np.ndarray) -> dict[str, Any]:
        return {"h": np.where(x < 0.0, depth, 0.0), "phi": phi + more * blob(x, place, 0.7)}

    return Scene((-5.0, 5.0), float(rng.uniform(0.2, 0.5)), flow, name="dry", **(_constants(rng) | {"boundary": Wall()}))


KINDS: dict[str, Callable[[Random], Scene]] = {
    "dam": dam, "rest": rest, "hump": hump, "hump+slip": lambda rng: hump(rng, 1.0), "dam+slip": lambda rng: dam(rng, 1.0),
    "friction": friction, "dry": dry,
}


class Measured(NamedTuple):
    """Predicted and measured errors of the depth, over the mean depth, of one scene."""

    kind: str
    scene: Scene
    reduced: float
    shallow: float
    reduced_error: float
    shallow_error: float
    seconds: tuple[float, float, float]


def measure(scene: Scene, cells: int, kind: str = "", backend: str = "auto") -> Measured:
    """Run a scene with the full model and its two limits, and set the differences of the depth beside their prediction."""
    depths, seconds = [], []
    for model in (TwoPhase, Reduced, ShallowWater):
        problem = scene.problem(model, cells)
        solution = solve(problem, WavePropagation(problem.model.default_riemann()), backend=backend, nonhyperbolic="ignore")
        depths.append(solution.observables()["h"])
        seconds.append(solution.stats.seconds)
    full, reduced, shallow = depths
    mean = full.mean()
    found = indicators(scene)
    return Measured(kind, scene, found.reduced, found.shallow, float(np.abs(reduced - full).mean() / mean),
                    float(np.abs(shallow - full).mean() / mean), tuple(seconds))
