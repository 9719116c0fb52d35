"""Time loop in Python: trial steps, acceptance and retries."""

from abc import abstractmethod
from collections.abc import Iterable, Sequence
from math import isfinite
from typing import NamedTuple

import numpy as np

from fvkit.backends.kernel import Kernel
from fvkit.backends.march import FILM, MICRO, March, Outcome
from fvkit.backends.step_length import shortened, step_length


class LostFaces(NamedTuple):
    """How many faces lost hyperbolicity, how many of them in films, and the depth of the deepest, in whole micrometres."""

    faces: int = 0
    films: int = 0
    deepest: int = 0

    def more(self, depths: np.ndarray | None, count: int) -> "LostFaces":
        """Return the sum with so many faces of these depths, in micrometres; None for a model without a depth."""
        if depths is None:
            return self._replace(faces=self.faces + count)
        films = int(np.count_nonzero(depths < FILM * MICRO))
        return LostFaces(self.faces + count, self.films + films, max(self.deepest, int(np.max(depths, initial=0.0))))


def together(every: Iterable[LostFaces]) -> LostFaces:
    """Return the sum of several counts."""
    faces, films, deepest = zip(*every, strict=True)
    return LostFaces(sum(faces), sum(films), max(deepest))


def counted(found: Sequence[np.ndarray]) -> tuple[LostFaces, int]:
    """Return what compiled code has counted on each thread, see `Scratch`, added up, and the first of the faces."""
    firsts = [int(item[1]) for item in found if item[1] >= 0]
    return together(LostFaces(*item[[0, 2, 3]].tolist()) for item in found), min(firsts, default=-1)


class SweepOutcome(NamedTuple):
    """What a sweep reports.

    Attributes
    ----------
    speed : largest speed at any face, NaN if any is.
    flux : (2, masses) mass fluxes through both ends, or sides, summed over the cells along them.
    bad : whether a state of the last sweep of a step may not be accepted, where the sweep `settles`.
    lost, lost_cell : faces that lost hyperbolicity, and the first of them, or with two axes the number of the cell behind it.
    """

    speed: float
    flux: np.ndarray
    lost: LostFaces = LostFaces()
    lost_cell: int = -1
    bad: bool = False


class Trial(NamedTuple):
    """What a trial step reports.

    Parameters
    ----------
    max_speed : largest speed at any face, NaN if any is.
    good : whether the new state is finite, without negative masses, and admissible.
    flux : (2 times axes, masses) mass fluxes through the ends of each axis, along it.
    brought : (sources, masses) what sources have added to each mass, summed over the cells; with one axis all of them together.
    lost, lost_face : faces that lost hyperbolicity, and the first of them.
    """

    max_speed: float
    good: bool
    flux: np.ndarray
    brought: np.ndarray
    lost: LostFaces
    lost_face: int


class StepwiseKernel(Kernel):
    """A kernel whose time loop runs in Python; a subclass makes one trial step."""

    @property
    def dx(self) -> float:
        """Length to which speeds refer, m: of a cell."""
        return self.problem.grid.dx

    @property
    def volume(self) -> float:
        """Length or area of a cell."""
        return self.problem.grid.cell_volume

    def length(self, march: March, dt: float, target: float) -> tuple[float, bool]:
        """Return the length of the next step, and whether it is the last before the target."""
        return step_length(march.t, dt, target)

    def following(self, march: March, dt: float, longest: float) -> float:
        """Return the length of the step after one of length dt."""
        return longest

    @abstractmethod
    def trial(self, march: March, dt: float) -> Trial:
        """Write the state after dt into ``march.next``."""

    def advance(self, march: March, target: float, max_steps: int) -> Outcome:
        for _ in range(max_steps):
            if march.t >= target:
                break
            outcome = self._step(march, target)
            if outcome is not Outcome.PAUSED:
                return outcome
        return Outcome.REACHED if march.t >= target else Outcome.PAUSED

    def _step(self, march: March, target: float) -> Outcome:
        """Take one accepted step. Ctrl-C leaves no trace of one that is not whole, but for the count of lost faces."""
        dx, scheme, t = self.dx, self.scheme, march.t
        dt, last = self.length(march, march.dt, target)
        rejected, outcome = 0, Outcome.NO_STEP
        while rejected < march.retries and (last or t + dt != t):
            report = self.trial(march, dt)
            cfl = report.max_speed * dt / dx
            if not isfinite(cfl) or cfl <= scheme.cfl_max:
                outcome = Outcome.PAUSED if isfinite(cfl) and report.good else Outcome.BAD_STATE
                break
            rejected += 1
            dt, last = shortened(dt, cfl, scheme.cfl), False
            if not self.steady:
                dt, last = self.length(march, dt, target)
        if outcome is not Outcome.PAUSED:
            march.refuse(dt, rejected)
            return outcome
        if report.lost.faces:
            if not march.lost:
                march.lost_face, march.lost_time = report.lost_face, t
            march.lost += report.lost.faces
            march.films += report.lost.films
            march.deepest = max(march.deepest, report.lost.deepest)
            if march.stop_when_lost:
                march.refuse(dt, rejected)
                return Outcome.LOST_HYPERBOLICITY
        following = scheme.cfl * dx / report.max_speed if report.max_speed > 0.0 else np.inf
        following = self.following(march, dt, following)
        passed = np.concatenate([dt * report.flux, self.volume * report.brought])
        march.accept(target if last else t + dt, march.bounded(following), cfl, rejected, passed)
        return Outcome.PAUSED
