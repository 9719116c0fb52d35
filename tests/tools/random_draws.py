"""Random scenes: states side by side over a random bottom, in classes from mild to absurd, the same for the same seed.

On a line two, on a plane four: in quadrants, or in three blobs and around them, turned against the grid in half of the scenes.
"""

import warnings
from collections.abc import Mapping, Sequence
from typing import Any, NamedTuple

import attrs
import numpy as np

from fvkit import Along, Grid, Inflow, Model, Outflow, Periodic, Problem, Source, Wall
from fvkit.problem.directions import in_plane
from fvkit.problem.side import SIDES
from fvkit_granular.boundaries import Hydrograph
from fvkit_granular.sources.drag_laws import ConstantDrag, VelocityDrag
from fvkit_granular.sources.friction_laws import CoulombFriction, Manning, Voellmy

#: Cells of the metre that a scene is long.
CELLS = 60

#: Cells along x and y of the square metre of a scene on a plane: not as many, not square, and of more than one block of compiled code.
PLANE_CELLS = (28, 20)

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

#: The same on a plane, whose ends are drawn from those above, an inflow through a part of a side; half of the scenes are on a slope.
PLANE = {"bare": "mild equations, no sources",
         "rough": "mild equations, drag that grows with the slip, Coulomb and Manning friction",
         "steep": "equations for steep ground, drag that grows with the slip, Voellmy friction"}

#: Settings of each kind of scenes, by the option of the command.
FAMILIES = {"": SETTINGS, "inflow": INFLOWS, "plane": PLANE}

#: Unit vectors inwards of the sides of a plane.
INWARDS = dict(zip((name for pair in SIDES for name in pair), ((1.0, 0.0), (-1.0, 0.0), (0.0, 1.0), (0.0, -1.0)), strict=True))

#: Bottoms, in turn.
BOTTOMS = {"step": "flat, or a step of up to 2 m", "noise": "a random height in every cell, up to 2 m",
           "slope": "a slope up to 10 m/m", "islands": "one to four hills or blocks up to 2 m, which the water does not cover"}


#: The datum of every bottom, m: kernels for a bottom that is 0 everywhere have other code.
DATUM = 1.0


class Draw(NamedTuple):
    """States side by side: depth, solid fraction and velocities of each, and the height of the bottom of all but the first."""

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


def family_of(setting: str | None) -> str:
    """The key of `FAMILIES` that a setting belongs to; of None that of lines."""
    return next((name for name, settings in FAMILIES.items() if setting in settings), "")


