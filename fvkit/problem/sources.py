"""Source terms: the base class `Source`, and given rates, `Forcing`."""

from abc import ABC, abstractmethod
from collections.abc import Sequence
from typing import Any, ClassVar

import attrs
import numpy as np

from fvkit import validation
from fvkit.pointwise import add, combine, maximum, minimum, scale, subtract, where
from fvkit.pointwise.part import Part, optional
from fvkit.problem.fields import is_number
from fvkit.problem.model import Model
from fvkit.problem.questions import SOURCE
from fvkit.problem.relief import slopes_at, stretched, stretching, turned_aside, turnings, unstretched
from fvkit.problem.turned import driven_in_plane, turned


@attrs.frozen
class Source(Part, ABC):
    """Abstract source term S(q, x) that acts within a cell. Contract:

    1. ``step(model, q, aux, dt)`` returns the state after dt under the source alone; pointwise. It is exact or
       unconditionally stable, so a time step never depends on its strength, and it returns q for dt = 0.
    2. ``rate(model, q, aux)`` returns dq/dt of the same source; pointwise. `fvkit.rhs` uses it.
    3. ``check(model)`` raises ValueError, with the reason, for a model it cannot act on.
    4. ``step`` may change masses, as rain and infiltration do, but makes none negative: it takes at most the existing mass. The
       change is counted as entered (`fvkit.Stats`). Masses that it does not change it returns unchanged. ``driven`` and
       ``implicit_rate`` never change masses: a source of mass acts beside the transport.
    5. ``driven(model, before, after, bearing, aux, dt)``, where defined, returns the state after dt under a constant drive, which
       alone takes ``before`` to ``after``, and the source; pointwise, with the masses of ``after``. ``bearing`` is, for each
       phase, the mass that the drive acts on. Where drive and source
       balance it returns the momenta of ``before``, to rounding. Wave propagation then lets source and transport act
       together, in cells and at faces: see `acted` and `fvkit.schemes.stages.driven`. A source without it is split
       from the transport.
    6. ``static = True`` declares static friction: it may hold a pushed phase at rest.
    7. ``between_phases = True`` declares that it exchanges momentum between phases: it is refused where the model has
       fewer than two, and a scene that is run with such a model omits it.
    8. A numeric field may vary over the grid: cell averages (num_cells,), a function of x, or of (x, t). Methods get a number
       in any case: that of the cell, or at a face the mean of both sides; of time, that of the middle of the step. Declare it
       with `fvkit.problem.fields.number`, which validates it.
    9. In two dimensions a source acts along the velocity of each phase, one ``between_phases`` along the slip: it gets the same
       one-dimensional states, turned. ``turns = False`` declares that it takes the state with the momenta along both axes.
    10. Sources act on the cells of the grid only; boundary conditions determine the ghost cells.
    11. ``acts_in()`` returns the numbers of the cells in which it acts, None for all: with two axes that saves time, and idle
        blocks stay idle. ``wets = False`` declares that it brings no mass to dry ground, ``bends = True`` that it needs the
        second derivatives of a bottom with relief.

    Examples
    --------
    >>> import fvkit as fv
    >>> import numpy as np
    >>> class Decay(fv.Source):
    ...     def step(self, model, q, aux, dt):
    ...         return (q[0] * np.exp(-dt),)
    ...
    ...     def rate(self, model, q, aux):
    ...         return (-q[0],)
    >>> problem = fv.Problem(fv.Advection(1.0), fv.Grid(0.0, 1.0, 10), np.ones((1, 10)), 1.0, boundary=fv.Periodic(),
    ...                      sources=Decay())
    >>> print(f"{fv.solve(problem, backend='numpy').q[-1].mean():.12f}, exp(-1) = {np.exp(-1.0):.12f}")
    0.367879441171, exp(-1) = 0.367879441171
    """

    questions = SOURCE
    between_phases: ClassVar[bool] = False
    static: ClassVar[bool] = False
    turns: ClassVar[bool] = True
    wets: ClassVar[bool] = True
    bends: ClassVar[bool] = False

    def check(self, model: Model) -> None:
        """Raise ValueError, with the reason, if this source cannot act on ``model``."""
        if self.between_phases and len(model.phases) < 2:
            raise ValueError(f"{type(self).__name__} acts between two phases, {type(model).__name__} has one velocity: "
                             "leave it out of `sources`")

    def varying(self) -> tuple[tuple[str, bool], ...]:
        return tuple((name, False) for name in self.parameter_names() if not is_number(getattr(self, name)))

    def acts_in(self) -> np.ndarray | None:
        """Return the numbers of the cells, in arrays of cells, in which this source acts; None for all."""
        return None

    @abstractmethod
    def step(self, model, q, aux, dt):
        """Return the state after a time dt under this source alone."""

    @optional
    def driven(self, model, before, after, bearing, aux, dt):
        """Return the state after dt under this source and a drive that alone takes ``before`` to ``after``."""

    @optional
    def implicit_rate(self, model, q, aux, a):
        """Return S(y) at the state y = q + a S(y), a >= 0 a time, for implicit stages. Optional."""

    @abstractmethod
    def rate(self, model, q, aux):
        """Return dq/dt due to this source."""


def _rates(value: Any) -> Any:
    if callable(value) and not isinstance(value, type):
        return value
    given = validation.array(value, "rate")
    if given.ndim not in (2, 3):
        raise ValueError(f"`rate` must be a function of x or of (x, t), or have shape (num_eqn, num_cells), got shape "
                         f"{given.shape}")
    return _tuples(given.tolist())


def _tuples(value: Any) -> Any:
    return tuple(map(_tuples, value)) if isinstance(value, list) else value


