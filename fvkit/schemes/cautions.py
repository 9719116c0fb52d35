"""Warnings before a run: missing methods of a model that reduce the order of the scheme or its stability."""

import warnings
from typing import Any

import numpy as np

from fvkit.pointwise import CHUNK, subtract
from fvkit.problem import answers
from fvkit.problem.model import Model, aux_rows
from fvkit.problem.problem import Problem
from fvkit.schemes.scheme import Parts, Scheme

#: Ratio of the largest wave speed between two states to the largest speed of the two states, above which a run warns.
BEYOND = 2.0

#: A push, relative to the flux, that counts as none.
ROUNDING = 1e-12


def cautioned(problem: Problem, chosen: Scheme, parts: Parts) -> Scheme:
    """Warn about missing methods of the model; return the scheme, reduced to first order if the matrix is unknown."""
    name = type(problem.model).__name__
    model = problem.directions[0].model
    if says_nothing_of_the_matrix(problem, parts):
        given, chosen = chosen, chosen.at_first_order()
        warnings.warn(f"{name} does not define the matrix of {type(parts.riemann).__name__}: the waves do not add up to its "
                      f"flux. The run uses the waves alone{'' if chosen is given else ', at first order'}. Define `flux(q)` or "
                      "`flux(q, aux)` of the same equations, or `jump` and `matrix_product` where they have no flux",
                      RuntimeWarning, stacklevel=4)
    if chosen.wants_cross and _lacks_cross(problem):
        warnings.warn(f"{name} defines a `jump` with products or sources that change with q, and no `cross`: "
                      f"{type(chosen).__name__} of order 2 is first order where they act. Define `cross(ql, qr, auxl, auxr)`, "
                      "the Lax-Wendroff term A'(G) dq - A'(dq) G - S'(G) db - A_a da G, and with a linearisation of your own "
                      "`matrix_product`, the matrix A times v (fv.Model); or take order=1, or fv.MethodOfLines, which needs none",
                      RuntimeWarning, stacklevel=4)
    steps = [np.abs(np.diff(problem.aux_averages[aux])).max(initial=0.0) for aux in model.aux]
    if parts.riemann.bounds and any(steps) and lacks_balance(model, *problem.sample()[:2], steps):
        warnings.warn(f"{name} defines a `jump` with a force at rest over a step of {' or '.join(model.aux)}, and "
                      f"no `balanced_difference`: the viscosity of {type(parts.riemann).__name__} acts on qr - ql, and moves "
                      "a state at rest. Define `balanced_difference(ql, qr, auxl, auxr)`, 0 at rest: for a depth h over "
                      "a bottom b, qr - ql with d(h + b) in place of dh; or take fv.Roe(), for a model with `decompose`",
                      RuntimeWarning, stacklevel=4)
    if parts.riemann.bounds and len(model.conserved) > 1 and not answers.looks_between(model):
        _check_bounds(problem, parts)
    return chosen


def lacks_balance(model: Model, q: Any, aux: Any, steps: Any) -> bool:
    """Whether ``steps`` of the aux values push states without momentum, and a model with phases has no `balanced_difference`."""
    known = model.defines("balanced_difference") or not model.defines("jump") or "flux" in model.takes_aux
    if known or not model.phases:
        return False
    momenta = [phase.momentum for phase in model.phases]
    still = tuple([0.0 * row if k in momenta else row for k, row in enumerate(q)])
    below, above = (tuple([row + side * step for row, step in zip(aux, steps, strict=True)]) for side in (-0.5, 0.5))
    with np.errstate(all="ignore"):
        push, size = (np.fmax.reduce([np.fmax.reduce(np.abs(np.atleast_1d(row))) for row in rows])
                      for rows in (model.jump(still, still, below, above), answers.flux(model, still, aux)))
    return bool(push > ROUNDING * size)


