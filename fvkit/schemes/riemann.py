"""Riemann solvers in f-wave form: Roe, HLL, Rusanov, and solvers written for PyClaw."""

import math
from abc import ABC, abstractmethod
from collections.abc import Callable, Mapping
from typing import Any, ClassVar, NamedTuple

import attrs
import numpy as np

from fvkit import validation
from fvkit.pointwise import TINY, add, combine, least, maximum, scale, subtract, where
from fvkit.pointwise.part import Part, optional
from fvkit.problem.answers import face_speeds, mass_flux
from fvkit.problem.model import Model
from fvkit.problem.questions import RIEMANN


@attrs.frozen
class RiemannSolver(Part, ABC):
    """Abstract Riemann solver in f-wave form. Contract:

    1. ``solve(model, ql, qr, auxl, auxr, jump)`` returns (waves, speeds): tuples with one entry per wave family; a
       wave has one component per equation. Pointwise.
    2. The waves add up to ``jump``, to rounding, for any data; conservation and well-balancedness follow.
    3. It calls methods of the model (such as ``model.balanced_difference(...)``) and does not test the model's class;
       ``needs`` lists the methods that have no default.
    4. ``eigenvectors = True`` declares that each wave is an eigenvector of the Roe-mean matrix with its speed; else the
       second-order corrections use ``model.matrix_product``.
    5. ``positive = True`` declares that masses stay non-negative for any data; else the scheme falls back to the model's
       ``relaxation``, if defined, at faces next to dry ground.
    6. ``compilable = False`` declares that it needs whole arrays: it runs on the NumPy backend, and its code is not checked.
    7. ``bounds = True`` declares that its speeds are bounds from `fvkit.problem.answers.face_speeds`, valid for all states
       between the two of the face.
    8. Its speeds bound the true wave speeds, since the time step keeps every |speed| dt/dx below the CFL number.

    Examples
    --------
    >>> import attrs
    >>> import fvkit as fv
    >>> @attrs.frozen
    ... class Rightwards(fv.RiemannSolver):
    ...     def solve(self, model, ql, qr, auxl, auxr, jump):
    ...         return (jump,), (model.wave_speeds(ql)[1],)
    >>> Rightwards().solve(fv.Advection(2.0), (1.0,), (3.0,), (), (), jump=(4.0,))
    (((4.0,),), (2.0,))
    """

    questions = RIEMANN
    needs: ClassVar[tuple[str, ...]] = ()
    eigenvectors: ClassVar[bool] = False
    positive: ClassVar[bool] = False
    compilable: ClassVar[bool] = True
    bounds: ClassVar[bool] = False

    @abstractmethod
    def solve(self, model, ql, qr, auxl, auxr, jump):
        """Return (waves, speeds) of a face with total fluctuation ``jump``: tuples with one entry per wave family."""

    @optional
    def total(self, ql, qr, auxl, auxr):
        """Return the sum of the waves, one value per component, for a solver that does not use the model's jump.

        Optional. If the flux of the model differs from the sum, the run is first order and warns."""

    @classmethod
    def serves(cls, model: Model | type[Model]) -> bool:
        """Whether a model defines the methods in ``needs``."""
        return all(model.defines(need) for need in cls.needs)

    def check(self, model: Model) -> None:
        """Raise ValueError, with the missing methods and the solvers that fit, if ``model`` does not define ``needs``."""
        missing = [need for need in self.needs if not model.defines(need)]
        if missing:
            fitting = sorted(kind.__name__ for kind in RiemannSolver.__subclasses__()
                             if kind.serves(model))
            raise ValueError(f"{type(self).__name__} cannot serve {type(model).__name__}: the model does not define "
                             f"{', '.join(f'`{name}`' for name in missing)}. "
                             f"Solvers that fit it: {', '.join(fitting) or 'none'}")


#: Relative distance below which two speed bounds count as equal: waves are differences divided by that distance, and would be
#: mere round-off where a scalar law is smooth.
NARROW = 1e-3

#: Distance below which two bounds count as equal in any case: 1/(s2 - s1) stays a number.
LEAST_GAP = 1e-300

