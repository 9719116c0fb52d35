"""Passengers of a sweep: the momenta across, which the mass flux of their own phase carries.

With u the velocity across, F the mass flux of a face as it stands at last, after window, fallback and walls,

    R = F (u_up + s),   s = +/- 1/2 (1 - nu) phi(theta) (u_R - u_L),   nu = dt/dx |F| / m_up,   s = 0 at first order.

Seen in the mass coordinate the cell holds a line in u; what leaves takes its share of it, and what stays is a mean of the rest.
So no velocity leaves the range of its neighbours, for any data and Courant numbers up to 1, and momentum is conserved. Derived
here.
"""

import numpy as np

from fvkit.pointwise import TINY, combine, where
from fvkit.problem.answers import mass_flux
from fvkit.schemes.scheme import MASS_FLUX, MOVED, NET, Parts, Read, Stage, here


def passenger_stages(parts: Parts, order: int) -> list[Stage]:
    """Return the stages behind those of a step along lines: what carries the momenta across, and the whole new state."""
    result = []
    if parts.across:
        reads = {"q": Read("q", -1, 0), "u": Read("velocity across", -2, 1), "flux": Read(MASS_FLUX)} if order == 2 else \
            {"q": Read("q", -1, 0), "u": Read("velocity across", -1, 0), "flux": Read(MASS_FLUX)}
        result += [Stage(velocity_across, here("q", "across"), ("velocity across",), light=True),
                   Stage(ride, reads, ("ridden",))]
    return result


def moved_stage(parts: Parts, made: str) -> Stage:
    """Return the last stage: the state after a sweep, of which ``made`` is the net fluctuation or what sources left of it."""
    ridden = {"across": Read("across"), "ridden": Read("ridden", 0, 1)} if parts.across else {}
    return Stage(moved, {"q": Read("q"), "made": Read(made), **ridden}, (MOVED,)) if made == NET else \
        Stage(driven_on, {"made": Read(made), **ridden}, (MOVED,))


def velocity_across(parts, ratio, q, across):
    """Return the velocity across of each phase, as faces see it."""
    return {"velocity across": velocities(parts.model, q, across)}


def velocities(model, q, momenta):
    """Return the velocity of each phase with given momenta, damped where it is thin."""
    state = list(q)
    for phase, momentum in zip(model.phases, momenta, strict=True):
        state[phase.momentum] = momentum
    flux = mass_flux(model, tuple(state))
    return tuple([flux[phase.masses[-1]] / (q[phase.masses[-1]] + TINY) for phase in model.phases])


def ride(parts, ratio, q, u, flux):
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
    return {"ridden": tuple(result)}


def moved(parts, ratio, q, made, across=(), ridden=((), ())):
    """Return the state of a cell after a sweep, and its momenta across."""
    return {MOVED: (*combine(1.0, q, -ratio, made), *carried(ratio, across, ridden))}


def driven_on(parts, ratio, made, across=(), ridden=((), ())):
    """Return the state that sources and sweep have made of a cell, and its momenta across."""
    return {MOVED: (*made, *carried(ratio, across, ridden))}


def carried(ratio, across, ridden):
    """Return the momenta across after a sweep."""
    return tuple([w - ratio * (right - left) for w, left, right in zip(across, *ridden, strict=True)])
