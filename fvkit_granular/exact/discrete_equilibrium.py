"""Steady states of the scheme: no jump at any face, so that no wave leaves one. Derived here."""

import numpy as np

from fvkit import Model

#: Newton steps per face, and the relative step of its difference quotients.
STEPS, QUOTIENT = 60, 1e-6
#: What to do where there is none.
MORE_CELLS = "near a critical point take more cells, or a cell edge at the crest"


def march(model: Model, q: np.ndarray, b: np.ndarray, first: int, last: int, centers: np.ndarray) -> None:
    """Turn the exact flow ``q`` into a discrete steady flow, in place, outwards from the cells ``first`` to ``last``, which
    stay.

    The model has one momentum per mass, and the momenta are uniform. ``b`` (n,) are averages of the bottom, m, and ``centers``,
    m, are for messages: a ValueError where the jump does not vanish.
    """
    for step, cells in ((1, range(last + 1, q.shape[1])), (-1, range(first - 1, -1, -1))):
        for i in cells:
            q[:, i] = across(model, q[:, i - step], q[:, i], b[i - step], b[i], centers[i])


def across(model: Model, known: np.ndarray, guess: np.ndarray, b_known: float, b: float, x: float) -> np.ndarray:
    """Return the state (num_eqn,) next to ``known`` that makes the momentum rows of ``model.jump`` vanish.

    Newton's method on the masses, momenta fixed, with difference quotients of the jump.
    """
    masses = [rows[0] for rows, _ in model.phases]
    momenta = [row for _, row in model.phases]
    count = len(masses)
    left, bl, br = tuple(known[:, None]), np.array([b_known]), np.array([b])

    def rows(q: np.ndarray) -> np.ndarray:
        return np.array(model.jump(left, tuple(q), (bl,), (br,)))[momenta]

    q, best, least = guess.copy(), guess, np.inf
    for _ in range(STEPS):
        step = QUOTIENT * q[masses]
        tried = np.repeat(q[:, None], 2 * count + 1, axis=1)
        tried[masses, np.arange(1, count + 1)] += step
        tried[masses, np.arange(count + 1, 2 * count + 1)] -= step
        found = rows(tried)
        residual = float(np.abs(found[:, 0]).max())
        if not residual < least:
            break
        best, least = q.copy(), residual
        slope = (found[:, 1 : count + 1] - found[:, count + 1 :]) / (2.0 * step)
        change = np.linalg.solve(slope, found[:, 0])
        q[masses] -= change * min(1.0, 0.5 / float(np.abs(change / q[masses]).max() + 1e-300))
    size = float(np.abs(np.array(model.flux(tuple(best[:, None])))).max())
    if not least < 1e-13 * size:
        raise ValueError(f"no discrete steady flow beside x = {x:.6g} found: the jump there stays {least:.2g}; {MORE_CELLS}")
    return best
