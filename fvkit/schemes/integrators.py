"""Runge-Kutta time integrators of the method of lines, as tables in Shu-Osher form."""

from collections.abc import Sequence
from typing import Any, ClassVar

import attrs

#: Rows of coefficients of a lower triangular matrix.
Table = tuple[tuple[float, ...], ...]

#: Tolerance of sums of coefficients, since published tables have a limited number of digits.
PRINTED = 1e-12


@attrs.frozen
class Integrator:
    """Base class of Runge-Kutta methods for dq/dt = L(q) + S(q), defined by tables of coefficients. Contract:

    1. State k + 1 is u_{k+1} = sum_j alpha[k][j] u_j + dt sum_j beta[k][j] L(u_j), j <= k, with u_0 the old state; the last
       state is the new one. Butcher form has alpha[k] = (1,).
    2. ``cfl`` is the recommended Courant number; at 1 the fastest wave crosses one cell per step.
    3. ``ssp`` is the SSP coefficient: a step is a convex combination of forward Euler steps of length dt/ssp. With None
       non-negative depths are not guaranteed.
    4. ``implicit``, if not empty, is the table of S in Butcher form with the same alpha, its diagonal included: row k belongs
       to u_{k+1}, and its last entry makes that stage implicit. ``weights`` are the weights of S in the new state.
    5. `check` passes: each row of alpha adds up to 1, the last state belongs to time dt, and ``ssp`` is at most the
       smallest alpha/beta.

    Examples
    --------
    Heun's method of second order; its rows are those of u_1 and u_2:

    >>> import fvkit as fv
    >>> class Heun(fv.Integrator):
    ...     alpha = (1.0,), (0.5, 0.5)
    ...     beta = (1.0,), (0.0, 0.5)
    ...     cfl, ssp = 0.5, 1.0
    >>> Heun().check()
    >>> fv.MethodOfLines(fv.Roe(), fv.MP5(), Heun()).cfl
    0.5
    """

    alpha: ClassVar[Table] = ()
    beta: ClassVar[Table] = ()
    implicit: ClassVar[Table] = ()
    weights: ClassVar[tuple[float, ...]] = ()
    cfl: ClassVar[float] = 1.0
    ssp: ClassVar[float | None] = None

    def __new__(cls, *arguments: Any, **named: Any) -> Any:
        if not cls.alpha:
            raise TypeError(f"{cls.__name__} is abstract: take fv.SSPRK104() or another, or set `alpha` and `beta`")
        return super().__new__(cls)

    def check(self) -> None:
        """Raise ValueError, with the row and the reason, for tables of an inconsistent method."""
        name, when = type(self).__name__, [0.0]
        if len(self.beta) != len(self.alpha):
            raise ValueError(f"alpha and beta of {name} must have as many rows each, got {len(self.alpha)} and {len(self.beta)}")
        for k, (alpha, beta) in enumerate(zip(self.alpha, self.beta, strict=True)):
            if max(len(alpha), len(beta)) > k + 1:
                raise ValueError(f"row {k} of the tables of {name} may look at {k + 1} states, got {alpha} and {beta}")
            _sum(alpha, 1.0, f"row {k} of alpha of {name}", "the state that was there is kept")
            when.append(sum(a * t for a, t in zip(alpha, when, strict=False)) + sum(beta))
            steps = min((a / b if b > 0.0 else 0.0 for a, b in zip((*alpha, *[0.0] * k), beta, strict=False) if b), default=0.0)
            if self.ssp is not None and steps < self.ssp * (1.0 - PRINTED):
                raise ValueError(f"`ssp` of {name} must be at most alpha/beta of every entry, {steps:g} in row {k}, or None: "
                                 f"no positivity guaranteed; got {self.ssp:g}")
        _sum(when[-1:], 1.0, f"the time of the last state of {name}", "in units of dt, from alpha and beta")
        if self.implicit:
            _sum(self.weights, 1.0, f"`weights` of {name}", "those of the sources in the new state")


def _sum(values: Sequence[float], wanted: float, name: str, why: str) -> None:
    if not abs(sum(values) - wanted) <= PRINTED:
        raise ValueError(f"{name} must add up to {wanted:g} ({why}), got {sum(values):.15g}")


@attrs.frozen
class SSPRK3(Integrator):
    """Three-stage, third-order Runge-Kutta method, strong stability preserving (SSP coefficient 1): few oscillations at shocks.

    Source: C.-W. Shu, S. Osher, J. Comput. Phys. 77 (1988) 439-471 (remembered, order measured).

    Examples
    --------
    >>> import fvkit as fv
    >>> fv.SSPRK3().cfl, fv.SSPRK3().ssp, len(fv.SSPRK3().alpha)
    (0.6, 1.0, 3)
    """

    alpha: ClassVar[Table] = ((1.0,), (3 / 4, 1 / 4), (1 / 3, 0.0, 2 / 3))
    beta: ClassVar[Table] = ((1.0,), (0.0, 1 / 4), (0.0, 0.0, 2 / 3))
    cfl: ClassVar[float] = 0.6
    ssp: ClassVar[float | None] = 1.0


