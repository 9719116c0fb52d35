"""What a scene is, in a few numbers, and the model errors that they predict. No simulation.

Without slip, all that the reduced model misses is that phi spreads by inner waves. They obey a telegraph equation with speed
c_i and damping K, so that phi has a root mean square spread of

    X = (c_i/K) sqrt(2 (K T - 1 + exp(-K T))),   c_i = a sqrt((1-phi)(1-gamma)/2),   K = D rho/(phi (1-phi)),

c_i T without drag and the diffusive sqrt(2 kappa T), kappa = c_i^2/K, with much. Shallow water misses rho as a whole, which acts
over the distance a T. With S(y) the mean of |rho(x) - (rho(x-y) + rho(x+y))/2|/rho of the initial state,

    e_red = | 0.7 S(X), M(F, tau), 0.6 M(G, T) |,   e_sw = | 0.4 S(a T), M(F, T - tau), M(H, T), Q |,
    M(F, t) = mean |F(x + a t) - F(x - a t)| / (2 a h),   tau = (1 - exp(-K T))/K

predict the mean error of the depth over the mean depth; | | is the root of the sum of squares. M is what a wrong flux h dv
leaves behind when it acts for the time t: two waves that part. Mixture velocity and volume flux differ by
phi (1-phi)(1-gamma)/rho times the slip w = vf - vs. The reduced model keeps the first, so it errs while slip lasts; shallow water
keeps the second, so it errs when slip is gone:

    F = phi (1-phi)(1-gamma)/rho h w.

Slip moves phi, by d_x(phi (1-phi) h w) tau/h: shallow water misses half of that, the mean in time, on top of rho. And slip
carries momentum, which shallow water misses too: it presses like P = phi (1-phi) h w^2, and leaves

    Q = mean |P(x) - (P(x + a T) + P(x - a T))/2| / (a^2 h)  times the share (1 - exp(-2 K T))/(2 K T) for which it lasts.

Friction at the bed slows the solid alone, which makes a slip of R (T - tau)/(K T) at most, that goes into F to make G; and in
shallow water it acts without buoyancy, H = 0.3 h T (R_sw - R_red), at most half of the speed. The speed is that of linear waves.

All derived here; the numbers 0.7, 0.4, 0.6, 0.3 and the half are fitted to random scenes (tests/tools/advice_validation.py).
"""

import math
from typing import Any

import attrs
import numpy as np

from fvkit import maximum
from fvkit_granular.models.reduced import Reduced
from fvkit_granular.models.shallow_water import ShallowWater
from fvkit_granular.models.two_phase import TwoPhase
from fvkit_granular.scenes.scene import Scene
from fvkit_granular.sources.drag import Drag
from fvkit_granular.sources.friction import BasalFriction
from fvkit_granular.sources.slip_decay import drag_rate

#: Points at which a scene is looked at.
POINTS = 2000
#: Share of the largest depth below which a point is dry.
DRY = 1e-6
#: Factors of the indicators, fitted: spread of phi, density, slip by friction, friction without buoyancy, share of the speed.
SPREAD, DENSITY, SLOWED, HEAVIER, HALF = 0.7, 0.4, 0.6, 0.3, 0.5


@attrs.frozen
class Indicators:
    """Non-dimensional numbers of a scene and the errors that they predict.

    Attributes
    ----------
    depth : mean depth of the interval, m.
    speed : wave speed a of the mean wet depth, m/s.
    phi, phi_range : mean solid fraction where it is wet, and largest less smallest.
    froude : largest speed over sqrt(g h).
    slip : largest |vf - vs| over 2 a beta, below which characteristic speeds are real.
    damping : K T, drag times the run time.
    spread : X, m.
    dry_share : share of the interval that is dry at the start.
    reduced, shallow : predicted mean error of the depth over the mean depth, of the reduced model and of shallow water.
    """

    depth: float
    speed: float
    phi: float
    phi_range: float
    froude: float
    slip: float
    damping: float
    spread: float
    dry_share: float
    reduced: float
    shallow: float


