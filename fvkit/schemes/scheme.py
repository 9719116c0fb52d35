"""`Scheme`: base class of numerical schemes, and the stages of a time step."""

from abc import ABC, abstractmethod
from collections.abc import Callable, Mapping
from typing import Any, NamedTuple

import attrs
import numpy as np

from fvkit.problem.model import Model
from fvkit.problem.sources import Source
from fvkit.schemes.background import Deviation
from fvkit.schemes.integrators import Integrator
from fvkit.schemes.limiters import Limiter
from fvkit.schemes.program import ONE_SWEEP, Program, program
from fvkit.schemes.reconstruction import Reconstruction
from fvkit.schemes.riemann import RiemannSolver
from fvkit.schemes.splitting import Splitting


class Parts(NamedTuple):
    """Model, Riemann solver, limiters, sources, cell length and reconstruction, passed to the function of every stage; in sweeps
    of a grid with two axes (``swept``) the number of momenta ``across``. Model and sources may be those of the problem, each seen
    through a `fvkit.pointwise.part.Wrapper`."""

    model: Any
    riemann: RiemannSolver
    limiters: tuple[Limiter, ...]
    sources: tuple[Source, ...]
    dx: Any = 1.0
    reconstruction: Reconstruction | None = None
    across: int = 0
    swept: bool = False

    @property
    def every(self) -> tuple[Any, ...]:
        """All parts, in the order in which their parameters are laid out for compiled code."""
        return (self.model, self.riemann, *self.limiters, *self.sources,
                *(() if self.reconstruction is None else (self.reconstruction,)))

    def mapped(self, change: Callable[[Any], Any]) -> "Parts":
        """Return the parts with a function applied to each, in the order of `every`."""
        symbols = iter([change(part) for part in self.every])
        return self._replace(model=next(symbols), riemann=next(symbols), limiters=tuple(next(symbols) for _ in self.limiters),
                             sources=tuple(next(symbols) for _ in self.sources),
                             reconstruction=None if self.reconstruction is None else next(symbols))

    @property
    def joint(self) -> tuple[Source, ...]:
        """Sources that act together with the transport: first those between phases (drag), last those at the bed (friction)."""
        alone = self.reconstruction is not None or (self.swept and not self.across)
        found = () if alone else [source for source in self.sources if source.defines("driven")]
        return tuple(sorted(found, key=lambda source: not source.between_phases))

    @property
    def beside(self) -> tuple[Source, ...]:
        """The other sources, which alternate with the transport by the splitting of the scheme."""
        joint = self.joint
        return tuple(source for source in self.sources if not any(source is other for other in joint))


class Read(NamedTuple):
    """Field read by a stage: a value at the offset ``first`` from its own cell or face, or a tuple at the offsets first..last."""

    field: str
    first: int = 0
    last: int | None = None

    @property
    def offsets(self) -> range:
        """The offsets, ascending."""
        return range(self.first, (self.first if self.last is None else self.last) + 1)

    @property
    def here(self) -> bool:
        """Whether it reads its own place alone."""
        return self.offsets == range(1)


def here(*fields: str) -> dict[str, Read]:
    """Read fields at the place of the stage itself, under their own names."""
    return {field: Read(field) for field in fields}


#: The fields that a scheme hands to its backend: what enters a cell less what leaves it; the state of the cell after transport
#: and the sources that act with it; the largest speed at a face; the flux of each mass through a face; of a sweep the state of
#: the cell and its momenta across; what pushes a cell along an axis, see `fvkit.schemes.stages.driven.pulling_stages`.
NET, NEW, SPEED, MASS_FLUX, MOVED, PULLS = "net", "new", "fastest", "mass_flux", "moved", "pulls"


@attrs.frozen
class Stage:
    """Pointwise stage of a time step.

    ``compute(parts, ratio, **inputs)`` receives dt/dx and its inputs by the names of ``reads``; it returns {field: value} for
    the fields in ``writes``. Cells and faces share one numbering: face j is the left face of cell j,
    between cells j - 1 and j. The fields ``q`` and ``aux`` are given. One stage writes `NET`, the sum of
    all fluctuations that enter a cell. If sources act with the transport, the last stage writes `NEW`, the state after both.

    Parameters
    ----------
    compute : pointwise function.
    reads : {name of an input: field and offsets}; the offsets determine the width of the halo.
    writes : fields that the stage writes. A guarded stage overwrites existing fields.
    guard : pointwise condition with the arguments of ``compute``; the stage is skipped in blocks where it is false everywhere.
    light : True lets a backend recompute the stage where its fields are read instead of storing them.
    sparse : True runs a guarded stage only at the few cells or faces where the guard is true, and leaves others unchanged.
    """

    compute: Callable[..., dict[str, Any]]
    reads: Mapping[str, Read]
    writes: tuple[str, ...]
    guard: Callable[..., Any] | None = None
    light: bool = False
    sparse: bool = False

    def run(self, parts: Parts, ratio: Any, inputs: Mapping[str, Any]) -> dict[str, Any]:
        """Return the fields that the stage writes, in the order of ``writes``."""
        found = self.compute(parts, ratio, **inputs)
        return {name: found[name] for name in self.writes}


