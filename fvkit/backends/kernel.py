"""Abstract kernel: padded states, ghost cells and given functions, shared by all backends."""

from abc import ABC, abstractmethod
from typing import Any, ClassVar

import attrs
import numpy as np

from fvkit.backends.march import March, Outcome
from fvkit.backends.numpy_stages import Runner
from fvkit.backends.plan import Plan, plan
from fvkit.problem import fields
from fvkit.problem.boundary import BoundaryCondition
from fvkit.problem.grid import Side
from fvkit.problem.model import Model, aux_rows
from fvkit.problem.problem import Problem
from fvkit.schemes.scheme import NET, Parts, Scheme


class Kernel(ABC):
    """Abstract backend: runs the stages of one scheme for one problem. Contract:

    1. States are padded arrays (num_eqn, halo + num_cells + halo), made by `padded`; a kernel owns none. ``aux`` holds the
       given functions on the cells of the grid, not copied if there is one, and behind them the fields of sources,
       see `set_fields`; ``aux_edges`` those of the ghost cells.
    2. `advance` takes accepted steps only: a step above the scheme's largest Courant number, or with a state that is
       not finite or has a negative mass, leaves ``march.now`` and ``march.t`` untouched.
    3. Ghost cells are filled before the transport of a step; sources act on the cells of the grid alone.
    """

    name: ClassVar[str]
    compile_seconds: float = 0.0

    def __init__(self, problem: Problem, scheme: Scheme, parts: Parts) -> None:
        self.problem, self.scheme, self.parts = problem, scheme, parts
        self.plan, self.source_plan = plans(scheme, parts)
        self.halo, self.cells = self.plan.halo, problem.grid.num_cells
        if self.cells < self.halo:
            raise ValueError(f"`num_cells` must be >= {self.halo} for this scheme, got {self.cells}")
        self.mass_rows = list(problem.model.mass_rows())
        self.closed = problem.ends[0].reads == "opposite"
        self.ghosts = tuple(ghosts_and_seen(end.reads, Side(0, upper), self.halo, self.cells)
                            for end, upper in zip(problem.ends, (False, True), strict=True))
        rows = aux_rows(problem.model, problem.aux_averages)
        self.aux = rows[0][None] if len(rows) == 1 else np.array(rows).reshape(len(rows), self.cells)
        self.aux_edges = np.concatenate([self._outside(*side) for side in zip(problem.ends, self.ghosts, strict=True)], axis=1)
        if problem.fields:
            behind = fields.averages(problem.fields, problem.t_start)
            self.aux = np.concatenate([self.aux, behind])
            self.aux_edges = np.concatenate([self.aux_edges, behind[:, self._seen_by_ghosts()]])
        self._slices = [tuple(as_slice(cells) for cells in pair) for pair in self.ghosts]
        self._layers = np.arange(self.halo, 0, -1.0), np.arange(1.0, self.halo + 1.0)
        self._values = self.ghost_values(problem.t_start) if self.steady_boundary else None
        if problem.background_averages is not None:
            self._add_background(problem.background_averages)
        self.aux, self.aux_edges = np.ascontiguousarray(self.aux), np.ascontiguousarray(self.aux_edges)  # as the loop takes them

    def padded(self, q: np.ndarray) -> np.ndarray:
        """Return a copy of q (rows, *grid.shape) with room for ghost cells."""
        result = np.zeros((len(q), *(cells + 2 * self.halo for cells in q.shape[1:])))
        self.inside(result)[:] = q
        return result

    def inside(self, padded: np.ndarray) -> np.ndarray:
        """View of the cells of the grid."""
        return padded[(slice(None), *(slice(self.halo, cells - self.halo) for cells in padded.shape[1:]))]

    def padded_aux(self) -> np.ndarray:
        """The given functions on cells and ghost cells."""
        return np.concatenate([self.aux_edges[:, :self.halo], self.aux, self.aux_edges[:, self.halo:]], axis=1)

    def fill_ghosts(self, q: np.ndarray, t: float) -> None:
        """Fill the ghost cells of a padded state."""
        model = self.parts.model
        given = self._given_values = self.ghost_values(t) if self._values is None else self._values
        for side, (ghosts, seen), numbers, values in zip(self.problem.ends, self._slices, self._layers, given, strict=True):
            for row, component in zip(q, side.ghost(model, tuple(q[:, seen]), side.layer(values, numbers)), strict=True):
                row[ghosts] = component

    def _seen_by_ghosts(self) -> list[int]:
        """The cells of the grid that all ghost cells copy, from left to right."""
        return [cell for ghosts, seen in self.ghosts for cell in _within(seen, self.halo, len(ghosts))]

    def set_fields(self, t: float) -> None:
        """Set what sources have as fields over the grid to time t."""
        rows, first = fields.averages(self.problem.fields, t), len(self.problem.model.aux)
        here = slice(first, first + len(rows))
        self.aux[here], self.aux_edges[here] = rows, rows[:, self._seen_by_ghosts()]

    def _add_background(self, averages: np.ndarray) -> None:
        """Add the rows of the background that the scheme needs behind the given functions."""
        problem, halo = self.problem, self.halo
        flow, aux = self.padded(averages), self.padded_aux()
        with np.errstate(all="ignore"):
            self.fill_ghosts(flow, problem.t_start)
            given = problem.background
            at_faces = np.asarray(given(problem.grid.edges), dtype=float) if callable(given) else None
            rows = self.scheme.background(self.parts, flow, aux, at_faces)
            fields = {"q": tuple(flow), "aux": tuple(np.concatenate([aux, rows]))}
            net = Runner(self.parts, self.plan, {self.cells}).run(fields, self.cells, 0.0)[NET]
        rows = self.scheme.completed(rows, self.padded(np.array([np.broadcast_to(row, self.cells) for row in net])))
        whole = np.concatenate([aux, rows])
        self.aux, self.aux_edges = self.inside(whole).copy(), np.concatenate([whole[:, :halo], whole[:, -halo:]], axis=1)

    def _outside(self, end: BoundaryCondition, cells: tuple[range, range]) -> np.ndarray:
        """The given functions on the ghost cells of one side."""
        ghosts, seen = cells
        near = np.array(_within(seen, self.halo, len(ghosts)))
        distance = np.abs(np.array(ghosts) - self.halo - near) * self.problem.grid.dx
        return np.asarray(end.ghost_aux(self.problem.model, self.aux[:, near], distance), dtype=float)

    def ghost_values(self, t: float) -> tuple[tuple[float, ...], ...]:
        """What the boundary conditions of both sides give to their ``ghost`` at time t."""
        return tuple(side.values(self.parts.model, t) for side in self.problem.ends)

    def restarted(self) -> None:
        """Drop cached properties of the state after it was replaced; nothing by default."""
        return

    @property
    def book_rows(self) -> int:
        """Rows of the books of masses: both ends of each axis, then sources: with one axis all together, with two each of those
        beside the transport."""
        return 3

    @property
    def books(self) -> tuple[int, int]:
        """Shape of the books of masses, see `March.masses`."""
        return self.book_rows, max(len(self.mass_rows), 1)

    @property
    def steady_boundary(self) -> bool:
        """Whether `ghost_values` is the same at all times."""
        return all(side.steady for side in self.problem.ends)

    @property
    def steady(self) -> bool:
        """Whether all steps are alike: neither boundary conditions nor sources depend on time."""
        return self.steady_boundary and self.steady_fields

    @property
    def steady_fields(self) -> bool:
        """Whether the fields of sources are the same at all times."""
        return all(field.steady for field in self.problem.fields)

    @abstractmethod
    def advance(self, march: March, target: float, max_steps: int) -> Outcome:
        """Take accepted steps until ``march.t == target``, exactly, or at most ``max_steps`` of them."""


