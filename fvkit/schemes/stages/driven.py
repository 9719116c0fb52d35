"""What sources leave of the jump of a face: its waves feel the push less what friction and drag take of it.

The cells get the whole push, and pay for the sources themselves, on the masses that the push of their faces acts on: else
neighbours of different depth would get more, or less, than they pay, and a flow that friction alone balances would grow waves.
So a flow in balance has no waves, and what is held at rest feels nothing. Derived here.
"""

from functools import partial, reduce
from operator import truediv
from typing import Any

import attrs
import numpy as np

from fvkit.pointwise import TINY, combine, maximum, minimum, rarely, subtract, where
from fvkit.pointwise.part import Wrapper
from fvkit.problem.answers import mass_flux, wave_speeds
from fvkit.problem.sources import acted
from fvkit.schemes.scheme import NEW, PULLS, Read, Stage

#: Waves feel a source that acts on what moves less where the masses of neighbours differ by more than this factor: a front is
#: no balance, and there the cells alone pay.
EVEN = 4.0

#: Least mass that takes a push, relative to the larger one beside the face: at an emerged step whose upper side is dry the push
#: is rounding, and so is the mass.
BORNE = 1e-8

#: Least mass that takes the push of a cell, relative to its own: a film that leaves deep flow would else feel no source.
PAYING = 0.25

#: Added to the factors of a denominator: far below any depth or speed, and their products stay numbers.
SMALL = 1e-100

#: dt/dx at which the limit dt -> 0 is taken, s/m.
SHORT = 1e-9


class Net(tuple):
    """Jump of a face reduced by sources, with the ``whole`` jump: a relaxation solver uses both."""

    whole: Any

    def __new__(cls, net, whole):
        result = super().__new__(cls, net)
        result.whole = whole
        return result


def jumps(parts, ratio, ql, qr, auxl, auxr):
    """Return the jump of a face, what sources leave of it for its waves (the same object where there are none), and the mass of
    each phase that the push acts on."""
    whole = parts.model.jump(ql, qr, auxl, auxr)
    joint = parts.joint
    limit = type(ratio) is float and ratio == 0.0
    if limit:
        joint, ratio = tuple([source for source in joint if source.static]), SHORT
    if not parts.joint:
        return whole, whole, ()
    model, phases = parts.model, parts.model.phases
    before, speeds = on_face(model, ql, qr, auxl, auxr)
    bearing = tuple([before[masses[-1]] for masses, _ in phases])
    if not joint:
        return whole, whole, bearing
    after, result = list(before), list(whole)
    around = surroundings(parts, auxl, auxr)
    for (masses, momentum), v in zip(phases, speeds, strict=True):
        after[momentum] = before[momentum] - ratio * (whole[momentum] - v * whole[masses[-1]])
    aux = tuple([0.5 * (left + right) for left, right in zip(auxl, auxr, strict=True)])
    start, free = with_across(model, before, tuple(after), bearing, around, ratio * parts.dx)
    end = acted(joint, model, start, free, bearing, aux, ratio * parts.dx)
    stops = not all(source.between_phases for source in joint)
    # The sound of the face: half the range of speeds at rest, since slip widens it, and that of a film without speeds is none.
    momenta = {phase.momentum for phase in phases}
    low, high = wave_speeds(model, tuple([0.0 * item if k in momenta else item for k, item in enumerate(before)]), aux)
    carries = 0.5 * (high - low) * reduce(maximum, map(np.abs, speeds))
    for k, (masses, momentum) in enumerate(phases):
        row, still = masses[-1], before[momentum] == 0.0
        still = still & (around[k][0] == 0.0) if around else still
        push = whole[momentum] - speeds[k] * whole[row]
        # A source may stop or drive what moves, and is felt at a point: the sound of the face carries no more of it than this.
        most = maximum(carries * before[row], np.abs(push))
        left = minimum(maximum(push + (after[momentum] - end[momentum]) * (1.0 / ratio), -most), most)
        smaller, larger = EVEN * minimum(ql[row], qr[row]), maximum(ql[row], qr[row])
        # A flow that a source stops must feel its push first: a slope would else come to rest below its angle.
        left_over, initial = (2.0 * np.abs(end[momentum]), np.abs(before[momentum]) + SMALL) if stops else (1.0, 1.0)
        share = minimum(smaller, larger) * minimum(left_over, initial) / (larger * initial + TINY)
        kept = whole[momentum] + where(still, 1.0, 0.0 if limit else share) * (left - push)
        result[momentum] = where(still & (end[momentum] == 0.0), 0.0, kept)
    return whole, tuple(result), bearing


def drive(parts, ratio, q, net, aux, bearing):
    """Return the state of a cell after its transport and its sources; ``bearing`` are the masses that take the push of its
    faces."""
    after, borne = combine(1.0, q, -ratio, net), combine(0.5, bearing[0], 0.5, bearing[1])
    borne = tuple([maximum(mass, PAYING * after[masses[-1]])
                   for mass, (masses, _) in zip(borne, parts.model.phases, strict=True)])
    start, free = with_across(parts.model, q, after, borne, surroundings(parts, aux, aux), ratio * parts.dx)
    step = (parts.joint, parts.model, start, free, borne, aux, ratio * parts.dx)
    end = acted(*step)
    if parts.model.bend_rows:
        end = acted(*step, reached=end)
    return {NEW: end[:len(q)]}


