"""What a scheme and a problem make together: the parts of a run, checked."""

import numpy as np

from fvkit import _validate, contract
from fvkit.problem import Problem
from fvkit.schemes import Parts, Scheme, WavePropagation


def assemble(problem: Problem, scheme: Scheme | None) -> tuple[Scheme, Parts]:
    """Return the scheme, the default where None, and its parts, checked against the problem."""
    _validate.instance(problem, "problem", Problem)
    chosen = default_scheme(problem) if scheme is None else _validate.instance(scheme, "scheme", Scheme)
    parts = chosen.parts(problem.model, problem.sources)._replace(dx=problem.grid.dx)
    check_parts(problem, parts)
    return chosen, parts if problem.background is None else chosen.around(parts)


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
