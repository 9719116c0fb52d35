"""`Scheme`, and the stages that it is made of."""

from abc import ABC, abstractmethod
from collections.abc import Callable
from typing import Any, NamedTuple

import attrs
import numpy as np

from fvkit.problem.model import Model
from fvkit.problem.sources import Source
from fvkit.schemes.background import deviation
from fvkit.schemes.integrators import Integrator
from fvkit.schemes.limiters import Limiter
from fvkit.schemes.reconstruction import Reconstruction
from fvkit.schemes.riemann import RiemannSolver
from fvkit.schemes.splitting import Splitting


class Parts(NamedTuple):
    """The parts that a stage's function may ask, and the length of a cell."""

    model: Model
    riemann: RiemannSolver
    limiters: tuple[Limiter, ...]
    sources: tuple[Source, ...]
    dx: Any = 1.0
    reconstruction: Reconstruction | None = None

    @property
    def joint(self) -> tuple[Source, ...]:
        """The sources that act together with the transport, those between phases first: the bed has the last word."""
        found = () if self.reconstruction is not None else [source for source in self.sources if source.defines("driven")]
        return tuple(sorted(found, key=lambda source: not source.between_phases))

    @property
    def beside(self) -> tuple[Source, ...]:
        """The other sources, which alternate with the transport as the splitting of the scheme says."""
        joint = self.joint
        return tuple(source for source in self.sources if not any(source is other for other in joint))


class Read(NamedTuple):
    """A field that a stage reads, at the offsets first..last from its own place."""

    field: str
    first: int
    last: int


@attrs.frozen
class Stage:
    """One pointwise stage of a scheme.

    ``compute(parts, ratio, *inputs)`` gets dt/dx and one input per field and offset, in the order of ``reads``; it
    returns one value per name in ``writes``. Cells and faces share one numbering: face j is the left face of cell j,
    between cells j - 1 and j. The fields ``q`` and ``aux`` are given; a stage writes ``net``, the sum of all fluctuations that
    enter a cell, and where sources act with the transport the last one writes ``new``, the state of the cell after both.

    Parameters
    ----------
    compute : pointwise function.
    reads : the fields it reads, with offsets; a backend sums the halo from them.
    writes : the fields it writes. A guarded stage writes fields that exist already.
    guard : pointwise condition with the same arguments. Where no cell of a tile asks, the stage is not run there.
    light : whether a backend may compute the stage again where it is read instead of keeping what it writes.
    sparse : whether a guarded stage is run at the very places that ask, few of them, and leaves all others as they are.
    """

    compute: Callable[..., tuple[Any, ...]]
    reads: tuple[Read, ...]
    writes: tuple[str, ...]
    guard: Callable[..., Any] | None = None
    light: bool = False
    sparse: bool = False


@attrs.frozen
class Scheme(ABC):
    """Abstract explicit one-step scheme. Contract:

    1. ``parts(model, sources)`` collects the parts and refuses, naming both, what cannot work together.
    2. ``stages(parts)`` lists the stages of one transport step, only those that these parts need:
       q_new = q - dt/dx net. ``fastest`` is the largest speed at a face. Where the model has masses, ``carried`` holds
       their fluxes, which a closed wall sets to 0, and the light stages that write ``to_left`` and ``to_right`` come last.
    3. ``cfl`` is the Courant number that the time step aims at; a step above ``cfl_max`` is rejected and redone.
    4. ``splitting`` says when sources act.
    5. ``time_integrator``, where not None, makes a step of several sweeps of the stages, whose ``net`` is then minus dx
       times the rate; ``source_stages(parts)`` are those of sources that it takes implicitly.

    Attributes
    ----------
    riemann : the Riemann solver at its faces.
    cfl : Courant number that the time step aims at.
    splitting : when sources act.
    """

    riemann: RiemannSolver
    cfl: float
    splitting: Splitting

    @property
    @abstractmethod
    def cfl_max(self) -> float:
        """Largest Courant number of an accepted step."""

    @property
    def time_integrator(self) -> Integrator | None:
        """The integrator of a semi-discrete scheme; None for one that makes its step itself."""
        return None

    @property
    def wants_cross(self) -> bool:
        """Whether the scheme needs the model's `cross`, where it has one, for its order."""
        return False

    def at_first_order(self) -> "Scheme":
        """Return this scheme at first order, without the matrix of the model; itself where it asks none."""
        return self

    @property
    @abstractmethod
    def limiting(self) -> Any:
        """The part, or tuple of parts, that keeps the scheme quiet at jumps: what reports call the limiter."""

    @property
    @abstractmethod
    def nominal_order(self) -> int:
        """Order where the solution is smooth."""

    @abstractmethod
    def parts(self, model: Model, sources: tuple[Source, ...]) -> Parts:
        """Return the parts of this scheme for ``model``, or raise ValueError naming the pair that cannot work."""

    def around(self, parts: Parts) -> Parts:
        """Return the parts for a problem with a background; by default the model is seen from it, face by face."""
        return parts._replace(model=deviation(parts.model))

    def background(self, parts: Parts, flow: np.ndarray, aux: np.ndarray, at_faces: np.ndarray | None) -> np.ndarray:
        """Return the rows that stand behind the aux values for a background; by default its cell averages.

        Parameters
        ----------
        parts : the parts of the scheme.
        flow : (num_eqn, m) cell averages of the background, ghost cells included.
        aux : (num_aux, m) cell averages of the aux functions.
        at_faces : (num_eqn, num_cells + 1) its values at the faces, None where it is given by averages alone.
        """
        return flow

    def completed(self, rows: np.ndarray, net: np.ndarray) -> np.ndarray:
        """Return the rows of `background` with what the stages make of it, ``net`` (num_eqn, m); by default as they are."""
        return rows

    @abstractmethod
    def stages(self, parts: Parts) -> tuple[Stage, ...]:
        """Return the stages of a step."""

    def source_stages(self, parts: Parts) -> tuple[Stage, ...]:
        """Return the stages of implicit sources; none by default."""
        return ()
