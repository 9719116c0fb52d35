"""Status and statistics of a run, and the exceptions that contain its partial solution."""

from enum import Enum
from typing import Any

import attrs
import numpy as np

from fvkit.validation import Portable


class Status(Enum):
    """Outcome of a run; the value of each member is a sentence for messages.

    Examples
    --------
    >>> import fvkit as fv
    >>> fv.Status.FINISHED.name, fv.Status.FINISHED.value
    ('FINISHED', 'the end time was reached')
    """

    FINISHED = "the end time was reached"
    MAX_STEPS = "the number of steps reached its limit, max_steps, before the end time"
    STOPPED = "the run was stopped by its rule"
    OVER_BUDGET = "the stepping took longer than its limit of `seconds`"
    DT_TOO_SMALL = "the time step became too small: the speeds grow without bound"
    DT_TOO_LARGE = "the given `dt` is longer than the Courant number of the scheme allows: give a shorter one, or `dt_max`"
    NON_FINITE = "a state became infinite or not a number"
    WRONG_SPEED = "a wave speed is infinite or not a number, or 0 where the state moves: `wave_speeds` of the model is wrong"
    NEGATIVE_DEPTH = "a mass became negative"
    INADMISSIBLE = "a state left what the model allows"
    INTERRUPTED = "the run was interrupted"
    ERROR = "an exception ended the run"
    NONHYPERBOLIC = "the characteristic speeds became complex (nonhyperbolic='raise')"


@attrs.frozen
class Stats:
    """Statistics of a run.

    Parameters
    ----------
    steps, rejected : numbers of accepted and rejected steps.
    cell_updates : cells x (accepted + rejected steps).
    seconds, compile_seconds : wall time of the stepping and of compilation, s.
    max_cfl : largest Courant number of an accepted step.
    backend : name of the backend.
    nonhyperbolic_faces : number of (face, step) pairs whose Roe mean has complex speeds.
    nonhyperbolic_films : number of those pairs where the flow is shallower than 5 cm on both sides.
    deepest_nonhyperbolic : largest depth at those pairs, m, to a micrometre; 0 for models without a depth.
    mass_drift : {mass: relative change that neither boundary fluxes nor sources explain}; relative to the total mass of all
        components where this component is initially zero. It is empty, as are the next two, for a model without
        ``phases``, which does not say what its masses are.
    entered_by_sources : {mass: net mass added by sources such as rain}, integrated over the grid.
    entered : mass balance, {side or source: {mass: net mass that came in there}}, negative where more has left: through "left",
        "right" and by "sources", all together; with two axes through "west", "east", "south", "north" and by each source of
        its own, "Rain", "Rain 2", "Drain". Their sum is the change of mass, but for ``mass_drift``.

    Examples
    --------
    >>> import numpy as np
    >>> import fvkit as fv
    >>> import fvkit_granular as gr
    >>> stats = fv.solve(gr.scene("dam-break").problem(gr.ShallowWater, 100), backend="numpy").stats
    >>> stats.backend, stats.max_cfl <= 1.0, abs(stats.mass_drift["h"]) < 1e-14
    ('numpy', True, True)
    >>> pulse = fv.Problem(fv.Advection(1.0), fv.Grid(0.0, 1.0, 10), lambda x: [np.sin(6.28 * x)], 1.0, boundary=fv.Periodic())
    >>> fv.solve(pulse, backend="numpy").stats.mass_drift
    {}
    """

    steps: int
    rejected: int
    cell_updates: int
    seconds: float
    compile_seconds: float
    max_cfl: float
    backend: str
    nonhyperbolic_faces: int
    mass_drift: dict[str, float]
    nonhyperbolic_films: int = 0
    deepest_nonhyperbolic: float = 0.0
    entered_by_sources: dict[str, float] = attrs.field(factory=dict)
    entered: dict[str, dict[str, float]] = attrs.field(factory=dict)

    @property
    def ns_per_cell_step(self) -> float:
        """Wall time per cell and step, ns."""
        return 1e9 * self.seconds / self.cell_updates if self.cell_updates else 0.0


class SolveError(Portable, RuntimeError):
    """Exception of a failed run, with the partial solution.

    Parameters
    ----------
    status : `Status` of the run.
    time, cell, x : time, s, cell and position, m, of the failure; the cell is -1 if the failure belongs to no cell.
    state : invalid state of that cell, (num_eqn,).
    step : number of the failed step.
    names : names of the components of the state.
    across : y of the failure, m, on a grid with two axes.
    solution : the partial `Solution`; None for a `Stepper` used without `solve`.

    Examples
    --------
    >>> import fvkit as fv
    >>> import fvkit_granular as gr
    >>> problem = gr.scene("dam-break").problem(gr.ShallowWater, 100)
    >>> found = fv.solve(problem, limits=fv.Limits(steps=3), backend="numpy", throw=False)
    >>> found.status.name, found.stats.steps
    ('MAX_STEPS', 3)
    """

    def __init__(self, status: Status, time: float, cell: int, x: float, state: np.ndarray, step: int,
                 names: tuple[str, ...], across: tuple[float, ...] = ()) -> None:
        self.status, self.time, self.cell, self.x, self.state, self.step = status, time, cell, x, state, step
        self.across = across
        self.solution: Any = None
        values = ", ".join(f"{name} = {value:.6g}" for name, value in zip(names, state, strict=True))
        place = "".join([f"x = {x:.6g}", *(f", y = {y:.6g}" for y in across)])
        at = f" in cell {cell} ({place}): {values}" if cell >= 0 else ""
        super().__init__(f"{status.value}, at t = {time:.8g}, step {step}{at}")


class Interrupted(SolveError, KeyboardInterrupt):
    """Exception of a run interrupted by Ctrl-C: a `SolveError` with the partial solution, and a KeyboardInterrupt.

    Examples
    --------
    >>> import fvkit as fv
    >>> issubclass(fv.Interrupted, fv.SolveError) and issubclass(fv.Interrupted, KeyboardInterrupt)
    True
    """
