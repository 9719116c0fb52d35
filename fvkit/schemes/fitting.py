"""Assembly of a scheme and a problem: model, solver, limiters and sources of a run, checked against the contract."""
from typing import Any

import numpy as np

from fvkit import validation
from fvkit.pointwise import contract, scale
from fvkit.problem import answers, fields
from fvkit.problem.directions import Direction
from fvkit.problem.grid import Grid
from fvkit.problem.problem import Problem
from fvkit.problem.questions import check_answers, samples
from fvkit.problem.relief import OverSlopes
from fvkit.schemes.background import AddingUp, GivenMore, Scanning
from fvkit.schemes.cautions import cautioned, says_nothing_of_the_matrix
from fvkit.schemes.riemann import default_riemann
from fvkit.schemes.scheme import Parts, Scheme
from fvkit.schemes.wave_propagation import WavePropagation

#: Number of times at which time-dependent boundary values are sampled.
TIMES = 9


def assemble(problem: Problem, scheme: Scheme | None) -> tuple[Scheme, tuple[Parts, ...]]:
    """Return the scheme (the default for None) and its `Parts` along each axis, checked against the problem."""
    validation.instance(problem, "problem", Problem)
    chosen = default_scheme(problem) if scheme is None else validation.instance(scheme, "scheme", Scheme)
    check_axes(chosen, problem.grid)
    if problem.model.relief() is not None:
        _check_relief(problem, chosen)
    every = tuple(_parts_of(problem, chosen, direction) for direction in problem.directions)
    parts = every[0]
    check_parts(problem, parts)
    chosen.splitting.check()
    if chosen.time_integrator is not None:
        chosen.time_integrator.check()
    chosen = cautioned(problem, chosen, parts)
    return chosen, every if problem.background is None else tuple(chosen.around(parts) for parts in every)


def check_axes(scheme: Scheme, grid: Grid) -> None:
    """Refuse a scheme that does not serve as many axes as a grid has."""
    if len(grid.axes) > 1 and not scheme.planar:
        raise ValueError(f"{type(scheme).__name__} serves a grid with one axis, got one with two: take fv.WavePropagation")


def _check_relief(problem: Problem, scheme: Scheme) -> None:
    """Refuse what has no equations for steep ground."""
    if not scheme.planar:
        raise ValueError(f"{type(scheme).__name__} has the equations for mild slopes only, got a {type(problem.model).__name__} "
                         "with slope=\"steep\": take fv.WavePropagation, or slope=\"mild\"")
    if problem.background is not None:
        raise ValueError("`background` needs slope=\"mild\": a flow on steep ground has none")


def _parts_of(problem: Problem, scheme: Scheme, direction: Direction) -> Parts:
    """Return the parts of a scheme for a problem, with the rows of the `fields` of its sources."""
    parts, found, own = _parts_for_model(problem, scheme, direction), problem.fields, len(problem.model.aux)
    if len(problem.grid.axes) > 1:
        parts = parts._replace(swept=True, across=len(direction.across))
    if problem.model.relief() is not None:
        bends = any(source.bends for source in problem.sources)
        parts = parts._replace(model=OverSlopes(parts.model, len(problem.grid.axes), direction.number, bends))
    of_sources = [field for field in found if isinstance(field, fields.Field)]
    rows = [f"{field.alias} of source {field.position}" for field in of_sources for _ in range(field.size)]
    if parts.across and parts.joint:
        rows += [f"{what} of phase {k} across" for k in range(parts.across) for what in ("velocity", "push", "bearing mass")]
    rows += ["compression across"] if parts.across else []
    if not rows:
        return parts
    sources = fields.on_grid(parts.sources, found, own) if found else parts.sources
    return parts._replace(model=GivenMore(parts.model, tuple(rows)), sources=sources)


def _parts_for_model(problem: Problem, scheme: Scheme, direction: Direction) -> Parts:
    """Return the `Parts` of a scheme; the speeds of a scalar law that is nonconvex around its initial state are sampled."""
    model = direction.model
    parts = scheme.parts(model, problem.sources)._replace(dx=problem.grid.axes[direction.number].dx)
    if not model.defines("jump") and says_nothing_of_the_matrix(problem, parts):
        return parts._replace(model=AddingUp(parts.model, parts.riemann.total))
    scalar = len(problem.q0) == 1 and not answers.looks_between(model)
    if scalar and not answers.monotone(model, _values(problem), problem.sample()[1]):
        return parts._replace(model=Scanning(parts.model))
    return parts


