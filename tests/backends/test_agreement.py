"""Both backends compute the same: every pair of parts is covered, after 200 steps to 1e-12."""

from collections.abc import Callable, Iterator, Mapping
from itertools import combinations, product
from typing import Any

import attrs
import numpy as np
import pytest

import fvkit as fv
import fvkit_granular as gr
from fvkit.studies.covering import covering

AXES: dict[str, tuple[str, ...]] = {
    "model": ("two-phase", "reduced", "shallow", "burgers", "advection", "acoustics"), "riemann": ("relaxation", "roe", "hll", "rusanov"),
    "limiter": ("none", "minmod", "superbee", "mc", "van-leer", "third-order"), "order": ("1", "2"),
    "boundary": ("outflow", "wall", "periodic", "inflow", "tide"), "source": ("none", "drag", "drag-godunov", "coulomb"),
}
MODELS = {"two-phase": gr.TwoPhase(), "reduced": gr.Reduced(gamma=0.4), "shallow": gr.ShallowWater(g=9.0), "burgers": fv.Burgers(),
          "advection": fv.Advection(-1.5), "acoustics": fv.Acoustics(2.0, 3.0)}
RIEMANN = {"relaxation": gr.Relaxation(), "roe": fv.Roe(), "hll": fv.HLL(), "rusanov": fv.Rusanov()}
LIMITERS = {"none": fv.NoLimiter(), "minmod": fv.Minmod(), "superbee": fv.Superbee(), "mc": fv.MC(), "van-leer": fv.VanLeer(),
            "third-order": fv.ThirdOrder()}


def possible(choice: dict[str, str]) -> bool:
    drag = choice.get("source", "none").startswith("drag")
    if choice.get("source") == "coulomb" and choice.get("model", "shallow") not in ("two-phase", "reduced", "shallow"):
        return False
    relaxes = choice.get("model", "two-phase") in ("two-phase", "reduced", "shallow")
    if choice.get("riemann") == "relaxation" and not relaxes:
        return False
    return not (drag and choice.get("model", "two-phase") != "two-phase") and not (
        choice.get("boundary") == "wall" and choice.get("model") in ("burgers", "advection"))


def combinations_that_cover_every_pair() -> Iterator[Mapping[str, str]]:
    """So many combinations that every possible pair of settings of two axes occurs."""
    every = [dict(zip(AXES, values, strict=True)) for values in product(*AXES.values())]
    return covering([choice for choice in every if possible(choice)])


def depth(x: np.ndarray) -> np.ndarray:
    return 1.0 + 0.2 * np.sin(2 * np.pi * x) + np.where(np.abs(x - 0.5) < 0.1, 0.15, 0.0) - bottom(x)


def bottom(x: np.ndarray) -> np.ndarray:
    return 0.1 * np.cos(2 * np.pi * x) + np.where(x > 0.7, 0.05, 0.0)


def initial(model: fv.Model) -> Callable[[np.ndarray], Any]:
    if model.phases:
        return lambda x: model.conserved_from(depth(x), 0.5 + 0.2 * np.cos(2 * np.pi * x), 0.3 + 0.2 * np.sin(2 * np.pi * x), 0.1)
    return lambda x: np.stack([depth(x) * (1.0 + k) for k in range(len(model.conserved))])


def build(choice: dict[str, str]) -> tuple[fv.Problem, fv.WavePropagation]:
    model = MODELS[choice["model"]]
    state = initial(model)(np.array([0.3]))[:, 0]
    boundary = {"outflow": fv.Outflow(), "wall": fv.Wall() if choice["boundary"] == "wall" else None, "periodic": fv.Periodic(),
                "inflow": (fv.Inflow(state), fv.Outflow()),
                "tide": (fv.Outflow(), fv.Inflow(lambda t: state * (1.0 + 0.05 * np.sin(40 * t))))}[choice["boundary"]]
    sources = {"none": (), "coulomb": gr.CoulombFriction(0.3)}.get(choice["source"], gr.ConstantDrag(5.0))
    problem = fv.Problem(model, fv.Grid(0.0, 1.0, 700), initial(model), 10.0, aux={"b": bottom} if model.aux else {},
                         boundary=boundary, sources=sources)
    splitting = fv.Godunov() if choice["source"] == "drag-godunov" else fv.Strang()
    return problem, fv.WavePropagation(RIEMANN[choice["riemann"]], limiter=LIMITERS[choice["limiter"]], order=int(choice["order"]),
                                       splitting=splitting, in_cell_shocks="shocks" in choice)


