"""Energy of a thin release: lines of slope nu on a plane and of a point on a parabola, and none lost without friction."""

import warnings

import pytest

from tests.benchmarks.mountain import NU, energy_left, energy_slope


def test_the_energy_line_of_a_plane():
    found, exact = energy_slope("plane", "steep", cells=200)
    assert exact == pytest.approx(NU, rel=1e-6)
    assert found == pytest.approx(NU, rel=0.02)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        mild, _ = energy_slope("plane", "mild", cells=200)
    assert mild < 0.6 * NU


def test_the_energy_line_of_a_parabola_needs_the_centripetal_force():
    found, exact = energy_slope("parabola", "steep", curved=True)
    assert found == pytest.approx(exact, rel=0.02)
    found, exact = energy_slope("parabola", "steep")
    assert found > 1.02 * exact > NU


def test_a_bead_without_friction_keeps_its_energy_on_a_curved_hillside():
    assert abs(energy_left("steep", True)) < 0.02
    assert abs(energy_left("steep", False)) > 0.05
