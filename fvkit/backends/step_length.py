"""Length of the next step: equalised before an output time, and shortened where a trial step exceeds the Courant number.

The largest and the smallest length are the user's, `fvkit.Step`. Compiled code has the same rules, see `time_loop`.
"""

from math import ceil

#: Within this many steps of an output time, step lengths are equalised.
EQUALISED = 1000

#: Retries per step, and the least share of its length that a retry has.
MAX_RETRIES, SHORTEST = 30, 0.25

#: Slack when the number of remaining steps is rounded up.
NEARLY_ONE = 1.0 - 1e-12


def step_length(t: float, dt: float, target: float, pair: bool = False) -> tuple[float, bool]:
    """Return the length of the next step, and whether it is the last before the target: steps before it are made even.

    A step that begins a ``pair`` of equal ones leaves an even number of them.
    """
    if pair and target - t < EQUALISED * dt:
        count = ceil((target - t) / dt * NEARLY_ONE)
        return (target - t) / max(2, count + count % 2), False
    if dt >= (target - t) * NEARLY_ONE:
        return target - t, True
    return (target - t) / ceil((target - t) / dt * NEARLY_ONE) if target - t < EQUALISED * dt else dt, False


def shortened(dt: float, cfl: float, target: float) -> float:
    """Return the length of a retry of a step whose Courant number was ``cfl`` instead of the target."""
    return dt * max(target / cfl, SHORTEST)