def with_in_cell_shocks(cases: list[Mapping[str, str]]) -> Iterator[Mapping[str, str]]:
    """So many of the cases that every setting occurs, now with in-cell shocks."""
    left = {setting for choice in cases for setting in choice.items()}
    while left:
        best = max(cases, key=lambda choice: len(choice.items() & left))
        left -= best.items()
        yield {**best, "shocks": "in-cell"}


CASES = list(combinations_that_cover_every_pair())
IN_CELL = list(with_in_cell_shocks(CASES))


@pytest.mark.parametrize("choice", [*CASES, *IN_CELL], ids=lambda choice: "-".join(choice.values()))
def test_compiled_equals_numpy_after_200_steps(choice):
    steppers = [fv.Stepper(*build(choice), backend=backend, nonhyperbolic="ignore") for backend in ("numba", "numpy")]
    for stepper in steppers:
        for _ in range(200):
            stepper.step()
    compiled, plain = steppers
    assert compiled.t == pytest.approx(plain.t, rel=1e-12)
    assert np.abs(compiled.q - plain.q).max() <= 1e-12 * np.abs(plain.q).max()
    one, other = compiled.stats(), plain.stats()
    assert (one.backend, other.backend) == ("numba", "numpy")
    assert (one.steps, one.rejected, one.nonhyperbolic_faces) == (other.steps, other.rejected, other.nonhyperbolic_faces)
    assert one.mass_drift == pytest.approx(other.mass_drift, abs=1e-13)


def test_the_cases_cover_every_possible_pair_and_stay_few():
    assert len(CASES) <= 45
    seen = set().union(*(set(combinations(choice.items(), 2)) for choice in CASES))
    for (one, first), (two, second) in combinations([(axis, value) for axis in AXES for value in AXES[axis]], 2):
        if one != two and possible({one: first, two: second}):
            assert ((one, first), (two, second)) in seen


def receding() -> fv.Problem:
    def flow(x: np.ndarray) -> np.ndarray:
        return gr.Reduced().conserved_from(np.where(x < 0, 1e-3, 3.0), 0.5, np.where(x < 0, -20.0, 20.0), np.where(x < 0, -20.0, 20.0))

    return fv.Problem(gr.Reduced(), fv.Grid(-1.0, 1.0, 60), flow, 0.05)


def slipping() -> fv.Problem:
    return fv.Problem(gr.TwoPhase(), fv.Grid(0.0, 1.0, 1200), lambda x: gr.TwoPhase().conserved_from(
        1.0, 0.6, np.where(x > 0.55, 4.0, 0.0), 0.0), 1e-3, boundary=fv.Periodic())


@attrs.frozen
class Brittle(fv.Model):
    """Advection whose flux is no number above u = 2."""

    conserved = ("u",)

    def flux(self, q):
        return (q[0] + 1e-300 * np.sqrt(2.0 - q[0]),)

    def wave_speeds(self, q):
        return 1.0 + 0.0 * q[0], 1.0 + 0.0 * q[0]


@attrs.frozen
class Growth(fv.Source):
    """u_t = u."""

    def step(self, model, q, aux, dt):
        return (q[0] * np.exp(dt),)

    def rate(self, model, q, aux):
        return q


def test_a_run_that_turns_nan_half_way_fails_the_same_way():
    start = np.where(np.arange(60) == 41, 1.3, 1.0)[None]
    problem = fv.Problem(Brittle(), fv.Grid(0.0, 1.0, 60), start, 5.0, boundary=fv.Periodic(), sources=Growth())
    ends = [fv.solve(problem, fv.WavePropagation(fv.HLL(), limiter=fv.Minmod()), backend=backend, throw=False)
            for backend in ("numba", "numpy")]
    assert ends[0].status is ends[1].status is fv.Status.NON_FINITE
    assert ends[0].stats.steps == ends[1].stats.steps > 10
    assert ends[0].message == ends[1].message
    assert np.isfinite(ends[0].q).all()


