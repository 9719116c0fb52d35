"""Random scenes: two states side by side over a random bottom, in classes from mild to absurd, the same for the same seed."""

import warnings
from collections.abc import Mapping
from typing import Any, NamedTuple

import attrs
import numpy as np

from fvkit import Grid, Inflow, Model, Outflow, Periodic, Problem, Source, Wall
from fvkit_granular.boundaries import Hydrograph
from fvkit_granular.sources.drag_laws import ConstantDrag, VelocityDrag
from fvkit_granular.sources.friction_laws import CoulombFriction, Manning, Voellmy

#: Cells of the metre that a scene is long.
CELLS = 60

#: No run takes longer, s: where nothing is deep enough to move, the first step is as long as it can be.
LONGEST = 100.0

#: The classes, drawn in turn. Depths in metres; half of all draws have a bottom step of up to 2 m.
CLASSES = {
    "generic": "depths 0.01 to 5, velocities up to 3 m/s", "thin": "depths down to 1e-12", "vanishing": "depths down to 1e-300",
    "one phase": "solid fraction 0, 1, 1e-12 or 1 - 1e-12", "fast": "Froude numbers up to 50, more over hills",
    "slipping": "slip in and around the range of complex speeds", "dry side": "a side, or one of its phases, absent",
    "one velocity": "both phases move together",
}

#: Boundaries and sources, in turn too: each is a kernel of its own, so the classes and bottoms share three.
SETTINGS = {"box": "walls, no sources", "channel": "open ends, constant drag",
            "ring": "periodic, drag that grows with the slip, dry friction"}

#: The same where scenes with an inflow are wanted, all on a slope of -1 to 1 m/m besides their bottom.
INFLOWS = {"torrent": "a hydrograph and an open end, Voellmy friction, drag that grows with the slip",
           "stream": "a given state and an open end, Manning friction, constant drag"}

#: Bottoms, in turn.
BOTTOMS = {"step": "flat, or a step of up to 2 m", "noise": "a random height in every cell, up to 2 m",
           "slope": "a slope up to 10 m/m", "islands": "one to four hills or blocks up to 2 m, which the water does not cover"}


#: The datum of every bottom, m: kernels for a bottom that is 0 everywhere have other code.
DATUM = 1.0


class Draw(NamedTuple):
    """A Riemann problem: depth, solid fraction and velocities of both sides, and the height of the right bottom."""

    h: np.ndarray
    phi: np.ndarray
    vs: np.ndarray
    vf: np.ndarray
    step: float


def kind_of(index: int) -> str:
    """The class of a draw."""
    return list(CLASSES)[index % len(CLASSES)]


