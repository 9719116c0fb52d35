"""Files that nobody should trust: what is read equals what was written, or one ValueError or OSError names the file."""

import gc
import resource
import time
import tracemalloc
import warnings
from contextlib import contextmanager
from pathlib import Path

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

import fvkit as fv
import fvkit_granular as gr
from fvkit.files import Unreadable
from tests.robust.mutations import READERS, crafted, generator, inside, mutate, seeds, texts

# h5netcdf cannot close a file that it could not open, and Python says so; nothing is lost.
pytestmark = pytest.mark.filterwarnings("ignore::pytest.PytestUnraisableExceptionWarning")

#: What one reading may take: memory, bytes, and time, s, on a busy machine.
MEMORY, SECONDS = 200_000_000, 2.0

QUICK = settings(max_examples=60, suppress_health_check=[HealthCheck.function_scoped_fixture, HealthCheck.too_slow],
                 derandomize=True, database=None)


class Files(dict):
    """Bytes of files by kind: hypothesis prints what a failing test was given, and 300 kB of it hide the failure."""

    def __repr__(self):
        return f"Files({', '.join(self)})"


@pytest.fixture(scope="module")
def valid(tmp_path_factory):
    return Files(seeds(tmp_path_factory.mktemp("seeds")))


@contextmanager
def bounded():
    """Within MEMORY and SECONDS of this thread; what garbage collection costs after thousands of other tests is not the reader's."""
    peak, start = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss, time.thread_time()
    gc.disable()
    try:
        yield
    finally:
        gc.enable()
    assert time.thread_time() - start < SECONDS
    assert 1000 * (resource.getrusage(resource.RUSAGE_SELF).ru_maxrss - peak) < MEMORY


def outcome(kind, data, folder):
    """What reading gives, or None where it is refused as promised; anything else fails."""
    ending, reader = READERS[kind]
    path = folder / f"mutated{ending}"
    path.write_bytes(data)
    with bounded():
        try:
            with warnings.catch_warnings():
                warnings.simplefilter("ignore")
                return reader(path)
        except (ValueError, OSError) as error:
            said = str(error)
    assert path.name in said
    assert "\n" not in said
    assert len(said) < 2000
    return None


@pytest.mark.parametrize("kind", READERS)
def test_a_valid_file_is_read(kind, valid, tmp_path):
    if kind not in valid:
        pytest.skip("needs the extra io")
    assert outcome(kind, valid[kind], tmp_path) is not None


@pytest.mark.parametrize("kind", ["npz", "checkpoint", "netcdf"])
@QUICK
@given(seed=st.integers(0, 2**32))
def test_one_change_of_an_archive_is_harmless_or_refused(kind, valid, tmp_path, seed):
    if kind not in valid:
        pytest.skip("needs the extra io")
    found = outcome(kind, mutate(valid[kind], generator(seed)), tmp_path)
    assert found in (None, outcome(kind, valid[kind], tmp_path))


@pytest.mark.parametrize("kind", READERS)
@QUICK
@given(seed=st.integers(0, 2**32), times=st.integers(1, 8))
def test_any_changes_are_read_or_refused(kind, valid, tmp_path, seed, times):
    if kind not in valid:
        pytest.skip("needs the extra io")
    outcome(kind, mutate(valid[kind], generator(seed), times), tmp_path)


@pytest.mark.parametrize("kind", ["npz", "checkpoint"])
@QUICK
@given(seed=st.integers(0, 2**32), times=st.integers(1, 4))
def test_changes_inside_an_archive_whose_checksums_are_right(kind, valid, tmp_path, seed, times):
    outcome(kind, inside(valid[kind], generator(seed), times), tmp_path)


def test_a_library_that_quotes_half_a_file_is_cut_short():
    assert len(str(Unreadable(Path("run.npz"), "differ: " + 30_000 * "x"))) < 400


@pytest.mark.parametrize("kind", ["npz", "checkpoint"])
def test_archives_made_on_purpose_are_refused_and_nothing_in_them_runs(kind, valid, tmp_path):
    canary = tmp_path / "canary"
    for what, data in crafted(valid[kind], canary).items():
        found = outcome(kind, data, tmp_path)
        assert found is None or what in ("a name outside", "encrypted"), what
        assert not canary.exists(), what
    assert not (tmp_path.parent.parent / "outside.npy").exists()


def test_the_canary_would_sing(tmp_path):
    import pickle

    from tests.robust.mutations import Canary

    pickle.loads(pickle.dumps(Canary(tmp_path / "canary"))).close()
    assert (tmp_path / "canary").exists()


@pytest.mark.parametrize(("kind", "what"), [(kind, what) for kind in ("scene", "sweep", "csv") for what in texts(kind)])
def test_texts_made_on_purpose_are_refused(kind, what, tmp_path):
    assert outcome(kind, texts(kind)[what], tmp_path) is None


@pytest.mark.parametrize("kind", ["npz", "checkpoint", "scene", "csv"])
def test_a_refused_file_costs_little_memory(kind, valid, tmp_path):
    data = valid[kind]
    tracemalloc.start()
    for seed in range(20):
        outcome(kind, mutate(data, generator(seed)), tmp_path)
    peak = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    assert peak < 50_000_000


def test_a_checkpoint_with_a_backend_that_is_none_is_named(valid, tmp_path):
    path = tmp_path / "named.npz"
    path.write_bytes(valid["checkpoint"])
    with np.load(path) as data:
        arrays = {name: data[name] for name in data.files}
    for wrong in ('"gpu"', "null"):
        changed = arrays | {"configuration": np.array(str(arrays["configuration"]).replace('"backend": "numpy"', f'"backend": {wrong}'))}
        assert str(changed["configuration"]) != str(arrays["configuration"])
        np.savez(path, **changed)
        with pytest.raises(ValueError, match=r"named\.npz cannot be read: .*`backend` must be one of"):
            fv.resume(path)


def test_an_unknown_key_of_a_scene_is_told_on_one_line(tmp_path):
    path = tmp_path / "s.toml"
    path.write_text('"na\\nme\\u001b" = 1\n')
    with pytest.raises(ValueError, match="unknown key `na me `") as caught:
        gr.load_scene(path)
    assert "\n" not in str(caught.value)