@attrs.frozen
class Scheme(ABC):
    """Abstract explicit one-step scheme. Contract:

    1. ``parts(model, sources)`` returns the `Parts` of a run, and raises for an incompatible pair.
    2. ``stages(parts)`` returns the stages of one transport step that these parts need:
       q_new = q - dt/dx net. The field `SPEED` is the largest speed at a face. For a model with masses the field
       `MASS_FLUX` contains the mass fluxes, which a wall sets to 0 before the last stages read them.
    3. ``cfl`` is the target Courant number; a step above ``cfl_max`` is rejected and repeated.
    4. ``splitting`` is the splitting of transport and sources.
    5. ``time_integrator``, if not None, evaluates the stages several times per step; ``net`` is then minus dx times the rate
       dq/dt. ``source_stages(parts)`` are the stages of implicit sources. ``program`` lists the sweeps of a step.

    Attributes
    ----------
    riemann : Riemann solver at the faces.
    cfl : target Courant number.
    splitting : splitting of transport and sources.

    Examples
    --------
    >>> import fvkit as fv
    >>> schemes = fv.WavePropagation(fv.HLL(), order=2), fv.MethodOfLines(fv.HLL(), fv.WENO5())
    >>> [(isinstance(scheme, fv.Scheme), scheme.cfl, scheme.riemann) for scheme in schemes]
    [(True, 0.9, HLL()), (True, 2.4, HLL())]
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
        """Time integrator of a semi-discrete scheme; None for a fully discrete scheme."""
        return None

    @property
    def program(self) -> Program:
        """The sweeps of a step: one, or those of the time integrator."""
        return ONE_SWEEP if self.time_integrator is None else program(self.time_integrator)

    @property
    def wants_cross(self) -> bool:
        """Whether the scheme uses the model's `cross` for its order."""
        return False

    def at_first_order(self) -> "Scheme":
        """Return the first-order version of this scheme, which does not use the model's matrix; by default the scheme itself."""
        return self

    @property
    def planar(self) -> bool:
        """Whether the scheme serves grids with two axes, by sweeps along each."""
        return False

    @property
    @abstractmethod
    def limiting(self) -> Any:
        """Limiter or reconstruction, or a tuple of limiters, named "limiter" in reports."""

    @property
    @abstractmethod
    def nominal_order(self) -> int:
        """Order of accuracy for smooth solutions."""

    @abstractmethod
    def parts(self, model: Model, sources: tuple[Source, ...]) -> Parts:
        """Return the `Parts` of this scheme for ``model``, or raise ValueError for an incompatible pair."""

    def around(self, parts: Parts) -> Parts:
        """Return the `Parts` for a problem with a background; by default jumps of the model are relative to the background."""
        return parts._replace(model=Deviation(parts.model))

    def background(self, parts: Parts, flow: np.ndarray, aux: np.ndarray, at_faces: np.ndarray | None) -> np.ndarray:
        """Return the additional aux values of a background, (rows, m); by default its cell averages.

        Parameters
        ----------
        parts : the parts of the scheme.
        flow : (num_eqn, m) cell averages of the background, ghost cells included.
        aux : (num_aux, m) cell averages of the aux functions.
        at_faces : (num_eqn, num_cells + 1) values of the background at the faces; None if only averages are known.
        """
        return flow

    def completed(self, rows: np.ndarray, net: np.ndarray) -> np.ndarray:
        """Return the rows of `background`, completed with its residual ``net`` (num_eqn, m); by default unchanged."""
        return rows

    @abstractmethod
    def stages(self, parts: Parts) -> tuple[Stage, ...]:
        """Return the tuple of stages of a transport step."""

    def source_stages(self, parts: Parts) -> tuple[Stage, ...]:
        """Return the stages of implicit sources; none by default."""
        return ()
