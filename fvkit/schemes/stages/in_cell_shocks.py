"""In-cell shocks: a cell that a shock crosses holds both of its states and the front between them, instead of their mean.

Averaging a shock over a cell is what makes internal shocks of a nonconservative system miss their speed: the mean is no
state of the shock, and the next Riemann problems see it. Here a cell whose neighbours a, c are joined by one dominant shock
is split again: w_l left of the front, w_r right of it, both from the Roe waves of (a, c), the front where the cell's
masses put it. The faces see w_l and w_r. The front moves inside, and what crosses the downstream face by the end of the
step is a flux through it, so both cells see the same number. The cell also gets jump(w_l, w_r) less that flux: masses and
mixture momentum stay conserved for any w_l, w_r. On one shock between two constants the scheme is exact.

Idea: Chalons (2020); Pimentel-Garcia, Castro, Chalons, Morales de Luna, Pares (2022), both remembered. Roe states,
isolation, dominance and the treatment of ties: derived here.
"""

from typing import Any

import numpy as np

from fvkit.pointwise import TINY, add, maximum, scale, subtract, weighted, where
from fvkit.schemes.scheme import MASS_FLUX, SPEED, Read, Stage
from fvkit.schemes.stages.driven import for_cells, jumps
from fvkit.schemes.stages.dry_fallback import nearly_dry
from fvkit.schemes.stages.fluctuations import fluctuations, half_signs, riemann_problem
from fvkit.schemes.stages.positivity import hold_within, mass_fluxes

#: The smallest shock looked at, its change of depth over the depth; results are insensitive from .005 to .1.
WEAKEST = 0.02

#: A shock is isolated where two cells further the change is at most this share of its own: smooth waves are not.
ISOLATED = 0.5

#: The same for the outer fields. Their shocks are sharp, and need this only where they carry something of an inner field with
#: them, such as slip; steep smooth surface waves on coarse grids would pass the weaker test.
SHARP = 0.3

#: Two neighbours count as equal, and neither holds a shock, where their strengths differ by less than this share: else
#: rounding would choose between mirror images.
TIE = 1e-9

_FRONT = ("strength", "crossing", "front_left", "front_right")


def detection_stages(model):
    """Return the stages that find the shocks: ``marked`` is true in cells with a shock."""
    none = (0.0,) * len(model.conserved)

    def empty(parts, ratio):
        return dict(zip(_FRONT, (0.0, 0.0, none, none), strict=True))

    around = {"q": Read("q", -1, 1), "aux": Read("aux", -1, 1)}
    distant = {"upstream": Read("contrast", -2), "change": Read("contrast"), "downstream": Read("contrast", 2)}
    return [Stage(contrast, around, ("contrast",)), Stage(empty, {}, _FRONT),
            Stage(shock_of_cell, {**distant, **around}, _FRONT, guard=suspected, sparse=True),
            Stage(mark_stronger, {"strength": Read("strength", -1, 1)}, ("marked",), light=True)]


def resolved_faces_stage(waves):
    """Return the stage that solves the faces of marked cells again; it writes ``waves``, the fields that keep waves, too."""
    sides = {name: Read(name, -1, 0) for name in ("marked", "q", "aux", "crossing", "front_left", "front_right")}
    return Stage(solve_between_fronts, sides, ("left_going", "right_going", SPEED, *waves), guard=beside_marked, sparse=True)


def first_order_stage(corrections, masses):
    """Return the stage that makes faces of marked cells first order: no corrections, mass fluxes without them in their window."""
    def uncorrected(parts, ratio, marked, q, left_going):
        none = dict.fromkeys(corrections, (0.0,) * len(left_going))
        if not masses:
            return none
        return none | hold_within(parts, ratio, q[0], q[1], left_going, mass_fluxes(parts, ratio, left_going)[MASS_FLUX])

    reads = {"marked": Read("marked", -1, 0), "q": Read("q", -1, 0), "left_going": Read("left_going")}
    return Stage(uncorrected, reads, (*corrections, *masses), guard=beside_marked, sparse=True)


