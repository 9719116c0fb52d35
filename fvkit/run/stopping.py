"""Stop rules: end a run before its end time, such as when the flow is at rest."""

from abc import ABC, abstractmethod
from collections.abc import Mapping

import attrs
import numpy as np

from fvkit.pointwise.part import Part
from fvkit.problem.directions import observables, quantities
from fvkit.problem.problem import Problem
from fvkit.validation import integer, number

#: Unit of the observables that are velocities.
VELOCITY = "m s-1"


@attrs.frozen
class Stop(Part, ABC):
    """Abstract stop rule. Contract:

    1. ``reached(problem, t, q)`` returns whether the run ends at time t with the cell averages q (num_eqn, *grid.shape).
    2. ``reached`` is called after every ``every`` accepted steps, so that results do not depend on the speed of the machine.
    3. ``check(problem)`` raises ValueError if the rule cannot be applied to a problem.

    Examples
    --------
    >>> import attrs
    >>> import numpy as np
    >>> import fvkit as fv
    >>> @attrs.frozen
    ... class WhenLow(fv.Stop):
    ...     level: float = 0.5
    ...     def reached(self, problem, t, q):
    ...         return bool(q[0].max() < self.level)
    >>> pulse = lambda x: [np.exp(-50.0 * (x - 0.5) ** 2)]
    >>> problem = fv.Problem(fv.Advection(1.0), fv.Grid(0.0, 1.0, 50), pulse, 2.0, boundary=fv.Outflow())
    >>> fv.solve(problem, until=WhenLow(), backend="numpy").status.name
    'STOPPED'
    """

    every: int = integer(20, at_least=1, kw_only=True)

    @abstractmethod
    def reached(self, problem: Problem, t: float, q: np.ndarray) -> bool:
        """Return whether the run ends at time ``t``."""

    def check(self, problem: Problem) -> None:
        """Raise ValueError if the rule cannot be applied to the problem."""


@attrs.frozen
class StopAtRest(Stop):
    """Stop rule for a flow at rest: every velocity is below ``speed`` wherever the flow is deeper than ``depth``.

    The velocities are the observables whose unit in ``Model.quantities`` is m s-1; with two axes the size of each vector counts.

    Parameters
    ----------
    speed : threshold of the velocities, m/s, positive.
    depth : threshold of the depth, m, >= 0; thinner flow is ignored.
        The depth is the sum of the model's ``thicknesses``; for models without them every cell counts.
    after : earliest time of the stop, s, for flows that start from rest and inflows that begin later.
    every : number of accepted steps between two checks.

    Examples
    --------
    >>> import fvkit as fv
    >>> import fvkit_granular as gr
    >>> scene = gr.scene("block-stop")
    >>> solution = fv.solve(scene.problem(gr.TwoPhase, 20), until=fv.StopAtRest(speed=1e-3), backend="numpy")
    >>> solution.status.name, float(solution.t[-1]) < scene.t_end
    ('STOPPED', True)
    """

    speed: float = number(0.01, above=0.0)
    depth: float = number(1e-3, at_least=0.0)
    after: float = number(0.0)

    def check(self, problem: Problem) -> None:
        if not self._velocities(problem, observables(problem.model, problem.grid, problem.q0, problem.aux_averages)):
            raise ValueError(f"StopAtRest needs velocities: {type(problem.model).__name__} names no observable with the unit "
                             f"{VELOCITY!r} in `quantities`")

    def reached(self, problem: Problem, t: float, q: np.ndarray) -> bool:
        if t < self.after:
            return False
        seen = observables(problem.model, problem.grid, q, problem.aux_averages)
        layers = problem.model.thicknesses(seen)
        counts = sum(layers.values()) > self.depth if layers else np.ones(q.shape[1:], dtype=bool)
        return all(np.abs(seen[name][counts]).max(initial=0.0) < self.speed for name in self._velocities(problem, seen))

    @staticmethod
    def _velocities(problem: Problem, seen: Mapping[str, np.ndarray]) -> list[str]:
        known = quantities(problem.model, problem.grid)
        return [name for name in seen if known.get(name, ("",))[0] == VELOCITY]