def sampled(scene: Scene) -> dict[str, np.ndarray]:
    """Return x, h, phi, vs, vf, b at ``POINTS`` points of the initial state, velocities 0 where the scene names none."""
    if len(scene.axes) > 1:
        raise ValueError("advice was validated for scenes with one axis alone, got one with two: run the models beside each "
                         "other, with gr.compare or `fvkit compare`")
    lower, upper = scene.interval
    x = lower + (np.arange(POINTS) + 0.5) * (upper - lower) / POINTS
    given = scene.flow(x) | {"b": scene.height(x)}
    return {"x": x} | {name: np.array(np.broadcast_to(given[name], x.shape), dtype=float)
                       for name in ("h", "phi", "vs", "vf", "b")}


def indicators(scene: Scene, state: dict[str, np.ndarray] | None = None) -> Indicators:
    """Return the numbers of a scene that is not dry, from its initial state, bottom, sources, constants and times alone.

    ``state`` is its `sampled` state, if at hand.
    """
    state = sampled(scene) if state is None else state
    x, h, phi, w = state["x"], state["h"], state["phi"], state["vf"] - state["vs"]
    g, gamma, time = scene.g, scene.gamma, scene.t_end
    wet = h > DRY * h.max()
    if not wet.any():
        raise ValueError(f"the scene {scene.name or ''} is dry everywhere at the start, and advice is of the initial state: run "
                         "it with two numbers of cells and with two models, and compare")
    both = wet & (phi > 0.0) & (phi < 1.0)
    w = np.where(both, w, 0.0)
    rho = phi + gamma * (1.0 - phi)
    mean_phi, a = float(phi[wet].mean()), float(np.sqrt(g * h[wet].mean()))
    rate = drag_of(scene, mean_phi, float(np.abs(w[both]).mean()) if both.any() else 0.0)
    tau = lasting(rate, time)
    spread = a * float(np.sqrt(0.5 * (1.0 - mean_phi) * (1.0 - gamma))) * spreading(rate, time)
    flux = np.where(wet, phi * (1.0 - phi) * (1.0 - gamma) / rho * h, 0.0)
    period = period_of(scene)
    slowed, heavier = _friction(scene, state, wet, a, rate * time, tau)

    gathered = np.where(wet, np.gradient(phi * (1.0 - phi) * h * w, x) / maximum(h, DRY * h.max()), 0.0) * (0.5 * tau)
    moved = np.clip(rho + (1.0 - gamma) * gathered, gamma, 1.0)

    def left_behind(wrong: np.ndarray, duration: float) -> float:
        return float(np.abs(around(x, wrong, a * duration, period) @ (1.0, -1.0)).mean()) / (2.0 * a * float(h.mean()))

    pressing = np.where(wet, phi * (1.0 - phi) * h * w * w, 0.0)
    unspread = np.abs(pressing - around(x, pressing, a * time, period).mean(axis=1)).mean() / (a * a * h.mean())
    pressed = float(unspread) * lasting(2.0 * rate, time) / time
    root = np.sqrt(g * h[wet])
    fastest = np.maximum(np.abs(np.where(phi > 0.0, state["vs"], 0.0)), np.abs(np.where(phi < 1.0, state["vf"], 0.0)))[wet]
    safe = 2.0 * np.sqrt(g * h[both] * 0.5 * (1.0 - phi[both]) * (1.0 - gamma))
    return Indicators(
        depth=float(h.mean()), speed=a, phi=mean_phi, phi_range=float(np.ptp(phi[wet])), froude=float((fastest / root).max()),
        slip=float((np.abs(w[both]) / safe).max()) if both.any() else 0.0, damping=rate * time, spread=spread,
        dry_share=float(1.0 - wet.mean()),
        reduced=math.hypot(SPREAD * unevenness(x, rho, wet, spread, period), left_behind(flux * w, tau),
                           SLOWED * left_behind(flux * slowed, time)),
        shallow=math.hypot(DENSITY * unevenness(x, moved, wet, a * time, period), left_behind(flux * w, time - tau),
                           left_behind(h * heavier, time), pressed))


