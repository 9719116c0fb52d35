"""`WavePropagation`: LeVeque's wave propagation in f-wave form, first and second order."""

from typing import Any

import attrs
import numpy as np

from fvkit import validation
from fvkit.pointwise import TINY, add, combine, dot, maximum, minimum, multiply, scale, weighted, where
from fvkit.problem.model import Model
from fvkit.problem.sources import Source
from fvkit.schemes.limiters import MC, Limiter
from fvkit.schemes.riemann import RiemannSolver
from fvkit.schemes.scheme import MASS_FLUX, NET, NEW, Parts, Read, Scheme, Stage, here
from fvkit.schemes.splitting import Splitting, Strang
from fvkit.schemes.stages.driven import drive
from fvkit.schemes.stages.faces import composite, convexity, face_stages, to_left, to_right, upwinding
from fvkit.schemes.stages.in_cell_shocks import detection_stages, first_order_stage, resolved_faces_stage
from fvkit.schemes.stages.passengers import moved_stage, passenger_stages
from fvkit.schemes.stages.positivity import hold_within, mass_fluxes, may_overdraw

_STATES = {"ql": Read("q", -1), "qr": Read("q")}
#: What a stage of faces reads.
FACE = {**_STATES, "auxl": Read("aux", -1), "auxr": Read("aux")}


def _limiters(value: Any) -> tuple[Limiter, ...]:
    given = value if isinstance(value, tuple) else (value,)
    return tuple(validation.instance(item, "limiter", Limiter, "such as fv.MC(), or a tuple of them") for item in given)


def _order(value: Any) -> int:
    return int(validation.choice(value, "order", (1, 2)))


