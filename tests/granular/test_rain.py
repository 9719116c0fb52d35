"""Rain and infiltration: masses that sources bring are exact, wet dry ground, count as entered, and never turn negative."""

import attrs
import numpy as np
import pytest

import fvkit as fv
import fvkit_granular as gr
from fvkit.testing import SourceConformance

MODELS = (gr.ShallowWater(), gr.Reduced(), gr.TwoPhase())
SCHEMES = (fv.WavePropagation(gr.Relaxation()), fv.WavePropagation(gr.Relaxation(), splitting=fv.Godunov()),
           fv.MethodOfLines(gr.Relaxation()))

#: The method of lines says that it alternates these sources with the transport.
pytestmark = pytest.mark.filterwarnings("ignore:SSPRK104 alternates:UserWarning")


def box(model, rain, h=0.0, phi=0.3, cells=20, t_end=50.0, **settings):
    """A closed box, dry or with water at rest."""
    initial = model.conserved_from(np.full(cells, h), phi)
    return fv.Problem(model, fv.Grid(0.0, 10.0, cells), initial, t_end, boundary=fv.Wall(), sources=rain, **settings)


def entered(solution):
    return solution.stats.entered_by_sources


def balanced(solution, most=1e-13):
    """Neither the state nor the books have lost anything."""
    assert max(map(abs, solution.stats.mass_drift.values())) < most


@pytest.mark.parametrize("scheme", SCHEMES, ids=["wave", "godunov", "lines"])
@pytest.mark.parametrize("model", MODELS, ids=lambda model: type(model).__name__)
def test_rain_fills_a_closed_box_linearly(model, scheme, backend):
    solution = fv.solve(box(model, gr.Rain(2e-3, phi=0.25), h=0.1), scheme, times=[20.0, 50.0], backend=backend)
    for t, q in zip(solution.t, solution.q, strict=True):
        expected = model.conserved_from(0.1, 0.3) + model.conserved_from(2e-3 * t, 0.25)
        np.testing.assert_allclose(q, np.broadcast_to(expected[:, None], q.shape), rtol=1e-12, atol=1e-15)
    balanced(solution)
    rows = model.mass_rows()
    np.testing.assert_allclose(list(entered(solution).values()), 10.0 * model.conserved_from(0.1, 0.25)[list(rows)], rtol=1e-12)


@pytest.mark.parametrize("model", MODELS, ids=lambda model: type(model).__name__)
def test_rain_wets_dry_ground(model, backend):
    solution = fv.solve(box(model, gr.Rain(2e-3, phi=0.25)), backend=backend)
    np.testing.assert_allclose(solution.q[-1], np.broadcast_to(model.conserved_from(0.1, 0.25)[:, None], solution.q[-1].shape),
                               rtol=1e-12, atol=1e-15)
    balanced(solution)


@pytest.mark.parametrize("model", MODELS, ids=lambda model: type(model).__name__)
def test_infiltration_takes_at_most_the_water_that_is_there(model, backend):
    """What is left are the grains, and not a mass is negative on the way; the books say what has gone."""
    solution = fv.solve(box(model, gr.Rain(-1e-2), h=0.2), times=[5.0, 50.0], backend=backend)
    np.testing.assert_allclose(model.observables(solution.q[1])["h"], 0.15, rtol=1e-12)
    left = solution.q[-1][list(model.mass_rows())]
    assert (left >= 0.0).all()
    grains = 0.0 if isinstance(model, gr.ShallowWater) else 0.06
    expected = {"h": grains, "rho h": grains, "hs": grains, "hf": 0.0}
    for row, name in zip(left, entered(solution), strict=True):
        np.testing.assert_allclose(row, expected[name], atol=1e-15)
    balanced(solution)