def around(x: np.ndarray, values: np.ndarray, y: float, period: float | None = None) -> np.ndarray:
    """Return values(x + y), values(x - y), (n, 2), the ends continued, or wrapped round where there is a period."""
    return np.stack([np.interp(x + y, x, values, period=period), np.interp(x - y, x, values, period=period)], axis=1)


def period_of(scene: Scene) -> float | None:
    """Return the length of a periodic interval, m; None where its ends are others."""
    return scene.interval[1] - scene.interval[0] if scene.boundary[0].reads == "opposite" else None


def drag_of(scene: Scene, phi: float, slip: float) -> float:
    """Return K, 1/s, of all drag laws of a scene together, at the mean state; 0 where a phase is absent."""
    if not 0.0 < phi < 1.0:
        return 0.0
    model: Any = scene.model(TwoPhase)
    drag = sum(float(law.bounded(model, phi, slip)) for law in scene.sources if isinstance(law, Drag))
    return drag * float(drag_rate(phi, 1.0 - phi, scene.gamma))


def _friction(scene: Scene, state: dict[str, np.ndarray], wet: np.ndarray, a: float, damping: float,
              tau: float) -> tuple[np.ndarray, np.ndarray]:
    """Return the slip that friction makes, and the excess of velocity of shallow water for want of its buoyancy, m/s."""
    x, time, period = state["x"], scene.t_end, period_of(scene)
    laws = [law for law in scene.sources if isinstance(law, BasalFriction)]
    if not laws:
        return np.zeros_like(x), np.zeros_like(x)
    rho = state["phi"] + scene.gamma * (1.0 - state["phi"])
    mean = (state["phi"] * state["vs"] + scene.gamma * (1.0 - state["phi"]) * state["vf"]) / rho
    surface = around(x, state["h"] + state["b"], a * time, period) @ (-1.0, 1.0)
    v = np.where(wet, around(x, mean, a * time, period) @ (0.5, 0.5) + scene.g / (2.0 * a) * surface, 0.0)
    speed, depth = np.abs(v), maximum(state["h"], DRY * state["h"].max())

    def slowing(kind: type) -> list[np.ndarray]:
        model: Any = scene.model(kind)
        loads = model.basal_load(tuple(model.conserved_from(depth, state["phi"], v, v)))
        return [sum(law.bounded(model, load + 0.0 * depth, depth, speed) for law in laws) for load in loads]

    (water,), (mixture,), (solid, fluid) = (slowing(kind) for kind in (ShallowWater, Reduced, TwoPhase))
    duration = (time - tau) / damping if damping > 1e-6 else 0.5 * time
    return (np.sign(v) * np.minimum(np.abs(solid - fluid) * duration, speed),
            np.sign(v) * np.minimum(HEAVIER * time * np.abs(water - mixture), HALF * speed))


def spreading(rate: float, time: float) -> float:
    """Return sqrt(2 (k t - 1 + exp(-k t)))/k, s: t for k = 0."""
    z = rate * time
    if z < 1e-3:
        return time * (1.0 - z / 6.0)
    return float(np.sqrt(2.0 * (z + np.expm1(-z)))) / rate


def lasting(rate: float, time: float) -> float:
    """Return (1 - exp(-k t))/k, s: t for k = 0."""
    return time if rate * time < 1e-12 else float(-np.expm1(-rate * time)) / rate


def unevenness(x: np.ndarray, rho: np.ndarray, wet: np.ndarray, y: float, period: float | None = None) -> float:
    """Return S(y), the mean over wet points of |rho(x) - (rho(x-y) + rho(x+y))/2|/rho(x), the ends continued."""
    return float((np.abs(rho - around(x, rho, y, period).mean(axis=1)) / maximum(rho, 1e-300))[wet].mean())
