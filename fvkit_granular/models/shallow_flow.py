"""`ShallowFlow`: base class of all models of shallow flow over a bottom."""

from abc import ABC, abstractmethod
from collections.abc import Mapping
from typing import Any, ClassVar, Self

import attrs
import numpy as np

from fvkit import Model, RiemannSolver, validation
from fvkit.pointwise.part import seen_as
from fvkit_granular.models.quantities import QUANTITIES, QUESTIONS
from fvkit_granular.models.relaxation import Relaxation
from fvkit_granular.models.slope import steep_equations, warn_of_steep_ground
from fvkit_granular.models.steep import OnBed
from fvkit_granular.models.wet_dry import resolved

#: Equations for the slope of the ground.
SLOPES = ("mild", "steep")


@attrs.frozen
class ShallowFlow(Model, ABC):
    """Abstract model of a shallow flow over a bottom b. Contract:

    1. The fields ``g``, gravity, m/s^2, and ``dry``, a depth, m, or None, are parameters of the model.
    2. ``conserved_from(h, phi, vs, vf)`` converts primitive to conserved variables; ``depth(q)`` returns the depth.
    3. ``basal_load(q)`` is used by friction, ``poured(q, solid, fluid)`` by rain.
    4. ``slope="steep"`` takes the equations for steep ground, see `fvkit_granular.models.steep`; ``"mild"`` those of the paper,
       with a `SteepSlopeWarning` for a problem whose flow may reach ground above 15 degrees.
    """

    questions = QUESTIONS
    aux: ClassVar[tuple[str, ...]] = ("b",)
    quantities: ClassVar[Mapping[str, tuple[str, str]]] = QUANTITIES

    slope: str = validation.field(validation.choice, "mild", kw_only=True, known=SLOPES)

    @abstractmethod
    def conserved_from(self, h: Any, phi: Any, vs: Any = 0.0, vf: Any = 0.0) -> np.ndarray:
        """Return q (num_eqn, ...) from depth h, m, solid fraction phi in [0, 1] and velocities vs, vf, m/s."""

    @abstractmethod
    def depth(self, q):
        """Return the depth h, m."""

    @abstractmethod
    def basal_load(self, q):
        """Return the basal load per mass, m/s^2, one value per phase."""

    @abstractmethod
    def poured(self, q, solid, fluid):
        """Return the masses after adding depths of solid and fluid, m; a negative depth removes at most the existing mass."""

    def check_validity(self, problem: Any) -> None:
        if not steep_equations(self):
            given: Any = self
            warn_of_steep_ground(problem, given.g)

    def relief(self) -> str | None:
        return "b" if self.slope == "steep" else None

    def on_slope(self, steepness: Any) -> Self:
        given: Any = self
        return seen_as(self, {"g": given.g / steepness})

    def on_bed(self, root: Any, turning: tuple[Any, ...] = ()) -> Any:
        return OnBed(self, 1.0 / root, turning)

    def resolved(self, q0: np.ndarray) -> Self:
        return resolved(self, q0)

    def preferred_riemann(self) -> RiemannSolver:
        return Relaxation()