@attrs.frozen
class WavePropagation(Scheme):
    """Wave propagation: Godunov's method (order 1), with limited Lax-Wendroff corrections (order 2).

    A face with total fluctuation J = sum Z_k sends A- = sum_{s<0} Z_k to the left and A+ = J - A- to the right (a
    zero-speed f-wave is split in half). At order 2 the correction flux

        F = 1/2 sum_k sgn(s_k) Z~_k - dt/(2 dx) A^ sum_k Z~_k,   Z~_k = phi(theta_k, nu_k) Z_k,

    is added, with the Roe-mean matrix A^. So every solver is second order, also if its waves are not eigenvectors; for
    eigenvectors A^ Z_k = s_k Z_k. Nonconservative products and a bottom also need the *cross term*,
    (dt/dx)^2/4 of the model's ``cross`` for each neighbour; without it the scheme is first order there.

    Parameters
    ----------
    riemann : the Riemann solver.
    limiter : one limiter, or a tuple with one per wave family of the solver. Unused at order 1.
    order : 1 or 2.
    cfl : target Courant number, in (0, 1].
    splitting : splitting of transport and sources.
    entropy_fix : for solvers with eigenvectors (Roe), add viscosity to the outer fields at transonic rarefactions. The
        viscosity acts on the balanced difference, so that rest and shocks are unchanged.
    cross_term : include the cross term (order 2). Switch it off only to study its effect.
    in_cell_shocks : reconstruct isolated shocks inside cells, see Notes; for any solver, with a model that defines
        ``decompose``.

    Notes
    -----
    Masses of the model never become negative: mass fluxes are limited by the content of the cell. Where neighbouring depths
    differ much, or a phase is almost absent, solvers that are not positive fall back to the model's ``relaxation``, face by
    face. Corrections vanish at such faces: the scheme is first-order accurate at wet/dry fronts.

    Internal shocks of a nonconservative system converge to a solution that depends on the numerical viscosity; the error of
    their speed is a few percent at any number of cells. With ``in_cell_shocks`` they converge to the weak solution of the
    stated path, that of the model's ``jump`` (for `fvkit_granular.TwoPhase` the segment in the depths). That path is not more
    physical than others. The speed of a shock with an attached fan keeps an error of .1 to .4 %, since the states come from
    Roe's linearisation. Cells of smooth, dry or static flow are unchanged; faces of a marked cell are first order.

    Source: R. J. LeVeque, Finite Volume Methods for Hyperbolic Problems, 2002, chapters 6, 15; f-waves: Bale, LeVeque,
    Mitran, Rossmanith, SIAM J. Sci. Comput. 24 (2003) 955-978. Matrix form and cross term: derived here.

    Examples
    --------
    >>> import fvkit as fv
    >>> scheme = fv.WavePropagation(fv.Roe(), limiter=fv.Superbee(), cfl=0.8)
    >>> scheme.riemann, scheme.limiter, scheme.order, scheme.splitting
    (Roe(), (Superbee(),), 2, Strang())
    """

    riemann: RiemannSolver = validation.field(validation.instance, kind=RiemannSolver, hint="such as fv.HLL()")
    limiter: Any = attrs.field(factory=MC, converter=_limiters)
    order: int = attrs.field(default=2, converter=_order)
    cfl: float = validation.number(0.9, above=0.0, at_most=1.0)
    splitting: Splitting = validation.field(validation.instance, Strang(), kind=Splitting, hint="such as fv.Strang()")
    entropy_fix: bool = validation.switch(True)
    cross_term: bool = validation.switch(True)
    in_cell_shocks: bool = validation.switch(False)

    @property
    def cfl_max(self) -> float:
        """Stability limit 1, with a tolerance for round-off."""
        return 1.0 + 1e-12

    @property
    def wants_cross(self) -> bool:
        return self.order == 2 and self.cross_term

    @property
    def planar(self) -> bool:
        return True

    def at_first_order(self) -> Scheme:
        return attrs.evolve(self, order=1)

    @property
    def limiting(self) -> tuple[Limiter, ...]:
        return self.limiter

    @property
    def nominal_order(self) -> int:
        return self.order

    def parts(self, model: Model, sources: tuple[Source, ...]) -> Parts:
        self.riemann.check(model)
        if self.in_cell_shocks and not model.defines("decompose"):
            raise ValueError(f"WavePropagation(in_cell_shocks=True) cannot serve {type(model).__name__}: the model does not "
                             "define `decompose`, which takes a shock apart. Define it, or leave in_cell_shocks=False")
        return Parts(model, self.riemann, self.limiter, sources)

    def stages(self, parts: Parts) -> tuple[Stage, ...]:
        model = parts.model
        result = detection_stages(model) if self.in_cell_shocks else []
        result += face_stages(parts, FACE, self.entropy_fix and self.riemann.eigenvectors, waves=self.order == 2)
        if self.in_cell_shocks:
            result.append(resolved_faces_stage(("speeds", "waves") if self.order == 2 else ()))
        terms = self._corrections(parts)
        result += self._second_order(parts) if terms else []
        if model.phases:
            held = (MASS_FLUX, *terms)
            result += [Stage(mass_fluxes, here("left_going", *terms[:1]), (MASS_FLUX, *terms[:1])),
                       Stage(hold_within, {**_STATES, **here("left_going", *held)}, held, guard=may_overdraw)]
            if self.in_cell_shocks and terms:
                result.append(first_order_stage(terms, held[:1]))
            terms = (*terms, MASS_FLUX)
        elif self.in_cell_shocks and terms:
            result.append(first_order_stage(terms, ()))
        if parts.swept:
            result += passenger_stages(parts, self.order)
        result += [Stage(to_left, here("left_going", *terms), ("to_left",), light=True),
                   Stage(to_right, here("right_going", *terms), ("to_right",), light=True),
                   Stage(net_fluctuation, {"from_left": Read("to_right"), "from_right": Read("to_left", 1)}, (NET,))]
        if parts.joint:
            result.append(Stage(drive, {**here("q", NET, "aux"), "bearing": Read("bearing", 0, 1)}, (NEW,)))
        if parts.swept:
            result.append(moved_stage(parts, NEW if parts.joint else NET))
        return tuple(result)

    def _second_order(self, parts: Parts) -> list[Stage]:
        """Return the stages of the second-order corrections, fields "correction" and, if the model defines it, "cross"."""
        result = []
        if self.in_cell_shocks or (parts.model.defines("relaxation") and not self.riemann.positive):
            result.append(Stage(upwinding, here("speeds"), ("sides",), light=True))
        limits = any(limiter.limits for limiter in parts.limiters)
        if limits:
            result.append(Stage(projections, {"before": Read("waves", -1), "waves": Read("waves")}, ("overlaps",), light=True))
        waves = {**here("waves", "speeds", "sides"), **({"overlaps": Read("overlaps", 0, 1)} if limits else {})}
        result.append(Stage(eigenvector_correction, waves, ("correction",)) if self.riemann.eigenvectors else
                      Stage(matrix_correction, {**FACE, **waves}, ("correction",)))
        if "cross" in self._corrections(parts):
            result.append(Stage(cross_term, FACE, ("cross",)))
        return result

    def _corrections(self, parts: Parts) -> tuple[str, ...]:
        """Return the names of the correction fields."""
        if self.order == 1:
            return ()
        return ("correction", "cross") if self.cross_term and parts.model.defines("cross") else ("correction",)


