"""`MethodOfLines`: high order in space by reconstruction, in time by Runge and Kutta."""

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
from fvkit.schemes.stages.cell_polynomial import draw, faces, mean_source, near_shore, net_change, reconstruct, third
from fvkit.schemes.stages.faces import BOTH, face_stages, to_left, to_right
from fvkit.schemes.stages.positivity import hold_within, mass_fluxes, may_overdraw


@attrs.frozen
class MethodOfLines(Scheme):
    """Path-conservative finite volumes of high order: reconstruct, solve at faces, integrate inside, march in time.

    dQ_i/dt = -(A+_{i-1/2} + A-_{i+1/2} + N_i)/dx,

    with the fluctuations of any Riemann solver between the values that both cells of a face reconstruct there, and N the
    integral of f_x + B q_x - source over the polynomial of the cell, in closed form where the model has one
    (``cell_integral``). Reconstructed are the model's modes of q + ``lift``, which is constant at rest: so rest is kept to
    rounding over any bottom.

    Parameters
    ----------
    riemann : the Riemann solver.
    reconstruction : `MP5`, `WENO5` (fifth order), `MUSCL` (second), or one of your own.
    integrator : `SSPRK104`, `SSPRK3`, `DP5` or `ARK4`, which takes one source into its stages, stiff or not: friction on slopes
        needs it. With the others sources alternate with transport by Strang's splitting: second order, and first where a
        source balances the flow, which gives a warning.
    cfl : Courant number aimed at; None for that of the integrator.

    Notes
    -----
    Fifth order where the solution is smooth and masses are present. For a model with masses the polynomial of a cell is
    drawn towards its mean where it would leave a face less than a tenth of it, and where masses of its five cells differ
    by more than a factor 10: shores are first order. It is drawn further where velocities at its faces would leave those of
    the cell and its neighbours, and faces where a phase parts faster than sound get the relaxation solver. With an SSP
    integrator depths then stay non-negative; `DP5` and `ARK4` do not promise that.

    Composite waves of a flux that is not convex, fan and shock in one, may converge to a shock that breaks the entropy condition:
    use `WavePropagation`, which does not.

    Where the solution jumps, second-order `WavePropagation` gives the same error in a fifth of the time. Static friction
    (piles at rest) is left to it.

    Source: reconstruction in modes, frozen equilibrium and in-cell integral derived here.
    """

    riemann: RiemannSolver = attrs.field()
    reconstruction: Reconstruction = attrs.field(factory=MP5)
    integrator: Integrator = attrs.field(factory=SSPRK104)
    cfl: float = validation.optional_number(above=0.0)
    splitting: Splitting = attrs.field(init=False, repr=False)

    def __attrs_post_init__(self) -> None:
        validation.instance(self.riemann, "riemann", RiemannSolver, "such as fv.HLL()")
        validation.instance(self.reconstruction, "reconstruction", Reconstruction, "such as fv.MP5()")
        validation.instance(self.integrator, "integrator", Integrator, "such as fv.SSPRK104()")
        object.__setattr__(self, "splitting", Unsplit() if self.integrator.implicit else Strang())
        if self.cfl is None:
            object.__setattr__(self, "cfl", self.integrator.cfl)

    @property
    def cfl_max(self) -> float:
        """A tenth above the number aimed at: speeds may grow that much within a step."""
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
        return Parts(model, self.riemann, (), sources, reconstruction=self.reconstruction)

    def stages(self, parts: Parts) -> tuple[Stage, ...]:
        face = {"ql": Read("right", -1), "qr": Read("left"), "auxl": Read("right_aux", -1), "auxr": Read("left_aux")}
        first = self._reconstruct()
        result = [first]
        if parts.model.phases:
            result.append(Stage(draw, {**first.reads, **here(*first.writes)}, first.writes, guard=near_shore))
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
        """Return the stages of the implicit sources: ``net`` is their mean rate over a cell, with its sign turned."""
        if not (self.integrator.implicit and parts.sources):
            return ()
        return (Stage(mean_source, self._reconstruct().reads, (NET,)),)

    def around(self, parts: Parts) -> Parts:
        return parts

    def background(self, parts: Parts, flow: np.ndarray, aux: np.ndarray, at_faces: np.ndarray | None) -> np.ndarray:
        """Return averages, values at both faces, third modes and, still 0, residuals of the background.

        The faces of ghost cells, and all where no values at faces are given, come from the averages.
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
