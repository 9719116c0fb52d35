"""Convergence studies: orders of fifth- and second-order schemes on several laws, expectations, self-convergence."""

import json

import numpy as np
import pytest

import fvkit as fv
from fvkit.studies.cost import predicted
from tests.cases import PSystem, Traffic, averages, burgers_exact, l1, solve

K = 2.0 * np.pi
FIFTH, SECOND = fv.MethodOfLines(fv.HLL(), integrator=fv.DP5()), fv.WavePropagation(fv.HLL())


def advected(x, t):
    return np.exp(np.sin(K * (x - t)))[None]


def burgers(x, t):
    return burgers_exact(x, t, lambda y: 0.5 + 0.25 * np.sin(K * y), lambda y: 0.25 * K * np.cos(K * y))[None]


def sound(x, t):
    """Two waves that cross: p = f(x - c t) + g(x + c t), u = (f - g)/Z, c = 2, Z = 1."""
    right, left = np.exp(np.sin(K * (x - 2.0 * t))), np.cos(K * (x + 2.0 * t))
    return np.array([right + left, right - left])


def traffic(x, t):
    """1 - 2 density obeys Burgers' equation."""
    return 0.5 - 0.5 * burgers_exact(x, t, lambda y: 0.5 * np.sin(K * y), lambda y: 0.5 * K * np.cos(K * y))[None]


#: law -> (model, exact solution, end time).
LAWS = {"advection": (fv.Advection(1.0), advected, 0.5), "burgers": (fv.Burgers(), burgers, 0.2),
        "acoustics": (fv.Acoustics(rho=0.5, bulk=2.0), sound, 0.2), "traffic": (Traffic(), traffic, 0.15)}


def problem_of(law):
    model, exact, end = LAWS[law]
    return lambda n: fv.Problem(model, fv.Grid(0.0, 1.0, n), lambda x: exact(x, 0.0), end, boundary=fv.Periodic())


def gas(n):
    return fv.Problem(PSystem(), fv.Grid(0.0, 1.0, n), lambda x: np.array([1.0 + 0.1 * np.sin(K * x), 0.1 * np.cos(K * x)]), 0.2,
                      boundary=fv.Periodic())


@pytest.mark.parametrize("law", LAWS)
def test_mp5_with_dp5_is_fifth_order_for_every_law(law):
    found = fv.convergence(problem_of(law), FIFTH, (40, 80, 160), LAWS[law][1], expect=4.8, backend="numpy")
    assert 4.8 <= found.total_orders[-1] < 5.3


@pytest.mark.parametrize("law", LAWS)
def test_wave_propagation_is_second_order_for_every_law(law):
    found = fv.convergence(problem_of(law), SECOND, (80, 160, 320), LAWS[law][1], expect=1.85, backend="numpy")
    assert found.total_orders[-1] < 2.4


@pytest.mark.parametrize(("scheme", "expect"), [(FIFTH, 4.8), (SECOND, 1.85)])
def test_a_law_without_a_solution_shows_its_order_by_self_convergence(scheme, expect):
    found = fv.convergence(gas, scheme, (20, 40, 80, 160), expect=expect, backend="numpy")
    assert found.kind == "self-converged"
    assert found.cells == (20, 40, 80)
    assert found.errors.shape == (3, 2)
    assert "Richardson" in str(found)


def test_richardson_estimates_the_error_of_the_finest_run():
    unlimited = fv.WavePropagation(fv.HLL(), fv.NoLimiter())
    alone, known = (fv.convergence(problem_of("burgers"), unlimited, (40, 80, 160), reference, backend="numpy")
                    for reference in (None, burgers))
    assert alone.finest_error == pytest.approx(known.finest_error, rel=0.05)


def test_errors_are_those_of_an_independent_quadrature_in_every_norm():
    problem = problem_of("acoustics")(40)
    difference = solve(problem, SECOND).q[-1] - averages(lambda x: sound(x, 0.2), problem.grid)
    wanted = {"l1": l1(problem.grid, difference), "max": np.abs(difference).max(axis=1).sum(),
              "l2": np.sqrt((difference**2).mean(axis=1)).sum()}
    for norm, error in wanted.items():
        found = fv.convergence(problem_of("acoustics"), SECOND, (20, 40), sound, norm=norm, backend="numpy")
        assert found.totals[-1] == pytest.approx(error, rel=1e-6)


def test_a_reference_may_average_itself_and_name_its_kind():
    class Known:
        kind = "semi-exact"

        def averages(self, model, grid, t):
            return averages(lambda x: sound(x, t), grid)

    found = fv.convergence(problem_of("acoustics"), SECOND, (20, 40), Known(), backend="numpy")
    assert found.kind == "semi-exact"
    assert found.totals == pytest.approx(fv.convergence(problem_of("acoustics"), SECOND, (20, 40), sound, backend="numpy").totals)