def draw(seed: int, index: int, g: float = 9.81, gamma: float = 0.5, states: int = 2) -> tuple[str, Draw]:
    """Return the class and the data of a problem; the same for the same seed, index and number of states."""
    rng = np.random.default_rng([seed, index])
    kind = kind_of(index)
    h, phi, (vs, vf) = rng.uniform(0.01, 5.0, states), rng.uniform(0.0, 1.0, states), rng.uniform(-3.0, 3.0, (2, states))
    if kind in ("thin", "vanishing"):
        h = 10.0 ** rng.uniform(-12.0 if kind == "thin" else -300.0, np.log10(5.0), states)
    elif kind == "one phase":
        phi = rng.choice([0.0, 1.0, 1e-12, 1.0 - 1e-12], states)
    elif kind == "fast":
        vs = rng.uniform(-50.0, 50.0, states) * np.sqrt(g * h)
        vf = vs + rng.uniform(-0.5, 0.5, states)
    elif kind == "slipping":
        beta = np.sqrt(0.5 * (1.0 - phi) * (1.0 - gamma))
        vs = vf + rng.choice([-1.0, 1.0], states) * np.sqrt(g * h) * rng.uniform(1.6 * beta, 2.2)
    elif kind == "dry side":
        side = rng.integers(0, states)
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
    kind, setting, bottom : keys of `CLASSES`, of `SETTINGS`, `INFLOWS` or `PLANE`, and of `BOTTOMS`.
    gamma : density ratio, .05 to .98.
    flow : depth, m, solid fraction, velocities of solid and fluid, m/s, along x, each of the shape of the grid.
    b : height of the bottom, m, of that shape.
    drag : D and its growth with the slip, 1/s and 1/m: 0, or 1e-3 to 1e12.
    nu : coefficient of friction, 0 to 2; None for no friction.
    comes : depth, m, solid fraction and velocity of what flows in, and the rough part of its friction, 0 to 1.
    across : velocities of solid and fluid along y, m/s; None on a line.
    ends : the setting whose ends a plane has, and the side of its inflow.
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
    across: tuple[np.ndarray, np.ndarray] | None = None
    ends: tuple[str, str] = ("", "")

    def model(self, kind: type[Model]) -> Model:
        """Return a model of a class with the scene's density ratio, where it has one."""
        steep: dict[str, Any] = {"slope": "steep"} if self.setting == "steep" else {}
        return kind(**steep | ({"gamma": self.gamma} if "gamma" in kind.parameter_names() else {}))

    def state(self, model: Any, h: Any, phi: Any, *along: Any) -> np.ndarray:
        """Return the conserved values of velocities of solid and fluid along x, and on a plane along y."""
        along_x, *along_y = (model.conserved_from(h, phi, *along[k:k + 2]) for k in range(0, len(along), 2))
        return in_plane(model, along_x, *along_y) if along_y else np.asarray(along_x)

    def boundary(self, model: Any) -> Any:
        """Return the boundary of both ends, or all sides."""
        h, phi, v, _ = self.comes
        kept, side = self.ends if self.across else (self.setting, "")
        inflow = [v * part for part in INWARDS.get(side, (1.0,)) for _ in range(2)]
        given: dict[str, Any] = {"box": Wall(), "channel": Outflow(), "ring": Periodic(drop=0.0),
                                 "torrent": (Hydrograph(0.0, h * v, phi, h), Outflow()),
                                 "stream": (Inflow(self.state(model, h, phi, *inflow)), Outflow())}
        return {side: Along(0.3, 0.7, given[kept][0])} if self.across and kept in INFLOWS else given[kept]

    def sources(self, model: Model) -> tuple[Source, ...]:
        """Return the sources; no drag for models with one velocity."""
        rough, dry = self.comes[3], () if self.nu is None else (CoulombFriction(self.nu),)
        drag, voellmy = VelocityDrag(*self.drag), Voellmy(0.5 * (self.nu or 0.0), 1e4 ** (1.0 - rough))
        given: dict[str, tuple[Source, ...]] = {
            "box": (), "channel": (ConstantDrag(self.drag[0]),), "ring": (drag, *dry),
            "torrent": (drag, voellmy), "stream": (ConstantDrag(self.drag[0]), Manning(0.2 * rough)),
            "bare": (), "rough": (drag, *dry, Manning(0.2 * rough)), "steep": (drag, voellmy)}
        return tuple(one for one in given[self.setting] if len(model.phases) > 1 or not one.between_phases)

    def problem(self, kind: type[Model]) -> Problem:
        """Return the problem for a class of models. Its bottom may be steep, and rough at an outflow."""
        model: Any = self.model(kind)
        grid = Grid((0.0, 0.0), (1.0, 1.0), PLANE_CELLS) if self.across else Grid(0.0, 1.0, CELLS)
        with warnings.catch_warnings():
            warnings.filterwarnings("ignore", "Outflow: `b` falls|steepest slope")
            return Problem(model, grid, self.state(model, *self.flow, *(self.across or ())), LONGEST, {"b": self.b},
                           self.boundary(model), self.sources(model))


def random_scene(seed: int, index: int, settings: Mapping[str, str] = SETTINGS) -> RandomScene:
    """Return a random scene; the same for the same seed, index and settings."""
    rng = np.random.default_rng([seed, index, 1])
    gamma = float(rng.uniform(0.05, 0.98))
    counted = _plane(rng) if settings is PLANE else (np.arange(CELLS) + 0.5,)
    places, states = [one / CELLS for one in counted], 2 ** len(counted)
    kind, drawn = draw(seed, index, gamma=gamma, states=states)
    setting, bottom = setting_of(index, settings), bottom_of(index, settings)
    part = _parts(places, rng)
    h, phi, vs, vf = (values[part] for values in drawn[:4])
    if kind == "one phase" and rng.random() < 0.5:
        rare = 10.0 ** rng.uniform(-16.0, -1.0, states)
        phi = np.where(rng.random(states) < 0.5, rare, 1.0 - rare)[part]
    shape, level = _shape(bottom, drawn.step * (part > 0), places, rng)
    if level:
        h = np.maximum(h - shape, 0.0)
    nu = 0.0 if rng.random() < 0.1 else float(rng.uniform(0.0, 2.0))
    scene = RandomScene(kind, setting, bottom, gamma, (h, phi, vs, vf), DATUM + shape, (_drag(rng), _drag(rng)), nu)
    if settings is SETTINGS:
        return scene
    depth = 10.0 ** rng.uniform(-3.0, np.log10(5.0))
    comes = depth, float(rng.uniform(0.0, 1.0)), float(rng.uniform(0.0, 3.0) * np.sqrt(9.81 * depth)), float(rng.uniform(0.0, 1.0))
    scene = attrs.evolve(scene, b=scene.b + rng.uniform(-1.0, 1.0) * counted[0] / CELLS, comes=comes)
    return scene if settings is INFLOWS else _turned(attrs.evolve(scene, b=scene.b if rng.random() < 0.5 else DATUM + shape), part, rng)