def test_water_that_seeps_away_leaves_the_velocity_of_the_rest(backend):
    model = gr.TwoPhase()
    q = model.conserved_from(np.full(20, 1.0), 0.4, 0.7, 1.3)
    problem = fv.Problem(model, fv.Grid(0.0, 10.0, 20), q, 2.0, boundary=fv.Periodic(), sources=gr.Rain(-0.1))
    q = fv.solve(problem, backend=backend).q[-1]
    np.testing.assert_allclose(q[2], 0.4, rtol=1e-12)
    np.testing.assert_allclose(q[3] / q[2], 1.3, rtol=1e-12)
    np.testing.assert_allclose(q[1] / q[0], 0.7, rtol=1e-12)


@pytest.mark.parametrize("scheme", [SCHEMES[0], SCHEMES[2]], ids=["wave", "lines"])
def test_rain_through_open_ends_in_rejected_steps_and_over_a_bottom_is_booked(scheme, backend):
    """Masses pass the ends, steps are rejected: what has come and gone still adds up."""
    model = gr.ShallowWater()
    problem = fv.Problem(model, fv.Grid(0.0, 10.0, 600), lambda x: [np.where(x < 4.0, 1.0, 0.0), 0.0 * x], 0.5,
                         aux={"b": lambda x: 0.2 * np.sin(x)}, sources=(gr.Rain(0.05), gr.Rain(-0.02)))
    solution = fv.solve(problem, scheme, backend=backend)
    balanced(solution)
    assert solution.stats.rejected
    assert 0.15 * (1.0 - 1e-12) < entered(solution)["h"] < 0.25  # dry ground gives nothing to seep away


def test_rain_on_a_slope_tends_to_its_steady_flow(backend):
    """Every place passes what has rained above it, q(x) = r x."""
    rain, grid = 1e-4, fv.Grid(0.0, 50.0, 25)
    problem = fv.Problem(gr.ShallowWater(), grid, lambda x: [0.0 * x, 0.0 * x], 400.0, aux={"b": lambda x: -0.05 * x},
                         boundary=(fv.Wall(), gr.UniformSlope(0.05)), sources=(gr.Rain(rain), gr.Manning(0.03)))
    solution = fv.solve(problem, times=[350.0, 400.0], backend=backend)
    np.testing.assert_allclose(solution.q[-1, 1], rain * grid.centers, rtol=0.0, atol=0.01 * rain * 50.0)
    np.testing.assert_allclose(solution.q[1, 0].sum(), solution.q[2, 0].sum(), rtol=1e-6)  # what rains leaves
    balanced(solution)


