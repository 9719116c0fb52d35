"""Quantities of the granular models: units, long names after the CF conventions, and conversion of primitive variables."""

from collections.abc import Callable, Mapping, Sequence
from typing import Any

import numpy as np

from fvkit import validation
from fvkit.problem.cell_averages import levelled
from fvkit.problem.directions import in_plane
from fvkit.problem.grid import NAMES
from fvkit.problem.model import Model
from fvkit.problem.questions import Question

QUANTITIES = {
    "h": ("m", "depth of the flow"),
    "hs": ("m", "depth of the solid"),
    "hf": ("m", "depth of the fluid"),
    "hs vs": ("m2 s-1", "discharge of the solid"),
    "hf vf": ("m2 s-1", "discharge of the fluid"),
    "h v": ("m2 s-1", "discharge"),
    "rho h": ("m", "mass per area over the density of the solid"),
    "rho h v": ("m2 s-1", "momentum per area over the density of the solid"),
    "phi": ("1", "volume fraction of the solid"),
    "vs": ("m s-1", "velocity of the solid"),
    "vf": ("m s-1", "velocity of the fluid"),
    "v": ("m s-1", "velocity of the mixture"),
    "surface": ("m", "height of the free surface"),
    "b": ("m", "height of the bottom"),
}

#: Quantities of two-layer flow, where the first mass is the lower layer.
LAYERS = QUANTITIES | {
    "hs": ("m", "depth of the lower layer"),
    "hf": ("m", "depth of the upper layer"),
    "hs vs": ("m2 s-1", "discharge of the lower layer"),
    "hf vf": ("m2 s-1", "discharge of the upper layer"),
    "phi": ("1", "share of the lower layer in the depth"),
    "vs": ("m s-1", "velocity of the lower layer"),
    "vf": ("m s-1", "velocity of the upper layer"),
    "interface": ("m", "height of the interface between the layers"),
}

#: More methods of these models: friction and ends call the first two, rain the last.
QUESTIONS: tuple[Question, ...] = (
    *Model.questions,
    Question("depth", ("q",), "number", "friction, ends"),
    Question("basal_load", ("q",), "one per phase", "friction"),
    Question("poured", ("q", "solid", "fluid"), "masses", "rain"),
)


def broadcast(h: Any, phi: Any, vs: Any, vf: Any) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """Return h, phi, vs, vf as arrays of one shape; velocities of an absent phase, which may have any value, are set to 0.

    A ValueError for a depth that is negative, phi outside [0, 1], or a value that is not finite.
    """
    depth, fraction, solid, fluid = np.broadcast_arrays(
        *(validation.floats(value, name) for name, value in (("h", h), ("phi", phi), ("vs", vs), ("vf", vf))))
    solid = np.where(depth * fraction > 0.0, solid, 0.0)
    fluid = np.where(depth * (1.0 - fraction) > 0.0, fluid, 0.0)
    for name, value, allowed, rule in (("h", depth, depth >= 0.0, "finite and >= 0"),
                                       ("phi", fraction, (fraction >= 0.0) & (fraction <= 1.0),
                                        "in [0, 1] (a fraction: 60 % is 0.6)"),
                                       ("vs", solid, True, "finite where there is solid"),
                                       ("vf", fluid, True, "finite where there is fluid")):
        good = np.isfinite(value) & allowed
        if not good.all():
            raise ValueError(f"`{name}` must be {rule}, got {validation.shown(value[~good].ravel()[0])}")
    return depth, fraction, solid, fluid


def velocities(axes: int) -> tuple[str, ...]:
    """Return the names of the velocities of a flow: vs and vf; with two axes vs_x, vf_x, vs_y and vf_y, those along x first."""
    return ("vs", "vf") if axes == 1 else tuple(f"{name}_{axis}" for axis in NAMES for name in ("vs", "vf"))


def flow_names(axes: int) -> tuple[str, ...]:
    """Return the names of the primitive variables of a flow: h, phi and the velocities."""
    return ("h", "phi", *velocities(axes))


def whole_flow(given: Any, axes: int = 1, name: str = "initial(x)", what: str = "`initial(x)`: a flow") -> dict[str, Any]:
    """Return the primitive variables of a user's mapping, velocities 0 if missing; ``name`` and ``what`` are for errors."""
    flow = dict(validation.mapping(given, name, "{'h': 1.0, 'phi': 0.5}"))
    moving = velocities(axes)
    unknown = [key for key in flow if key not in ("h", "phi", *moving)]
    if unknown or not {"h", "phi"} <= flow.keys():
        where = " on a grid with two axes" if axes > 1 else ""
        raise ValueError(f"{what}{where} needs h and phi, and takes {', '.join(moving[:-1])} and {moving[-1]} (0 where missing; "
                         "an initial state may give surface, its level, for h); got "
                         f"{', '.join(map(str, flow)) or 'nothing'}")
    return dict.fromkeys(moving, 0.0) | flow


