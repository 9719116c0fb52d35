"""`fv.compare`: any model, its schemes against a reference, several models of one flow."""

from typing import ClassVar

import attrs
import numpy as np
import pytest

import fvkit as fv
from examples import shock_tube


def wave(x, t):
    return np.exp(-100.0 * (x - t - 0.3) ** 2)[None]


def problem(cells):
    return fv.Problem(fv.Advection(1.0), fv.Grid(0.0, 1.0, cells), lambda x: wave(x, 0.0), 0.2)


SECOND, FIRST = fv.WavePropagation(fv.Roe()), fv.WavePropagation(fv.Roe(), order=1)


def test_errors_and_orders_are_those_of_a_convergence_study():
    report = fv.compare(problem, [SECOND, FIRST], (50, 100), wave, repeats=1, backend="numpy")
    for rows, scheme in ((report.rows[:2], SECOND), (report.rows[2:], FIRST)):
        found = fv.convergence(problem, scheme, (50, 100), wave, backend="numpy")
        assert [row["error"]["u"] for row in rows] == pytest.approx(found.totals, rel=1e-14)
        assert rows[1]["order_observed"]["u"] == pytest.approx(found.total_orders[0], rel=1e-12)
    assert report.verdict().startswith("at L1(u) = ")


def test_without_schemes_every_solver_runs_and_without_a_reference_a_finer_grid_is_one():
    report = fv.compare(problem, cells=(20, 40), repeats=1, backend="numpy")
    assert [row["riemann"] for row in report.rows[::2]] == ["roe", "hll", "rusanov"]
    assert report.reference["kind"] == "self-converged"
    assert "N = 160" in report.reference["detail"]
    exact = fv.compare(problem, cells=(20, 40), reference=wave, repeats=1, backend="numpy")
    assert [row["error"]["u"] for row in report.rows] == pytest.approx([row["error"]["u"] for row in exact.rows], rel=0.1)


def test_of_a_shock_tube_roe_and_hllc_keep_the_contact_that_hll_smears():
    schemes = [fv.WavePropagation(solver) for solver in (fv.Roe(), fv.HLL(), shock_tube.HLLC())]
    report = fv.compare(shock_tube.problem, schemes, (100, 200), shock_tube.exact, repeats=1, backend="numpy")
    errors = {row["riemann"]: row["error"] for row in report.rows[1::2]}
    assert set(errors["roe"]) == {"rho", "u", "p"}
    assert errors["roe"]["rho"] < errors["hllc"]["rho"] < errors["hll"]["rho"]
    assert all(row["order_observed"]["rho"] > 0.8 for row in report.rows[1::2])
    assert {"roe", "hll", "hllc"} == {label.split()[-1] for label in report.profiles if label != "reference"}


@attrs.frozen
class Pair(fv.Model):
    """Advection of two quantities, to differ from `fvkit.Advection` in what it conserves."""

    conserved: ClassVar[tuple[str, ...]] = ("q", "r")

    def flux(self, q):
        return q

    def wave_speeds(self, q):
        return 1.0 + 0.0 * q[0], 1.0 + 0.0 * q[0]


def pair(cells):
    return fv.Problem(Pair(), fv.Grid(0.0, 1.0, cells), lambda x: np.concatenate([wave(x, 0.0), wave(x, 0.0)]), 0.2)


class Known:
    """A reference of both models."""

    kind, detail = "exact", "a bump that moves"

    def averages(self, model, grid, t):
        return np.repeat(wave(grid.centers, t), len(model.conserved), axis=0)


def test_several_models_need_a_reference_that_serves_all():
    both = {"one": problem, "two": pair}
    report = fv.compare(both, [fv.WavePropagation(fv.HLL())], (50, 100), Known(), repeats=1, backend="numpy")
    assert [row["model"] for row in report.rows] == ["one", "one", "two", "two"]
    assert report.rows[3]["error"]["q"] == pytest.approx(report.rows[1]["error"]["u"], rel=1e-12)
    with pytest.raises(ValueError, match=r"`averages\(model, grid, t\)`.*one: \('u',\), two: \('q', 'r'\)"):
        fv.compare(both, [SECOND], (50, 100), wave)


def test_a_scheme_that_serves_no_model_is_refused_and_one_that_serves_some_runs_with_those():
    both = {"one": problem, "two": pair}
    report = fv.compare(both, [SECOND], (50,), Known(), repeats=1, backend="numpy")
    assert [row["model"] for row in report.rows] == ["one"]
    with pytest.raises(ValueError, match=r"serve none of the models.*decompose"):
        fv.compare(pair, [SECOND], (50,))


@pytest.mark.parametrize(("change", "message"), [
    ({"problems": {}}, "`problems` must hold"), ({"problems": 3}, "`problems`"), ({"problems": lambda n: n}, "`problems"),
    ({"schemes": fv.Roe()}, "`schemes`"), ({"schemes": [fv.Roe()]}, "`schemes`"), ({"cells": ()}, "`cells`"),
    ({"repeats": 0}, "`repeats`"), ({"seconds": -1.0}, "`seconds`"), ({"reference": 3}, "`reference`"), ({"progress": 3}, "`progress`"),
])
def test_bad_input_is_named(change, message):
    given = {"problems": problem, "schemes": [SECOND], "cells": (20,), "repeats": 1, "backend": "numpy"} | change
    with pytest.raises((ValueError, TypeError), match=message):
        fv.compare(**given)


def test_a_table_is_narrow_unless_all_of_it_is_wanted():
    report = fv.compare(shock_tube.problem, None, (20, 40), shock_tube.exact, name="a tube with " + 30 * "a long name ", repeats=1,
                        backend="numpy")
    narrow, wide = report.table(), report.table(wide=True)
    assert max(map(len, narrow.splitlines())) <= 100 < max(map(len, wide.splitlines()))
    assert "Left out: ms min, rej., orders" in narrow
    assert "Left out" not in wide
    for row in report.rows:
        assert f"{row['error']['p']:.2e}" in narrow
