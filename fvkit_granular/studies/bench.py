"""`bench`: nanoseconds per cell and step against the number of cells, for every model, solver, backend and order."""

import json
import time
from collections.abc import Callable, Sequence
from importlib.util import find_spec
from itertools import product
from math import isqrt
from pathlib import Path
from statistics import median
from typing import Any, NamedTuple

import attrs
import numpy as np
from matplotlib.figure import Figure

import fvkit as fv
from fvkit import RiemannSolver, Scheme, validation
from fvkit.backends.compiled.numba_kernel import available
from fvkit.output.figures import legend_below, new_axes, save_all, style
from fvkit.pointwise.part import public_name
from fvkit.problem.directions import in_plane
from fvkit.run.interruption import keeping
from fvkit.studies.report import environment
from fvkit.studies.tables import table
from fvkit_granular.models.reduced import Reduced
from fvkit_granular.models.relaxation import Relaxation
from fvkit_granular.models.shallow_water import ShallowWater
from fvkit_granular.models.two_phase import TwoPhase
from fvkit_granular.studies.bench_pyclaw import pyclaw_runs, pyclaw_runs_in_the_plane

#: Orders that can be measured; 5 is one stage of the method of lines, MP5.
ORDERS = (1, 2, 5)

#: A timed block takes about this long, s, and at least this many steps.
BLOCK, LEAST_STEPS = 0.05, 3

#: Models and solvers that are measured with two axes.
IN_THE_PLANE = ((ShallowWater(), fv.Roe()), (TwoPhase(), Relaxation()))

Run = Callable[[int], float]


class Case(NamedTuple):
    """What is measured: everything but the number of cells."""

    model: str
    riemann: str
    order: int
    backend: str
    axes: int = 1

    @property
    def label(self) -> str:
        """For legends."""
        return f"{self.model} {self.riemann}, order {self.order}, {self.backend}"

    def size(self, cells: int) -> str:
        """How many cells, in words: with two axes "300 x 300" of 90000."""
        return f"{cells}" if self.axes == 1 else " x ".join([f"{isqrt(cells)}"] * 2)


def flow(model: Any, cells: int) -> fv.Problem:
    """Smooth periodic waves over a smooth bottom, with slip where the model has it: no cell is constant."""
    def initial(x: np.ndarray) -> np.ndarray:
        h = 1.0 + 0.4 * np.exp(-100.0 * (x - 0.4) ** 2) - bottom(x)
        return model.conserved_from(h, 0.5 + 0.2 * np.sin(2.0 * np.pi * x), 0.1, -0.1)

    return fv.Problem(model, fv.Grid(0.0, 1.0, cells), initial, 1e9, aux={"b": bottom}, boundary=fv.Periodic())


def flow_in_the_plane(model: Any, cells: int) -> fv.Problem:
    """The same waves on a square of cells x cells, bent so that nothing is constant along either axis, over the same bottom."""
    def initial(x: np.ndarray, y: np.ndarray) -> np.ndarray:
        h = 1.0 + 0.4 * np.exp(-100.0 * ((x - 0.4) ** 2 + (y - 0.5) ** 2)) - bottom(x)
        phi = 0.5 + 0.2 * np.sin(2.0 * np.pi * (x + y))
        return in_plane(model, model.conserved_from(h, phi, 0.1, -0.1), model.conserved_from(h, phi, -0.1, 0.1))

    return fv.Problem(model, fv.Grid((0.0, 0.0), (1.0, 1.0), (cells, cells)), initial, 1e9, aux={"b": lambda x, y: bottom(x)},
                      boundary=fv.Periodic())


def bottom(x: np.ndarray) -> np.ndarray:
    """Return 0.1 sin(2 pi x)."""
    return 0.1 * np.sin(2.0 * np.pi * x)


def stepping(problem: fv.Problem, riemann: RiemannSolver, order: int, backend: str) -> Run:
    """Return a function that takes k steps and returns the seconds per step, of order 5 per stage, stepping alone."""
    scheme: Scheme = fv.MethodOfLines(riemann) if order == 5 else fv.WavePropagation(riemann, order=order)
    stages = 1 if scheme.time_integrator is None else len(scheme.time_integrator.beta)
    stepper = fv.Stepper(problem, scheme, backend=backend, nonhyperbolic="ignore")

    def run(steps: int) -> float:
        before = stepper.stats().seconds
        stepper.run(np.inf, steps)
        return (stepper.stats().seconds - before) / steps / stages

    return run


