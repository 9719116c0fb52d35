"""Fallback of a Riemann solver at faces beside dry ground and rare phases: its fluctuations are blended with those of a solver
that keeps masses non-negative."""

from functools import reduce
from typing import Any

import numpy as np

from fvkit.pointwise import TINY, add, combine, largest_share, maximum, minimum, multiply, subtract, where
from fvkit.problem.answers import mass_flux, wave_speeds
from fvkit.schemes.scheme import SPEED
from fvkit.schemes.stages.driven import Net, for_cells, jumps
from fvkit.schemes.stages.fluctuations import anchored, rest_of, travelling_left
from fvkit.schemes.stages.positivity import carriers, window, within_window

#: Depth ratio of neighbours, or of an equilibrium difference such as a step of the bottom to the smaller depth: the weight of
#: the fallback is 0 below half of it and 1 above it.
DRIER = 10.0

#: Share of a phase in the whole: the weight is 1 below it and 0 above twice that.
RARE = 1e-4

#: Between reconstructed states it is complete too where a phase parts faster than the speed of sound of both sides, and
#: begins at half of that. A Riemann solver with one mean speed per wave lets inner waves push such a flow apart; the cells
#: of a resolved fan are never that far from each other. Cell means on a line do well without: what parts there has left soon.
#: On a plane the other sweep may bring more, as beside a jet that comes in through a wall, and what parts grows ever faster.
SEPARATING = 1.0


def contrasts(parts, ql, qr, auxl, auxr):
    """Return, for the mass that carries each phase, the smaller of both sides, and the larger or the equilibrium difference."""
    moving = parts.model.balanced_difference(ql, qr, auxl, auxr)
    return [(minimum(ql[row], qr[row]), maximum(maximum(ql[row], qr[row]), np.abs((qr[row] - ql[row]) - moving[row])))
            for row in carriers(parts.model)]


def needs_fallback(parts, ratio, ql, qr, auxl, auxr, left_going, **others):
    """Whether a face needs the relaxation solver: neighbours differ much, a phase is rare, or a mass is overdrawn."""
    return ~within_window(parts, ratio, ql, qr, left_going) | nearly_dry(parts, ql, qr, auxl, auxr)


def nearly_dry(parts, ql, qr, auxl, auxr):
    """Whether neighbours differ much, or a phase is rare."""
    found: Any = False
    for smaller, larger in contrasts(parts, ql, qr, auxl, auxr):
        found = found | (0.5 * DRIER * smaller < larger)
    rows = carriers(parts.model)
    if len(rows) > 1:
        total = sum(ql[row] + qr[row] for row in rows)
        for row in rows:
            found = found | (ql[row] + qr[row] < 2.0 * RARE * total)
    if sees_separation(parts):
        for speed, sound in separations(parts.model, ql, qr, auxl, auxr):
            found = found | (2.0 * speed > SEPARATING * sound)
    return found


def sees_separation(parts):
    """Whether a phase that parts too fast needs the fallback, see `SEPARATING`."""
    return parts.reconstruction is not None or parts.across > 0


def separations(model, ql, qr, auxl, auxr):
    """Return, for each phase, how fast both sides part, and the smaller speed of sound: half the range of speeds less slip."""
    left, right = velocities(model, ql), velocities(model, qr)
    sounds = []
    for q, aux, found in ((ql, auxl, left), (qr, auxr, right)):
        low, high = wave_speeds(model, q, aux)
        slip = reduce(maximum, [np.abs(v - found[0]) for v in found[1:]], 0.0)
        sounds.append(0.5 * maximum((high - low) - slip, 0.0))
    return [(after - before, minimum(*sounds)) for before, after in zip(left, right, strict=True)]


def velocities(model, q):
    """Return the velocity of each phase, that of a face, damped where the phase is thin."""
    flux = mass_flux(model, q)
    return [flux[row] / (q[row] + TINY) for row in carriers(model)]


def own_shares(parts, ratio, ql, qr, auxl, auxr, left, relaxed):
    """Return, for each phase, the share of the scheme's own solver at a face, 0 next to dry ground.

    ``relaxed`` is the part of the other solver. A phase that is rare loses its own rows alone: the rest of the flow goes on.
    """
    model, rows = parts.model, carriers(parts.model)
    total = sum(ql[row] + qr[row] for row in rows)
    parted = separations(model, ql, qr, auxl, auxr) if sees_separation(parts) else ()
    owns, rare, common = [], [], 1.0
    for k, ((masses, _), (smaller, larger)) in enumerate(zip(model.phases, contrasts(parts, ql, qr, auxl, auxr), strict=True)):
        own = DRIER * smaller / (larger + TINY) - 1.0
        for speed, sound in parted[k:k + 1]:
            own = minimum(own, where(2.0 * speed > SEPARATING * sound, 2.0 - 2.0 * speed / (SEPARATING * sound + TINY), 1.0))
        for row in masses:
            low, high = window(parts, ratio, ql, qr, row)
            carried, change = ratio * relaxed[row], ratio * (left[row] - relaxed[row])
            own = minimum(own, where(change == change, largest_share(change, carried - low, high - carried), 0.0))
        present = (ql[rows[k]] + qr[rows[k]]) / (RARE * total + TINY) - 1.0 if len(rows) > 1 else 1.0
        owns.append(minimum(own, present))
        rare.append(1.0 - minimum(1.0, maximum(present, 0.0)))
        common = minimum(common, maximum(own, rare[k]))
    return [maximum(minimum(own, common), 0.0) for own in owns]


def blend_with_relaxation(parts, ratio, ql, qr, auxl, auxr, left_going, right_going, fastest, speeds=None, waves=None):
    """Blend a face's fluctuations, and at second order its waves and speeds, towards those of the relaxation solver.

    The waves fade instead: next to dry ground the scheme is first order. A face, and a phase, that trusts its own solver keeps
    every bit.
    """
    whole, net, _ = jumps(parts, ratio, ql, qr, auxl, auxr)
    jump = for_cells(parts.model, ql, qr, whole, net)
    pieces, their_speeds = parts.model.relaxation(ql, qr, auxl, auxr, Net(net, whole))
    relaxed = travelling_left(pieces, their_speeds)
    relaxed = anchored(parts, ql, relaxed if net is whole else combine(1.0, relaxed, 0.5, subtract(jump, net)))
    shares = own_shares(parts, ratio, ql, qr, auxl, auxr, left_going, relaxed)
    some, own, share = reduce(maximum, shares) > 0.0, reduce(minimum, shares) >= 1.0, [1.0] * len(left_going)
    for found, (masses, momentum) in zip(shares, parts.model.phases, strict=True):
        for row in (*masses, momentum):
            share[row] = found

    def kept(values):
        return tuple([where(some, value, 0.0) for value in values])

    def trusted(mine, both, theirs):
        return tuple([where(part >= 1.0, item, where(part > 0.0, mixed, other))
                      for part, item, mixed, other in zip(share, mine, both, theirs, strict=True)])

    safe, other = kept(left_going), kept(relaxed)
    left = trusted(left_going, add(other, multiply(share, subtract(safe, other))), relaxed)
    top = reduce(maximum, map(np.abs, their_speeds), where(some, fastest, 0.0))
    rest = rest_of(parts, jump, left)
    right = trusted(right_going, rest, rest)
    result = {"left_going": left, "right_going": right, SPEED: where(own, fastest, top)}
    if waves is None:
        return result
    return {**result, "speeds": kept(speeds), "waves": tuple(multiply(share, kept(wave)) for wave in waves)}