def setting_of(index: int, settings: Mapping[str, str] = SETTINGS) -> str:
    """The setting of a random scene."""
    return list(settings)[index // len(CLASSES) % len(settings)]


def bottom_of(index: int, settings: Mapping[str, str] = SETTINGS) -> str:
    """The kind of bottom of a random scene."""
    return list(BOTTOMS)[index // (len(CLASSES) * len(settings)) % len(BOTTOMS)]


def draw(seed: int, index: int, g: float = 9.81, gamma: float = 0.5) -> tuple[str, Draw]:
    """Return the class and the data of a problem; the same for the same seed and index."""
    rng = np.random.default_rng([seed, index])
    kind = kind_of(index)
    h, phi, (vs, vf) = rng.uniform(0.01, 5.0, 2), rng.uniform(0.0, 1.0, 2), rng.uniform(-3.0, 3.0, (2, 2))
    if kind in ("thin", "vanishing"):
        h = 10.0 ** rng.uniform(-12.0 if kind == "thin" else -300.0, np.log10(5.0), 2)
    elif kind == "one phase":
        phi = rng.choice([0.0, 1.0, 1e-12, 1.0 - 1e-12], 2)
    elif kind == "fast":
        vs = rng.uniform(-50.0, 50.0, 2) * np.sqrt(g * h)
        vf = vs + rng.uniform(-0.5, 0.5, 2)
    elif kind == "slipping":
        beta = np.sqrt(0.5 * (1.0 - phi) * (1.0 - gamma))
        vs = vf + rng.choice([-1.0, 1.0], 2) * np.sqrt(g * h) * rng.uniform(1.6 * beta, 2.2)
    elif kind == "dry side":
        side = rng.integers(0, 2)
        what = rng.integers(0, 3)
        h[side], phi[side] = (0.0, 0.5) if what == 0 else (h[side], float(what - 1))
    elif kind == "one velocity":
        vf = vs.copy()
    return kind, Draw(h, phi, vs, vf, rng.uniform(-2.0, 2.0) if rng.random() < 0.5 else 0.0)


@attrs.frozen(eq=False)
class RandomScene:
    """A random scene, for any model.

    Parameters
    ----------
    kind, setting, bottom : keys of `CLASSES`, `SETTINGS` or `INFLOWS`, and `BOTTOMS`.
    gamma : density ratio, .05 to .98.
    flow : depth, m, solid fraction, velocities of solid and fluid, m/s, each (CELLS,).
    b : height of the bottom, m, (CELLS,).
    drag : D and its growth with the slip, 1/s and 1/m: 0, or 1e-3 to 1e12.
    nu : coefficient of friction, 0 to 2; None for no friction.
    comes : depth, m, solid fraction and velocity of what flows in, and the rough part of its friction, 0 to 1.
    """

    kind: str
    setting: str
    bottom: str
    gamma: float
    flow: tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]
    b: np.ndarray
    drag: tuple[float, float]
    nu: float | None
    comes: tuple[float, float, float, float] = (0.0, 0.0, 0.0, 0.0)

    def model(self, kind: type[Model]) -> Model:
        """Return a model of a class with the scene's density ratio, where it has one."""
        return kind(**{"gamma": self.gamma} if "gamma" in kind.parameter_names() else {})

    def boundary(self, model: Any) -> Any:
        """Return the boundary of both ends."""
        h, phi, v, _ = self.comes
        given: dict[str, Any] = {"box": Wall(), "channel": Outflow(), "ring": Periodic(drop=0.0),
                                 "torrent": (Hydrograph(0.0, h * v, phi, h), Outflow()),
                                 "stream": (Inflow(model.conserved_from(h, phi, v, v)), Outflow())}
        return given[self.setting]

    def sources(self, model: Model) -> tuple[Source, ...]:
        """Return the sources; no drag for models with one velocity."""
        rough, dry = self.comes[3], () if self.nu is None else (CoulombFriction(self.nu),)
        given: dict[str, tuple[Source, ...]] = {
            "box": (), "channel": (ConstantDrag(self.drag[0]),), "ring": (VelocityDrag(*self.drag), *dry),
            "torrent": (VelocityDrag(*self.drag), Voellmy(0.5 * (self.nu or 0.0), 1e4 ** (1.0 - rough))),
            "stream": (ConstantDrag(self.drag[0]), Manning(0.2 * rough))}
        return tuple(one for one in given[self.setting] if len(model.phases) > 1 or not one.between_phases)

    def problem(self, kind: type[Model]) -> Problem:
        """Return the problem for a class of models. Its bottom may be steep, and rough at an outflow."""
        model: Any = self.model(kind)
        with warnings.catch_warnings():
            warnings.filterwarnings("ignore", "Outflow: `b` falls|steepest slope")
            return Problem(model, Grid(0.0, 1.0, CELLS), model.conserved_from(*self.flow), LONGEST, {"b": self.b}, self.boundary(model),
                           self.sources(model))


def random_scene(seed: int, index: int, settings: Mapping[str, str] = SETTINGS) -> RandomScene:
    """Return a random scene; the same for the same seed, index and settings."""
    rng = np.random.default_rng([seed, index, 1])
    gamma = float(rng.uniform(0.05, 0.98))
    kind, drawn = draw(seed, index, gamma=gamma)
    setting, bottom = setting_of(index, settings), bottom_of(index, settings)
    side = (np.arange(CELLS) >= CELLS // 2).astype(int)
    h, phi, vs, vf = (values[side] for values in drawn[:4])
    if kind == "one phase" and rng.random() < 0.5:
        rare = 10.0 ** rng.uniform(-16.0, -1.0, 2)
        phi = np.where(rng.random(2) < 0.5, rare, 1.0 - rare)[side]
    shape, level = _shape(bottom, drawn.step * side, rng)
    if level:
        h = np.maximum(h - shape, 0.0)
    nu = 0.0 if rng.random() < 0.1 else float(rng.uniform(0.0, 2.0))
    scene = RandomScene(kind, setting, bottom, gamma, (h, phi, vs, vf), DATUM + shape, (_drag(rng), _drag(rng)), nu)
    if setting not in INFLOWS:
        return scene
    depth = 10.0 ** rng.uniform(-3.0, np.log10(5.0))
    comes = depth, float(rng.uniform(0.0, 1.0)), float(rng.uniform(0.0, 3.0) * np.sqrt(9.81 * depth)), float(rng.uniform(0.0, 1.0))
    return attrs.evolve(scene, b=scene.b + rng.uniform(-1.0, 1.0) * (np.arange(CELLS) + 0.5) / CELLS, comes=comes)


def _drag(rng: np.random.Generator) -> float:
    return 0.0 if rng.random() < 0.2 else float(10.0 ** rng.uniform(-3.0, 12.0))


def _shape(bottom: str, step: np.ndarray, rng: np.random.Generator) -> tuple[np.ndarray, bool]:
    """Return the height of a bottom, m, and whether depths count from the level 0 rather than from the bottom."""
    if bottom == "step":
        return step, False
    height, x = 10.0 ** rng.uniform(-3.0, np.log10(2.0)), (np.arange(CELLS) + 0.5) / CELLS
    if bottom == "noise":
        return height * rng.uniform(-1.0, 1.0, CELLS), bool(rng.random() < 0.5)
    if bottom == "slope":
        return rng.choice([-1.0, 1.0]) * 5.0 * height * (x - 0.5), bool(rng.random() < 0.5)
    shape, block = np.zeros(CELLS), rng.random() < 0.5
    for _ in range(rng.integers(1, 5)):
        distance = np.abs(x - rng.uniform(0.0, 1.0)) / rng.uniform(0.02, 0.2)
        inside = distance < 1.0
        shape = np.maximum(shape, height * np.where(inside, 1.0 if block else np.cos(0.5 * np.pi * distance) ** 2, 0.0))
    return shape, True
