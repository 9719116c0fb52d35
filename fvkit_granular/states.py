"""What a person says of a flow, (h, phi, vs, vf), and how it becomes arrays."""

from collections.abc import Mapping
from typing import Any

import numpy as np


def broadcast(h: Any, phi: Any, vs: Any, vf: Any) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """Return h, phi, vs, vf as arrays of one shape, velocities of an absent phase set to 0.

    Parameters
    ----------
    h : depth, m, >= 0.
    phi : solid volume fraction in [0, 1].
    vs, vf : velocities of solid and fluid, m/s; any value where the phase is absent.

    Raises
    ------
    ValueError
        If a depth is negative, phi leaves [0, 1], or a value that counts is not finite.
    """
    depth, fraction, solid, fluid = (np.array(a, dtype=float) for a in np.broadcast_arrays(h, phi, vs, vf))
    solid = np.where(depth * fraction > 0.0, solid, 0.0)
    fluid = np.where(depth * (1.0 - fraction) > 0.0, fluid, 0.0)
    for name, value, allowed, rule in (("h", depth, depth >= 0.0, "finite and >= 0"),
                                       ("phi", fraction, (fraction >= 0.0) & (fraction <= 1.0), "in [0, 1]"),
                                       ("vs", solid, True, "finite where there is solid"),
                                       ("vf", fluid, True, "finite where there is fluid")):
        good = np.isfinite(value) & allowed
        if not good.all():
            raise ValueError(f"`{name}` must be {rule}, got {value[~good].ravel()[0]!r}")
    return depth, fraction, solid, fluid


def ratio(numerator: np.ndarray, denominator: np.ndarray) -> np.ndarray:
    """Return numerator/denominator for reading, 0 where the denominator is not positive."""
    present = denominator > 0.0
    return np.where(present, numerator / np.where(present, denominator, 1.0), 0.0)


def solid_and_fluid(seen: Mapping[str, np.ndarray]) -> dict[str, np.ndarray]:
    """Return the thicknesses of the phases, drawn apart, as if the grains had settled."""
    return {"solid": seen["phi"] * seen["h"], "fluid": (1.0 - seen["phi"]) * seen["h"]}


def bottom(aux: Any, like: np.ndarray) -> np.ndarray:
    """Return the bottom among aux values, 0 where there is none."""
    return np.zeros_like(like) if aux is None else np.asarray(aux["b"], dtype=float)