def test_books_survive_a_checkpoint(tmp_path, backend):
    """A run that goes on has the same state and the same books, bit for bit."""
    file = tmp_path / "rain.npz"
    problem = box(gr.TwoPhase(), gr.Rain(1e-2, phi=0.25), h=0.1, t_end=4.0)
    whole = fv.solve(problem, times=[2.0, 4.0], backend=backend)
    with pytest.raises(fv.SolveError):
        fv.solve(problem, times=[2.0, 4.0], backend=backend, checkpoint=fv.Checkpoint(file), limits=fv.Limits(steps=whole.stats.steps // 2))
    again = fv.resume(file)
    np.testing.assert_array_equal(again.q, whole.q)
    assert again.stats.entered_by_sources == whole.stats.entered_by_sources
    assert again.stats.mass_drift == whole.stats.mass_drift


def test_threads_book_the_same():
    pytest.importorskip("numba", reason="the compiled backend needs the extra `fast`")
    problem = box(gr.ShallowWater(), gr.Rain(0.1), h=1.0, phi=0.0, cells=100_000, t_end=1e-3)
    one, two = (fv.solve(problem, backend="numba", threads=threads) for threads in (1, 2))
    np.testing.assert_array_equal(one.q, two.q)
    np.testing.assert_allclose([run.stats.entered_by_sources["h"] for run in (one, two)], 1e-3, rtol=1e-9)


def test_both_backends_agree():
    pytest.importorskip("numba", reason="the compiled backend needs the extra `fast`")
    problem = fv.Problem(gr.TwoPhase(), fv.Grid(0.0, 10.0, 600), gr.TwoPhase().conserved_from(np.linspace(0.0, 1.0, 600), 0.4), 0.2,
                         sources=(gr.Rain(0.1, phi=0.2), gr.Rain(-0.2), gr.ConstantDrag(1.0)))
    one, two = (fv.solve(problem, backend=backend) for backend in ("numpy", "numba"))
    np.testing.assert_allclose(one.q, two.q, rtol=1e-12, atol=1e-12)
    for name, value in entered(one).items():
        assert entered(two)[name] == pytest.approx(value, rel=1e-11)


@attrs.frozen
class Leak(fv.Source):
    """Takes more than there is."""

    k: float

    def step(self, model, q, aux, dt):
        return q[0] - self.k * dt, q[1]

    def rate(self, model, q, aux):
        return -self.k + 0.0 * q[0], 0.0 * q[1]


def test_a_source_that_makes_a_mass_negative_ends_the_run(backend):
    with pytest.raises(fv.SolveError) as error:
        fv.solve(box(gr.ShallowWater(), Leak(0.1), h=0.1, phi=0.0), backend=backend)
    assert error.value.status in (fv.Status.NEGATIVE_DEPTH, fv.Status.NON_FINITE)
    assert error.value.time < 1.0 + 1e-9
    balanced(error.value.solution)


def test_runs_without_sources_of_mass_book_nothing(backend):
    solution = fv.solve(box(gr.TwoPhase(), (gr.ConstantDrag(1.0), gr.Manning(0.03)), h=0.1, t_end=1.0), backend=backend)
    assert entered(solution) == {"hs": 0.0, "hf": 0.0}


def test_rain_needs_a_model_that_says_what_water_makes():
    with pytest.raises(ValueError, match=r"Burgers has no `poured\(q, solid, fluid\)`"):
        fv.Problem(fv.Burgers(), fv.Grid(0.0, 1.0, 4), np.ones((1, 4)), 1.0, sources=gr.Rain(1e-3))
    with pytest.raises(ValueError, match=r"`phi` must be finite and >= 0 and <= 1, got 1.2"):
        gr.Rain(1e-3, phi=1.2)


def flows(model, rng, count):
    return model.conserved_from(rng.uniform(0.1, 2.0, count), rng.uniform(0.1, 0.9, count), *rng.uniform(-2.0, 2.0, (2, count)))


class TestRainOnShallowWater(SourceConformance):
    model, source, of_mass = gr.ShallowWater(dry=1e-8), gr.Rain(0.3), True

    def states(self, rng, count):
        return flows(self.model, rng, count)


class TestInfiltrationFromTwoPhase(SourceConformance):
    model, source, of_mass = gr.TwoPhase(dry=1e-8), gr.Rain(-0.05), True

    def states(self, rng, count):
        return flows(self.model, rng, count)


class TestInfiltrationFromReduced(SourceConformance):
    model, source, of_mass = gr.Reduced(dry=1e-8), gr.Rain(-0.05), True

    def states(self, rng, count):
        return flows(self.model, rng, count)


@pytest.mark.parametrize("axes", [1, 2])
def test_a_late_shower_falls_on_ground_that_is_dry_everywhere(axes, backend):
    def falls(x, t):
        return np.where((t > 30.0) & (t < 40.0), 1e-4, 0.0) + 0.0 * x

    grid = fv.Grid(0.0, 1.0, 20) if axes == 1 else fv.Grid((0.0, 0.0), (0.5, 0.25), (10, 5))
    problem = fv.Problem(gr.ShallowWater(), grid, np.zeros((1 + axes, *grid.shape)), 50.0, boundary=fv.Wall(),
                         sources=gr.Rain(falls if axes == 1 else lambda x, y, t: falls(x, t)))
    solution = fv.solve(problem, backend=backend)
    # Seen at the middle of steps of at most a hundredth of the run, both ends of the shower are known to half of that.
    assert solution.q[-1, 0].mean() == pytest.approx(1e-3, abs=1e-4 * 0.5)
    balanced(solution)