@attrs.frozen
class SSPRK104(Integrator):
    """Ten-stage, fourth-order Runge-Kutta method, SSP coefficient 6: the default; 4.2 stages per unit of Courant number.

    Unstable with fifth-order reconstructions from a Courant number of about 3.5 on.

    Source: D. I. Ketcheson, SIAM J. Sci. Comput. 30 (2008) 2113-2136 (remembered, order measured).

    Examples
    --------
    >>> import fvkit as fv
    >>> fv.SSPRK104().cfl, fv.SSPRK104().ssp, len(fv.SSPRK104().alpha)
    (2.4, 6.0, 10)
    """

    alpha: ClassVar[Table] = (
        (1.0,), (0.0, 1.0), (0.0, 0.0, 1.0), (0.0, 0.0, 0.0, 1.0), (3 / 5, 0.0, 0.0, 0.0, 2 / 5),
        *(tuple([0.0] * k + [1.0]) for k in (5, 6, 7, 8)), (1 / 25, 0.0, 0.0, 0.0, 9 / 25, 0.0, 0.0, 0.0, 0.0, 3 / 5))
    beta: ClassVar[Table] = (
        (1 / 6,), (0.0, 1 / 6), (0.0, 0.0, 1 / 6), (0.0, 0.0, 0.0, 1 / 6), (0.0, 0.0, 0.0, 0.0, 1 / 15),
        *(tuple([0.0] * k + [1 / 6]) for k in (5, 6, 7, 8)), (0.0, 0.0, 0.0, 0.0, 3 / 50, 0.0, 0.0, 0.0, 0.0, 1 / 10))
    cfl: ClassVar[float] = 2.4
    ssp: ClassVar[float | None] = 6.0


@attrs.frozen
class DP5(Integrator):
    """Dormand-Prince fifth-order Runge-Kutta method, 6 stages, without the embedded method: for smooth flow. Not SSP.

    Source: J. R. Dormand, P. J. Prince, J. Comput. Appl. Math. 6 (1980) 19-26 (remembered, order measured).

    Examples
    --------
    >>> import fvkit as fv
    >>> fv.DP5().cfl, fv.DP5().ssp, len(fv.DP5().alpha)
    (1.0, None, 6)
    """

    alpha: ClassVar[Table] = ((1.0,),) * 6
    beta: ClassVar[Table] = (
        (1 / 5,), (3 / 40, 9 / 40), (44 / 45, -56 / 15, 32 / 9),
        (19372 / 6561, -25360 / 2187, 64448 / 6561, -212 / 729),
        (9017 / 3168, -355 / 33, 46732 / 5247, 49 / 176, -5103 / 18656),
        (35 / 384, 0.0, 500 / 1113, 125 / 192, -2187 / 6784, 11 / 84))


@attrs.frozen
class ARK4(Integrator):
    """Additive Runge-Kutta method ARK4(3)6L[2]SA: fourth order, sources implicit, 6 stages. Not SSP.

    Sources are evaluated at Gauss nodes of the reconstruction, so that their cell averages are accurate. Full order with
    stiff drag needs an initial state in equilibrium; an initial layer reduces the order of every method.

    Source: C. A. Kennedy, M. H. Carpenter, Appl. Numer. Math. 44 (2003) 139-181 (remembered; the order conditions of both
    tables and across them hold to rounding).

    Examples
    --------
    >>> import fvkit as fv
    >>> fv.ARK4().cfl, len(fv.ARK4().implicit)
    (1.0, 5)
    """

    weights: ClassVar[tuple[float, ...]] = (82889 / 524892, 0.0, 15625 / 83664, 69875 / 102672, -2260 / 8211, 1 / 4)
    alpha: ClassVar[Table] = ((1.0,),) * 6
    beta: ClassVar[Table] = (
        (1 / 2,), (13861 / 62500, 6889 / 62500),
        (-116923316275 / 2393684061468, -2731218467317 / 15368042101831, 9408046702089 / 11113171139209),
        (-451086348788 / 2902428689909, -2682348792572 / 7519795681897, 12662868775082 / 11960479115383,
         3355817975965 / 11060851509271),
        (647845179188 / 3216320057751, 73281519250 / 8382639484533, 552539513391 / 3454668386233,
         3354512671639 / 8306763924573, 4040 / 17871),
        weights)
    implicit: ClassVar[Table] = (
        (1 / 4, 1 / 4), (8611 / 62500, -1743 / 31250, 1 / 4),
        (5012029 / 34652500, -654441 / 2922500, 174375 / 388108, 1 / 4),
        (15267082809 / 155376265600, -71443401 / 120774400, 730878875 / 902184768, 2285395 / 8070912, 1 / 4),
        (*weights[:5], 1 / 4))
