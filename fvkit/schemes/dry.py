"""Masses that stay non-negative: a window for what a face may carry, and a fallback at faces next to dry ground.

A face may take from a cell at most what keeps its half of the mass: with F the mass flux, f the physical one,

    -(qr dx/dt - fr)/2  <=  F  <=  (ql dx/dt + fl)/2.

Then no mass turns negative at Courant numbers up to 1, one face at a time. A correction is reduced to the share that
stays inside, for all rows of its phase: fluxes stay fluxes, so masses and mixture momentum stay conserved. Derived here.

The rows of ``left_going`` that belong to masses hold F itself; see `fvkit.schemes.fluctuations`.
"""

from functools import reduce
from typing import Any

import numpy as np

from fvkit.answers import mass_flux, wave_speeds
from fvkit.pointwise import TINY, add, combine, largest_share, maximum, minimum, multiply, subtract, where
from fvkit.schemes.driven import for_cells, jumps
from fvkit.schemes.fluctuations import anchored, left_going, right_going

#: Half of a cell's mass, less what rounding may add to it.
HALF = 0.5 * (1.0 - 1e-14)

#: Correction fluxes fade where the masses of neighbours differ by more than this factor.
SHORE = 4.0

#: The fallback is complete where they differ by more than this factor, or where the difference that is equilibrium, such
#: as a step of the bottom, exceeds the smaller by it; it begins at half of it.
DRIER = 10.0

#: It is complete where a phase is less than this share of the whole, and begins at twice that.
RARE = 1e-4

#: Between reconstructed states it is complete too where a phase parts faster than the speed of sound of both sides, and
#: begins at half of that. A Riemann solver with one mean speed per wave lets inner waves push such a flow apart; the cells
#: of a resolved fan are never that far from each other. Cell means of first and second order do well without.
PARTING = 1.0


def window(parts, ratio, ql, qr, row):
    """Return the bounds of dt/dx times the flux of a mass through a face."""
    fluxl, fluxr = mass_flux(parts.model, ql)[row], mass_flux(parts.model, qr)[row]
    return HALF * (ratio * fluxr - qr[row]), HALF * (ql[row] + ratio * fluxl)


def carriers(model):
    """Rows of the masses that carry the momentum of each phase."""
    return [masses[-1] for masses, _ in model.phases]


def apart(parts, ql, qr, factor):
    """Whether the masses of neighbours differ by more than a factor."""
    found = False
    for row in carriers(parts.model):
        found = found | (factor * minimum(ql[row], qr[row]) < maximum(ql[row], qr[row]))
    return found


def evenness(left, right, factor):
    """Return factor times the smaller over the larger of two masses; 0 where both are."""
    return factor * minimum(left, right) / (maximum(left, right) + TINY)


def contrasts(parts, ql, qr, auxl, auxr):
    """Return, for the mass that carries each phase, the smaller of both sides, and the larger or the equilibrium difference."""
    moving = parts.model.balanced_difference(ql, qr, auxl, auxr)
    return [(minimum(ql[row], qr[row]), maximum(maximum(ql[row], qr[row]), np.abs((qr[row] - ql[row]) - moving[row])))
            for row in carriers(parts.model)]


def inside(parts, ratio, ql, qr, fluxes):
    """Whether no mass is overdrawn by fluxes, given by row; False for NaN."""
    found = True
    for row in parts.model.mass_rows():
        low, high = window(parts, ratio, ql, qr, row)
        found = found & (ratio * fluxes[row] >= low) & (ratio * fluxes[row] <= high)
    return found


# ---------------------------------------------------------------------- the window

def mass_fluxes(parts, ratio, left, correction=None):
    """Return the flux of each mass through a face, and the correction without the rows that have gone into it."""
    rows = parts.model.mass_rows()
    if correction is None:
        return (tuple([left[row] for row in rows]),)
    rest = tuple([0.0 if k in rows else item for k, item in enumerate(correction)])
    return tuple([left[row] + correction[row] for row in rows]), rest


def may_overdraw(parts, ratio, ql, qr, left, carried, correction=None, cross=None):
    """Whether a mass flux leaves the window, or neighbours differ enough to fade the correction of the face."""
    found = ~inside(parts, ratio, ql, qr, dict(zip(parts.model.mass_rows(), carried, strict=True)))
    return found if correction is None else found | apart(parts, ql, qr, SHORE)


def hold_within(parts, ratio, ql, qr, left, carried, correction=None, cross=None):
    """Keep the mass fluxes within the window, to the last bit, and the corrections to the share that this allows.

    At shores the corrections fade.
    """
    terms = [list(term) for term in (correction, cross) if term is not None]
    held = []
    total = dict(zip(parts.model.mass_rows(), carried, strict=True))
    for masses, momentum in parts.model.phases:
        factor, bounds = 1.0, [window(parts, ratio, ql, qr, row) for row in masses]
        if correction is not None:
            for row, (low, high) in zip(masses, bounds, strict=True):
                first = ratio * left[row]
                factor = minimum(factor, largest_share(ratio * total[row] - first, first - low, high - first))
            fading = minimum(1.0, evenness(ql[masses[-1]], qr[masses[-1]], SHORE))
            factor = factor * fading
            terms[0][momentum] = factor * correction[momentum]
            for term in terms[1:]:
                term[momentum] = fading * term[momentum]
        for row, (low, high) in zip(masses, bounds, strict=True):
            reduced = left[row] if correction is None else left[row] + factor * (total[row] - left[row])
            flux = total[row] if correction is None else where(factor < 1.0, reduced, total[row])
            held.append(where(ratio * flux > high, high / ratio, where(ratio * flux < low, low / ratio, flux)))
    return (tuple(held), *(tuple(term) for term in terms))