#: A numerical viscosity on D fades out as s1 s2/(s2 - s1)^2 of bounds with one sign rises to 1/``ONE_WAY``: at Froude number 1.5.
ONE_WAY = 3.0


class FaceDifference(NamedTuple):
    """Difference D of a face on which a viscosity acts, and A^ D, None for a conservation law, where it is J.

    With the bounds s1 <= s2 of the speeds, 1/(s2 - s1), 0 where they are equal, and the share of D that counts: 1 where waves run
    both ways, 0 where all run one way.
    """

    s1: Any
    s2: Any
    inverse: Any
    share: Any
    difference: Any
    product: Any


def face_difference(model, ql, qr, auxl, auxr):
    """Return the `FaceDifference` of `HLL` and `Rusanov`."""
    s1, s2 = face_speeds(model, ql, qr, auxl, auxr)
    gap = s2 - s1
    opened = gap > maximum(NARROW * maximum(np.abs(s1), np.abs(s2)), LEAST_GAP)
    inverse = where(opened, 1.0 / where(opened, gap, 1.0), 0.0)
    change = model.difference(ql, qr, auxl, auxr)
    if not model.defines("jump"):
        return FaceDifference(s1, s2, inverse, 1.0, change, None)
    result = list(least(change, model.balanced_difference(ql, qr, auxl, auxr)))
    fluxl, fluxr = mass_flux(model, ql), mass_flux(model, qr)
    for masses, momentum in model.phases:
        row = masses[-1]
        v = (fluxl[row] + fluxr[row]) / (ql[row] + qr[row] + TINY)
        result[momentum] = change[momentum] + v * (result[row] - change[row])
    # Steady flow that is faster than its waves has a D, but no jump: a viscosity on D would never let it settle.
    share = maximum(1.0 - ONE_WAY * maximum((s1 * inverse) * (s2 * inverse), 0.0), 0.0)
    return FaceDifference(s1, s2, inverse, share, result, model.matrix_product(ql, qr, auxl, auxr, tuple(result)))


def with_square_term(model, ql, qr, auxl, auxr, face, rest):
    """Return K - 2 f (A^ - s1) K/(s2 - s1), whose part at the slower bound is what travels left of K.

    That is (1 - sgn A^) K/2 with a polynomial for the sign, exact for waves at the bounds. Waves between them would be split
    centrally, and grow: the square term, with f = m (1 - m^4) of m = (s1 + s2)/(s2 - s1), gives them a direction. Two equations
    have none, but the same waves as mixtures of one velocity, and get the same numbers. Derived here.
    """
    mean = (face.s1 + face.s2) * face.inverse
    squared = mean * mean
    weight = mean * maximum(1.0 - squared * squared, 0.0) * (2.0 * face.inverse)
    return combine(1.0 + weight * face.s1, rest, -weight, model.matrix_product(ql, qr, auxl, auxr, rest))


def at_slower_bound(model, ql, qr, auxl, auxr, face, change):
    """Return P q = (s2 - A^) q/(s2 - s1), the part of q at the slower bound."""
    part = scale(face.inverse, change)
    return combine(face.s2, part, -1.0, model.matrix_product(ql, qr, auxl, auxr, part))


@attrs.frozen
class Roe(RiemannSolver):
    """Roe solver: the jump as a sum of eigenvectors of the Roe-mean matrix.

    The sharpest solver; it needs the model's ``decompose``. It does not guarantee positive depths near vacuum, where the
    scheme falls back to the model's ``relaxation``. Transonic rarefactions need the entropy fix of the scheme.

    Source: P. L. Roe, J. Comput. Phys. 43 (1981) 357-372; f-waves: Bale, LeVeque, Mitran, Rossmanith,
    SIAM J. Sci. Comput. 24 (2003) 955-978.

    Examples
    --------
    >>> import fvkit as fv
    >>> fv.Roe().solve(fv.Burgers(), (2.0,), (0.0,), (), (), jump=(-2.0,))
    (((-2.0,),), (1.0,))
    """

    needs: ClassVar[tuple[str, ...]] = ("decompose",)
    eigenvectors: ClassVar[bool] = True

    def solve(self, model, ql, qr, auxl, auxr, jump):
        return model.decompose(ql, qr, auxl, auxr, jump)


