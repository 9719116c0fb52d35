"""`MethodOfLines`: high order in space by reconstruction, in time by Runge-Kutta methods."""

import warnings

import attrs
import numpy as np

from fvkit import validation
from fvkit.problem.model import Model
from fvkit.problem.sources import Source
from fvkit.schemes.integrators import SSPRK104, Integrator
from fvkit.schemes.reconstruction import MP5, Reconstruction
from fvkit.schemes.riemann import RiemannSolver
from fvkit.schemes.scheme import MASS_FLUX, NET, Parts, Read, Scheme, Stage, here
from fvkit.schemes.splitting import Splitting, Strang, Unsplit
from fvkit.schemes.stages.cell_polynomial import faces, limit_at_shore, mean_source, near_shore, net_change, reconstruct, third
from fvkit.schemes.stages.faces import BOTH, face_stages, to_left, to_right
from fvkit.schemes.stages.positivity import hold_within, mass_fluxes, may_overdraw


@attrs.frozen
class MethodOfLines(Scheme):
    """High-order path-conservative finite volumes: reconstruction, Riemann solver at faces, cell integrals, Runge-Kutta steps.

    dQ_i/dt = -(A+_{i-1/2} + A-_{i+1/2} + N_i)/dx,

    with the fluctuations A+ and A- of a Riemann solver between the two values reconstructed at a face, and N the integral of
    f_x + B q_x - source over the polynomial of the cell, in closed form if the model defines ``cell_integral``. The
    reconstructed variables are the model's characteristic variables of q + ``lift``, which is constant at rest. So a lake at
    rest is preserved to rounding over any bottom.

    Parameters
    ----------
    riemann : the Riemann solver.
    reconstruction : `MP5`, `WENO5` (fifth order), `MUSCL` (second order), or a user-defined one.
    integrator : `SSPRK104`, `SSPRK3`, `DP5` or `ARK4`. `ARK4` treats one source implicitly in its stages, which friction on
        slopes needs. The others alternate sources and transport by Strang splitting: second order, and first order, with a
        warning, where a source balances the flow.
    cfl : target Courant number; None for that of the integrator.

    Notes
    -----
    Fifth order for smooth solutions without absent phases. For a model with masses the polynomial of a cell is scaled towards
    its mean where a face value would be less than a tenth of the mean, and where masses of its five cells differ by more than
    a factor 10: first order at wet/dry fronts. It is scaled further where velocities at its faces would exceed the range of
    the cell and its neighbours. Faces where a phase separates faster than sound use the relaxation solver. With an SSP
    integrator depths stay non-negative; `DP5` and `ARK4` do not guarantee that.

    First order, too, at composite waves of a scalar flux that is not convex (fan and shock in one), which converge to the
    entropy solution.

    For discontinuous solutions second-order `WavePropagation` reaches the same error in a fifth of the time. Static friction
    (piles at rest) is not supported; use `WavePropagation`.

    Source: reconstruction in characteristic variables, frozen equilibrium and in-cell integral derived here.

    Examples
    --------
    >>> import fvkit as fv
    >>> fv.MethodOfLines(fv.Roe(), reconstruction=fv.WENO5(), integrator=fv.DP5())
    MethodOfLines(riemann=Roe(), reconstruction=WENO5(), integrator=DP5(), cfl=1.0)
    """

    riemann: RiemannSolver = validation.field(validation.instance, kind=RiemannSolver, hint="such as fv.HLL()")
    reconstruction: Reconstruction = validation.field(validation.instance, MP5(), kind=Reconstruction, hint="such as fv.MP5()")
    integrator: Integrator = validation.field(validation.instance, SSPRK104(), kind=Integrator, hint="such as fv.SSPRK104()")
    cfl: float = validation.optional_number(above=0.0)
    splitting: Splitting = attrs.field(init=False, repr=False)

    def __attrs_post_init__(self) -> None:
        object.__setattr__(self, "splitting", Unsplit() if self.integrator.implicit else Strang())
        if self.cfl is None:
            object.__setattr__(self, "cfl", self.integrator.cfl)

    @property
    def cfl_max(self) -> float:
        """1.1 times the target Courant number, since wave speeds may grow within a step."""
        return 1.1 * self.cfl

    @property
    def limiting(self) -> Reconstruction:
        return self.reconstruction

    @property
    def nominal_order(self) -> int:
        return self.reconstruction.order

    @property
    def time_integrator(self) -> Integrator:
        return self.integrator

    def parts(self, model: Model, sources: tuple[Source, ...]) -> Parts:
        self.riemann.check(model)
        for source in sources:
            if source.static:
                raise ValueError(f"MethodOfLines cannot serve {type(source).__name__}: a pile held by static friction needs "
                                 "WavePropagation, such as fv.WavePropagation(gr.Relaxation())")
        if self.integrator.implicit and (len(sources) > 1 or not all(source.defines("implicit_rate") for source in sources)):
            given = ", ".join(type(source).__name__ for source in sources)
            raise ValueError(f"{type(self.integrator).__name__} takes one source that defines `implicit_rate`, got {given}: "
                             "use another integrator, such as fv.SSPRK104(), which splits")
        split = [type(source).__name__ for source in sources if source.defines("driven") and not source.between_phases]
        if split and not self.integrator.implicit:
            warnings.warn(f"{type(self.integrator).__name__} alternates {' and '.join(split)} with the transport: a flow that it "
                          "balances, such as uniform flow down a slope, is wrong to first order in dt. Use integrator=fv.ARK4(), "
                          "which takes it into its stages, or fv.WavePropagation", stacklevel=2)
        beside = [type(source).__name__ for source in sources if not source.defines("driven")]
        if beside:
            warnings.warn(f"{type(self.integrator).__name__} alternates {' and '.join(beside)} with the transport: the run is of "
                          "second order in time. fv.WavePropagation has that order too, at less cost; for a higher one integrate "
                          "fv.rhs and the source with scipy.integrate.solve_ivp", stacklevel=2)
        return Parts(model, self.riemann, (), sources, reconstruction=self.reconstruction)

    def stages(self, parts: Parts) -> tuple[Stage, ...]:
        face = {"ql": Read("right", -1), "qr": Read("left"), "auxl": Read("right_aux", -1), "auxr": Read("left_aux")}
        first = self._reconstruct()
        result = [first]
        if parts.model.phases:
            result.append(Stage(limit_at_shore, {**first.reads, **here(*first.writes)}, first.writes, guard=near_shore))
        result += face_stages(parts, face, fixes=self.riemann.eigenvectors)
        terms: tuple[str, ...] = ()
        if parts.model.phases:
            terms = (MASS_FLUX,)
            states = {"ql": Read("q", -1), "qr": Read("q")}
            result += [Stage(mass_fluxes, here("left_going"), terms),
                       Stage(hold_within, {**states, **here("left_going", *terms)}, terms, guard=may_overdraw)]
        faces = {"from_left": Read("to_right"), "from_right": Read("to_left", 1)}
        return (*result, Stage(to_left, here(BOTH[0], *terms), ("to_left",), light=True),
                Stage(to_right, here(BOTH[1], *terms), ("to_right",), light=True),
                Stage(net_change, {**faces, **here("inside", "aux")}, (NET,)))

    def source_stages(self, parts: Parts) -> tuple[Stage, ...]:
        """Return the stages of the implicit sources; ``net`` is minus their mean rate over a cell."""
        if not (self.integrator.implicit and parts.sources):
            return ()
        return (Stage(mean_source, self._reconstruct().reads, (NET,)),)

    def around(self, parts: Parts) -> Parts:
        return parts

    def background(self, parts: Parts, flow: np.ndarray, aux: np.ndarray, at_faces: np.ndarray | None) -> np.ndarray:
        """Return averages, values at both faces, third modes and residuals (initially 0) of the background, (5 num_eqn, m).

        Face values of ghost cells are reconstructed from the averages; so are all face values if ``at_faces`` is None.
        """
        reach, width = self.reconstruction.reach, flow.shape[1]
        stencil = [tuple(flow[:, k:width - 2 * reach + k]) for k in range(2 * reach + 1)]
        sides = np.array([flow, flow, np.zeros_like(flow)])
        inner = slice(reach, width - reach)
        for side, values in zip(sides, (*faces(self.reconstruction, stencil), third(self.reconstruction, stencil)), strict=True):
            for row, value in zip(side, values, strict=True):
                row[inner] = value
        if at_faces is not None:
            halo = (width - (len(at_faces[0]) - 1)) // 2
            sides[0, :, halo:width - halo], sides[1, :, halo:width - halo] = at_faces[:, :-1], at_faces[:, 1:]
        return np.concatenate([flow, *sides, np.zeros_like(flow)])

    def completed(self, rows: np.ndarray, net: np.ndarray) -> np.ndarray:
        return np.concatenate([rows[:-len(net)], net])

    def _reconstruct(self) -> Stage:
        reach = self.reconstruction.reach
        return Stage(reconstruct, {name: Read(name, -reach, reach) for name in ("q", "aux")},
                     ("left", "right", "left_aux", "right_aux", "inside"))