# ---------------------------------------------------------------------- the fallback

def distrusted(parts, ratio, ql, qr, auxl, auxr, left, *others):
    """Whether a face needs the relaxation solver: neighbours differ much, a phase is rare, or a mass is overdrawn."""
    return ~inside(parts, ratio, ql, qr, left) | uneven(parts, ql, qr, auxl, auxr)


def uneven(parts, ql, qr, auxl, auxr):
    """Whether neighbours differ much, or a phase is rare."""
    found: Any = False
    for smaller, larger in contrasts(parts, ql, qr, auxl, auxr):
        found = found | (0.5 * DRIER * smaller < larger)
    rows = carriers(parts.model)
    if len(rows) > 1:
        total = sum(ql[row] + qr[row] for row in rows)
        for row in rows:
            found = found | (ql[row] + qr[row] < 2.0 * RARE * total)
    if parts.reconstruction is not None:
        for speed, sound in partings(parts.model, ql, qr, auxl, auxr):
            found = found | (2.0 * speed > PARTING * sound)
    return found


def partings(model, ql, qr, auxl, auxr):
    """Return, for each phase, how fast both sides part, and the smaller speed of sound: half the range of speeds less slip."""
    left, right = velocities(model, ql), velocities(model, qr)
    sounds = []
    for q, aux, found in ((ql, auxl, left), (qr, auxr, right)):
        low, high = wave_speeds(model, q, aux)
        slip = 0.0
        for v in found[1:]:
            slip = maximum(slip, np.abs(v - found[0]))
        sounds.append(0.5 * maximum((high - low) - slip, 0.0))
    return [(after - before, minimum(*sounds)) for before, after in zip(left, right, strict=True)]


def velocities(model, q):
    """Return the velocity of each phase, that of a face, damped where the phase is thin."""
    flux = mass_flux(model, q)
    return [flux[row] / (q[row] + TINY) for row in carriers(model)]


def trust(parts, ratio, ql, qr, auxl, auxr, left, relaxed):
    """Return, for each phase, the share of the scheme's own solver at a face, 0 next to dry ground.

    ``relaxed`` is the part of the other solver. A phase that is rare loses its own rows alone: the rest of the flow goes on.
    """
    model, rows = parts.model, carriers(parts.model)
    total = sum(ql[row] + qr[row] for row in rows)
    parted = partings(model, ql, qr, auxl, auxr) if parts.reconstruction is not None else ()
    owns, rare, common = [], [], 1.0
    for k, ((masses, _), (smaller, larger)) in enumerate(zip(model.phases, contrasts(parts, ql, qr, auxl, auxr), strict=True)):
        own = DRIER * smaller / (larger + TINY) - 1.0
        for speed, sound in parted[k:k + 1]:
            own = minimum(own, where(2.0 * speed > PARTING * sound, 2.0 - 2.0 * speed / (PARTING * sound + TINY), 1.0))
        for row in masses:
            low, high = window(parts, ratio, ql, qr, row)
            carried, change = ratio * relaxed[row], ratio * (left[row] - relaxed[row])
            own = minimum(own, where(change == change, largest_share(change, carried - low, high - carried), 0.0))
        present = (ql[rows[k]] + qr[rows[k]]) / (RARE * total + TINY) - 1.0 if len(rows) > 1 else 1.0
        owns.append(minimum(own, present))
        rare.append(1.0 - minimum(1.0, maximum(present, 0.0)))
        common = minimum(common, maximum(own, rare[k]))
    return [maximum(minimum(own, common), 0.0) for own in owns]


def fall_back(parts, ratio, ql, qr, auxl, auxr, left, right, fastest, speeds=None, waves=None):
    """Blend a face's fluctuations, and at second order its waves and speeds, towards those of the relaxation solver.

    The waves fade instead: next to dry ground the scheme is first order. A face, and a phase, that trusts its own solver keeps
    every bit.
    """
    whole, net, _ = jumps(parts, ratio, ql, qr, auxl, auxr)
    jump = for_cells(parts.model, ql, qr, whole, net)
    pieces, their_speeds = parts.model.relaxation(ql, qr, auxl, auxr, net)
    relaxed = left_going(pieces, their_speeds)
    relaxed = anchored(parts, ql, relaxed if net is whole else combine(1.0, relaxed, 0.5, subtract(jump, net)))
    shares = trust(parts, ratio, ql, qr, auxl, auxr, left, relaxed)
    some, own, share = reduce(maximum, shares) > 0.0, reduce(minimum, shares) >= 1.0, [1.0] * len(left)
    for found, (masses, momentum) in zip(shares, parts.model.phases, strict=True):
        for row in (*masses, momentum):
            share[row] = found

    def kept(values):
        return tuple([where(some, value, 0.0) for value in values])

    def trusted(mine, both, theirs):
        return tuple([where(part >= 1.0, item, where(part > 0.0, mixed, other))
                      for part, item, mixed, other in zip(share, mine, both, theirs, strict=True)])

    safe, other = kept(left), kept(relaxed)
    left = trusted(left, add(other, multiply(share, subtract(safe, other))), relaxed)
    top = where(some, fastest, 0.0)
    for speed in their_speeds:
        top = maximum(top, np.abs(speed))
    rest = right_going(parts, jump, left)
    right = trusted(right, rest, rest)
    result = (left, right, where(own, fastest, top))
    return result if waves is None else (*result, kept(speeds), tuple(multiply(share, kept(wave)) for wave in waves))
