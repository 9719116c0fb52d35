"""`MethodOfLines`: high order in space by reconstruction, in time by Runge and Kutta."""

from typing import Any, NamedTuple

import attrs
import numpy as np

from fvkit import _validate
from fvkit.integrators import SSPRK104, Integrator
from fvkit.model import Model
from fvkit.pointwise import TINY, add, maximum, minimum, scale, subtract, where
from fvkit.polynomial import polynomial
from fvkit.reconstruction import MP5, Reconstruction
from fvkit.riemann import RiemannSolver
from fvkit.schemes.base import Parts, Read, Scheme, Stage
from fvkit.schemes.dry import hold_within, mass_fluxes, may_overdraw
from fvkit.schemes.faces import BOTH, face_stages, here, to_left, to_right
from fvkit.sources import Source, Splitting, Strang, Unsplit

#: A face keeps at least this share of the mean of its cell's mass.
LEAST = 0.1

#: The reconstruction is whole where the masses of its cells differ by less than this factor, and gone at twice that.
CONTRAST = 10.0

#: The velocity at a face may leave those of its cell and the next ones by this share of the range of the wave speeds.
HASTE = 0.1

#: Share of the whole below which the mass of a phase is no reason to give up order.
RARE = 1e-6


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
    integrator : `SSPRK104`, `SSPRK3`, `DP5` or `ARK4`, which takes a stiff source into its stages. With the others
        sources alternate with transport by Strang's splitting: second order.
    cfl : Courant number aimed at; None for that of the integrator.

    Notes
    -----
    Fifth order where the solution is smooth and masses are present. For a model with masses the polynomial of a cell is
    drawn towards its mean where it would leave a face less than a tenth of it, and where masses of its five cells differ
    by more than a factor 10: shores are first order. It is drawn further where velocities at its faces would leave those of
    the cell and its neighbours, and faces where a phase parts faster than sound get the relaxation solver. With an SSP
    integrator depths then stay non-negative; `DP5` and `ARK4` do not promise that.

    Where the solution jumps, second-order `WavePropagation` gives the same error in a fifth of the time. Static friction
    (piles at rest) is left to it.

    Source: reconstruction in modes, frozen equilibrium and in-cell integral derived here.
    """

    riemann: RiemannSolver = attrs.field()
    reconstruction: Reconstruction = attrs.field(factory=MP5)
    integrator: Integrator = attrs.field(factory=SSPRK104)
    cfl: float = _validate.optional_number(above=0.0)
    splitting: Splitting = attrs.field(init=False, repr=False)

    def __attrs_post_init__(self) -> None:
        _validate.instance(self.riemann, "riemann", RiemannSolver, "such as fv.HLL()")
        _validate.instance(self.reconstruction, "reconstruction", Reconstruction, "such as fv.MP5()")
        _validate.instance(self.integrator, "integrator", Integrator, "such as fv.SSPRK104()")
        object.__setattr__(self, "splitting", Unsplit() if self.integrator.implicit else Strang())
        if self.cfl is None:
            object.__setattr__(self, "cfl", self.integrator.cfl)

    @property
    def cfl_max(self) -> float:
        """A tenth above the number aimed at: speeds may grow that much within a step."""
        return 1.1 * self.cfl

    @property
    def time_integrator(self) -> Integrator:
        return self.integrator

    def parts(self, model: Model, sources: tuple[Source, ...]) -> Parts:
        self.riemann.check(model)
        for source in sources:
            if source.defines("limit_jump"):
                raise ValueError(f"MethodOfLines cannot serve {type(source).__name__}: a pile held by static friction needs "
                                 "WavePropagation, such as fv.WavePropagation(gr.Relaxation())")
        if self.integrator.implicit and (len(sources) > 1 or not all(source.defines("implicit_rate") for source in sources)):
            given = ", ".join(type(source).__name__ for source in sources)
            raise ValueError(f"{type(self.integrator).__name__} takes one source that defines `implicit_rate`, got {given}: "
                             "use another integrator, such as fv.SSPRK104(), which splits")
        return Parts(model, self.riemann, (), sources, reconstruction=self.reconstruction)

    def stages(self, parts: Parts) -> tuple[Stage, ...]:
        face = (Read("right", -1, -1), Read("left", 0, 0), Read("right_aux", -1, -1), Read("left_aux", 0, 0))
        result = [self._reconstruct(parts), *face_stages(parts, face, fixes=self.riemann.eigenvectors)]
        terms: tuple[str, ...] = ()
        if parts.model.phases:
            terms = ("carried",)
            result += [Stage(mass_fluxes, here("left_going"), terms),
                       Stage(hold_within, (Read("q", -1, 0), *here("left_going", *terms)), terms, guard=may_overdraw)]
        return (*result, Stage(to_left, here(BOTH[0], *terms), ("to_left",), light=True),
                Stage(to_right, here(BOTH[1], *terms), ("to_right",), light=True),
                Stage(net_change, (*here("to_right"), Read("to_left", 1, 1), *here("inside", "aux")), ("net",)))

    def source_stages(self, parts: Parts) -> tuple[Stage, ...]:
        """Return the stages of the implicit sources: ``net`` is their mean rate over a cell, with its sign turned."""
        if not (self.integrator.implicit and parts.sources):
            return ()
        return (Stage(mean_source, self._reconstruct(parts).reads, ("net",)),)

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

    def _reconstruct(self, parts: Parts) -> Stage:
        reach = self.reconstruction.reach
        return Stage(reconstruct, (Read("q", -reach, reach), Read("aux", -reach, reach)),
                     ("left", "right", "left_aux", "right_aux", "inside"))


def reconstruct(parts, ratio, *stencil):
    """Return the states and aux values at both faces of a cell, and the integral over it."""
    left, right, q, aux = polynomials(parts, *stencil)
    return (left, right, tuple([item.left for item in aux]), tuple([item.right for item in aux]),
            inside(parts.model, left, right, q, aux))


def polynomials(parts, *stencil):
    """Return the face states of a cell, and the polynomials of q and aux on it, drawn to their means at shores."""
    model, width = parts.model, len(stencil) // 2
    states, given = stencil[:width], [item[:len(model.aux)] for item in stencil[width:]]
    flows = [of_background(model, item) for item in stencil[width:]]
    q, aux, flow = states[width // 2], given[width // 2], flows[width // 2]
    bed_left, bed_right = faces(parts.reconstruction, [subtract(item, aux) for item in given])
    bed_third = third(parts.reconstruction, given)
    lifted = [subtract(item, q) for item in states]
    lifts = model.defines("lift") and flow is None
    if flow is not None:
        lifted = [subtract(item, subtract(own.mean, flow.mean)) for item, own in zip(lifted, flows, strict=True)]
    if lifts:
        lifted = [add(item, model.lift(q, subtract(bed, aux))) for item, bed in zip(lifted, given, strict=True)]
    modes = [model.to_modes(q, item) for item in lifted]
    left, right = (model.from_modes(q, amplitudes) for amplitudes in faces(parts.reconstruction, modes))
    bend = third(parts.reconstruction, lifted)
    if lifts:
        left, right, bend = (subtract(item, model.lift(q, bed)) for item, bed in
                             ((left, bed_left), (right, bed_right), (bend, bed_third)))
    if flow is not None:
        left, right = add(left, subtract(flow.left, flow.mean)), add(right, subtract(flow.right, flow.mean))
        bend = add(bend, flow.third)
    if model.phases:
        share = trust(model, states, left, right)
        if lifts:
            share = minimum(share, smoothness(model, states, given))
        left, right, bend, bed_left, bed_right, bed_third = (
            kept(share, item) for item in (left, right, bend, bed_left, bed_right, bed_third))
    left, right, bed_left, bed_right = add(q, left), add(q, right), add(aux, bed_left), add(aux, bed_right)
    return (left, right, tuple(map(polynomial, q, left, right, bend)),
            tuple(map(polynomial, aux, bed_left, bed_right, bed_third)))


class Background(NamedTuple):
    """A background on a cell: its average, face values, third mode and residual."""

    mean: Any
    left: Any
    right: Any
    third: Any
    residual: Any


def of_background(model, aux):
    """Return the background behind the aux values of a cell, None where there is none."""
    rows, own = len(model.conserved), len(model.aux)
    behind = aux[own:]
    return Background(*(behind[k:k + rows] for k in range(0, 5 * rows, rows))) if behind else None


def faces(reconstruction, stencil):
    """Return the left and right values of each component of a stencil of tuples."""
    pad = (None,) * (2 - reconstruction.reach)
    cells = [(*pad, *values, *pad) for values in zip(*stencil, strict=True)]
    return (tuple([reconstruction.right(*values[::-1]) for values in cells]),
            tuple([reconstruction.right(*values) for values in cells]))


def third(reconstruction, stencil):
    """Return the third mode of each component: the third difference of its averages over 6."""
    if not reconstruction.cubic:
        return tuple([0.0 for _ in stencil[0]])
    return tuple([((e - a) - 2.0 * (d - b)) * (1.0 / 12.0) for a, b, _, d, e in zip(*stencil, strict=True)])


def trust(model, states, left, right):
    """Return the share of the deviation from the mean that a cell may keep: 1 but at shores, where masses differ much."""
    q = states[len(states) // 2]
    rows, share = model.mass_rows(), 1.0
    whole = [sum(state[row] for row in rows) for state in states]
    floor = RARE * largest(whole)
    for row in rows:
        masses = [state[row] for state in states]
        evenness = (smallest(masses) + floor) / (largest(masses) + floor + TINY)
        share = minimum(share, 2.0 * CONTRAST * evenness - 1.0)
        drop, spare = -minimum(left[row], right[row]), (1.0 - LEAST) * q[row]
        share = minimum(share, where(drop > spare, spare / (maximum(drop, 0.0) + TINY), 1.0))
    low, high = model.wave_speeds(q)
    for masses, momentum in model.phases:
        share = minimum(share, calm(states, (left, right), masses[-1], momentum, HASTE * (high - low)))
    return maximum(share, 0.0)


def calm(states, sides, row, momentum, sound):
    """Return the share that keeps the velocities at both faces as close to that of the cell as those next to it are.

    A share s makes v + s (dm - v dh)/(h + s dh) of the velocity, so s (|dm - v dh| - V dh) <= V h bounds its change by V, here
    the largest difference to a neighbour and a little of the speed of sound. Where the depth of a thin cell falls to a
    tenth at a face but its momentum does not, the velocity would grow tenfold, stage after stage. Derived here.
    """
    centre = len(states) // 2
    before, here, after = ((state[row], state[momentum] / (state[row] + TINY)) for state in states[centre - 1:centre + 2])
    h, v = here
    bound = maximum(np.abs(before[1] - v), np.abs(after[1] - v)) + sound
    share: Any = 1.0
    for side in sides:
        excess, room = np.abs(side[momentum] - v * side[row]) - bound * side[row], bound * h
        share = minimum(share, where(excess > room, room / (maximum(excess, 0.0) + TINY), 1.0))
    return share


def smoothness(model, states, given):
    """Return the share that the bottom allows: none where its third differences exceed the smallest depth of the stencil.

    Rest survives without it, but a model whose density is frozen in the lift (`Reduced`) lets rounding grow there.
    """
    q = states[len(states) // 2]
    rough = 0.0
    for a, b, c, d in zip(given, given[1:], given[2:], given[3:], strict=False):
        bend = tuple([(last - first) - 3.0 * (right - left) for first, left, right, last in zip(a, b, c, d, strict=True)])
        rough = maximum(rough, np.abs(sum(model.lift(q, bend)[row] for row in model.mass_rows())))
    depth = smallest([sum(state[row] for row in model.mass_rows()) for state in states])
    return maximum(2.0 - 2.0 * rough / (depth + TINY), 0.0)


def kept(share, deviation):
    """Return a share of a deviation; 0 for none of it, whatever it is: modes mean nothing where a cell is dry."""
    return tuple([where(share > 0.0, share * item, 0.0) for item in deviation])


def smallest(values):
    """Return the smallest of several values."""
    result = values[0]
    for value in values[1:]:
        result = minimum(result, value)
    return result


def largest(values):
    """Return the largest of several values."""
    result = values[0]
    for value in values[1:]:
        result = maximum(result, value)
    return result


def inside(model, left, right, q, aux):
    """Return the integral over a cell; nothing in the rows of masses, whose fluxes stand at the faces."""
    if model.defines("cell_integral"):
        result = model.cell_integral(left, right, q, aux)
    elif model.defines("jump"):
        result = romberg(model, left, right, q, aux)
    else:
        result = subtract(model.flux(right), model.flux(left))
    return tuple([0.0 if row in model.mass_rows() else item for row, item in enumerate(result)])


def romberg(model, left, right, q, aux):
    """Return the sum of jumps along the polynomial, extrapolated from 1, 2 and 4 pieces of the cell: seventh order."""
    def at(xi):
        return tuple([item.at(xi) for item in q]), tuple([item.at(xi) for item in aux])

    points = [(left, tuple([item.left for item in aux])), at(-0.25), at(0.0), at(0.25),
              (right, tuple([item.right for item in aux]))]

    def pieces(step):
        total = None
        for first, last in zip(points[:-1:step], points[step::step], strict=True):
            jump = model.jump(first[0], last[0], first[1], last[1])
            total = jump if total is None else add(total, jump)
        return total

    return tuple([(one - 20.0 * two + 64.0 * four) * (1.0 / 45.0)
                  for one, two, four in zip(pieces(4), pieces(2), pieces(1), strict=True)])


#: Gauss and Legendre's nodes in [-1/2, 1/2] and weights at which implicit sources act.
NODES = tuple((0.5 * float(x), 0.5 * float(w)) for x, w in zip(*np.polynomial.legendre.leggauss(3), strict=True))


def mean_source(parts, ratio, *stencil):
    """Return minus the mean over a cell of S(y), y = q + a S(y), at Gauss nodes; ``ratio`` is a."""
    _, _, q, aux = polynomials(parts, *stencil)
    result: Any = None
    for node, weight in NODES:
        state, given = tuple([item.at(node) for item in q]), tuple([item.at(node) for item in aux])
        rate = scale(-weight, parts.sources[0].implicit_rate(parts.model, state, given, ratio))
        result = rate if result is None else add(result, rate)
    return (result,)


def net_change(parts, ratio, from_left, from_right, inner, aux):
    """Sum what enters a cell through both of its faces and what happens inside, less what that makes of the background."""
    whole, flow = add(add(from_left, from_right), inner), of_background(parts.model, aux)
    return (whole if flow is None else subtract(whole, flow.residual),)
