"""Faces with complex speeds: films are counted apart from flow, and a warning about films alone says how deep they are."""

import warnings

import numpy as np
import pytest

import fvkit as fv
import fvkit_granular as gr
from fvkit.backends.compiled.numba_kernel import available
from fvkit.backends.compiled.threads import SMALLEST

BACKENDS = ["numpy", pytest.param("numba", marks=pytest.mark.skipif(not available(), reason="needs the extra fast"))]
SCHEMES = {"waves": fv.WavePropagation(gr.Relaxation()), "lines": fv.MethodOfLines(gr.Relaxation())}


def slipping(left, right, cells=100, model=gr.TwoPhase):
    """A slip in the range of complex speeds, on two depths, m, far apart."""
    def flow(x):
        depth = np.where(np.abs(x - 0.25) < 0.1, left, np.where(np.abs(x - 0.75) < 0.1, right, 1e-3 * min(left, right)))
        return {"h": depth, "phi": 0.5, "vs": 0.0, "vf": np.where(depth >= min(left, right), 1.2 * np.sqrt(9.81 * depth), 0.0)}

    return gr.Scene((0.0, 1.0), 0.01 * np.sqrt(min(left, right)), flow, boundary=fv.Periodic()).problem(model, cells)


def remarks(problem, scheme, backend, **options):
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        solution = fv.solve(problem, scheme, backend=backend, **options)
    return solution.stats, [str(warning.message) for warning in caught if "complex" in str(warning.message)]


@pytest.mark.parametrize("backend", BACKENDS)
@pytest.mark.parametrize("scheme", SCHEMES.values(), ids=SCHEMES)
def test_films_alone_are_said_once_at_the_end_with_the_depth_of_the_deepest(scheme, backend):
    stats, said = remarks(slipping(0.02, 0.04), scheme, backend)
    assert stats.nonhyperbolic_faces == stats.nonhyperbolic_films > 0
    assert 0.02 < stats.deepest_nonhyperbolic <= 0.05
    (warning,) = said
    assert f"at {stats.nonhyperbolic_films} faces and steps, all in films: the deepest is {100 * stats.deepest_nonhyperbolic:.2g} cm" in warning


@pytest.mark.parametrize("backend", BACKENDS)
@pytest.mark.parametrize("scheme", SCHEMES.values(), ids=SCHEMES)
def test_films_beside_a_flow_are_counted_apart_and_the_flow_is_said_at_once(scheme, backend):
    stats, said = remarks(slipping(0.02, 2.0), scheme, backend)
    assert 0 < stats.nonhyperbolic_films < stats.nonhyperbolic_faces
    assert stats.deepest_nonhyperbolic > 1.0
    (warning,) = said
    assert "film" not in warning
    assert "m deep" in warning


@pytest.mark.skipif(not available(), reason="needs the extra fast")
@pytest.mark.parametrize("scheme", SCHEMES.values(), ids=SCHEMES)
def test_backends_and_threads_count_the_same(scheme):
    def counts(**options):
        stats = fv.solve(slipping(0.03, 0.6), scheme, nonhyperbolic="ignore", **options).stats
        return stats.nonhyperbolic_faces, stats.nonhyperbolic_films, stats.deepest_nonhyperbolic

    assert counts(backend="numpy") == counts(backend="numba")


@pytest.mark.skipif(not available(), reason="needs the extra fast")
def test_threads_count_what_one_counts():
    one, two = (fv.solve(slipping(0.03, 0.6, SMALLEST), SCHEMES["waves"], limits=fv.Limits(steps=3), throw=False, nonhyperbolic="ignore", threads=n,
                         backend="numba").stats for n in (1, 2))
    assert one.nonhyperbolic_films > 0
    assert (one.nonhyperbolic_faces, one.nonhyperbolic_films, one.deepest_nonhyperbolic) == \
        (two.nonhyperbolic_faces, two.nonhyperbolic_films, two.deepest_nonhyperbolic)


@pytest.mark.parametrize("option", ["ignore", "raise"])
def test_films_are_silent_where_that_is_asked_for_and_end_the_run_where_that_is(option):
    problem = slipping(0.02, 0.04)
    if option == "raise":
        with pytest.raises(fv.SolveError, match="characteristic speeds became complex"):
            fv.solve(problem, backend="numpy", nonhyperbolic="raise")
    else:
        assert remarks(problem, None, "numpy", nonhyperbolic="ignore")[1] == []


def test_a_run_in_parts_counts_films_on(tmp_path):
    problem = slipping(0.02, 2.0)
    whole = fv.solve(problem, backend="numpy", nonhyperbolic="ignore").stats
    fv.solve(problem, backend="numpy", nonhyperbolic="ignore", limits=fv.Limits(steps=whole.steps // 2), throw=False, checkpoint=fv.Checkpoint(tmp_path / "c.npz"))
    parts = fv.resume(tmp_path / "c.npz").stats
    assert (parts.nonhyperbolic_films, parts.deepest_nonhyperbolic) == (whole.nonhyperbolic_films, whole.deepest_nonhyperbolic)
    assert fv.load(fv.resume(tmp_path / "c.npz").save(tmp_path / "s.npz")).stats == parts


@pytest.mark.filterwarnings("ignore:characteristic speeds")
def test_the_command_counts_films_apart(tmp_path, capsys):
    from fvkit.cli import main

    assert main(["run", "lost-hyperbolicity", "--cells", "50", "--backend", "numpy", "--out", str(tmp_path)]) == 0
    assert "of them where h < 0.05 m, largest depth" in capsys.readouterr().out
