"""`ShallowFlow`: base class of all models of shallow flow over a bottom."""

from abc import ABC, abstractmethod
from collections.abc import Mapping
from typing import Any, ClassVar, Self

import attrs
import numpy as np

from fvkit import Model, RiemannSolver
from fvkit_granular.models.quantities import QUANTITIES, QUESTIONS
from fvkit_granular.models.relaxation import Relaxation
from fvkit_granular.models.wet_dry import resolved


@attrs.frozen
class ShallowFlow(Model, ABC):
    """Abstract model of a shallow flow over a bottom b. Contract:

    1. The fields ``g``, gravity, m/s^2, and ``dry``, a depth, m, or None, are parameters of the model.
    2. ``conserved_from(h, phi, vs, vf)`` converts primitive to conserved variables; ``depth(q)`` returns the depth.
    3. ``basal_load(q)`` is used by friction, ``poured(q, solid, fluid)`` by rain.
    """

    questions = QUESTIONS
    aux: ClassVar[tuple[str, ...]] = ("b",)
    quantities: ClassVar[Mapping[str, tuple[str, str]]] = QUANTITIES

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

    def resolved(self, q0: np.ndarray) -> Self:
        return resolved(self, q0)

    def preferred_riemann(self) -> RiemannSolver:
        return Relaxation()
