"""What random scenes found, by name: each run ends in a collapse of the step that has a name, a whole state, and all its mass.

None is repaired: where one of them finishes one day, its line goes, and `tests.tools.random_limits.COLLAPSES` gets smaller.
"""

import pytest

from tests.tools.random_runs import COLLAPSED, run_random

FOUND = {
    # Pitman and Le's product drives thin fluid at fronts without bound.
    "pitman-le, front onto dry ground": ("pitman-le", "relaxation", 1, 54),
    "pitman-le, vanishing film on rough ground": ("pitman-le", "relaxation", 1, 26),
}

#: What once collapsed, and finishes since the ground goes on beyond open ends, and since rare phases lose their own rows alone,
#: the last since a trace of a phase is no faster than its push over its mass.
MENDED = {
    "inflow through an open end, one velocity": ("two-phase", "rusanov", 1, 536),
    "inflow through an open end, complex speeds": ("two-phase", "rusanov", 2, 517),
    "inflow through an open end, over an island": ("two-layer", "rusanov", 1, 183),
    "film of fluid without drag": ("two-phase", "relaxation", 1, 489),
    "solid parting from a wall, order 2": ("two-phase", "rusanov", 2, 3677),
    "slow start on rough ground": ("two-layer", "roe", 2, 314),
    "pitman-le, solid with little fluid": ("pitman-le", "hll", 2, 38),
}

#: The same on a plane, with the setting: what parts from a wall is there again at the next step, brought by the sweep along it.
MENDED_ON_A_PLANE = {
    "film beside a hydrograph": ("two-phase", "roe", 1, 97, "bare"),
    "upper layer at a wall, fast": ("two-layer", "rusanov", 2, 412, "bare"),
}

#: The same on a slope with an inflow, seed 101: beside a flow of 1 m the friction of a face on a film of 1e-297 m was no number; fluid that brings 1e-22 m of
#: grains in and out by the same end keeps its mass as well as a double can add it.
MENDED_ON_A_SLOPE = {
    "film under Manning friction": ("shallow-water", "relaxation", 1, 6282, "stream"),
    "film under Manning friction and drag": ("two-phase", "hll", 1, 4810, "stream"),
    "film under Voellmy friction": ("two-phase", "roe", 2, 2306, "torrent"),
    "film of two layers": ("two-layer", "rusanov", 2, 5794, "torrent"),
    "grains that leave by the end that brought them": ("two-phase", "relaxation", 1, 363, "stream"),
}

#: Thin films, the last of 1e-27 m, where a last digit decides what the product does. A face that is computed twice, at both ends of a ring,
#: had two fluxes there, since the compiler contracted products in vectors and not behind them: up to 1.6e-7 of a mass was lost.
TWO_FLUXES = (9113, 10457, 11346, 12018)


@pytest.mark.parametrize("index", TWO_FLUXES)
def test_both_ends_of_a_ring_have_one_flux(index, monkeypatch):
    monkeypatch.setenv("FVKIT_BACKEND", "auto")
    found = run_random("pitman-le", "relaxation", 2, 1, index, 1)
    assert not found["odd"]
    assert found["shares"][0] <= 0.1


@pytest.mark.parametrize("name", FOUND)
def test_what_collapses_has_a_name_and_keeps_its_mass(name, monkeypatch):
    monkeypatch.setenv("FVKIT_BACKEND", "auto")
    model, riemann, order, index = FOUND[name]
    found = run_random(model, riemann, order, 1, index, 1)
    (one,) = found["odd"]
    assert one["status"] in COLLAPSED
    assert found["lowest"] >= 0.0
    assert one["share"] <= 1.0


@pytest.mark.parametrize("name", MENDED)
def test_what_was_mended_finishes(name, monkeypatch):
    monkeypatch.setenv("FVKIT_BACKEND", "auto")
    model, riemann, order, index = MENDED[name]
    found = run_random(model, riemann, order, 1, index, 1)
    assert found["odd"] == []
    assert found["shares"][0] <= 1.0


@pytest.mark.parametrize("name", MENDED_ON_A_SLOPE)
def test_what_was_mended_on_a_slope_finishes_and_keeps_its_mass(name):
    *which, index, setting = MENDED_ON_A_SLOPE[name]
    found = run_random(*which, 101, index, 1, setting)
    assert found["odd"] == []
    assert found["shares"][0] <= 1.0


@pytest.mark.parametrize("name", MENDED_ON_A_PLANE)
def test_what_was_mended_on_a_plane_finishes_without_a_small_step(name, monkeypatch):
    monkeypatch.setenv("FVKIT_BACKEND", "auto")
    *which, index, setting = MENDED_ON_A_PLANE[name]
    found = run_random(*which, 1, index, 1, setting)
    assert found["odd"] == []
    assert found["ratios"][0] < 2.0


def test_a_thin_film_on_a_slope_ends_the_method_of_lines_by_name(monkeypatch):
    """Fifth order loses the step of a film on a slope between walls; with Rusanov the last step is not finite, and is refused."""
    monkeypatch.setenv("FVKIT_BACKEND", "auto")
    found = run_random("two-phase", "rusanov", 5, 3, 241, 1)
    (one,) = found["odd"]
    assert one["status"] in (*COLLAPSED, "non_finite")
    assert found["lowest"] >= 0.0


def test_the_method_of_lines_is_not_asked_for_static_friction(monkeypatch):
    monkeypatch.setenv("FVKIT_BACKEND", "numpy")
    assert run_random("shallow-water", "hll", 5, 1, 16, 1)["odd"] == []
