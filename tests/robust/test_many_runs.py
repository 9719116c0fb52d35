"""The small sizes of many runs: the same bits in any company, and no memory kept. In full: ``python -m tests.robust.full``."""

import sys

import pytest

from tests.robust import many
from tests.robust.cases import shaken

pytestmark = pytest.mark.skipif(sys.platform != "linux", reason="forks, and reads /proc")


def test_random_runs_in_any_order_in_threads_and_in_processes_are_each_the_run_alone():
    assert many.many_runs(24) == {"one after the other": 0, "4 threads": 0, "2 processes": 0}


def test_the_digest_tells_runs_apart():
    assert len({shaken(number) for number in range(12)}) == 12


def test_many_small_runs_keep_no_memory():
    """Bounds as in tests/LOG.md: 0.5 kB of objects for each run, and what the allocator rounds up to, 4 MB in all."""
    traced, whole = many.growth(60, warm=20, settings=20)
    assert traced < 500 * 60
    assert whole < 4_000_000