def says_nothing_of_the_matrix(problem: Problem, parts: Parts) -> bool:
    """Whether the sum of the solver's own waves differs from the flux difference of a model without `matrix_product`."""
    model, riemann = problem.directions[0].model, parts.riemann
    if not riemann.defines("total") or model.defines("matrix_product"):
        return False
    q, aux, count = problem.sample()
    ql, auxl, auxr = (tuple(row[::-1] for row in q), aux, tuple(row[::-1] for row in aux))
    size = max(float(np.abs(q).max()), 1.0)
    qr = tuple([row + 0.01 * size * np.cos(np.arange(count) + k) for k, row in enumerate(q)])
    with np.errstate(all="ignore"):
        wanted = subtract(answers.flux(model, qr, auxr), answers.flux(model, ql, auxl))
        found, known = (np.array([np.broadcast_to(row, (count,)) for row in rows])
                        for rows in (riemann.total(ql, qr, auxl, auxr), wanted))
    return bool((np.abs(found - known) > 1e-6 * np.maximum(np.abs(found), np.abs(known)).max(axis=1, keepdims=True)).any())


def _lacks_cross(problem: Problem) -> bool:
    """Whether a model defines a `jump` that needs a cross term, but no `cross`.

    The test is the sum of jumps around a closed loop of states, q -/+ w by q -/+ dq/2 with its aux values. The sum is 0 for
    conservation laws and constant matrices; otherwise, with w along the jump G, it is the cross term. It is evaluated near
    the initial state, with differences of the aux values of the size that the problem has.
    """
    model = problem.directions[0].model
    if not model.defines("jump") or model.defines("cross"):
        return False
    cells, aux, count = problem.sample()
    rng = np.random.default_rng(1)
    size = np.abs(problem.seen).max(axis=1)
    size = 0.01 * np.where(size > 0.0, size, size.max() or 1.0)
    q = np.array(cells)
    w, half = (size[:, None] * rng.uniform(-1.0, 1.0, (len(q), count)) for _ in range(2))
    spread = np.array([np.ptp(problem.aux_averages[name]) for name in model.aux]).reshape(-1, 1)
    a, da = np.array(aux).reshape(len(aux), count), 0.01 * spread * rng.uniform(-1.0, 1.0, (len(aux), count))

    def jump(left: np.ndarray, right: np.ndarray, auxl: np.ndarray, auxr: np.ndarray) -> np.ndarray:
        found = model.jump(tuple(left), tuple(right), tuple(auxl), tuple(auxr))
        return np.array([np.broadcast_to(row, (count,)) for row in found])

    with np.errstate(all="ignore"):
        sides = [jump(q + w - half, q + w + half, a - da, a + da), -jump(q - w - half, q - w + half, a - da, a + da),
                 -jump(q + half - w, q + half + w, a + da, a + da), jump(q - half - w, q - half + w, a - da, a - da)]
        known = np.isfinite(sides).all(axis=(0, 1))
        loop, most = np.abs(sum(sides))[:, known], np.abs(sides).max(axis=0)[:, known].max(axis=1, initial=0.0)
    return bool((loop > 1e-9 * most[:, None]).any())


def _check_bounds(problem: Problem, parts: Parts) -> None:
    """Warn if wave speeds between the two initial states of a face exceed those of both states by more than `BEYOND`."""
    model, count = problem.directions[0].model, problem.grid.size
    ends, most = np.zeros(max(count - 1, 0)), np.zeros(max(count - 1, 0))
    seen = problem.seen
    for first in range(0, count - 1, CHUNK):
        cells = slice(first, first + CHUNK + 1)
        q, aux = seen[:, cells], [row.reshape(-1)[cells] for row in aux_rows(model, problem.aux_averages)]
        for share, found in ((0.0, ends), (1.0, ends), *((share, most) for share in answers.BETWEEN)):
            state, given = (tuple([(1.0 - share) * row[:-1] + share * row[1:] for row in rows]) for rows in (q, aux))
            here = found[first:first + CHUNK]
            with np.errstate(all="ignore"):
                for bound in answers.wave_speeds(model, state, given):
                    np.fmax(here, np.abs(bound), out=here)
    wrong = np.flatnonzero(most > BEYOND * ends + np.finfo(float).tiny)
    if wrong.size:
        face = int(wrong[np.argmax(most[wrong] - ends[wrong])])
        warnings.warn(f"{type(model).__name__}: speeds of states between those of both sides of a face reach {most[face]:.6g}, "
                      f"of both sides {ends[face]:.6g} at most (near {problem.grid.located(face)}): "
                      f"{type(parts.riemann).__name__} uses those of both sides as bounds, and may be unstable. Define "
                      "`speeds_between(ql, qr)`, bounds over all states between (fv.Model, point 7)",
                      RuntimeWarning, stacklevel=5)
