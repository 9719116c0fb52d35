"""Passengers of a sweep: the momenta across, which the mass flux of their own phase carries.

With u the velocity across, F the final mass flux of a face, after bounds, fallback and walls,

    R = F (u_up + s),   s = +/- 1/2 (1 - nu) phi(theta) (u_R - u_L),   nu = dt/dx |F| / m_up,   s = 0 at first order.

Seen in the mass coordinate the cell holds a line in u; what leaves takes its share of it, and what stays is a mean of the rest.
So no velocity leaves the range of its neighbours, for any data and Courant numbers up to 1, and momentum is conserved. Derived
here.

Behind strong jumps along a grid line the momenta across grow from rounding (the carbuncle). A viscosity E on
passengers alone, where the other axis has such a jump, removes it:

    R -= E (u_R - u_L),   E = min(eta min(m_L, m_R)/2, half of what the window leaves beside F),

with eta what the characteristic speeds of the other axis fall by at a face, beyond 0.3 of the sound speed, the larger of both
cells. It is known in the second sweep of a step, from the first one.
"""

import numpy as np

from fvkit.pointwise import TINY, combine, maximum, minimum, where
from fvkit.problem.answers import wave_speeds
from fvkit.problem.turned import with_momenta
from fvkit.schemes.scheme import MASS_FLUX, MOVED, NET, Parts, Read, Stage, here
from fvkit.schemes.stages.dry_fallback import velocities
from fvkit.schemes.stages.positivity import window

#: Fall of a characteristic speed at a face that counts as smooth, as a share of the sound speed.
SMOOTH = 0.3


def passenger_stages(parts: Parts, order: int) -> list[Stage]:
    """Return the stages behind those of a step along lines: what carries the momenta across, and the whole new state."""
    result = []
    if parts.across:
        result.append(Stage(compression, {"ql": Read("q", -1), "qr": Read("q"), "auxl": Read("aux", -1), "auxr": Read("aux")},
                            ("compression",)))
        reads = {"q": Read("q", -1, 0), "u": Read("velocity across", -2, 1), "flux": Read(MASS_FLUX)} if order == 2 else \
            {"q": Read("q", -1, 0), "u": Read("velocity across", -1, 0), "flux": Read(MASS_FLUX)}
        viscous = {**reads, "aux": Read("aux", -1, 0), "through": Read("flux across")}
        result += [Stage(velocity_across, here("q", "across"), ("velocity across",), light=True),
                   Stage(flux_across, reads, ("flux across",)),
                   Stage(viscosity_across, viscous, ("flux across",), guard=beside_a_jump)]
    return result


def moved_stage(parts: Parts, made: str) -> Stage:
    """Return the last stage: the state after a sweep, of which ``made`` is the net fluctuation or what sources left of it."""
    reads = {**({"q": Read("q")} if made == NET else {}), "made": Read(made)}
    if parts.across:
        reads |= {"across": Read("across"), "through": Read("flux across", 0, 1), "squeezed": Read("compression", 0, 1)}
    return Stage(moved, reads, (MOVED,))


def velocity_across(parts, ratio, q, across):
    """Return the velocity across of each phase, as faces see it."""
    return {"velocity across": tuple(velocities(parts.model, with_momenta(parts.model, q, across)))}


def flux_across(parts, ratio, q, u, flux):
    """Return the flux of each momentum across."""
    fluxes = dict(zip(parts.model.mass_rows(), flux, strict=True))
    result = []
    for k, phase in enumerate(parts.model.phases):
        row, carried = phase.masses[-1], fluxes[phase.masses[-1]]
        onwards, at = carried > 0.0, [one[k] for one in u]
        if len(at) == 2:
            result.append(carried * where(onwards, *at))
            continue
        before, left, right, after = at
        change = right - left
        theta = where(onwards, left - before, after - right) * change / (change * change + TINY)
        nu = ratio * np.abs(carried) / (where(onwards, q[0][row], q[1][row]) + TINY)
        slope = 0.5 * (1.0 - nu) * parts.limiters[0].phi(theta, nu) * change
        result.append(carried * where(onwards, left + slope, right - slope))
    return {"flux across": tuple(result)}


def moved(parts, ratio, made, q=None, across=(), through=((), ()), squeezed=()):
    """Return the state of a cell after a sweep, its momenta across, and the larger compression at its faces."""
    state = made if q is None else combine(1.0, q, -ratio, made)
    carried = [w - ratio * (right - left) for w, left, right in zip(across, *through, strict=True)]
    return {MOVED: (*state, *carried, *([maximum(*squeezed)] if squeezed else []))}


def compression(parts, ratio, ql, qr, auxl, auxr):
    """Return by how much the characteristic speeds fall at a face, beyond a share of the sound speed: not in smooth flow."""
    lowl, highl = wave_speeds(parts.model, ql, auxl)
    lowr, highr = wave_speeds(parts.model, qr, auxr)
    sound = 0.25 * ((highl - lowl) + (highr - lowr))
    return {"compression": maximum(maximum(lowl - lowr, highl - highr) - SMOOTH * sound, 0.0)}


def beside_a_jump(parts, ratio, aux, **others):
    """Whether a cell of a face lies at a jump of the other axis."""
    return maximum(aux[0][-1], aux[1][-1]) > 0.0


def viscosity_across(parts, ratio, q, u, flux, aux, through):
    """Add the viscosity of passengers at jumps of the other axis."""
    (ql, qr), eta = q, maximum(aux[0][-1], aux[1][-1])
    fluxes, result = dict(zip(parts.model.mass_rows(), flux, strict=True)), []
    left, right = u[len(u) // 2 - 1:len(u) // 2 + 1]
    for k, phase in enumerate(parts.model.phases):
        row = phase.masses[-1]
        low, high = window(parts, ratio, ql, qr, row)
        room = 0.5 * minimum(high - ratio * fluxes[row], ratio * fluxes[row] - low)
        extra = minimum(0.5 * ratio * eta * minimum(ql[row], qr[row]), maximum(room, 0.0)) / ratio
        result.append(through[k] - extra * (right[k] - left[k]))
    return {"flux across": tuple(result)}
