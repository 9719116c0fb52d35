"""Hazard maps and cross-sections: against every state of a run."""

import numpy as np
import pytest

import fvkit as fv
import fvkit_granular as gr
from fvkit.problem.directions import observables
from tests.plane.problems import hillside


def seen_of(problem, observers, **options):
    """Times and observables of every accepted step."""
    states = [(problem.t_start, problem.q0)]
    fv.solve(problem, backend="numpy", nonhyperbolic="ignore",
             observers=[lambda stepper: states.append((stepper.t, stepper.q.copy())), *observers], **options)
    return (np.array([t for t, _ in states]),
            [observables(problem.model, problem.grid, q, problem.aux_averages) for _, q in states], [q for _, q in states])


@pytest.mark.parametrize("model", [gr.ShallowWater(), gr.TwoPhase(gamma=0.4), gr.TwoPhase(gamma=0.4, slope="steep")])
def test_hazard_maps_are_those_of_all_steps(model):
    problem = hillside(model)
    hazard = gr.HazardMaps(threshold=0.2, density=2500.0, least=0.05)
    times, seen, _ = seen_of(problem, [hazard])
    h = np.array([one["h"] for one in seen])
    vx, vy = (np.array([one[f"v_{axis}"] for one in seen]) for axis in "xy")
    square = vx * vx + vy * vy
    slopes = np.zeros((2, *problem.grid.shape))
    if model.slope == "steep":
        slopes = problem.given[1:]
        square = square + (vx * slopes[0] + vy * slopes[1]) ** 2
    square[h < 0.05] = 0.0
    rho = 2500.0 * np.ones_like(h)
    if "phi" in seen[0]:
        rho = 2500.0 * np.array([one["phi"] + 0.4 * (1.0 - one["phi"]) for one in seen])
    maps = hazard.maps
    np.testing.assert_array_equal(maps["depth"], h.max(axis=0))
    np.testing.assert_allclose(maps["thickness"], h.max(axis=0) / np.sqrt(1.0 + slopes[0] ** 2 + slopes[1] ** 2))
    np.testing.assert_allclose(maps["speed"], np.sqrt(square).max(axis=0), rtol=1e-13)
    np.testing.assert_allclose(maps["pressure"], np.nanmax(rho * square, axis=0), rtol=1e-13)
    there = h >= 0.2
    first = np.where(there.any(axis=0), times[there.argmax(axis=0)], np.inf)
    np.testing.assert_array_equal(maps["arrival"], first)
    np.testing.assert_allclose(maps["duration"], (np.diff(times, prepend=0.0)[:, None, None] * there).sum(axis=0), atol=1e-12)
    assert np.isfinite(maps["arrival"]).any()
    assert np.isinf(maps["arrival"]).any()
    if "phi" in seen[0]:
        deepest = h.argmax(axis=0)
        phi = np.take_along_axis(np.array([one["phi"] for one in seen]), deepest[None], axis=0)[0]
        np.testing.assert_array_equal(maps["phi"][h.max(axis=0) > 0.0], phi[h.max(axis=0) > 0.0])


def test_both_are_the_same_after_a_resume(tmp_path):
    problem, path = hillside(gr.TwoPhase()), tmp_path / "run.npz"
    line = [(2.0, 0.5), (9.0, 7.5)]
    whole = gr.HazardMaps(), fv.CrossSection(line)
    fv.solve(problem, backend="numpy", observers=whole, nonhyperbolic="ignore")
    fv.solve(problem, backend="numpy", observers=(gr.HazardMaps(), fv.CrossSection(line)), nonhyperbolic="ignore",
             checkpoint=fv.Checkpoint(path), limits=fv.Limits(steps=7), throw=False)
    parts = gr.HazardMaps(), fv.CrossSection(line)
    fv.resume(path, problem=problem, observers=parts)
    for name, values in whole[0].maps.items():
        np.testing.assert_array_equal(values, parts[0].maps[name])
    for name, values in whole[1].discharge.items():
        np.testing.assert_array_equal(values, parts[1].discharge[name])


def test_what_passes_a_line_is_what_leaves_the_part_behind_it():
    """A closed box: the volume through a line across it is what the other side gains, to the error of the averages."""
    problem = hillside(gr.TwoPhase(), cells=(60, 8))
    line = fv.CrossSection([(6.0, 0.0), (6.0, 8.0)])
    _, _, states = seen_of(problem, [line])
    gained = (states[-1] - states[0])[[0, 3]][:, :, 30:].sum(axis=(1, 2)) * problem.grid.cell_volume
    assert gained.min() > 0.5
    # walking northwards, what flows to the east goes from left to right
    for name, value in zip(("hs", "hf"), gained, strict=True):
        assert line.volume[name][-1] == pytest.approx(value, rel=0.02)
    assert len(line.t) == len(states)


def test_a_bent_line_and_its_pieces():
    problem = hillside(gr.ShallowWater())
    bent = fv.CrossSection([(1.3, 0.7), (6.0, 4.0), (11.0, 1.0)])
    first, second = fv.CrossSection(bent.line[:2]), fv.CrossSection(bent.line[1:])
    back = fv.CrossSection(bent.line[::-1])
    seen_of(problem, [bent, first, second, back])
    np.testing.assert_allclose(bent.discharge["h"], first.discharge["h"] + second.discharge["h"], atol=1e-13)
    np.testing.assert_allclose(bent.discharge["h"], -back.discharge["h"], atol=1e-13)
    assert np.abs(bent.discharge["h"]).max() > 0.1


@pytest.mark.parametrize(("line", "words"), [
    ([(0.0, 0.0)], "at least two points"), ([(0.0, 0.0), (0.0, 0.0)], "the same point twice"), ([1.0, 2.0], "at least two points"),
    ([(0.0, 0.0), (99.0, 1.0)], r"`line` of a CrossSection must be within \[0, 12\], got 99")])
def test_lines_that_are_none(line, words):
    with pytest.raises(ValueError, match=words):
        fv.solve(hillside(gr.ShallowWater()), backend="numpy", observers=fv.CrossSection(line))


def test_observers_of_another_grid_or_model():
    flat = fv.Problem(gr.ShallowWater(), fv.Grid(0.0, 1.0, 8), lambda x: [1.0 + x, 0.0 * x], 0.1)
    with pytest.raises(ValueError, match="a number x on a grid with one axis"):
        fv.solve(flat, backend="numpy", observers=fv.CrossSection([(0.0, 0.0), (1.0, 0.0)]))
    burgers = fv.Problem(fv.Burgers(), fv.Grid(0.0, 1.0, 8), lambda x: [x], 0.1)
    with pytest.raises(ValueError, match="defines no `depth"):
        fv.solve(burgers, backend="numpy", observers=gr.HazardMaps())