def depth_change(model, difference):
    """Return the change of depth: the sum of abs over the masses, over all components of a model without masses."""
    return sum(np.abs(difference[row]) for row in measured_rows(model))


def measured_rows(model):
    """Rows that measure a shock and place its front."""
    return model.mass_rows() or tuple(range(len(model.conserved)))


# ---------------------------------------------------------------------- which cells

def contrast(parts, ratio, q, aux):
    """Return the change of depth from the cell before to the cell after, beyond that of an equilibrium."""
    return {"contrast": depth_change(parts.model, parts.model.balanced_difference(q[0], q[2], aux[0], aux[2]))}


def suspected(parts, ratio, upstream, change, downstream, q, aux):
    """Whether a change over two cells is large and isolated enough to be a shock in the cell between them."""
    depth = 0.5 * (depth_change(parts.model, q[0]) + depth_change(parts.model, q[2]))
    most = ISOLATED * change
    return (change > WEAKEST * depth) & (upstream <= most) & (downstream <= most)


def shock_of_cell(parts, ratio, upstream, change, downstream, q, aux):
    """Return strength, crossing speed, w_l and w_r of the shock in a cell; strength 0 where there is none.

    The strongest Roe wave of the neighbours, both on the bottom of the cell, is a shock in the cell where its states have
    depth, the other waves together are no stronger, its characteristic speeds on both sides run into it (Lax), and the
    masses of the cell put its front inside. ``crossing`` is the part of its speed that is spent behind the downstream face.
    """
    model = parts.model
    (before, here, after), (aux_before, aux, aux_after) = q, aux
    a = subtract(here, model.balanced_difference(before, here, aux_before, aux))
    c = add(here, model.balanced_difference(here, after, aux, aux_after))
    waves, speeds = model.decompose(a, c, aux, aux, subtract(c, a))
    left, right, strength, speed, family, others = strongest(model, a, c, waves, speeds)
    shock = subtract(right, left)
    rows = measured_rows(model)
    norm = sum(shock[row] * shock[row] for row in rows) + TINY
    behind = sum((right[row] - here[row]) * shock[row] for row in rows) / norm
    outer = (family == 0.0) | (family == len(waves) - 1.0)
    most = where(outer, SHARP, ISOLATED) * change
    accepted = ((upstream <= most) & (downstream <= most) & (others <= strength) & (behind > 0.0) & (behind < 1.0)
                & (strength > WEAKEST * 0.5 * (depth_change(model, a) + depth_change(model, c)))
                & (own_speed(model, left, aux, shock, family) > own_speed(model, right, aux, shock, family)))
    for row in model.mass_rows():
        accepted = accepted & (left[row] > 0.0) & (right[row] > 0.0)
    if model.phases:
        for ql, qr, auxl, auxr in ((before, here, aux_before, aux), (here, after, aux, aux_after), (left, right, aux, aux)):
            accepted = accepted & ~nearly_dry(parts, ql, qr, auxl, auxr)
    whole, net, _ = jumps(parts, ratio, a, c, aux, aux)
    if net is not whole:
        for every, rest in zip(whole, for_cells(model, a, c, whole, net), strict=True):
            accepted = accepted & (every == rest)
    way = np.abs(speed) * ratio
    room = where(speed > 0.0, 1.0 - behind, behind)
    crossing = np.sign(speed) * (maximum(way - room, 0.0) / (ratio + TINY))
    return dict(zip(_FRONT, (where(accepted, strength, 0.0), crossing, left, right), strict=True))