def over_ground(given: Any, places: Sequence[np.ndarray], ground: Callable[..., Any] | None,
                depth: Callable[[np.ndarray], np.ndarray]) -> Any:
    """Return primitive variables with ``surface`` replaced by h = depth(surface - bottom); unchanged without it.

    ``ground`` is the function of the ``places`` x, or x and y, m, to the bottom, m, None where it is unknown. A ValueError where
    h and ``surface`` contradict each other, or the bottom is unknown and h is missing.
    """
    if not isinstance(given, Mapping) or "surface" not in given:
        return given
    flow = {name: value for name, value in given.items() if name != "surface"}
    if ground is None:
        if "h" not in flow:
            raise ValueError("a flow gives `surface`, its level, where no bottom is known: give h")
        return flow
    x = places[0]
    level = over(x, given["surface"], "surface")
    above = level - ground(*places)
    differs = np.abs(over(x, flow.get("h", np.maximum(above, 0.0)), "h") - np.maximum(above, 0.0)) > 1e-9 * (1.0 + np.abs(level))
    if differs.any():
        h = over(x, flow["h"], "h")[differs][0]
        place = ", ".join(f"{name} = {one[differs][0]:.6g}" for name, one in zip(NAMES, places, strict=False))
        raise ValueError(f"`surface` of the initial state lies over another bottom than that of the scene, or contradicts `h`: "
                         f"at {place} they make h {max(above[differs][0], 0.0):.6g} and {h:.6g}; give one of them")
    return flow | {"h": depth(above)}


def over(x: np.ndarray, value: Any, name: str) -> np.ndarray:
    """Return a number, or values at the points ``x`` (m,) or (my, mx), as an array of that shape; ``name`` is for errors."""
    values = validation.floats(value, name)
    if values.shape not in ((), x.shape):
        raise ValueError(f"`{name}` must have shape {x.shape} for x of that shape, or be a number, got shape {values.shape}")
    return np.broadcast_to(values, x.shape)


def ratio(numerator: np.ndarray, denominator: np.ndarray) -> np.ndarray:
    """Return numerator/denominator of the same shape, 0 where the denominator is not positive."""
    present = denominator > 0.0
    return np.where(present, numerator / np.where(present, denominator, 1.0), 0.0)


def solid_and_fluid(seen: Mapping[str, np.ndarray]) -> dict[str, np.ndarray]:
    """Return the depths of the phases for profile plots, {name: (n,)}, the solid below the fluid."""
    return {"solid": seen["phi"] * seen["h"], "fluid": (1.0 - seen["phi"]) * seen["h"]}


def bottom(aux: Any, like: np.ndarray) -> np.ndarray:
    """Return the bottom b of the aux values, 0 of the shape of ``like`` without aux values."""
    return np.zeros_like(like) if aux is None else np.asarray(aux["b"], dtype=float)


def critical_depth(q: float, g: float = 9.81) -> float:
    """Return the critical depth (q^2/g)^(1/3), m, at which the velocity equals the wave speed.

    Parameters
    ----------
    q : discharge h v, m^2/s.
    g : gravity, m/s^2.
    """
    return (validation.real(q, "q") ** 2 / validation.real(g, "g", above=0.0)) ** (1.0 / 3.0)


#: A function of x, or of x and y, that returns the primitive variables of a flow, see `flow_names`.
Flow = Callable[..., Mapping[str, Any]]


def conserved(model: Any, flow: Flow, ground: Callable[..., Any] | None = None) -> Callable[..., np.ndarray]:
    """Return the function of places -> conserved values (rows, *places) of ``model`` for a function -> primitive variables.

    The flow is x (m,) -> {h, phi, vs, vf}, with two axes x and y (my, mx) -> {h, phi, vs_x, vs_y, vf_x, vf_y}. With a bottom
    ``ground``, a function of the same places -> b, it may contain ``surface``, its level, instead of h. Partly dry cells
    then get the depth of the level over their mean bottom, and the places must be all nodes of cells, see
    `fvkit.problem.cell_averages.levelled`.
    """
    def values(*places: np.ndarray) -> np.ndarray:
        state = whole_flow(over_ground(flow(*places), places, ground, levelled), len(places))
        return conserved_from(model, {name: over(places[0], value, name) for name, value in state.items()}, len(places))

    return values


def conserved_from(model: Any, state: Mapping[str, Any], axes: int) -> np.ndarray:
    """Return the conserved values (rows, ...) of ``model`` from all primitive variables, see `flow_names`."""
    moving = velocities(axes)
    along = [model.conserved_from(*(state[name] for name in ("h", "phi", *moving[2 * k:2 * k + 2]))) for k in range(axes)]
    return along[0] if axes == 1 else in_plane(model, *along)