@attrs.frozen
class HLL(RiemannSolver):
    """HLL solver: two waves at bounds s1 <= s2 of all wave speeds at the face::

        Z1 = s1 P D + K-,  P = (s2 - A^)/(s2 - s1),  Z2 = J - Z1,  K = J - A^ D,

    where J is the total path-conservative jump, A^ the Roe-mean matrix (``matrix_product``) and D the difference that the
    numerical viscosity acts on: 0 at rest, in uniform flow down a slope, and where all waves run one way (Froude numbers above
    1.5), which need none. A conservation law has D = qr - ql, A^ D = J and K = 0: the usual HLL. If s1 = s2 the whole jump is
    assigned to that single speed. K- is P K and a square term in A^, which gives the waves between the bounds their direction.

    Notes
    -----
    Smears waves between the outer ones: contacts, internal waves of two phases. Over a bottom and with sources its accuracy
    depends on the model's ``matrix_product``.

    Source: Harten, Lax, van Leer, SIAM Rev. 25 (1983) 35-61; path-conservative form: Castro Diaz, Kurganov,
    Morales de Luna, M2AN 53 (2019) 959-985; D and K derived here.

    Examples
    --------
    >>> import fvkit as fv
    >>> (left, right), speeds = fv.HLL().solve(fv.Burgers(), (2.0,), (-1.0,), (), (), jump=(-1.5,))
    >>> round(float(left[0] + right[0]), 12), [float(speed) for speed in speeds]
    (-1.5, [-1.0, 2.0])
    """

    bounds: ClassVar[bool] = True

    def solve(self, model, ql, qr, auxl, auxr, jump):
        face = face_difference(model, ql, qr, auxl, auxr)
        if face.product is None:
            ratio = face.s1 * face.inverse
            first = combine(ratio * face.s2, face.difference, where(face.inverse > 0.0, -ratio, 0.5), jump)
        else:
            rest = with_square_term(model, ql, qr, auxl, auxr, face, combine(1.0, jump, -face.share, face.product))
            first = at_slower_bound(model, ql, qr, auxl, auxr, face, combine(face.share * face.s1, face.difference, 1.0, rest))
        return (first, subtract(jump, first)), (face.s1, face.s2)


@attrs.frozen
class Rusanov(RiemannSolver):
    """Rusanov (local Lax-Friedrichs) solver: two waves at -/+ s, s the largest speed: Z1 = (A^ D - s D)/2 + K-, Z2 = J - Z1.

    D and K are those of `HLL`, K- the left-going part of K. A conservation law has K = 0, so Z1 = (J - s D)/2. The simplest
    and most diffusive solver; over a bottom upwind where all waves run one way.

    Source: V. V. Rusanov, USSR Comput. Math. Math. Phys. 1 (1962) 304-320; D and K derived here.

    Examples
    --------
    >>> import fvkit as fv
    >>> (left, right), speeds = fv.Rusanov().solve(fv.Burgers(), (2.0,), (0.0,), (), (), jump=(-2.0,))
    >>> float(left[0]), float(right[0]), [float(speed) for speed in speeds]
    (1.0, -3.0, [-2.0, 2.0])
    """

    bounds: ClassVar[bool] = True

    def solve(self, model, ql, qr, auxl, auxr, jump):
        face = face_difference(model, ql, qr, auxl, auxr)
        s = maximum(np.abs(face.s1), np.abs(face.s2))
        if face.product is None:
            first = combine(0.5, jump, -0.5 * s, face.difference)
        else:
            half = 0.5 * face.share
            rest = combine(1.0, jump, -face.share, face.product)
            left = at_slower_bound(model, ql, qr, auxl, auxr, face, with_square_term(model, ql, qr, auxl, auxr, face, rest))
            left = combine(face.share, left, where(face.s2 < 0.0, 1.0 - face.share, 0.0), rest)
            first = add(combine(half, face.product, -half * s, face.difference), left)
        return (first, subtract(jump, first)), (-s, s)


def _function(value: Any) -> Any:
    if not callable(value):
        raise TypeError("`function` must be a Riemann solver f(q_l, q_r, aux_l, aux_r, problem_data), got "
                        f"{validation.shown(value)}")
    return value


