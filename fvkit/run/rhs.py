"""`rhs`: right-hand side of the semi-discrete equations, for time integrators of other libraries."""

from collections.abc import Callable

import numpy as np

from fvkit import validation
from fvkit.backends import array_kernel
from fvkit.problem.problem import Problem
from fvkit.schemes.fitting import assemble
from fvkit.schemes.scheme import Scheme


def rhs(problem: Problem, scheme: Scheme | None = None) -> Callable[[float, np.ndarray], np.ndarray]:
    """Return the right-hand side f(t, q) = dq/dt of the semi-discrete scheme, for SciPy and other libraries.

    For wave propagation f is the limit dt -> 0 of the scheme, limited corrections included, plus the rates of all sources.

    Parameters
    ----------
    problem, scheme : as for `solve`.

    Returns
    -------
    callable
        (t, q) -> dq/dt, q of shape (num_eqn, num_cells) or flat; the result has the shape of q.

    Examples
    --------
    >>> import fvkit as fv
    >>> import numpy as np
    >>> wave = lambda x: [np.sin(2.0 * np.pi * x)]
    >>> problem = fv.Problem(fv.Advection(1.0), fv.Grid(0.0, 1.0, 50), wave, 1.0, boundary=fv.Periodic())
    >>> f = fv.rhs(problem, fv.MethodOfLines(fv.Roe()))
    >>> wanted = -2.0 * np.pi * np.cos(2.0 * np.pi * problem.grid.centers)
    >>> bool(abs(f(0.0, problem.q0)[0] - wanted).max() < 0.01)
    True
    """
    chosen, every = assemble(problem, scheme)
    if len(every) > 1:
        raise ValueError("fvkit.rhs serves a grid with one axis, got one with two: sweeps along each make a step, not a rate")
    (parts,) = every
    if problem.model.relief() is not None and problem.sources:
        raise ValueError("fvkit.rhs adds rates of sources on the map, not on steep ground: take fv.solve, or slope=\"mild\"")
    kernel, model, shape = array_kernel(problem, chosen, every), problem.model, problem.q0.shape

    def rate(t: float, q: np.ndarray) -> np.ndarray:
        state = validation.floats(q, "q")
        if state.size != problem.q0.size:
            raise ValueError(f"`q` must have shape {shape}, or as many numbers in a row, got {state.shape}")
        state = state.reshape(shape)
        with np.errstate(all="ignore"):
            if not kernel.steady_fields:
                kernel.set_fields(t)
            result = kernel.rate(kernel.padded(state), t)
            aux = tuple(kernel.aux[:len(parts.model.aux)])
            for source in parts.sources:
                for row, component in zip(result, source.rate(model, tuple(state), aux), strict=True):
                    row += component
        return result.reshape(np.shape(q))

    return rate
