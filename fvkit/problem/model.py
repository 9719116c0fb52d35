"""`Model`: a hyperbolic system, as the methods that solvers, boundaries and schemes call."""

import inspect
from abc import ABC, abstractmethod
from collections.abc import Mapping
from types import MappingProxyType
from typing import Any, ClassVar, NamedTuple

import attrs
import numpy as np

from fvkit.pointwise import combine, subtract
from fvkit.pointwise.part import Part, default, optional
from fvkit.problem import answers
from fvkit.problem.questions import MODEL, Question


class Phase(NamedTuple):
    """A phase of a model: the rows of q that are its masses, never negative, and the row of their momentum.

    The last mass is the one that bears the momentum. Walls, positivity, mass balances, drag and friction are derived from it.

    Examples
    --------
    >>> import fvkit as fv
    >>> fv.Phase(masses=(0,), momentum=1)
    Phase(masses=(0,), momentum=1)
    """

    masses: tuple[int, ...]
    momentum: int


@attrs.frozen
class Model(Part, ABC):
    """Abstract system q_t + f(q)_x + B(q) q_x = S(q, x). Contract:

    1. ``conserved`` names the components of q, in order. ``aux`` names the given functions of x it needs.
    2. ``flux(q)`` and ``wave_speeds(q)`` are required; every other method has a default. Where the law depends on x they are
       ``flux(q, aux)`` and ``wave_speeds(q, aux)``: each side of a face has the aux values of its own cell. Core and solvers ask
       through `fvkit.problem.answers`, which serves both.
    3. States are tuples of components, scalars or arrays; so are results. Methods are pointwise and branch-free:
       arithmetic, ``np.sqrt`` and its like, ``fv.where/maximum/minimum``, in ordinary Python; ``self`` gives float fields,
       methods and constants of the class.
    4. ``phases`` lists, for each phase, the rows of q that are masses (never negative) and the row of their momentum. The
       last of several masses times the velocity is the momentum. Walls, positivity, treatment of dry faces, conservation
       statistics, drag and friction are derived from it. () for a general law.
    5. A face between states ql and qr, with aux values auxl and auxr, is described by ``jump``, the total
       fluctuation f(qr) - f(ql) + nonconservative products - source at the face. It must vanish at rest.
    6. Signs: dq/dt = -jump/dx, and left to right is the positive direction.
    7. A solver needs bounds of the speeds of *all* states between both sides of a face. The speeds of both sides are bounds if
       every speed is monotone between two states, as in convex laws; otherwise define ``speeds_between(ql, qr)``. For a scalar
       law without it speeds are sampled between the states if they are not monotone near the initial state; a system warns.
    8. ``quantities`` gives unit and meaning of components, aux functions and observables, for files: {name: (unit, what)},
       such as {"u": ("m s-1", "velocity")}; missing names have no unit.
    9. On a grid with two axes each sweep solves these equations along one axis. Momenta of ``phases`` have a row along each axis.
       A model of several components without phases defines ``vectors``, the rows that are components of a vector: ((1, 2),) if
       sweeps use both components, such as the momenta of gas dynamics, the second across; ((1,),) if the component across does
       not change in a sweep, such as the velocity of sound; () for no vector. A law that differs between the axes defines
       ``along(axis)``. ``dimensions`` is the largest number of axes.

    `Part.defines` tests which methods a model defines.

    Examples
    --------
    >>> import fvkit as fv
    >>> import numpy as np
    >>> class Traffic(fv.Model):
    ...     conserved = ("rho",)
    ...
    ...     def flux(self, q):
    ...         return (q[0] * (1.0 - q[0]),)
    ...
    ...     def wave_speeds(self, q):
    ...         return 1.0 - 2.0 * q[0], 1.0 - 2.0 * q[0]
    >>> road = fv.Problem(Traffic(), fv.Grid(-1.0, 1.0, 50), lambda x: [np.where(x < 0.0, 0.8, 0.1)], 0.5)
    >>> fv.solve(road, fv.WavePropagation(fv.HLL()), backend="numpy").success
    True
    """

    questions = MODEL
    conserved: ClassVar[tuple[str, ...]] = ()
    aux: ClassVar[tuple[str, ...]] = ()
    phases: ClassVar[tuple[Phase, ...]] = ()
    vectors: ClassVar[tuple[tuple[int, ...], ...]] = ()
    dimensions: ClassVar[int] = 2
    quantities: ClassVar[Mapping[str, tuple[str, str]]] = MappingProxyType({})
    #: Whether speeds between two states are looked at: where those of a scalar law are not monotone, see `fvkit.schemes.fitting`.
    scans: ClassVar[bool] = False
    #: Rows of aux values that hold the slopes of the bottom along a sweep and across it, see `fvkit.problem.relief`.
    slope_rows: ClassVar[tuple[int, ...]] = ()
    #: Rows that hold the second derivatives of the bottom, where a source bends the flow.
    bend_rows: ClassVar[tuple[int, ...]] = ()
    #: Which of the methods that may take aux values do; decided when the class is made.
    takes_aux: ClassVar[frozenset[str]] = frozenset()

    def __init_subclass__(cls, **options: Any) -> None:
        super().__init_subclass__(**options)
        for name in ("conserved", "aux"):
            given = getattr(cls, name)
            if not isinstance(given, tuple) or not all(isinstance(item, str) for item in given):
                raise TypeError(f"`{name}` of {cls.__name__} must be a tuple of names such as ('h', 'h v'), got {given!r}"
                                + (f": write ({given!r},)" if isinstance(given, str) else ""))
        cls.takes_aux = frozenset(one.name for one in cls.questions if one.also and _takes_aux(cls, one))
        _check_phases(cls)

    @abstractmethod
    def flux(self, q):
        """Return f(q), one component per equation; f(q, aux) of a method ``flux(self, q, aux)``."""

    @abstractmethod
    def wave_speeds(self, q):
        """Return two bounds (smallest, largest) of the characteristic speeds at q, m/s; also ``wave_speeds(self, q, aux)``."""

    @optional
    def speeds_between(self, ql, qr):
        """Return two bounds of the characteristic speeds of all states between ql and qr, m/s; also with ``auxl, auxr``.

        Needed where a speed is not monotone between two states: fluxes that are not convex, such as that of Buckley and Leverett,
        whose speed is 0 at 0 and at 1. Also where the speeds of a model with flux(q, aux) depend on more than both sides.
        """

    @default
    def jump(self, ql, qr, auxl, auxr):
        """Return the total fluctuation of a face: by default the flux difference."""
        return subtract(answers.flux(self, qr, auxr), answers.flux(self, ql, auxl))

    @default
    def difference(self, ql, qr, auxl, auxr):
        """Return qr - ql; relative to a background flow, less that of the flow."""
        return subtract(qr, ql)

    @default
    def balanced_difference(self, ql, qr, auxl, auxr):
        """Return the part of qr - ql beyond an equilibrium, on which a viscosity may act."""
        return subtract(qr, ql)

    @optional
    def lift(self, here, aux):
        """Return the term to add to q so that rest over ``aux`` is constant; linear in aux, frozen at the state ``here``.

        High-order reconstructions use q + lift. Zero by default, and used only where defined.
        """

    @default
    def to_modes(self, here, w):
        """Return the amplitudes of w in a basis that is always real, frozen at ``here``: high order limits these.

        w itself by default.
        """
        return w

    @default
    def from_modes(self, here, amplitudes):
        """Return w from its amplitudes, the inverse of ``to_modes``."""
        return amplitudes

    @optional
    def cell_integral(self, ql, qr, q, aux):
        """Return the integral of f_x + B q_x - source over a cell with face states ql, qr and polynomials q and aux.

        Used where defined; otherwise it is the flux difference or, where ``jump`` is defined, built from jumps.
        """

    @optional
    def decompose(self, ql, qr, auxl, auxr, jump):
        """Return (waves, speeds) of the Roe linearisation: ``jump`` as a sum of its eigenvectors. No default."""

    @default
    def matrix_product(self, ql, qr, auxl, auxr, v):
        """Return the Roe-mean matrix times v; by default the jump from mean - v/2 to mean + v/2 over the mean aux values.

        ``v`` is an increment of the state (a scheme passes dt/dx times a fluctuation).
        """
        mean, aux = combine(0.5, ql, 0.5, qr), combine(0.5, auxl, 0.5, auxr)
        if self.defines("jump"):
            return self.jump(combine(1.0, mean, -0.5, v), combine(1.0, mean, 0.5, v), aux, aux)
        after = answers.flux(self, combine(1.0, mean, 0.5, v), aux)
        return subtract(after, answers.flux(self, combine(1.0, mean, -0.5, v), aux))

    @optional
    def cross(self, ql, qr, auxl, auxr):
        """Return the Lax-Wendroff term A'(G) dq - A'(dq) G - S'(G) db - A_a da G of nonconservative products and bottom.

        G is the jump, S db the source that it contains, a the aux values on which A depends in a model without a flux: the colour
        equation q_t + u(x) q_x = 0 has -du G. Zero by default: conservation laws have none, flux(q, aux) neither.
        """

    @optional
    def relaxation(self, ql, qr, auxl, auxr, jump):
        """Return (waves, speeds) that keep every mass non-negative, for any data. No default.

        Where a model defines it, any other solver falls back to it at faces next to dry ground. The ``jump`` of a
        scheme is reduced by sources; ``jump.whole`` is the full one.
        """

    @optional
    def beyond(self, q, slopes, distance):
        """Return the state of a flow ``distance`` m beyond a cell with state q, positive to the right, where the aux functions
        continue at ``slopes``, per metre to the right: rest must stay at rest, and uniform flow uniform.

        Where defined, the aux functions continue beyond open ends, see ``fvkit.problem.open_ends.Continued``.
        """

    @optional
    def settle(self, q):
        """Return the state of a cell after a step: layers that are too thin to move lose their momentum. Optional."""

    @optional
    def admissible(self, q):
        """Return whether the state is physical. Optional; masses are always checked."""

    @optional
    def hyperbolic_discriminant(self, ql, qr):
        """Return a number per face, negative where the Roe mean has complex speeds; also with ``auxl, auxr``.
        Optional."""

    @optional
    def may_lose_hyperbolicity(self, ql, qr):
        """Return a cheap necessary condition for a negative `hyperbolic_discriminant`; also with ``auxl, auxr``."""

    def along(self, axis: int) -> "Model":
        """Return the equations along an axis, 0 for x and 1 for y: by default the same for all."""
        return self

    def resolved(self, q0: np.ndarray) -> "Model":
        """Return this model with parameters that are None set from the initial state q0."""
        return self

    def check_validity(self, problem: Any) -> None:
        """Warn where the data of a `Problem` leave the range in which the equations are valid; called when it is built."""

    def relief(self) -> str | None:
        """Return the name of the aux function whose slopes the equations depend on, see `fvkit.problem.relief`; None for none."""
        return None

    def on_slope(self, steepness: Any) -> "Model":
        """Return the equations over a bottom of slope s, ``steepness`` = 1 + s^2; used only where `relief` names a bottom."""
        raise NotImplementedError(f"{type(self).__name__} has a `relief`, so it must define `on_slope`")

    def on_bed(self, root: Any, turning: tuple[Any, ...] = ()) -> Any:
        """Return the equations as sources see them on a bottom of slope s, ``root`` = sqrt(1 + s^2): depth, load normal to it.

        ``turning`` is u . Hess(b) u of each phase, m/s^2, or empty.
        """
        raise NotImplementedError(f"{type(self).__name__} has a `relief`, so it must define `on_bed`")

    @optional
    def preferred_riemann(self) -> Any:
        """Return the default Riemann solver. Optional: otherwise it is Roe, or HLL for a model without `decompose`."""

    def observables(self, q: np.ndarray, aux: Mapping[str, np.ndarray] | None = None) -> dict[str, np.ndarray]:
        """Return the observables, {name: (n,)}: by default the conserved quantities."""
        return dict(zip(self.conserved, q, strict=True))

    def thicknesses(self, seen: Mapping[str, np.ndarray]) -> dict[str, np.ndarray]:
        """Return the layers on the bottom, from below, {name: (n,)}, from the observables; empty without a profile."""
        return {}

    def hyperbolicity_margin(self, q: np.ndarray) -> np.ndarray:
        """Return a number per cell, (n,), negative where characteristic speeds are complex; inf where they never are."""
        return np.full(q.shape[1], np.inf)

    def wall_signs(self) -> tuple[float, ...]:
        """Return the factor of each component under reflection at a wall: -1 for momenta and the first row of a vector.

        Raises
        ------
        ValueError
            If the model has neither ``phases`` nor ``vectors`` and does not override this.
        """
        if not self.phases and not self.vectors:
            raise ValueError(f"Wall needs to know what {type(self).__name__} reflects: define `phases`, `vectors`, "
                             "or `wall_signs()` with one factor +1 or -1 per component")
        momenta = {momentum for _, momentum in self.phases} | {rows[0] for rows in self.vectors}
        return tuple(-1.0 if row in momenta else 1.0 for row in range(len(self.conserved)))

    @classmethod
    def mass_rows(cls) -> tuple[int, ...]:
        """Rows of q that are masses."""
        return tuple(row for masses, _ in cls.phases for row in masses)