@attrs.frozen
class Forcing(Source):
    """A given rate of every component, dq/dt = rate(x, t): manufactured solutions, or a prescribed source.

    Second order in time. Changes of masses count as entered: `fvkit.Stats`.

    Parameters
    ----------
    rate : function of x or of (x, t) -> (num_eqn, n), averaged over cells by quadrature, at the middle of each step; or
        (num_eqn, num_cells) cell averages.

    Examples
    --------
    >>> import fvkit as fv
    >>> import numpy as np
    >>> problem = fv.Problem(fv.Burgers(), fv.Grid(0.0, 1.0, 20), lambda x: [0.0 * x], 1.0, boundary=fv.Periodic(),
    ...                      sources=fv.Forcing(lambda x, t: [np.full_like(x, 2.0 * t)]))
    >>> print(f"{fv.solve(problem, fv.WavePropagation(fv.Roe()), backend='numpy').q[-1].mean():.12f}")
    1.000000000000
    """

    turns: ClassVar[bool] = False

    given: Any = attrs.field(alias="rate", converter=_rates, repr=validation.shown)

    def varying(self) -> tuple[tuple[str, bool], ...]:
        return (("given", True),)

    def step(self, model, q, aux, dt):
        return forced(self, q, dt)

    def rate(self, model, q, aux):
        return forced(self, scale(0.0, q), 1.0)


def forced(forcing, q, dt):
    """Return a state after a time dt of a `Forcing`."""
    return combine(1.0, q, dt, forcing.given)


def acted(sources, model, before, after, bearing, aux, dt, reached=None):
    """Return the state after dt under a drive that alone takes ``before`` to ``after``, and under all sources, each `driven`.

    A source is driven by the transport and by the others: by those that went ahead of it as they have acted, by those that
    follow as their rates at ``before`` have it, within the momenta at hand. Where all of them balance the state stays, and
    the whole is of second order. States may have the momenta across behind them, one for each phase. On a steep bottom all
    that happens in its tangent plane, see `fvkit.problem.relief`; a curved one turns the flow at the mean velocity of ``before``
    and ``reached``, the state after dt as a first pass has found it, in which it turns at that of ``before``.
    """
    slopes = slopes_at(model, aux)
    if not slopes:
        return acted_on_map(sources, model, before, after, bearing, aux, dt)
    root, turning = np.sqrt(stretching(slopes)), turnings(model, before, before if reached is None else reached, aux)
    before, after = (stretched(model, state, slopes, root) for state in (before, after))
    bed = model.on_bed(root, turning)
    if turning:
        after = turned_aside(model, after, slopes, root, bed.turning, bearing, dt)
    return unstretched(model, acted_on_map(sources, bed, before, after, bearing, aux, dt), slopes, root)


def acted_on_map(sources, model, before, after, bearing, aux, dt):
    """Return what `acted` does of states whose momenta are those that friction acts on."""
    own, shares, pushed = len(model.conserved), [], after
    for source in sources if len(sources) > 1 else ():
        shares.append((expected if len(before) == own else expected_in_plane)(source, model, before, pushed, aux, dt))
        pushed = add(pushed, shares[-1])
    for k, source in enumerate(sources):
        pushed = after
        for share in shares[k + 1:]:
            pushed = add(pushed, share)
        if len(before) > own:
            end = driven_in_plane(source, model, before, pushed, bearing, aux, dt)
        else:
            end = source.driven(model, before, pushed, bearing, aux, dt)
        after = add(after, subtract(end, pushed))
    return after


def brought(masses: Sequence[int], before: Sequence[Any], after: Sequence[Any]) -> list[tuple[int, Any]]:
    """Return what sources have made of the rows ``masses`` of a state, and the number of each; none that they handed on."""
    return [(k, after[row] - before[row]) for k, row in enumerate(masses) if after[row] is not before[row]]


def expected(source, model, before, after, aux, dt):
    """Return what the rate of a source at ``before`` adds to each momentum in dt, at most its own size and that of its drive."""
    rates, result = source.rate(model, before, aux), [0.0] * len(before)
    for _, momentum in model.phases:
        most = np.abs(before[momentum]) + np.abs(after[momentum] - before[momentum])
        result[momentum] = maximum(minimum(dt * rates[momentum], most), -most)
    return tuple(result)


def expected_in_plane(source, model, before, after, aux, dt):
    """Return the same of states with the momenta across behind them."""
    return turned(source, model, before, before, after,
                  lambda start, end: expected(source, model, start, end, aux, dt), along_only=not source.between_phases)


def with_masses(model, q, masses):
    """Return a state with other masses: what has gone has taken its momentum along, what has come has brought none.

    What the ``step`` of a source of mass returns.
    """
    result, left = list(q), iter(masses)
    for rows, momentum in model.phases:
        for row in rows:
            result[row] = next(left)
        before, after = q[rows[-1]], result[rows[-1]]
        result[momentum] = q[momentum] * where(after < before, after / where(before > 0.0, before, 1.0), 1.0)
    return tuple(result)


def mass_rates(model, q, gain, loss, drained):
    """Return dq/dt of a source of mass from the rates at which each mass comes in, and at which it may go.

    Mass goes only where something is left: where ``drained``, the masses less some of what goes, differ from those of q.
    """
    result, rates = [0.0 * component for component in q], iter(zip(gain, loss, drained, strict=True))
    for rows, momentum in model.phases:
        for row in rows:
            comes, goes, least = next(rates)
            result[row] = comes - where(least < q[row], goes, 0.0)
        mass = q[rows[-1]]
        result[momentum] = minimum(result[rows[-1]], 0.0) * (q[momentum] / where(mass > 0.0, mass, 1.0))
    return tuple(result)