def _values(problem: Problem) -> np.ndarray:
    """Return the initial values of a scalar law and the boundary values of both ends at some times, (m,)."""
    model, times = problem.directions[0].model, np.linspace(problem.t_start, problem.t_end, TIMES)
    outside = [side.ghost(model, (problem.q0[0, cell],), side.values(model, t))[0]
               for side, cell in zip(problem.ends, (0, -1), strict=False) for t in times[:1 if side.steady else None].tolist()]
    outside += [value for axis in problem.sides for side in axis for part in side
                for value in part.first.ghost(model, (problem.q0[0].reshape(-1)[:1],), part.first.values(model, times[0]))[0]]
    return np.concatenate([problem.q0[0].reshape(-1), np.asarray(outside, dtype=float)])


def default_scheme(problem: Problem) -> Scheme:
    """Return second-order wave propagation with the model's default Riemann solver."""
    return WavePropagation(default_riemann(problem.model))


def check_parts(problem: Problem, parts: Parts) -> None:
    """Check the pointwise contract of solver and limiters on the problem's own initial state."""
    q, aux, _ = problem.sample()
    given = samples(problem.directions[0].model, q, aux)
    waves, _ = check_answers(parts.riemann, given, traced=parts.riemann.compilable)["solve"]
    if parts.reconstruction is None and len(parts.limiters) not in (1, len(waves)):
        raise ValueError(f"`limiter` must be one limiter or one per wave family: {type(parts.riemann).__name__} with "
                         f"{type(problem.model).__name__} has {len(waves)}, got {len(parts.limiters)}")
    for part in (parts.reconstruction, *parts.limiters):
        if part is not None:
            check_answers(part, given)
    with np.errstate(all="ignore"):
        behind = (np.zeros(q[0].shape),) * (len(parts.model.aux) - len(aux))
        _check_numbers(parts, given["ql"], given["qr"], (*given["auxl"], *behind), (*given["auxr"], *behind))


def _check_numbers(parts: Parts, ql: Any, qr: Any, auxl: Any, auxr: Any) -> None:
    """Refuse parts that run but break their contract: such runs would silently converge to something else."""
    jump = parts.model.jump(ql, qr, auxl, auxr)
    waves, _ = parts.riemann.solve(parts.model, ql, qr, auxl, auxr, jump)
    sizes = [np.fmax.reduce(np.abs(row), axis=None) for wave in (*waves, scale(1e-6, (*ql, *qr))) for row in wave]
    largest = float(np.fmax.reduce(sizes))  # the waves of a state at rest are round-off relative to the state
    contract.agree(parts.riemann, "solve", tuple(sum(rows) for rows in zip(*waves, strict=True)), jump,
                   "the waves must add up to the jump (of the flux: a wave is its speed times a jump of the state)", largest)
    if parts.reconstruction is not None:
        means, right = np.array([-2.0, 0.0, 1e-3, 1.0]), parts.reconstruction.right
        contract.agree(parts.reconstruction, "right", right(*[means] * 5), means, "must return the mean that five cells share")
        if parts.reconstruction.reach == 1:
            a, b, c, d, e = (means + shift for shift in (0.3, 0.1, 0.7, 0.4, 0.9))
            contract.agree(parts.reconstruction, "right", right(a, b, c, d, e), right(e, b, c, d, a),
                           "`reach` is 1, so that the first and the last mean must not count")
    nu = np.linspace(0.1, 1.0, 4)
    for limiter in parts.limiters:
        theta = np.array([1.0, 1.0, 1.0, 1.0] if limiter.limits else [-1.0, 0.0, 0.5, 3.0])
        contract.agree(limiter, "phi", limiter.phi(theta, nu), np.ones(4),
                       "must be 1 for theta = 1, else the scheme is not of second order" if limiter.limits else
                       "`limits` is False, so that it must be 1 for every theta")