def _takes_aux(kind: type[Model], asked: Question) -> bool:
    """Whether a method takes the aux values of each state, or raise where it takes neither them nor states alone."""
    try:
        given = list(inspect.signature(getattr(kind, asked.name)).parameters.values())[1:]
    except (TypeError, ValueError):  # no function at all: the contract check says so
        return False
    if any(one.kind is not one.POSITIONAL_OR_KEYWORD for one in given):
        return False
    needed = sum(one.default is one.empty for one in given)
    alone, with_aux = asked.takes, (*asked.takes, *asked.also)
    if needed not in (len(alone), len(with_aux)):
        wanted, other, got = (f"{asked.name}({', '.join(['self', *names])})"
                              for names in (alone, with_aux, [one.name for one in given]))
        raise TypeError(f"`{asked.name}` of {kind.__name__} must be {wanted}, or {other} where it depends on x, got {got}")
    return needed == len(with_aux)


def _check_phases(kind: type[Model]) -> None:
    """Make `Phase` of pairs; refuse what does not name rows of masses and the row of their momentum."""
    rows = range(len(kind.conserved))
    try:
        phases = tuple(Phase(*pair) for pair in kind.phases)
        good = all(phase.masses and {*phase.masses, phase.momentum} <= {*rows} for phase in phases)
    except (TypeError, ValueError):
        good = False
    if not good:
        raise TypeError(f"`phases` of {kind.__name__} must be a tuple of phases, each with its rows of masses and the row of "
                        f"their momentum, such as (fv.Phase((0,), 1),), with rows below {len(rows)}, got {kind.phases!r}")
    kind.phases = phases


def aux_rows(model: Model, aux: Mapping[str, Any]) -> tuple[np.ndarray, ...]:
    """Arrange named aux arrays in the order of ``model.aux``."""
    return tuple(aux[name] for name in model.aux)