def projections(parts, ratio, before, waves):
    """Return <Z_k of the face before, Z_k> for every wave family."""
    return {"overlaps": tuple(overlap(parts.model, ratio, old, new) for old, new in zip(before, waves, strict=True))}


def overlap(model, ratio, one, other):
    """Return the scalar product of two waves, with momenta scaled by 2 dt/dx, so that results do not depend on units.

    Scaled momenta equal the masses for a wave of Courant number 1/2.
    """
    momenta = [momentum for _, momentum in model.phases]
    scaled = [2.0 * ratio if row in momenta else 1.0 for row in range(len(one))]
    return dot(multiply(scaled, one), multiply(scaled, other))


def limited(model, limiters, ratio, waves, speeds, overlaps, gently=False):
    """Return the limiter's factor of every wave; ``overlaps`` are its projections on both neighbours, absent if unlimited.

    ``gently`` bounds the factor by that of Minmod, since sharper limiters may violate the entropy condition of nonconvex fluxes.
    """
    if not overlaps:
        return tuple(1.0 for _ in waves)
    factors = []
    for k, (wave, speed, before, after) in enumerate(zip(waves, speeds, *overlaps, strict=True)):
        theta = where(speed > 0.0, before, after) / (overlap(model, ratio, wave, wave) + TINY)
        factor = limiters[k if len(limiters) > 1 else 0].phi(theta, np.abs(speed) * ratio)
        factors.append(minimum(factor, maximum(minimum(theta, 1.0), 0.0)) if gently else factor)
    return tuple(factors)


def eigenvector_correction(parts, ratio, waves, speeds, sides, overlaps=()):
    """Return the correction flux of waves that are eigenvectors: 1/2 (sgn s - s dt/dx) Z~."""
    factors = limited(parts.model, parts.limiters, ratio, waves, speeds, overlaps)
    half = 0.5 * ratio
    weights = [(side - half * speed) * factor for side, speed, factor in zip(sides, speeds, factors, strict=True)]
    return {"correction": weighted(weights, waves)}


def matrix_correction(parts, ratio, ql, qr, auxl, auxr, waves, speeds, sides, overlaps=()):
    """Return the correction flux with the Roe-mean matrix: 1/2 sgn s Z~ - dt/(2 dx) A^ Z~."""
    factors = limited(parts.model, parts.limiters, ratio, waves, speeds, overlaps, composite(parts.model))
    if composite(parts.model):
        factors = scale(convexity(parts.model, ql, qr, auxl, auxr), factors)
    kept = weighted(scale(ratio, factors), waves)
    upwinded = weighted(multiply(sides, factors), waves)
    return {"correction": combine(1.0, upwinded, -0.5, parts.model.matrix_product(ql, qr, auxl, auxr, kept))}


def cross_term(parts, ratio, ql, qr, auxl, auxr):
    """Return dt/dx/4 of the cross term, which both fluctuations of a face lose."""
    return {"cross": scale(0.25 * ratio, parts.model.cross(ql, qr, auxl, auxr))}


def net_fluctuation(parts, ratio, from_left, from_right):
    """Sum what enters a cell through both of its faces."""
    return {NET: add(from_left, from_right)}
