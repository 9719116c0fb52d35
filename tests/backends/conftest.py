"""These tests need the compiled backend."""

import pytest


@pytest.fixture(scope="session", autouse=True)
def compiled():
    pytest.importorskip("numba", reason="the compiled backend needs the extra `fast`")
