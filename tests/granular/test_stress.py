"""`stress`: which runs are made, how they are judged, known limits, files and exit codes."""

import json

import numpy as np
import pytest

from fvkit.cli import main
from fvkit.studies.covering import covering
from fvkit_granular.scenes.library.catalogue import scene_names
from fvkit_granular.stress import StressReport, stress, suite
from fvkit_granular.stress import known_limits as limits_module
from fvkit_granular.stress.cases import CASES
from fvkit_granular.stress.known_limits import Limit


def test_cases_are_scenes_and_the_default_covers_every_pair():
    assert set(CASES) <= set(scene_names())
    every = suite.choices(True, tuple(CASES), ("numba", "numpy"))
    few = suite.choices(False, tuple(CASES), ("numba", "numpy"))
    assert len(few) < 0.3 * len(every)

    def pairs(choices):
        return {(one, two) for choice in choices for one in choice.items() for two in choice.items() if one < two}

    assert pairs(few) == pairs(every)
    assert all(suite.SOLVERS[choice["riemann"]].serves(suite.MODELS[choice["model"]]) for choice in every)


def test_covering_is_exact_on_a_square():
    every = [{"a": a, "b": b} for a in range(3) for b in range(2)]
    assert len(list(covering(every))) == 6


@pytest.fixture(scope="module")
def report() -> StressReport:
    return stress(scenes=["island-step", "dry-dam-break"], backends=["numpy"], workers=2)


def test_runs_pass_and_say_what_was_checked(report, tmp_path):
    assert report.success
    assert {row["verdict"] for row in report.rows} == {"pass"}
    for row in report.rows:
        names = [check["name"] for check in row["checks"]]
        assert {"most negative mass", "mass drift", "steps / nominal"} <= set(names)
        assert row["nominal"] > 0
    assert "island-step" in report.summary()
    folder = report.save(tmp_path / "out")
    document = json.loads((folder / "stress.json").read_text())
    assert len(document["rows"]) == len(report.rows)
    assert (folder / "stress.png").stat().st_size > 5000
    assert "mass drift" in (folder / "stress.txt").read_text()


def test_a_known_limit_is_expected_and_a_failure_that_passes_is_not(monkeypatch):
    choice = {"scene": "dry-dam-break", "model": "reduced", "riemann": "hll", "order": 1, "backend": "numpy"}
    failing = [suite.Check("error of h", 2.0, 1.0), suite.Check("mass drift", 0.0, 1.0)]
    assert suite.verdict(choice, failing) == "FAIL"
    known = Limit({"scene": "dry-dam-break", "riemann": ("hll", "rusanov")}, "error", "for the test", "a factor 2")
    monkeypatch.setattr(suite, "LIMITS", (known,))
    assert suite.verdict(choice, failing) == "expected"
    assert suite.verdict(choice, failing[1:]) == "BETTER"
    assert suite.verdict({**choice, "riemann": "roe"}, failing[1:]) == "pass"
    assert suite.verdict(choice, [suite.Check("error of h", np.nan, 1.0)]) == "expected"
    assert suite.verdict(choice, [*failing, suite.Check("mass drift", np.nan, 1.0)]) == "FAIL"


def test_every_limit_is_explained():
    for limit in limits_module.LIMITS:
        assert len(limit.cause) > 20
        assert limit.size


def test_the_command_says_what_it_wrote_and_exits_1_on_failure(tmp_path, capsys, monkeypatch):
    out = str(tmp_path / "out")
    assert main(["stress", "--scenes", "tiny-depth", "--backends", "numpy", "--workers", "1", "--out", out]) == 0
    assert "stress.png" in capsys.readouterr().out
    monkeypatch.setattr(suite, "LIMITS", (Limit({"scene": "tiny-depth"}, "mass", "for the test: it does not fail", "none"),))
    assert main(["stress", "--scenes", "tiny-depth", "--backends", "numpy", "--workers", "1", "--out", out]) == 1
    assert "BETTER" in capsys.readouterr().out
    assert main(["stress", "--scenes", "tinydepth"]) == 2
    assert "did you mean tiny-depth" in capsys.readouterr().err


def test_a_run_that_fails_at_once_is_a_row(monkeypatch):
    import attrs

    from tests.cases import Fading

    broken = attrs.evolve(suite.find_scene("tiny-depth"), sources=Fading())
    monkeypatch.setattr(suite, "find_scene", lambda name: broken)
    row = suite.run_case("tiny-depth", "shallow-water", "relaxation", 1, "numpy")
    assert row["verdict"] == "FAIL"
    assert row["status"] == "non_finite"