def measure(runs: dict[Case, Run], cells: int, repeats: int) -> list[dict[str, Any]]:
    """Time all runs, interleaved, after a warm-up; return one row each."""
    steps = {}
    for case, run in runs.items():
        run(LEAST_STEPS)
        steps[case] = max(LEAST_STEPS, int(BLOCK / run(LEAST_STEPS)))
    times: dict[Case, list[float]] = {case: [] for case in runs}
    for _ in range(repeats):
        for case, run in runs.items():
            times[case].append(run(steps[case]))
    return [{**case._asdict(), "cells": cells, "steps": steps[case], "ns_per_cell_step": 1e9 * median(values) / cells,
             "ns_per_cell_step_min": 1e9 * min(values) / cells} for case, values in times.items()]


@attrs.frozen
class Bench:
    """Result of a benchmark: rows, and where they were measured."""

    rows: list[dict[str, Any]] = attrs.field(repr=lambda rows: f"<{len(rows)} rows>")
    machine: dict[str, Any]
    versions: dict[str, str]

    def series(self) -> dict[Case, list[dict[str, Any]]]:
        """Rows that differ only in their number of cells."""
        result: dict[Case, list[dict[str, Any]]] = {}
        for row in self.rows:
            result.setdefault(Case(**{field: row[field] for field in Case._fields if field in row}), []).append(row)
        return result

    def ratios(self) -> list[str]:
        """Return PyClaw's time over ours for shallow water, then that of a stage of order 5 over a second-order step with Roe."""
        pyclaw, stages = [], []
        for case, rows in self.series().items():
            ours = Case("shallow-water", "roe", case.order, "numba", case.axes)
            if case.backend == "pyclaw":
                pyclaw.append(f"PyClaw ({case.riemann}, order {case.order}) over our compiled Roe: "
                              f"{self._over(rows, ours, 1)} cells")
            elif case.order == 5 and (found := self._over(rows, case._replace(riemann="roe", order=2), 2)):
                stages.append(f"{case.label}: a stage over a second-order Roe step: {found} cells")
        return pyclaw + stages

    def _over(self, rows: list[dict[str, Any]], other: Case, digits: int) -> str:
        known = {row["cells"]: row["ns_per_cell_step"] for row in self.series().get(other, [])}
        return ", ".join(f"{row['ns_per_cell_step'] / known[row['cells']]:.{digits}f} at {other.size(row['cells'])}"
                         for row in rows if row["cells"] in known)

    def table(self) -> str:
        """Return one line per case, a column per number of cells: median, in brackets minimum; two axes behind one."""
        parts = [text for axes in (1, 2) for text in self._lines(axes)]
        versions = ", ".join(f"{name} {number}" for name, number in self.versions.items())
        machine = f"{self.machine['processor']}, one thread; {versions}"
        note = "median (minimum) of interleaved repeats, stepping only"
        return "\n".join([*parts, note, machine, *self.ratios()])

    def _lines(self, axes: int) -> list[str]:
        """The table of cases with so many axes, and an empty line; nothing without any."""
        series = {case: rows for case, rows in self.series().items() if case.axes == axes}
        cells = sorted({row["cells"] for rows in series.values() for row in rows})
        lines = []
        for case, rows in series.items():
            found = {row["cells"]: f"{row['ns_per_cell_step']:.1f} ({row['ns_per_cell_step_min']:.1f})" for row in rows}
            lines.append([case.label, *(found.get(count, "-") for count in cells)])
            head = ["ns per cell and step", *(f"N = {case.size(count)}" for count in cells)]
        return [table([head, *lines], left=1), ""] if lines else []

    def plot(self) -> Figure:
        """Return the picture: a panel per model and number of axes; none for a single grid where others have several."""
        several = any(len(rows) > 1 for rows in self.series().values())
        models = list(dict.fromkeys((case.model, case.axes) for case, rows in self.series().items() if len(rows) > several))
        figure, axes = new_axes(1, len(models), width=4.6, height=4.6)
        solvers = list(dict.fromkeys(case.riemann for case in self.series()))
        for ax, (model, count) in zip(axes, models, strict=True):
            for case, rows in self.series().items():
                if (case.model, case.axes) == (model, count):
                    dash = {"numba": "-", "numpy": "--"}.get(case.backend, ":")
                    look = style(solvers.index(case.riemann)) | {"linestyle": dash}
                    ax.loglog([row["cells"] for row in rows], [row["ns_per_cell_step"] for row in rows], **look, markersize=4,
                              linewidth=2.0 if case.order == 2 else 0.9,
                              label=f"{case.riemann}, order {case.order}, {case.backend}")
            ax.set(title=model if count == 1 else f"{model}, two axes", xlabel="cells", ylabel="ns per cell and step")
            ax.grid(which="major", alpha=0.35)
        legend_below(figure, axes, 4, "x-small")
        return figure

    def save(self, folder: str | Path) -> Path:
        """Write bench.json and bench.png into ``folder``, which is made if missing."""
        document = {"machine": self.machine, "versions": self.versions, "rows": self.rows}
        return save_all(folder, {"bench.json": json.dumps(document, indent=1), "bench.png": self.plot()})