def test_roe_falls_back_near_vacuum_alike_on_both_backends():
    ends = [fv.solve(receding(), fv.WavePropagation(fv.Roe()), backend=backend, nonhyperbolic="ignore").q[-1]
            for backend in ("numba", "numpy")]
    assert min(end[row].min() for end in ends for row in (0, 1)) > 0.0
    assert np.abs(ends[0] - ends[1]).max() < 1e-11 * np.abs(ends[1]).max()


@pytest.mark.parametrize("solver", [fv.Roe(), fv.HLL()], ids=["roe", "hll"])
def test_lost_hyperbolicity_is_counted_warned_about_and_raised_alike(solver):
    scheme, counts, places = fv.WavePropagation(solver, order=1), [], []
    for backend in ("numba", "numpy"):
        with pytest.warns(RuntimeWarning, match="speeds are complex from t = 0 on") as caught:
            solution = fv.solve(slipping(), scheme, backend=backend, throw=False)
        counts.append(solution.stats.nonhyperbolic_faces)
        places.append(str(caught[0].message))
        stopped = fv.solve(slipping(), scheme, backend=backend, throw=False, nonhyperbolic="raise")
        assert stopped.status is fv.Status.NONHYPERBOLIC
        assert stopped.stats.steps == 0
    assert counts[0] == counts[1] > 100
    assert places[0] == places[1]


def test_output_times_and_max_steps_are_the_same():
    problem = gr.scene("dam-break").problem(gr.TwoPhase, 300)
    times = [0.1, 0.2345, 0.5]
    runs = [fv.solve(problem, times=times, backend=backend) for backend in ("numba", "numpy")]
    assert runs[0].t.tolist() == runs[1].t.tolist() == [0.0, *times]
    assert runs[0].stats.steps == runs[1].stats.steps
    assert np.abs(runs[0].q - runs[1].q).max() < 1e-12
    short = fv.solve(problem, backend="numba", limits=fv.Limits(steps=7), throw=False)
    assert short.status is fv.Status.MAX_STEPS
    assert short.stats.steps == 7


def test_step_by_step_is_bit_identical_to_a_compiled_run():
    problem = gr.scene("riemann").problem(gr.TwoPhase, 300)
    stepper = fv.Stepper(problem, backend="numba")
    while stepper.t < problem.t_end:
        stepper.step()
    whole = fv.solve(problem, backend="numba")
    observed = fv.solve(problem, backend="numba", observers=[lambda stepper: None])
    assert np.array_equal(stepper.q, whole.q[-1])
    assert np.array_equal(observed.q[-1], whole.q[-1])
    assert stepper.stats().steps == whole.stats.steps


@pytest.mark.parametrize("dt", [1.0, 10.0, 1e3])
@pytest.mark.parametrize("model", [fv.Burgers(), gr.ShallowWater()], ids=lambda model: type(model).__name__)
def test_a_step_that_is_far_too_long_is_shortened_though_its_later_stages_are_no_numbers(model, dt):
    steppers = []
    for backend in ("numba", "numpy"):
        q = np.ones((len(model.conserved), 100))
        q[0, :50], q[1:] = 2.0, 0.0
        stepper = fv.Stepper(fv.Problem(model, fv.Grid(0.0, 10.0, 100), q, 1e6), fv.MethodOfLines(fv.HLL()), backend=backend)
        snapshot = stepper.snapshot()
        snapshot["real"][1] = dt  # the length of the next step
        stepper.restore(snapshot)
        stepper.step()
        steppers.append(stepper)
    compiled, plain = steppers
    assert compiled.stats().rejected == plain.stats().rejected >= 2
    assert compiled.t == pytest.approx(plain.t, rel=1e-12)
    np.testing.assert_allclose(compiled.q, plain.q, rtol=0.0, atol=1e-12)
