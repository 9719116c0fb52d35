"""Tests run on the NumPy backend unless they ask for another: compiling is tested once, in tests/backends."""

import os
import signal

import pytest
from hypothesis import HealthCheck, settings

os.environ["FVKIT_BACKEND"] = "numpy"
os.environ.setdefault("MPLBACKEND", "Agg")

# Examples may be slow on a machine that is busy; kernels are compiled in some. A test says how many examples it wants.
settings.register_profile("fvkit", deadline=None, print_blob=True, suppress_health_check=[HealthCheck.too_slow])
settings.load_profile("fvkit")


@pytest.fixture(params=["numpy", "numba"])
def backend(request):
    """Each backend in turn; kernels stay in the cache of the user, for all processes and for the next run."""
    if request.param == "numba":
        pytest.importorskip("numba", reason="the compiled backend needs the extra `fast`")
    return request.param


@pytest.fixture(scope="session", autouse=True)
def a_process_that_listens_to_ctrl_c():
    """A test run in the background of a shell ignores it, and so would the processes that it starts."""
    before = signal.signal(signal.SIGINT, signal.default_int_handler)
    yield
    signal.signal(signal.SIGINT, before)


def pytest_collection_modifyitems(items):
    """Keep of tests of every model on both backends one model on the compiled one: tests/backends compares every pair."""
    items[:] = [item for item in items if not _compiled_again(item)]


def _compiled_again(item):
    given = getattr(getattr(item, "callspec", None), "params", {})
    model = given.get("model")
    name = getattr(model, "__name__", type(model).__name__)
    return given.get("backend") == "numba" and "model" in given and name != "TwoPhase" and "backends" not in item.path.parts
