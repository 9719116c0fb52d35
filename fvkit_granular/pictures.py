"""Pictures that only two-phase flows have."""

from typing import TYPE_CHECKING

import numpy as np

from fvkit import Solution
from fvkit.plot import COLORS, new_axes

if TYPE_CHECKING:
    from matplotlib.axes import Axes

#: Share of the largest depth below which a phase has no velocity to speak of.
THIN = 1e-4


def slip(solution: Solution, ax: "Axes | None" = None, i: int = -1) -> "Axes":
    """Draw the slip vf - vs at output ``i``, m/s, where both phases are thicker than 1/10000 of the largest depth.

    Raises
    ------
    ValueError
        For a model with one velocity.
    """
    seen = solution.observables(i)
    if "vs" not in seen or "vf" not in seen:
        raise ValueError(f"{type(solution.model).__name__} has one velocity, hence no slip")
    target = ax if ax is not None else new_axes()[1][0]
    thinner = seen["h"] * np.minimum(seen["phi"], 1.0 - seen["phi"])
    shown = np.where(thinner > THIN * seen["h"].max(), seen["vf"] - seen["vs"], np.nan)
    target.plot(solution.grid.centers, shown, color=COLORS[0])
    target.axhline(0.0, color="0.4", linewidth=0.8)
    target.set(xlabel="x", ylabel="slip vf - vs, m/s", title=f"{type(solution.model).__name__}, t = {solution.t[i]:.4g}")
    target.grid(alpha=0.3)
    return target