def bench(cells: Sequence[int] = (100, 1000, 10_000, 100_000), orders: Sequence[int] = (1, 2),
          backends: Sequence[str] | None = None, repeats: int = 5, progress: Callable[[str], None] | None = None, *,
          plane: Sequence[int] = ()) -> Bench:
    """Measure every model, solver, backend and order at every number of cells, interleaved; with two axes some of them.

    Parameters
    ----------
    cells, orders : what to measure; order 5 is a stage of `fvkit.MethodOfLines`.
    backends : ``"numba"`` and ``"numpy"``; default: those that are installed.
    repeats : timed blocks of each, of about 0.05 s.
    progress : function that receives a line of text now and then.
    plane : numbers of cells along each axis of a square, on which shallow water with Roe and two phases with Relaxation are
        measured too, at orders 1 and 2 where these are among ``orders``.

    Returns
    -------
    Bench
        PyClaw's Fortran solvers for shallow water are measured in the same run where ``clawpack`` is installed.

    Raises
    ------
    KeyboardInterrupt
        After Ctrl-C; its attribute ``result`` is the Bench of the numbers of cells that are done, None where there are none.
    """
    tell = progress or (lambda line: None)
    for order in orders:
        validation.choice(order, "orders", ORDERS)
    chosen = backends or (("numba", "numpy") if available() else ("numpy",))
    rows: list[dict[str, Any]] = []

    def report() -> Bench:
        return Bench(rows, *environment("fvkit", "numpy", "numba", "clawpack"))

    with keeping(lambda: report() if rows else None):
        for axes, counts in ((1, cells), (2, plane)):
            for count in counts:
                rows += _cases(count, axes, orders, chosen, repeats, tell)
    return report()


def _cases(count: int, axes: int, orders: Sequence[int], backends: Sequence[str], repeats: int,
           tell: Callable[[str], None]) -> list[dict[str, Any]]:
    """Measure everything with a number of cells along each axis."""
    solvers = (Relaxation(), fv.Roe(), fv.HLL(), fv.Rusanov())
    pairs = IN_THE_PLANE if axes > 1 else product((TwoPhase(), Reduced(), ShallowWater()), solvers)
    split = [order for order in orders if order < 5]
    runs: dict[Case, Run] = {}
    for model, riemann in pairs:
        for order in orders if axes == 1 else split:
            for backend in backends:
                case = Case(public_name(model), public_name(riemann), order, backend, axes)
                tell(f"N = {case.size(count**axes)}: preparing {case.label}")
                runs[case] = stepping((flow if axes == 1 else flow_in_the_plane)(model, count), riemann, order, backend)
    if find_spec("clawpack") is not None:
        peers = pyclaw_runs(count, split, bottom) if axes == 1 else pyclaw_runs_in_the_plane(count, split)
        runs |= {Case("shallow-water", name, order, "pyclaw", axes): run for (name, order), run in peers.items()}
    tell(f"N = {count}: measuring {len(runs)} cases")
    started = time.perf_counter()
    rows = measure(runs, count**axes, repeats)
    tell(f"N = {count}: {time.perf_counter() - started:.0f} s")
    return rows
