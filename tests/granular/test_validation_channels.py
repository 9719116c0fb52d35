"""The channels of the validation chapter, at a small size: docs/validation/channels.md; MacDonald's stand in test_macdonald."""

import numpy as np
import pytest

from fvkit.backends.compiled.numba_kernel import available
from tests.benchmarks import channels
from tests.benchmarks.chapter import SCHEMES, G, means
from tests.cases import orders

REGIMES = ("subcritical", "transcritical", "jump")


@pytest.mark.parametrize("regime", REGIMES)
def test_the_bump_has_one_discharge_and_one_head_beside_its_jump(regime):
    flow = channels.bump(regime)
    x = np.linspace(0.0, 25.0, 2001)
    head = flow.depth(x) + channels.BUMP(x) + flow.q**2 / (2.0 * G * flow.depth(x) ** 2)
    assert len(np.unique(np.round(head, 9))) == (2 if regime == "jump" else 1)
    if regime == "jump":
        (place,) = set(flow.breaks) - {8.0, channels.CREST, channels.FOOT}
        before, behind = flow.depth(np.array([place - 1e-9, place + 1e-9]))
        assert before < behind
        assert flow.q**2 / before + 0.5 * G * before**2 == pytest.approx(flow.q**2 / behind + 0.5 * G * behind**2, rel=1e-6)


@pytest.mark.skipif(not available(), reason="too slow uncompiled")
@pytest.mark.parametrize("solver", ["Relaxation", "Roe"])
@pytest.mark.parametrize("regime", REGIMES)
def test_flow_over_a_bump_starts_from_rest_and_becomes_the_exact_one(regime, solver):
    found = np.array([channels.bump_errors(regime, SCHEMES[solver], cells, t=400.0, backend="numba") for cells in (50, 100)])
    # Relaxation is between first and second order where the flow passes its critical depth.
    assert orders(found[:, 0])[0] > (0.9 if regime == "jump" or (regime, solver) == ("transcritical", "Relaxation") else 1.3)
    assert found[1, 0] < 3e-3
    assert found[1, 1] < 1e-3


@pytest.mark.parametrize("solver", ["Relaxation", "Roe", "MP5"])
@pytest.mark.parametrize("regime", REGIMES)
def test_a_background_keeps_the_flow_to_rounding(regime, solver):
    assert max(channels.bump_errors(regime, SCHEMES[solver], 50, background=True, t=2.0, still=False)) < 1e-13


@pytest.mark.parametrize("solver", ["Relaxation", "Roe", "HLL", "Rusanov"])
@pytest.mark.parametrize("right", [0.001, 0.0])
def test_dam_breaks_come_nearer_with_the_cells(right, solver):
    found = np.array([channels.dam_errors(right, SCHEMES[solver], cells)[0] for cells in (100, 200)])
    assert orders(found)[0] > 0.8
    assert found[1] < 2e-5


def test_dresslers_perturbation_is_of_first_order_in_the_friction():
    """What the equations leave of it is the square of g/C^2: 10,000 times less at ten times C."""
    def left(chezy):
        solved, t, step = channels.Dressler(chezy=chezy), 40.0, 1e-3
        x = np.linspace(-250.0, 50.0, 7)

        def q(x, t):
            seen = solved.at(x, t)
            return np.stack([seen["h"], seen["h"] * seen["v"]]), np.stack([seen["h"] * seen["v"], seen["h"] * seen["v"] ** 2 + 0.5 * G * seen["h"] ** 2])

        rate = (q(x, t + step)[0] - q(x, t - step)[0]) / (2.0 * step)
        flux = (q(x + step, t)[1] - q(x - step, t)[1]) / (2.0 * step)
        return np.abs(rate + flux + np.stack([0.0 * x, G * solved.at(x, t)["v"] ** 2 / chezy**2])).max()

    assert left(40.0) / left(400.0) == pytest.approx(1e4, rel=0.2)


@pytest.mark.parametrize("solver", ["Relaxation", "Roe"])
def test_rough_ground_slows_a_dam_break_as_dressler_has_it(solver):
    assert channels.dressler_error(SCHEMES[solver], 200) < 0.01 * 6.0


@pytest.mark.skipif(not available(), reason="too slow uncompiled")
@pytest.mark.parametrize("solver", ["Relaxation", "Roe", "HLL"])
def test_a_basin_rocks_as_thacker_has_it(solver):
    found = [channels.basin_errors(SCHEMES[solver], cells, backend="numba")[0] for cells in (100, 200)]
    assert found[1] < 0.01 * 0.17  # of the mean depth
    assert found[1] < found[0]


def test_means_are_cut_at_jumps():
    np.testing.assert_allclose(means(lambda x: np.where(x < 0.3, 1.0, x), np.array([0.0, 0.5, 1.0]), (0.3,)), [0.76, 0.75], rtol=1e-14)