@attrs.frozen
class PyClawRiemann(RiemannSolver):
    """PyClaw Riemann solver in Python, ``(q_l, q_r, aux_l, aux_r, problem_data) -> (wave, s, amdq, apdq)``.

    Arrays are (num_eqn, num_faces), ``wave`` is (num_eqn, num_waves, num_faces), ``s`` is (num_waves, num_faces). With two axes
    it gets the components along each sweep, as a solver of one dimension does; transverse solvers are not needed. The waves
    become f-waves, Z_k = s_k W_k. Their difference to the model's jump (rounding, or a source) is distributed over the waves
    in equal parts, so that the scheme is conservative.

    Parameters
    ----------
    function : the Riemann solver.
    problem_data : dictionary passed to the function as ``problem_data``.
    fwave : True if its waves are f-waves already.

    Notes
    -----
    Runs on the NumPy backend only, since the function needs whole arrays. ``amdq`` and ``apdq`` are not used, so an entropy
    fix in them has no effect; the entropy fix of the scheme is for Roe. The model should have the equations of the function,
    with ``flux(q, aux)`` if the flux depends on x. If the flux of the model differs and the model has no ``matrix_product``,
    the run is first order, with the waves of the function, and warns.

    Source: the contract of PyClaw's Python solvers, www.clawpack.org (clawpack.riemann).

    Examples
    --------
    >>> import fvkit as fv
    >>> import numpy as np
    >>> def advection(q_l, q_r, aux_l, aux_r, problem_data):
    ...     u = problem_data["u"]
    ...     return (q_r - q_l)[:, None], np.full_like(q_l, u), None, None
    >>> wave = lambda x: [np.sin(2.0 * np.pi * x)]
    >>> problem = fv.Problem(fv.Advection(1.0), fv.Grid(0.0, 1.0, 50), wave, 1.0, boundary=fv.Periodic())
    >>> fv.solve(problem, fv.WavePropagation(fv.PyClawRiemann(advection, {"u": 1.0})), backend="numpy").success
    True
    """

    compilable: ClassVar[bool] = False

    function: Callable[..., Any] = attrs.field(converter=_function)
    problem_data: Mapping[str, Any] = attrs.field(factory=dict, hash=False, converter=lambda value: validation.mapping(
        value, "problem_data", "{'u': 1.0}"))
    fwave: bool = validation.switch(False)

    def solve(self, model, ql, qr, auxl, auxr, jump):
        wave, speed = self._waves(ql, qr, auxl, auxr)
        missing = (np.array([np.broadcast_to(row, wave.shape[2:]) for row in jump]) - wave.sum(axis=1)) / wave.shape[1]
        return (tuple(tuple(wave[:, k] + missing) for k in range(wave.shape[1])), tuple(speed))

    def total(self, ql, qr, auxl, auxr):
        return tuple(self._waves(ql, qr, auxl, auxr)[0].sum(axis=1))

    def _waves(self, ql: Any, qr: Any, auxl: Any, auxr: Any) -> tuple[Any, Any]:
        """Return the f-waves of the function, (num_eqn, num_waves, num_faces), and their speeds, (num_waves, num_faces)."""
        shape = np.broadcast(*ql, *qr).shape
        faces = math.prod(shape)  # with two axes those of all lines in a row: the function gets one line of them
        left, right, given_left, given_right = (np.array([np.broadcast_to(row, shape).reshape(faces) for row in side])
                                                for side in (ql, qr, auxl, auxr))
        wave, speed, _, _ = self.function(left, right, given_left, given_right, dict(self.problem_data))
        wave, speed = wave.reshape(*wave.shape[:2], *shape), speed.reshape(-1, *shape)
        return wave if self.fwave else wave * speed, speed


def default_riemann(model: Model) -> RiemannSolver:
    """Return the default Riemann solver of a model: its ``preferred_riemann``, else Roe, or HLL without ``decompose``."""
    if model.defines("preferred_riemann"):
        return validation.instance(model.preferred_riemann(), "preferred_riemann()", RiemannSolver)
    return Roe() if model.defines("decompose") else HLL()