def ghosts_and_seen(reads: str, side: Side, halo: int, n: int) -> tuple[range, range]:
    """Return the ghost cells of one side of n cells, and for each the cell that it copies."""
    ghosts = range(halo + n, n + 2 * halo) if side.upper else range(halo)
    if reads == "opposite":
        return ghosts, range(halo, 2 * halo) if side.upper else range(n, n + halo)
    if reads == "mirror":
        return ghosts, range(halo + n - 1, n - 1, -1) if side.upper else range(2 * halo - 1, halo - 1, -1)
    edge = halo + n - 1 if side.upper else halo
    return ghosts, range(edge, edge + 1)


def imposed(end: BoundaryCondition, model: Model, values: Any) -> tuple[Any, ...]:
    """Return the flux of each mass that a boundary condition sets by itself; () where it leaves that to the Riemann solver."""
    if end.closed:
        return (0.0,) * len(model.mass_rows())
    return end.mass_fluxes(model, values) if end.defines("mass_fluxes") else ()


def plans(scheme: Scheme, parts: Parts) -> tuple[Plan, Plan | None]:
    """Return the plans of a scheme's stages and of its implicit sources, None without, with one halo for both."""
    transport, sources = plan(scheme.stages(parts)), scheme.source_stages(parts)
    if not sources:
        return transport, None
    implicit = plan(sources)
    halo = max(transport.halo, implicit.halo)
    return attrs.evolve(transport, halo=halo), attrs.evolve(implicit, halo=halo)


def as_slice(cells: range) -> slice:
    """The slice of the same cells; none of ours ends at index 0 going down."""
    return slice(cells.start, cells.stop if cells.stop >= 0 else None, cells.step)


def _within(seen: range, halo: int, count: int) -> list[int]:
    """Cells of the grid, counted from its first, that ``count`` ghost cells copy."""
    return [cell - halo for cell in seen] * (count // len(seen))
