"""Compiled kernels of the tests live in one folder per test run."""

import pytest


@pytest.fixture(scope="session", autouse=True)
def kernels(tmp_path_factory):
    pytest.importorskip("numba", reason="the compiled backend needs the extra `fast`")
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("FVKIT_CACHE", str(tmp_path_factory.mktemp("kernels")))
        yield