def surroundings(parts, auxl, auxr):
    """Return, for each phase, its velocity across the sweep and what accelerates it there, m/s^2, between two cells; () without.

    Both are those of the start of the step: friction acts against the whole velocity, and holds against the whole push. They
    stand behind the aux values, see `pulling_stages`: velocity, push and the mass that takes it.
    """
    rows = 3 * parts.across
    if not rows:
        return ()
    left, right = auxl[len(auxl) - 1 - rows:], auxr[len(auxr) - 1 - rows:]
    return tuple([(0.5 * (left[k] + right[k]), -(left[k + 1] + right[k + 1]) / (left[k + 2] + right[k + 2] + TINY))
                  for k in range(0, rows, 3)])


def with_across(model, before, after, bearing, around, dt):
    """Return two states with the momenta across behind them: at the start, and after dt of what accelerates them."""
    if not around:
        return before, after
    rows = [phase.masses[-1] for phase in model.phases]
    start = tuple([before[row] * u for row, (u, _) in zip(rows, around, strict=True)])
    end = tuple([after[row] * u + dt * (mass * pull) for row, mass, (u, pull) in zip(rows, bearing, around, strict=True)])
    return (*before, *start), (*after, *end)


def pulling_stages(face):
    """Return the stages of the velocity of each phase of a cell along an axis, of what pushes it there, per length, and of the
    mass that takes the push.

    Sweeps along the other axis read them, see `surroundings`.
    """
    return (Stage(pushes, face, ("push", "bearing")),
            Stage(pulls, {"q": Read("q"), "push": Read("push", 0, 1), "bearing": Read("bearing", 0, 1)}, (PULLS,)))


def pushes(parts, ratio, ql, qr, auxl, auxr):
    """Return the push of a face on each phase, less the momentum of its mass flux, and the masses that take it."""
    whole = parts.model.jump(ql, qr, auxl, auxr)
    before, speeds = on_face(parts.model, ql, qr, auxl, auxr)
    phases = parts.model.phases
    return {"push": tuple([(whole[phase.momentum] - v * whole[phase.masses[-1]]) / parts.dx
                           for phase, v in zip(phases, speeds, strict=True)]),
            "bearing": tuple([maximum(before[phase.masses[-1]], BORNE * maximum(ql[phase.masses[-1]], qr[phase.masses[-1]]))
                              for phase in phases])}


def pulls(parts, ratio, q, push, bearing):
    """Return velocity, push and bearing mass of each phase, of these the mean of both faces of a cell."""
    flux, result = mass_flux(parts.model, q), []
    for k, phase in enumerate(parts.model.phases):
        row = phase.masses[-1]
        result += [flux[row] / (q[row] + TINY), 0.5 * (push[0][k] + push[1][k]), 0.5 * (bearing[0][k] + bearing[1][k])]
    return {PULLS: tuple(result)}


def on_face(model, ql, qr, auxl, auxr):
    """Return the state of a face, and the velocity of each phase there.

    Masses are those that a push acts on: the mean, and of the excess of an emerged step of the bottom the upper side.
    Velocities are weighted by the roots of the masses.
    """
    lift = subtract(model.balanced_difference(ql, qr, auxl, auxr), subtract(qr, ql))
    fluxl, fluxr = mass_flux(model, ql), mass_flux(model, qr)
    result, speeds = [0.5 * (left + right) for left, right in zip(ql, qr, strict=True)], []
    for masses, momentum in model.phases:
        row = masses[-1]
        beyond = maximum(lift[row] - ql[row], 0.0) + maximum(-lift[row] - qr[row], 0.0)
        raised = rarely(beyond > 0.0, partial(truediv, beyond, np.abs(lift[row]) + TINY), 0.0)
        for k in masses:
            result[k] = result[k] + raised * (where(lift[row] > 0.0, qr[k], ql[k]) - result[k])
        rootl, rootr = np.sqrt(ql[row]) + SMALL, np.sqrt(qr[row]) + SMALL
        v = (fluxl[row] * rootr + fluxr[row] * rootl) / (rootl * rootr * (rootl + rootr) + TINY)
        speeds.append(v)
        result[momentum] = result[row] * v
    return tuple(result), speeds


@attrs.frozen(repr=False)
class Restrained(Wrapper):
    """A model whose balanced difference leaves out what friction holds back at a face, since that too is equilibrium.

    A viscosity would else carry a depth away whose push friction has taken.
    """

    whole: Any
    net: Any

    def balanced_difference(self, ql, qr, auxl, auxr):
        """Return the balanced difference of the model, of each phase as much as sources leave of its push."""
        result = list(self.part.balanced_difference(ql, qr, auxl, auxr))
        for masses, momentum in self.part.phases:
            left = minimum(1.0, np.abs(self.net[momentum]) / (np.abs(self.whole[momentum]) + TINY))
            for row in masses:
                result[row] = left * result[row]
        return tuple(result)


def without_held(model, whole, jump, waves):
    """Return the waves without the rows of a phase that sources hold at this face: neither viscosity nor the waves of another
    phase then move it."""
    result = [list(wave) for wave in waves]
    for masses, momentum in model.phases:
        held: Any = (whole[momentum] != 0.0) & (jump[momentum] == 0.0)
        for row in masses:
            held = held & (jump[row] == 0.0)
        for wave in result:
            for row in (*masses, momentum):
                wave[row] = where(held, 0.0, wave[row])
    return tuple(map(tuple, result))


def for_cells(model, ql, qr, whole, jump):
    """Return the jump that the cells of a face get: nothing of the push of a phase that is held at rest, else the whole of it.

    The part that the waves do not carry stays at the face, and each cell gets half of it.
    """
    if jump is whole:
        return whole
    result = list(whole)
    for _, momentum in model.phases:
        held = (ql[momentum] == 0.0) & (qr[momentum] == 0.0) & (jump[momentum] == 0.0)
        result[momentum] = where(held, 0.0, whole[momentum])
    return tuple(result)
