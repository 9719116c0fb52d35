"""Sources that act in a few cells: the same as everywhere, with idle ground left idle, and drains."""

import numpy as np
import pytest

import fvkit as fv
import fvkit_granular as gr
from fvkit.backends.numpy_sweeps import NumpySweep
from tests.plane.problems import CLOSED, hillside, state


class Everywhere(gr.Rain):
    """Rain that says nothing of where it falls."""

    def acts_in(self):
        return None


def spring(kind, model, n=48):
    grid = fv.Grid((0.0, 0.0), (96.0, 64.0), (n, 2 * n // 3))
    where = np.zeros(grid.shape)
    where[20:23, 3:6] = 0.2
    return fv.Problem(model, grid, np.zeros((3 * len(model.phases), *grid.shape)), 4.0,
                      aux={"b": lambda x, y: 20.0 - 0.2 * x + 0.0 * y}, boundary=CLOSED,
                      sources=(kind(where, phi=0.4), gr.CoulombFriction(0.1), *((gr.ConstantDrag(1e3),) * (len(model.phases) - 1))))


@pytest.mark.parametrize("model", [gr.ShallowWater(), gr.TwoPhase()])
def test_rain_in_a_few_cells_is_rain_everywhere(model, backend):
    runs = [fv.solve(spring(kind, model), backend=backend, nonhyperbolic="ignore", step=fv.Step(dt_initial=0.1))
            for kind in (gr.Rain, Everywhere)]
    np.testing.assert_allclose(runs[0].q[-1], runs[1].q[-1], rtol=1e-13, atol=1e-13)
    fell = 9 * 0.2 * 4.0 * runs[0].grid.cell_volume
    assert sum(runs[0].stats.entered_by_sources.values()) == pytest.approx(fell, rel=1e-12)
    assert runs[0].q[-1, 0].sum() > 0.0


def test_a_drain_takes_what_reaches_it_with_its_momentum(backend):
    problem = hillside(gr.TwoPhase(), cells=(36, 24), t_end=3.0)
    rate = np.zeros(problem.grid.shape)
    rate[:, 24:] = 1e9
    drained = fv.Problem(problem.model, problem.grid, problem.q0, 3.0, aux=problem.aux_averages, boundary=CLOSED,
                         sources=(*problem.sources, gr.Drain(rate)))
    solution = fv.solve(drained, backend=backend, nonhyperbolic="ignore")
    assert not solution.q[-1][:, :, 24:].any()
    gone = {name: -value for name, value in solution.stats.entered_by_sources.items()}
    before = problem.q0[[0, 3]].sum(axis=(1, 2)) * problem.grid.cell_volume
    left = solution.q[-1][[0, 3]].sum(axis=(1, 2)) * problem.grid.cell_volume
    assert gone["hs"] > 0.5
    np.testing.assert_allclose(before - left, list(gone.values()), rtol=1e-12)


def test_a_slow_drain_decays():
    grid = fv.Grid((0.0, 0.0), (1.0, 1.0), (4, 4))
    model = gr.ShallowWater()
    problem = fv.Problem(model, grid, state(model, np.ones(grid.shape), 1.0), 2.0, boundary=CLOSED, sources=gr.Drain(0.3))
    np.testing.assert_allclose(fv.solve(problem, backend="numpy").q[-1, 0], np.exp(-0.6), rtol=1e-13)


def test_an_interrupted_step_leaves_the_last_accepted_state(monkeypatch):
    """Sources in few cells act on it in place: what they brought to a step that Ctrl-C ends is taken back."""
    calls, run = [], NumpySweep.run

    def interrupted(*given):
        calls.append(given)
        if len(calls) == 40:
            raise KeyboardInterrupt
        return run(*given)

    monkeypatch.setattr(NumpySweep, "run", interrupted)
    solution = fv.solve(spring(gr.Rain, gr.TwoPhase()), backend="numpy", nonhyperbolic="ignore", throw=False,
                        step=fv.Step(dt_initial=0.1))
    assert solution.status is fv.Status.INTERRUPTED
    assert solution.stats.entered_by_sources["hs"] > 0.0
    assert max(abs(drift) for drift in solution.stats.mass_drift.values()) < 1e-13
