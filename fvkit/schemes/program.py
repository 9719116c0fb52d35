"""A step as a list of sweeps over the grid and sums of registers, the same for both backends."""

from functools import lru_cache
from typing import NamedTuple

import attrs

from fvkit.schemes.integrators import Integrator

#: What a register holds: a state, minus dx times a rate of transport, a rate of sources.
STATE, TRANSPORT, SOURCE = 0, 1, 2

#: Name of a value: its kind and its number; states between an explicit sum and its implicit source are numbered from 100 on.
Value = tuple[int, int]


class Term(NamedTuple):
    """A register in a sum, and its weight: of a rate in units of dt."""

    register: int
    kind: int
    weight: float


@attrs.frozen
class StageSweep:
    """One sweep and the sum that follows it.

    Parameters
    ----------
    implicit : whether it is a sweep of the sources.
    state, rate : registers that it reads and writes.
    share : transport: length of the forward Euler step that keeps masses non-negative; sources: the implicit coefficient;
        in units of dt.
    time : time at which boundary values are evaluated, in units of dt from the start of the step.
    flux : weight of what passes the ends of the grid.
    target : register of the sum, None where there is none.
    terms : the sum.
    """

    implicit: bool
    state: int
    rate: int
    share: float
    time: float
    flux: float
    target: int | None
    terms: tuple[Term, ...]


@attrs.frozen
class Program:
    """The sweeps of a step, from register 0 to register ``last``, and the number of registers.

    Without registers it is one sweep from the old state to the new one, with the sources and all that makes a state.
    """

    sweeps: tuple[StageSweep, ...]
    last: int
    registers: int

    @property
    def times(self) -> tuple[float, ...]:
        """When each sweep asks the boundaries, in units of dt from the start of the step."""
        return tuple(sweep.time for sweep in self.sweeps)


#: The step of a fully discrete scheme: one sweep, with the boundaries of its middle.
ONE_SWEEP = Program((StageSweep(False, 0, 1, 1.0, 0.5, 1.0, None, ()),), 1, 0)


class _Step(NamedTuple):
    """A sweep with values in place of registers."""

    implicit: bool
    state: Value
    rate: Value
    share: float
    time: float
    flux: float
    target: Value | None
    terms: tuple[tuple[Value, float], ...]


@lru_cache(maxsize=64)
def program(integrator: Integrator) -> Program:
    """Return the program of an integrator, with as few registers as its sums allow."""
    return _assign(_steps(integrator))


def _steps(method: Integrator) -> list[_Step]:
    count, times, weights = len(method.beta), _times(method), _weights(method)
    euler = 1.0 / (method.ssp or 1.0)
    result: list[_Step] = []
    if method.implicit:
        result.append(_Step(True, (STATE, 0), (SOURCE, 0), 0.0, 0.0, 0.0, None, ()))
    for k in range(count):
        explicit = [((STATE, j), weight) for j, weight in enumerate(method.alpha[k])]
        explicit += [((TRANSPORT, j), weight) for j, weight in enumerate(method.beta[k])]
        last = k + 1 == count
        if method.implicit:
            row = method.weights if last else method.implicit[k][:-1]
            explicit += [((SOURCE, j), weight) for j, weight in enumerate(row)]
        before = (STATE, 101 + k) if method.implicit and not last else (STATE, k + 1)
        terms = tuple((value, weight) for value, weight in explicit if weight != 0.0)
        result.append(_Step(False, (STATE, k), (TRANSPORT, k), euler, times[k], weights[k], before, terms))
        if method.implicit and not last:
            share = method.implicit[k][-1]
            result.append(_Step(True, before, (SOURCE, k + 1), share, times[k + 1], 0.0, (STATE, k + 1),
                                ((before, 1.0), ((SOURCE, k + 1), share))))
    return result


def _times(method: Integrator) -> list[float]:
    """Times of the states, in units of dt."""
    result = [0.0]
    for alpha, beta in zip(method.alpha, method.beta, strict=True):
        result.append(sum(weight * result[j] for j, weight in enumerate(alpha)) + sum(beta))
    return result


def _weights(method: Integrator) -> list[float]:
    """Weights of the rates in the new state."""
    count = len(method.beta)
    states = [[0.0] * count]
    for alpha, beta in zip(method.alpha, method.beta, strict=True):
        row = [sum(weight * states[j][k] for j, weight in enumerate(alpha)) for k in range(count)]
        states.append([have + (beta[k] if k < len(beta) else 0.0) for k, have in enumerate(row)])
    return states[-1]


def _assign(steps: list[_Step]) -> Program:
    """Give registers to values, each free again after its last use."""
    ends: dict[Value, int] = {}
    for k, step in enumerate(steps):
        for value in (step.state, step.rate, *(term for term, _ in step.terms)):
            ends[value] = k
    free: list[int] = []
    held: dict[Value, int] = {(STATE, 0): 0}
    count = 1

    def take(value: Value) -> int:
        nonlocal count
        if value not in held:
            if not free:
                free.append(count)
                count += 1
            held[value] = free.pop()
        return held[value]

    sweeps = []
    for k, step in enumerate(steps):
        rate = take(step.rate)
        target = None if step.target is None else take(step.target)
        terms = tuple(Term(held[value], value[0], weight) for value, weight in step.terms)
        sweeps.append(StageSweep(step.implicit, held[step.state], rate, step.share, step.time, step.flux, target, terms))
        for value in [value for value in held if ends.get(value, len(steps)) <= k]:
            free.append(held.pop(value))
    last = sweeps[-1].target
    return Program(tuple(sweeps), 0 if last is None else last, count)
