"""Data of a solution, for the functions that write and draw them."""

from typing import Any

import attrs
import numpy as np

from fvkit.output.status import Stats, Status
from fvkit.problem.directions import directions, observables
from fvkit.problem.grid import Grid
from fvkit.problem.model import Model


@attrs.frozen(eq=False)
class Results:
    """Data of a `fvkit.Solution`, which adds files and plots; its documentation has the fields."""

    t: np.ndarray
    q: np.ndarray
    aux: dict[str, np.ndarray]
    grid: Grid
    model: Model
    status: Status
    stats: Stats
    message: str = ""
    configuration: dict[str, Any] = attrs.field(factory=dict)

    @property
    def success(self) -> bool:
        """Whether the run reached its end time or its stop rule, the ``until`` of `fvkit.solve`."""
        return self.status in (Status.FINISHED, Status.STOPPED)

    def observables(self, i: int = -1) -> dict[str, np.ndarray]:
        """Return the observables at output ``i``, such as depth and velocity, {name: grid.shape}; with two axes
        the components and the size of each vector: v_x, v_y, speed."""
        return observables(self.model, self.grid, self.q[i], self.aux)

    def hyperbolicity_margin(self, i: int = -1) -> np.ndarray:
        """Return the hyperbolicity margin at output ``i``, grid.shape: negative where characteristic speeds are complex."""
        rows = [list(one.rows) for one in directions(self.model, self.grid)]
        found = [self.model.hyperbolicity_margin(self.q[i][row].reshape(len(row), -1)) for row in rows]
        return np.minimum.reduce(found).reshape(self.grid.shape)
