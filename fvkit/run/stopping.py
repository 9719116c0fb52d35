"""`Stop`: when a run ends before its end time, because nothing more happens."""

from abc import ABC, abstractmethod
from collections.abc import Mapping

import attrs
import numpy as np

from fvkit.pointwise.part import Part
from fvkit.problem.problem import Problem
from fvkit.validation import integer, number

#: Unit of the observables that are velocities.
VELOCITY = "m s-1"


@attrs.frozen
class Stop(Part, ABC):
    """Abstract rule that ends a run. Contract:

    1. ``reached(problem, t, q)`` says whether the run ends at time t with the cell averages q (num_eqn, num_cells).
    2. It is asked after every ``every`` accepted steps, so that the answer does not depend on the machine.
    3. ``check(problem)`` raises ValueError where the rule does not fit a problem.
    """

    every: int = integer(20, at_least=1, kw_only=True)

    @abstractmethod
    def reached(self, problem: Problem, t: float, q: np.ndarray) -> bool:
        """Return whether the run ends here."""

    def check(self, problem: Problem) -> None:
        """Raise ValueError where the rule does not fit the problem."""


@attrs.frozen
class StopAtRest(Stop):
    """End a run when nothing moves any more: every velocity is below ``speed`` wherever the flow is deeper than ``depth``.

    The velocities are those observables of the model whose unit (``Model.quantities``) is m s-1.

    Parameters
    ----------
    speed : m/s, positive.
    depth : m, >= 0: what is thinner does not count.
        The depth is that of the model's ``thicknesses``; without these every cell counts.
    after : s: not before this time, so that a flow which starts from rest, or an inflow which comes later, has begun.
    every : the rule is looked at after so many accepted steps.
    """

    speed: float = number(0.01, above=0.0)
    depth: float = number(1e-3, at_least=0.0)
    after: float = number(0.0)

    def check(self, problem: Problem) -> None:
        first_cell = {name: row[:1] for name, row in problem.aux_averages.items()}
        if not self._velocities(problem, problem.model.observables(problem.q0[:, :1], first_cell)):
            raise ValueError(f"StopAtRest needs velocities: {type(problem.model).__name__} names no observable with the unit "
                             f"{VELOCITY!r} in `quantities`")

    def reached(self, problem: Problem, t: float, q: np.ndarray) -> bool:
        if t < self.after:
            return False
        seen = problem.model.observables(q, problem.aux_averages)
        layers = problem.model.thicknesses(seen)
        counts = sum(layers.values()) > self.depth if layers else np.ones(q.shape[1], dtype=bool)
        return all(np.abs(seen[name][counts]).max(initial=0.0) < self.speed for name in self._velocities(problem, seen))

    @staticmethod
    def _velocities(problem: Problem, seen: Mapping[str, np.ndarray]) -> list[str]:
        return [name for name in seen if problem.model.quantities.get(name, ("",))[0] == VELOCITY]