def _plane(rng: np.random.Generator) -> tuple[np.ndarray, np.ndarray]:
    """Return two coordinates of the cells of a plane, 0 to CELLS through its centre, in half of all draws along the grid."""
    x, y = np.meshgrid(*((np.arange(cells) + 0.5) / cells - 0.5 for cells in PLANE_CELLS))
    angle = 0.5 * np.pi * (rng.integers(0, 4) if rng.random() < 0.5 else rng.uniform(0.0, 4.0))
    c, s = np.round([np.cos(angle), np.sin(angle)], 15)
    return CELLS * (0.5 + c * x + s * y), CELLS * (0.5 + c * y - s * x)


def _parts(places: Sequence[np.ndarray], rng: np.random.Generator) -> np.ndarray:
    """Return which state each cell has."""
    part = sum((place > 0.5) * 2**k for k, place in enumerate(places))
    if len(places) > 1 and rng.random() < 0.5:
        part = np.zeros(places[0].shape, dtype=int)
        for k in range(1, 4):
            part[_distance(places, rng) < 1.0] = k
    return np.asarray(part)


def _turned(scene: RandomScene, part: np.ndarray, rng: np.random.Generator) -> RandomScene:
    """Return a scene on a plane whose velocities have any direction, in half of all draws that of both phases, and with any ends."""
    (h, phi, *v), angle = scene.flow, rng.uniform(0.0, 2.0 * np.pi, (2, part.max() + 1))
    if scene.kind == "one velocity" or rng.random() < 0.5:
        angle[1] = angle[0]
    along, across = ((v[0] * turn(angle[0])[part], v[1] * turn(angle[1])[part]) for turn in (np.cos, np.sin))
    ends = str(rng.choice([*SETTINGS, *INFLOWS])), str(rng.choice(list(INWARDS)))
    return attrs.evolve(scene, flow=(h, phi, *along), across=across, ends=ends)


def _drag(rng: np.random.Generator) -> float:
    return 0.0 if rng.random() < 0.2 else float(10.0 ** rng.uniform(-3.0, 12.0))


def _distance(places: Sequence[np.ndarray], rng: np.random.Generator) -> np.ndarray:
    """Return the distance of the cells from a random place, over a random radius."""
    return np.sqrt(sum((place - rng.uniform(0.0, 1.0)) ** 2 for place in places)) / rng.uniform(0.02, 0.2)


def _shape(bottom: str, step: np.ndarray, places: Sequence[np.ndarray], rng: np.random.Generator) -> tuple[np.ndarray, bool]:
    """Return the height of a bottom, m, and whether depths count from the level 0 rather than from the bottom."""
    if bottom == "step":
        return step, False
    height = 10.0 ** rng.uniform(-3.0, np.log10(2.0))
    if bottom == "noise":
        return height * rng.uniform(-1.0, 1.0, step.shape), bool(rng.random() < 0.5)
    if bottom == "slope":
        return rng.choice([-1.0, 1.0]) * 5.0 * height * (places[0] - 0.5), bool(rng.random() < 0.5)
    shape, block = np.zeros(step.shape), rng.random() < 0.5
    for _ in range(rng.integers(1, 5)):
        distance = _distance(places, rng)
        inside = distance < 1.0
        shape = np.maximum(shape, height * np.where(inside, 1.0 if block else np.cos(0.5 * np.pi * distance) ** 2, 0.0))
    return shape, True
