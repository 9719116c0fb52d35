"""What a scheme and a problem make together: the parts of a run, checked."""

import warnings

import numpy as np

from fvkit import _validate, answers, contract
from fvkit.backends import CHUNK
from fvkit.deviation import scanning
from fvkit.model import aux_rows
from fvkit.problem import Problem
from fvkit.schemes import Parts, Scheme, WavePropagation

#: Times at which ends that depend on time are asked for the values that come in.
TIMES = 9

#: Speeds between two states may exceed those of both by this factor before a model that looks at both alone is warned of.
BEYOND = 2.0


def assemble(problem: Problem, scheme: Scheme | None) -> tuple[Scheme, Parts]:
    """Return the scheme, the default where None, and its parts, checked against the problem."""
    _validate.instance(problem, "problem", Problem)
    chosen = default_scheme(problem) if scheme is None else _validate.instance(scheme, "scheme", Scheme)
    parts = parts_of(problem, chosen)
    check_parts(problem, parts)
    if parts.riemann.bounds and len(problem.q0) > 1 and not answers.looks_between(problem.model):
        _check_bounds(problem, parts)
    return chosen, parts if problem.background is None else chosen.around(parts)


def parts_of(problem: Problem, scheme: Scheme) -> Parts:
    """Return the parts of a scheme for a problem: a scalar law that is not convex around its initial state scans its speeds."""
    parts = scheme.parts(problem.model, problem.sources)._replace(dx=problem.grid.dx)
    scalar = len(problem.q0) == 1 and not answers.looks_between(problem.model)
    if scalar and not answers.monotone(problem.model, _values(problem), problem.sample()[1]):
        return parts._replace(model=scanning(parts.model))
    return parts


def _values(problem: Problem) -> np.ndarray:
    """Values of a scalar law that a run meets: those of the start, and those outside of both ends at some times."""
    model, times = problem.model, np.linspace(problem.t_start, problem.t_end, TIMES)
    outside = [side.ghost(model, (problem.q0[0, cell],), side.values(model, t))[0]
               for side, cell in zip(problem.ends, (0, -1), strict=True) for t in times[:1 if side.steady else None].tolist()]
    return np.concatenate([problem.q0[0], np.asarray(outside, dtype=float)])


def default_scheme(problem: Problem) -> Scheme:
    """Second-order wave propagation with the model's default Riemann solver."""
    return WavePropagation(problem.model.default_riemann())


def check_parts(problem: Problem, parts: Parts) -> None:
    """Check the pointwise contract of solver and limiters on the problem's own initial state."""
    model, kind = problem.model, type(problem.model)
    q, aux, count = problem.sample()
    face = (model, q, tuple(row[::-1] for row in q), aux, tuple(row[::-1] for row in aux), q)
    if parts.riemann.compilable:
        contract.read(type(parts.riemann), ("solve",), kind)
    waves = contract.rehearse_waves(parts.riemann, "solve", face, len(q), count)
    if parts.reconstruction is None and len(parts.limiters) not in (1, waves):
        raise ValueError(f"`limiter` must be one limiter or one per wave family: {type(parts.riemann).__name__} with "
                         f"{kind.__name__} has {waves}, got {len(parts.limiters)}")
    if parts.reconstruction is not None:
        contract.read(type(parts.reconstruction), ("right",))
        cells = tuple(np.linspace(1.0, 2.0 + k % 3, count) for k in range(5))
        contract.rehearse_value(parts.reconstruction, "right", cells, count)
    for limiter in parts.limiters:
        contract.read(type(limiter), ("phi",))
        contract.rehearse_value(limiter, "phi", (np.linspace(-1.0, 3.0, count), np.full(count, 0.5)), count)


def _check_bounds(problem: Problem, parts: Parts) -> None:
    """Warn where speeds between the states of a face at the start exceed those of both sides by far: bounds that do not bound."""
    model, count = problem.model, problem.grid.num_cells
    ends, most = np.zeros(max(count - 1, 0)), np.zeros(max(count - 1, 0))
    for first in range(0, count - 1, CHUNK):
        cells = slice(first, first + CHUNK + 1)
        q, aux = problem.q0[:, cells], [row[cells] for row in aux_rows(model, problem.aux_averages)]
        for share, found in ((0.0, ends), (1.0, ends), *((share, most) for share in answers.BETWEEN)):
            state, given = (tuple([(1.0 - share) * row[:-1] + share * row[1:] for row in rows]) for rows in (q, aux))
            here = found[first:first + CHUNK]
            with np.errstate(all="ignore"):
                for bound in answers.wave_speeds(model, state, given):
                    np.fmax(here, np.abs(bound), out=here)
    wrong = np.flatnonzero(most > BEYOND * ends + np.finfo(float).tiny)
    if wrong.size:
        face = int(wrong[np.argmax(most[wrong] - ends[wrong])])
        warnings.warn(f"{type(model).__name__}: speeds of states between those of both sides of a face reach {most[face]:.6g}, of both "
                      f"sides {ends[face]:.6g} at most (x = {problem.grid.edges[face + 1]:.6g}): {type(parts.riemann).__name__} takes "
                      "those of both sides as bounds, and may be unstable. Define `speeds_between(ql, qr)`, bounds over all states "
                      "between (fv.Model, point 7)", RuntimeWarning, stacklevel=4)