def test_a_missed_order_raises_with_the_table():
    with pytest.raises(fv.OrderError, match=r"expected order 3 between 80 and 160 cells, observed [12]\.") as caught:
        fv.convergence(problem_of("burgers"), SECOND, (40, 80, 160), burgers, expect=3.0, backend="numpy")
    assert isinstance(caught.value, AssertionError)
    assert caught.value.convergence.table() in str(caught.value)


def test_errors_of_rounding_show_no_order_and_meet_no_expectation():
    def still(n):
        return fv.Problem(fv.Advection(1.0), fv.Grid(0.0, 1.0, n), lambda x: np.ones((1, len(x))), 0.1, boundary=fv.Periodic())

    found = fv.convergence(still, SECOND, (10, 20), lambda x, t: np.ones((1, len(x))), backend="numpy")
    assert np.isnan(found.total_orders).all()
    with pytest.raises(fv.OrderError, match="errors are rounding"):
        found.check(1.0)


def test_table_picture_files_and_progress(tmp_path):
    told = []
    found = fv.convergence(gas, None, (20, 40, 80), backend="numpy", progress=told.append)
    assert [line.split()[-1] for line in told] == ["20", "40", "80"]
    lines = found.table().splitlines()
    assert lines[0].startswith("PSystem, wave-propagation hll mc order 2")
    assert lines[2].split() == ["cells", "ms", "rho", "ord.", "m", "ord.", "sum", "ord."]
    assert lines[5].split()[3] == f"{found.orders[0, 0]:.2f}"
    document = json.loads((found.save(tmp_path / "new") / "convergence.json").read_text())
    assert document["rows"][1]["total_order"] == pytest.approx(found.total_orders[0])
    assert (tmp_path / "new" / "convergence.png").stat().st_size > 5000
    assert len(found.plot().lines) == 4, "two components, their sum and the guide"


@pytest.mark.parametrize(("settings", "error", "words"), [
    ({"cells": (40,)}, ValueError, "`cells` must hold at least 3 ascending numbers without a reference"),
    ({"cells": (80, 40, 20)}, ValueError, "ascending"), ({"cells": (20, 40, 60)}, ValueError, "grow by one whole factor"),
    ({"cells": (20.5, 40, 80)}, TypeError, "cells"), ({"norm": "l3"}, ValueError, "`norm` must be one of l1, l2, max"),
    ({"reference": 3.0}, TypeError, "`reference` must be a function"), ({"expect": "high"}, TypeError, "expect"),
    ({"problem_of": lambda n: gas(n + 1)}, ValueError, r"`problem_of\(20\)` must have 20 cells, got 21"),
    ({"problem_of": lambda n: n}, TypeError, r"problem_of\(n\)")])
def test_bad_input_is_refused_by_name(settings, error, words):
    with pytest.raises(error, match=words):
        fv.convergence(**({"problem_of": gas, "scheme": SECOND, "cells": (20, 40, 80), "backend": "numpy"} | settings))


def test_a_run_stops_when_its_seconds_are_over():
    problem = fv.Problem(fv.Burgers(), fv.Grid(0.0, 1.0, 2000), lambda x: np.sin(K * x)[None], 50.0, boundary=fv.Periodic())
    solution = fv.solve(problem, SECOND, backend="numpy", throw=False, limits=fv.Limits(seconds=0.05))
    assert solution.status is fv.Status.OVER_BUDGET
    assert 0.05 < solution.stats.seconds < 1.0
    assert 0.0 < solution.t[-1] < 50.0
    with pytest.raises(fv.SolveError, match="took longer than its limit of `seconds`"):
        fv.solve(problem, SECOND, backend="numpy", limits=fv.Limits(seconds=0.05))
    with pytest.raises(ValueError, match="`seconds` must be finite and > 0"):
        fv.solve(problem, SECOND, backend="numpy", limits=fv.Limits(seconds=0.0))


def test_the_cost_of_a_run_is_predicted_from_coarser_ones():
    assert predicted(400, []) == 0.0
    assert predicted(400, [(100, 1.0)]) == pytest.approx(4.0)
    assert predicted(400, [(200, 4.0), (100, 1.0)]) == pytest.approx(16.0)
    assert predicted(400, [(200, 1.0), (100, 1.0)]) == pytest.approx(2.0), "grows at least with N"
    assert predicted(400, [(200, 9.0), (100, 1.0)]) == pytest.approx(36.0), "and at most with its square"


def test_a_reference_that_is_not_finite_is_refused():
    with pytest.raises(ValueError, match="`reference` must be finite"):
        fv.convergence(lambda n: fv.Problem(fv.Advection(1.0), fv.Grid(0.0, 1.0, n), lambda x: [x], 0.1), None, (4, 8),
                       lambda x, t: [np.nan * x], backend="numpy")