def strongest(model, a, c, waves, speeds):
    """Return both states of the strongest wave, its strength, speed and number, and the strength of all others together.

    Waves are summed up from the nearer side, so that a mirror image has mirrored states.
    """
    count = len(waves)
    sizes = [depth_change(model, wave) for wave in waves]
    states = []
    for k, wave in enumerate(waves):
        from_left, from_right = a, c
        for before in waves[:k]:
            from_left = add(from_left, before)
        for after in waves[:k:-1]:
            from_right = subtract(from_right, after)
        if 2 * k < count - 1:
            states.append((from_left, add(from_left, wave)))
        elif 2 * k > count - 1:
            states.append((subtract(from_right, wave), from_right))
        else:
            states.append((scale(0.5, add(from_left, subtract(from_right, wave))),
                           scale(0.5, add(from_right, add(from_left, wave)))))
    (left, right), strength, speed = states[0], sizes[0], speeds[0]
    family: Any = 0.0
    for k in range(1, count):
        more = sizes[k] > strength
        left, right = selected(more, states[k][0], left), selected(more, states[k][1], right)
        speed, family = where(more, speeds[k], speed), where(more, float(k), family)
        strength = maximum(sizes[k], strength)
    return left, right, strength, speed, family, sum(sizes) - strength


def own_speed(model, state, aux, change, family):
    """Return the characteristic speed of a family at a state: the Roe speed of equal sides."""
    _, speeds = model.decompose(state, state, aux, aux, change)
    result = speeds[0]
    for k in range(1, len(speeds)):
        result = where(family == float(k), speeds[k], result)
    return result


def mark_stronger(parts, ratio, strength):
    """Whether a cell holds a shock: of two neighbours the stronger one, none of equals."""
    before, here, after = strength
    return {"marked": here > (1.0 + TIE) * maximum(before, after)}


# ---------------------------------------------------------------------- what their faces do

def beside_marked(parts, ratio, marked, **others):
    """Whether one of the cells of a face is marked."""
    return marked[0] | marked[1]


def solve_between_fronts(parts, ratio, marked, q, aux, crossing, front_left, front_right):
    """Solve a face between the states of the fronts, with what fronts carry through it and do inside their cells.

    Each input is a pair, of the left and the right cell; ``front_left`` and ``front_right`` are the states w_l and w_r on both
    sides of the front of a cell. Returned are the fluctuations left and right, the fastest speed, speeds and waves.
    """
    (markedl, markedr), (ql, qr), (auxl, auxr), (crossingl, crossingr) = marked, q, aux, crossing
    (l_of_l, l_of_r), (r_of_l, r_of_r) = front_left, front_right
    l_of_l, r_of_l = selected(markedl, l_of_l, ql), selected(markedl, r_of_l, ql)
    l_of_r, r_of_r = selected(markedr, l_of_r, qr), selected(markedr, r_of_r, qr)
    found = riemann_problem(parts, ratio, r_of_l, l_of_r, auxl, auxr)
    waves, speeds = found["waves"], found["speeds"]
    left, right = fluctuations(parts, ratio, r_of_l, l_of_r, found["jump"], waves, half_signs(speeds)).values()
    forth, back = where(markedl, maximum(crossingl, 0.0), 0.0), where(markedr, maximum(-crossingr, 0.0), 0.0)
    carried = weighted((forth, back), (subtract(r_of_l, l_of_l), subtract(r_of_r, l_of_r)))
    insidel = for_cells(parts.model, l_of_l, r_of_l, *jumps(parts, ratio, l_of_l, r_of_l, auxl, auxl)[:2])
    insider = for_cells(parts.model, l_of_r, r_of_r, *jumps(parts, ratio, l_of_r, r_of_r, auxr, auxr)[:2])
    rows = parts.model.mass_rows()
    left = tuple([item - through if k in rows else item + 0.5 * inside - through
                  for k, (item, inside, through) in enumerate(zip(left, insidel, carried, strict=True))])
    right = tuple([item if k in rows else item + 0.5 * inside + through
                   for k, (item, inside, through) in enumerate(zip(right, insider, carried, strict=True))])
    return {"left_going": left, "right_going": right, SPEED: found[SPEED], "speeds": speeds, "waves": waves}


def selected(condition, new, old):
    """Return the tuple ``new`` where the condition holds, else ``old``."""
    return tuple([where(condition, mine, other) for mine, other in zip(new, old, strict=True)])
